"""Comparisons that a rival's author would sign: one rate for all, tuned presets from a search that includes the default, both of
Bullet's tables of contact algorithms."""
import json
import os
import re
import sys
import unittest

from case import ATWOOD, ROOT, Case

BIN = os.path.dirname(ATWOOD)
os.environ["ATWOOD_ROOT"] = ROOT
SPECIAL = ("error-position-max", "error-attitude-max", "error-velocity-rms", "energy-max", "energy-gain", "energy-rise", "penetration-max",
           "penetration-rms")

CUBES = """id = "cubes"
title = "Two aligned cubes, 0.1 deep"
claim = "Depth 0.1 along x."
[run]
t_end_s = 1.0
steps = [1]
samples = 1
[world]
gravity_m_per_s2 = [0, 0, 0]
[[body]]
name = "a"
mass_kg = 1
shape.box = { half_extents_m = [0.5, 0.5, 0.5] }
position_m = [0, 0, 0]
[[body]]
name = "b"
mass_kg = 1
shape.box = { half_extents_m = [0.5, 0.5, 0.5] }
position_m = [0.9, 0, 0]
[truth]
kind = "none"
"""


@unittest.skipUnless(os.path.exists(os.path.join(BIN, "atwood-odeint")), "odeint is not built")
class SameRate(Case):
    def compare(self, *words):
        return json.loads(self.ask("compare", "atwood/rk4", "odeint/runge_kutta4", "--scenario", "free-box-complex", "--steps", "960",
                                   "--steps", "1920", "--json", *words).stdout)

    def ranked(self, data):
        return {reached["method"] for table in data["dominance"] for level in table["by_error"] for reached in level["ranked"]}

    def test_a_library_and_ours_are_ranked_on_one_rate_and_native_times_stand_beside(self):
        for words in ((), ("--same-rate",)):
            data = self.compare(*words)
            self.assertEqual(data["rates"], "same")
            self.assertEqual(self.ranked(data), {"atwood-same-rate/rk4", "odeint/runge_kutta4"})
            timed = {row["method"] for row in data["rows"] if row["metric"] == "run-time"}
            self.assertIn("atwood/rk4", timed)
            # The same work: as many evaluations, and the same rate underneath.
            counts = {row["method"]: row["value"] for row in data["rows"] if row["metric"] == "rate-evaluations" and row["steps"] == 960}
            self.assertEqual(counts["atwood-same-rate/rk4"], counts["odeint/runge_kutta4"])
            overheads = {one["method"]: one for one in data["overheads"]}
            self.assertEqual(set(overheads), {"atwood-same-rate/rk4", "odeint/runge_kutta4"})
            for one in overheads.values():
                self.assertLessEqual(one["overhead_ns"]["low"], one["overhead_ns"]["value"])
                self.assertLessEqual(one["overhead_ns"]["value"], one["overhead_ns"]["high"])
                self.assertGreater(one["rate_ns"]["value"], 0)

    def test_native_rates_are_asked_for_and_said(self):
        data = self.compare("--native-rate")
        self.assertEqual(data["rates"], "native")
        self.assertEqual(self.ranked(data), {"atwood/rk4", "odeint/runge_kutta4"})
        self.assertEqual(data["overheads"], [])
        self.assertIn("--same-rate", data["rates_words"])

    def test_the_headline_says_which_it_is(self):
        words = ("compare", "atwood/rk4", "odeint/runge_kutta4", "--scenario", "free-box-complex", "--steps", "960")
        told = self.ask(*words).stdout
        self.assertIn("The same rate: ours (atwood-same-rate) and odeint call", re.sub(r"\s+", " ", told))
        self.assertIn("beside the rate, an evaluation costs", told)
        self.assertIn("Native rates: odeint call", re.sub(r"\s+", " ", self.ask(*words, "--native-rate").stdout))

    def test_what_takes_no_rate_is_not_ranked_against_what_does(self):
        data = json.loads(self.ask("compare", "atwood/velocity-verlet", "atwood/rk4", "odeint/runge_kutta4", "--scenario", "kepler-e0.3", "--steps",
                                   "960", "--same-rate", "--json").stdout)
        self.assertEqual(self.ranked(data), {"atwood-same-rate/rk4", "odeint/runge_kutta4"})
        self.assertTrue(any("not ranked" in note and "atwood/velocity-verlet" in note for note in data["notes"]), data["notes"])

    def test_slips(self):
        self.assertIn("found no method of ours", self.ask("compare", "atwood/velocity-verlet", "odeint/euler", "--same-rate", code=2).stderr)
        self.ask("compare", "atwood/rk4", "odeint/euler", "--same-rate", "--native-rate", code=2)
        self.assertNotIn("atwood-same-rate", self.ask("list", "methods").stdout)

    def test_advice_and_goals_at_the_same_rate(self):
        words = ("advise", "kepler-e0.3", "--error", "1e-6", "--method", "atwood/rk4", "--method", "atwood/velocity-verlet", "--method", "odeint/runge_kutta4")
        advice = json.loads(self.ask(*words, "--same-rate", "--json").stdout)
        self.assertIn("the same", advice["rates"])
        self.assertIn(advice["advice"]["method"], ("atwood-same-rate/rk4", "odeint/runge_kutta4"))
        self.assertNotIn("same-rate", advice["rerun"].split("--method")[1])
        self.assertTrue(any("atwood/velocity-verlet" in left["methods"] and "same-rate" in left["reason"] for left in advice["left_out"]))
        self.assertIn("native", json.loads(self.ask(*words, "--json").stdout)["rates"])
        goals = self.path("goals.toml", """[[goal]]
id = "one"
title = "One"
scenario = "kepler-e0.6"
metric = "error-state-end"
error = 1e-2
time = "1 s"
steps = [960]
methods = ["atwood/rk4"]
rivals = ["odeint/runge_kutta4"]
""")
        goal = json.loads(self.ask("bench", "goals", "--goals", goals, "--json").stdout)["goals"][0]
        self.assertEqual((goal["ours"]["method"], goal["same_rate"]["method"], goal["library"]["method"]),
                         ("atwood/rk4", "atwood-same-rate/rk4", "odeint/runge_kutta4"))
        self.assertLessEqual(goal["same_rate_low"], goal["same_rate_ratio"])
        self.assertLessEqual(goal["same_rate_ratio"], goal["same_rate_high"])
        self.assertIn("at the same rate the library costs", self.ask("bench", "goals", "--goals", goals).stdout)


