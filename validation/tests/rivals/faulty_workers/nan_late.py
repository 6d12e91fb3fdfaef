#!/usr/bin/env python3
"""Sends a position that is not a number in its last sample, and still says that all went well."""
import json

from talk import serve


def fault(request, k, line):
    if k != request["samples"]:
        return line
    sample = json.loads(line)
    sample["bodies"][0][0] = "nan"  # the protocol writes non-finite numbers as strings
    return json.dumps(sample) + "\n"


serve("nan-late", fault)
