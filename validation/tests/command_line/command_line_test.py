"""The commands as a user meets them: words, exit codes, files, bad input, bad luck."""
import csv
import io
import json
import os
import resource
import shutil
import signal
import subprocess
import sys
import time
import unittest
import xml.etree.ElementTree as xml

from case import ATWOOD, ROOT, Case, thrown_stone

os.environ["ATWOOD_CALLED_AS"] = "./atwood"  # as the script in front of the program calls it
SMALL = ["--scenario", "kepler-e0.6", "--method", "atwood/rk4", "--steps", "960", "--no-timing"]

SCENE = thrown_stone("[64, 128]") + '[[invariant]]\nquantity = "energy"\n'


def atwood(*words, cwd=None, **more):
    return subprocess.run([ATWOOD, *words], cwd=cwd, text=True, capture_output=True, timeout=300, **more)


class Inspecting(Case):
    def test_list_describe_schema_doctor(self):
        listed = json.loads(self.expect(self.run_in("list", "--json"), 0).stdout)
        ids = {s["id"] for s in listed["scenarios"]}
        self.assertIn("kepler-e0.6", ids)
        for method in listed["methods"]:
            self.assertTrue(method["doc"], method["id"])
        described = json.loads(self.expect(self.run_in("describe", "free-box-complex", "--json"), 0).stdout)
        self.assertIn("scene", json.dumps(described))
        schema = json.loads(self.expect(self.run_in("schema"), 0).stdout)
        self.assertIn("$schema", schema)
        json.loads(self.expect(self.run_in("schema", "rows"), 0).stdout)
        self.expect(self.run_in("doctor"), 0, "bullet64", "ode", "cvode", "atwood-fcl", "contacts only")

    def test_contacts_by_other_tests_of_an_engine(self):
        box = "shape.box = { half_extents_m = [1, 1, 1] }"
        inside = SCENE.replace("[truth]", 'shape.sphere = { radius_m = 0.5 }\n[truth]').replace("shape.sphere = { radius_m = 0.5 }", box)
        inner = inside[inside.index("[[body]]"):inside.index("[truth]")].replace("stone", "pebble").replace("[1, 1, 1]", "[0.1, 0.1, 0.1]")
        path = self.path("inside.toml", inside.replace("[truth]", inner + "[truth]"))
        rows = lambda engine: len(self.expect(self.run_in("contacts", path, "--engine", engine), 0).stdout.splitlines()) - 1
        self.assertGreater(rows("atwood"), 0)
        self.assertEqual(rows("box-edges"), 0)  # no edge of either meets a face of the other: containment is missed
        self.assertEqual(rows("atwood/box-edges"), 0)
        self.assertGreater(rows("ode/unit-size"), 0)
        self.expect(self.run_in("contacts", path, "--engine", "ode/nonsense"), 0, "unsupported", "has no test `nonsense`")

    def test_a_method_is_described_with_its_response(self):
        self.expect(self.run_in("describe", "atwood/rk4+event"), 0, "order:", "+event", "restitution = newton", "simultaneous = sequential")
        told = json.loads(self.expect(self.run_in("describe", "atwood/rk4+penalty", "--json"), 0).stdout)
        self.assertEqual(told["response"]["id"], "+penalty")
        self.expect(self.run_in("describe", "atwood/rk4+bounce"), 2, "atwood/rk4+bounce", "+impulse, +event, +penalty")
        self.expect(self.run_in("describe", "ode/default+impulse"), 2, "the engine resolves contacts itself")

    def test_no_ansi_off_a_terminal(self):
        for words in (["list"], ["doctor"], ["run", *SMALL]):
            result = self.run_in(*words)
            self.assertNotIn("\x1b", result.stdout + result.stderr)

    def test_usage_errors_exit_2(self):
        for words in ([], ["frobnicate"], ["run", "--frobnicate"], ["trace"], ["list", "everything"], ["describe", "no-such-scene"],
                      ["run", "--scenario", "no-such-*"], ["run", "--method", "atwood/rk5"], ["run", "--method", "bulet64/default"], ["run", "--method", "atwood"],
                      ["run", *SMALL[:-3], "--steps", "7"], ["run", *SMALL, "-o", "pdf:x"], ["run", "no-such-study.toml"], ["run", "no-such-study"],
                      ["run", "--engine", "/no/such/engine"], ["trace", "kepler-e0.6", "--method", "unknown/rk4"]):
            self.expect(self.run_in(*words), 2)


class OptionalEngines(Case):
    """A build without them: the programs of this one, without those executables."""
    ENGINES = ["dart", "jolt", "mujoco", "mujoco3", "pysph", "rapier", "simbody"]

    def setUp(self):
        super().setUp()
        bin_dir = os.path.dirname(ATWOOD)
        shutil.copy(ATWOOD, self.path("atwood"))  # finds its workers beside itself
        for name in os.listdir(bin_dir):
            if name != "atwood" and name.removeprefix("atwood-") not in self.ENGINES:
                os.symlink(os.path.join(bin_dir, name), self.path(name))

    def run_without(self, *words):
        return subprocess.run([self.path("atwood"), *words], cwd=self.here, text=True, capture_output=True, timeout=300,
                              env={**os.environ, "ATWOOD_ROOT": ROOT})

    def test_what_is_not_there_says_how_to_get_it(self):
        for engine in self.ENGINES:
            how = f"ATWOOD_ENGINES={engine} ./atwood run"
            self.expect(self.run_without("doctor"), 0, f"atwood-{engine}", "not built", how)
            self.expect(self.run_without("list", "methods"), 0, f"atwood-{engine}: not built", f"ATWOOD_ENGINES={engine}")
            self.expect(self.run_without("list", "methods", "--long"), 0, f"atwood-{engine}: not built", how)
            for method in (f"{engine}/default", f"{engine}/*"):
                result = self.run_without("run", "--scenario", "ballistic", "--method", method, "--steps", "120", "--no-timing",
                                          "--out", self.path("out"), "-o", "csv:" + self.path("rows.csv"))
                with open(self.path("rows.csv")) as file:
                    rows = list(csv.DictReader(file))
                self.assertTrue(rows, result.stdout + result.stderr)
                for row in rows:
                    self.assertEqual(row["status"], "not built")
                    self.assertIn(how, row["reason"])


class Wrapper(unittest.TestCase):
    def test_an_unknown_engine_is_refused(self):
        result = subprocess.run([os.path.join(ROOT, "atwood"), "doctor"], text=True, capture_output=True, timeout=60,
                                env={**os.environ, "ATWOOD_ENGINES": "mujoco,havok"})
        self.assertEqual(result.returncode, 2)
        self.assertIn("havok", result.stderr)
        self.assertIn("dart,jolt,mujoco,mujoco3,pysph,rapier,simbody", result.stderr)


