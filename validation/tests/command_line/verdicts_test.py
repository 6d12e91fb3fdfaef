"""Gates, baselines and endings of cells, as a job in continuous integration meets them: nothing passes that should not."""
import json
import os
import resource
import shlex
import subprocess
import sys
import unittest
import xml.etree.ElementTree as xml

from case import ATWOOD, Case, thrown_stone

SMALL = ["--scenario", "kepler-e0.6", "--method", "atwood/rk4", "--steps", "960"]

SCENE = thrown_stone("[64, 128]") + '[[invariant]]\nquantity = "energy"\n'

# Answers as `BODY(k)` says for each sample, and ends as STATUS says.
WORKER = """#!/usr/bin/env python3
import json, os, sys
for line in sys.stdin:
    request = json.loads(line)
    if request["request"] == "hello":
        print(json.dumps({"engine": "odd", "version": "1", "scalar": "double", "fingerprint": "1",
                          "methods": [{"id": "odd/one", "doc": "odd", "claims": {"point-mass": 2}}]}), flush=True)
        continue
    n, t_end = request["samples"], request["t_end_s"]
    %s
    print(json.dumps({"cell": request["cell"], "done": {"status": status, "reason": "", "steps_taken": request["steps"],
                      "rate_evaluations": 0, "busy_ns": []}}), flush=True)
"""
FALLS = """status = "ok"
    h = t_end / request["steps"]
    for k in range(n + 1):
        t = t_end * k / n
        x = [t, 0, 1 + 2 * t - 4.9 * t * t + h * t]  # an error of first order
        print(json.dumps({"cell": request["cell"], "t_s": t, "bodies": [x + [1, 0, 0, 0] + [1, 0, 2 - 9.8 * t] + [0, 0, 0]]}), flush=True)
"""
NAN = """status = "ok"
    start = [0, 0, 1] + [1, 0, 0, 0] + [1, 0, 2] + [0, 0, 0]
    for k in range(n + 1):
        print(json.dumps({"cell": request["cell"], "t_s": t_end * k / n, "bodies": [["nan"] * 13 if k else start]}), flush=True)
"""
DIVERGES = """status = "diverged"
"""
DIES = """os._exit(9)
"""


def gate(scenario="kepler-e0.6", method="atwood/rk4", metric="error-position-end", limit="max = 1", more=""):
    return f'[[gate]]\nscenario = "{scenario}"\nmethod = "{method}"\nmetric = "{metric}"\n{limit}\n{more}\nreason = "a test"\n'


class Verdicts(Case):
    def run_in(self, *words, env=None, **more):
        clean = {k: v for k, v in os.environ.items() if not k.startswith(("ATWOOD_CALLED_AS", "GITHUB_"))}
        return super().run_in(*words, env=clean | (env or {}), **more)

    def edit(self, name, change):
        with open(self.path(name)) as file:
            text = file.read()
        self.path(name, change(text))


