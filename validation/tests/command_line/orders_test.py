"""Errors and orders over a run through the built program: samples at whole periods hide nothing, baselines of other
definitions are no regressions, and a metric has one name in every command. Called with the program and the project's root."""
import csv
import json
import os
import random
import sys
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from case import ROOT, Case  # noqa: E402

# A mass on a spring of period 1 s, ten of them; 20 samples are at whole and half periods.
SPRING = """id = "period"
tags = ["smooth"]
[run]
t_end_s = 10.0
steps = [320, 640, 1280, 2560, 5120]
samples = SAMPLES
[[body]]
name = "p"
mass_kg = 1
position_m = [1, 0, 0]
velocity_m_per_s = [0, 6.283185307179586, 0]
[[force]]
kind = "spring"
body = "p"
anchor_m = [0, 0, 0]
stiffness_N_per_m = 39.47841760435743
[truth]
kind = "closed-form"
solution = "oscillator"
"""
STUDY = """id = "g"
engines = ["%s"]
tolerances = "gates.toml"
baseline = "baseline.tsv"
[[cells]]
scenarios = ["sc.toml"]
methods = ["python/*"]
timing = false
"""
GATES = """[[gate]]
scenario = "period"
method = "python/symplectic-euler"
metric = "order-position"
within = [1.95, 2.05]
reason = "r"
[[gate]]
scenario = "period"
method = "python/symplectic-euler"
metric = "error-position-max"
steps = 5120
max = 0.001
reason = "r"
"""
# A pendulum: with a truth its energy has a scale, without one it is in joules.
PENDULUM = """id = "bar"
[run]
t_end_s = 2
steps = [80, 160, 320, 640]
samples = 10
[world]
gravity_m_per_s2 = [0, -10, 0]
[[body]]
name = "bar"
mass_kg = 1
inertia_kg_m2 = [0.1, 0.1, 0.1]
[[joint]]
name = "pin"
kind = "hinge"
bodies = ["world", "bar"]
anchors_body_m = [[0, 0, 0], [0, 0.5, 0]]
axis_body = [0, 0, 1]
angle_rad = 0.5
[[invariant]]
quantity = "energy"
[truth]
kind = "%s"
"""


