# The worker protocol for the scripts beside this file: every body flies straight on.
import json
import sys


def say(answer):
    sys.stdout.write(json.dumps(answer) + "\n")
    sys.stdout.flush()


def sample(request, bodies, k):
    t = request["t_end_s"] * k / request["samples"]
    rows = []
    for body in bodies:
        position, velocity = body["position_m"], body["velocity_m_per_s"]
        rows.append([p + v * t for p, v in zip(position, velocity)] + body["orientation_wxyz"] + velocity + [0, 0, 0])
    return {"cell": request["cell"], "t_s": t, "bodies": rows}


def done(request, status="ok", reason="", **more):
    body = {"status": status, "reason": reason, "steps_taken": request.get("steps", 0), "rate_evaluations": 0}
    return {"cell": request["cell"], "done": {**body, **more}}


def well(request):
    """An answer without a fault."""
    if request["pass"] == "timing":
        return say(done(request, busy_ns=[1000 * request["steps"]] * request["repeats"]))
    for k in range(request["samples"] + 1):
        say(sample(request, request["scene"]["bodies"], k))
    say(done(request))


def serve(engine, methods, answer):
    for line in sys.stdin:
        request = json.loads(line)
        if request["request"] == "hello":
            listed = [{"id": engine + "/" + name, "doc": name, "settings": {"gain": 1.0}} for name in methods]
            say({"engine": engine, "version": "1", "scalar": "double", "methods": listed})
        else:
            answer(request)
