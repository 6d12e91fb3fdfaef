#!/usr/bin/env python3
"""An engine of fluids whose errors are known: particles stay where they start, their velocity is the exact decay of Taylor
and Green's vortices times 1 + a spacing^2 (1 + spacing) + b h, with a and b settings of the method."""
import json
import math
import sys

METHOD = {"id": "known/vortices", "doc": "Known errors.", "settings": {"space": 1.0, "time": 0.0, "nan_at": -1}}


def put(line):
    print(json.dumps(line), flush=True)


def run(request):
    scene, cell = request["scene"], request["cell"]
    settings = dict(METHOD["settings"])
    if "{" in request["method"]:
        for pair in request["method"].split("{")[1].rstrip("}").split(","):
            name, value = pair.split("=")
            settings[name] = float(value)
    fluid = scene["fluids"][0]
    k, nu, h = 2 * math.pi, fluid.get("viscosity_m2_per_s", 0), request["t_end_s"] / request["steps"]
    factor = 1 + settings["space"] * fluid["spacing_m"] ** 2 * (1 + fluid["spacing_m"]) + settings["time"] * h
    start = fluid["particles"]["position_m"]
    timed = request["pass"] == "timing"
    for sample in range(0 if timed else request["samples"] + 1):
        t = request["t_end_s"] * sample / request["samples"]
        decay = math.exp(-2 * nu * k * k * t)
        rows = []
        for x, y in start:
            grow = decay * (factor if sample else 1)
            p = -0.25 * fluid["density_kg_per_m3"] * decay**2 * (math.cos(2 * k * x) + math.cos(2 * k * y))
            rows.append([x, y, 0, -grow * math.cos(k * x) * math.sin(k * y), grow * math.sin(k * x) * math.cos(k * y), 0,
                         fluid["density_kg_per_m3"], p, 0])
        if settings["nan_at"] == sample:
            rows[3][0] = "nan"
        half = len(rows) // 2  # in two parts, as a long line is
        put({"cell": cell, "t_s": t, "bodies": [], "particles": rows[:half], "more": True})
        put({"cell": cell, "t_s": t, "from_particle": half, "bodies": [], "particles": rows[half:]})
    busy = [round(0.2 * request["steps"] * len(start))] * request["repeats"] if timed else []
    put({"cell": cell, "done": {"status": "ok", "reason": "", "steps_taken": request["steps"],
                                "rate_evaluations": request["steps"], "busy_ns": busy}})


for line in sys.stdin:
    request = json.loads(line)
    if request["request"] == "hello":
        put({"protocol": 1, "engine": "known", "version": "1", "scalar": "double", "fluids": True, "fingerprint": "1",
             "methods": [METHOD]})
    elif request["request"] == "run":
        run(request)
    else:
        put({"cell": request["cell"], "done": {"status": "unsupported", "reason": "runs alone"}})
