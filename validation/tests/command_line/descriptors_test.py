"""The commands without standard input, output or error, or with full ones: an exit code, a store that stays one."""
import itertools
import os
import sqlite3
import subprocess
import sys
import unittest

from case import ATWOOD, Case

SMALL = ["--scenario", "ballistic", "--method", "atwood/rk4", "--steps", "120", "--no-timing"]
GATE = '[[gate]]\nscenario = "ballistic"\nmethod = "atwood/rk4"\nmetric = "error-position-end"\nmax = 1\nreason = "wide"\n'


class Descriptors(Case):
    def setUp(self):
        super().setUp()
        self.path("wide.toml", GATE)

    def shell(self, words, redirections):
        command = '"$0" "$@" ' + redirections
        return subprocess.run(["sh", "-c", command, ATWOOD, *words], cwd=self.here, text=True, capture_output=True, timeout=120)

    def check_store(self):
        path = os.path.join(self.here, "atwood-out/store.db")
        with open(path, "rb") as file:
            self.assertEqual(file.read(16), b"SQLite format 3\0")
        with sqlite3.connect(path) as store:
            self.assertEqual(store.execute("pragma integrity_check").fetchall(), [("ok",)])

    def test_a_run_with_any_of_them_closed_or_full(self):
        stdin, stdout, stderr = ("", "<&-"), ("", ">&-", ">/dev/full"), ("", "2>&-", "2>/dev/full")
        for number, chosen in enumerate(itertools.product(stdin, stdout, stderr)):
            redirections = " ".join(chosen)
            with self.subTest(redirections):
                words = ["run", *SMALL, "--tolerances", "wide.toml"] + ([] if number % 2 else ["--out", "out%d" % number])
                result = self.shell(words, redirections)
                self.assertEqual(result.returncode, 5 if chosen[1] else 0, result.stderr)
                if chosen[1] and not chosen[2]:
                    self.assertIn("atwood: ", result.stderr)
        self.check_store()
        again = self.shell(["run", *SMALL, "--tolerances", "wide.toml"], "")
        self.assertIn("in the store already", again.stderr)

    def test_other_commands(self):
        self.assertEqual(self.shell(["run", *SMALL, "--tolerances", "wide.toml"], "").returncode, 0)
        commands = (["list", "metrics"], ["gate", *SMALL[:-1], "--tolerances", "wide.toml"], ["--help"],
                    ["trace", "ballistic", "--method", "atwood/rk4", "--steps", "120"])
        for words, (redirections, code) in itertools.product(commands, (
                ("<&-", 0), ("2>&-", 0), ("2>/dev/full", 0), ("<&- 2>&-", 0), (">&-", 5), (">/dev/full", 5),
                (">/dev/full 2>/dev/full", 5), ("<&- >&- 2>&-", 5))):
            with self.subTest(" ".join(words) + " " + redirections):
                result = self.shell(words, redirections)
                self.assertEqual(result.returncode, code, result.stderr)
                if code and "2>" not in redirections:
                    self.assertIn("atwood: ", result.stderr)
        self.check_store()

    def test_exit_code_without_a_readable_standard_error(self):
        for redirections in ("2>&-", "2>/dev/full", ">&- 2>&-", "<&- >/dev/full 2>/dev/full"):
            with self.subTest(redirections):
                self.assertEqual(self.shell(["trace", "no-such-scene", "--method", "atwood/rk4"], redirections).returncode, 2)
                self.assertEqual(self.shell(["no-such-command"], redirections).returncode, 2)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=1)

from case import ATWOOD, Case
