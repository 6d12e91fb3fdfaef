"""The engine in JavaScript of reference/your_engine/, and the library that it stands on, beside recurrences written here.
javascript_engine_test.py ROOT; skipped without Node.js."""
import json
import math
import os
import shutil
import subprocess
import sys
import tempfile
import unittest

from workers import Run, Worker, body, has_node, scene, tumbled

ROOT = os.path.abspath(sys.argv[1])
SCHEME = "symplectic-euler"


def add(a, b, s=1.0):
    return [x + s * y for x, y in zip(a, b)]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


class Engine(unittest.TestCase):
    def setUp(self):
        self.worker = Worker(None, "javascript", os.path.join(ROOT, "reference/your_engine/worker.mjs"))
        self.addCleanup(self.worker.close)

    def recurrence(self, force, steps=200, t_end_s=2, **members):
        """Symplectic Euler of one point of 2 kg and 3 C under force(t, x, v), and the engine's end."""
        start = {"position_m": [1, 0.5, -0.2], "velocity_m_per_s": [0.3, -0.4, 0.9], "charge_C": 3}
        h, x, v = t_end_s / steps, start["position_m"], start["velocity_m_per_s"]
        point = body("a", mass_kg=2, **start, inertia_kg_m2=[0] * 9)
        for n in range(steps):
            v = add(v, force(h * n, x, v), h / 2)
            x = add(x, v, h)
        end = Run(self.worker, SCHEME, scene(point, forces=[members]), t_end_s, steps).body(0)
        for a, b in zip(end["p"] + end["v"], x + v):
            self.assertAlmostEqual(a, b, delta=1e-11)

    def test_forces_of_one_body_are_those_of_the_manual(self):
        self.recurrence(lambda t, x, v: [-8 * y for y in x], kind="spring", bodies=["a"], anchor_m=[0, 0, 0], stiffness_N_per_m=8,
                        damping_N_s_per_m=0, rest_length_m=0, points_body_m=[[0, 0, 0]])

        def sprung(t, x, v):
            size = math.hypot(*x)
            along = 8 * (size - 0.5) + 0.7 * sum(a * b for a, b in zip(x, v)) / size
            return [-along * y / size for y in x]
        self.recurrence(sprung, kind="spring", bodies=["a"], anchor_m=[0, 0, 0], stiffness_N_per_m=8, damping_N_s_per_m=0.7,
                        rest_length_m=0.5, points_body_m=[[0, 0, 0]])
        self.recurrence(lambda t, x, v: [-2 * 5 * y / math.hypot(*x)**3 for y in x], kind="attractor", bodies=["a"], center_m=[0, 0, 0], mu_m3_per_s2=5)
        self.recurrence(lambda t, x, v: [-0.6 * (y - w) for y, w in zip(v, (0.1, 0, 0.2))], kind="drag", model="linear",
                        bodies=["a"], coefficient_kg_per_s=0.6, wind_m_per_s=[0.1, 0, 0.2], angular_coefficient_N_m_s=0)
        self.recurrence(lambda t, x, v: [-0.5 * 1.2 * 0.9 * 0.4 * math.hypot(*v) * y for y in v], kind="drag", model="quadratic", bodies=["a"],
                        density_kg_per_m3=1.2, drag_coefficient=0.9, area_m2=0.4, wind_m_per_s=[0, 0, 0], angular_coefficient_N_m_s=0)
        self.recurrence(lambda t, x, v: [3 * y for y in add([0.2, 0.1, 0], cross(v, [0.3, 0, 1.1]))], kind="lorentz", bodies=["a"],
                        electric_V_per_m=[0.2, 0.1, 0], magnetic_T=[0.3, 0, 1.1])
        self.recurrence(lambda t, x, v: [math.cos(3 * t + 0.4) * y for y in (1, 2, 3)], kind="drive", bodies=["a"], force_N=[1, 2, 3],
                        angular_frequency_rad_per_s=3, phase_rad=0.4)
        self.recurrence(lambda t, x, v: [1, 0, 0] if t < 0.999 else [0, 0, 0], kind="point-force", body="a", point_body_m=[1, 1, 1],
                        force_N=[1, 0, 0], on_s=[[0, 1]])
        self.recurrence(lambda t, x, v: [0, 0, 4], kind="thruster", body="a", point_body_m=[0, 0, 0], direction_body=[0, 0, 1], thrust_N=4, on_s=[])
        self.recurrence(lambda t, x, v: [-2 * y for y in add([2 * z for z in cross([0, 0, 0.5], v)], cross([0, 0, 0.5], cross([0, 0, 0.5], x)))],
                        kind="rotating-frame", angular_velocity_rad_per_s=[0, 0, 0.5])
        self.recurrence(lambda t, x, v: [-x[0] - 2 * x[0] * x[1], -x[1] - x[0]**2 + x[1]**2, 0], kind="potential", bodies=["a"], name="henon-heiles")

    def test_mutual_forces_pull_and_push_along_the_line(self):
        a, b = body("a", mass_kg=2, charge_C=1, inertia_kg_m2=[0] * 9), body("b", mass_kg=6, charge_C=2, position_m=[2, 0, 0], inertia_kg_m2=[0] * 9)
        for force, strength in (({"kind": "gravity", "bodies": ["a", "b"], "constant_m3_per_kg_s2": 1, "softening_m": 0}, 2 * 6 / 4),
                                ({"kind": "coulomb", "bodies": ["a", "b"], "constant_N_m2_per_C2": 4}, -4 * 2 / 4)):
            run = Run(self.worker, SCHEME, scene(a, b, forces=[force]), 1e-3, 1)
            self.assertAlmostEqual(run.body(0)["v"][0], strength / 2 * 1e-3, delta=1e-15)
            self.assertAlmostEqual(run.body(1)["v"][0], -strength / 6 * 1e-3, delta=1e-15)
            self.assertEqual(run.done["reason"], "forces evaluated by the adapter once a step: " + force["kind"])

    def test_rotations_converge_to_the_top_of_any_inertia(self):
        inertia = [2.0, 0.3, -0.2, 0.3, 1.5, 0.1, -0.2, 0.1, 1.0]
        q, w = tumbled(inertia, [1, 0, 0, 0], [1.0, 0.5, -0.4], 2)
        errors = []
        for steps in (1000, 2000):
            end = Run(self.worker, SCHEME, scene(body("a", inertia_kg_m2=inertia, angular_velocity_body_rad_per_s=[1.0, 0.5, -0.4])), 2, steps).body(0)
            errors.append(math.dist(end["w"], w))
        self.assertLess(errors[1], 1e-3)
        self.assertAlmostEqual(errors[0] / errors[1], 2, delta=0.1)

    def test_frames_of_unequal_length_are_taken_in_equal_parts(self):
        run = Run(self.worker, SCHEME, scene(body("a"), gravity=(0, 0, -10)), 1, 4, frame_ends_s=[0.2, 1])
        # Steps of 0.1, 0.1, 0.4 and 0.4: x = sum of h_k v_k.
        v = x = 0
        for h in (0.1, 0.1, 0.4, 0.4):
            v -= 10 * h
            x += h * v
        self.assertAlmostEqual(run.body(0)["p"][2], x, delta=1e-12)

    def test_the_example_is_as_short_as_the_manual_says(self):
        with open(os.path.join(ROOT, "reference/your_engine/worker.mjs")) as file:
            lines = file.read().splitlines()
        with open(os.path.join(ROOT, "reference/your_engine/README.md")) as file:
            self.assertIn(f"is one in {len(lines)} lines of JavaScript", file.read())
        self.assertLess(len(lines), 50)
        self.assertLessEqual(max(map(len, lines)), 128)

    def test_a_request_that_cannot_be_read_is_answered(self):
        self.assertEqual(self.worker.answer(request="dance", cell=5)[0]["done"]["status"], "unsupported")


