"""The GitHub Action: action.yml is consistent, and its script runs a study, keeps the first baseline and judges by it."""
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

try:
    import yaml
except ImportError:
    print("skipped: python3-yaml is not here")
    sys.exit(77)

ATWOOD = os.path.abspath(sys.argv[1])
ROOT = os.path.abspath(sys.argv[2])
SCRIPT = os.path.join(ROOT, "packaging", "action.sh")
STUDY = """id = "two"
[[cells]]
scenarios = ["ballistic"]
methods = ["atwood/rk4", "atwood/midpoint"]
steps = [120, 240]
timing = false
"""


class Description(unittest.TestCase):
    def setUp(self):
        with open(os.path.join(ROOT, "action.yml")) as file:
            self.text = file.read()
        self.action = yaml.safe_load(self.text)

    def test_what_it_uses_is_declared(self):
        used = set(re.findall(r"\binputs\.([a-z_]+)", self.text))
        self.assertEqual(used, set(self.action["inputs"]))
        ids = {step["id"] for step in self.action["runs"]["steps"] if "id" in step}
        for step, name in re.findall(r"\bsteps\.([a-z]+)\.outputs\.([a-z-]+)", self.text):
            self.assertIn(step, ids)
            if name != "cache-hit":  # GitHub's own action tells that one
                with open(SCRIPT) as file:
                    self.assertIn(f'echo "{name}=', file.read())
        for step in self.action["runs"]["steps"]:
            self.assertTrue(("run" in step) != ("uses" in step), step)
            if "run" in step:
                self.assertEqual(step["shell"], "bash")
                # inputs reach the script by its environment alone: none is pasted into a shell's text
                self.assertRegex(step["run"], r'^"\$GITHUB_ACTION_PATH/packaging/action\.sh" (key|install|run)$')
            else:
                self.assertRegex(step["uses"], r"^actions/[a-z/-]+@v\d+$")

    def test_every_variable_of_the_script_is_given(self):
        given = {name for step in self.action["runs"]["steps"] for name in step.get("env", {})}
        with open(SCRIPT) as file:
            read = set(re.findall(r"\$\{?(ATWOOD_[A-Z_]+)", file.read()))
        self.assertEqual(read - {"ATWOOD_PROGRAM"}, given)


    def test_caches(self):
        steps = self.action["runs"]["steps"]
        caches = [step for step in steps if step.get("uses", "").startswith("actions/cache")]
        build, built, kept, blessed = caches
        for restored, saved in ((build, built), (kept, blessed)):
            self.assertEqual(restored["uses"], "actions/cache/restore@v4")
            self.assertEqual(saved["uses"], "actions/cache/save@v4")
            for same in ("path", "key"):
                self.assertEqual(restored["with"][same], saved["with"][same])
        # the build is kept before the study runs, which may fail
        self.assertLess(steps.index(built), next(i for i, step in enumerate(steps) if step.get("id") == "run"))
        # the repository's own baseline stays
        self.assertEqual(kept["if"], "hashFiles(inputs.baseline) == ''")
        self.assertTrue(kept["with"]["key"].startswith(kept["with"]["restore-keys"]))


