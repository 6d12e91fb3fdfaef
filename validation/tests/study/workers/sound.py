#!/usr/bin/env -S python3 -B
# Nothing wrong with it. Each run leaves a line in the file that SOUND_LOG names; `slow` takes its time.
import os
import time

from speak import serve, well


def answer(request):
    if os.environ.get("SOUND_LOG"):
        with open(os.environ["SOUND_LOG"], "a") as log:
            log.write("%s %d %s\n" % (request["method"], request["steps"], request["pass"]))
    if request["method"].startswith("sound/slow"):
        time.sleep(0.05)
    well(request)


serve("sound", ["straight", "slow"], answer)