class Unmatched(Verdicts):
    """A gate of the user's own that matches nothing is not run, and the nearest name is told."""

    def test_each_part_of_a_gate(self):
        self.expect(self.run_in("run", *SMALL, "--no-timing"), 0)
        for text, *words in ((gate(scenario="keppler-e0.6"), "scenario `keppler-e0.6`", "kepler-e0.6"),
                             (gate(method="atwood/rk44"), "method `atwood/rk44`", "atwood/rk4"),
                             (gate(method="atwood/rk4+evnt"), "method `atwood/rk4+evnt`"),
                             (gate(scenario="ballistic", method="atwood/rk4+event"), "does not run on `ballistic`"),
                             (gate(metric="error-positon-end"), "`error-positon-end`", "nearest: error-position-end"),
                             (gate(more="steps = 961"), "steps = 961", "nearest: 960"),
                             (gate(limit='within_claim = "rotation"', metric="order-position"), "no ladder", 'claim = "rotation"'),
                             (gate(limit='max_ratio = { to = "ode/defualt", value = 1 }'), "ode/defualt"),
                             ('study = "defualt"\n' + gate(), "about the study `defualt`", "nearest: default"),
                             ('study = "contact"\n' + gate(), "about the study `contact`, and this is `default`")):
            path = self.path("g.toml", gate() + text if not text.startswith("study") else text)
            for words_of_call in (["gate", *SMALL], ["run", *SMALL, "--no-timing"]):
                self.expect(self.run_in(*words_of_call, "--tolerances", path), 1, "1 not run", *words)

    def test_what_a_filter_leaves_out_is_counted(self):
        path = self.path("g.toml", gate() + gate(method="atwood/heun") + gate(scenario="ballistic") + gate(more="steps = 240") +
                         gate(metric="order-position", limit="within = [3.9, 4.2]"))
        for command in ("run", "gate"):
            extra = ["--no-timing"] if command == "run" else []
            self.expect(self.run_in(command, *SMALL, "--tolerances", path, *extra), 0, "1 gate: 1 pass", "4 gates left out by the filter.")

    def test_a_gate_on_all_scenes_says_nothing_of_one_without_its_figure(self):
        words = ["contact", "--scenario", "bounce-e0", "--method", "atwood/*"]
        self.expect(self.run_in("run", *words, "--no-timing"), 0, "0 not run")
        self.expect(self.run_in("gate", *words), 0, "0 not run")

    def test_without_a_filter_of_a_study_of_ones_own(self):
        study = self.path("s.toml", 'id = "mine"\n[[cells]]\nscenarios = ["kepler-e0.6"]\nmethods = ["atwood/rk4"]\nsteps = [960]\ntiming = false\n')
        path = self.path("g.toml", gate())
        self.expect(self.run_in("run", study, "--tolerances", path), 0, "1 pass")
        self.path("g.toml", gate() + gate(method="atwood/heun"))
        self.expect(self.run_in("gate", study, "--tolerances", path), 1, "matches no method of the study `mine`", "the study has atwood/rk4")

    def test_gates_are_read_before_the_work(self):
        self.expect(self.run_in("run", *SMALL, "--tolerances", self.path("g.toml", "[[gate]]\n")), 2, "g.toml")
        self.expect(self.run_in("run", *SMALL, "--baseline", self.path("b.tsv", "letter\n")), 2, "b.tsv:1")
        self.expect(self.run_in("run", *SMALL, "--baseline", "none.tsv"), 4, "none.tsv")
        self.assertFalse(os.path.exists(self.path("atwood-out/store.db")))


