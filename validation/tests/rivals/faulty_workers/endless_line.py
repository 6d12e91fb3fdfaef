#!/usr/bin/env python3
"""Begins a line and never ends it: more than the protocol's 64 MiB."""
from talk import say, serve


def fault(request, k, line):
    if k == request["samples"] // 2:
        while True:
            say("9" * (1 << 20))
    return line


serve("endless-line", fault)
