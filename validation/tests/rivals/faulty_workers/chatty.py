#!/usr/bin/env python3
"""Floods standard error while it runs well: a full pipe would block it."""
import sys

from talk import serve


def fault(request, k, line):
    sys.stderr.write("debug: step\n" * 20000)
    sys.stderr.flush()
    return line


serve("chatty", fault)
