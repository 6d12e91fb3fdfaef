#!/usr/bin/env python3
"""Runs each worker of this project under valgrind's memcheck: its hello and short runs of a smooth scene, one with impacts
and one with a joint, or their truths. Every answer must come, and no error of memory be found: no invalid or uninitialised
access, no block that is lost.

    python3 validation/tests/campaigns/memcheck.py build/release [WORKER ...]
    python3 validation/tests/campaigns/memcheck.py build/release --programs REGEX [--seconds S]

Without names: the workers that link no engine of others. --programs: the test programs whose name matches, as they were
built, each for at most S seconds (600); one that takes longer is named and is no error. Whether their assertions hold is not
judged, for valgrind calculates long double with the 53 binary digits of a double instead of 64. Assertions on the digits of
a long double fail there (protocol_test: the hash of the protocol's lines, 0.1 written in 21 digits). memcheck.supp beside
this file names what is known of libraries, with its reason.
"""
import argparse
import json
import os
import shutil
import signal
import subprocess
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
WORKERS = ("atwood-engine", "atwood-truth", "atwood-cvode", "atwood-arkode", "atwood-ida", "atwood-odeint")
SCENES = ("ballistic", "bounce-e0.5", "pendulum-1")
METHODS = {"atwood-engine": ("atwood/rk4", "atwood/symplectic-euler", "atwood/gbs:1e-10")}
VALGRIND = ["valgrind", "--quiet", "--error-exitcode=99", "--leak-check=full", "--show-leak-kinds=definite",
            "--errors-for-leak-kinds=definite", "--suppressions=" + os.path.join(HERE, "memcheck.supp")]
ENDED_BY_VALGRIND = 99
LEFT_OUT = {"so3_test": "Boost's Jacobi functions in long double recurse until its last digits, which valgrind has not"}


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


def programs_of(build, regex):
    """By name: the command and folder of each test program, as ctest knows them."""
    told = subprocess.run(["ctest", "--test-dir", build, "--show-only=json-v1", "-L", "^program$", "-R", regex],
                          capture_output=True, text=True, check=True)
    for test in json.loads(told.stdout)["tests"]:
        if test["name"] in LEFT_OUT:
            print(f"{test['name']}: left out: {LEFT_OUT[test['name']]}")
            continue
        folder = next(one["value"] for one in test["properties"] if one["name"] == "WORKING_DIRECTORY")
        yield test["name"], test["command"], folder


def check_program(command, folder, seconds):
    """What is wrong, or nothing; and how it ended."""
    process = subprocess.Popen([*VALGRIND, *command], cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
                               env={**os.environ, "RC_PARAMS": "seed=1784"}, start_new_session=True)
    try:
        _, told = process.communicate(timeout=seconds)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)  # with the workers that it started
        _, told = process.communicate()
        return ("errors of memory:\n" + told[-6000:] if "==" in told else ""), f"no error in {seconds} s, not ended"
    if process.returncode == ENDED_BY_VALGRIND:
        return "errors of memory:\n" + told[-6000:], ""
    return (f"signal {-process.returncode}" if process.returncode < 0 else ""), f"no error, exit code {process.returncode}"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("build")
    parser.add_argument("workers", nargs="*", default=WORKERS)
    parser.add_argument("--programs", metavar="REGEX")
    parser.add_argument("--seconds", type=float, default=600)
    asked = parser.parse_args()
    if not shutil.which("valgrind"):
        sys.exit("memcheck: valgrind is missing")
    if asked.programs is not None:
        checks = ((name, *check_program(command, folder, asked.seconds))
                  for name, command, folder in programs_of(asked.build, asked.programs))
    else:
        scenarios = [scenario(asked.build, name) for name in SCENES]
        results = ((worker, *check(asked.build, worker, scenarios)) for worker in asked.workers)
        checks = ((worker, wrong, f"{ok} runs, no error") for worker, wrong, ok in results)
    bad = done = 0
    for name, wrong, ended in checks:
        bad, done = bad + bool(wrong), done + 1
        print(f"{name}: {wrong or ended}", flush=True)
    print(f"{done} programs, {bad} of them with errors")
    sys.exit(bad > 0 or done == 0)


if __name__ == "__main__":
    main()
