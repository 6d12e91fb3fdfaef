#!/usr/bin/env python3
"""Falls silent halfway through a run and never ends, not even when asked politely (SIGTERM)."""
import signal
import time

from talk import serve


def fault(request, k, line):
    if k == request["samples"] // 2:
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
        while True:
            time.sleep(3600)
    return line


serve("hangs", fault)