class Comparing(Case):
    def test_tolerances_are_added_where_a_method_takes_them(self):
        result = self.expect(self.run_in("compare", "atwood/rk4", "atwood/dopri5", "cvode/adams", "--scenario", "kepler-e0.6",
                                         "--no-timing"), 0, "evaluations of the equations of motion", "cheapest for a wanted error",
                             "a  atwood/rk4", "atwood/dopri5:tol", "tol 1e-13", "cvode/adams chooses its own steps",
                             "named without a tolerance", "stable from", "compare.html")
        self.assertNotIn("\x1b", result.stdout + result.stderr)
        for line in result.stdout.splitlines():
            if not line.startswith(("cvode", "atwood", "kepler")):  # notes and titles wrap by themselves
                self.assertLessEqual(len(line), 80, line)
        self.assertTrue(os.path.exists(self.path("atwood-out/compare.html")))
        self.assertFalse(os.path.exists(self.path("atwood-out/report.html")))

    def test_paired_ratios_and_documents(self):
        words = ("compare", "atwood/rk4", "atwood/heun", "--scenario", "ballistic", "--scenario", "kepler-e0.6", "--json",
                 "-o", "html:mine.html", "-o", "md:mine.md")
        data = json.loads(self.expect(self.run_in(*words), 0).stdout)
        kepler = [d for d in data["dominance"] if d["scenario"] == "kepler-e0.6" and d["cost"] == "seconds"][0]
        self.assertEqual(kepler["metric"], "error-position-max")
        first = kepler["by_error"][0]
        self.assertEqual(first["asked"], 1e-3)
        self.assertEqual(first["ranked"][0]["family"], "atwood/rk4")
        self.assertLessEqual(first["to_next"]["low"], first["to_next"]["value"])
        self.assertLessEqual(first["to_next"]["value"], first["to_next"]["high"])
        self.assertGreaterEqual(first["to_next"]["pairs"], 5)
        self.assertTrue(os.path.exists(self.path("mine.html")))
        self.assertFalse(os.path.exists(self.path("atwood-out/compare.html")))
        with open(self.path("mine.md")) as file:
            self.assertIn("Cheapest method for an error", file.read())

    def test_a_last_word_names_a_method(self):
        result = self.run_in("compare", "odeint/dopri5", "atwood/rk4", "--scenario", "kepler-e0", "--no-timing")
        if "no engine" in result.stderr or "not built" in result.stdout + result.stderr:
            return  # that library is not here
        self.expect(result, 0, "taken as odeint/runge_kutta_dopri5", "odeint/controlled/runge_kutta_dopri5 chooses its own steps",
                    "dopri5:tol")

    def test_a_method_that_cannot_run_the_scene_is_a_line(self):
        self.expect(self.run_in("compare", "atwood/rk4", "bullet64/tuned", "--scenario", "kepler-e0", "--scenario", "lorenz", "--no-timing"),
                    0, "bullet64/tuned", "unsupported: ")

    def test_slips_of_the_pen(self):
        self.expect(self.run_in("compare", "atwood/rk4", "atwood/dopri6"), 2, "atwood/dopri5")
        self.expect(self.run_in("compare", "atwood/rk4", "atwood/heun", "--scenario", "kepler-0.6"), 2, "kepler-e0.6")
        self.expect(self.run_in("compare", "atwood/rk4{step=1}", "atwood/heun"), 2, "no setting `step`")
        self.expect(self.run_in("run", "--scenario", "ballistic", "--method", "ode/default{erq=0.1}"), 2, "no setting `erq`", "erp")
        self.expect(self.run_in("compare", "atwood/rk4", "-o", "html:no-such-folder/x.html"), 5, "no-such-folder")


HEAPS = """#!/usr/bin/env python3
import json, sys, time
asked = set()
for line in sys.stdin:
    request = json.loads(line)
    if request["request"] == "hello":
        print(json.dumps({"engine": "odd", "version": "1", "scalar": "double", "methods": [{"id": "odd/one", "doc": "odd"}]}), flush=True)
        continue
    bodies = sum(body["mass_kg"] > 0 for body in request["scene"]["bodies"])
    if bodies >= 300: time.sleep(1000)
    step_ms = 0.1 * bodies if bodies in asked else 100  # a bad moment of the machine, whenever somebody new comes
    asked.add(bodies)
    print(json.dumps({"cell": request["cell"], "done": {"step_ns": [int(step_ms * 1e6)] * request["steps"],
                      "status": "ok", "reason": "", "steps_taken": request["steps"], "rate_evaluations": 0, "busy_ns": []}}), flush=True)
"""


class FrameBudget(Case):
    def test_a_bad_moment_ends_no_search_and_a_limit_is_told(self):
        path = self.path("heaps.py", HEAPS, 0o755)
        result = self.expect(self.run_in("bench", "frame-budget", "--engine", path, "--method", "odd/one", "--limit", "0.5"), 0)
        row = next(line for line in result.stdout.splitlines() if line.startswith("odd/one") and "spheres" in line).split()
        self.assertTrue(154 <= float(row[2]) <= 167, row)
        self.assertTrue(277 <= float(row[4]) < 300, row)
        self.assertIn("odd/one, spheres: N in 40 ms may be larger", result.stdout)
        notes = " ".join(result.stdout.split())
        self.assertIn("bodies were not stepped within --limit 0.5 (seconds a run)", notes)
        self.assertNotIn("N in 16.7 ms may be larger", notes)

    def test_a_block_of_fluid_is_stepped_and_a_crash_is_no_success(self):
        words = ("bench", "frame-budget", "--method", "atwood/rk4+sph", "--limit", "0.3", "--json")
        rows = json.loads(self.expect(self.run_in(*words), 0).stdout)["tables"][0]["rows"]
        self.assertEqual([row[1] for row in rows], ["2-D", "3-D"])
        path = self.path("dies.py", HEAPS.replace("if bodies >= 300: time.sleep(1000)", "sys.exit(1)"), 0o755)
        self.expect(self.run_in("bench", "frame-budget", "--engine", path, "--method", "odd/one"), 3, "odd/one", "crashed")


GATE = """[[gate]]
scenario = "kepler-e0.6"
method = "atwood/rk4"
metric = "error-position-end"
max = 1
reason = "wide"
"""


