"""`gate` and `bless` judge the study that is planned, not the part of it that happens to be in the store."""
import os
import signal
import subprocess
import sys
import time
import unittest

from case import ATWOOD, Case, thrown_stone


# Flight under constant weight; the module beside it makes it wrong at 64 steps.
ENGINE = """#!/usr/bin/env -S python3 -B
import json, os, sys, time
from gain import GAIN
for line in sys.stdin:
    r = json.loads(line)
    if r["request"] == "hello":
        print(json.dumps({"engine": "mine", "version": "1", "scalar": "double",
                          "methods": [{"id": "mine/one", "doc": "one"}]}), flush=True)
        continue
    time.sleep(float(os.environ.get("ENGINE_SLEEP", "0")))
    with open(os.environ["ENGINE_LOG"], "a") as log:
        log.write(str(r["steps"]) + "\\n")
    gain = GAIN if r["steps"] == 64 else 1
    for k in range(r["samples"] + 1):
        t = r["t_end_s"] * k / r["samples"]
        rows = []
        for b in r["scene"]["bodies"]:
            g = [0, 0, -9.8]
            p = [x + gain * v * t + 0.5 * a * t * t for x, v, a in zip(b["position_m"], b["velocity_m_per_s"], g)]
            rows.append(p + [1, 0, 0, 0] + [v + a * t for v, a in zip(b["velocity_m_per_s"], g)] + [0, 0, 0])
        print(json.dumps({"cell": r["cell"], "t_s": t, "bodies": rows}))
    done = {"status": "ok", "reason": "", "steps_taken": r["steps"], "rate_evaluations": 0}
    print(json.dumps({"cell": r["cell"], "done": done}), flush=True)
"""

SCENE = thrown_stone("[64, 128, 256]")

GATES = """[[gate]]
scenario = "*"
method = "mine/one"
metric = "error-position-end"
max = 1e-9
reason = "It is exact."
"""


class Whole(Case):
    def setUp(self):
        super().setUp()
        self.environment = {**os.environ, "ATWOOD_CALLED_AS": "", "ENGINE_LOG": self.path("engine.log", "")}
        self.path("engine.py", ENGINE, 0o755)
        self.path("gain.py", "GAIN = 1.0\n")
        self.path("mine.toml", SCENE)
        self.path("gates.toml", GATES)
        # The whole: the ladder of one scene; narrowed by --steps.
        self.words = ["--engine", "./engine.py", "--no-sandbox", "--method", "mine/one", "--scenario", "mine.toml"]

    def atwood(self, *words, code=0, told=(), untold=()):
        result = self.ask(*words, code=code, told=told)
        for word in untold:
            self.assertNotIn(word, result.stdout + result.stderr)
        return result

    def steps_run(self):
        with open(self.path("engine.log")) as file:
            return sorted(int(line) for line in file)

    def test_a_gate_over_an_interrupted_run_is_not_run(self):
        with subprocess.Popen([ATWOOD, "run", *self.words, "--no-timing", "--tolerances", "gates.toml"], cwd=self.here,
                              stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                              env={**self.environment, "ENGINE_SLEEP": "0.5"}) as run:
            while not self.steps_run():
                time.sleep(0.02)
            time.sleep(0.2)
            run.send_signal(signal.SIGINT)
            self.assertEqual(run.wait(30), 130)
        missing = 3 - len(self.steps_run())
        self.assertGreater(missing, 0)
        of_three = f"{missing} of its 3 cells"
        command = (f"{ATWOOD} run --scenario {self.here}/mine.toml --method mine/one --engine {self.here}/engine.py --no-sandbox "
                   f"--tolerances {self.here}/gates.toml --out {self.here}/atwood-out")
        self.atwood("gate", *self.words, "--tolerances", "gates.toml", code=1, told=[of_three, "not run", command])
        self.atwood("gate", *self.words, "--tolerances", "gates.toml", "--quiet", code=1, told=[of_three])
        junit = self.path("junit.xml")
        self.atwood("gate", *self.words, "--tolerances", "gates.toml", "--junit", junit, code=1)
        with open(junit) as file:
            self.assertIn(of_three, file.read())
        self.atwood("bless", *self.words, "--reason", "why", code=2, told=[f"{missing} of 3 planned cells", "atwood"])
        self.assertFalse(os.path.exists(self.path("atwood-baseline.tsv")))
        self.atwood("report", *self.words, told=[f"{missing} of 3 planned cells"])
        self.atwood("run", *self.words, "--no-timing", "--tolerances", "gates.toml", untold=["not in the store"])
        self.atwood("gate", *self.words, "--tolerances", "gates.toml", untold=["not in the store"])
        self.atwood("bless", *self.words, "--reason", "why")

    def test_a_narrowed_run_hides_nothing(self):
        run = ["run", *self.words, "--no-timing", "--tolerances", "gates.toml"]
        gate = ["gate", *self.words, "--tolerances", "gates.toml"]
        self.path("gain.py", "GAIN = 1.5\n")
        self.atwood(*run, code=1)
        self.atwood(*run, "--steps", "128", told=["measured anew in its last campaign"])
        self.assertEqual(self.steps_run(), [64, 128, 128, 256])
        self.atwood(*gate, code=1, told=["FAIL"], untold=["not in the store"])
        # The mended engine, and the command that the failing gate named.
        self.path("gain.py", "GAIN = 1.0\n")
        self.atwood(*run, "--steps", "64")
        self.assertEqual(self.steps_run(), [64, 64, 128, 128, 256])
        self.atwood(*gate)

    def test_a_study_without_gates_is_not_passed_by_a_part_of_it(self):
        self.path("only.toml", 'id = "only"\n[[cells]]\nscenarios = ["ballistic", "kepler-e0.6"]\n'
                               'methods = ["atwood/rk4"]\n')
        self.path("gates.toml", GATES.replace("mine/one", "atwood/rk4").replace("1e-9", "1e9"))
        self.path("none.toml", GATES.replace("mine/one", "atwood/rk4").replace("1e-9", "1e9").replace('"*"', '"ballistic"'))
        self.atwood("run", "only.toml", "--scenario", "ballistic", "--no-timing")
        self.atwood("gate", "only.toml", code=1, told=["planned cells are not in the store", "kepler-e0.6", f"atwood run {self.here}/only.toml"])
        self.atwood("gate", "only.toml", "--tolerances", "gates.toml", code=1, told=["not in the store"])
        self.atwood("gate", "only.toml", "--scenario", "ballistic", "--tolerances", "gates.toml")
        self.atwood("gate", "only.toml", "--tolerances", "none.toml", told=["planned cells are not in the store"])
        self.atwood("run", "only.toml", "--no-timing")
        self.atwood("gate", "only.toml", untold=["not in the store"])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])

from case import ATWOOD, Case
