"""MuJoCo 3 beside MuJoCo 2.2: what both compute by the same method agrees, so that two adapters written apart agree too.
Jolt beside one-joint motions of MuJoCo. agreement_test.py BIN_DIR; what is not built is left out."""
import json
import math
import os
import subprocess
import sys
import tempfile
import unittest

from workers import Run, Worker, across_a_weld, ball, body, exp, floor, law, scene, turned

BIN_DIR = sys.argv[1]
INERTIA = [0.1, 0.01, 0.02, 0.01, 0.2, 0.03, 0.02, 0.03, 0.25]


def built(*names):
    return all(os.path.exists(f"{BIN_DIR}/atwood-{name}") for name in names)


def hanging(kind, q, forces=(), body_changes=None, **joint):
    """One body at a joint to the world at the origin, 0.7 m above its centre; q: its attitude at the start."""
    anchor = [0, 0.7, 0]
    made = {"name": "joint", "kind": kind, "bodies": ["world", "body"], "anchors_body_m": [[0, 0, 0], anchor],
            "frame_wxyz": [1, 0, 0, 0], "closes_loop": False, **joint}
    one = body(inertia_kg_m2=INERTIA, position_m=[-x for x in turned(q, anchor)], orientation_wxyz=q, **(body_changes or {}))
    more = {"joint_forces": [{"joint": "joint", **force} for force in forces]} if forces else {}
    return scene(one, gravity=(0.3, -9.81, 0.2), joints=[made], **more)


SPRING = {"kind": "joint-spring", "stiffness_N_m_per_rad": 5, "rest_rad": 0.3, "damping_N_m_s_per_rad": 0.2}
MOTOR = {"kind": "joint-torque", "torque_N_m": 3, "angular_frequency_rad_per_s": 2, "phase_rad": 0.1, "on_s": [[0.25, 0.75]]}
Z = [0, 0, 1]
JOINTS = {
    "hinge": hanging("hinge", exp([0, 0, 1]), axis_body=Z, coordinates=[1.0], rates=[0.0]),
    "hinge with a stop": hanging("hinge", exp([0, 0, 1]), axis_body=Z, coordinates=[1.0], rates=[0.0], limits_rad=[0.2, 1.2]),
    "hinge with a spring": hanging("hinge", exp([0, 0, 1]), [SPRING], axis_body=Z, coordinates=[1.0], rates=[0.0]),
    "hinge with a motor": hanging("hinge", exp([0, 0, 1]), [MOTOR], axis_body=Z, coordinates=[1.0], rates=[0.0]),
    "slider": hanging("slider", [1, 0, 0, 0], axis_body=[0.6, 0.8, 0], coordinates=[0.0], rates=[0.0]),
    "cylindrical": hanging("cylindrical", [1, 0, 0, 0], axis_body=[0.6, 0.8, 0], coordinates=[0.0, 0.0], rates=[0.0, 0.0]),
    "universal": hanging("universal", exp([0, 0, 0.3]), axes_body=[[1, 0, 0], Z], coordinates=[0.0, 0.3], rates=[0.0, 0.0]),
    "ball": hanging("ball", exp([0, 0, 1]), coordinates=exp([0, 0, 1]), rates=[0, 2, 0],
                    body_changes={"angular_velocity_body_rad_per_s": [0, 2, 0]}),
}


