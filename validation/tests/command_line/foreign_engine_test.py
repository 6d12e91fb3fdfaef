"""Foreign engines whose answers cannot be true: quaternions of any norm, absurd sizes, no answer at hello."""
import csv
import json
import os
import subprocess
import sys
import unittest

from case import ATWOOD, Case


SCENE = """id = "spinning-ball"
title = "A ball spins freely"
claim = "It turns at a constant rate."
tags = ["smooth"]
[run]
t_end_s = 1
steps = [16]
samples = 8
[world]
gravity_m_per_s2 = [0, 0, 0]
[[body]]
name = "ball"
mass_kg = 1
shape.sphere = { radius_m = 0.1 }
position_m = [0, 0, 0]
velocity_m_per_s = [1, 0, 0]
angular_velocity_body_rad_per_s = [0, 0, 2]
[truth]
kind = "extended"
"""

ENGINE = """#!/usr/bin/env python3
import json, math, sys
for line in sys.stdin:
    r = json.loads(line)
    if r["request"] == "hello":
        print(json.dumps({"engine": "mine", "version": "1", "scalar": "double", "fingerprint": "1",
                          "methods": [{"id": "mine/a", "doc": "exact", "settings": {}}]}), flush=True)
        continue
    norm, leap = NORM, LEAP
    for k in range(r["samples"] + 1):
        t = r["t_end_s"] * k / r["samples"]
        n = norm if k else 1
        print(json.dumps({"cell": r["cell"], "t_s": t, "bodies": [[t + (leap if k else 0), 0, 0, n * math.cos(t), 0, 0,
                          n * math.sin(t), 1, 0, 0, 0, 0, 2]]}))
    print(json.dumps({"cell": r["cell"], "done": {"status": "ok", "reason": "", "steps_taken": r["steps"],
                      "rate_evaluations": 0, "busy_ns": []}}), flush=True)
"""