class Places(unittest.TestCase):
    """Folders whose names a URL writes otherwise."""

    def setUp(self):
        made = tempfile.TemporaryDirectory()
        self.addCleanup(made.cleanup)
        self.root = os.path.join(made.name, "a checkout%20of #1")
        for each in ("reference/node", "reference/your_engine"):
            shutil.copytree(os.path.join(ROOT, each), os.path.join(self.root, each))
        os.makedirs(os.path.join(self.root, "reference/rivals"))
        shutil.copy(os.path.join(ROOT, "reference/rivals/tuned.json"), os.path.join(self.root, "reference/rivals"))

    def test_a_worker_finds_its_sources(self):
        ended = subprocess.run([shutil.which("node"), os.path.join(self.root, "reference/your_engine/worker.mjs")], text=True,
                               input='{"protocol":1,"request":"hello"}\n', capture_output=True, timeout=60)
        self.assertEqual(ended.stderr, "")
        self.assertEqual(json.loads(ended.stdout)["engine"], "javascript")

    def test_the_script_beside_the_workers_starts_one(self):
        worker, script = os.path.join(self.root, "worker.mjs"), os.path.join(self.root, "atwood-engine")
        with open(worker, "w") as file:
            file.write("export const main = (packages) => console.log(packages);")
        with open(os.path.join(ROOT, "reference/node/atwood-engine.in")) as file:
            text = file.read()
        for name, value in (("PROGRAM", shutil.which("node")), ("WORKER", worker), ("PACKAGES", "some packages")):
            text = text.replace(f"@NODE_{name}@", value)
        with open(script, "w") as file:
            file.write(text)
        os.chmod(script, 0o755)
        ended = subprocess.run([script], text=True, capture_output=True, timeout=60)
        self.assertEqual((ended.stderr, ended.stdout), ("", "some packages\n"))


if __name__ == "__main__":
    if not has_node():
        print("no Node.js of version 18.3 or newer")
        sys.exit(77)
    unittest.main(argv=sys.argv[:1])
