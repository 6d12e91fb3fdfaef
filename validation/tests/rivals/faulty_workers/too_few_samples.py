#!/usr/bin/env python3
"""Leaves one sample out and says that all went well."""
from talk import serve

serve("too-few-samples", lambda request, k, line: None if k == request["samples"] // 2 else line)
