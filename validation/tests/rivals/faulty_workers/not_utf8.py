#!/usr/bin/env python3
"""Prints bytes that are no UTF-8."""
import sys

from talk import serve


def fault(request, k, line):
    if k == request["samples"] // 2:
        sys.stdout.buffer.write(b'{"cell":\xff\xfe\x80}\n')
        sys.stdout.buffer.flush()
        return None
    return line


serve("not-utf8", fault)
