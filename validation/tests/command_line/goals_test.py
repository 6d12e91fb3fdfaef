"""Goals through the built program, on an engine whose errors and times are known."""
import base64
import json
import os
import re
import sys
import unittest
import zlib

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from case import Case  # noqa: E402

ENGINE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "goals_engine.py")
SCENE = """id = "straight"
title = "A stone that flies straight on"
claim = "It does."
[run]
t_end_s = 1.0
steps = [64]
samples = 1
[world]
gravity_m_per_s2 = [0, 0, 0]
[[body]]
name = "stone"
mass_kg = 2.0
position_m = [0, 0, 1]
velocity_m_per_s = [1, 0, 2]
[truth]
kind = "extended"
"""
GOAL = """[[goal]]
id = "{id}"
scenario = "{scene}"
metric = "error-position-end"
error = 1e-6
{asked}
steps = [64]
methods = {methods}
"""


class Goals(Case):
    def setUp(self):
        super().setUp()
        self.scene = self.path("straight.toml", SCENE)

    def goals(self, *goals, words=("--no-timing",)):
        """The results of goals, each (id, requirement, methods)."""
        text = "".join(GOAL.format(id=id, scene=self.scene, asked=asked, methods=json.dumps(methods)) for id, asked, methods in goals)
        self.told = self.ask("bench", "goals", "--goals", self.path("goals.toml", text), "--engine", ENGINE, "--json", *words)
        return {goal["id"]: goal for goal in json.loads(self.told.stdout)["goals"]}

    def kept(self):
        with open(self.path("atwood-out/bench.json")) as file:
            return {goal["id"]: goal for goal in json.load(file)["goals"]}

    def test_a_state_that_is_not_finite_over_the_last_quarter_reaches_no_goal(self):
        # 64 samples: 50 and 63 are in the last quarter, 40 is before it. The end itself is right.
        asked = "evaluations = 100"
        goals = self.goals(*((name, asked, ["known/straight{%s}" % setting]) for name, setting in
                             (("right", "off=1e-7"), ("nan", "nan_at=50"), ("inf", "inf_at=63"), ("before", "nan_at=40"))))
        self.assertEqual({name: goal["reached"] for name, goal in goals.items()},
                         {"right": True, "nan": False, "inf": False, "before": True})
        self.assertAlmostEqual(goals["right"]["ours"]["last_quarter"], 1e-7, delta=1e-12)
        for name in ("nan", "inf"):
            self.assertEqual(goals[name]["ours"]["last_quarter"], "inf")
            self.assertFalse(goals[name]["ours"]["accurate"])
            self.assertIn("not finite", goals[name]["why"])
            self.assertEqual(self.kept()[name]["ours"]["last_quarter"], "inf")
        # One that stays finite takes its place, however much it costs; those that do not are not close to it.
        chosen = self.goals(("both", asked, ["known/straight{nan_at=50}", "known/straight{off=1e-7}"]))["both"]
        self.assertEqual(chosen["ours"]["method"], "known/straight{off=1e-7}")
        self.assertNotIn("close", chosen)

    def test_a_goal_is_timed_again_while_the_machine_is_busy(self):
        # Whatever else runs here: each timing of `always` has a second process on its processor, and so have the first 40 of
        # `first`. A timing is taken up to three times, 15 rounds of them are up to 45 timings.
        asked, method = 'time = "1 s"', "known/straight{crowd=%d,work=6}"
        goals = self.goals(("always", asked, [method % 1e9]), ("first", asked, [method % 40]), words=())
        always, first = goals["always"]["machine"], goals["first"]["machine"]
        self.assertEqual(always["again"], 2)
        self.assertTrue(always["busy"])
        self.assertGreater(10 * always["interrupted"], 9 * always["timings"])
        self.assertEqual(always["timings"], 45)  # of one measurement, not of all three
        self.assertIn(first["again"], (1, 2))
        self.assertLessEqual(first["interrupted"] / first["timings"], always["interrupted"] / always["timings"])
        self.assertEqual(self.kept()["always"]["machine"]["again"], 2)
        told = self.ask("bench", "goals", "--goals", "goals.toml", "--goal", "always", "--engine", ENGINE).stdout
        self.assertRegex(" ".join(told.split()), r"Timed on a busy machine, times may be too long: `always` \(\d+ of 45 timings "
                                                 r"interrupted, [0-9.]+ to [0-9.]+ GHz, the calmest of 3\)")
        # Where no time is judged none is taken again.
        kept = self.goals(("kept", "evaluations = 100", [method % 1e9]), words=())["kept"]
        self.assertEqual(kept["machine"]["again"], 0)

    def test_rungs_that_cannot_be_the_cheapest_are_left_out_and_named(self):
        # Of the tolerances 1e-4 to 1e-11 the first four always run. Order 8 reaches 1e-6 with 316 evaluations at 1e-7; order 2
        # needs 10 000 there, so its four finer rungs, up to a million, need not run. Ours are never left out.
        tolerances = [10.0**-k for k in range(4, 12)]
        asked = "evaluations = 1000\ntolerances = %s\nfirst_steps = 64\n" % json.dumps(tolerances)
        rivals = 'rivals = ["known/steep:tol{order=8}", "known/steep:tol{order=2}"]'
        goal = self.goals(("steep", asked + rivals, ["known/steep:tol{order=2,nan_at=-2}"]))["steep"]
        self.assertEqual(goal["left_out"], ["known/steep:1e-%02d{order=2}" % k for k in range(8, 12)])
        self.assertEqual((goal["rival"]["method"], goal["rival"]["evaluations"]), ("known/steep:1e-07{order=8}", 316))
        self.assertEqual((goal["ours"]["method"], goal["ours"]["evaluations"]), ("known/steep:1e-07{order=2,nan_at=-2}", 10000))
        self.assertEqual(self.kept()["steep"]["left_out"], goal["left_out"])
        told = self.ask("bench", "goals", "--goals", "goals.toml", "--engine", ENGINE, "--no-timing").stdout
        self.assertIn("left out 4 finer rungs of 1 rivals' methods", " ".join(told.split()))

    def test_what_costs_ten_times_as_much_is_timed_in_fewer_rounds(self):
        # One of ours of 1 ms. Three rivals, of which the first two are within 1.3 times of the quickest: after a first timing
        # 5 rounds of them, in each measurement; none of the third. Runs of 60 ms are not taken again.
        self.environment = {**os.environ, "GOALS_LOG": self.path("log")}
        rivals = ["known/straight{off=1e-8,work=%d}" % ms for ms in (60, 66, 90)]
        goal = self.goals(("far", 'time = "1 s"\nrivals = %s' % json.dumps(rivals), ["known/straight{off=1e-8,work=1}"]),
                          words=("--no-sandbox",))["far"]
        with open(self.path("log")) as file:
            asked = file.read().split("\n")
        measurements = 1 + goal["machine"]["again"]
        self.assertEqual([asked.count(rival) for rival in rivals], [1 + 5 * measurements, 1 + 5 * measurements, 1])
        self.assertGreaterEqual(asked.count("known/straight{off=1e-8,work=1}"), 15 * measurements)
        self.assertEqual(goal["rival"]["method"], rivals[0])
        self.assertAlmostEqual(goal["ratio"], 60, places=4)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
