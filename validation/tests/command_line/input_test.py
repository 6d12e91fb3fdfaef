"""Files that users name, studies that need no flags, scenes as people type them, and text that must not act."""
import csv
import io
import json
import os
import sys
import unittest

from case import Case, thrown_stone


SCENE = thrown_stone("[64]").replace('claim = "It falls."\n', "")

ENGINE = """#!/usr/bin/env python3
import json, sys
for line in sys.stdin:
    request = json.loads(line)
    if request["request"] == "hello":
        print(json.dumps({"engine": "NAME", "version": "1", "scalar": "double", "methods": [{"id": "NAME/one", "doc": "DOC"}]}), flush=True)
        continue
    reason = " ".join(sys.argv[1:]) + "REASON"
    print(json.dumps({"cell": request["cell"], "done": {"status": "unsupported", "reason": reason}}), flush=True)
"""


class OwnEngine(Case):
    def engine(self, name, file=None, doc="odd", reason="", mode=0o755):
        return self.path(file or name + ".py", ENGINE.replace("NAME", name).replace("DOC", doc).replace("REASON", reason), mode)

    def methods(self, rows="rows.csv"):
        with open(self.path(rows), newline="") as file:
            return {(row["scenario"], row["method"]) for row in csv.DictReader(file)}


class Files(OwnEngine):
    def test_what_is_no_regular_file_is_refused_by_name_and_at_once(self):
        os.mkfifo(self.path("pipe"))
        os.mkfifo(self.path("pipe.toml"))
        with open(self.path("giant.toml"), "wb") as file:
            file.truncate(1 << 40)
        scene = self.path("mine.toml", SCENE)
        small = ["--scenario", "kepler-e0.6", "--method", "atwood/rk4", "--steps", "960"]
        for file, found in (("pipe", "a pipe"), ("/dev/zero", "a device"), (self.here, "a directory")):
            for words in (["run", "./" + file if file == "pipe" else file], ["check", file, "--scenario", scene],
                          ["run", *small, "--tolerances", file], ["bench", "goals", "--goals", file], ["import", file],
                          ["run", *small, "--shard", "1/2", "--costs", file]):
                self.expect(self.run_in(*words), 2, "found " + found)
        for name, found in (("pipe.toml", "a pipe"), ("giant.toml", "1099511627776 bytes")):
            for words in (["run", name], ["describe", name], ["trace", name, "--method", "truth"], ["check", name, "--scenario", scene],
                          ["run", *small, "--tolerances", name], ["bench", "goals", "--goals", name]):
                self.expect(self.run_in(*words), 2, name, "found " + found)

    def test_deep_keys_end_in_a_message(self):
        deep = ".".join(["a"] * 100_000) + " = 1\n"
        path = self.path("deep.toml", deep)
        small = ["--scenario", "kepler-e0.6", "--method", "atwood/rk4", "--steps", "960"]
        for words in (["run", path], ["describe", path], ["run", *small, "--tolerances", path], ["bench", "goals", "--goals", path]):
            self.expect(self.run_in(*words), 2, "deep.toml:1:", "nesting deeper than")

    def test_a_giant_mesh_is_refused(self):
        with open(self.path("shape.obj"), "wb") as file:
            file.truncate(1 << 40)
        scene = self.path("mine.toml", SCENE.replace("position_m", 'shape.mesh.file = "shape.obj"\nposition_m'))
        self.expect(self.run_in("describe", scene), 2, "shape.obj: found 1099511627776 bytes")


class Traces(OwnEngine):
    def test_times_beyond_double_blame_the_file(self):
        scene = self.path("mine.toml", SCENE)
        trace = self.expect(self.run_in("trace", scene, "--method", "truth"), 0).stdout.splitlines(keepends=True)
        for bad in ("1e400", "nan", "-inf"):
            broken = trace[:2] + [bad + trace[2][trace[2].index(","):]] + trace[3:]
            result = self.run_in("check", self.path("bad.csv", "".join(broken)), "--scenario", scene)
            self.expect(result, 2, "bad.csv:3:1: t_s: found `" + bad + "`")

    def test_names_that_a_spreadsheet_would_compute_go_out_and_come_back(self):
        scene = self.path("mine.toml", SCENE.replace('"stone"', '"=SUM(A1)"'))
        trace = self.expect(self.run_in("trace", scene, "--method", "truth"), 0).stdout
        rows = list(csv.reader(io.StringIO(trace)))
        self.assertEqual(rows[1][1], "'=SUM(A1)")
        told = json.loads(self.run_in("trace", scene, "--method", "truth", "--json").stdout)
        self.assertEqual(told[0]["body"], "=SUM(A1)")
        self.path("run.csv", trace)
        self.expect(self.run_in("check", "run.csv", "--scenario", scene, "--max", "error-position-end=1e-9"), 0)