class Agreement(unittest.TestCase):
    def worker(self, name):
        made = Worker(BIN_DIR, name)
        self.addCleanup(made.close)
        return made

    def joints(self, worker, scheme, of, t_end_s, steps):
        run = Run(worker, scheme, of, t_end_s, steps, samples=4)
        self.assertEqual(run.done["status"], "ok", run.done)
        return [x for sample in run.samples for x in map(float, sample["joints"][0] + sample["bodies"][0])]

    @unittest.skipUnless(built("mujoco", "mujoco3"), "one of the two is not built")
    def test_joints_of_both_mujocos_and_their_reactions(self):
        old, new = self.worker("mujoco"), self.worker("mujoco3")
        for name, of in JOINTS.items():
            for schemes in (("default", "default"), ("stiff", "stiff")) if name != "hinge with a motor" else (("default", "default"),):
                # motors: 2.2.2 evaluates them at each stage of RK4, 3 once a step
                rows = [self.joints(worker, scheme, of, 1, 240) for worker, scheme in zip((old, new), schemes)]
                with self.subTest(joint=name, schemes=schemes):
                    self.assertEqual(len(rows[0]), len(rows[1]))
                    self.assertLess(max(abs(a - b) for a, b in zip(*rows)), 1e-9)

    @unittest.skipUnless(built("mujoco", "mujoco3"), "one of the two is not built")
    def test_free_flight_of_both_mujocos(self):
        drag = {"kind": "drag", "model": "linear", "bodies": ["body"], "coefficient_kg_per_s": 0.3, "wind_m_per_s": [1, 0, 0],
                "angular_coefficient_N_m_s": 0.02}
        start = body(inertia_kg_m2=INERTIA, velocity_m_per_s=[1, 2, 3], angular_velocity_body_rad_per_s=[0.4, 2, 0.3],
                     orientation_wxyz=[0.5, 0.5, -0.5, 0.5])
        for schemes in (("default", "default"), ("rk4", "rk4"), ("implicit", "implicit"), ("stiff", "stiff")):
            # 2.2.2 evaluates the scene's forces at each stage of RK4, 3 once a step
            forces = [drag] if schemes[0] in ("default", "implicit") else []
            rows = [self.worker(name).end(scheme, scene(start, gravity=(0, 1, -9.8), forces=forces), 2, 240)[0]
                    for name, scheme in zip(("mujoco", "mujoco3"), schemes)]
            with self.subTest(schemes=schemes):
                self.assertLess(max(abs(a - b) for r, s in zip(*rows) for a, b in zip(r, s)), 1e-10)

    @unittest.skipUnless(built("mujoco", "mujoco3"), "one of the two is not built")
    def test_contacts_of_both_mujocos(self):
        """Rolling and sliding with two laws on one floor: what differs is the solver's and the collision's, under a millimetre."""
        laws = [law(friction=0.3, rolling_friction_m=1e-3), law("stone", "ice", friction=0.1), law("ice", "ice", friction=0.05)]
        slab = body("slab", inertia_kg_m2=[0.09, 0, 0, 0, 0.09, 0, 0, 0, 0.17], shape={"box": {"half_extents_m": [0.5, 0.5, 0.1]}},
                    position_m=[0, 3, 0.1], velocity_m_per_s=[1, 0.5, 0], material="ice")
        roll = ball(position_m=[0, 0, 0.1], velocity_m_per_s=[1, 0, 0], angular_velocity_body_rad_per_s=[0, 0, 3])
        of = scene(roll, slab, floor(), gravity=(0, 0, -9.81), laws=laws)
        old, new = (self.worker(name).end(scheme, of, 1, 480) for name, scheme in (("mujoco", "stiff"), ("mujoco3", "stiff")))
        for a, b in zip(old, new):
            self.assertLess(math.dist(a[0], b[0]), 1e-3)
        self.assertLess(old[0][0][0], 0.71)  # from 1 m/s it rolls at 5/7, and slows

    @unittest.skipUnless(built("mujoco", "mujoco3"), "one of the two is not built")
    def test_spinning_balls_thrown_at_a_slanted_plane_in_both_mujocos(self):
        """Three masses, three directions of the slip, the plane as first body or as second, its own pose without effect."""
        both = [self.worker(name) for name in ("mujoco", "mujoco3")]
        n = [2 / 7, -3 / 7, 6 / 7]
        slant = body("slant", fixed=True, mass_kg=0, shape={"plane": {"normal": n, "offset_m": 0.3}}, position_m=[3, 1, 2],
                     orientation_wxyz=exp([0.3, 0.2, -1]))
        slips = [3 / 7, 6 / 7, 2 / 7], [-6 / 7, 2 / 7, 3 / 7], [-3 / 7, -6 / 7, -2 / 7]
        for mass_kg, slip, friction in zip((0.1, 3, 40), slips, (0.1, 0.4, 0.2)):
            thrown = ball("thrown", 0.2, mass_kg, position_m=[0.8 * x for x in n], velocity_m_per_s=[3 * a - 2 * b for a, b in zip(slip, n)],
                          angular_velocity_body_rad_per_s=[5, -3, 4], orientation_wxyz=exp([0.4, -0.7, 0.3]))
            for bodies in ((slant, thrown), (thrown, slant)):
                of = scene(*bodies, gravity=[-9 * x for x in n], laws=[law(friction=friction)])
                for schemes, bound in ((("default", "default"), 1e-11), (("stiff", "stiff"), 1e-6)):
                    rows = [worker.end(scheme, of, 1, 480)[bodies.index(thrown)] for worker, scheme in zip(both, schemes)]
                    with self.subTest(mass_kg=mass_kg, schemes=schemes):
                        self.assertGreater(sum(a * b for a, b in zip(rows[0][0], n)), 0.45)  # it lies on the plane, or hops
                        self.assertLess(max(abs(a - b) for r, s in zip(*rows) for a, b in zip(r, s)), bound)

    @unittest.skipUnless(built("mujoco", "mujoco3"), "one of the two is not built")
    def test_a_ball_at_rest_sinks_in_both_mujocos_as_their_manual_says(self):
        """Frictionless, one contact: (1 - d) g = d^2 k |r|, k = 1 / (d_most^2 tau^2), with the impedance d of the overlap r."""
        g, tau, least, most, width = 10, 0.02, 0.9, 0.95, 0.001
        overlap = 0
        for _ in range(100):
            x = overlap / width
            d = least + (most - least) * (2 * x * x if x <= 0.5 else 1 - 2 * (1 - x)**2)
            overlap = (1 - d) * g * (most * tau / d)**2
        tilt = [0.6, 0, 0.8]
        slant = body("slant", fixed=True, mass_kg=0, shape={"plane": {"normal": tilt, "offset_m": 0.5}}, position_m=[7, 8, 9])
        lying = ball(position_m=[0, 0, 0.1]), ball(position_m=[0.6 * n for n in tilt])
        for name in ("mujoco", "mujoco3"):
            for bodies, down in (((floor(), lying[0]), [0, 0, -g]), ((lying[0], floor()), [0, 0, -g]), ((slant, lying[1]), [-g * n for n in tilt])):
                run = Run(self.worker(name), "default", scene(*bodies, gravity=down), 3, 720)
                with self.subTest(engine=name, down=down):
                    (row,) = run.samples[-1]["contacts"]
                    self.assertAlmostEqual(float(row[8]), -overlap, delta=1e-9)
                    self.assertAlmostEqual(float(row[9]), g * lying[0]["mass_kg"], delta=1e-6)

    @unittest.skipUnless(built("mujoco", "mujoco3"), "one of the two is not built")
    def test_bodies_collide_across_a_weld_in_both_mujocos(self):
        for name in ("mujoco", "mujoco3"):
            run = Run(self.worker(name), "default", across_a_weld(), 0.5, 240)
            self.assertEqual(run.done["status"], "ok", run.done)
            # how far a deep overlap throws them depends on the collision's algorithm
            self.assertLess(run.samples[-1]["joints"][0][0], -0.02, name)

    @unittest.skipUnless(built("mujoco3", "truth") and os.path.exists(f"{BIN_DIR}/atwood"), "one of them is not built")
    def test_the_default_study_allows_the_step_at_which_mujoco_s_euler_is_unstable(self):
        with tempfile.TemporaryDirectory() as out:
            ended = subprocess.run([f"{BIN_DIR}/atwood", "run", "default", "--scenario", "free-box-*", "--method", "mujoco3/default", "--steps", "120",
                                    "--no-timing", "--limit", "120", "--out", out], text=True, capture_output=True)
        self.assertIn("2 not finite", ended.stdout)
        self.assertEqual(ended.returncode, 0, ended.stdout)

    @unittest.skipUnless(built("mujoco", "mujoco3") and os.path.exists(f"{BIN_DIR}/atwood"), "one of them is not built")
    def test_loops_of_both_mujocos_ahead_of_the_singular_position(self):
        described = subprocess.run([f"{BIN_DIR}/atwood", "describe", "four-bar-1", "--json"], capture_output=True, check=True)
        of = json.loads(described.stdout)["scene"]
        rows = []
        for name, scheme in (("mujoco", "stiff"), ("mujoco3", "stiff")):
            run = Run(self.worker(name), scheme, of, 0.625, 160)
            self.assertEqual(run.done["status"], "ok", run.done)
            rows.append([float(x) for joint in run.samples[-1]["joints"] for x in joint])
        self.assertLess(rows[0][0], -1)
        self.assertLess(max(abs(a - b) for a, b in zip(*rows, strict=True)), 1e-4)

    @unittest.skipUnless(built("jolt", "mujoco3"), "one of the two is not built")
    def test_joints_of_jolt_are_those_of_mujoco(self):
        jolt, other = self.worker("jolt"), self.worker("mujoco3")
        for name, of in JOINTS.items():
            p, q = jolt.end("default", of, 1, 960)[0][:2]
            p_other, q_other = other.end("rk4", of, 1, 960)[0][:2]
            with self.subTest(joint=name):
                self.assertLess(math.dist(p, p_other), 0.02)
                self.assertGreater(abs(sum(a * b for a, b in zip(q, q_other))), 1 - 2e-4)


if __name__ == "__main__":
    if not built("mujoco3"):
        print("mujoco3 is not built")
        sys.exit(77)
    unittest.main(argv=sys.argv[:1] + sys.argv[2:])
