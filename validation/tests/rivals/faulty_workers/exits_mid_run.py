#!/usr/bin/env python3
"""Leaves with exit code 7 halfway through a run."""
import sys

from talk import serve


def fault(request, k, line):
    if k == request["samples"] // 2:
        print("faulty worker: licence expired", file=sys.stderr, flush=True)
        sys.exit(7)
    return line


serve("exits-mid-run", fault)
