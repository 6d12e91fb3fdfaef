#!/usr/bin/env -S python3 -B
import sys

sys.exit("no licence file")
