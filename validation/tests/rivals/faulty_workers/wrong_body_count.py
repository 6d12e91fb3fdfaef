#!/usr/bin/env python3
"""Sends one body more than the scene has."""
import json

from talk import serve


def fault(request, k, line):
    answer = json.loads(line)
    if "bodies" in answer:
        answer["bodies"].append(answer["bodies"][0])
    return json.dumps(answer) + "\n"


serve("wrong-body-count", fault)
