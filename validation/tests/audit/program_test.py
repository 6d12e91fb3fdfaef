"""Printed programs stand alone: they compile as their first comment says, run, and come to the verdict that the study comes to."""
import json
import os
import shlex
import subprocess
import sys
import tempfile

ATWOOD, ROOT = sys.argv[1:3]
os.environ["ATWOOD_ROOT"] = ROOT
CASES = [("arkode/erkstep/VERNER_8_5_6", "kepler-e0.6", "lower"), ("arkode/arkstep-imex/ARK436L2SA_6_3_4", "oscillator", "as claimed"),
         ("arkode/arkstep-implicit/KVAERNO_4_2_3", "charge-in-e-cross-b", "as claimed"),
         ("odeint/adams_bashforth4@long-double{in_place=true}", "oscillator-driven", "lower"),
         ("odeint/adams_bashforth4@long-double", "oscillator-driven", "as claimed"), ("odeint/rosenbrock4@long-double", "oscillator-driven", "lower"),
         ("odeint/velocity_verlet@long-double", "oscillator", "higher"), ("odeint/symplectic_euler@long-double", "kepler-e0.6", "as claimed"),
         ("arkode/arkstep-imex/ARK437L2SA_7_3_4:tol", "oscillator", "lower"), ("arkode/erkstep/DORMAND_PRINCE_7_4_5:tol", "oscillator", "as claimed")]
TOLERANCES = ("1e-4", "1e-6", "1e-8")
faults = []


def call(*words, **more):
    return subprocess.run(words, capture_output=True, text=True, timeout=280, **more)


def verdict_of_program(folder, method, scenario):
    made = call(ATWOOD, "describe", method.replace(":tol", ":1e-8"), "--program", "--scenario", scenario)
    if made.returncode != 0:
        return f"describe: {made.stderr}"
    if "atwood" in made.stdout.lower():
        return "the program speaks of Atwood"
    with open(os.path.join(folder, "program.cpp"), "w", encoding="utf-8") as file:
        file.write(made.stdout)
    command = made.stdout.split("\n")[2].removeprefix("// ")
    ran = call("bash", "-c", command, cwd=folder)
    return ran.stdout.strip().split("\n")[-1].split(": ")[-1] if ran.returncode == 0 else f"{command}: {ran.stderr}"


def verdicts_of_study(folder):
    words = [ATWOOD, "run", "audit", "--out", os.path.join(folder, "out"), "-o", "json:" + os.path.join(folder, "report.json")]
    for method in dict.fromkeys(case[0] for case in CASES):
        for one in [method.replace("tol", each) for each in TOLERANCES] if ":tol" in method else [method]:
            words += ["--method", one]
    for scenario in dict.fromkeys(case[1] for case in CASES):
        words += ["--scenario", scenario]
    ran = call(*words)
    if ran.returncode != 0:
        faults.append(f"{shlex.join(words)}: exit {ran.returncode}: {ran.stderr[-2000:]}{ran.stdout[-2000:]}")
        return {}
    with open(os.path.join(folder, "report.json"), encoding="utf-8") as file:
        report = json.load(file)
    return {(f["method"], p["scenario"]): p["verdict"] for f in report["audit"] for p in f["problems"]}


def refusals():
    for words, expected in [(("describe", "kepler-e0.6", "--program"), "library's method"),
                            (("describe", "atwood/rk4", "--program"), "is not a method of ARKODE or odeint"),
                            (("describe", "odeint/controlled/runge_kutta_dopri5", "--program"), "chooses its steps"),
                            (("describe", "odeint/runge_kutta4", "--program", "--scenario", "pleiades"), "one moving point mass"),
                            (("describe", "odeint/runge_kutta5"), "nearest")]:
        said = call(ATWOOD, *words)
        if said.returncode != 2 or expected not in said.stderr:
            faults.append(f"{shlex.join(words)}: exit {said.returncode}, {said.stderr!r}; expected 2 and `{expected}`")
    said = call(ATWOOD, "describe", "arkode/erkstep/VERNER_8_5_6")
    for expected in ("ERKStep", "point-mass 6", "table_stages = 8", "ARKODE"):
        if expected not in said.stdout:
            faults.append(f"describe of a method: no `{expected}` in {said.stdout!r}")


with tempfile.TemporaryDirectory() as scratch:
    offered = call(ATWOOD, "list", "methods").stdout
    if "arkode/erkstep" not in offered or "odeint/runge_kutta4" not in offered:
        print("ARKODE or odeint is not built")
        sys.exit(77)
    study = verdicts_of_study(scratch)
    for method, scenario, expected in CASES:
        printed = verdict_of_program(scratch, method, scenario)
        if printed != expected or study.get((method, scenario)) != expected:
            faults.append(f"{method} on {scenario}: expected {expected}; the program says {printed}, the study {study.get((method, scenario))}")
    refusals()

print("\n".join(faults) if faults else f"{len(CASES)} programs come to the study's verdicts")
sys.exit(1 if faults else 0)
