"""Studies of more cells than memory holds rows of: judged and reported ladder by ladder, with the same verdicts."""
import json
import os
import re
import sys
import unittest

from case import ROOT
from shards_test import STUDY, Shards

GATES = """[[gate]]
scenario = "*"
method = "atwood/*"
metric = "error-position-end"
max = %s
reason = "A bound."
[[gate]]
scenario = "oscillator"
method = "atwood/heun"
metric = "error-position-end"
max_ratio = { to = "atwood/rk4", value = 1e-3 }
reason = "A ratio."
"""


class ManyCells(Shards):
    def many(self, *words, **how):
        self.environment["ATWOOD_MANY_CELLS"] = "0"
        ended = self.atwood(*words, **how)
        del self.environment["ATWOOD_MANY_CELLS"]
        return ended

    def counts(self, ended):
        return re.search(r"(PASS|FAIL) +(\d+ gates?: .*)", ended.stdout).groups()

    def gate(self, bound, code, *more):
        self.path("gates.toml", GATES % bound)
        words = ["gate", "small.toml", "--tolerances", "gates.toml", *more]
        whole = self.atwood(*words, code=code)
        ladders = self.many(*words, code=code)
        self.assertEqual(self.counts(ladders), self.counts(whole))
        return ladders

    def test_verdicts_and_exit_codes_are_those_of_all_rows_together(self):
        self.atwood("run", "small.toml", "--no-timing")
        self.assertIn("oscillator", self.gate("1e9", 1).stdout)
        told = self.gate("1e-9", 1)
        self.assertIn("--scenario", told.stdout)
        self.gate("1e9", 0, "--method", "atwood/rk4")

    def test_missing_cells_are_told(self):
        self.shard("1/2")
        os.makedirs(self.path("atwood-out"), exist_ok=True)
        os.rename(self.path("shards/shard-1-of-2.db"), self.path("atwood-out/store.db"))
        self.assertIn("not in the store", self.gate("1e9", 1).stdout)

    def test_a_run_and_its_report_show_some_ladders_and_count_all(self):
        self.path("small.toml", STUDY)
        self.path("gates.toml", GATES % "1e9")
        words = ["small.toml", "--tolerances", "gates.toml"]
        ran = self.many("run", *words, "--no-timing", code=1)
        reported = self.many("report", *words)
        self.assertEqual(self.counts(ran), self.counts(reported))
        self.assertIn("report: atwood-out/report.html", reported.stdout)
        with open(self.path("atwood-out/report.html")) as page:
            self.assertIn("</html>", page.read())
        self.assertEqual(self.counts(self.atwood("report", *words)), self.counts(reported))
        (kept,) = json.loads(self.atwood("history", "--json").stdout)
        counts = f"{kept['pass']} pass, {kept['fail']} fail, {kept['unverifiable']} unverifiable, {kept['not_run']} not run"
        self.assertIn(counts, self.counts(ran)[1])
        refused = self.atwood("report", *words, "--against", "1", code=2)
        self.assertIn("of runs of 20 000 cells or more the history keeps only counts", refused.stderr)
        counted = {}
        for trend in json.loads(self.atwood("history", "--metric", "*", "--scenario", "oscillator", "--json").stdout):
            counted[trend["metric"]] = trend["points"][0]["value"]
        row = re.search(r"^oscillator +(.*)", reported.stdout, re.M).group(1).split()
        names = ("ladders", "cells", "cells-not-ok", "cells-missing", "gates-pass", "gates-fail", "gates-unverifiable", "gates-not-run")
        self.assertEqual({name: float(number) for name, number in zip(names, row) if name != "ladders"}, counted)

    def test_what_a_users_engine_refuses_is_told(self):
        engine = os.path.join(ROOT, "reference", "your_engine", "worker.py")
        words = ["run", "--engine", engine, "--scenario", "asymmetric-top", "--steps", "480", "--no-timing"]
        whole = self.atwood(*words, code=[0, 1])
        self.assertIn("does not run asymmetric-top: ", " ".join(whole.stdout.split()))
        self.assertIn("does not run asymmetric-top: ", " ".join(self.many(*words, code=[0, 1]).stdout.split()))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