class Scenes(OwnEngine):
    def test_an_unknown_solution_is_told_with_the_nearest(self):
        scene = self.path("mine.toml", SCENE.replace('kind = "extended"', 'kind = "closed-form"\nsolution = "balistic"'))
        for words in (["run", "--scenario", scene, "--method", "atwood/rk4"], ["trace", scene, "--method", "truth"], ["describe", scene]):
            self.expect(self.run_in(*words), 2, "mine.toml:17:12: `solution` in [truth] is \"balistic\"", "did you mean ballistic?")

    def test_an_unknown_metric_is_told_with_the_nearest(self):
        scene = self.path("mine.toml", 'metric = "error-positon-end"\n' + SCENE)
        for words in (["run", "--scenario", scene, "--method", "atwood/rk4"], ["describe", scene]):
            self.expect(self.run_in(*words), 2, "mine.toml:1:10: `metric` is \"error-positon-end\"", "nearest: error-position-end")

    def test_rounded_vectors_are_normalised_with_a_note(self):
        scene = self.path("mine.toml", SCENE.replace("mass_kg", "orientation_wxyz = [0.7071, 0.7071, 0, 0]\nmass_kg"))
        for words in (["describe", scene], ["trace", scene, "--method", "truth"]):
            result = self.expect(self.run_in(*words), 0)
            self.assertEqual(result.stderr.count("it was normalised"), 1)
            self.assertIn("mine.toml:12:20: `orientation_wxyz`", result.stderr)

    def test_an_id_of_the_catalogue_and_an_id_twice_are_refused_with_both_files(self):
        taken = self.path("taken.toml", SCENE.replace('"mine"', '"ballistic"'))
        words = ["--method", "atwood/rk4", "--no-timing"]
        self.expect(self.run_in("run", "--scenario", taken, *words), 2, "taken.toml", "ballistic.toml")
        one, two = self.path("one.toml", SCENE), self.path("two.toml", SCENE)
        self.expect(self.run_in("run", "--scenario", one, "--scenario", two, *words), 2, "`mine`", "one.toml", "two.toml")
        self.expect(self.run_in("run", "--scenario", one, "--scenario", "./one.toml", *words, "--out", "out"), 0)
        study = self.path("study.toml", 'id = "s"\n[[cells]]\nscenarios = ["one.toml", "two.toml"]\nmethods = ["atwood/rk4"]\n')
        self.expect(self.run_in("run", study), 2, "one.toml", "two.toml")
        study = self.path("study.toml", 'id = "s"\n[[cells]]\nscenarios = ["taken.toml"]\nmethods = ["atwood/rk4"]\n')
        self.expect(self.run_in("run", study), 2, "taken.toml", "ballistic.toml")