class Endings(Verdicts):
    def odd(self, body, *words):
        path = self.path("odd.py", WORKER % body, 0o755)
        return self.run_in("run", "--engine", path, "--scenario", self.path("mine.toml", SCENE), "--no-timing", "--limit", "20", *words)

    def test_an_engine_that_answers_nan_fails(self):
        for body, why in ((NAN, "not finite"), (DIVERGES, "diverged")):
            result = self.odd(body, "--method", "odd/*", "--junit", "v.xml", "-o", "json:v.json", "-o", "md:v.md", "--out", "out-" + why[:3])
            self.expect(result, 1, why, "FAIL")
            root = xml.parse(self.path("v.xml")).getroot()
            self.assertEqual((root.get("tests"), root.get("failures")), ("2", "2"))
            self.assertEqual(json.load(open(self.path("v.json")))["verdict"]["fail"], 2)
            self.assertIn("**Fail.**", open(self.path("v.md")).read())
            self.assertIn('class="word">Fail', open(self.path(f"out-{why[:3]}/report.html")).read())

    def test_a_crash_joins_the_verdict_everywhere(self):
        result = self.odd(DIES, "--method", "odd/one", "--junit", "v.xml", "--tolerances", self.path("g.toml", gate("mine", "odd/one", "energy-max")), "--json")
        self.assertEqual(result.returncode, 3, result.stderr)
        data = json.loads(result.stdout)
        self.assertGreaterEqual(data["verdict"]["fail"], 2)
        self.assertIn("crashed", {v["text"].split(":")[0] for v in data["verdicts"] if v["metric"] == "status"})
        names = [case.get("name") for case in xml.parse(self.path("v.xml")).getroot().iter("testcase")]
        self.assertIn("odd/one runs at 64 steps", names)
        self.assertIn('class="word">Fail', open(self.path("atwood-out/report.html")).read())

    def test_a_trace_that_ends_early_is_no_success(self):
        scene = self.path("mine.toml", SCENE)
        words = ["trace", scene, "--method", "odd/one", "--limit", "20"]
        partly = FALLS.replace('"ok"', '"diverged"').replace("range(n + 1)", "range(n // 2 + 1)")
        for body, code, told, lines in ((FALLS, 0, "", 65), (partly, 1, "atwood: diverged", 33), (DIVERGES, 1, "atwood: diverged", 0),
                                        ('status = "unsupported"\n', 1, "atwood: unsupported", 0), (NAN, 1, "atwood: not finite", None),
                                        (DIES, 3, "atwood: crashed", None)):
            result = self.expect(self.run_in(*words, "--engine", self.path("odd.py", WORKER % body, 0o755)), code, told)
            if lines is not None:
                self.assertEqual(max(0, len(result.stdout.splitlines()) - 1), lines, result.stdout)

    def test_a_block_may_allow_it_with_a_reason(self):
        path = self.path("odd.py", WORKER % DIVERGES, 0o755)
        text = 'id = "mine"\n[[cells]]\nscenarios = ["ballistic"]\nsteps = [120]\nmethods = ["odd/one"]\ntiming = false\n'
        allow = 'allow = ["diverged"]\nallow_reason = "It does."\n'
        for more, code, *words in (("", 1, "diverged"), (allow, 0, "diverged"), (allow.replace("diverged", "not finite"), 1, "diverged"),
                                   ('allow = ["diverged"]\n', 2, "allow_reason"), ('allow = ["divergent"]\n', 2, "divergent"),
                                   ('allow_reason = "x"\n', 2, "`allow`")):
            self.expect(self.run_in("run", self.path("s.toml", text + more), "--engine", path, "--scenario", "ballistic", "--method", "odd/one"),
                        code, *words)

    def test_ids_without_a_glob_must_end_well_and_globs_of_ours_need_not(self):
        words = ["run", "--scenario", "kepler-e0.6", "--steps", "240", "--no-timing"]
        self.expect(self.run_in(*words, "--method", "atwood/implicit-euler"), 1, "diverged")
        self.expect(self.run_in(*words, "--method", "atwood/implicit-eule?"), 0, "1 diverged")

    def test_a_claim_is_set_beside_what_is_observed(self):
        scene = SCENE.replace("[64, 128]", "[64, 128, 256, 512]")
        path = self.path("odd.py", WORKER % FALLS, 0o755)
        result = self.run_in("run", "--engine", path, "--method", "odd/one", "--scenario", self.path("mine.toml", scene), "--no-timing",
                             "-o", "json:v.json")
        self.expect(result, 0, "(claims 2)", "claims 2, observed 1.00 +/-", "below its claim")
        orders = json.load(open(self.path("v.json")))["claimed_orders"]
        self.assertEqual({o["claimed"] for o in orders}, {2})

    def test_quiet(self):
        result = self.expect(self.run_in("run", *SMALL, "--no-timing", "--quiet"), 0)
        self.assertEqual(len(result.stdout.splitlines()), 1, result.stdout)
        self.assertIn("report: atwood-out/report.html", result.stdout)
        self.assertEqual(result.stderr, "")