class Tune(Case):
    SMALL = ("--trials", "6", "--no-timing", "--scenario", "roll", "--scenario", "roll-slip", "--scenario", "slip-to-roll", "--scenario", "slide-10")

    def test_a_search_is_the_same_each_time_and_keeps_its_evidence(self):
        kept = []
        for name in ("one.json", "two.json"):
            told = self.ask("tune", "ode", "--class", "friction", "--file", name, "--out", "out-" + name, *self.SMALL)
            self.assertIn("6 trials", told.stdout)
            with open(os.path.join(self.here, name)) as file:
                kept.append(json.load(file))
        self.assertEqual(kept[0], kept[1])
        entry = kept[0]["ode"]["friction"]
        self.assertEqual(entry["seed"], 1784)
        self.assertFalse(set(entry["training"]) & set(entry["held_out"]))
        self.assertTrue(entry["training"] and entry["held_out"])
        self.assertIn("kept", entry["verdict"])
        if entry["settings"]:
            for figure in entry["evidence"]:
                self.assertLessEqual(abs(figure["tuned"]), abs(figure["default"]) * (1 + 1e-9) + figure["interval"] + 1e-12, figure)

    def test_the_default_wins_where_nothing_is_better(self):
        told = self.ask("tune", "ode", "--class", "friction", "--trials", "1", "--no-timing", "--scenario", "roll", "--scenario", "roll-slip")
        self.assertIn("the default is kept: no trial was better", told.stdout)
        with open(os.path.join(self.here, "atwood-out/tuned.json")) as file:
            self.assertEqual(json.load(file)["ode"]["friction"]["settings"], {})

    def test_too_few_scenes_are_said(self):
        self.assertIn("found 1 scenes of that class", self.ask("tune", "ode", "--class", "friction", "--no-timing", "--scenario", "roll").stdout)
        self.assertIn("found 0 scenes of that class", self.ask("tune", "ode", "--class", "mechanism", "--no-timing", "--scenario", "roll").stdout)

    def test_slips(self):
        self.assertIn("free-flight, bounce, friction, stack, heap, mechanism", self.ask("tune", "ode", "--class", "heaps", code=2).stderr)
        self.assertIn("atwood, bullet32, bullet64, dart, jolt, mujoco, mujoco3, ode, rapier or simbody", self.ask("tune", "havok", "--class", "heap", code=2).stderr)
        self.assertIn("--trials", self.ask("tune", "ode", "--class", "heap", "--trials", "0", code=2).stderr)
        self.ask("tune", "ode", code=2)

    def test_tuned_is_nowhere_worse_than_the_default_on_the_scenes_held_out(self):
        with open(os.path.join(ROOT, "reference/rivals/tuned.json")) as file:
            searches = json.load(file)
        compared = 0
        for engine, classes in searches.items():
            if engine == "atwood":
                continue
            for name, entry in classes.items():
                worth = {}
                for figure in entry["evidence"]:
                    if figure["held_out"] and entry["settings"]:
                        worth[figure["scenario"], figure["metric"]] = figure
                for scenario in sorted({key[0] for key in worth}):
                    samples = json.loads(self.ask("describe", scenario, "--json").stdout)["run"]["samples"]  # the search has 16
                    steps = samples * -(-next(f["steps"] for key, f in worth.items() if key[0] == scenario) // samples)
                    rows = json.loads(self.ask("run", "--scenario", scenario, "--method", engine + "/default", "--method", engine + "/tuned", "--steps",
                                               str(steps), "--no-timing", "--json", "--limit", "120").stdout)["rows"]
                    if all(r["status"] == "not built" for r in rows):
                        continue
                    figures = {(r["method"].split("/")[1], r["metric"]): r["value"] for r in rows
                               if r["steps"] == steps and not r["body"] and r["metric"] in SPECIAL}
                    for metric in SPECIAL:
                        if (scenario, metric) not in worth:
                            continue
                        interval = worth[scenario, metric]["interval"]
                        default, tuned = abs(figures["default", metric]), abs(figures["tuned", metric])
                        self.assertLessEqual(tuned, default * (1 + 1e-9) + 2 * interval + 1e-12, (engine, name, scenario, metric))
                        compared += 1
        self.assertGreater(compared, 0)


class Contacts(Case):
    def test_both_of_bullets_tables_are_shown_by_name(self):
        scene = self.path("cubes.toml", CUBES)

        def deepest(engine):
            lines = self.ask("contacts", scene, "--engine", engine).stdout.strip().split("\n")[1:]
            return max((tuple(float(x) for x in line.split(",")[5:9]) for line in lines), key=lambda c: c[3])

        stepped, closest = deepest("bullet64"), deepest("bullet64/closest-points")
        for got, wanted in zip(stepped, (1, 0, 0, 0.1)):
            self.assertAlmostEqual(got, wanted, delta=1e-12)
        self.assertLess(closest[3], 0.09)  # a diagonal normal and .0577
        rounded = deepest("bullet32")
        self.assertAlmostEqual(rounded[3], 0.1, delta=1e-6)


sys.argv[1:] = sys.argv[3:]
unittest.main(verbosity=1)
