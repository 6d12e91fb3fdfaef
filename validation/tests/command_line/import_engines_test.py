"""One arm as URDF and as MJCF: both imports move alike, in every engine that is built. Called with the program."""
import csv
import io
import os
import unittest

from case import ATWOOD, Case

URDF = """<?xml version="1.0"?>
<robot name="arm">
  <link name="base"/>
  <link name="upper"><inertial><origin xyz="0 0 -0.5"/><mass value="2"/>
    <inertia ixx="0.2" ixy="0" ixz="0" iyy="0.2" iyz="0" izz="0.05"/></inertial></link>
  <link name="lower"><inertial><origin xyz="0 0 -0.25" rpy="0 0 0.3"/><mass value="1"/>
    <inertia ixx="0.05" ixy="0" ixz="0" iyy="0.06" iyz="0" izz="0.02"/></inertial></link>
  <joint name="shoulder" type="continuous"><parent link="base"/><child link="upper"/>
    <origin xyz="0 0 1" rpy="0 0.4 0"/><axis xyz="0 1 0"/><dynamics damping="0.05"/></joint>
  <joint name="elbow" type="continuous"><parent link="upper"/><child link="lower"/>
    <origin xyz="0 0 -1" rpy="0.5 0 0"/><axis xyz="1 0 0"/><dynamics damping="0.05"/></joint>
</robot>
"""
MJCF = """<mujoco model="arm">
  <compiler angle="radian"/>
  <option gravity="0 0 -9.81"/>
  <default><joint damping="0.05"/></default>
  <worldbody>
    <body name="upper" pos="0 0 1" euler="0 0.4 0">
      <joint name="shoulder" type="hinge" axis="0 1 0"/>
      <inertial pos="0 0 -0.5" mass="2" diaginertia="0.2 0.2 0.05"/>
      <body name="lower" pos="0 0 -1" euler="0.5 0 0">
        <joint name="elbow" type="hinge" axis="1 0 0"/>
        <inertial pos="0 0 -0.25" euler="0 0 0.3" mass="1" diaginertia="0.05 0.06 0.02"/>
      </body>
    </body>
  </worldbody>
</mujoco>
"""
# The largest error of an angle after 1 s at 2000 steps [rad]. Methods of order 1: h times the size of the motion.
METHODS = {"atwood/dop853": 1e-11, "cvode/adams:1e-10": 1e-7, "ida/bdf:1e-9": 1e-7, "simbody/default": 1e-8,
           "mujoco/rk4": 1e-8, "mujoco/default": 2e-3, "bullet64/default": 2e-3, "bullet64/multibody": 2e-3,
           "bullet32/default": 2e-3, "ode/default": 2e-3, "dart/default": 2e-3, "rapier/default": 2e-3, "jolt/default": 2e-3,
           "mujoco3/default": 2e-3}


def is_built(engine):
    return os.path.exists(os.path.join(os.path.dirname(ATWOOD), engine if "/" in engine else "atwood-" + engine))


class Imports(Case):
    def end(self, scene, method):
        steps = [] if method == "truth" else ["--steps", "2000"]
        result = self.ask("trace", scene, "--method", method, *steps, "--joints", "--samples", "50")
        rows = list(csv.DictReader(line for line in io.StringIO(result.stdout) if not line.startswith("#")))
        return [float(next(row["q0"] for row in reversed(rows) if row["joint"] == joint)) for joint in ("shoulder", "elbow")]

    def imported(self, name, text):
        scene = self.path(name.replace(".", "-") + ".toml")
        self.ask("import", self.path(name, text), "-o", scene)
        return scene

    def judge(self, scene, truth):
        for method, most in METHODS.items():
            if not is_built(method.split("/")[0]):
                continue
            with self.subTest(scene=os.path.basename(scene), method=method):
                for found, exact in zip(self.end(scene, method), truth):
                    self.assertLess(abs(found - exact), most)

    def test_urdf(self):
        scene = self.imported("arm.urdf", URDF)
        truth = self.end(scene, "truth")
        self.assertGreater(abs(truth[0]), 0.3)  # it moves, and both joints do
        self.assertGreater(abs(truth[1]), 0.3)
        self.judge(scene, truth)

    def test_mjcf(self):
        if not is_built("mujoco-import"):
            self.skipTest("without MuJoCo no MJCF is read")
        scene = self.imported("arm.xml", MJCF)
        truth = self.end(scene, "truth")
        for found, urdf in zip(truth, self.end(self.imported("arm.urdf", URDF), "truth")):
            self.assertLess(abs(found - urdf), 1e-12)
        self.judge(scene, truth)


if __name__ == "__main__":
    import sys
    unittest.main(argv=sys.argv[:1])