class Settings(Case):
    """A slip of the pen in a method's settings is input, wherever it stands; a scene that an engine cannot do is not."""
    def test_settings_of_a_response_belong_to_the_id(self):
        words = ("--scenario", "struck-rod-rough", "--steps", "120", "--no-timing")
        method = "atwood/rk4+event{restitution=poisson,simultaneous=together}"
        data = json.loads(self.run_in("run", *words, "--method", method, "--json").stdout)
        self.assertEqual({row["method"] for row in data["rows"]}, {method})
        self.assertEqual({row["status"] for row in data["rows"]}, {"ok"})
        self.expect(self.run_in("compare", method, "atwood/rk4+event", *words), 0, "poisson")
        self.expect(self.run_in("run", *words, "--method", "atwood/rk4+event{bounce=1}"), 2, "neither atwood/rk4 nor +event",
                    "`bounce`", "restitution, simultaneous")
        self.expect(self.run_in("run", *words, "--method", "atwood/rk4{restitution=poisson}"), 2, "atwood/rk4 has no setting `restitution`")

    def test_settings_of_step_control_need_a_tolerance(self):
        for method, name in (("atwood/ias15{criterion=prs23}", "criterion"), ("atwood/dopri5{safety=0.8}", "safety")):
            self.expect(self.run_in("trace", "kepler-e0", "--method", method), 1, "unsupported",
                        f"`{name}` has an effect only with a tolerance; expected one, as in")
        self.expect(self.run_in("trace", "kepler-e0", "--method", "atwood/ias15:1e-16{criterion=prs23}"), 0)

    def test_settings_that_others_leave_without_effect(self):
        for method, told in (("atwood/ias15:1e-12{epsilon=1e-7}", "`epsilon` has an effect only with criterion=rein-spiegel or criterion=prs23"),
                             ("atwood/gbs:1e-9{columns=7}", "`columns` has an effect only with order=fixed"),
                             ("atwood/gbs:1e-12{order=fixed,columns=9}", "at most 8 columns")):
            self.expect(self.run_in("trace", "kepler-e0", "--method", method), 1, "unsupported", told)
        self.expect(self.run_in("trace", "kepler-e0", "--method", "atwood/gbs{columns=9}"), 0)
        self.expect(self.run_in("trace", "kepler-e0", "--method", "atwood/gbs:1e-10{order=fixed,columns=8}"), 0)

    def test_wrong_values_are_input(self):
        for method, *told in (("atwood/rk4+event{restitution=foo}", "+event", "`restitution` is `foo`; expected newton, poisson or stronge"),
                              ("atwood/rk4+event{foo=bar}", "+event", "`foo`", "simultaneous"),
                              ("atwood/symplectic-euler+impulse{substeps=-1}", "+impulse", "`substeps` is `-1`; expected a whole number from 0 to 1000"),
                              ("atwood/symplectic-euler+impulse{substeps=1e9}", "+impulse", "`substeps`", "a whole number"),
                              ("atwood/symplectic-euler+impulse{broad_phase=octree}", "+impulse: `broad_phase` is `octree`; expected "),
                              ("atwood/rk4+penalty{overlap=2}", "+penalty", "`overlap` is `2`; expected a number from 1e-09 to 0.5"),
                              ("atwood/gbs+event{columns=1}", "`columns` is `1`; expected a whole number from 2 to "),
                              ("atwood/rk4{gravity=twice}", "atwood/rk4: `gravity` is `twice`; expected auto, direct or tree"),
                              ("cvode/adams{max_order=13}", "`max_order` is `13`; expected a whole number from 1 to 12"),
                              ("ode/default{step=leap}", "`step` is `leap`; expected dWorldStep or dWorldQuickStep"),
                              ("ode/default{space=tree}", "`space` is `tree`; expected dHashSpace"),
                              ("atwood/rk4+penalty{overlap=1e-300}", "`overlap` is `1e-300`; expected a number from 1e-09 to 0.5"),
                              ("atwood/rk4+penalty{impact_speed_m_per_s=1e308}", "a number from 0 to 1000000"),
                              ("atwood/dopri5:1e-6{safety=1e308}", "`safety` is `1e+308`; expected a number from 0.01 to 1"),
                              ("bullet64/default{erp=foo}", "`erp`", "a number")):
            self.expect(self.run_in("trace", "bounce-e0.8", "--method", method), 2, method, *told)
            if "foo" not in method: continue
            study = self.path("study.toml", f"id = 'mine'\n[[cells]]\nscenarios = ['bounce-e0.8']\nmethods = ['{method}']\n")
            for words in (("describe", method), ("run", study, "--no-timing"),
                          ("run", "--scenario", "bounce-e0.8", "--method", method, "--no-timing"),
                          ("compare", method, "atwood/rk4+event", "--scenario", "bounce-e0.8")):
                self.expect(self.run_in(*words), 2, method, *told)
        sweep = "id = 'mine'\n[[cells]]\nscenarios = ['bounce-e0.8']\nmethods = ['atwood/rk4+event']\nsweep = { restitution = ['newton', 'foo'] }\n"
        self.expect(self.run_in("run", self.path("study.toml", sweep)), 2, "study `mine`", "newton, poisson or stronge")

    def test_what_a_study_names_is_there(self):
        study = "id = 'mine'\n[[cells]]\nscenarios = ['kepler-e0.6']\nsteps = [960]\nmethods = ['%s']\n"
        for method, told in (("atwood/rk5", "atwood has no method `rk5`"), ("bulet64/default", "no engine `bulet64`"),
                             ("physx/default", "no engine `physx` is available (PhysX's package for JavaScript, physx-js-webidl, is built only for browsers"),
                             ("atwood/rx*", "no method of atwood")):
            self.expect(self.run_in("run", self.path("study.toml", study % method)), 2, "study `mine`", told)
        self.expect(self.run_in("run", self.path("study.toml", study % "atwood/rk4'\n, 'atwood/leapfrog"), "--no-timing", "--tolerances", self.path("none.toml", GATE)), 0)
        for other in ("mine.toml", "kepler-f*", "tag:smoth"):
            text = (study % "atwood/rk4").replace("['kepler-e0.6']", f"['kepler-e0.6', '{other}']")
            self.expect(self.run_in("run", self.path("study.toml", text)), 2, "study `mine`", f"`{other}`")
        self.expect(self.run_in("run", self.path("study.toml", (study % "atwood/rk4").replace("kepler-e0.6", "mine.toml"))), 2, "found no file `mine.toml`")

    def test_what_an_engine_cannot_do_is_no_slip(self):
        for scene, method in (("bounce-e0.8", "atwood/rk4"), ("bounce-e0.8", "atwood/rk4{gravity=direct}"),
                              ("bounce-e0.8", "atwood/rk4+penalty{overlap=1e-4}"),  # beyond its limit of stability
                              ("lorenz", "ode/default{erp=0.1}"), ("bounce-e0.8", "ode/default@float{erp=0.1}")):
            result = self.expect(self.run_in("trace", scene, "--method", method), 1, "unsupported")  # 2 is for a slip
            self.assertEqual(result.stdout, "")
        smooth = self.expect(self.run_in("trace", "ballistic", "--method", "atwood/rk4+event{restitution=poisson}"), 0)
        self.assertTrue(smooth.stdout, smooth.stderr)  # nothing touches there, and no setting is in the way

    def test_a_sweep_over_a_response(self):
        study = "id = 'mine'\n[[cells]]\nscenarios = ['bounce-e0.8']\nsteps = [240]\nmethods = ['atwood/rk4+event', 'ode/default']\nsweep = { %s }\n"
        data = json.loads(self.run_in("run", self.path("study.toml", study % "restitution = ['newton', 'poisson']"), "--no-timing", "--json").stdout)
        self.assertEqual({row["method"] for row in data["rows"]},
                         {"atwood/rk4+event{restitution=newton}", "atwood/rk4+event{restitution=poisson}", "ode/default"})
        self.expect(self.run_in("run", self.path("study.toml", study % "restitutoin = ['newton']")), 2, "study `mine`", "sweep", "`restitutoin`",
                    "atwood/rk4+event, ode/default")

    def test_words(self):
        for steps in ("0", "-60", "7"):
            words = "a multiple of the 60 samples" if steps == "7" else f"--steps: found `{steps}`; expected a whole number of steps from 1"
            self.expect(self.run_in("run", *SMALL[:-2], steps, "--no-timing"), 2, words)
            self.expect(self.run_in("trace", "kepler-e0.6", "--method", "atwood/rk4", "--steps", steps), 2, words)
        self.expect(self.run_in("contacts", "bounce-e0.8", "--engine", "mujoco"), 2, "mujoco answers no questions about contacts", "bullet64")
        self.expect(self.run_in("contacts", "bounce-e0.8", "--engine", "havok"), 2, "no such engine or file")
        self.expect(self.run_in("contacts", "--help"), 0, "unit-size")
        self.expect(self.run_in("compare", "atwood/rk4"), 2, "two methods or more")


