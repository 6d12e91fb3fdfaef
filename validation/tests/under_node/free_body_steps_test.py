"""The evidence of docs/jolt.md and docs/rapier.md: the steps of a free body that free_body_steps.mjs writes anew converge with
order 1 in double and not in float, and the engines are the float ones. free_body_steps_test.py BIN_DIR ROOT; skipped without
Node.js."""
import csv
import json
import os
import shutil
import subprocess
import sys
import unittest

from workers import Run, Worker, has_node

BIN_DIR, ROOT = sys.argv[1], os.path.abspath(sys.argv[2])
LADDER = [3840, 15360, 61440]
METHODS = {"jolt": "default", "rapier": "default{solver_iterations=1}"}


class Steps(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        described = subprocess.run([f"{BIN_DIR}/atwood", "describe", "free-box-complex", "--json"], capture_output=True, check=True, cwd=ROOT)
        cls.scene = json.loads(described.stdout)["scene"]
        script = [shutil.which("node"), f"{ROOT}/validation/tests/under_node/free_body_steps.mjs", *map(str, LADDER)]
        ended = subprocess.run(script, input=described.stdout, capture_output=True, check=True, timeout=200)
        cls.rows = {(row["engine"], row["arithmetic"], int(row["steps"])): (float(row["attitude_error_rad"]), float(row["energy_drift"]))
                    for row in csv.DictReader(ended.stdout.decode().splitlines())}

    def test_in_double_the_attitude_is_of_order_1(self):
        for engine in METHODS:
            coarse, fine = (self.rows[engine, "double", steps][0] for steps in LADDER[1:])
            self.assertAlmostEqual(coarse / fine, 4, delta=0.25, msg=engine)
            self.assertLess(fine, 0.03)

    def test_in_float_the_energy_grows_with_the_steps_and_the_attitude_is_lost(self):
        for engine in METHODS:
            drifts = [self.rows[engine, "float", steps][1] for steps in LADDER]
            for less, more in zip(drifts, drifts[1:]):
                self.assertTrue(3 < more / less < 5, (engine, drifts))  # in proportion to the steps: a bias, no random walk
            self.assertGreater(drifts[-1], 1000 * abs(self.rows[engine, "double", LADDER[-1]][1]))
            self.assertGreater(self.rows[engine, "float", LADDER[-1]][0], 0.5)

    def test_the_engine_gains_the_energy_of_its_step_in_float(self):
        moments = [self.scene["bodies"][0]["inertia_kg_m2"][k] for k in (0, 4, 8)]
        energy = lambda rate: sum(i * x * x for i, x in zip(moments, rate)) / 2
        tried = 0
        for engine, method in METHODS.items():
            if not os.path.exists(f"{BIN_DIR}/atwood-{engine}"):
                continue
            worker = Worker(BIN_DIR, engine)
            self.addCleanup(worker.close)
            run = Run(worker, method, self.scene, 10, 15360)
            drift = energy(run.body(0)["w"]) / energy(run.body(0, 0)["w"]) - 1
            self.assertAlmostEqual(drift / self.rows[engine, "float", 15360][1], 1, delta=0.35, msg=engine)  # other roundings
            tried += 1
        if tried == 0:
            self.skipTest("neither engine is built")


if __name__ == "__main__":
    if not has_node():
        print("no Node.js of version 18.3 or newer")
        sys.exit(77)
    unittest.main(argv=sys.argv[:1])
