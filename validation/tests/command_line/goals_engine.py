#!/usr/bin/env -S python3 -B
"""An engine for goals: bodies fly straight on, with the error `off` [m] after the start. `nan_at` and `inf_at`: the sample
whose position is no number. A timed run takes `work` [ms] of its processor; while less than `crowd` of them were asked, a
second process takes half of that processor. `known/steep` takes a tolerance: its error is five times that, and its number of
evaluations a power of it, `order`. Each timed run leaves a line in the file that GOALS_LOG names."""
import json
import os
import signal
import sys
import time

METHOD = {"id": "known/straight", "doc": "Known errors.",
          "settings": {"off": 0.0, "nan_at": -1, "inf_at": -1, "work": 0.0, "crowd": 0}}
STEEP = {**METHOD, "id": "known/steep", "adaptive": True, "settings": {**METHOD["settings"], "order": 2.0}}
timed = {}


def put(line):
    print(json.dumps(line), flush=True)


def settings_of(method):
    settings = dict(STEEP["settings"])
    if "{" in method:
        for pair in method.split("{")[1].rstrip("}").split(","):
            name, value = pair.split("=")
            settings[name] = float(value)
    return settings


def busy_for(ms):
    used = time.process_time()
    while time.process_time() - used < 1e-3 * ms:
        pass
    return round(1e6 * ms)


def time_passes(request, settings):
    count = timed[request["method"]] = timed.get(request["method"], 0) + 1
    if os.environ.get("GOALS_LOG"):
        with open(os.environ["GOALS_LOG"], "a") as log:
            log.write(request["method"] + "\n")
    if count > settings["crowd"]:
        return [max(1000 * request["steps"], busy_for(settings["work"]))] * request["repeats"]
    other = os.fork()  # on the same processor, to which a timed engine is bound
    if other == 0:
        while True:
            pass
    try:
        return [busy_for(settings["work"])] * request["repeats"]
    finally:
        os.kill(other, signal.SIGKILL)
        os.waitpid(other, 0)


def run(request):
    settings, cell = settings_of(request["method"]), request["cell"]
    busy, evaluations = [], request["steps"]
    if ":" in request["method"]:
        rtol = float(request["method"].split(":")[1].split("{")[0])
        settings["off"], evaluations = 5 * rtol, round(100 * (1e-3 / rtol) ** (1 / settings["order"]))
    if request["pass"] == "timing":
        busy = time_passes(request, settings)
    else:
        for k in range(request["samples"] + 1):
            t = request["t_end_s"] * k / request["samples"]
            rows = []
            for body in request["scene"]["bodies"]:
                p, v = body["position_m"], body["velocity_m_per_s"]
                x = [p[i] + v[i] * t + (settings["off"] if k > 0 and i == 0 else 0) for i in range(3)]
                for word in ("nan", "inf"):
                    if settings[word + "_at"] == k:
                        x[0] = word
                rows.append(x + body["orientation_wxyz"] + v + [0, 0, 0])
            put({"cell": cell, "t_s": t, "bodies": rows})
    put({"cell": cell, "done": {"status": "ok", "reason": "", "steps_taken": request["steps"],
                                "rate_evaluations": evaluations, "busy_ns": busy}})


for line in sys.stdin:
    request = json.loads(line)
    if request["request"] == "hello":
        put({"protocol": 1, "engine": "known", "version": "1", "scalar": "double", "fingerprint": "1", "methods": [METHOD, STEEP]})
    elif request["request"] == "run":
        run(request)
    else:
        put({"cell": request["cell"], "done": {"status": "unsupported", "reason": "runs alone"}})
