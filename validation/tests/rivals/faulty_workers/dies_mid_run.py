#!/usr/bin/env python3
"""Dies by a signal halfway through a run, with words on standard error."""
import os
import signal
import sys

from talk import serve


def fault(request, k, line):
    if k == request["samples"] // 2:
        print("faulty worker: about to die", file=sys.stderr, flush=True)
        os.kill(os.getpid(), signal.SIGSEGV)
    return line


serve("dies-mid-run", fault)
