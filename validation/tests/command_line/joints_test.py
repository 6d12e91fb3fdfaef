"""Mechanisms through the built program: joints as CSV and JSON, refusals, scenes imported from URDF. Called with the program
and the project's root."""
import csv
import io
import json
import math
import os
import sys
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from case import ROOT, Case  # noqa: E402

# A bar of 1 kg hangs at 0.5 rad from a hinge, 0.5 m from its centre, its inertia there 0.1 + 0.25 kg m^2.
PENDULUM = """id = "bar"
[run]
t_end_s = 1
steps = [100]
samples = 1
[world]
gravity_m_per_s2 = [0, -10, 0]
[[body]]
name = "bar"
mass_kg = 1
inertia_kg_m2 = [0.1, 0.1, 0.1]
[[joint]]
name = "pin"
kind = "hinge"
bodies = ["world", "bar"]
anchors_body_m = [[0, 0, 0], [0, 0.5, 0]]
axis_body = [0, 0, 1]
angle_rad = 0.5
[truth]
kind = "extended"
"""
COLUMNS = ("t_s,joint,q0,q1,q2,q3,u0,u1,u2,fx_N,fy_N,fz_N,tx_N_m,ty_N_m,tz_N_m,applied0,applied1,applied2,"
           "stop0,stop1,stop2")

# A hinge whose angle a line gives, and a slider on a spring, omega h = 0.4 at 100 steps: forward Euler's grows by
# 1.16^50 there, without bound.
TURN_AND_SLIDE = """id = "hs"
[run]
t_end_s = 2
steps = [100, 200, 400, 800]
samples = 20
[[body]]
name = "a"
mass_kg = 1
inertia_kg_m2 = [0.1, 0.1, 0.1]
[[body]]
name = "b"
mass_kg = 1
inertia_kg_m2 = [0.1, 0.1, 0.1]
[[joint]]
name = "h"
kind = "hinge"
bodies = ["world", "a"]
axis_body = [0, 0, 1]
rate_rad_per_s = 0.1
[[joint]]
name = "s"
kind = "slider"
bodies = ["world", "b"]
axis_body = [1, 0, 0]
offset_m = 1
[[force]]
kind = "joint-spring"
joint = "s"
stiffness_N_per_m = 400
[truth]
kind = "extended"
"""

URDF = """<?xml version="1.0"?>
<!-- an arm -->
<robot name="arm">
  <link name="base"/>
  <link name="upper">
    <inertial><origin xyz="0 0 0.5"/><mass value="2"/><inertia ixx="0.2" ixy="0" ixz="0" iyy="0.2" iyz="0" izz="0.1"/></inertial>
    <visual><geometry><mesh filename="package://arm/upper.stl"/></geometry></visual>
  </link>
  <link name="flange"/>
  <link name="lower">
    <inertial><origin xyz="0 0 0.25" rpy="0 0 1.5707963267948966"/><mass value="1"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.2" iyz="0" izz="0.15"/></inertial>
  </link>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><origin xyz="0 0 1"/><axis xyz="0 1 0"/><limit lower="-1" upper="2" effort="5" velocity="1"/><dynamics damping="0.3" friction="0.1"/></joint>
  <joint name="mount" type="fixed"><parent link="upper"/><child link="flange"/><origin xyz="0 0 1" rpy="0 0 1.5707963267948966"/></joint>
  <joint name="slide" type="prismatic"><parent link="flange"/><child link="lower"/><origin xyz="0 0.1 0"/><axis xyz="0 0 2"/><limit lower="0.1" upper="0.5"/></joint>
</robot>
"""


