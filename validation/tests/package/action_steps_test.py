"""The GitHub Action step by step: action.yml's own conditions, environments and caches are carried out in order, as a runner does,
with GitHub's actions (cache, upload-artifact) replaced by copies between folders."""
import glob
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

from action_test import ATWOOD, ROOT, STUDY, yaml

NAME = r"(?:inputs|github)\.[a-z_]+|steps\.[a-z]+\.outputs\.[a-z-]+"


class Job:
    """One job of a workflow, with a folder of its own; `cache` outlives it."""

    def __init__(self, cache, folder, event="push", number=1, **inputs):
        with open(os.path.join(ROOT, "action.yml")) as file:
            action = yaml.safe_load(file)
        self.steps, self.cache, self.folder = action["runs"]["steps"], cache, folder
        self.values = {"inputs." + name: given["default"] for name, given in action["inputs"].items()}
        self.values.update({"inputs." + name: value for name, value in inputs.items()})
        self.values.update({"github.event_name": event, "github.run_id": str(number), "github.run_attempt": "1",
                            "github.action_path": ROOT})
        self.ran, self.said, self.failed, self.artifact = [], "", False, []
        self.stubs = os.path.join(folder, ".stubs")
        os.mkdir(self.stubs)
        for name in ("apt-get", "sudo"):  # nothing is installed
            with open(os.path.join(self.stubs, name), "w") as file:
                file.write("#!/bin/sh\n")
            os.chmod(os.path.join(self.stubs, name), 0o755)

    def value(self, expression):
        """Of an expression of GitHub's, the part of them that action.yml uses."""
        code = re.sub(r"always\(\)", "True", expression).replace("&&", " and ")
        code = re.sub(r"hashFiles\((" + NAME + r")\)", r"hash_files(\1)", code)
        code = re.sub(NAME, lambda m: f"value_of({m.group(0)!r})", code)
        found = eval(code, {"__builtins__": {}}, {
            "value_of": lambda name: self.values.get(name, ""), "True": True,
            "hash_files": lambda path: "hash" if glob.glob(os.path.join(self.folder, path)) else ""})
        return str(found).lower() if isinstance(found, bool) else found

    def text(self, text):
        return re.sub(r"\$\{\{ *(.*?) *\}\}", lambda m: self.value(m.group(1)), text)

    def run(self):
        for step in self.steps:
            condition = step.get("if", "")
            if self.failed and "always()" not in condition:
                continue
            if condition and self.value(condition) in ("false", ""):
                continue
            self.shell(step) if "run" in step else self.used(step)
        return self

    def shell(self, step):
        output = os.path.join(self.folder, ".output")
        open(output, "w").close()
        environment = {"PATH": self.stubs + ":/usr/bin:/bin", "HOME": self.folder, "GITHUB_ACTION_PATH": ROOT,
                       "GITHUB_OUTPUT": output, "GITHUB_STEP_SUMMARY": os.path.join(self.folder, ".summary"),
                       "GITHUB_WORKSPACE": self.folder, "ATWOOD_PROGRAM": ATWOOD,
                       **{name: self.text(value) for name, value in step.get("env", {}).items()}}
        done = subprocess.run(["bash", "--noprofile", "--norc", "-eo", "pipefail", "-c", step["run"]], cwd=self.folder,
                              env=environment, text=True, capture_output=True, timeout=300)
        self.ran.append(step["run"].split()[-1])
        self.said += done.stdout + done.stderr
        self.failed = self.failed or done.returncode != 0
        with open(output) as file:
            for line in file:
                name, _, value = line.rstrip("\n").partition("=")
                self.values[f"steps.{step['id']}.outputs.{name}"] = value

    def used(self, step):
        action, words = step["uses"].split("@")[0], {k: self.text(str(v)) for k, v in step["with"].items()}
        paths = words["path"].split()
        self.ran.append(action.split("/", 1)[1])
        if action == "actions/cache/save":
            kept = os.path.join(self.cache, words["key"])
            os.mkdir(kept)
            for path in paths:
                shutil.copy(os.path.join(self.folder, path), kept)
        elif action == "actions/cache/restore":
            found = sorted(glob.glob(os.path.join(self.cache, words.get("restore-keys", words["key"]) + "*")), key=os.path.getmtime)
            if found:
                for path in paths:
                    shutil.copy(os.path.join(found[-1], os.path.basename(path)), os.path.join(self.folder, path))
        else:
            self.artifact = sorted({os.path.relpath(p, self.folder) for path in paths for p in glob.glob(os.path.join(self.folder, path))})


