"""What a report takes from a scene besides rows: the methods drawn beside the truth, whose poses are as far from it as the
rows say, and the metric that the scene's file names."""
import base64
import glob
import json
import os
import re
import sys
import unittest
import zlib

from case import ROOT, Case

METHODS = ("atwood/explicit-euler", "atwood/rk4", "atwood/midpoint", "bullet32/default", "atwood/rk4@float", "bullet64/default", "bullet64/tuned", "ode/default", "mujoco/default")


BALL = """id = "ball"
metric = %s
[run]
t_end_s = 1.0
steps = [64]
samples = 8
[[body]]
name = "metric"
mass_kg = 1
velocity_m_per_s = [1, 0, 0]
[truth]
kind = "extended"
"""


class Motion(Case):
    def embedded(self):
        with open(self.path("atwood-out/report.html")) as file:
            coded = re.search('<script type="text/plain" id="data">([^<]*)<', file.read())[1]
        return json.loads(zlib.decompress(base64.b64decode(coded), -15))

    def test_beside_the_truth(self):
        words = [word for method in METHODS for word in ("--method", method)]
        self.ask("run", "--scenario", "free-box-complex", *words, "-o", "json:rows.json", code=(0, 1))
        scene, = self.embedded()["scenes"]
        with open(self.path("rows.json")) as file:
            report = json.load(file)
        scenario, = report["scenarios"]
        chosen = [method["id"] for method in scene["methods"]]
        self.assertEqual(chosen[:2], ["atwood/rk4", "bullet64/default"])
        self.assertIn(chosen[2], ("ode/default", "mujoco/default"))
        self.assertEqual(len(chosen), 3)
        nearest = min(scenario["steps"], key=lambda steps: abs(steps / (240 * scenario["t_end_s"]) - 1))
        figures = {(row["method"], row["steps"], row["metric"]): row["value"] for row in report["rows"] if row["body"] == "" and row.get("t_s") is None}
        for method in scene["methods"]:
            self.assertEqual(method["steps"], nearest, method["id"])
            body, = method["bodies"]
            for part, metric in (("p", "error-position-max"), ("r", "error-attitude-max")):
                self.assertEqual(len(body[part]), 3 * len(scene["times"]))
                sizes = [sum(x * x for x in body[part][i:i + 3]) ** 0.5 for i in range(0, len(body[part]), 3)]
                exact = figures[method["id"], nearest, metric]
                self.assertAlmostEqual(max(sizes) / exact if exact else max(sizes), 1 if exact else 0, delta=0.01, msg=f"{method['id']} {metric}: {max(sizes)}, not {exact}")
                self.assertEqual(sizes[0], 0)

    def test_named_metric(self):
        self.path("ball.toml", BALL % '"error-velocity-max"')
        self.ask("run", "--scenario", "ball.toml", "--method", "atwood/rk4", code=(0, 1))
        scenario, = self.embedded()["scenarios"]
        self.assertEqual(scenario["metric"], "error-velocity-max")
        self.path("ball.toml", (BALL % '""').replace('metric = ""\n', ""))
        self.ask("report", "--scenario", "ball.toml", "--method", "atwood/rk4", code=(0, 1))
        scenario, = self.embedded()["scenarios"]
        self.assertNotIn("metric", scenario)
        for wrong in ('"Two words"', "7", '["error-velocity-max"]', '""'):
            self.path("ball.toml", BALL % wrong)
            self.ask("run", "--scenario", "ball.toml", code=2, told=["ball.toml:2:10", "metric"])

    def test_catalogue(self):
        """Each metric that a scene of the catalogue names is one that is defined."""
        named = {}
        for path in glob.glob(os.path.join(ROOT, "validation", "scenarios", "**", "*.toml"), recursive=True):
            with open(path) as file:
                found = re.search(r'^metric += "([^"]*)"$', file.read(), re.MULTILINE)
            if found:
                named.setdefault(found[1], []).append(os.path.basename(path))
        self.assertGreater(len(named), 3)
        for metric, scenes in named.items():
            self.ask("describe", metric, told=[metric])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