class Truths(Verdicts):
    def refused(self):
        box = "shape.box = { half_extents_m = [0.1, 0.2, 0.3] }"
        second = '[[body]]\nname = "other"\nmass_kg = 1.0\nshape.sphere = { radius_m = 0.1 }\nposition_m = [0, 0, 0.2]\n'
        return SCENE.replace("[truth]", "[truth]").replace("mass_kg = 2.0", "mass_kg = 2.0\n" + box).replace("[truth]", second + "[truth]")

    def test_a_truth_that_refuses_is_said_and_fails_what_needs_it(self):
        path = self.path("mine.toml", self.refused())
        self.expect(self.run_in("trace", path, "--method", "truth"), 1, "unsupported", '`kind = "none"`')
        words = ["run", "--scenario", path, "--method", "atwood/symplectic-euler+impulse", "--no-timing"]
        result = self.expect(self.run_in(*words, "-o", "md:r.md", "-o", "json:r.json"), 0, "no truth", "not covered by the extended truth")
        self.assertEqual(result.stdout.count("not covered by the extended truth"), 1)
        self.assertIn("Scenes without a truth", open(self.path("r.md")).read())
        refused = json.load(open(self.path("r.json")))["refused_truths"]
        self.assertEqual([r["scenario"] for r in refused], ["mine"])
        self.assertIn("none", refused[0]["remedy"])
        self.expect(self.run_in(*words, "--tolerances", self.path("g.toml", gate("mine", "*"))), 1, "1 not run", "truth of this scene ended")
        self.expect(self.run_in(*words, "--tolerances", self.path("g.toml", gate("mine", "*", "energy-change-max", "max = 1e9"))), 0)


