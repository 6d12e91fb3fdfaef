#!/usr/bin/env -S python3 -B
# The truth of free flight, which is straight: its bars are zero. A line in the file that TRUTH_LOG names for each.
import os
import time

from speak import done, sample, say, serve


def answer(request):
    if os.environ.get("TRUTH_LOG"):
        with open(os.environ["TRUTH_LOG"], "a") as log:
            log.write(request["scenario"]["id"] + "\n")
    if request["scenario"]["id"] == "no-truth":
        os._exit(9)
    if request["scenario"]["id"] == "slow-truth":
        time.sleep(60)
    request["t_end_s"] = request["scenario"]["run"]["t_end_s"]
    bodies = request["scenario"]["scene"]["bodies"]
    for k in range(request["samples"] + 1):
        line = sample(request, bodies, k)
        say({**line, "bars": [[0] * 13 for _ in line["bodies"]]})
    say(done(request, source="closed form: straight flight", condition=1, note=""))


serve("truth", [], answer)
