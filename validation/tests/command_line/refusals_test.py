"""Values that no option takes, traces that cannot be judged, files that cannot be written: refused, in words."""
import fcntl
import json
import os
import struct
import subprocess
import sys
import termios
import unittest

from case import ATWOOD, Case



class Refusals(Case):
    def on_terminal(self, columns, *words):
        ours, its = os.openpty()
        fcntl.ioctl(its, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
        process = subprocess.Popen([ATWOOD, *words], cwd=self.here, stdin=subprocess.DEVNULL, stdout=its, stderr=subprocess.DEVNULL)
        os.close(its)
        text = b""
        try:
            while more := os.read(ours, 65536):
                text += more
        except OSError:  # the other end is closed
            pass
        os.close(ours)
        self.assertEqual(process.wait(), 0)
        return text.decode().splitlines()

    def catalogue(self, name):
        root = os.path.abspath(os.path.join(os.path.dirname(__file__), "..", "..", "scenarios"))
        with open(os.path.join(root, name + ".toml")) as file:
            return file.read()


class Values(Refusals):
    def test_numbers(self):
        scene = "kepler-e0.6"
        for option, command in (("--limit", ["run"]), ("--limit", ["trace", scene, "--method", "atwood/rk4"]),
                                ("--limit", ["contacts", scene]), ("--limit", ["compare", "atwood/rk4", "atwood/heun"]),
                                ("--limit", ["advise", scene, "--error", "1"]), ("--limit", ["bench", "goals"]),
                                ("--time", ["advise", scene, "--error", "1"]), ("--hz", ["run"])):
            for value in ("nan", "inf", "-inf", "1e999", "-5", "abc", "", "0x10", "5 s"):
                told = self.ask(*command, option + "=" + value, code=2).stderr
                self.assertIn(option, told)
                for not_ours in ("not in range", "convert", "179769"):
                    self.assertNotIn(not_ours, told)
                if value: self.assertIn("found `" + value + "`; expected a number of", told)
        for option, command in (("--steps", ["run"]), ("--jobs", ["run"]), ("--max-cells", ["run"]),
                                ("--samples", ["trace", scene, "--method", "truth"])):
            for value in ("nan", "abc", "1.5", "0", "-3", "1e3", "99999999999999999999"):
                told = self.ask(*command, option + "=" + value, code=2).stderr
                self.assertIn("found `" + value + "`; expected a whole number of", told)

    def test_a_response_without_possible_contacts(self):
        """The scheme alone is refused, and the message says that the response, of whose doc it is no exception, has no part in it."""
        for scheme, response in (("symplectic-euler", "impulse"), ("symplectic-euler", "penalty")):
            told = self.ask("trace", "bricard", "--method", f"atwood/{scheme}+{response}", code=1).stderr
            self.assertIn(f"no contact is possible in this scene, so +{response} has no effect; atwood/{scheme} cannot step a mechanism", told)
        self.assertNotIn("no effect", self.ask("trace", "bricard", "--method", "atwood/symplectic-euler", code=1).stderr)

    def test_repetition_and_lack(self):
        told = self.ask("advise", "kepler-e0.6", "--error", "1", "--time", "1", "--time", "2", code=2).stderr
        self.assertIn("--time: found 2 times; expected once", told)
        self.assertIn("found no value; expected one", self.ask("run", "--limit", code=2).stderr)
        self.assertIn("it is a switch", self.ask("run", "--fresh=maybe", code=2).stderr)


class Traces(Refusals):
    def setUp(self):
        super().setUp()
        self.trace = self.ask("trace", "ballistic", "--method", "atwood/rk4").stdout.splitlines(keepends=True)

    def test_what_is_not_finite_fails(self):
        fields = self.trace[3].split(",")
        for value in ("nan", "inf", "1e5000"):
            broken = ",".join(fields[:2] + [value] + fields[3:])
            path = self.path("bad.csv", "".join(self.trace[:3] + [broken] + self.trace[4:]))
            for more in ([], ["--json"], ["--max", "error-position-end=1e9"]):
                told = self.ask("check", path, "--scenario", "ballistic", *more, code=1).stderr
                self.assertIn(f"body `{fields[1]}` is not finite at t = {fields[0]} s", told)
        self.ask("check", self.path("good.csv", "".join(self.trace)), "--scenario", "ballistic")

    def test_limits_are_finite_and_name_a_metric(self):
        path = self.path("good.csv", "".join(self.trace))
        for value in ("inf", "nan", "-inf", "1e5000"):
            told = self.ask("check", path, "--scenario", "ballistic", "--max", "error-position-end=" + value, code=2).stderr
            self.assertIn("expected a number that is finite", told)
        told = self.ask("check", path, "--scenario", "ballistic", "--max", "error-position-edn=1", code=2).stderr
        self.assertIn("nearest: error-position-end", told)

    def test_times_beyond_the_end_are_refused(self):
        first = [line for line in self.trace[1:] if float(line.split(",")[0]) == 0]
        late = ["1e300" + line[line.index(","):] for line in first]
        told = self.ask("check", self.path("late.csv", "".join(self.trace[:1] + first + late)), "--scenario", "ballistic", code=2).stderr
        self.assertIn("found t = 1e+300 s; expected times up to the scenario's end", told)


class Files(Refusals):
    def test_pipes_are_refused_before_the_run(self):
        pipe = os.path.join(self.here, "pipe")
        os.mkfifo(pipe)
        os.mkdir(os.path.join(self.here, "out"))
        small = ("--scenario", "ballistic", "--method", "atwood/rk4", "--no-timing")
        for words in (("run", *small, "-o", "csv:pipe"), ("run", *small, "--junit", "pipe"),
                      ("compare", "atwood/rk4", "atwood/heun", "--no-timing", "-o", "json:pipe"), ("run", *small, "-o", "csv:/dev/zero")):
            self.assertIn("expected a file to write to", self.ask(*words, code=2).stderr)
        for words in (("gate", *small[:4], "--junit", "pipe"), ("costs", "-o", "pipe"), ("import", "no.urdf", "-o", "pipe"),
                      ("play", "ballistic", "--method", "atwood/rk4", "-o", "html:pipe")):
            self.assertIn("pipe: found a pipe; expected a file to write to", self.ask(*words, code=2).stderr)
        for command in ("run", "gate"):
            told = self.ask(command, *small[:4], "--github", code=2, env={**os.environ, "GITHUB_STEP_SUMMARY": "pipe"}).stderr
            self.assertIn("pipe: found a pipe; expected a file to write to", told)
        os.mkfifo(os.path.join(self.here, "out", "report.html"))
        self.assertIn("report.html: found a pipe", self.ask("run", *small, "--out", "out", code=2).stderr)
        self.assertFalse(os.path.exists(os.path.join(self.here, "out", "store.db")))

    def test_a_folder_that_cannot_be_reached(self):
        os.symlink("loop", os.path.join(self.here, "loop"))
        told = self.ask("report", "--out", "loop", code=5).stderr
        self.assertRegex(told, "loop/[a-z.]*: cannot be reached: Too many levels of symbolic links")

    def test_an_empty_share(self):
        for option in ("--shard", "--costs", "--lease"):
            told = self.ask("run", "--scenario", "ballistic", "--method", "atwood/rk4", "--no-timing", option, "", code=2).stderr
            self.assertIn(option + ": found an empty text", told)
        self.assertFalse(os.path.exists(os.path.join(self.here, "atwood-out")))

    def test_an_id_of_the_catalogue(self):
        path = self.path("mine.toml", self.catalogue("ballistic"))
        for words in (["trace", path, "--method", "atwood/rk4"], ["describe", path], ["contacts", path]):
            self.assertIn("its id `ballistic` is that of the catalogue's scenario", self.ask(*words).stderr)
        for words in (["trace", "ballistic", "--method", "atwood/rk4"], ["describe", "ballistic"]):
            self.assertNotIn("its id", self.ask(*words).stderr)
        self.assertIn("expected an id of its own", self.ask("advise", path, "--error", "1", code=2).stderr)

    def test_nearest(self):
        told = self.ask("trace", "ballistic", "--method", "atwood/rk5", code=2).stderr
        self.assertIn("nearest: atwood/rk", told)
        self.assertLess(len(told), 250)
        self.path("scenes/satellite.toml", self.catalogue("ballistic").replace('"ballistic"', '"satellite"'))
        study = self.path("study.toml", 'id = "mine"\n[[cells]]\nscenarios = ["scenes/satelite.toml"]\nmethods = ["atwood/rk4"]\n')
        self.assertRegex(self.ask("run", study, code=2).stderr, "nearest: .*scenes/satellite.toml")
        self.assertIn("nearest: cradle-", self.ask("describe", "cradle-55", code=2).stderr)

    def test_an_axis_of_no_length(self):
        scene = self.path("mine.toml", self.catalogue("ballistic").replace('id = "ballistic"', 'id = "mine"').replace(
            "position_m", 'axis_angle_deg = { axis = [0, 0, 0], angle_deg = 5 }\nposition_m', 1))
        self.assertIn("is [0, 0, 0]; expected an axis that is not 0", self.ask("describe", scene, code=2).stderr)

    def test_a_pipe_as_mesh(self):
        os.mkfifo(os.path.join(self.here, "shape.obj"))
        scene = self.path("mine.toml", self.catalogue("ballistic").replace('id = "ballistic"', 'id = "mine"') .replace(
            "position_m", 'shape.mesh.file = "shape.obj"\nposition_m', 1))
        self.assertIn("shape.obj is a pipe; expected an ordinary file", self.ask("describe", scene, code=2).stderr)


class Said(Refusals):
    def test_no_attitude_of_points(self):
        told = self.ask("compare", "atwood/rk4", "atwood/heun", "--error", "1e-6rad", code=2).stderr
        self.assertIn("the bodies of kepler-e0.6 do not turn: there is no attitude", told)

    def test_conservative_only_where_nothing_dissipates(self):
        self.assertNotIn("conservative", self.ask("describe", "bounce-e0.8").stdout)
        self.assertIn("conservative", self.ask("describe", "kepler-e0.6").stdout)

    def test_methods_fit_the_width(self):
        for columns in (60, 80, 120):
            lines = self.on_terminal(columns, "list", "methods")
            for line in lines:
                self.assertLessEqual(len(line) if " " in line.strip() else 0, columns, line)

    def test_a_closed_output_is_named(self):
        told = subprocess.run(f"'{ATWOOD}' list scenarios >&-", shell=True, capture_output=True, text=True, cwd=self.here)
        self.assertEqual(told.returncode, 5)
        self.assertIn("standard output: ", told.stderr)
        self.assertNotIn("to file", told.stderr)

    def test_too_many_cells_speak_of_sweeps_only_where_there_is_one(self):
        told = self.ask("run", "--max-cells", "1", code=2).stderr
        self.assertNotIn("sweep", told)


class Advice(Refusals):
    def test_no_method_is_dismissed_while_there_is_time(self):
        advice = json.loads(self.ask("advise", "bounce-e0.8", "--error", "1e-3", "--time", "3", "--json").stdout)
        for out in advice["left_out"]:
            self.assertNotIn("others of its kind", out["reason"])
        tried = " ".join([advice["advice"]["method"], advice["runner_up"]["method"]] +
                         [out["methods"] for out in advice["left_out"] if not out["reason"].startswith("not tried")])
        self.assertIn("atwood/midpoint+event", tried)
        self.assertIn("atwood/velocity-verlet+event", tried)

    def test_every_engine_has_its_turn(self):
        slow = self.path("slow.py", SLOW)
        os.chmod(slow, 0o755)
        words = ("advise", "bounce-e0.8", "--error", "1e-3", "--engine", slow, "--method", "slow/*", "--method", "atwood/midpoint+event",
                 "--time", "1", "--json")
        advice = json.loads(self.ask(*words).stdout)
        self.assertEqual(advice["advice"]["method"], "atwood/midpoint+event")
        reasons = {out["reason"]: out["methods"] for out in advice["left_out"]}
        hung = " ".join(methods for reason, methods in reasons.items() if reason.startswith("timeout"))
        self.assertIn("slow/m0", hung)
        late = " ".join(methods for reason, methods in reasons.items() if "the 1 s of the search were over" in reason)
        self.assertIn("slow/m5", late)

    def test_what_is_unsupported_is_no_turn(self):
        # What a scene makes unsupported costs no turn: +impulse still comes when the time is over.
        words = ("advise", "stack-10", "--error", "1e-3m", "--time", "1", "--json")
        advice = json.loads(subprocess.run([ATWOOD, *words], cwd=self.here, text=True, capture_output=True, timeout=120).stdout)
        tried = " ".join([advice["advice"]["method"] if advice["advice"] else ""] +
                         [out["methods"] for out in advice["left_out"] if not out["reason"].startswith("not tried")])
        for method in ("atwood/symplectic-euler+impulse", "bullet64/", "ode/"):
            self.assertIn(method, tried)

    def test_the_coarsest_rung_says_why_it_is(self):
        words = ("advise", "bounce-e0.8", "--error", "1e-3", "--method", "atwood/midpoint+event", "--time", "1")
        text = " ".join(self.ask(*words).stdout.split())
        self.assertRegex(text, r"coarser (none was run: the ladder begins at \d+ steps, and \d+ steps are not a multiple of the 60 samples"
                               r"|was run and does not count: \d+ steps \(|\d+ steps)")
        self.assertNotIn("or the 60 samples divide none", text)


SLOW = """#!/usr/bin/env python3
import json, sys, time
for line in sys.stdin:
    request = json.loads(line)
    if request["request"] == "hello":
        methods = [{"id": "slow/m%d" % k, "doc": "slow"} for k in range(6)]
        print(json.dumps({"engine": "slow", "version": "1", "scalar": "double", "methods": methods}), flush=True)
        continue
    time.sleep(60)
"""

class Branches(Refusals):
    """An outcome that hangs on a convention ends a truth there; what came before is certified and printed."""

    def test_what_comes_before_a_branch_is_printed(self):
        text = self.catalogue("simultaneous").replace('id     = "simultaneous"', 'id     = "branch"')
        text = text.replace('simultaneous_impacts = "sequential"\n', "")
        kinds = ('kind     = "closed-form"\nsolution = "ball-flights"', 'kind = "extended"', 'kind = "cvode"')
        for kind in kinds:
            path = self.path("branch.toml", text.replace(kinds[0], kind))
            traced = self.ask("trace", path, "--method", "truth", code=1)
            rows = [line.split(",") for line in traced.stdout.splitlines()[1:]]
            self.assertEqual(len(rows), 25 * 3)  # the impact is at (2 - sqrt(3) / 2) / 3 = 0.378 s
            self.assertEqual(float(rows[-1][0]), 0.375)
            self.assertAlmostEqual(float(rows[-1][3]), -1 + 3 * 0.375, 12)
            self.assertIn("certified up to t = 0.375 s", traced.stderr)
            self.assertIn("at t = 0.37799", traced.stderr)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