GOALS = """[[goal]]
id = "easy"
title = "An easy one"
scenario = "kepler-e0.6"
metric = "error-state-end"
error = 1e-6
evaluations = 3000
steps = [120, 240, 480, 960]
tolerances = [1e-8, 1e-10]
methods = ["atwood/dopri5:tol", "atwood/rk4", "atwood/not-yet"]
rivals = ["cvode/adams:tol"]

[[goal]]
id = "hard"
scenario = "kepler-e0.6"
metric = "error-state-end"
error = 1e-12
evaluations = 10
steps = [120]
methods = ["atwood/rk4"]
uncounted = ["atwood/dopri5"]

[[goal]]
id = "kept"
scenario = "kepler-e0.6"
metric = "energy-max"
error = 1e-3
samples = 60
steps = [240]
methods = ["atwood/leapfrog"]
"""


class Goals(Case):
    def test_reached_or_not_beside_the_best_rival(self):
        words = ("bench", "goals", "--goals", self.path("goals.toml", GOALS))
        data = json.loads(self.expect(self.run_in(*words, "--no-timing", "--json"), 0).stdout)
        easy, hard, kept = data["goals"]
        self.assertTrue(easy["reached"])
        self.assertEqual(easy["why"], "")
        self.assertEqual(easy["ours"]["method"], "atwood/dopri5:1e-08")
        self.assertLessEqual(easy["ours"]["error"], 1e-6)
        self.assertEqual(easy["rival"]["method"], "cvode/adams:1e-10")
        self.assertAlmostEqual(easy["ratio"], easy["rival"]["evaluations"] / easy["ours"]["evaluations"], places=4)
        self.assertFalse(hard["reached"])
        self.assertIn("times too large", hard["why"])
        self.assertEqual(hard["uncounted"]["method"], "atwood/dopri5")  # nearer, and still no goal
        self.assertLess(hard["uncounted"]["error"], hard["ours"]["error"])
        self.assertIsNone(hard["rival"])
        self.assertTrue(kept["reached"])
        # No error is called reached for passing through zero at the end: the last quarter stands beside it.
        self.assertTrue(easy["ours"]["error"] <= easy["ours"]["last_quarter"] <= 10 * easy["wanted_error"])
        self.assertNotIn("last_quarter", kept["ours"])  # not an error at the end
        self.assertNotIn("machine", easy)  # nothing was timed
        result = self.expect(self.run_in(*words), 0, "reached      An easy one", "NOT REACHED  hard", "2 of 3 goals reached", "rival      none", "atwood/rk4, 120 steps")
        self.assertNotIn("\x1b", result.stdout)
        self.assertRegex(result.stdout, r"machine    \d+ of \d+ timings interrupted, \d+\.\d\d to \d+\.\d\d GHz")
        with open(self.path("atwood-out/bench.json")) as file:
            kept_goals = json.load(file)["goals"]
        self.assertGreater(kept_goals[0]["machine"]["timings"], 15)
        self.assertAlmostEqual(kept_goals[0]["ours"]["last_quarter"] / easy["ours"]["last_quarter"], 1, places=5)
        # The report of a run shows them, with the floor of double beside an error at the end.
        self.expect(self.run_in("run", *SMALL, "-o", "json:r.json"), 0)
        with open(self.path("r.json")) as file:
            shown = json.load(file)["goals"]
        self.assertEqual([g["id"] for g in shown], ["easy", "hard", "kept"])
        self.assertTrue(1e-16 < easy["ours"]["floor"] < 1e-12)
        self.assertEqual(shown[0]["ours"]["floor"], easy["ours"]["floor"])
        self.assertNotIn("floor", shown[2]["ours"])

    def test_an_error_that_vanishes_at_the_end_alone_reaches_no_goal(self):
        # Near a turning point an error of the phase, 6e-4 here, changes the position by its square only.
        goals = self.path("turning.toml", """[[goal]]
id = "turning"
scenario = "oscillator"
metric = "error-position-end"
error = 1e-5
evaluations = 1000
t_end_s = 7.85
steps = [600]
methods = ["atwood/leapfrog"]
""")
        goal = json.loads(self.expect(self.run_in("bench", "goals", "--goals", goals, "--no-timing", "--json"), 0).stdout)["goals"][0]
        self.assertLess(goal["ours"]["error"], 1e-5)
        self.assertAlmostEqual(goal["ours"]["last_quarter"] / 4.03e-4, 1, delta=0.1)
        self.assertFalse(goal["reached"])
        self.assertFalse(goal["ours"]["accurate"])
        self.assertIn("over the last quarter", goal["why"])

    def test_slips_of_the_pen(self):
        bad = self.path("bad.toml", GOALS.replace("evaluations = 10", 'time = "10 parsecs"'))
        self.expect(self.run_in("bench", "goals", "--goals", bad), 2, "10 parsecs", "ns, us, ms or s")
        self.expect(self.run_in("bench", "goals", "--goals", self.path("b.toml", GOALS.replace("metric =", "metrics ="))), 2, "b.toml:5:", "metrics")
        self.expect(self.run_in("bench", "goals", "--goal", "kepler-10-tim"), 2, "kepler-10-time")
        self.expect(self.run_in("bench", "goals", "--goals", "nowhere.toml"), 2, "nowhere.toml")