class Steps(unittest.TestCase):
    def setUp(self):
        self.cache = tempfile.mkdtemp()
        self.folders = [self.cache]
        self.number = 0

    def tearDown(self):
        for folder in self.folders:
            shutil.rmtree(folder)

    def job(self, files=None, **words):
        folder = tempfile.mkdtemp()
        self.folders.append(folder)
        for name, text in {"study.toml": STUDY, **(files or {})}.items():
            with open(os.path.join(folder, name), "w") as file:
                file.write(text)
        self.number += 1
        return Job(self.cache, folder, number=self.number, study="study.toml", package="./atwood.deb", **words).run()

    def test_the_first_push_keeps_a_baseline_that_judges_later_jobs(self):
        request = self.job(event="pull_request")
        self.assertFalse(request.failed, request.said)
        self.assertEqual(request.ran[-1], "upload-artifact")
        self.assertEqual(os.listdir(self.cache), [], "a pull request makes no baseline")
        first = self.job()
        self.assertFalse(first.failed, first.said)
        self.assertEqual(first.ran[-2:], ["cache/save", "upload-artifact"])
        (kept,) = os.listdir(self.cache)
        for name in ("atwood-out/report.html", "atwood-out/index.html", "atwood-out/verdicts.xml", "atwood-baseline.tsv",
                     "atwood-baseline.tsv.env"):
            self.assertIn(name, first.artifact)
        with open(os.path.join(first.folder, "atwood-out/index.html")) as file:
            for target in re.findall(r'href="([^"]+)"', file.read()):
                self.assertIn("atwood-out/" + target, first.artifact, "what the index links to is uploaded too")
        second = self.job()
        self.assertFalse(second.failed, second.said)
        self.assertEqual(second.ran[-2:], ["run", "upload-artifact"])
        self.assertIn("atwood-baseline.tsv", os.listdir(second.folder), "restored")

        path = os.path.join(self.cache, kept, "atwood-baseline.tsv")
        with open(path) as file:
            lines = file.read().splitlines(keepends=True)
        at = next(i for i, line in enumerate(lines) if "midpoint\t240\terror-position-end" in line)
        words = lines[at].split("\t")
        words[4] = repr(float(words[4]) / 4)  # as if it had been four times as accurate
        lines[at] = "\t".join(words)
        with open(path, "w") as file:
            file.writelines(lines)
        for event in ("push", "pull_request"):
            worse = self.job(event=event)
            self.assertTrue(worse.failed)
            self.assertIn("::error", worse.said)
            self.assertIn("atwood-out/report.html", worse.artifact, "a report of a failed run is uploaded")
        blessed = self.job(bless="the midpoint rule is what it is")
        self.assertFalse(blessed.failed, blessed.said)
        self.assertEqual(len(os.listdir(self.cache)), 2)
        self.assertFalse(self.job().failed, "judged by the newest baseline")

    def test_another_study_has_another_baseline(self):
        self.job()
        other = self.job(arguments="--method atwood/rk4")
        self.assertFalse(other.failed, other.said)
        self.assertEqual(len(os.listdir(self.cache)), 2)

    def test_a_committed_baseline_goes_before_the_caches(self):
        first = self.job()
        with open(os.path.join(first.folder, "atwood-baseline.tsv")) as file:
            committed = file.read()
        job = self.job(files={"atwood-baseline.tsv": committed})
        self.assertNotIn("cache/restore", job.ran)
        self.assertFalse(job.failed, job.said)

    def test_a_study_that_is_not_there_fails_and_uploads_what_there_is(self):
        job = self.job(files={"study.toml": "id = 3"})
        self.assertTrue(job.failed)
        self.assertEqual(job.ran[-1], "upload-artifact")
        self.assertEqual(os.listdir(self.cache), [])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
