"""Questions about fluids through the built program: compare, advise, goals and the words of refusals, on an engine whose
errors and times are known. Called with the program and the project's root."""
import base64
import json
import math
import os
import re
import sys
import unittest
import zlib

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from case import Case  # noqa: E402
from fluid_scene import ENGINE, SCENE, known_error  # noqa: E402

EXACT, COARSE = "known/vortices{space=0.001}", "known/vortices{space=1.0}"


class Questions(Case):
    def setUp(self):
        super().setUp()
        self.path("scene.toml", SCENE)

    def known(self, command, *words, **more):
        return self.ask(command, *words, "--engine", ENGINE, **more)

    def compare(self, *words, **more):
        return self.known("compare", EXACT, COARSE, "--scenario", "scene.toml", *words, **more)

    def advise(self, *words, **more):
        return self.known("advise", "scene.toml", "--method", COARSE, *words, **more)

    def test_compare_ranks_by_time_and_at_equal_spacing(self):
        tables = json.loads(self.compare("--json").stdout)["dominance"]
        self.assertEqual([t["cost"] for t in tables], ["seconds"])  # evaluations of many and few particles are no common cost
        self.assertEqual(tables[0]["metric"], "velocity-l1")
        places = tables[0]["by_spacing"]
        self.assertEqual([(p["spacing_m"], p["sound_speed_m_per_s"]) for p in places],
                         [(dx, c) for dx in (0.25, 0.125, 0.0625, 0.03125) for c in (10, 20)])
        for place in places:
            self.assertEqual([r["family"] for r in place["ranked"]], [EXACT, COARSE])
            for ranked, share in zip(place["ranked"], (0.001, 1)):
                self.assertAlmostEqual(ranked["error"], share * known_error(place), delta=1e-5 * known_error(place))  # six digits
                self.assertAlmostEqual(ranked["cost"], 0.2e-9 * ranked["steps"] / place["spacing_m"]**2, delta=1e-7)
        # An error of 0.03: the other method needs half the spacing, four times the particles and twice the steps.
        level = next(c for c in tables[0]["by_error"] if c["asked"] == 0.03)["ranked"]
        self.assertEqual([(r["family"], r["spacing_m"], r["sound_speed_m_per_s"]) for r in level],
                         [(EXACT, 0.25, 10), (COARSE, 0.125, 10)])
        self.assertAlmostEqual(level[1]["cost"] / level[0]["cost"], 8, delta=1e-6)

    def test_compare_in_words(self):
        told = " ".join(self.compare().stdout.split())
        for word in ("at equal spacing dx [m]", "dx 0.125, c 20", "steps, dx 0.25, c 10", "velocity l1"):
            self.assertIn(word, told)
        self.assertNotIn("stable from", told)

    def test_advice_is_a_measured_rung_that_reaches_the_error(self):
        told = json.loads(self.advise("--error", "0.05", "--json").stdout)
        self.assertEqual((told["metric"], told["advice"]["spacing_m"], told["advice"]["sound_speed_m_per_s"]),
                         ("velocity-l1", 0.125, 10))
        self.assertAlmostEqual(told["advice"]["error"], 0.125**2 * 1.125, delta=1e-7)
        self.assertIn("--spacing 0.125 --sound-speed 10", told["rerun"])
        told = json.loads(self.advise("--budget", "1us", "--json").stdout)  # 20 steps of 64 particles: 256 ns
        self.assertEqual(told["advice"]["spacing_m"], 0.125)
        self.assertIn("dx 0.125, c 10", self.advise("--error", "5%").stdout)
        self.advise("--error", "1e-9", code=1, told=["no rung has that error"])

    def test_the_time_of_advice_bounds_its_truths_too(self):
        # Without a temperature the parts of the error have a truth, which at this Mach number takes minutes a run.
        barotropic = SCENE.replace("heat_capacity_J_per_kg_K = 1\n", "").replace("t_end_s = 0.1", "t_end_s = 10")
        self.path("scene.toml", barotropic.replace("[10, 20]", "[1000]").replace("spacings_m = [0.25, 0.125", "spacings_m = [0.125"))
        told = json.loads(self.advise("--error", "0.05", "--time", "2", "--json", timeout=60).stdout)
        self.assertAlmostEqual(told["advice"]["error"], 0.125**2 * 1.125, delta=1e-7)
        told = self.advise("--metric", "space-error", "--error", "0.05", "--time", "2", timeout=60).stdout
        self.assertIn("the 2 s of the search were over", " ".join(told.split()))

    def test_what_advice_measured_is_measured_whole_by_a_run(self):
        barotropic = SCENE.replace("heat_capacity_J_per_kg_K = 1\n", "").replace(", 0.125, 0.0625, 0.03125]", "]")
        self.path("scene.toml", barotropic.replace("[10, 20]", "[10]"))
        run = ("run", "--scenario", "scene.toml", "--engine", ENGINE, "--method", COARSE, "--steps", "10", "--no-timing", "--json")
        model = []
        for _ in range(2):
            self.advise("--error", "0.2")
            rows = json.loads(self.ask(*run, code=[0, 1]).stdout)["rows"]
            model.append([r["value"] for r in rows if r["metric"] == "model-error"])
        self.assertEqual(len(model[0]), 3)
        self.assertEqual(model[0], model[1])

    def test_advice_at_one_spacing(self):
        told = json.loads(self.advise("--error", "0.1", "--spacing", "0.0625", "--json").stdout)
        self.assertEqual(told["advice"]["spacing_m"], 0.0625)

    def test_questions_that_make_no_sense_name_what_to_ask(self):
        for words, told in ((["--metric", "model-error"], "the same for every method"),
                            (["--metric", "position"], "expected velocity-l1"),
                            (["--metric", "order-space"], "a figure of a whole ladder"),
                            (["--error", "1mm"], "errors of fluids are ratios")):
            self.compare(*words, code=2, told=[told])
            self.advise(*(words if "--error" in words else ["--error", "1e-2", *words]), code=2, told=[told])
        self.ask("compare", "atwood/rk4", "atwood/midpoint", "--scenario", "kepler-e0.6", "--metric", "velocity-l1", code=2,
                 told=["no scene here has a fluid"])
        self.path("scene.toml", SCENE[:SCENE.index("[truth]")] + '[truth]\nkind = "none"\n')
        for told in (self.compare(code=2), self.advise("--error", "1e-2", code=2)):
            self.assertIn("names no truth", told.stderr)
            self.assertIn("--metric energy-budget", told.stderr)
        kept = json.loads(self.compare("--metric", "fluid-momentum-error", "--json").stdout)["dominance"]
        self.assertEqual(kept[0]["metric"], "fluid-momentum-error")

    def test_neighbours_and_the_time_of_a_particle(self):
        rows = json.loads(self.ask("run", "--scenario", "scene.toml", "--engine", ENGINE, "--method", COARSE, "--json",
                                   code=[0, 1]).stdout)["rows"]
        times = [r for r in rows if r["metric"] == "ns-per-particle-evaluation"]
        self.assertEqual(len(times), 8)
        for row in times:
            self.assertAlmostEqual(row["value"], 0.2, delta=1e-6)
            self.assertIn(f"{round(row['spacing_m']**-2)} particles", row["reason"])
        # The engine names no kernel, so that nothing counts as a neighbour.
        self.assertFalse([r for r in rows if r["metric"] == "neighbours"])

    def test_the_report_holds_the_particles_of_the_finest_cell(self):
        self.ask("run", "--scenario", "scene.toml", "--engine", ENGINE, "--method", COARSE, "--no-timing", code=[0, 1])
        with open(self.path("atwood-out/report.html")) as file:
            coded = re.search('id="data">([^<]*)<', file.read()).group(1)
        report = json.loads(zlib.decompress(base64.b64decode(coded), -15))
        self.assertEqual(len(report["pictures"]), 1)
        picture = report["pictures"][0]
        self.assertEqual((report["strings"][picture["s"]], report["strings"][picture["m"]]), ("vortices", COARSE))
        self.assertEqual((picture["dx"], picture["c"], picture["particles"]), (0.03125, 20, 1024))
        self.assertEqual(picture["error_of"], "velocity [m/s]")
        for name in ("x", "y", "speed", "pressure", "error"):
            self.assertEqual(len(picture[name]["at"]), 1024)
        self.assertEqual((picture["x"]["low"], picture["x"]["high"]), (0, 1))
        # At most the exact speed, 1 exp(-8 pi^2 0.01 0.1), times the known share.
        largest = math.exp(-8 * math.pi**2 * 0.001) * 0.03125**2 * 1.03125
        self.assertAlmostEqual(10**picture["error"]["high"], largest, delta=0.05 * largest)

    def test_a_goal_takes_a_spacing_an_instant_and_seeds(self):
        goal = """
[[goal]]
id = "{id}"
scenario = "{scene}"
metric = "{metric}"
{asked}
sound_speed_m_per_s = 10
samples = 2
steps = [10]
methods = ["known/vortices{{space=1.0}}"]
"""
        scene = self.path("scene.toml")
        self.path("goals.toml", goal.format(id="met", scene=scene, metric="velocity-l1", 
                                    asked='error = 0.08\nspacings_m = [0.25]\nseeds = 3\nrivals = ["known/vortices{space=2.0}"]\n'
                                    "rival_steps = [20]\nrival_seeds = 1")
                  + goal.format(id="missed", scene=scene, metric="velocity-l1", asked="error = 0.01\nspacings_m = [0.125]\nat_s = 0.05")
                  + goal.format(id="order", scene=scene, metric="order-space",
                                asked="within = [1.8, 2.3]\nspacings_m = [0.25, 0.125, 0.0625, 0.03125]")
                  + goal.format(id="no-order", scene=scene, metric="order-space",
                                asked="within = [3.8, 4.2]\nspacings_m = [0.25, 0.125, 0.0625, 0.03125]"))
        told = self.known("bench", "goals", "--goals", "goals.toml", "--no-timing", "--json")
        goals = {g["id"]: g for g in json.loads(told.stdout)["goals"]}
        self.assertEqual({name: g["reached"] for name, g in goals.items()},
                         {"met": True, "missed": False, "order": True, "no-order": False})
        self.assertAlmostEqual(goals["met"]["ours"]["error"], 0.25**2 * 1.25, delta=1e-6)
        self.assertEqual((goals["met"]["ours"]["steps"], goals["met"]["rival"]["steps"]), (10, 20))
        self.assertAlmostEqual(goals["met"]["rival"]["error"], 2 * 0.25**2 * 1.25, delta=2e-6)
        self.assertAlmostEqual(goals["missed"]["ours"]["error"], 0.125**2 * 1.125, delta=1e-7)
        self.assertIn("times too large", goals["missed"]["why"])
        self.assertIn("is not inside", goals["no-order"]["why"])
        for asked, word in (("seeds = 2\nrival_seeds = 3", "`rival_seeds`: expected at most `seeds`"),
                            ("rival_steps = [3]", "`rival_steps`: expected multiples of `samples`")):
            self.path("goals.toml", goal.format(id="odd", scene=scene, metric="velocity-l1", asked="error = 1\n" + asked))
            self.known("bench", "goals", "--goals", "goals.toml", "--no-timing", code=2, told=[word])


