#!/usr/bin/env python3
"""Answers for a cell that was not requested."""
import json

from talk import serve


def fault(request, k, line):
    answer = json.loads(line)
    answer["cell"] = 4711
    return json.dumps(answer) + "\n"


serve("wrong-cell", fault)