class Advising(Case):
    def advice(self, *words, code=0):
        return json.loads(self.expect(self.run_in("advise", *words, "--json"), code).stdout)

    def test_an_error(self):
        advice = self.advice("kepler-e0.3", "--error", "1e-7")
        self.assertTrue(advice["found"])
        self.assertEqual(advice["metric"], "error-position-max")
        best, next_ = advice["advice"], advice["runner_up"]
        self.assertLessEqual(best["error"] * advice["safety"], 1e-7)
        self.assertLessEqual(next_["error"] * advice["safety"], 1e-7)
        self.assertNotEqual(best["method"].split(":")[0], "atwood/leapfrog")
        self.assertLess(advice["finer"]["error"], best["error"])
        self.assertTrue(advice["left_out"])
        self.assertIn("closed form", advice["truth"])
        # The printed command runs that very cell, and finds that very error.
        words = advice["rerun"].replace("'", "").split()[1:]
        data = json.loads(self.run_in(*words, "--no-timing", "--json").stdout)
        rows = [r for r in data["rows"] if r["metric"] == "error-position-max"]
        self.assertEqual([r["value"] for r in rows], [best["error"]])

    def test_a_budget_and_another_metric(self):
        for _ in range(3):  # a busy machine may take longer when the winner is timed once more
            advice = self.advice("symmetric-top", "--budget", "1ms", "--metric", "attitude")
            if advice["advice"]["seconds"] <= 1e-3:
                break
            shutil.rmtree(os.path.join(self.folder.name, "atwood-out"), ignore_errors=True)
        self.assertEqual(advice["unit"], "rad")
        self.assertLessEqual(advice["advice"]["seconds"], 1e-3)
        self.assertLess(advice["advice"]["error"], 1e-9)
        for out in advice["left_out"]:
            if "no order" in out["reason"]:
                self.assertIn("dprkn", out["methods"])  # made for forces without torque
        result = self.expect(self.run_in("advise", "symmetric-top", "--budget", "1ms", "--metric", "attitude"), 0, "asked", "use", "evidence", "margin", "runner-up", "rerun", "left out")
        self.assertNotIn("\x1b", result.stdout + result.stderr)

    def test_scenes_without_a_truth(self):
        path = self.path("mine.toml", SCENE.replace('kind = "extended"', 'kind = "none"'))
        advice = self.advice(path, "--error", "1e-9")
        self.assertIn("extended precision", advice["truth"])
        self.assertIn("mine.toml", advice["rerun"])
        with open(os.path.join(ROOT, "validation/scenarios/oblique-rough.toml")) as file:
            text = file.read()
        ball = "shape.sphere = { radius_m = 0.125 }"  # of uneven moments: the slip turns, and no truth follows that
        text = text.replace(ball, ball + "\ninertia_kg_m2 = [0.00625, 0.00625, 0.007]", 1)
        text = text.replace('id = "oblique-rough"', 'id = "rough"').replace('id     = "oblique-rough"', 'id     = "rough"')
        rough = self.path("rough.toml", text[:text.index("[truth]")] + '[truth]\nkind = "none"\n' + text[text.index("[[invariant]]"):])
        advice = self.advice(rough, "--error", "1e-6")
        self.assertIn("self-convergence", advice["truth"])
        self.assertGreater(advice["advice"]["bar"], 0)
        self.assertIn("+event", advice["advice"]["method"])

    def test_an_error_that_no_method_reaches_is_reported(self):
        self.expect(self.run_in("advise", "kepler-e0", "--error", "1e-25", "--time", "2"), 1, "nothing that was tried", "did not reach the error")

    def test_slips_of_the_pen(self):
        for words in (["kepler-e0"], ["kepler-e0", "--error", "1e-8", "--budget", "1ms"], ["kepler-e0", "--error", "-1"], ["kepler-e0", "--error", "1e-8parsec"],
                      ["kepler-e0", "--budget", "16"], ["kepler-e0", "--error", "1e-8", "--metric", "colour"], ["kepler-e0", "--error", "1e-8", "--metric", "attitude"]):
            self.expect(self.run_in("advise", *words), 2)
        self.expect(self.run_in("advise", "keppler-e0", "--error", "1e-8"), 2, "kepler-e0")


class BadScenes(Case):
    def error(self, text, *words):
        path = self.path("bad.toml", text)
        for command in (["describe", path], ["run", "--scenario", path], ["trace", path, "--method", "truth"]):
            result = self.expect(self.run_in(*command), 2, "bad.toml", *words)
            self.assertEqual(result.stdout, "")

    def test_each_is_named_with_its_line(self):
        self.error(SCENE.replace("mass_kg", "mas_kg"), "mas_kg", ":13:")
        self.error(SCENE.replace("mass_kg = 2.0", "mass_kg = -2.0"), ":13:", "-2")
        self.error(SCENE.replace("[1, 0, 2]", "[1, nan, 2]"), ":15:", "nan")
        self.error(SCENE.replace("[1, 0, 2]", "[1, inf, 2]"), ":15:", "inf")
        self.error(SCENE[:SCENE.index("kind = ") + 9])  # truncated inside a string
        self.error(SCENE.replace("samples = 64", "samples = 60"), "samples")
        self.error("")

    def test_a_family_is_told_by_its_members(self):
        self.expect(self.run_in("describe", "cradle"), 2, "nearest: cradle-apart-1, cradle-apart-2, cradle-apart-3")
        self.expect(self.run_in("describe", "kepler-e0.6x"), 2, "nearest: kepler-e0.6,")
        result = self.expect(self.run_in("run", "--scenario", "mesh-floor", "--method", "atwood/rk4+event", "--steps", "90",
                                         "--no-timing", "-o", "csv:rows.csv"), 0)
        with open(self.path("rows.csv"), newline="") as file:
            ran = {row["scenario"] for row in csv.DictReader(file)}
        self.assertEqual(ran, {"mesh-floor-roll", "mesh-floor-slide"}, result.stdout)

    def test_missing_files(self):
        self.expect(self.run_in("describe", "nowhere.toml"), 2, "nowhere.toml")
        self.expect(self.run_in("describe", self.here + "/"), 2)
        self.expect(self.run_in("check", "nowhere.csv", "--scenario", "kepler-e0.6"), 2, "nowhere.csv")


