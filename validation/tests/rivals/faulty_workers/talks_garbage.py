#!/usr/bin/env python3
"""Prints what is no JSON in the middle of a run."""
from talk import serve


def fault(request, k, line):
    return "Segmentation fau\x00lt (core dumped) }{][\n" if k == request["samples"] // 2 else line


serve("talks-garbage", fault)
