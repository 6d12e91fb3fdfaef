#!/usr/bin/env python3
"""Runs each worker of this project under valgrind's memcheck: its hello and short runs of a smooth scene, one with impacts
and one with a joint, or their truths. Every answer must come, and no error of memory be found: no invalid or uninitialised
access, no block that is lost.

    python3 validation/tests/campaigns/memcheck.py build/release [WORKER ...]

Without names: the workers that link no engine of others.
"""
import json
import os
import shutil
import subprocess
import sys

WORKERS = ("atwood-engine", "atwood-truth", "atwood-cvode", "atwood-arkode", "atwood-ida", "atwood-odeint")
SCENES = ("ballistic", "bounce-e0.5", "pendulum-1")
METHODS = {"atwood-engine": ("atwood/rk4", "atwood/symplectic-euler", "atwood/gbs:1e-10")}
VALGRIND = ["valgrind", "--quiet", "--error-exitcode=99", "--leak-check=full", "--show-leak-kinds=definite",
            "--errors-for-leak-kinds=definite"]
ENDED_BY_VALGRIND = 99


def scenario(build, name):
    told = subprocess.run([os.path.join(build, "bin/atwood"), "describe", name, "--json"], capture_output=True, text=True, check=True)
    return json.loads(told.stdout)


def answers(command, requests):
    text = "".join(json.dumps(request) + "\n" for request in requests)
    ended = subprocess.run(command, input=text, capture_output=True, text=True, timeout=3600)
    return ended, [json.loads(line) for line in ended.stdout.splitlines()]


def requests_for(worker, methods, scenarios):
    for cell, (method, one) in enumerate(((method, one) for method in methods for one in scenarios), 1):
        if worker == "atwood-truth":
            yield {"request": "truth", "cell": cell, "samples": one["run"]["samples"], "scenario": one}
        else:
            yield {"request": "run", "cell": cell, "method": method, "pass": "accuracy", "t_end_s": one["run"]["t_end_s"],
                   "steps": one["run"]["steps"][0], "samples": one["run"]["samples"], "repeats": 0, "scene": one["scene"]}


def check(build, worker, scenarios):
    """What is wrong, or nothing; and how many runs ended ok."""
    program = os.path.join(build, "bin", worker)
    hello = {"protocol": 1, "request": "hello"}
    _, told = answers([program], [hello])
    methods = METHODS.get(worker, [method["id"] for method in told[0]["methods"]][:1])
    requests = list(requests_for(worker, methods, scenarios))
    ended, told = answers([*VALGRIND, program], [hello, *requests])
    done = {answer["cell"]: answer["done"]["status"] for answer in told if "done" in answer}
    if ended.returncode == ENDED_BY_VALGRIND:
        return "errors of memory:\n" + ended.stderr[-6000:], 0
    if ended.returncode != 0:
        return f"exit code {ended.returncode}: {ended.stderr[-2000:]}", 0
    wrong = [request["cell"] for request in requests if done.get(request["cell"]) not in ("ok", "unsupported")]
    ok = sum(status == "ok" for status in done.values())
    return (f"no answer to the requests {wrong}" if wrong else "" if ok else "no run ended ok"), ok


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    if not shutil.which("valgrind"):
        sys.exit("memcheck: valgrind is missing")
    build = sys.argv[1]
    scenarios = [scenario(build, name) for name in SCENES]
    bad = 0
    for worker in sys.argv[2:] or WORKERS:
        wrong, ok = check(build, worker, scenarios)
        bad += bool(wrong)
        print(f"{worker}: {wrong or f'{ok} runs, no error'}", flush=True)
    sys.exit(bad > 0)


if __name__ == "__main__":
    main()
