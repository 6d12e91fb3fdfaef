#!/usr/bin/env python3
"""Never answers hello."""
import time

while True:
    time.sleep(3600)
