"""What the faulty workers share: a worker that speaks the protocol well, moving every body uniformly, until its fault.

`fault(request, k, line)` is asked before sample k goes out and may do anything; what it returns is sent instead of
`line` (None: nothing). k = samples + 1 asks about the closing line.
"""
import json
import sys


def say(text):
    sys.stdout.write(text)
    sys.stdout.flush()


def hello(name):
    doc = "moves every body uniformly, and then " + name
    method = {"id": "faulty/" + name, "doc": doc, "settings": {}}
    say(json.dumps({"engine": "faulty", "version": "1", "scalar": "double", "methods": [method]}) + "\n")


def rows(request, t_s):
    for body in request["scene"].get("bodies", request["scene"].get("body", [])):
        p, v = body.get("position_m", [0, 0, 0]), body.get("velocity_m_per_s", [0, 0, 0])
        yield [x + t_s * u for x, u in zip(p, v)] + [1, 0, 0, 0] + list(v) + [0, 0, 0]


def serve(name, fault):
    for text in sys.stdin:
        request = json.loads(text)
        if request["request"] == "hello":
            hello(name)
            continue
        cell, samples = request["cell"], request["samples"]
        timing = request["pass"] == "timing"
        for k in range(0 if timing else samples + 1):
            t_s = request["t_end_s"] * k / samples
            line = json.dumps({"cell": cell, "t_s": t_s, "bodies": list(rows(request, t_s)), "events": []}) + "\n"
            line = fault(request, k, line)
            if line is not None:
                say(line)
        done = {"status": "ok", "reason": "", "steps_taken": request["steps"], "rate_evaluations": 0}
        done["busy_ns"] = [1000] * request.get("repeats", 0) if timing else []
        line = fault(request, samples + 1, json.dumps({"cell": cell, "done": done}) + "\n")
        if line is not None:
            say(line)