class Studies(OwnEngine):
    STUDY = """id = "own"
scenarios = ["scenes/mine.toml"]
engines = [["./odd.py", "notes.txt", "--fast"], ["python3", "other.py"]]
tolerances = "gates/own.toml"
baseline = "base/own.tsv"
"""

    def build(self):
        self.path("study/scenes/mine.toml", SCENE)
        self.path("study/notes.txt", "")
        self.engine("odd", "study/odd.py")
        self.engine("other", "study/other.py", mode=0o644)
        self.path("study/gates/own.toml", '[[gate]]\nscenario = "mine"\nmethod = "odd/one"\nmetric = "error-position-end"\nmax = 1\nreason = "r"\n')
        return self.path("study/study.toml", self.STUDY)

    def test_a_study_file_is_enough_from_any_folder(self):
        study = self.build()
        self.run_in("run", study, "--no-timing", "-o", "csv:rows.csv")
        self.assertEqual(self.methods(), {("mine", "odd/one"), ("mine", "other/one"), ("mine", "")} & self.methods() |
                         {("mine", "odd/one"), ("mine", "other/one")})
        with open(self.path("rows.csv")) as file:
            rows = file.read()
        self.assertIn(os.path.join(self.here, "study/notes.txt") + " --fast", rows)  # arguments: resolved, and kept

    def test_a_block_of_a_study_names_files_globs_and_tags(self):
        self.build()
        study = self.path("study/blocks.toml", 'id = "b"\nengines = ["./odd.py"]\n[[cells]]\nscenarios = ["scenes/*.toml", "ballistic"]\n'
                          'methods = ["odd/*"]\nallow = ["not finite", "diverged"]\nallow_reason = "odd"\n')
        self.run_in("run", "blocks.toml", "--no-timing", "-o", "csv:" + self.path("rows.csv"), cwd=self.path("study"))
        self.assertEqual({scenario for scenario, method in self.methods() if method}, {"mine", "ballistic"})
        self.run_in("run", study, "--scenario", "min*", "--no-timing", "-o", "csv:rows.csv")
        self.assertEqual({scenario for scenario, method in self.methods() if method}, {"mine"})

    def test_what_is_wrong_in_a_study_is_told_with_its_place(self):
        self.build()
        block = '[[cells]]\nscenarios = ["ballistic"]\nmethods = ["atwood/rk4"]\n'
        for text, words in (
                ('engines = ["./none"]\n' + block, ("study.toml:2:", "found no program", "study/none")),
                ('engines = [["no-such-program-3"]]\n' + block, ("found no program `no-such-program-3`", "PATH")),
                ('engines = ["notes.txt"]\n' + block, ("notes.txt is not executable",)),
                ('engines = [[]]\n' + block, ("expected a list of programs",)),
                ('engines = "./odd.py"\n' + block, ("expected a list of programs",)),
                ('engines = ["./odd.py", "odd.py"]\n' + block, ("the same engine twice",)),
                (block.replace('"ballistic"', '"scenes/none.toml"'), ("study.toml:3:13", "found no file `scenes/none.toml`")),
                (block.replace('"ballistic"', '"scenes/no*.toml"'), ("no file matches `scenes/no*.toml`",)),
                (block + 'allow = ["crashed"]\nallow_reason = "x"\n', ('found `crashed`', '"diverged" or "not finite"')),
                (block + 'allow = ["diverged"]\n', ("found `allow` without a reason; expected `allow_reason`",)),
                (block + 'allow_reason = "x"\n', ("found `allow_reason` without `allow`",)),
                (block + 'sweep = { dt = [nan] }\n', ("`dt` has", "expected finite numbers")),
                (block + 'sweep = { dt = [1.0, inf] }\n', ("`dt` has", "expected finite numbers")),
                ('scenarios = ["ballistic"]\n', ("missing key `methods`",)),
                ('scenario = ["ballistic"]\n', ("unknown key `scenario`",)),
                ('tolerances = 3\n' + block, ("`tolerances` is 3; expected a file's path",))):
            study = self.path("study/study.toml", 'id = "own"\n' + text)
            self.expect(self.run_in("run", study), 2, "study.toml", *words)

    def test_an_engine_alone_runs_alone(self):
        worker = self.engine("odd")
        self.expect(self.run_in("run", "--engine", worker, "--scenario", "ballistic", "--no-timing", "-o", "csv:rows.csv"), 0)
        self.assertEqual({method for _, method in self.methods() if method}, {"odd/one"})
        self.run_in("run", "--engine", worker, "--method", "atwood/rk4", "--scenario", "ballistic", "--no-timing", "-o", "csv:rows.csv")
        self.assertEqual({method for _, method in self.methods() if method}, {"odd/one", "atwood/rk4"})
        self.run_in("run", "--engine", worker, "--method", "odd/one", "--scenario", "ballistic", "--no-timing", "-o", "csv:rows.csv")
        self.assertEqual({method for _, method in self.methods() if method}, {"odd/one"})


class Words(OwnEngine):
    def test_no_escape_byte_reaches_the_terminal(self):
        acting = self.path("bad\x1b[31m.toml", SCENE.replace("mass_kg", "mas\\u001b[1m_kg"))
        worker = self.engine("odd", doc="\\x1b[31mred", reason="\\x1b]0;owned\\x07told")
        evil = self.engine("evil\\x1b[2J")
        title = self.path("title.toml", SCENE.replace("A thrown", "A \\u001b[31mthrown"))
        for words in (["describe", acting], ["describe", title], ["trace", acting, "--method", "truth"], ["run", "--scenario", acting],
                      ["\x1b[31mcommand"], ["run", "--\x1b[31mflag"], ["run", "--method", "a/\x1b[31m"], ["run", "no\x1b[31mstudy"],
                      ["list", "methods", "--engine", worker], ["describe", "odd/one", "--engine", worker],
                      ["doctor", "--engine", worker], ["doctor", "--engine", evil], ["list", "methods", "--engine", evil],
                      ["trace", "ballistic", "--method", "odd/one", "--engine", worker],
                      ["run", "--engine", worker, "--scenario", "ballistic", "--no-timing", "-o", "csv:rows.csv"],
                      ["run", "--engine", evil, "--scenario", "ballistic"], ["check", "x\x1b[31m.csv", "--scenario", "ballistic"]):
            result = self.run_in(*words)
            for text in (result.stdout, result.stderr):
                self.assertNotIn("\x1b", text, words)
                self.assertNotIn("\x07", text, words)
        with open(self.path("rows.csv")) as file:
            rows = file.read()
        self.assertNotIn("\x1b", rows)
        self.assertIn("told", rows)
        self.expect(self.run_in("run", "--engine", evil, "--scenario", "ballistic"), 3, "lower-case letters")

    def test_reasons_are_no_formulas(self):
        worker = self.engine("odd", reason="=1+1,\\\"a\\\"")
        self.run_in("run", "--engine", worker, "--scenario", "ballistic", "--steps", "120", "--no-timing", "-o", "csv:rows.csv")
        with open(self.path("rows.csv"), newline="") as file:
            reasons = {row["reason"] for row in csv.DictReader(file)}
        self.assertIn("'=1+1,\"a\"", reasons)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[3:], verbosity=2)
