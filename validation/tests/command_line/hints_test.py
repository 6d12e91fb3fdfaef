"""Commands that the program prints, pasted in another folder: they do what the call that printed them did."""
import os
import shlex
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree as xml

ATWOOD, ROOT = map(os.path.abspath, sys.argv[1:3])
SMALL = ["--scenario", "kepler-e0.6", "--method", "atwood/rk4", "--steps", "960"]
GATE = '[[gate]]\nscenario = "kepler-e0.6"\nmethod = "atwood/rk4"\nmetric = "error-position-end"\nmax = 1e-30\nreason = "a test"\n'
STUDY = ('id = "mine"\ntolerances = "g.toml"\nbaseline = "b.tsv"\n[[cells]]\nscenarios = ["kepler-e0.6"]\nmethods = ["atwood/rk4"]\n'
         'steps = [960]\ntiming = false\n')


class Pasted(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.here = os.path.join(folder.name, "here")
        self.elsewhere = os.path.join(folder.name, "else")
        os.mkdir(self.here)
        os.mkdir(self.elsewhere)
        self.write("g.toml", GATE)
        self.write("study.toml", STUDY)

    def write(self, name, text):
        with open(os.path.join(self.here, name), "w") as file:
            file.write(text)

    def read(self, name):
        with open(os.path.join(self.here, name)) as file:
            return file.read()

    def run_in(self, *words):
        env = {k: v for k, v in os.environ.items() if not k.startswith(("ATWOOD_CALLED_AS", "GITHUB_"))}
        return subprocess.run([ATWOOD, *words], cwd=self.here, text=True, capture_output=True, timeout=300, env=env)

    def paste(self, command, code):
        """Runs it in another folder, which it must leave empty."""
        ended = subprocess.run(["sh", "-c", command], cwd=self.elsewhere, text=True, capture_output=True, timeout=300)
        self.assertEqual(ended.returncode, code, command + "\n" + ended.stdout + ended.stderr)
        self.assertEqual(os.listdir(self.elsewhere), [], command)
        return ended.stdout + ended.stderr

    def between_ticks(self, text, before):
        return text[text.index(before) + len(before):].split("`")[0]

    def test_the_command_of_a_failing_gate(self):
        first = self.run_in("run", "./study.toml", "--limit", "17", "--junit", "v.xml")
        self.assertEqual(first.returncode, 1, first.stdout + first.stderr)
        line = next(line for line in first.stdout.splitlines() if " run " in line and "--steps 960" in line).strip()
        words = shlex.split(line)
        self.assertEqual(words[words.index("--limit") + 1], "17")
        self.assertIn(os.path.join(self.here, "study.toml"), words)
        self.assertEqual(words[words.index("--out") + 1], os.path.join(self.here, "atwood-out"))
        self.assertIn("1 fail", self.paste(line, 1))
        self.assertIn("rerun: " + line, next(xml.parse(os.path.join(self.here, "v.xml")).getroot().iter("failure")).text)

    def test_options_that_are_paths(self):
        self.assertEqual(self.run_in("run", *SMALL, "--no-timing").returncode, 0)
        self.assertEqual(self.run_in("bless", *SMALL, "--reason", "x", "--baseline", "b.tsv").returncode, 0)
        first = self.run_in("run", *SMALL, "--no-timing", "--tolerances", "g.toml", "--baseline", "./b.tsv")
        line = next(line for line in first.stdout.splitlines() if " run --scenario" in line).strip()
        self.assertIn("1 pass, 1 fail", self.paste(line + " --no-timing", 1))

    def test_no_baseline_is_there_yet(self):
        self.assertEqual(self.run_in("run", "study.toml").returncode, 1)
        missing = self.run_in("gate", "study.toml")
        self.assertEqual(missing.returncode, 4, missing.stderr)
        hint = self.between_ticks(missing.stderr, "no baseline at b.tsv; `" if "at b.tsv" in missing.stderr else "b.tsv; `")
        self.paste(hint.replace("TEXT", "'the first one'"), 0)
        self.assertIn("# reason: the first one\n", self.read("b.tsv"))

    def test_filters_and_places_of_this_call(self):
        missing = self.run_in("gate", *SMALL, "--baseline", "n.tsv", "--out", "kept")
        words = shlex.split(self.between_ticks(missing.stderr, "no baseline at n.tsv; `"))
        self.assertEqual(words, [ATWOOD, "bless", *SMALL, "--reason", "TEXT", "--baseline", os.path.join(self.here, "n.tsv"),
                                 "--out", os.path.join(self.here, "kept")])

    def test_cells_that_are_not_in_the_store(self):
        self.assertEqual(self.run_in("run", *SMALL, "--no-timing").returncode, 0)
        absent = self.run_in("gate", "--scenario", "kepler-e0.6", "--method", "atwood/rk4", "--steps", "480", "--steps", "960")
        self.assertIn("1 of 2 planned cells is not in the store", absent.stdout)
        words = shlex.split(self.between_ticks(absent.stdout, "480 steps): `"))
        self.assertEqual(words[:2] + words[-2:], [ATWOOD, "run", "--out", os.path.join(self.here, "atwood-out")])
        self.assertEqual([words[i + 1] for i, word in enumerate(words) if word == "--steps"], ["480", "960"])

    def test_improvements_are_kept(self):
        self.assertEqual(self.run_in("run", *SMALL, "--no-timing").returncode, 0)
        self.assertEqual(self.run_in("bless", *SMALL, "--reason", "x", "--baseline", "b.tsv").returncode, 0)
        lines = [line.split("\t") for line in self.read("b.tsv").splitlines()]
        for cells in lines:
            if len(cells) > 4 and cells[3] == "error-position-end":
                cells[4] = repr(float(cells[4]) * 2)
        self.write("b.tsv", "\n".join("\t".join(cells) for cells in lines) + "\n")
        better = self.run_in("gate", *SMALL, "--baseline", "b.tsv")
        self.assertIn("0 regressions, 0 missing, 1 improvement, ", better.stdout)
        hint = next(line for line in better.stdout.splitlines() if line.startswith("to keep the improvements: "))
        self.paste(hint.split(": ", 1)[1].replace("TEXT", "better"), 0)
        self.assertIn("0 improvements", self.run_in("gate", *SMALL, "--baseline", "b.tsv").stdout)


class HeldTo(unittest.TestCase):
    def test_a_unit_that_is_not_the_metrics_is_refused(self):
        with tempfile.TemporaryDirectory() as here:
            path = os.path.join(here, "b.tsv")
            with open(path, "w") as file:
                file.write("# atwood baseline 2\nkepler-e0.6\tatwood/rk4\t960\terror-position-end\t1e-6\t0\tmm\n# end 1\n")
            ended = subprocess.run([ATWOOD, "gate", *SMALL, "--baseline", path], cwd=here, text=True, capture_output=True, timeout=60)
            self.assertEqual(ended.returncode, 2, ended.stdout + ended.stderr)
            self.assertIn("the unit is `mm`; expected `m`", ended.stderr)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[3:], verbosity=1)
