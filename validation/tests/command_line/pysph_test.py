"""PySPH beside our fluids: its conventions, its known error, refusals, steps beyond stability. Called with the program and the
project's root; skipped where PySPH's worker is not there."""
import csv
import json
import os
import subprocess
import sys
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from case import ATWOOD, Case  # noqa: E402

WORKER = os.path.join(os.path.dirname(ATWOOD), "atwood-pysph")
DRIFT = """
id = "drift"
[run]
t_end_s = 1.3
steps = [260]
samples = 13
spacings_m = [0.1]
sound_speeds_m_per_s = [10]
[domain]
dimensions = 2
periodic_m = [1, 1]
[[fluid]]
name = "fluid"
region.box = { min_m = [0, 0], max_m = [1, 1] }
density_kg_per_m3 = 1
viscosity_m2_per_s = 0.01
velocity_m_per_s = [1, -0.5]
[truth]
kind = "none"
"""
LIMIT = ("--limit", "250")  # of a cell: what was not compiled with the build is compiled in it


class PySPH(Case):
    def particles(self, scene, method, *words):
        """{time: rows} of a run; rows as lists of numbers px, py, pz, vx, ..., in the scene's order."""
        told = self.ask("trace", scene, "--method", method, "--particles", *LIMIT, *words).stdout
        samples = {}
        for row in list(csv.reader(told.splitlines()))[1:]:
            samples.setdefault(float(row[0]), []).append([float(x) for x in row[3:]])
        return samples

    def rows(self, scenario, method, *words, code=0):
        out = self.path("rows.csv")
        told = self.ask("run", "--scenario", scenario, "--method", method, "--no-timing", "--out", "out", "-o", "csv:" + out,
                        *LIMIT, *words, code=code)
        with open(out) as file:
            return list(csv.DictReader(file)), told.stdout

    def test_a_uniform_flow_stays_one_through_the_periods(self):
        scene = self.path("drift.toml", DRIFT)
        for scheme in ("wcsph", "aha", "tvf", "gtvf", "edac"):
            samples = self.particles(scene, "pysph/" + scheme)
            start = samples[0]
            for t, rows in samples.items():
                for row, first in zip(rows, start):
                    for axis, speed in enumerate((1, -0.5, 0)):
                        self.assertAlmostEqual(row[axis], first[axis] + speed * t, delta=1e-9, msg=f"{scheme}, t = {t}")
                        self.assertAlmostEqual(row[3 + axis], speed, delta=1e-9, msg=f"{scheme}, t = {t}")

    def test_the_error_that_pysph_has_elsewhere(self):
        """Its own example has 2.6e-2 with other random positions of the particles."""
        rows, _ = self.rows("taylor-green", "pysph/edac", "--spacing", "0.04", "--sound-speed", "10", "--steps", "560", code=[0, 1])
        error = next(float(row["value"]) for row in rows if row["metric"] == "velocity-l1" and row["t_s"] == "0.5")
        self.assertTrue(0.02 < error < 0.032, error)
        _, told = self.rows("taylor-green", "pysph/edac", "--spacing", "0.04", "--sound-speed", "10", "--steps", "560", code=[0, 1])
        self.assertIn("1 of them found in the store", told)

    def test_a_wall_drags_the_fluid_its_way(self):
        for method in ("pysph/tvf", "pysph/wcsph{alpha=0.0}"):
            rows, _ = self.rows("couette", method, code=[0, 1])
            error = next(float(row["value"]) for row in rows if row["metric"] == "velocity-linf" and row["t_s"] == "0.5")
            self.assertLess(error, 0.05, method)

    def test_steps_beyond_stability_end_by_name(self):
        rows, _ = self.rows("taylor-green", "pysph/edac", "--spacing", "0.04", "--sound-speed", "40", "--steps", "40", code=[0, 1])
        status = next(row for row in rows if row["metric"] == "status")
        self.assertIn(status["status"], ("not finite", "diverged"))
        self.assertIn("particle", status["reason"])

    def test_what_pysph_has_not(self):
        for scenario, method, words in (("heat-sine", "edac", "no temperature"), ("mms-2d", "tvf", "depends on the place"),
                                        ("dam-break", "edac", "linear equation of state"), ("square-patch", "tvf", "free surface"),
                                        ("poiseuille", "gtvf", "friction at walls"), ("ballistic", "wcsph", "one fluid")):
            rows, _ = self.rows(scenario, "pysph/" + method, code=[0, 1])
            ends = {(row["status"], row["reason"]) for row in rows}
            self.assertTrue(all(status == "unsupported" for status, _ in ends), (scenario, ends))
            self.assertTrue(any(words in reason for _, reason in ends), (scenario, ends))

    def test_settings_out_of_range(self):
        for setting, words in (("hdx=9", "hdx"), ("kernel=square", "kernel"), ("speed=1", "speed")):
            self.ask("trace", "taylor-green", "--method", "pysph/edac{" + setting + "}", code=2, told=[words])

    def test_nothing_but_the_protocol_on_standard_output(self):
        words = json.dumps({"protocol": 1, "request": "hello"}) + "\n"
        hello = subprocess.run([WORKER], input=words, text=True, capture_output=True, timeout=60, cwd=self.here)
        self.assertEqual(json.loads(hello.stdout)["engine"], "pysph", hello.stderr)
        self.assertEqual(os.listdir(self.here), [])


if __name__ == "__main__":
    if not os.path.exists(WORKER):
        print("skipped: PySPH is not there, no atwood-pysph beside the program (ATWOOD_ENGINES=pysph ./atwood test)")
        sys.exit(77)
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
