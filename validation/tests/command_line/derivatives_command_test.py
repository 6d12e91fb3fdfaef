"""atwood derivatives: the accelerations' derivatives at any time of a run, the errors of differences, refusals. Called with the
program and the project's root."""
import csv
import io
import math
import os
import sys
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from case import ATWOOD, Case  # noqa: E402

MUJOCO = os.path.exists(os.path.join(os.path.dirname(ATWOOD), "atwood-mujoco-derivatives"))
G, LENGTH, MASS, MOMENT = 9.81, 0.7, 2.0, 0.3
HEAD = """id = "scene"
[run]
t_end_s = 2.0
steps = [400]
samples = 4
[world]
gravity_m_per_s2 = [0, -9.81, 0]
[truth]
kind = "none"
"""
# Angle 0 hangs down; the moment about the pivot is MOMENT + MASS LENGTH^2.
PENDULUM = HEAD + f"""
[[body]]
name = "bob"
mass_kg = {MASS}
inertia_kg_m2 = [{MOMENT}, 0.2, {MOMENT}]
[[joint]]
name = "pivot"
kind = "hinge"
bodies = ["world", "bob"]
anchors_body_m = [[0, 0, 0], [0, {LENGTH}, 0]]
axis_body = [0, 0, 1]
angle_rad = 1.1
"""
SPRING = """
[[force]]
kind = "joint-spring"
joint = "pivot"
stiffness_N_m_per_rad = 3.0
damping_N_m_s_per_rad = 0.4
"""


def body(name, more=""):
    return f"""
[[body]]
name = "{name}"
mass_kg = 1.3
inertia_kg_m2 = [0.05, 0.07, 0.1]
{more}
"""


# A floating base with a ball, a universal joint, a slider and a hinge with a damper: every kind of coordinate.
TREE = HEAD + body("base", "position_m = [0.1, 0.2, 0.3]\nvelocity_m_per_s = [0.3, 0, -0.2]\n"
                   "angular_velocity_body_rad_per_s = [0.4, -0.3, 0.9]") + body("arm") + body("hand") + body("cart") + body("leaf") + """
[[joint]]
name = "shoulder"
kind = "ball"
bodies = ["base", "arm"]
anchors_body_m = [[0.2, 0, 0.1], [0, 0.3, 0]]
axis_angle_deg = [1, 0, 0, 40]
angular_velocity_body_rad_per_s = [1.2, -0.5, 0.7]
[[joint]]
name = "wrist"
kind = "universal"
bodies = ["arm", "hand"]
anchors_body_m = [[0, -0.3, 0], [0.1, 0.2, 0]]
axes_body = [[1, 0, 0], [0, 0, 1]]
angle_rad = [0.4, -0.3]
rate_rad_per_s = [0.5, 1.1]
[[joint]]
name = "rail"
kind = "slider"
bodies = ["base", "cart"]
anchors_body_m = [[-0.2, 0.1, 0], [0, 0, 0]]
axis_body = [0, 1, 0]
offset_m = 0.2
rate_m_per_s = -0.4
[[joint]]
name = "pivot"
kind = "hinge"
bodies = ["cart", "leaf"]
anchors_body_m = [[0, 0, 0], [0.3, 0, 0]]
axis_body = [0, 0, 1]
angle_rad = 0.8
rate_rad_per_s = 2.0
""" + SPRING