class Tracing(Case):
    def test_truth_and_a_method(self):
        truth = list(csv.DictReader(io.StringIO(self.expect(self.run_in("trace", "kepler-e0.6", "--method", "truth"), 0).stdout)))
        self.assertGreater(len(truth[-1]["px_m"]), 30)
        self.assertLess(float(truth[-1]["px_m_bar"]), 1e-20)
        run = list(csv.DictReader(io.StringIO(
            self.expect(self.run_in("trace", "kepler-e0.6", "--method", "atwood/rk4", "--steps", "7680"), 0).stdout)))
        self.assertEqual(len(run), len(truth))
        self.assertLess(abs(float(run[-1]["px_m"]) - float(truth[-1]["px_m"])), 1e-7)
        self.assertNotEqual(run[-1]["px_m"], truth[-1]["px_m"])

    def test_a_truth_takes_any_number_of_samples(self):
        """It has no steps that they would have to divide."""
        rows = list(csv.DictReader(io.StringIO(
            self.expect(self.run_in("trace", "pendulum-1", "--method", "truth", "--samples", "7"), 0).stdout)))
        self.assertEqual(len(rows), 8)
        self.assertAlmostEqual(float(rows[1]["t_s"]) * 7, float(rows[7]["t_s"]), delta=1e-14)
        self.expect(self.run_in("trace", "pendulum-1", "--method", "atwood/rk4", "--samples", "7", "--steps", "160"), 2,
                    "--steps 160: expected a multiple of the 7 samples")
        for method in ("truth", "atwood/rk4"):
            self.expect(self.run_in("trace", "pendulum-1", "--method", method, "--samples", "1000001", "--steps", "1000001"), 2,
                        "--samples 1000001: expected at most 1000000")

    def test_events(self):
        events = list(csv.DictReader(io.StringIO(
            self.expect(self.run_in("trace", "bounce-e0.5", "--method", "truth", "--events"), 0).stdout)))
        self.assertEqual(events[0]["kind"], "impact")
        self.assertTrue(events[0]["t_s_bar"])

    def test_json_holds_what_the_csv_holds(self):
        words = ("trace", "bounce-e0.5", "--method", "truth")
        for more in ((), ("--events",)):
            table = list(csv.DictReader(io.StringIO(self.expect(self.run_in(*words, *more), 0).stdout)))
            objects = json.loads(self.expect(self.run_in(*words, *more, "--json"), 0).stdout, parse_float=str, parse_int=str)
            self.assertEqual(table, objects)

    def test_every_column_of_json_has_one_type(self):
        """Whatever the digits of its values are: 0.0027046041799436774 has 20 with its zeros; a truth's have up to 36."""
        scene = self.path("mine.toml", SCENE.replace('"stone"', '"1"'))
        for words in (("trace", "double-pendulum-regular", "--method", "atwood/rk4"),
                      ("trace", "double-pendulum-regular", "--method", "truth"), ("trace", scene, "--method", "truth"),
                      ("trace", "double-pendulum-regular", "--method", "atwood/rk4", "--joints"),
                      ("trace", "double-pendulum-regular", "--method", "truth", "--joints"),
                      ("derivatives", "double-pendulum-regular"), ("derivatives", "double-pendulum-regular", "--ladder")):
            rows = json.loads(self.expect(self.run_in(*words, "--json"), 0).stdout, parse_int=float)
            for column in rows[0]:
                text = column in ("body", "joint", "source", "of", "by", "by_name", "from")
                for row in rows:
                    if row[column] != "" or text:  # a value that is not reported
                        self.assertIs(type(row[column]), str if text else float, (words, column, row[column]))

    def test_a_scene_of_ones_own(self):
        for kind in ("extended", "cvode"):
            path = self.path("mine.toml", SCENE.replace("extended", kind))
            rows = list(csv.DictReader(io.StringIO(self.expect(self.run_in("trace", path, "--method", "truth"), 0).stdout)))
            z = 1 + 2 * 1.0 - 9.8 / 2
            self.assertLess(abs(float(rows[-1]["pz_m"]) - z), 1e-15 * 10 + 3 * float(rows[-1]["pz_m_bar"]))


