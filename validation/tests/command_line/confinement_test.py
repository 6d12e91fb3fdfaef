"""Confinement of engines as a user sees it: what doctor says, who opts out and where that is said, the limit of memory."""
import csv
import json
import os
import signal
import subprocess
import sys
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from case import ATWOOD, Case  # noqa: E402
from foreign_engine_test import ENGINE, SCENE  # noqa: E402

OUT = " (sandbox = false)"


class Confinement(Case):
    def setUp(self):
        super().setUp()
        self.path("scene.toml", SCENE)
        self.target = self.path("written")
        told = json.loads(self.run_in("doctor", "--json").stdout)
        self.confinement = told["confinement"]
        self.sandboxes = {engine["name"]: engine["sandbox"] for engine in told["engines"]}

    def engine(self, first):
        """An exact engine that does this first when it is asked for a run."""
        text = ENGINE.replace("NORM", "1").replace("LEAP", "0").replace("    norm, ", f"    {first}\n    norm, ")
        return self.path("engine", text, 0o755)

    def writer(self):
        return self.engine(f"open({self.target!r}, 'w').close()")

    def rows(self, *words, code=0, told=()):
        out = self.path("rows.csv")
        done = self.ask("run", *words, "--no-timing", "--fresh", "-o", "csv:" + out, code=code, told=told)
        with open(out) as file:
            return [row for row in csv.DictReader(file) if row["method"] == "mine/a"], done

    def test_doctor_says_what_the_kernel_offers(self):
        self.assertEqual(list(self.confinement), ["memory", "network", "writing"])
        self.assertEqual(self.confinement["memory"]["how"], "at most 4 GiB resident, with descendants")
        for what in ("network", "writing"):
            self.assertEqual(self.confinement[what]["full"], "NOT confined" not in self.confinement[what]["how"]
                             and "other protocols" not in self.confinement[what]["how"])
        self.ask("doctor", "--memory", "1.5", told=["Workers are confined:", "at most 1.5 GiB", self.confinement["writing"]["how"]])
        self.ask("doctor", "--memory", "0", told=["memory not limited"])
        self.assertEqual(set(self.sandboxes.values()), {True})

    def test_an_engine_writes_nothing_unless_it_opts_out(self):
        if not self.confinement["writing"]["full"]:
            self.skipTest("writing: " + self.confinement["writing"]["how"])
        engine = self.writer()
        words = ("--engine", engine, "--scenario", "scene.toml")
        _, done = self.rows(*words, code=3, told=["written"])
        self.assertFalse(os.path.exists(self.target))
        self.assertNotIn("sandbox", done.stdout + done.stderr)
        rows, done = self.rows(*words, "--no-sandbox", "-o", "markdown:report.md")
        self.assertTrue(os.path.exists(self.target))
        sentence = "The engine `mine` runs without confinement (sandbox = false)"
        self.assertEqual(done.stderr.count(sentence), 1, done.stderr)
        self.assertEqual({row["engine_version"] for row in rows}, {"1" + OUT})
        with open(self.path("report.md")) as file:
            text = file.read()
        self.assertIn("| mine | 1" + OUT + " |", text)
        told = json.loads(self.ask("run", *words, "--no-sandbox", "--no-timing", "--json").stdout)
        self.assertTrue(any(sentence in note for note in told["notes"]), told["notes"])
        self.assertEqual({row["engine_version"] for row in told["rows"] if row["method"] == "mine/a"}, {"1" + OUT})

    def test_a_study_names_who_is_not_confined(self):
        study = 'id = "s"\nscenarios = ["scene.toml"]\nmethods = ["mine/a"]\nengines = [{ command = "%s", sandbox = %s }]\n'
        self.writer()
        self.path("study.toml", study % ("./engine", "false"))
        rows, _ = self.rows("study.toml", told=["The engine `mine` runs without confinement"])
        self.assertTrue(os.path.exists(self.target))
        self.assertEqual({row["engine_version"] for row in rows}, {"1" + OUT})
        os.remove(self.target)
        if self.confinement["writing"]["full"]:
            self.path("study.toml", study % ("./engine", "true"))
            self.rows("study.toml", code=3)
            self.assertFalse(os.path.exists(self.target))
        self.path("study.toml", study % ("./engine", '"no"'))
        self.ask("run", "study.toml", code=2, told=["`sandbox` is", "expected true or false"])
        self.path("study.toml", study.replace("command", "program") % ("./engine", "false"))
        self.ask("run", "study.toml", code=2, told=["unknown key `program` in an engine of `engines`", "command, sandbox"])

    def test_confinement_changes_no_row(self):
        engine = self.engine("pass")
        words = ("--engine", engine, "--scenario", "scene.toml")
        values = lambda rows: [(row["metric"], row["t_s"], row["value"], row["truth_bar"], row["reason"]) for row in rows]
        self.assertEqual(values(self.rows(*words)[0]), values(self.rows(*words, "--no-sandbox")[0]))

    def test_orphans(self):
        """An engine's daemon without its environment is killed; what the shell had started before, and its orphans, are not."""
        daemon = ("__import__('os').fork() == 0 and (__import__('os').setsid(), __import__('os').fork() and __import__('os')._exit(0), "
                  "__import__('os').execve('/bin/sleep', ['sleep', DAEMON], {}))")
        self.engine(daemon.replace("DAEMON", f"'{1000 + os.getpid()}.25'"))
        theirs = [f"{1000 + os.getpid()}.{part}" for part in ("5", "75")]
        script = (f"sleep {theirs[0]} & (sleep 0.3; setsid sleep {theirs[1]} &) & exec \"$0\" run --engine ./engine --scenario "
                  "scene.toml --no-timing --fresh")
        for words in ([], ["--no-sandbox"]):
            done = subprocess.run(["bash", "-c", script + " " + " ".join(words), ATWOOD], cwd=self.here, stdin=subprocess.DEVNULL,
                                  stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            running = {}
            for pid in filter(str.isdigit, os.listdir("/proc")):
                try:
                    with open(f"/proc/{pid}/cmdline") as file:
                        command = file.read().split("\0")
                except OSError:
                    continue
                if command[0] == "sleep" and command[1].startswith(f"{1000 + os.getpid()}."):
                    running[command[1]] = int(pid)
            for pid in running.values():
                os.kill(pid, signal.SIGKILL)
            self.assertEqual(done.returncode, 0)
            self.assertLessEqual(set(theirs), set(running))
            if not words:
                self.assertEqual(set(theirs), set(running))

    def test_memory(self):
        engine = self.engine("taken = [b'x' * (1 << 20) for _ in range(300)]")
        words = ("--engine", engine, "--scenario", "scene.toml")
        rows, _ = self.rows(*words, "--memory", "0.125", code=3)
        reason = next(row["reason"] for row in rows if row["metric"] == "status")
        self.assertEqual(reason, "took more than 128 MiB of memory")
        rows, _ = self.rows(*words, "--memory", "1")
        self.assertEqual({row["status"] for row in rows}, {"ok"})
        self.ask("run", *words, "--memory", "0.01", code=2, told=["--memory 0.01: expected GiB from 0.0625 to 1e6"])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