class Script(unittest.TestCase):
    def setUp(self):
        self.here = tempfile.mkdtemp()
        with open(os.path.join(self.here, "study.toml"), "w") as file:
            file.write(STUDY)
        self.output, self.summary = os.path.join(self.here, "output"), os.path.join(self.here, "summary")

    def tearDown(self):
        shutil.rmtree(self.here)

    def script(self, word, **more):
        """The step's exit code, what it wrote to GITHUB_OUTPUT, and what it printed."""
        open(self.output, "w").close()
        environment = {"PATH": "/usr/bin:/bin", "GITHUB_OUTPUT": self.output, "GITHUB_STEP_SUMMARY": self.summary, "ATWOOD_PROGRAM": ATWOOD,
                       "ATWOOD_STUDY": "study.toml", "ATWOOD_ARGUMENTS": "", "ATWOOD_BASELINE": "kept.tsv", "ATWOOD_BLESS": "",
                       "ATWOOD_OUT": "out", "ATWOOD_MAY_BLESS": "true", **more}
        done = subprocess.run([SCRIPT, word], cwd=self.here, text=True, capture_output=True, timeout=300, env=environment)
        with open(self.output) as file:
            return done.returncode, file.read(), done.stdout + done.stderr

    def baseline(self):
        with open(os.path.join(self.here, "kept.tsv")) as file:
            return file.read()

    def test_the_first_run_makes_the_baseline_and_later_ones_are_judged_by_it(self):
        code, told, said = self.script("run", ATWOOD_MAY_BLESS="false")
        self.assertEqual((code, told), (0, ""), said)
        self.assertFalse(os.path.exists(os.path.join(self.here, "kept.tsv")))
        code, told, said = self.script("run")
        self.assertEqual((code, told), (0, "blessed=true\n"), said)
        for name in ("kept.tsv.env", "out/report.html", "out/verdicts.xml", "summary"):
            self.assertTrue(os.path.getsize(os.path.join(self.here, name)), name)
        kept = self.baseline()
        code, told, said = self.script("run")
        self.assertEqual((code, told), (0, ""), said)
        self.assertEqual(self.baseline(), kept)

        # A baseline that was four times as accurate: the same figures now are regressions.
        lines = kept.splitlines(keepends=True)
        at = next(i for i, line in enumerate(lines) if "midpoint" in line and "error-position-end" in line)
        fields = lines[at].split("\t")
        value = max(range(len(fields)), key=lambda k: bool(re.fullmatch(r"\d+\.?\d*e?-?\d*", fields[k])) and 0 < float(fields[k]) < 1)
        fields[value] = repr(float(fields[value]) / 4)
        lines[at] = "\t".join(fields)
        with open(os.path.join(self.here, "kept.tsv"), "w") as file:
            file.writelines(lines)
        code, told, said = self.script("run")
        self.assertEqual((code, told), (1, ""), said)
        self.assertIn("::error", said)
        code, told, said = self.script("run", ATWOOD_BLESS="the midpoint rule is what it is")
        self.assertEqual((code, told), (0, "blessed=true\n"), said)
        self.assertEqual(self.script("run")[0], 0)

    def test_a_pull_request_is_judged_by_the_baseline_also_with_a_reason_to_bless(self):
        self.assertEqual(self.script("run")[0], 0)
        with open(os.path.join(self.here, "kept.tsv"), "a") as file:
            file.write("not a row of a baseline\n")
        kept = self.baseline()
        code, told, said = self.script("run", ATWOOD_BLESS="a reason", ATWOOD_MAY_BLESS="false")
        self.assertNotEqual(code, 0)
        self.assertEqual(told, "")
        self.assertIn("kept.tsv", said)
        self.assertEqual(self.baseline(), kept)

    def test_arguments_narrow_the_run_and_its_baseline(self):
        narrow = {"ATWOOD_ARGUMENTS": "--method 'atwood/mid*' --no-timing"}
        code, told, said = self.script("run", **narrow)
        self.assertEqual((code, told), (0, "blessed=true\n"), said)
        self.assertIn("atwood/midpoint", self.baseline())
        self.assertNotIn("atwood/rk4", self.baseline())
        self.assertEqual(self.script("run", **narrow)[0], 0)

    def test_an_option_with_an_equals_sign_narrows_too(self):
        narrow = {"ATWOOD_ARGUMENTS": "--method=atwood/mid* --steps=120 --no-timing --max-cells=50"}
        code, told, said = self.script("run", **narrow)
        self.assertEqual((code, told), (0, "blessed=true\n"), said)
        self.assertIn("atwood/midpoint", self.baseline())
        self.assertNotIn("atwood/rk4", self.baseline())

    def test_what_narrows_a_run_reaches_bless(self):
        program = os.path.join(self.here, "program")
        with open(program, "w") as file:
            file.write('#!/bin/sh\nprintf "<%s>" "$@" >>calls\necho >>calls\n')
        os.chmod(program, 0o755)
        narrowing = ["--scenario=a b", "--filter", "c", "--method=d", "--method", "e", "--steps", "1", "--hz=2",
                     "--engine", "./f", "--spacing", "0.1", "--spacing=0.2", "--sound-speed", "3", "--sound-speed=4",
                     "--max-cells", "5"]
        written = " ".join(f"'{word}'" for word in ["--jobs", "2", *narrowing, "--junit=x.xml", "--fresh"])
        code, told, said = self.script("run", ATWOOD_ARGUMENTS=written, ATWOOD_PROGRAM=program)
        self.assertEqual((code, told), (0, "blessed=true\n"), said)
        with open(os.path.join(self.here, "calls")) as file:
            ran, blessed = file.read().splitlines()
        words = "".join(f"<{word}>" for word in narrowing)
        self.assertIn(f"<run><study.toml><--jobs><2>{words}<--junit=x.xml><--fresh><--out>", ran)
        self.assertIn(f"<bless><study.toml>{words}<--out>", blessed)

    def test_nothing_in_the_arguments_is_expanded(self):
        program = os.path.join(self.here, "program")
        with open(program, "w") as file:
            file.write('#!/bin/sh\nprintf "<%s>" "$@"\nexit 3\n')
        os.chmod(program, 0o755)
        for written, words in (("$(touch x) `touch x` *", "<$(touch><x)><`touch><x`><*>"),
                               ("; touch x", "<;><touch><x>"),
                               ("\"$HOME  a\" 'b\"c' ''\n  d\\ e\n", '<$HOME  a><b"c><><d e>'), ("", ""), (" \n", "")):
            code, told, said = self.script("run", ATWOOD_ARGUMENTS=written, ATWOOD_PROGRAM=program)
            self.assertEqual((code, told), (3, ""), said)
            self.assertTrue(said.startswith(f"<run><study.toml>{words}<--out>"), said)
            self.assertFalse(os.path.exists(os.path.join(self.here, "x")), written)
        code, _, said = self.script("run", ATWOOD_ARGUMENTS="--method 'open", ATWOOD_PROGRAM=program)
        self.assertEqual(code, 2, said)
        self.assertIn("unmatched quote", said)

    def test_a_run_that_fails_blesses_nothing(self):
        code, told, said = self.script("run", ATWOOD_STUDY="no-such.toml", ATWOOD_BLESS="a reason")
        self.assertEqual((code, told), (2, ""), said)
        self.assertIn("no-such.toml", said)

    def test_a_package_from_an_address_is_kept_under_its_files_name(self):
        stubs = os.path.join(self.here, "stubs")
        os.mkdir(stubs)
        says = 'printf "<%s>" "$@"; echo'
        for name, does in (("apt-get", says), ("curl", says), ("sudo", '"$@"')):
            with open(os.path.join(stubs, name), "w") as file:
                file.write(f"#!/bin/sh\n{does}\n")
            os.chmod(os.path.join(stubs, name), 0o755)
        for address in ("https://a.org/b/atwood_1_amd64.deb", "https://a.org/b/atwood_1_amd64.deb?token=x/y#z",
                        "https://a.org/atwood_1_amd64.deb#of/b?c"):
            code, _, said = self.script("install", ATWOOD_PACKAGE=address, PATH=f"{stubs}:/usr/bin:/bin")
            self.assertEqual(code, 0, said)
            self.assertRegex(said, r"<-o><[^<>?#]*/atwood_1_amd64\.deb><" + re.escape(address) + ">")
            self.assertRegex(said.splitlines()[-1], r"<[^<>?#]*/atwood_1_amd64\.deb>$")

    def test_the_key_is_that_of_the_sources(self):
        code, told, _ = self.script("key")
        self.assertEqual(code, 0)
        self.assertRegex(told, r"^key=[0-9a-f]{64}\nbaseline=[0-9a-f]{64}\n$")
        self.assertEqual(self.script("key")[1], told)
        baselines = {told.split("baseline=")[1]}
        for more in ({"ATWOOD_STUDY": "study"}, {"ATWOOD_ARGUMENTS": "--fresh"}, {"ATWOOD_BASELINE": "other.tsv"}):
            other = self.script("key", **more)[1]
            self.assertEqual(other.splitlines()[0], told.splitlines()[0])
            baselines.add(other.split("baseline=")[1])
        self.assertEqual(len(baselines), 4)
        self.assertEqual(self.script("frobnicate")[0], 2)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