class Running(Case):
    def test_a_run_writes_what_it_says(self):
        result = self.expect(self.run_in("run", "--scenario", "kepler-e0.6", "--method", "atwood/rk4", "-o", "csv:rows.csv", "-o",
                                         "json:rows.json", "-o", "junit:v.xml", "-o", "markdown:r.md"), 0, "report.html")
        self.assertIn("PASS", result.stdout)
        with open(self.path("rows.csv"), newline="") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual(list(rows[0])[:10], ["scenario", "method", "steps", "h_s", "body", "t_s", "metric", "unit", "value", "truth_bar"])
        order = [row for row in rows if row["metric"] == "order-position"]
        self.assertEqual(len(order), 1)
        self.assertTrue(3.9 < float(order[0]["value"]) < 4.2)
        json.load(open(self.path("rows.json")))
        self.assertEqual(xml.parse(self.path("v.xml")).getroot().tag, "testsuites")
        self.assertNotIn("http-equiv=\"refresh", open(self.path("atwood-out/report.html")).read())

    def test_a_place_that_cannot_be_written_is_said_before_the_work(self):
        self.expect(self.run_in("run", *SMALL, "-o", "csv:nowhere/rows.csv"), 5, "nowhere/rows.csv")
        self.assertFalse(os.path.exists(self.path("atwood-out")))

    def test_no_store(self):
        self.expect(self.run_in("gate", *SMALL[:-1]), 1, "no store")
        self.expect(self.run_in("report", *SMALL[:-1]), 2, "no store")

    def test_the_second_run_does_nothing(self):
        self.expect(self.run_in("run", *SMALL), 0)
        self.expect(self.run_in("run", *SMALL), 0, "in the store already")

    def test_a_scene_of_ones_own(self):
        path = self.path("mine.toml", SCENE)
        self.expect(self.run_in("run", "--scenario", path, "--no-timing"), 0, "cells")
        gate = '[[gate]]\nscenario = "mine"\nmethod = "atwood/explicit-euler"\nmetric = "error-position-end"\nmax = 1e-30\nreason = "no"\n'
        result = self.expect(self.run_in("run", "--scenario", path, "--no-timing", "--tolerances", self.path("g.toml", gate)), 1)
        command = next(line for line in result.stdout.splitlines() if line.strip().startswith("./atwood run")).split()[1:]
        self.expect(self.run_in(*command, "--no-timing"), 1, "FAIL")

    def test_scenes_of_the_manual_run_as_they_are_printed(self):
        blocks = []
        for page in ("add-a-scene.md", "contact.md"):
            with open(os.path.join(ROOT, "docs", page)) as file:
                blocks += file.read().split("```toml\n")[1:]
        scenes = [block.split("```")[0] for block in blocks if block.startswith("id     = ")]
        self.assertEqual(len(scenes), 2)
        for scene, method in zip(scenes, ("atwood/dopri5:1e-10", "atwood/rk4+event")):
            path = self.path(scene.split('"')[1] + ".toml", scene)
            data = json.loads(self.expect(self.run_in("run", "--scenario", path, "--method", method, "--no-timing", "--json"), 0).stdout)
            errors = [row["value"] for row in data["rows"] if row["metric"] == "error-position-end"]
            self.assertTrue(errors and max(errors) < 1e-7, errors)
        rolling = scenes[1].replace("# rolling_friction_m", "rolling_friction_m")
        self.expect(self.run_in("trace", self.path("rolling.toml", rolling), "--method", "truth"), 1, "unsupported", "rolling friction")
        end = self.expect(self.run_in("trace", self.path("rolling.toml"), "--method", "atwood/rk4+event"), 0).stdout.splitlines()[-2]
        self.assertLess(abs(float(end.split(",")[9])), 1e-12)  # it stands

    def test_a_scene_of_ones_own_reruns_by_its_file(self):
        path = self.path("mine.toml", SCENE)
        words = ["--scenario", path, "--method", "atwood/explicit-euler", "--no-timing"]
        self.run_in("run", *words)
        self.expect(self.run_in("bless", *words[:-1], "--reason", "first"), 0)
        with open(self.path("atwood-baseline.tsv")) as file:
            lines = file.read().splitlines()
        at = [i for i, line in enumerate(lines) if "error-position-end" in line][0]
        cells = lines[at].split("\t")
        cells[4] = str(float(cells[4]) / 2)  # it was twice as good once
        lines[at] = "\t".join(cells)
        self.path("atwood-baseline.tsv", "\n".join(lines) + "\n")
        changes = json.loads(self.expect(self.run_in("gate", *words[:-1], "--baseline", "atwood-baseline.tsv", "--json"), 1).stdout)
        self.assertTrue(changes)
        for change in changes:
            self.assertIn("--scenario " + path + " ", change["rerun"])

    def test_gate_bless_baseline(self):
        self.expect(self.run_in("run", *SMALL), 0)
        self.expect(self.run_in("gate", *SMALL[:-1], "--baseline", "none.tsv"), 4, "no baseline")
        self.expect(self.run_in("bless", *SMALL[:-1], "--reason", ""), 2)
        self.expect(self.run_in("bless", *SMALL[:-1], "--reason", "first", "--baseline", "b.tsv"), 0, "b.tsv")
        self.expect(self.run_in("gate", *SMALL[:-1], "--baseline", "b.tsv"), 0, "0 regressions")
        with open(self.path("b.tsv")) as file:
            lines = file.read().splitlines()
        worse = []
        for line in lines:
            if "error-position-end" in line and not line.startswith("#"):
                words = line.split("\t")
                words = [repr(float(w) * 0.5) if i == 4 else w for i, w in enumerate(words)]
                line = "\t".join(words)
            worse.append(line)
        self.path("b.tsv", "\n".join(worse) + "\n")
        self.expect(self.run_in("gate", *SMALL[:-1], "--baseline", "b.tsv"), 1, "regression", "./atwood run")

    def test_own_tolerances(self):
        gate = '[[gate]]\nscenario = "kepler-e0.6"\nmethod = "atwood/rk4"\nmetric = "error-position-end"\nmax = 1e-30\nreason = "too tight"\n'
        path = self.path("tight.toml", gate)
        self.expect(self.run_in("run", *SMALL, "--tolerances", path, "--junit", "v.xml"), 1, "allowed <= 1e-30",
                    "./atwood run --scenario kepler-e0.6", "--tolerances " + path)
        verdicts = open(self.path("v.xml")).read()
        self.assertIn("<failure", verdicts)
        self.assertIn("too tight", verdicts)
        self.expect(self.run_in("run", *SMALL, "--tolerances", self.path("odd.toml", gate.replace("max", "maxx"))), 2, "maxx")

    def test_check(self):
        trace = self.expect(self.run_in("trace", "kepler-e0.6", "--method", "atwood/rk4", "--steps", "7680"), 0).stdout
        self.path("run.csv", trace)
        self.expect(self.run_in("check", "run.csv", "--scenario", "kepler-e0.6", "--max", "error-position-end=1e-6"), 0)
        self.expect(self.run_in("check", "run.csv", "--scenario", "kepler-e0.6", "--max", "error-position-end=1e-16"), 1)
        self.path("bad.csv", trace.replace("px_m", "qx_m"))
        self.expect(self.run_in("check", "bad.csv", "--scenario", "kepler-e0.6"), 2, "px_m")
        lines = trace.splitlines(keepends=True)
        for name, text, words in (("ragged", "".join(lines[:5] + ["0.5\n"] + lines[5:]), (":6:", "15")),
                                  ("half-a-spin", "".join(line.rsplit(",", 2)[0] + "\n" for line in lines), ("wy_rad_per_s",)),
                                  ("falling", "".join(lines[:5] + lines[3:]), ("increasing",))):
            self.expect(self.run_in("check", self.path(name + ".csv", text), "--scenario", "kepler-e0.6"), 2, name, *words)
        self.expect(self.run_in("check", "run.csv", "--scenario", "kepler-e0.6", "--max", "bogus=1"), 2, "bogus")
        lost = self.path("nan.csv", "".join(lines[:9]) + "".join(",".join(["nan" if i == 2 else field for i, field in enumerate(
            line.split(","))]) for line in lines[9:]))
        self.expect(self.run_in("check", lost, "--scenario", "kepler-e0.6", "--max", "error-position-end=1"), 1, "not finite",
                    "./atwood check")


WORKER = """#!/usr/bin/env python3
import json, sys, time, os
for line in sys.stdin:
    request = json.loads(line)
    if request["request"] == "hello":
        print(json.dumps({"engine": "odd", "version": "1", "scalar": "double", "methods": [{"id": "odd/one", "doc": "odd"}]}), flush=True)
        continue
    %s
"""


