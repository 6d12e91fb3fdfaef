"""Contact queries of the engines that run under Node.js, on overlaps whose place, normal and depth are known.
contacts_test.py BIN_DIR NAME; skipped where the engine is not there."""
import os
import sys
import unittest

from workers import Worker, body, exp, floor, scene, turned

BIN_DIR, NAME = sys.argv[1], sys.argv[2]
LENGTH_M = 1e-14 if NAME == "mujoco3" else 1e-6  # round-off of places and depths, in scenes of a metre
BOX = {"box": {"half_extents_m": [0.5, 0.4, 0.3]}}
TILTED = exp([0.4, -0.7, 0.3])
TRIANGLE = {"mesh": {"points_m": [[-1, -1, 0], [2, -1, 0], [-1, 2, 0]], "triangles": [[0, 1, 2]]}}


def sphere(name="sphere", radius_m=0.25, **members):
    return body(name, shape={"sphere": {"radius_m": radius_m}}, **members)


class Contacts(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.worker = Worker(BIN_DIR, NAME)
        cls.addClassCleanup(cls.worker.close)

    def ask(self, *bodies, swept=False, test="contacts", **members):
        """Rows {pair, x, normal, depth}; or the reason of a refusal."""
        lines = self.worker.answer(request="contacts", cell=1, swept=swept, t_end_s=1, test=test, scene=scene(*bodies, **members))
        done = lines[-1]["done"]
        if done["status"] == "unsupported":
            return done["reason"]
        self.assertEqual(done["status"], "ok", done)
        return [{"pair": tuple(row[:2]), "x": row[2:5], "normal": row[5:8], "depth": row[8]}
                for line in lines for row in line.get("contacts", [])]

    def near(self, found, expected, tolerance):
        self.assertLessEqual(max(abs(a - b) for a, b in zip(found, expected, strict=True)), tolerance, f"{found} is not {expected}")

    def one(self, bodies, pair, normal, depth_m, x_m=None):
        found = self.ask(*bodies)
        self.assertTrue(found and not isinstance(found, str), found)
        self.assertEqual({each["pair"] for each in found}, {pair})
        deepest = max(found, key=lambda each: each["depth"])
        self.near(deepest["normal"], normal, 1e-6)
        self.near([deepest["depth"]], [depth_m], 4 * LENGTH_M)
        if x_m:
            self.near(deepest["x"], x_m, depth_m + LENGTH_M)  # between the two surfaces

    def test_a_normal_points_from_the_first_body_to_the_second_whichever_comes_first(self):
        box, ball = body("box", shape=BOX), sphere(position_m=[0.1, 0.05, 0.5])
        self.one((box, ball), (0, 1), [0, 0, 1], 0.05, [0.1, 0.05, 0.275])
        self.one((ball, box), (0, 1), [0, 0, -1], 0.05, [0.1, 0.05, 0.275])
        other = body("other", shape=BOX, position_m=[0.9, 0.2, 0.1])
        self.one((box, other), (0, 1), [1, 0, 0], 0.1)
        self.one((other, box), (0, 1), [-1, 0, 0], 0.1)
        self.assertGreaterEqual(len(self.ask(box, other)), 4)  # corners of the face that they share

    def test_a_pose_is_w_first_and_turns_the_shape_of_its_body(self):
        at = [0.3, -0.2, 0.4]
        box = body("box", shape=BOX, position_m=at, orientation_wxyz=TILTED)
        for axis, half in (([1, 0, 0], 0.5), ([0, 1, 0], 0.4), ([0, 0, 1], 0.3)):
            out = turned(TILTED, axis)
            ball = sphere(position_m=[a + (half + 0.2) * n for a, n in zip(at, out)])
            self.one((box, ball), (0, 1), out, 0.05, [a + (half - 0.025) * n for a, n in zip(at, out)])

    def test_capsules_and_cylinders_lie_along_z(self):
        for shape, end in (({"capsule": {"radius_m": 0.2, "half_length_m": 0.6}}, 0.8), ({"cylinder": {"radius_m": 0.2, "half_length_m": 0.6}}, 0.6)):
            rod = body("rod", shape=shape, orientation_wxyz=TILTED)
            along, across = turned(TILTED, [0, 0, 1]), turned(TILTED, [1, 0, 0])
            ends = sphere(position_m=[(end + 0.2) * x for x in along]), sphere(position_m=[0.4 * x for x in across])
            for ball, out in zip(ends, (along, across)):
                found = self.ask(rod, ball)
                self.assertEqual(len(found), 1, found)
                curved = 2e-3 if "cylinder" in shape else 1e-6  # found by iterations
                self.near(found[0]["normal"], out, curved)
                self.near([found[0]["depth"]], [0.05], curved)

    def test_hulls_and_compounds_stand_in_the_axes_of_their_body(self):
        points = [[x, y, z] for x in (-0.1, 0.5) for y in (-0.4, 0.4) for z in (-0.3, 0.3)]  # not about its middle
        part = {"half_extents_m": [0.3, 0.4, 0.3], "position_body_m": [0.2, 0, 0], "orientation_wxyz": [1, 0, 0, 0]}
        for shape in ({"convex": {"points_m": points}}, {"compound": {"boxes": [part]}}):
            for sign, half in ((1, 0.5), (-1, 0.1)):
                found = self.ask(body("a", shape=shape), sphere(position_m=[sign * (half + 0.2), 0, 0]))
                self.assertEqual(len(found), 1, found)
                self.near(found[0]["normal"], [sign, 0, 0], 1e-5)
                self.near([found[0]["depth"]], [0.05], 1e-5)

    def test_a_plane_stands_in_world_axes_at_its_offset(self):
        plane = {"plane": {"normal": [0, 3, 4], "offset_m": 1}}  # n.x = 1 with n of length 5: 0.2 m from the origin
        under = body("plane", fixed=True, mass_kg=0, shape=plane, position_m=[5, 6, 7], orientation_wxyz=TILTED)
        ball = sphere(position_m=[0, 0.6 * 0.4, 0.8 * 0.4])
        self.one((under, ball), (0, 1), [0, 0.6, 0.8], 0.05)
        self.one((ball, under), (0, 1), [0, -0.6, -0.8], 0.05)

    def test_only_what_overlaps_is_told_and_nothing_moves(self):
        box = body("box", shape=BOX)
        self.assertEqual(self.ask(box, sphere(position_m=[0, 0, 0.551])), [])
        fixed = [body("a", shape=BOX, fixed=True), body("b", shape=BOX, fixed=True, position_m=[0.9, 0, 0])]
        self.assertEqual(self.ask(*fixed), [])
        self.assertEqual({each["pair"] for each in self.ask(*fixed, sphere(position_m=[0.45, 0, 0.5]))}, {(0, 2), (1, 2)})
        still = self.ask(box, sphere(position_m=[0, 0, 0.5]))
        moving = sphere(position_m=[0, 0, 0.5], velocity_m_per_s=[30, 20, 10], angular_velocity_body_rad_per_s=[9, 8, 7], release_s=2)
        self.assertEqual(self.ask({**box, "fixed": True}, moving, gravity=(1, 2, -1000)), still)
        shapeless = body("point", inertia_kg_m2=[0] * 9)
        self.assertEqual(self.ask(box, sphere(position_m=[0, 0, 0.5]), shapeless), still)

    def test_joined_bodies_are_asked_too(self):
        joint = {"name": "j", "kind": "ball", "bodies": ["box", "sphere"], "anchors_body_m": [[0, 0, 0.5], [0, 0, 0]],
                 "frame_wxyz": [1, 0, 0, 0], "coordinates": [1, 0, 0, 0], "rates": [0, 0, 0], "closes_loop": False}
        self.assertEqual(len(self.ask(body("box", shape=BOX), sphere(position_m=[0, 0, 0.5]), joints=[joint])), 1)

    def test_meshes_where_the_engine_has_them(self):
        mesh, ball = body("mesh", shape=TRIANGLE), sphere(position_m=[0.1, 0.1, 0.2])
        square = body("square", fixed=True, mass_kg=0, shape={"rectangle": {"half_extents_m": [1, 1]}})
        if NAME == "mujoco3":
            self.assertIn("convex hull", self.ask(mesh, ball))
            self.assertIn("no rectangle", self.ask(square, ball))
            return
        of_file = {**mesh, "shape": {"mesh": {**TRIANGLE["mesh"], "file": "triangle.obj"}}}
        for under in (mesh, {**mesh, "fixed": True, "mass_kg": 0}, of_file, square):
            self.one((under, ball), (0, 1), [0, 0, 1], 0.05)

    def test_refusals_name_what_is_missing(self):
        box, ball, mesh = body("box", shape=BOX), sphere(position_m=[0, 0, 0.5]), body("mesh", shape=TRIANGLE)
        self.assertIn("no sweeps in time", self.ask(box, ball, swept=True))
        for swept, reason in ((True, "no sweeps in time"), (False, "no poses")):
            (line,) = self.worker.answer(request="contacts-sweep", cell=1, swept=swept, pair="sphere-sphere", seed=1, **{"from": 0, "count": 1})
            self.assertEqual(line["done"]["status"], "unsupported")
            self.assertIn(reason, line["done"]["reason"])
        self.assertIn("no test `unit-size`", self.ask(box, ball, test="unit-size"))
        self.assertIn("two surfaces: `mesh`", self.ask(mesh, floor()))
        line = {"convex": {"points_m": [[0, 0, 0.1 * k] for k in range(5)]}}
        self.assertRegex(self.ask(body("line", shape=line), ball), "hull|triangle|collinear")
        if NAME != "mujoco3":
            self.assertIn("no room for 1e+40: shape, mass or inertia of `big`", self.ask(sphere("big", 1e40), box))


if __name__ == "__main__":
    if not os.path.exists(f"{BIN_DIR}/atwood-{NAME}"):
        print(f"{NAME} is not built")
        sys.exit(77)
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
