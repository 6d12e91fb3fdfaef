#!/usr/bin/env python3
"""No fault: the control that the others are measured against."""
from talk import serve

serve("well-behaved", lambda request, k, line: line)