class OddEngines(Case):
    def odd(self, body, *words, code=3, limit="2"):
        path = self.path("odd.py", WORKER % body, 0o755)
        result = self.run_in("run", "--engine", path, "--method", "odd/one", "--scenario", "ballistic", "--steps", "120",
                             "--limit", limit, "-o", "csv:rows.csv")
        self.expect(result, code)
        text = open(self.path("rows.csv")).read()
        for word in words:
            self.assertIn(word, text)

    def test_dies(self):
        self.odd("sys.stderr.write('out of luck'); sys.stderr.flush(); os._exit(9)", "crashed", "out of luck")

    def test_hangs(self):
        self.odd("time.sleep(1000)", "timeout")

    def test_a_cell_that_failed_is_told_with_its_command(self):
        path = self.path("odd.py", WORKER % "os._exit(9) if request['steps'] > 120 else time.sleep(1000)", 0o755)
        gate = '[[gate]]\nscenario = "ballistic"\nmethod = "atwood/rk4"\nmetric = "error-position-end"\nmax = 1\nreason = "wide"\n'
        words = ["run", "--engine", path, "--method", "odd/one", "--method", "atwood/rk4", "--scenario", "ballistic", "--limit", "0.5",
                 "--no-timing", "--tolerances", self.path("wide.toml", gate)]
        for steps, why in (("120", "timeout: "), ("240", "crashed: ")):
            result = self.expect(self.run_in(*words, "--steps", steps), 3, "odd/one", why, "1 pass, 1 fail")
            self.assertNotIn("PASS", result.stdout)
            command = next(line for line in result.stdout.splitlines() if line.strip().startswith("./atwood run"))
            self.assertIn("--method odd/one --steps " + steps, command)
            self.assertIn("--limit 0.5", command)
            self.expect(self.run_in(*command.split()[1:]), 3, why)
            self.assertIn("1 fail", self.expect(self.run_in("gate", *words[1:-5], *words[-2:], "--steps", steps), 3, why).stdout)

    def test_a_block_of_a_study_has_a_limit_of_its_own(self):
        path = self.path("odd.py", WORKER % "time.sleep(1000)", 0o755)
        study = self.path("study.toml", "id = 'slow'\n[[cells]]\nscenarios = ['ballistic']\nsteps = [120]\nmethods = ['odd/one']\nlimit = 0.25\n")
        words = ("run", study, "--engine", path, "--method", "odd/one")
        self.expect(self.run_in(*words), 3, "0.25 s")
        self.expect(self.run_in(*words, "--limit", "0.5"), 3, "0.5 s")

    def test_talks_garbage(self):
        self.odd("print('%% what?', flush=True)" .replace("%%", "%%%%"), "crashed")

    def test_says_unsupported(self):
        self.odd("print(json.dumps({'cell': request['cell'], 'done': {'status': 'unsupported', 'reason': 'no stones'}}), flush=True)",
                 "unsupported", "no stones", code=0)

    def test_will_not_start(self):
        path = self.path("dead.py", "#!/usr/bin/env python3\nraise SystemExit(1)\n", 0o755)
        self.expect(self.run_in("run", "--engine", path, "--scenario", "ballistic"), 3, "dead.py", "answering `hello`")
        path = self.path("plain.txt", "no program\n")
        self.expect(self.run_in("run", "--engine", path, "--scenario", "ballistic"), 2, "not executable")

    def test_python_example_equals_symplectic_euler(self):
        worker = os.path.join(ROOT, "reference/your_engine/worker.py")
        for scenario, steps in (("ballistic", "120"), ("kepler-e0.6", "960")):
            rows = []
            for words in (["--method", "atwood/symplectic-euler"], ["--engine", worker, "--method", "python/symplectic-euler"]):
                result = self.run_in("run", "--scenario", scenario, "--steps", steps, "--no-timing", "-o", "csv:rows.csv", *words)
                self.expect(result, 0)
                with open(self.path("rows.csv"), newline="") as file:
                    rows.append({r["metric"]: r["value"] for r in csv.DictReader(file) if r["metric"].startswith("error-")})
            self.assertEqual(set(rows[0]), set(rows[1]))
            self.assertIn("error-position-end", rows[0])
            for metric in rows[0]:
                self.assertLess(abs(float(rows[0][metric]) - float(rows[1][metric])), 1e-12, metric)


class BadLuck(Case):
    def rows_but_for_the_run(self):
        with open(self.path("rows.csv")) as file:
            return sorted(tuple(value for key, value in row.items() if key != "run_id") for row in csv.DictReader(file))

    def test_interrupt_keeps_what_is_done_and_resumes(self):
        words = ["run", "--scenario", "kepler-*", "--method", "atwood/rk4", "--method", "atwood/heun", "--no-timing", "-o", "csv:rows.csv"]
        for stop, code in ((signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGKILL, -9)):
            process = subprocess.Popen([ATWOOD, *words], cwd=self.here, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
            while not os.path.exists(self.path("atwood-out/store.db")) and process.poll() is None:
                time.sleep(0.02)
            time.sleep(0.4)
            process.send_signal(stop)
            process.communicate(timeout=60)
            self.assertIn(process.returncode, (code, -stop, 0, 1))  # -stop: before the run's first cell
        self.run_in(*words)
        resumed = self.rows_but_for_the_run()
        os.rename(self.path("atwood-out"), self.path("old"))
        self.run_in(*words)
        self.assertEqual(resumed, self.rows_but_for_the_run())

    def test_full_disk(self):
        def small_files():
            resource.setrlimit(resource.RLIMIT_FSIZE, (60_000, 60_000))
        result = self.run_in("run", *SMALL, preexec_fn=small_files)
        self.expect(result, 5)
        self.assertTrue(result.stderr.strip())
        self.assertFalse(os.path.exists(self.path("atwood-out/report.html")))
        self.expect(self.run_in("run", *SMALL), 0)

    @unittest.skipIf(os.geteuid() == 0 and not os.path.exists("/usr/bin/setpriv"), "root may write everywhere")
    def test_a_store_in_a_folder_for_reading_only(self):
        self.expect(self.run_in("run", *SMALL), 0)
        os.chmod(self.here, 0o755)
        os.chmod(self.path("atwood-out"), 0o555)
        as_other = ["setpriv", "--reuid=65534", "--clear-groups"] if os.geteuid() == 0 else []
        words = ["gate", *SMALL[:-1], "--tolerances", self.path("g.toml", '[[gate]]\nscenario = "kepler-e0.6"\nmethod = "atwood/rk4"\n'
                                                                'metric = "error-position-end"\nmax = 1\nreason = "wide"\n')]
        result = subprocess.run([*as_other, ATWOOD, *words], cwd=self.here, text=True, capture_output=True)
        os.chmod(self.path("atwood-out"), 0o755)
        self.expect(result, 0, "1 pass")

    def test_store_that_is_no_store(self):
        os.mkdir(self.path("atwood-out"))
        self.path("atwood-out/store.db", "this is no database, it is a letter to a friend\n" * 100)
        self.expect(self.run_in("run", *SMALL), 5, "store.db")
        self.path("file", "x")
        self.expect(self.run_in("run", *SMALL, "--out", "file/below"), 5, "file/below")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=1)