class Joints(Case):
    def trace(self, *words, code=0, told=()):
        return self.ask("trace", self.path("bar.toml", PENDULUM), *words, code=code, told=told).stdout

    def test_the_columns_of_joints(self):
        rows = list(csv.reader(io.StringIO(self.trace("--method", "atwood/rk4", "--joints"))))
        self.assertEqual(",".join(rows[0]), COLUMNS)
        first = dict(zip(rows[0], rows[1]))
        self.assertEqual((first["t_s"], first["joint"], first["q0"], first["q1"], first["u0"], first["u1"]), ("0", "pin", "0.5", "", "0", ""))
        # At rest th'' = -m g l sin th / I; the centre accelerates by l th'' along (cos th, sin th), so f = m (a - g).
        bend = -1 * 10 * 0.5 * math.sin(0.5) / 0.35
        self.assertAlmostEqual(float(first["fx_N"]), 0.5 * bend * math.cos(0.5), delta=1e-13)
        self.assertAlmostEqual(float(first["fy_N"]), 0.5 * bend * math.sin(0.5) + 10, delta=1e-13)
        self.assertAlmostEqual(float(first["tz_N_m"]), 0, delta=1e-13)
        self.assertEqual(len(rows), 3)

    def test_the_truth_has_bars_and_json_the_child_axes(self):
        rows = list(csv.reader(io.StringIO(self.trace("--method", "truth", "--joints"))))
        self.assertEqual(",".join(rows[0][:21]), COLUMNS)
        self.assertEqual(rows[0][21], "q0_bar")
        self.assertEqual(rows[0][-1], "source")
        self.assertTrue(all(len(row) == len(rows[0]) for row in rows))
        first = json.loads(self.trace("--method", "atwood/rk4", "--joints", "--json"))[0]
        x, y = first["fx_N"], first["fy_N"]
        self.assertAlmostEqual(first["fx_child_N"], x * math.cos(0.5) + y * math.sin(0.5), delta=1e-13)
        self.assertAlmostEqual(first["fy_child_N"], y * math.cos(0.5) - x * math.sin(0.5), delta=1e-13)

    def test_components_in_the_child_axes_that_the_constraints_determine(self):
        """A parallelogram in the x-y plane: what acts along z and about x and y is open, the rest is not, in both axes."""
        rows = json.loads(self.ask("trace", "four-bar-2", "--method", "atwood/dop853", "--joints", "--json").stdout)
        open_in_world, open_in_child = set(), set()
        for row in rows:
            for name in ("fx_N", "fy_N", "fz_N", "tx_N_m", "ty_N_m", "tz_N_m"):
                child = name.replace("_N", "_child_N", 1)
                if row[name] == "not unique":
                    open_in_world.add(name)
                if row[child] == "not unique":
                    open_in_child.add(name)
        self.assertTrue(open_in_world)
        self.assertEqual(open_in_child, open_in_world)

    def advise(self, scene, *words, code=0, told=()):
        methods = [word for method in ("explicit-euler", "rk4", "dop853") for word in ("--method", f"atwood/{method}")]
        return self.ask("advise", scene, "--metric", "joint", *methods, *words, code=code, told=told).stdout

    def test_advice_judges_angles_and_offsets(self):
        scene = self.path("hs.toml", TURN_AND_SLIDE)
        both = json.loads(self.advise(scene, "--error", "1e-4", "--json"))
        self.assertEqual((both["metric"], both["unit"], both["not_judged"]), ("error-joint-coordinate", "rad, m", ""))
        self.assertNotEqual(both["advice"]["method"], "atwood/explicit-euler")
        self.assertGreater(both["advice"]["error"], 1e-14)  # the slider's: the hinge turns evenly
        offsets = json.loads(self.advise(scene, "--error", "0.1mm", "--json"))
        self.assertEqual((offsets["metric"], offsets["unit"]), ("error-joint-offset", "m"))
        self.assertNotEqual(offsets["advice"]["method"], "atwood/explicit-euler")
        self.assertIn("angles of joints; their error in this run is", offsets["not_judged"])
        angles = self.advise(scene, "--error", "1e-9rad")
        self.assertRegex(angles, r"not judged offsets of joints; their error in this run is \S+ m")
        self.ask("compare", "atwood/rk4", "atwood/heun", "--scenario", scene, "--metric", "joint", "--error", "1e-9rad",
                 told=["hs: offsets of joints are not judged; their errors in these runs: "])

    def test_advice_leaves_prescribed_joints_out(self):
        driven = TURN_AND_SLIDE.replace("rate_rad_per_s = 0.1", "driven_rate_rad_per_s = 0.1").replace("800]", "800, 1600]")
        scene = self.path("driven.toml", driven)
        both = json.loads(self.advise(scene, "--error", "1e-4", "--json"))
        self.assertEqual((both["unit"], both["advice"]["method"] == "atwood/explicit-euler"), ("m", False))
        self.advise(scene, "--error", "1e-9rad", code=2,
                    told=["--metric joint: no joint of `hs` has an angle that is not prescribed"])
        self.advise(self.path("bar.toml", PENDULUM), "--error", "1e-9m", code=2,
                    told=["--metric joint: no joint of `bar` has an offset that is not prescribed"])
        run = self.ask("run", "--scenario", scene, "--method", "atwood/rk4", "--no-timing", "--json").stdout
        orders = [row for row in json.loads(run)["rows"] if row["metric"] == "order-joint-coordinate"]
        self.assertAlmostEqual(orders[0]["value"], 4, delta=0.3)

    def test_the_force_of_a_stop_has_columns_of_its_own(self):
        """A door pressed against its stop by -2 cos(t + 0.4) N m: the stop bears it until it pulls, at pi / 2 - 0.4."""
        force = '[[force]]\nkind = "joint-torque"\njoint = "pin"\ntorque_N_m = -2\nangular_frequency_rad_per_s = 1\nphase_rad = 0.4\n'
        door = PENDULUM.replace("[0, -10, 0]", "[0, 0, 0]").replace("angle_rad = 0.5", "limits_rad = [0, 2]") + force
        door = self.path("door.toml", door.replace("t_end_s = 1", "t_end_s = 2").replace("samples = 1", "samples = 2"))

        def trace(*words):
            return list(csv.DictReader(io.StringIO(self.ask("trace", door, *words).stdout)))
        for method in ("truth", "atwood/dop853", "atwood/rk4"):
            rows = trace("--method", method, "--joints")
            self.assertAlmostEqual(float(rows[1]["applied0"]), -2 * math.cos(1.4), delta=1e-14, msg=method)
            self.assertAlmostEqual(float(rows[1]["stop0"]), 2 * math.cos(1.4), delta=1e-14, msg=method)
            self.assertAlmostEqual(float(rows[1]["tz_N_m"]), 0, delta=1e-14, msg=method)
            self.assertEqual((float(rows[2]["stop0"]), rows[2]["stop1"]), (0, ""), method)
            events = trace("--method", method, "--events")
            self.assertEqual([row["kind"] for row in events], ["rest", "separate"], method)
            self.assertAlmostEqual(float(events[1]["t_s"]), math.pi / 2 - 0.4, delta=1e-12, msg=method)
        told = json.loads(self.ask("trace", door, "--method", "truth", "--joints", "--json").stdout)[1]
        self.assertAlmostEqual(float(told["stop0"]), 2 * math.cos(1.4), delta=1e-14)

    def test_a_force_that_begins_at_zero_holds_a_coordinate_at_its_stop(self):
        """A door at rest at its stop under cos 2t - 1 N m: zero at the start with its rate, and never positive."""
        force = '[[force]]\nkind = "joint-torque"\njoint = "pin"\ntorque_N_m = '
        door = PENDULUM.replace("[0, -10, 0]", "[0, 0, 0]").replace("angle_rad = 0.5", "limits_rad = [0, 2]")
        door = self.path("door.toml", door + force + "1\nangular_frequency_rad_per_s = 2\n" + force + "-1\n")
        for method in ("atwood/rk4", "atwood/gauss4", "atwood/dop853"):
            end = list(csv.DictReader(io.StringIO(self.ask("trace", door, "--method", method, "--joints").stdout)))[-1]
            self.assertAlmostEqual(float(end["q0"]), 0, delta=1e-18, msg=method)
            self.assertAlmostEqual(float(end["u0"]), 0, delta=1e-18, msg=method)
            self.assertAlmostEqual(float(end["stop0"]), 1 - math.cos(2), delta=1e-14, msg=method)
        self.ask("trace", door, "--method", "truth", code=1, told=[
            "unsupported: joint `pin` is at its stop, and neither its rate nor the force there decides whether it stays"])

    def test_what_is_not_there_or_not_simulated(self):
        self.trace("--method", "atwood/rk4", "--ropes", code=2, told=["`bar` has no rope"])
        self.ask("trace", "kepler-e0.6", "--method", "atwood/rk4", "--joints", code=2, told=["has no joint"])
        worker = os.path.join(ROOT, "reference", "your_engine", "worker.py")
        self.trace("--engine", worker, "--method", "python/symplectic-euler", "--joints", code=1,
                   told=["unsupported: python simulates no joints"])
        self.ask("describe", self.path("bar.toml", PENDULUM), told=["`pin`: hinge, the world to `bar`; starts at 0.5 rad"])
        bad = self.path("bad.toml", PENDULUM.replace('"bar"]', '"beam"]'))
        self.ask("trace", bad, "--method", "atwood/rk4", code=2, told=["bad.toml:15:20: `bodies` in [[joint]] `pin` is \"beam\""])

    def test_import_of_urdf(self):
        result = self.ask("import", self.path("arm.urdf", URDF), "-o", "arm.toml",
                          told=["mesh package://arm/upper.stl", "its friction is not taken", "starts at its limit 0.1"])
        self.assertEqual(result.stdout, "")
        scene = json.loads(self.ask("describe", os.path.join(self.here, "arm.toml"), "--json").stdout)
        scene = scene.get("scene", scene)
        bodies = {body["name"]: body for body in scene["bodies"]}
        # The shoulder stands at height 1, the flange one above it, turned by a quarter: its y is the upper link's -x. The
        # slide starts at 0.1 along z, the centre of `lower` is 0.25 above its frame.
        for found, expected in zip(bodies["upper"]["position_m"] + bodies["lower"]["position_m"], [0, 0, 1.5, -0.1, 0, 2.35]):
            self.assertAlmostEqual(found, expected, delta=1e-15)
        self.assertAlmostEqual(bodies["lower"]["inertia_kg_m2"][0], 0.2, delta=1e-15)  # turned with its frame
        self.assertEqual([joint["kind"] for joint in scene["joints"]], ["hinge", "slider"])
        self.assertEqual(scene["joint_forces"][0]["damping_N_m_s_per_rad"], 0.3)

    def test_motors_that_bullet_holds_over_a_step(self):
        """bullet64/multibody-rk4 moves arm-6 as if every motor were late by half a step (docs/joints.md)."""
        steps = 8000
        with open(os.path.join(ROOT, "validation/scenarios/arm-6.toml")) as file:
            arm = file.read()
        lines, frequency = [], 0.0
        for line in arm.replace('"arm-6"', '"arm-late"').splitlines():
            if line.startswith("angular_frequency_rad_per_s"):
                frequency = float(line.split("=")[1])
            if line.startswith("phase_rad"):
                line = f"phase_rad = {float(line.split('=')[1]) - frequency / steps / 2!r}"
            lines.append(line)

        def end(scene, method, count):
            rows = csv.DictReader(io.StringIO(self.ask("trace", scene, "--method", method, "--steps", str(count), "--samples",
                                                       "1", "--joints").stdout))
            return [float(row["q0"]) for row in rows if float(row["t_s"]) > 0]

        late = end(self.path("late.toml", "\n".join(lines)), "atwood/dop853", 4000)
        on_time, bullet = end("arm-6", "atwood/dop853", 4000), end("arm-6", "bullet64/multibody-rk4", steps)
        self.assertEqual(len(bullet), 6)
        self.assertGreater(max(abs(a - b) for a, b in zip(bullet, on_time)), 0.3)
        self.assertLess(max(abs(a - b) for a, b in zip(bullet, late)), 1e-4)

    def test_urdf_that_is_no_mechanism(self):
        for before, after, told in (
                ('<child link="lower"/>', '<child link="x"/>', "arm.urdf:15: joint `slide` names the child link `x`"),
                ('type="prismatic"', 'type="planar"', "is of the type `planar`; expected revolute"),
                ('<link name="flange"/>', '<link name="flange"/><link name="spare"/>', "found 2 links that no joint holds"),
                ('<mass value="1"/>', '<mass value="0"/>', "link `lower` moves by the joint `slide` and has no mass"),
                ('lower="-1"', 'lower="3"', "has the limits 3 and 2"),
                ('<axis xyz="0 1 0"/>', '<axis xyz="0 1 0"/><mimic joint="slide"/>', "joint `shoulder` mimics another joint"),
                ('xyz="0 0 0.5"', 'xyz="0 0 up"', "`xyz` of <origin> is \"0 0 up\"; expected 3 numbers"),
                ("</robot>", "", "found no XML")):
            self.assertIn(before, URDF)
            self.ask("import", self.path("arm.urdf", URDF.replace(before, after)), code=2, told=[told])
        self.ask("import", self.path("other.xml", "<html/>"), code=2, told=["found <html>; expected <robot> (URDF) or <mujoco>"])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
