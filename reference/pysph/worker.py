"""PySPH 1.0 as a worker of Atwood's protocol (reference/your_engine/README.md).

Conventions
- One fluid, in two or three dimensions, in double, on one thread. Particles, masses, velocities and densities are the
  scene's; walls are particles at the scene's points, as deep as the kernel reaches. h = hdx spacing, constant.
- N equal steps: no adaptive step, no damped start, no output of PySPH's own. Nothing refuses a step beyond the scheme's
  stability; what it leads to is reported (`not finite`, `diverged`).
- The equation of state of tvf, gtvf and edac is linear: they refuse Tait's. wcsph and aha take both. tvf has no free
  surface. edac takes PySPH's formulation for internal flows where the fluid fills its space, else that for free surfaces.
- Positions and velocities are of the sample's instant. wcsph, aha: the density too, and the pressure is the equation of
  state's. tvf, gtvf: both, of the last sum. edac: the pressure, integrated; its density is the sum half a step before.
- Walls of wcsph begin with the density of the nearest particle and the weight between; no-slip is the wall's velocity at
  its particles. A free-slip wall is left out of the viscous sums; the artificial viscosity (alpha) acts there as everywhere.
- PySPH compiles the equations of a scheme when they are first used, which takes some 10 s. The build does it for the kinds
  of scenes in situations.py; the code is kept in the folder `cache`, not in the user's home. busy_ns is Solver.solve() with its initial evaluation, and nothing else.
"""
import hashlib
import importlib.metadata
import json
import os
import re
import sys
import traceback

import schemes
from outcome import Ended, Refusal

HERE = os.path.dirname(os.path.abspath(__file__))
ROWS_OF_LINE = 50000
PACKAGES = ("pysph", "compyle", "cyarray", "numpy", "Cython")


def version(package):
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return ""


def fingerprint():
    """Of Python, PySPH and what it compiles with, and of these sources."""
    text = sys.version + " ".join(package + version(package) for package in PACKAGES)
    text += "".join(os.path.realpath(path) for path in ("/usr/bin/gcc", "/usr/bin/g++"))
    for name in sorted(name for name in os.listdir(HERE) if name.endswith(".py")):
        with open(os.path.join(HERE, name), "rb") as file:
            text += name + hashlib.sha256(file.read()).hexdigest()
    return hashlib.sha256(text.encode()).hexdigest()


def hello():
    return {"protocol": 1, "engine": "pysph", "version": version("pysph"), "scalar": "double", "fluids": True,
            "fingerprint": fingerprint(), "methods": [schemes.describe(*preset) for preset in schemes.presets()]}


def number(x):
    return x if abs(x) < float("inf") else str(x).replace("-nan", "nan")


def body_row(body):
    return body["position_m"] + body["orientation_wxyz"] + body["velocity_m_per_s"] + body["angular_velocity_body_rad_per_s"]


def sample_lines(cell, t_s, bodies, rows):
    """A sample in lines of at most so many particles."""
    for first in range(0, len(rows), ROWS_OF_LINE):
        line = {"cell": cell, "t_s": t_s, "bodies": bodies if first == 0 else []}
        if first > 0:
            line.update({"from": len(bodies), "from_particle": first})
        line["particles"] = rows[first:first + ROWS_OF_LINE]
        if first + ROWS_OF_LINE < len(rows):
            line["more"] = True
        yield line


def run(request, put):
    """(outcome) of a run; samples go to put."""
    from run import Run
    from scene import Fluid
    kind, settings = schemes.parse(request["method"])
    fluid = Fluid(request["scene"])
    refusal = schemes.refusal(request["method"].partition("{")[0], kind, fluid)
    if refusal:
        raise Refusal(refusal)
    t_end_s, steps, samples = request["t_end_s"], request["steps"], request["samples"]
    one = Run(fluid, kind, settings, t_end_s, steps)
    outcome = {"status": "ok", "reason": "", "steps_taken": steps, "rate_evaluations": one.evaluations, "busy_ns": []}
    if request["pass"] == "timing":
        one.busy_ns()  # the first is not counted
        outcome["busy_ns"] = [Run(fluid, kind, settings, t_end_s, steps).busy_ns() for _ in range(request["repeats"])]
        return outcome
    bodies = [body_row(body) for body in request["scene"].get("bodies", [])]

    def observe(k, x, u, rho, p):
        rows = [[number(value) for value in row]
                for row in zip(*x.T.tolist(), *u.T.tolist(), rho.tolist(), p.tolist(), fluid.temperature.tolist())]
        for line in sample_lines(request["cell"], t_end_s * k / samples, bodies, rows):
            put(line)

    if request["pass"] == "profile":
        one.busy_ns()
    else:
        one.observe(samples, observe)
    return outcome


def answer(request, put):
    if request["request"] == "hello":
        return put(hello())
    cell = request.get("cell", -1)
    if request["request"] != "run":
        return put({"cell": cell, "done": {"status": "unsupported", "reason": "PySPH runs scenes alone"}})
    try:
        done = run(request, put)
    except Refusal as refusal:
        done = {"status": "unsupported", "reason": str(refusal)}
    except Ended as ended:
        done = {"status": ended.status, "reason": str(ended)}
    except (Exception, SystemExit) as error:  # PySPH leaves by SystemExit where its code does not compile
        traceback.print_exc()
        done = {"status": "crashed", "reason": re.sub(r"\s+", " ", f"{type(error).__name__}: {error}")}
    put({"cell": cell, "done": done})


def serve(cache):
    os.environ["HOME"] = cache  # PySPH and compyle keep code and read options in the user's home
    if "--compile" in sys.argv:
        from situations import compile_all
        return compile_all()
    out = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)  # what PySPH prints is no answer

    def put(line):
        print(json.dumps(line, allow_nan=False), file=out, flush=True)

    for line in sys.stdin:
        answer(json.loads(line), put)
