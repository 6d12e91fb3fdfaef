"""The peak of the memory that a cell of many samples takes, in each command that it is taken through and in each of its processes:
what any cell takes, and 800 bytes a sample of one body, so that a cell of a million samples takes a gigabyte at most."""
import os
import subprocess
import unittest

from case import ATWOOD, Case

SAMPLES = 200_000
A_SAMPLE = 800  # bytes; a truth holds 13 numbers in quad and as many bars, a run 13 more
ANY_CELL = 200_000_000  # bytes: the program with its catalogue, 64 MB of SQLite's pages, a part of a truth on its way
THROW = """id = "throw"
title = "A throw"
[run]
t_end_s = 2.0
steps = [%d]
samples = %d
[world]
gravity_m_per_s2 = [0, 0, -9.8]
[[body]]
name = "ball"
mass_kg = 1.0
velocity_m_per_s = [7.5, 0, 7.5]
[truth]
kind = "closed-form"
solution = "ballistic"
[[invariant]]
quantity = "energy"
"""


class ManySamples(Case):
    def peak(self, *words):
        """Bytes: the largest of the program and of the workers that it waited for."""
        with open(self.path("said"), "w") as said:
            started = subprocess.Popen([ATWOOD, *words], cwd=self.here, stdout=said, stderr=subprocess.STDOUT)
            _, status, used = os.wait4(started.pid, 0)
        started.returncode = os.waitstatus_to_exitcode(status)
        with open(self.path("said")) as said:
            self.assertEqual(started.returncode, 0, said.read()[-2000:])
        return used.ru_maxrss * 1024

    def test_peaks(self):
        scene = self.path("throw.toml", THROW % (SAMPLES, SAMPLES))
        cell = ("--scenario", scene, "--method", "atwood/rk4", "--out", self.path("out"))
        limit = ("--limit", "600")
        run = ("run", *cell, *limit, "--no-timing")
        for words in (run, (*run, "-o", "csv:rows.csv", "-o", "json:rows.json"), ("report", *cell), ("trace", scene, *limit, "--method", "atwood/rk4"),
                      ("trace", scene, *limit, "--method", "truth")):
            with self.subTest(" ".join(words)):
                self.assertLess(self.peak(*words), ANY_CELL + A_SAMPLE * SAMPLES)


if __name__ == "__main__":
    unittest.main(argv=["many_samples_test"])