class Words(Case):
    def test_a_run_without_a_figure_says_why(self):
        told = self.ask("run", "--scenario", "taylor-green", "--method", "atwood/rk4", "--spacing", "0.0625", "--no-timing",
                        code=[0, 1])
        self.assertIn("3 cells: unsupported: the scene has fluids: use +sph or +polynomial", told.stdout)

    def test_a_scene_of_another_study(self):
        self.ask("run", "--scenario", "taylor-green", code=2, told=["nothing to run: the default study", "(fluid)", "--method"])

    def test_the_counts_of_a_run_that_is_timed_later(self):
        words = ("run", "--scenario", "ballistic", "--method", "atwood/rk4", "--steps", "120")
        self.ask(*words, "--no-timing", code=[0, 1], told=["1 cell, 1 of them run, 0 timed"])
        told = self.ask(*words, code=[0, 1])
        self.assertIn("1 cell, 0 of them run, 1 timed, 0 found whole in the store", told.stdout)
        self.ask(*words, code=[0, 1], told=["1 cell, 1 of them found in the store"])

    def test_the_option_that_was_given(self):
        for words in (["--particles"], ["--probes"], ["--spacing", "0.1"], ["--sound-speed", "3"]):
            self.ask("trace", "kepler-e0.6", "--method", "atwood/rk4", *words, code=2, told=[words[0] + ": `kepler-e0.6` has no fluid"])
        for option in ("--spacing", "--sound-speed"):
            self.ask("run", "--scenario", "taylor-green", "--method", "atwood/rk4+sph", option, "abc", code=2,
                     told=[option + ": found `abc`; expected a number of metres"])

    def test_every_solver_is_described(self):
        told = self.ask("list", "metrics").stdout
        for solver in ("implicit-stages", "contact-newton", "expanding-polytope"):
            self.assertRegex(told, solver + r"\n(?:    .*\n)*?    .*Residual:")


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
