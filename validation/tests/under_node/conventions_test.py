"""Scenes of known answer for the engines that run under Node.js: a frame, a unit or a coefficient that an adapter mistakes
shows in one of them. conventions_test.py BIN_DIR NAME; an engine that is not built is left out."""
import json
import math
import os
import shutil
import subprocess
import sys
import unittest

from workers import Run, Worker, across_a_weld, ball, body, bounced, exp, floor, law, scene, turned

BIN_DIR, NAME = sys.argv[1], sys.argv[2]
FLOAT = NAME != "mujoco3"
ROUND_OFF = 3e-6 if FLOAT else 1e-12  # relative, of some hundred steps
RESTITUTION = NAME != "mujoco3"
QUARTER = [math.sqrt(0.5), math.sqrt(0.5), 0, 0]  # a quarter turn about x: body y is world z
FULL_INERTIA = [0.25, 0.05, 0, 0.05, 0.25, 0, 0, 0, 0.4]  # principal axes at 45 degrees, moments 0.2, 0.3, 0.4


class Conventions(unittest.TestCase):
    def setUp(self):
        self.worker = Worker(BIN_DIR, NAME)
        self.addCleanup(self.worker.close)

    def near(self, found, expected, tolerance):
        self.assertLessEqual(max(abs(a - b) for a, b in zip(found, expected, strict=True)), tolerance, f"{found} is not {expected}")

    def test_gravity_is_that_of_the_scene_and_stepped_semi_implicitly(self):
        p, _, v, _ = self.worker.end("default", scene(body(velocity_m_per_s=[3, 0, 1]), gravity=(0, 2, -9.8)), 2, 128)[0]
        h = 2 / 128
        self.near(v, [3, 4, 1 - 19.6], 30 * ROUND_OFF)
        self.near(p, [6, 4 + 2 * h, 2 - 19.6 - 9.8 * h], 30 * ROUND_OFF)

    def test_nothing_is_damped_or_cut(self):
        fast = body(velocity_m_per_s=[3000, 0, 0], angular_velocity_body_rad_per_s=[0, 0, 300])
        slow = body("slow", position_m=[0, 50, 0], velocity_m_per_s=[1e-3, 0, 0], angular_velocity_body_rad_per_s=[0, 0, 1e-3])
        found = self.worker.end("default", scene(fast, slow), 8, 512)
        self.near(found[0][2] + found[0][3], [3000, 0, 0, 0, 0, 300], 3000 * ROUND_OFF)
        self.near(found[1][0], [8e-3, 50, 0], 50 * ROUND_OFF)
        self.near(found[1][3], [0, 0, 1e-3], 1e-3 * 30 * ROUND_OFF)

    def test_rates_are_of_the_body(self):
        start = body(orientation_wxyz=QUARTER, angular_velocity_body_rad_per_s=[0, 0, 2])
        _, q, _, w = self.worker.end("default", scene(start), 0.5, 200)[0]
        turned = [math.cos(0.5), 0, 0, math.sin(0.5)]  # about body z, then the start
        s = math.sqrt(0.5)
        self.near(q, [s * turned[0], s * turned[0], -s * turned[3], s * turned[3]], 100 * ROUND_OFF)
        self.near(w, [0, 0, 2], 100 * ROUND_OFF)

    def test_a_force_at_a_point_turns_by_the_inertia_of_the_body_axes(self):
        push = {"kind": "point-force", "body": "body", "point_body_m": [0, 1, 0], "force_N": [0, 0, 3]}
        still = body(inertia_kg_m2=FULL_INERTIA, orientation_wxyz=QUARTER, mass_kg=2)
        _, _, v, w = self.worker.end("default", scene(still, forces=[push]), 1e-3, 1)[0]
        self.near(v, [0, 0, 1.5e-3], 1.5e-3 * 30 * ROUND_OFF)
        self.near(w, [0, 0, 0], 1e-8)  # body y is world z: the force has no moment
        across = {**push, "force_N": [0, 3, 0]}  # world y is body -z: the moment is y x -z = -x of the body
        _, _, _, w = self.worker.end("default", scene(still, forces=[across]), 1e-3, 1)[0]
        determinant = 0.25 * 0.25 - 0.05 * 0.05
        self.near(w, [-3e-3 * 0.25 / determinant, 3e-3 * 0.05 / determinant, 0], 1e-2 * 30 * ROUND_OFF)
        upward = {**push, "point_body_m": [1, 0, 0]}  # x cross world z is world -y, which is body z
        _, _, _, w = self.worker.end("default", scene(still, forces=[upward]), 1e-3, 1)[0]
        self.near(w, [0, 0, 3e-3 / 0.4], 1e-2 * 30 * ROUND_OFF)

    def test_a_thruster_turns_with_its_body_and_switches_at_its_times(self):
        thrust = {"kind": "thruster", "body": "body", "point_body_m": [0, 0, 0], "direction_body": [0, 1, 0], "thrust_N": 4,
                  "on_s": [[0.25, 0.75]]}
        _, _, v, _ = self.worker.end("default", scene(body(orientation_wxyz=QUARTER), forces=[thrust]), 1, 64)[0]
        self.near(v, [0, 0, 2], 100 * ROUND_OFF)

    @unittest.skipUnless(NAME == "mujoco3", "the others have one integrator")
    def test_runge_and_kutta_s_method_has_a_force_of_the_adapter_constant_over_a_step(self):
        """x += h v + h^2 a / 2, v += h a: the energy of an oscillator of 1 rad/s grows by the factor 1 + h^2 / 2 a step."""
        pull = {"kind": "spring", "bodies": ["body"], "anchor_m": [0, 0, 0], "stiffness_N_per_m": 1, "damping_N_s_per_m": 0,
                "rest_length_m": 0, "points_body_m": [[0, 0, 0]]}
        h, steps = 0.125, 160
        p, _, v, _ = self.worker.end("rk4", scene(body(position_m=[1, 0, 0]), forces=[pull]), h * steps, steps)[0]
        x, u = 1.0, 0.0
        for _ in range(steps):
            x, u = x + h * u - h * h / 2 * x, u - h * x
        self.near([p[0], v[0]], [x, u], 1e-10)

    def test_the_tumbling_box_keeps_its_angular_momentum_in_the_limit_of_small_steps(self):
        moments = [0.2, 0.3, 0.4]
        start = body(inertia_kg_m2=[0.2, 0, 0, 0, 0.3, 0, 0, 0, 0.4], angular_velocity_body_rad_per_s=[1, 0.5, 2])

        def momentum(row):
            _, (w, x, y, z), _, rate = row
            l = [m * u for m, u in zip(moments, rate)]
            r = [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                 [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                 [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]
            return [sum(a * b for a, b in zip(row, l)) for row in r]

        drift = []
        for steps in (100, 200):
            end = momentum(self.worker.end("default", scene(start), 1, steps)[0])
            drift.append(math.dist(end, [0.2, 0.15, 0.8]))
        self.assertLess(drift[0], 0.01)  # without the gyroscopic term: 0.2
        self.assertAlmostEqual(drift[0] / drift[1], 2, delta=0.2)

    @unittest.skipIf(NAME == "mujoco3", "its dampers are MuJoCo's own")
    def test_a_damper_beyond_c_h_2_i_is_named_with_the_bound(self):
        """I = 0.01 + 0.1 x 0.1^2 = 0.011 kg m2 about the hinge, c = 50 N m s: c h = 2 I at 0.44 ms."""
        link = body("link", mass_kg=0.1, inertia_kg_m2=[0.01, 0, 0, 0, 0.01, 0, 0, 0, 0.01], position_m=[0, 0, -0.1])
        hinge = {"name": "pin", "kind": "hinge", "bodies": ["world", "link"], "anchors_body_m": [[0, 0, 0], [0, 0, 0.1]],
                 "axis_body": [0, 1, 0], "coordinates": [0.0], "rates": [1.0], "frame_wxyz": [1, 0, 0, 0], "closes_loop": False}
        link["angular_velocity_body_rad_per_s"], link["velocity_m_per_s"] = [0, 1, 0], [-0.1, 0, 0]
        damper = {"kind": "joint-spring", "joint": "pin", "damping_N_m_s_per_rad": 50}
        of = scene(link, gravity=(0, 0, -9.8), joints=[hinge], joint_forces=[damper])
        within = Run(self.worker, "default", of, 0.4, 1000).done
        self.assertEqual(within["status"], "ok", within)
        self.assertNotIn("unstable", within["reason"])
        beyond = Run(self.worker, "default", of, 0.4, 100).done
        self.assertEqual(beyond["status"], "diverged", beyond)
        self.assertIn("the damper of the joint `pin` is explicit", beyond["reason"])
        self.assertIn("beyond c h = 2 I: h = 0.00044 s; the step is 0.004 s", beyond["reason"])

    def test_a_held_body_starts_when_it_is_released(self):
        held = body(release_s=0.5, velocity_m_per_s=[1, 0, 0], angular_velocity_body_rad_per_s=[0, 0, 1])
        run = Run(self.worker, "default", scene(held), 1, 64, samples=2)
        self.assertEqual(run.done["status"], "ok")
        self.near(run.samples[1]["bodies"][0][:3], [0, 0, 0], 0)
        self.near(run.samples[2]["bodies"][0][:3], [0.5, 0, 0], 30 * ROUND_OFF)
        self.near(run.samples[2]["bodies"][0][12:], [1], 30 * ROUND_OFF)

    def test_a_held_body_stands_where_it_is_struck(self):
        balls = [ball("held", release_s=1), ball("thrown", position_m=[-1, 0, 0], velocity_m_per_s=[4, 0, 0])]
        found = self.worker.end("default", scene(*balls), 0.5, 128)
        self.assertLess(found[1][2][0], 0.1)  # a free one of equal mass would leave half the velocity

    def test_shapes_stand_where_the_scene_says(self):
        """Each lies on the floor where its extent along z says; MuJoCo's contacts give by some 1e-4 m."""
        shapes = {"box": ({"half_extents_m": [0.1, 0.2, 0.3]}, 0.3), "sphere": ({"radius_m": 0.2}, 0.2),
                  "capsule": ({"radius_m": 0.1, "half_length_m": 0.2}, 0.3), "cylinder": ({"radius_m": 0.2, "half_length_m": 0.15}, 0.15),
                  "convex": ({"points_m": [[x, y, z] for x in (-0.1, 0.1) for y in (-0.2, 0.2) for z in (-0.25, 0.25)]}, 0.25),
                  "compound": ({"boxes": [{"half_extents_m": [0.1, 0.1, 0.35], "position_body_m": [0, 0, 0],
                                           "orientation_wxyz": [1, 0, 0, 0]}]}, 0.35)}
        for kind, (shape, height_m) in shapes.items():
            for lift_m, touching in ((0.002, False), (-0.002, True)):
                on = body(shape={kind: shape}, position_m=[0, 0, height_m + lift_m])
                v = self.worker.end("default{%s}" % self.exact_contacts(), scene(on, floor(), gravity=(0, 0, -10)), 1e-3, 1)[0][2]
                with self.subTest(shape=kind, lift_m=lift_m):
                    self.assertEqual(v[2] > -9e-3, touching, f"velocity {v} after one step")

    def exact_contacts(self):
        return {"jolt": "speculative_contact_distance_m=0", "mujoco3": "margin_m=0"}.get(NAME, "")

    def test_the_law_is_the_pair_s_own(self):
        """Restitution 0.25 and 0.75 on one floor: no rule of combination of three coefficients gives both and 0.5 between."""
        if not RESTITUTION:
            self.assertIn("has no restitution", self.worker.reason("default", scene(ball(), floor(), laws=[law(restitution=0.5)])))
            return
        laws = [law(), law("stone", "a", 0.25), law("stone", "b", 0.75), law("a", "b", 0.5), law("a", "a"), law("b", "b")]
        balls = [ball("one", position_m=[0, 0, 0.5], velocity_m_per_s=[0, 0, -8], material="a"),
                 ball("two", position_m=[5, 0, 0.5], velocity_m_per_s=[0, 0, -8], material="b"),
                 ball("three", position_m=[0, 9, 5], velocity_m_per_s=[0, 4, 0], material="a"),
                 ball("four", position_m=[0, 10, 5], mass_kg=3, material="b")]
        found = self.worker.end("default", scene(*balls, floor(), laws=laws), 0.25, 250)
        self.near([found[0][2][2], found[1][2][2]], [2, 6], 1e-4)
        # e = 0.5, masses 1 and 3: the first keeps 4 (1 - 0.75 (1 + e)) = -0.5, the second gets 4 * 0.25 (1 + e) = 1.5
        self.near([found[2][2][1], found[3][2][1]], [-0.5, 1.5], 1e-4)

    def test_a_convention_for_simultaneous_impacts_is_refused_or_the_cell_says_that_it_is_not_followed(self):
        def told(convention, *bodies):
            return self.worker.reason("default", scene(*bodies, floor(), simultaneous_impacts=convention))

        two = ball("one", position_m=[0, 0, 1]), ball("two", position_m=[10, 0, 1])
        self.assertRegex(told("together", *two), "unsupported: .*the scene's simultaneous_impacts is together")
        self.assertRegex(told("sequential", *two), "ok: .*simultaneous_impacts = sequential is not followed")
        self.assertRegex(told("together", two[0]), "^ok: (?!.*simultaneous)")  # one pair

    def test_friction_is_the_pair_s_own_and_has_no_preferred_direction(self):
        """Slabs slide on two laws, along x and at 30 degrees: v = v0 - mu g t, without sideways motion."""
        inertia = [0.17, 0, 0, 0, 0.17, 0, 0, 0, 0.33]
        laws = [law(friction=0.05), law("stone", "ice", friction=0.1), law("ice", "ice", friction=0.7)]
        for angle in (0.0, math.radians(30)):
            u = [math.cos(angle), math.sin(angle), 0]
            slabs = [body(name, inertia_kg_m2=inertia, shape={"box": {"half_extents_m": [1, 1, 0.05]}}, material=material,
                          position_m=[10 * k, 0, 0.05], velocity_m_per_s=[3 * x for x in u])
                     for k, (name, material) in enumerate([("rough", "stone"), ("smooth", "ice")])]
            scheme = "stiff" if NAME == "mujoco3" else "default"
            found = self.worker.end(scheme, scene(*slabs, floor(), gravity=(0, 0, -10), laws=laws), 1, 480)
            for row, mu in zip(found, (0.05, 0.1)):
                along, across = (sum(a * b for a, b in zip(row[2], d)) for d in (u, [-u[1], u[0], 0]))
                with self.subTest(angle=angle, mu=mu):
                    self.assertAlmostEqual(along, 3 - 10 * mu, delta=0.01)
                    self.assertAlmostEqual(across, 0, delta=0.01)

    @unittest.skipUnless(RESTITUTION, "MuJoCo has none")
    def test_an_oblique_bounce_on_a_slanted_plane_loses_what_friction_takes(self):
        n, along = [2 / 7, -3 / 7, 6 / 7], [3 / 7, 6 / 7, 2 / 7]
        slant = body("slant", fixed=True, shape={"plane": {"normal": n, "offset_m": 0.5}})
        v = [3 * a - 4 * b for a, b in zip(along, n)]
        thrown = ball("thrown", 0.2, 3, position_m=[(0.5 + 0.2 + 0.4) * x for x in n], velocity_m_per_s=v, orientation_wxyz=exp([0.4, -0.7, 0.3]))
        for e, mu in ((0.3, 0), (0.3, 0.1), (0.7, 0.1), (0.7, 0.9)):
            expected, rate = bounced(0.2, v, n, e, mu)
            for bodies in ((slant, thrown), (thrown, slant)):
                _, q, found, w = self.worker.end("default", scene(*bodies, laws=[law(restitution=e, friction=mu)]), 0.2, 240)[bodies.index(thrown)]
                with self.subTest(restitution=e, friction=mu):
                    self.near(found, expected, 1e-3)
                    self.near(turned(q, w), rate, 1e-2)

    def test_forces_of_contacts_are_on_the_second_body_along_the_normal_from_the_first(self):
        """A slab of 2 kg slides along x at mu = 0.1: 20 N bear it, 2 N slow it, and the floor is its first body or its second."""
        slab = body("slab", mass_kg=2, inertia_kg_m2=[0.67, 0, 0, 0, 0.67, 0, 0, 0, 1.33], shape={"box": {"half_extents_m": [1, 1, 0.05]}},
                    position_m=[0, 0, 0.05], velocity_m_per_s=[3, 0, 0])
        scheme = "stiff" if NAME == "mujoco3" else "default"
        for bodies, on_slab in (((floor(), slab), 1), ((slab, floor()), -1)):
            run = Run(self.worker, scheme, scene(*bodies, gravity=(0, 0, -10), laws=[law(friction=0.1)]), 1, 480, 480)
            late = run.samples[121:]  # of each step: in MuJoCo it hops
            rows = [row for line in late for row in line["contacts"]]
            for row in rows:
                self.assertEqual(row[:2], [0, 1])
                self.near(row[5:8], [0, 0, on_slab], 1e-5)
                self.assertGreater(row[9], 0)
            self.assertAlmostEqual(sum(row[9] for row in rows) / len(late), 20, delta=0.5)
            self.assertAlmostEqual(sum(row[10] for row in rows) / len(late), -2 * on_slab, delta=0.05)
            self.assertAlmostEqual(sum(row[11] for row in rows) / len(late), 0, delta=0.02)

    def test_impacts_are_told_of_all_steps_or_of_none(self):
        """A second ball strikes one that rests on the floor, and leaves it: where the step of two contacts of one ball is not
        told, the floor's lasting contact is no new impact."""
        rest = ball("rest", position_m=[0, 0, 0.1])
        strikes = ball("strikes", position_m=[-1, 0, 0.1 + 1e-3], velocity_m_per_s=[4, 0, 0])
        run = Run(self.worker, "default", scene(floor(), rest, strikes, gravity=(0, 0, -10)), 0.5, 480, 480)
        if NAME == "jolt":
            self.assertEqual(run.events, [])
            self.assertIn("impacts are not told", run.done["reason"])
            untold = [line for line in run.samples[1:] if "contacts" not in line]
            self.assertTrue(0 < len(untold) < 480, len(untold))
        alone = ball("alone", position_m=[0, 0, 0.3], velocity_m_per_s=[0, 0, -2])
        run = Run(self.worker, "default", scene(floor(), alone), 0.5, 480, 4)
        self.assertEqual([(event["body_a"], event["body_b"]) for event in run.events], [(0, 1)])
        self.assertEqual(run.done["reason"], "")

    def test_a_mobile_plane_alone_is_a_body_at_its_place(self):
        """Its shape has no effect, and it is no plane of the world."""
        alone = body("plane", shape={"plane": {"normal": [0, 0, 1], "offset_m": 0}}, position_m=[0, 0, 5], velocity_m_per_s=[1, 0, 0])
        self.near(self.worker.end("default", scene(alone), 1, 60)[0][0], [1, 0, 5], 100 * ROUND_OFF)

    def test_bodies_collide_across_a_weld(self):
        """A hinge from a to b and a weld from b to c: a and c overlap and are not joined, so that they are pushed apart."""
        run = Run(self.worker, "default", across_a_weld(), 0.5, 240)
        self.assertEqual(run.done["status"], "ok", run.done)
        self.assertGreater(abs(run.samples[-1]["joints"][0][0]), 0.02)  # at rest without the contact

    @unittest.skipUnless(NAME == "jolt", "JavaScript frees what the other has")
    def test_a_world_gives_its_memory_back(self):
        cube = [[x, y, z] for x in (-0.1, 0.1) for y in (-0.1, 0.1) for z in (-0.1, 0.1)]
        part = {"half_extents_m": [0.1, 0.1, 0.1], "position_body_m": [0.1, 0, 0], "orientation_wxyz": [1, 0, 0, 0]}
        corners = {"points_m": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "triangles": [[0, 1, 2]]}
        shapes = [{"sphere": {"radius_m": 0.1}}, {"box": {"half_extents_m": [0.1, 0.1, 0.1]}}, {"convex": {"points_m": cube}},
                  {"cylinder": {"radius_m": 0.1, "half_length_m": 0.2}}, {"compound": {"boxes": [part]}}]
        bodies = [body(f"b{k}", shape=shape, position_m=[k, 0, 1]) for k, shape in enumerate(shapes)]
        kinds = [("hinge", {"axis_body": [0, 0, 1], "limits_rad": [-1, 1]}), ("slider", {"axis_body": [0, 0, 1]}), ("ball", {}),
                 ("fixed", {}), ("universal", {"axes_body": [[1, 0, 0], [0, 0, 1]]})]
        joints = [{"name": kind, "kind": kind, "bodies": ["world", f"b{k}"], "anchors_body_m": [[k, 0, 1], [0, 0, 0]],
                   "frame_wxyz": [1, 0, 0, 0], **more} for k, (kind, more) in enumerate(kinds)]
        of = scene(floor(), body("mesh", fixed=True, shape={"mesh": corners}), *bodies, joints=joints)
        script = os.path.join(os.path.dirname(os.path.abspath(__file__)), "jolt_memory.mjs")
        root = os.path.join(os.path.dirname(script), "../../..")
        ended = subprocess.run([shutil.which("node"), script, root, f"{BIN_DIR}/../node"], input=json.dumps(of), text=True,
                               capture_output=True, timeout=100)
        self.assertEqual(ended.returncode, 0, ended.stderr)
        self.assertLess(int(ended.stdout), 200 * 16)  # not 16 bytes of each world

    def test_two_runs_have_the_same_bits(self):
        balls = [ball(str(k), position_m=[0.05 * (k % 2), 0, 0.1 + 0.25 * k]) for k in range(6)]
        of = scene(*balls, floor(), gravity=(0, 0, -10), laws=[law(friction=0.5)])
        self.assertEqual(self.worker.end("default", of, 1, 240), self.worker.end("default", of, 1, 240))
        other = Worker(BIN_DIR, NAME)
        self.addCleanup(other.close)
        self.assertEqual(self.worker.end("default", of, 1, 240), other.end("default", of, 1, 240))

    def test_refusals_name_what_is_missing(self):
        pair = lambda **of: scene(ball(position_m=[0, 0, 1]), floor(), laws=[law(**of)])
        self.assertIn("unsupported: ", self.worker.reason("default{cellar=1}", pair()))
        self.assertIn("cellar", self.worker.reason("default{cellar=1}", pair()))
        self.assertIn("is not available", self.worker.reason("default+impulse", pair()))
        self.assertIn("no error control", self.worker.reason("default:1e-9", pair()))
        if NAME == "jolt":
            self.assertIn("moves no body faster", self.worker.reason("default", scene(body(velocity_m_per_s=[1e10, 0, 0]))))
            self.assertIn("turns no body faster", self.worker.reason(
                "default{max_angular_velocity_rad_per_s=47.1}", scene(body(angular_velocity_body_rad_per_s=[0, 0, 50]))))
            self.assertIn("no rolling friction", self.worker.reason("default", pair(friction=0.5, rolling_friction_m=0.01)))
            mesh = {"mesh": {"points_m": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "triangles": [[0, 1, 2]]}}
            self.assertIn("must be fixed", self.worker.reason("default", scene(body(shape=mesh), floor())))
        if NAME == "mujoco3":
            flat = {"rectangle": {"half_extents_m": [1, 1]}}
            self.assertIn("no rectangle", self.worker.reason("default", scene(ball(), body("flat", fixed=True, shape=flat))))


if __name__ == "__main__":
    if not os.path.exists(f"{BIN_DIR}/atwood-{NAME}"):
        print(f"{NAME} is not built")
        sys.exit(77)
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
