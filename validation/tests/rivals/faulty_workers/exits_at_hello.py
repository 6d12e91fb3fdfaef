#!/usr/bin/env python3
"""Leaves before it says hello."""
import sys

print("faulty worker: shared library not found", file=sys.stderr)
sys.exit(127)