class OrdersOverARun(Case):
    def rows(self, *words, code=0):
        self.ask("run", *words, "-o", "csv:rows.csv", code=code)
        with open(self.path("rows.csv")) as file:
            return [row for row in csv.DictReader(file) if row["status"] == "ok"]

    def study(self, samples):
        self.path("sc.toml", SPRING.replace("SAMPLES", str(samples)))
        self.path("gates.toml", GATES)
        self.path("study.toml", STUDY % os.path.join(ROOT, "reference/your_engine/worker.py"))

    def test_samples_at_whole_periods_hide_no_error(self):
        for samples in (20, 80):
            self.study(samples)
            rows = self.rows("study.toml", "--no-timing", "--out", "out%d" % samples, code=1)
            orders = {row["metric"]: row for row in rows if row["steps"] == "0"}
            for metric in ("order-position", "order-position-max", "order-position-rms"):
                self.assertAlmostEqual(float(orders[metric]["value"]), 1, delta=0.1)
            self.assertAlmostEqual(float(orders["order-position-end"]["value"]), 2, delta=0.05)
            self.assertIn("superconvergent at the samples", orders["order-position"]["reason"])
            largest = [row for row in rows if row["metric"] == "error-position-max" and row["steps"] == "5120"][0]
            self.assertAlmostEqual(float(largest["value"]), 6.5e-3, delta=2e-3)
            self.ask("gate", "study.toml", "--out", "out%d" % samples, code=[1, 4])
        self.study(20)
        words = ("advise", "sc.toml", "--engine", os.path.join(ROOT, "reference/your_engine/worker.py"), "--method",
                 "python/symplectic-euler", "--budget", "1s", "--json")
        told = json.loads(self.ask(*words).stdout)
        self.assertGreater(told["advice"]["error"], 3e-3)

    def test_a_figure_does_not_depend_on_which_rungs_run(self):
        self.path("sc.toml", SPRING.replace("SAMPLES", "20"))
        whole = self.rows("--scenario", "sc.toml", "--method", "atwood/symplectic-euler", "--no-timing")
        one = self.rows("--scenario", "sc.toml", "--method", "atwood/symplectic-euler", "--no-timing", "--steps", "1280", "--out", "other")
        figures = lambda rows: {row["metric"]: row["value"] for row in rows if row["steps"] == "1280"}  # noqa: E731
        self.assertEqual(figures(one), figures(whole))
        # The store has the rung already, and a coarser ladder of `compare` beside it.
        again = self.ask("run", "--scenario", "sc.toml", "--method", "atwood/symplectic-euler", "--no-timing", "--steps", "1280")
        self.assertIn("1 of them found in the store", again.stdout)

    def test_baselines_of_other_definitions(self):
        self.study(20)
        self.path("gates.toml", GATES.split("[[gate]]")[0] + "[[gate]]" + GATES.split("[[gate]]")[2].replace("0.001", "0.1"))
        self.ask("run", "study.toml", "--no-timing")
        self.ask("bless", "study.toml", "--reason", "first")
        with open(self.path("baseline.tsv")) as file:
            text = file.read()
        self.assertIn("# definition\torder-position\t2\n", text)
        self.ask("gate", "study.toml", told=["0 regressions"])
        self.assertNotIn("definition changed", self.ask("run", "study.toml", "--no-timing", "--fresh").stdout)  # against the run before
        # As it was written before: no definitions, the order of the end under the name.
        lines = [line for line in text.split("\n") if not line.startswith("# definition")]
        lines[0] = "# atwood baseline 2"
        old = ["\t".join(cells[:4] + ["2.0"] + cells[5:]) if len(cells := line.split("\t")) > 4 and cells[3] == "order-position" else line
               for line in lines]
        self.path("baseline.tsv", "\n".join(old))
        told = self.ask("gate", "study.toml", told=["0 regressions", "definition changed", "order-position: the order of the largest error"])
        self.assertNotIn("regression ", told.stdout)
        # A figure whose definition is the same is still compared.
        worse = ["\t".join(cells[:4] + ["1e-12", "0"] + cells[6:]) if len(cells := line.split("\t")) > 4 and cells[3] == "error-position-end"
                 else line for line in old]
        self.path("baseline.tsv", "\n".join(worse))
        self.ask("gate", "study.toml", code=1, told=["error-position-end"])

    def test_every_metric_has_one_name_in_every_command(self):
        draw = random.Random(38)
        for kind in ("extended", "none"):
            self.path("scene.toml", PENDULUM % kind)
            out = "out-" + kind
            rows = self.rows("--scenario", "scene.toml", "--method", "atwood/rk4", "--out", out, code=[0, 1])
            named = {row["metric"] for row in rows if not row["body"] and row["metric"] != "status"}
            energy = "energy-max" if kind == "extended" else "energy-change-max"
            self.assertIn(energy, named)
            of_runs = {row["metric"] for row in rows if row["steps"] != "0" and not row["body"] and row["metric"] in named}
            history = {figure["metric"] for figure in json.loads(self.ask("history", "--metric", "*", "--out", out, "--json").stdout)}
            for row in rows:  # a history has figures that are judged: no sizes, and no inconclusive ones
                judged_over_time = row["value"] != "nan" and not row["metric"].startswith("size-") and row["metric"] not in (
                    "condition", "solver-residual-max")
                if row["metric"] in named and judged_over_time:
                    self.assertTrue(row["metric"] in history, row["metric"] + " is not in the history")
            self.path("all.toml", "".join(
                '[[gate]]\nscenario = "bar"\nmethod = "atwood/rk4"\nmetric = "%s"\nmin = -1e300\nreason = "r"\n' % metric for metric in sorted(named)))
            judged = json.loads(self.ask("run", "--scenario", "scene.toml", "--method", "atwood/rk4", "--out", out, "--tolerances", "all.toml",
                                         "--json", code=[0, 1]).stdout)
            told = {verdict["metric"] for verdict in judged["verdicts"] if verdict["judgement"] != "not run"}
            self.assertEqual(named - told, set())
            asked = {energy, "rate-evaluations", *draw.sample(sorted(of_runs), 2), *draw.sample(sorted(named - of_runs), 1)}
            for metric in sorted(asked):
                words = ("scene.toml", "--method", "atwood/rk4", "--metric", metric, "--out", out, "--json")
                if metric not in of_runs:
                    self.ask("advise", *words, "--budget", "10s", code=2, told=[metric, "a figure of a whole ladder"])
                    continue
                finite = [row for row in rows if row["metric"] == metric and row["value"] != "nan" and not row["body"]]
                best = self.ask("advise", *words, "--budget", "10s", "--time", "2", code=[0, 1])
                if finite:
                    self.assertEqual(best.returncode, 0, metric + best.stdout + best.stderr)
                compared = self.run_in("compare", "atwood/rk4", "atwood/velocity-verlet", "--scenario", "scene.toml", "--metric", metric,
                                       "--out", out, "--no-timing")
                self.expect(compared, 0, metric.replace("error-", "").replace("-", " ")[:12])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