class Derivatives(Case):
    def rows(self, text, *words, **more):
        return list(csv.DictReader(io.StringIO(self.ask("derivatives", self.path("scene.toml", text), *words, **more).stdout)))

    def test_pendulum_at_any_time(self):
        """u' = -(m g l sin q + 3 q + 0.4 u) / J, at the coordinate that trace prints for this time."""
        moment = MOMENT + MASS * LENGTH**2
        for at, sample in ((0, 0), (0.5, 1), (1.5, 3)):
            text = PENDULUM + SPRING
            traced = list(csv.DictReader(io.StringIO(self.ask(
                "trace", self.path("scene.toml", text), "--method", "atwood/dop853", "--joints").stdout)))
            q = float(traced[sample]["q0"])
            expected = {"displacement": -(MASS * G * LENGTH * math.cos(q) + 3) / moment, "rate": -0.4 / moment, "force": 1 / moment}
            found = self.rows(text, "--at", str(at))
            self.assertEqual({row["by"] for row in found}, set(expected))
            for row in found:
                self.assertEqual((float(row["t_s"]), row["of"], row["by_name"]), (at, "pivot", "pivot"))
                self.assertAlmostEqual(float(row["derivative"]), expected[row["by"]], delta=1e-11)
                self.assertLess(float(row["error"]), 1e-14 * abs(expected["displacement"]))
        self.assertNotAlmostEqual(q, 1.1, delta=0.1)  # the run did move it

    def test_motor_of_the_time(self):
        """A motor changes accelerations, not their derivatives; prescribed motion is no unknown, but moves what hangs on it."""
        motor = '\n[[force]]\nkind = "joint-torque"\njoint = "pivot"\ntorque_N_m = 5\n'
        still = self.rows(PENDULUM, "--at", "0")
        self.assertEqual(self.rows(PENDULUM + motor, "--at", "0"), still)
        driven = PENDULUM + body("tip") + """
[[joint]]
name = "tip"
kind = "hinge"
bodies = ["bob", "tip"]
anchors_body_m = [[0, -0.2, 0], [0, 0.4, 0]]
axis_body = [0, 0, 1]
driven_rate_rad_per_s = 1.5
"""
        self.assertEqual({row["of"] for row in self.rows(driven, "--at", "1")}, {"pivot"})

    def test_all_kinds_of_coordinates(self):
        found = self.rows(TREE, "--at", "1.0")
        names = [("base", str(k)) for k in range(6)] + [("shoulder", "0"), ("shoulder", "1"), ("shoulder", "2"), ("wrist", "0"),
                                                        ("wrist", "1"), ("rail", "0"), ("pivot", "0")]
        self.assertEqual([(row["of"], row["of_component"]) for row in found[:13 * 13:13]], names)
        self.assertEqual(len(found), 3 * 13 * 13)
        largest = max(abs(float(row["derivative"])) for row in found)
        self.assertLess(max(float(row["error"]) for row in found), 2e-13 * largest)
        by_force = {(row["of"], row["of_component"], row["by_name"], row["by_component"]): float(row["derivative"])
                    for row in found if row["by"] == "force"}
        for (of, i, by, k), value in by_force.items():  # the inverse of the mass matrix
            self.assertAlmostEqual(value, by_force[by, k, of, i], delta=1e-11 * largest)

    def ladder(self, text, *words):
        found = {}
        for row in self.rows(text, *words, "--ladder"):
            found.setdefault((row["by"], row["from"]), {})[float(row["step"] or 0)] = float(row["error"])
        return found

    def test_ladder(self):
        """Forward differences are of order 1 and best near 1e-8, central ones of order 2 and best near 1e-5; duals have no step."""
        found = self.ladder(TREE, "--at", "1.0")
        self.assertLess(found["displacement", "duals"][0], 2e-13)
        for by, order, best in (("forward", 1, (1e-9, 1e-7)), ("central", 2, (1e-7, 1e-4))):
            errors = found["displacement", by]
            self.assertEqual(len(errors), 14)
            self.assertAlmostEqual(math.log10(errors[1e-2] / errors[1e-3]), order, delta=0.1)
            least = min(errors, key=errors.get)
            self.assertTrue(best[0] <= least <= best[1], (by, least))
            self.assertGreater(errors[least], 100 * found["displacement", "duals"][0])

    @unittest.skipUnless(MUJOCO, "MuJoCo is not built")
    def test_mujoco(self):
        """Its derivatives are of its own step, dampers taken implicitly, on floating bodies and balls as well."""
        found = self.ladder(TREE, "--at", "1.0")
        for rule, order, least in (("mujoco forward", 1, 1e-7), ("mujoco central", 2, 1e-8)):
            errors = found["transition", rule]
            self.assertAlmostEqual(math.log10(errors[1e-2] / errors[1e-3]), order, delta=0.1)
            self.assertLess(min(errors.values()), least)
        motor = '\n[[force]]\nkind = "joint-torque"\njoint = "pivot"\ntorque_N_m = 5\n'
        told = self.ask("derivatives", self.path("scene.toml", PENDULUM + motor), "--ladder",
                        told=["mujoco: unsupported: MuJoCo's derivatives are of its own forces"])
        self.assertNotIn("transition", told.stdout)

    def test_refusals(self):
        for scene, word in (("slider-crank-free", "closes a loop"), ("atwood-machine", "the scene has no joint"),
                            ("kepler-e0.3", "the scene has no joint")):
            self.ask("derivatives", scene, code=2, told=[word, "expected a tree of joints"])
        drag = '\n[[force]]\nkind = "drag"\nmodel = "linear"\nbodies = ["bob"]\ncoefficient_kg_per_s = 0.1\n'
        self.ask("derivatives", self.path("scene.toml", PENDULUM + drag), code=2, told=["a [[force]] acts on bodies"])
        for at in ("-1", "2.5", "nan"):
            self.ask("derivatives", self.path("scene.toml", PENDULUM), "--at", at, code=2, told=["--at"])
        self.ask("derivatives", self.path("scene.toml", PENDULUM), "--at", "1", "--method", "atwood/no-such", code=2)
        self.ask("derivatives", self.path("scene.toml", PENDULUM), "--at", "0", "--method", "atwood/rk4", code=2,
                 told=["--method", "scene's own"])
        for option in ("--steps", "--hz"):
            self.ask("derivatives", self.path("scene.toml", PENDULUM), option, "100", option, "200", code=2,
                     told=[option + ": expected one count"])
        self.ask("derivatives", "door-stop", code=2, told=["has limits, and stops are not differentiated"])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