class Baselines(Verdicts):
    def setUp(self):
        super().setUp()
        self.expect(self.run_in("run", *SMALL, "--no-timing"), 0)
        self.expect(self.run_in("bless", *SMALL, "--reason", "first", "--baseline", "b.tsv"), 0)

    def halve(self, text):  # it was twice as good once
        lines = [line.split("\t") for line in text.splitlines()]
        for cells in lines:
            if len(cells) > 4 and cells[3].startswith("error-position") and cells[4] != "value":
                cells[4] = repr(float(cells[4]) / 2)
        return "\n".join("\t".join(cells) for cells in lines) + "\n"

    def test_tolerances_and_baseline_are_judged_together(self):
        both = ["gate", *SMALL, "--baseline", "b.tsv", "--tolerances", self.path("g.toml", gate()), "--junit", "v.xml"]
        self.expect(self.run_in(*both), 0, "2 pass")
        self.path("g.toml", gate(limit="max = 1e-30"))
        self.expect(self.run_in(*both), 1, "allowed <= 1e-30", "0 regressions", "1 pass, 1 fail")
        self.assertEqual(xml.parse(self.path("v.xml")).getroot().get("failures"), "1")
        self.path("g.toml", gate())
        self.edit("b.tsv", self.halve)
        result = self.expect(self.run_in(*both), 1, "2 x as bad", "1 pass, 1 fail")
        lines = [line for line in result.stdout.splitlines() if line.startswith("regression ")]
        self.assertEqual(len(lines), 1, result.stdout)
        self.assertEqual(xml.parse(self.path("v.xml")).getroot().get("failures"), "1")
        data = json.loads(self.run_in(*both, "--json").stdout)
        self.assertEqual((data["verdict"]["pass"], data["verdict"]["fail"]), (1, 1))
        self.assertEqual({change["kind"] for change in data["baseline"]}, {"regression"})
        self.expect(self.run_in("run", *SMALL, "--no-timing", "--baseline", "b.tsv"), 1, "2 x as bad")

    def test_nothing_passes_against_what_is_lost(self):
        judge = ["gate", *SMALL, "--baseline", "b.tsv"]
        with open(self.path("b.tsv")) as file:
            whole = file.read()
        self.expect(self.run_in(*judge), 0, "0 regressions, 0 missing")
        for text, code, *words in (("", 2, "empty"), (whole[:len(whole) // 2], 2, "b.tsv:"), (whole[:whole.index("# end")], 2, "a part of it is lost"),
                                   ("\n".join(whole.splitlines()[:3]) + "\n# end 0\n", 4, "holds no figure"),
                                   ("# atwood baseline 1\n# reason: x\n", 4, "holds no figure"),
                                   (whole.replace("kepler-e0.6", "kepler-e0.7"), 1, "nothing was compared"),
                                   (whole.replace("\t960\t", "\t960abc\t"), 2, "960abc")):
            self.path("b.tsv", text)
            self.expect(self.run_in(*judge), code, *words)

    def test_what_a_filter_leaves_out_of_a_baseline_is_no_loss(self):
        wide = ["--scenario", "kepler-e0.6", "--method", "atwood/rk4", "--method", "atwood/heun"]
        self.expect(self.run_in("run", *wide, "--no-timing", "--quiet"), 0)
        self.expect(self.run_in("bless", *wide, "--reason", "both", "--baseline", "b.tsv"), 0)
        self.expect(self.run_in("gate", *SMALL, "--baseline", "b.tsv"), 0, "0 missing", "left out by the filter")
        self.edit("b.tsv", lambda text: text.replace("atwood/heun", "atwood/hen"))
        self.expect(self.run_in("gate", *SMALL, "--baseline", "b.tsv"), 1, "missing kepler-e0.6")

    def test_annotations_and_a_summary(self):
        self.edit("b.tsv", self.halve)
        result = self.run_in("gate", *SMALL, "--baseline", "b.tsv", "--github", env={"GITHUB_STEP_SUMMARY": self.path("s.md")})
        self.expect(result, 1, "::error title=atwood fail%3A kepler-e0.6 atwood/rk4")
        self.assertIn("## Against the baseline", open(self.path("s.md")).read())
        path = self.path("g.toml", gate(limit="max = 1e-30"))
        result = self.run_in("run", *SMALL, "--no-timing", "--tolerances", path, "--github", "--quiet", env={"GITHUB_WORKSPACE": self.here})
        self.expect(result, 1, "::error file=g.toml,line=1,title=atwood fail")

    def test_a_full_disk_leaves_the_old_baseline(self):
        with open(self.path("b.tsv")) as file:
            before = file.read()
        def small_files():
            resource.setrlimit(resource.RLIMIT_FSIZE, (512, 512))
        result = self.run_in("bless", *SMALL, "--reason", "second", "--baseline", "b.tsv", preexec_fn=small_files)
        self.expect(result, 5)
        self.assertTrue(result.stderr.startswith("atwood: "), result.stderr)
        with open(self.path("b.tsv")) as file:
            self.assertEqual(file.read(), before)
        self.assertEqual(sorted(os.listdir(self.here)), ["atwood-out", "b.tsv", "b.tsv.env"])


class Reruns(Verdicts):
    def test_a_printed_command_is_pasted(self):
        name = "it's a $(touch x) \"stone\"; `touch y` & more.toml"
        os.mkdir(self.path("scenes"))
        self.path(os.path.join("scenes", name), SCENE)
        self.path("gates of mine.toml", gate("mine", "atwood/explicit-euler", limit="max = 1e-30"))
        elsewhere = self.path("else where")
        os.mkdir(elsewhere)
        result = self.run_in("run", "--scenario", os.path.join("..", "scenes", name), "--method", "atwood/explicit-euler", "--no-timing",
                             "--tolerances", "../gates of mine.toml", cwd=elsewhere)
        self.expect(result, 1, "allowed <= 1e-30")
        command = next(line for line in result.stdout.splitlines() if " run --scenario " in line).strip()
        self.assertEqual(shlex.split(command)[0], ATWOOD)
        for shell in ("bash", "sh"):
            pasted = subprocess.run([shell, "-c", command + " --no-timing"], cwd=elsewhere, text=True, capture_output=True)
            self.expect(pasted, 1, "allowed <= 1e-30", "1 fail")
        self.assertEqual(sorted(os.listdir(elsewhere)), ["atwood-out"])
        self.assertEqual(sorted(os.listdir(self.here)), ["else where", "gates of mine.toml", "scenes"])

    def test_the_program_is_named_as_it_was_called(self):
        path = self.path("g.toml", gate(limit="max = 1e-30"))
        os.symlink(ATWOOD, self.path("my-atwood"))
        for called, named in (("./my-atwood", "./my-atwood run"), (ATWOOD, ATWOOD + " run")):
            env = {k: v for k, v in os.environ.items() if k != "ATWOOD_CALLED_AS"}
            result = subprocess.run([called, "run", *SMALL, "--no-timing", "--tolerances", path], cwd=self.here, text=True,
                                    capture_output=True, env=env)
            self.expect(result, 1, named)
        result = self.run_in("run", *SMALL, "--no-timing", "--tolerances", path, env={"ATWOOD_CALLED_AS": "../clone/atwood"})
        self.expect(result, 1, "../clone/atwood run")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[3:], verbosity=1)