class Foreign(Case):
    def setUp(self):
        super().setUp()
        self.scene = self.path("scene.toml", SCENE)

    def run_engine(self, path, code):
        rows = os.path.join(self.folder.name, "rows.csv")
        done = subprocess.run([ATWOOD, "run", "--engine", path, "--scenario", self.scene, "--no-timing", "--fresh", "--out",
                               os.path.join(self.folder.name, "out"), "-o", "csv:" + rows],
                              capture_output=True, text=True, stdin=subprocess.DEVNULL)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        if not os.path.exists(rows):
            return {}, done.stderr
        with open(rows) as file:
            return {row["metric"]: row for row in csv.DictReader(file) if row["method"] == "mine/a"}, done.stderr

    def engine_code(self, norm="1", leap="0"):
        return ENGINE.replace("NORM", norm).replace("LEAP", leap)

    def engine(self, **faults):
        return self.path("engine", self.engine_code(**faults), 0o755)

    def test_norms(self):
        rows, _ = self.run_engine(self.engine(), 0)
        self.assertLess(float(rows["error-attitude-max"]["value"]), 1e-12)
        self.assertNotIn("quaternion-norm-drift", rows)
        rows, _ = self.run_engine(self.engine(norm="1.01"), 0)
        self.assertAlmostEqual(float(rows["quaternion-norm-drift"]["value"]), 0.01, 12)
        for norm in ("2", "0.001"):
            rows, _ = self.run_engine(self.engine(norm=norm), 3)
            self.assertEqual(rows["status"]["status"], "crashed")
            self.assertIn("invalid answer: sample 1: the quaternion of body 0", rows["status"]["reason"])

    def test_a_ladder_without_truth_and_invariants_has_its_order_and_index(self):
        with open(self.scene, "w") as file:
            file.write(SCENE.replace("[16]", "[16, 32, 64, 128]").replace('"extended"', '"none"'))
        rows, _ = self.run_engine(self.engine(leap='r["steps"] ** -2'), 0)
        self.assertAlmostEqual(float(rows["richardson-order-position"]["value"]), 2, 9)
        self.assertIn("asymptotic: orders 2", rows["gci-position"]["reason"])
        self.assertEqual(rows["steps-taken"]["value"], "128")

    def test_absurd_sizes(self):
        rows, _ = self.run_engine(self.engine(leap="1e300"), 1)
        self.assertEqual(rows["status"]["status"], "diverged")
        self.assertIn("the host: body 0 moves 1e+300 m from sample 0 to 1", rows["status"]["reason"])

    def test_hello(self):
        for name, text in (("garbage", "#!/bin/sh\necho hello to you too\n"), ("dies", "#!/bin/sh\nexit 1\n")):
            _, words = self.run_engine(self.path(name, text, 0o755), 3)
            self.assertIn("answering `hello`: ", words)
        self.run_engine(self.path("plain", "#!/bin/sh\n", 0o644), 2)
        self.run_engine(os.path.join(self.folder.name, "missing"), 2)

    def test_a_rule_that_contradicts_itself_is_garbage(self):
        hello = {"engine": "mine", "methods": [{"id": "mine/a", "doc": "none", "settings": {"n": 1},
                                                "setting_rules": {"n": {"least": 5, "most": 2}}}]}
        text = f"#!/bin/sh\nread line\necho '{json.dumps(hello)}'\n"
        _, words = self.run_engine(self.path("contradicts", text, 0o755), 3)
        self.assertIn("mine/a", words)
        self.assertIn("the rule of the setting `n`: no number lies in it: \"least\" is 5, \"most\" 2", words)

    def test_a_refusal_is_told_with_its_reason(self):
        refuses = self.path("refuses.py", """#!/usr/bin/env python3
import json, sys
for line in sys.stdin:
    r = json.loads(line)
    if r["request"] == "hello":
        print(json.dumps({"engine": "mine", "methods": [{"id": "mine/a", "doc": "none", "settings": {}}]}), flush=True)
    else:
        print(json.dumps({"cell": r["cell"], "done": {"status": "unsupported", "reason": "mine has no balls"}}), flush=True)
""", 0o755)
        done = subprocess.run([ATWOOD, "run", "--engine", refuses, "--scenario", self.scene, "--no-timing", "--out",
                               os.path.join(self.folder.name, "out")], capture_output=True, text=True, stdin=subprocess.DEVNULL)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertIn("mine/a does not run spinning-ball: mine has no balls.", done.stdout)

    def under_wasm(self):
        """An exact engine that says, by `call_ns`, that it runs as WebAssembly."""
        code = self.engine_code().replace('"busy_ns": []', '"busy_ns": [1000] * r.get("repeats", 0), "call_ns": 70')
        return self.path("wasm", code, 0o755)

    def test_advise_says_that_times_under_webassembly_are_not_ranked(self):
        reason, engine = "timed only under WebAssembly: such times are not ranked", self.under_wasm()
        for asked in (("--error", "1e-3"), ("--budget", "1s")):
            told = json.loads(self.ask("advise", self.scene, *asked, "--engine", engine, "--method", "mine/a", "--method",
                                       "atwood/rk4", "--json").stdout)
            self.assertEqual(told["advice"]["method"], "atwood/rk4")
            self.assertEqual([one["methods"] for one in told["left_out"] if one["reason"].startswith(reason)], ["mine/a"])
        self.ask("advise", self.scene, "--error", "1e-3", "--engine", engine, "--method", "mine/a", code=1,
                 told=["nothing that was tried: no method with times that can be ranked", reason])

    def test_compare_says_that_times_under_webassembly_are_not_ranked(self):
        words = ("compare", "mine/a", "atwood/rk4", "--scenario", self.scene, "--engine", self.under_wasm())
        told = self.ask(*words, told=["mine/a: timed only under WebAssembly: such times are not ranked"]).stdout
        self.assertRegex(told, r"16 steps .* wasm +-")
        self.assertNotIn("WebAssembly", self.ask(*words, "--no-timing", "--out", "untimed").stdout)  # no store of times


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])

from case import ATWOOD, Case
