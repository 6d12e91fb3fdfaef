"""Rapier's conventions, by scenes whose answer is known. rapier_test.py BIN_DIR; skipped where the worker is not there."""
import json
import math
import os
import random
import shutil
import subprocess
import sys
import unittest

import workers
from workers import Worker, angle_between, bounced, exp, floor, law, scene, times, tumbled, turned

BIN_DIR = sys.argv[1]
DEFAULT = "default"
TILTED = exp([0.4, -0.7, 0.3])
MIXED = [2.0, 0.3, -0.2, 0.3, 1.5, 0.1, -0.2, 0.1, 1.0]  # an inertia about no principal axes


def body(name, **members):
    """A ball of 0.1 m and 2 kg without a shape, unless said otherwise."""
    return workers.body(name, **{"mass_kg": 2, "inertia_kg_m2": [0.008, 0, 0, 0, 0.008, 0, 0, 0, 0.008], **members})


def laws_of(materials, pairs=()):
    """Laws of materials (name, restitution, friction): the geometric mean where `pairs`, (a, b, restitution, friction), has no
    entry."""
    given = {frozenset(pair[:2]): pair[2:] for pair in pairs}
    return [law(a, b, *given.get(frozenset((a, b)), [math.sqrt(x * y) for x, y in zip(of_a, of_b)]))
            for i, (a, *of_a) in enumerate(materials) for b, *of_b in materials[i:]]


def Run(scheme, of, t_end_s, steps, samples=1, **more):
    return workers.Run(WORKER, scheme, of, t_end_s, steps, samples, **more)


class FreeFlight(unittest.TestCase):
    def near(self, a, b, tolerance):
        self.assertLess(max(abs(x - y) for x, y in zip(a, b)), tolerance, f"{a} and {b}")

    def test_the_first_sample_is_the_scene(self):
        start = dict(position_m=[1, 2, 3], orientation_wxyz=TILTED, velocity_m_per_s=[4, 5, 6],
                     angular_velocity_body_rad_per_s=[0.1, 0.2, 0.3], inertia_kg_m2=MIXED)
        found = Run(DEFAULT, scene(body("a", **start)), 1, 60).body(0, 0)
        for key, name in (("p", "position_m"), ("q", "orientation_wxyz"), ("v", "velocity_m_per_s"), ("w", "angular_velocity_body_rad_per_s")):
            self.near(found[key], start[name], 1e-6)

    def test_rates_are_of_the_body_and_quaternions_w_first(self):
        w = [0, 0, 1.3]
        end = Run(DEFAULT, scene(body("a", orientation_wxyz=TILTED, angular_velocity_body_rad_per_s=w, inertia_kg_m2=[1, 0, 0, 0, 2, 0, 0, 0, 3])), 2, 480).body(0)
        self.near(end["w"], w, 1e-3)
        self.assertLess(angle_between(end["q"], times(TILTED, exp([2 * x for x in w]))), 1e-3)

    def test_the_inertia_is_in_the_axes_of_the_body(self):
        q, w = tumbled(MIXED, TILTED, [1.0, 0.5, -0.4], 2)
        end = Run(DEFAULT, scene(body("a", orientation_wxyz=TILTED, angular_velocity_body_rad_per_s=[1.0, 0.5, -0.4], inertia_kg_m2=MIXED)), 2, 960).body(0)
        self.assertLess(angle_between(end["q"], q), 5e-3)
        self.near(end["w"], w, 5e-3)

    def test_a_force_at_a_point_turns_by_its_moment_in_world_axes(self):
        # m = 2, I = diag(1, 2, 3), turned: F in world axes at r in body axes; after a short time w_B = I^-1 R^T (R r x F) t.
        inertia, r, force, t = [1.0, 2.0, 3.0], [0.3, -0.2, 0.5], [0.4, 0.1, -0.3], 0.05
        a = body("a", orientation_wxyz=TILTED, inertia_kg_m2=[1, 0, 0, 0, 2, 0, 0, 0, 3])
        load = {"kind": "point-force", "body": "a", "point_body_m": r, "force_N": force, "on_s": []}
        run = Run(DEFAULT, scene(a, forces=[load]), t, 48)
        back = [TILTED[0], *(-x for x in TILTED[1:])]
        f_B = turned(back, force)
        moment = [r[1] * f_B[2] - r[2] * f_B[1], r[2] * f_B[0] - r[0] * f_B[2], r[0] * f_B[1] - r[1] * f_B[0]]
        self.near(run.body(0)["w"], [m / i * t for m, i in zip(moment, inertia)], 2e-5)
        self.near(run.body(0)["v"], [f / 2 * t for f in force], 1e-6)
        self.assertEqual(run.done["reason"], "forces evaluated by the adapter once a step: point-force")

    def test_a_force_does_not_outlast_its_time(self):
        load = {"kind": "point-force", "body": "a", "point_body_m": [0, 0, 0], "force_N": [2, 0, 0], "on_s": [[0, 0.5]]}
        self.near(Run(DEFAULT, scene(body("a"), forces=[load]), 2, 240).body(0)["v"], [0.5, 0, 0], 1e-5)

    def test_a_body_falls_by_gravity_alone_and_neither_sleeps_nor_is_damped(self):
        slow = body("slow", velocity_m_per_s=[1e-3, 0, 0], angular_velocity_body_rad_per_s=[0, 1e-3, 0])
        held = body("held", position_m=[5, 0, 0], velocity_m_per_s=[0, 3, 0], release_s=1)
        run = Run(DEFAULT, scene(slow, held), 10, 600)
        self.near(run.body(0)["p"], [1e-2, 0, 0], 1e-6)
        self.near(run.body(0)["w"], [0, 1e-3, 0], 1e-6)  # in float it grows, by 3e-7 here
        self.near(run.body(1)["p"], [5, 27, 0], 1e-3)
        self.near(Run(DEFAULT, scene(body("a"), gravity=(0, 0, -9.8)), 1, 600).body(0)["v"], [0, 0, -9.8], 1e-4)

    def test_a_mobile_plane_alone_is_a_body_at_its_place(self):
        """Its shape has no effect, and it is no plane of the world."""
        alone = body("plane", shape={"plane": {"normal": [0, 0, 1], "offset_m": 0}}, position_m=[0, 0, 5], velocity_m_per_s=[1, 0, 0])
        self.near(Run(DEFAULT, scene(alone), 1, 60).body(0)["p"], [1, 0, 5], 1e-5)

    def test_limits_of_speed_are_told(self):
        fast = Run(DEFAULT, scene(body("fast", velocity_m_per_s=[401, 0, 0])), 1, 60)
        self.assertEqual(fast.done["status"], "unsupported")
        self.assertIn("`fast`", fast.done["reason"])
        faster = Run("default{length_unit_m=2}", scene(body("fast", velocity_m_per_s=[401, 0, 0])), 1, 60)
        self.near(faster.body(0)["v"], [401, 0, 0], 1e-3)
        falling = Run(DEFAULT, scene(body("a", velocity_m_per_s=[0, 0, -395]), gravity=(0, 0, -10)), 1, 60)
        self.assertIn("speeds are cut at 400 m/s", falling.done["reason"])
        spinning = scene(body("a", angular_velocity_body_rad_per_s=[0, 0, 60]))
        self.assertIn("rates are cut at a turn of pi/4 a step", Run(DEFAULT, spinning, 1, 60).done["reason"])
        self.assertEqual(Run(DEFAULT, spinning, 1, 120).done["reason"], "")


class Contacts(unittest.TestCase):
    """Falls and slides; g = 10 m/s2."""
    BALL = {"sphere": {"radius_m": 0.1}}

    def test_each_pair_bounces_by_its_own_restitution(self):
        # 0.3 and 0.6 on the floor and 0.7 between the balls: half the sum of 0.2, 0.4 and 1 gives each pair its own.
        materials, pairs = [("floor", 0, 0), ("a", 0, 0), ("b", 0, 0)], [("floor", "a", 0.3, 0), ("floor", "b", 0.6, 0), ("a", "b", 0.7, 0)]
        balls = [body(name, material=name, shape=self.BALL, position_m=[2.0 * i, 0, 0.5], velocity_m_per_s=[0, 0, -2]) for i, name in enumerate("ab")]
        run = Run(DEFAULT, scene(floor(material="floor"), *balls, laws=laws_of(materials, pairs)), 0.4, 240)
        for i, e in ((1, 0.3), (2, 0.6)):
            self.assertAlmostEqual(run.body(i)["v"][2], 2 * e, delta=2e-3)
        meeting = [{**ball, "position_m": [x, 0, 5], "velocity_m_per_s": [-x, 0, 0]} for ball, x in zip(balls, (-1, 1))]
        run = Run(DEFAULT, scene(floor(material="floor"), *meeting, laws=laws_of(materials, pairs)), 1.5, 720)
        self.assertAlmostEqual(run.body(2)["v"][0] - run.body(1)["v"][0], 2 * 0.7, delta=2e-3)

    def test_the_geometric_mean_of_two_materials(self):
        materials = [("floor", 0.9, 0.4), ("a", 0.4, 0.1), ("b", 0.1, 0.9)]
        balls = [body(name, material=name, shape=self.BALL, position_m=[2.0 * i, 0, 0.5], velocity_m_per_s=[0, 0, -2]) for i, name in enumerate("ab")]
        run = Run(DEFAULT, scene(floor(material="floor"), *balls, laws=laws_of(materials)), 0.4, 240)
        for i, e in ((1, 0.6), (2, 0.3)):
            self.assertAlmostEqual(run.body(i)["v"][2], 2 * e, delta=2e-3)

    def test_laws_that_no_rule_combines_are_each_pair_s_own(self):
        """a with a 0.8, b with b 0.3, a with b 0.1, and 0.2 and 0.9 on the floor: two balls of a kind, and one on the floor."""
        materials, pairs = [("floor", 0, 0), ("a", 0, 0), ("b", 0, 0)], [("a", "a", 0.8, 0), ("b", "b", 0.3, 0), ("a", "b", 0.1, 0),
                                                                         ("floor", "a", 0.2, 0), ("floor", "b", 0.9, 0)]
        bodies = [floor(material="floor")]
        for k, (x, y) in enumerate(("aa", "bb", "ab", "ba")):
            bodies += [body(f"{k}{side}", material=name, shape=self.BALL, position_m=[side, 2 * k, 5], velocity_m_per_s=[-side, 0, 0])
                       for side, name in ((-1, x), (1, y))]
        bodies += [body(name, material=name, shape=self.BALL, position_m=[5, k, 0.5], velocity_m_per_s=[0, 0, -2]) for k, name in enumerate("ab")]
        run = Run(DEFAULT, scene(*bodies, laws=laws_of(materials, pairs)), 1.2, 720)
        self.assertEqual(run.done["status"], "ok", run.done)
        for k, e in enumerate((0.8, 0.3, 0.1, 0.1)):
            self.assertAlmostEqual(run.body(2 + 2 * k)["v"][0] - run.body(1 + 2 * k)["v"][0], 2 * e, delta=2e-3, msg=k)
        for k, e in ((9, 0.2), (10, 0.9)):
            self.assertAlmostEqual(run.body(k)["v"][2], 2 * e, delta=2e-3)
        # one contact of each pair, not one a layer: it carries the weight once
        resting = body("c", material="a", shape=self.BALL, position_m=[9, 9, 0.1])
        run = Run(DEFAULT, scene(*bodies, resting, gravity=(0, 0, -10), laws=laws_of(materials, pairs)), 1, 240, 4)
        (row,) = [row for row in run.samples[-1]["contacts"] if row[1] == 11]
        self.assertAlmostEqual(row[9], 20, delta=0.05)

    def test_friction_has_no_direction_and_stops_at_the_right_place(self):
        # v^2 / (2 mu g) = 9 / 6 m along any direction; in double the slide is exact.
        box = {"box": {"half_extents_m": [0.1, 0.1, 0.1]}}
        for angle in (0, math.pi / 4, 1.0):
            a = body("a", shape=box, position_m=[0, 0, 0.1], velocity_m_per_s=[3 * math.cos(angle), 3 * math.sin(angle), 0],
                     inertia_kg_m2=[0.0133, 0, 0, 0, 0.0133, 0, 0, 0, 0.0133])
            end = Run(DEFAULT, scene(floor(), a, gravity=(0, 0, -10), laws=[law(friction=0.3)]), 1.5, 720).body(1)
            self.assertAlmostEqual(math.hypot(*end["p"][:2]), 1.5, delta=0.01)
            self.assertAlmostEqual(math.atan2(end["p"][1], end["p"][0]), angle, delta=1e-3)

    def test_an_oblique_bounce_has_the_friction_of_one_without_restitution(self):
        """Rapier adds restitution after friction: the friction impulse is mu times the normal one over 1 + e (docs/rapier.md)."""
        n, along = [2 / 7, -3 / 7, 6 / 7], [3 / 7, 6 / 7, 2 / 7]
        slant = body("slant", fixed=True, shape={"plane": {"normal": n, "offset_m": 0.5}})
        v = [3 * a - 4 * b for a, b in zip(along, n)]
        thrown = body("thrown", mass_kg=3, inertia_kg_m2=[0.048, 0, 0, 0, 0.048, 0, 0, 0, 0.048], shape={"sphere": {"radius_m": 0.2}},
                      position_m=[(0.5 + 0.2 + 0.4) * x for x in n], velocity_m_per_s=v, orientation_wxyz=TILTED)
        for e, mu in ((0.3, 0), (0.3, 0.1), (0.7, 0.1), (0.7, 0.9)):
            expected, rate = bounced(0.2, v, n, e, mu / (1 + e))
            for bodies in ((slant, thrown), (thrown, slant)):
                of = scene(*bodies, laws=[law(restitution=e, friction=mu)])
                end = Run("default{prediction_distance=0}", of, 0.2, 240).body(bodies.index(thrown))  # a gap lengthens the lever
                self.assertLess(math.dist(end["v"], expected), 2e-3, (e, mu))
                self.assertLess(math.dist(turned(end["q"], end["w"]), rate), 2e-2, (e, mu))

    def test_capsules_and_cylinders_lie_along_z(self):
        inertia = [0.02, 0, 0, 0, 0.02, 0, 0, 0, 0.01]
        for shape, upright in (({"cylinder": {"radius_m": 0.1, "half_length_m": 0.25}}, 0.25), ({"capsule": {"radius_m": 0.1, "half_length_m": 0.25}}, 0.35)):
            lying = [math.sqrt(0.5), 0, math.sqrt(0.5), 0]
            for q, height in (([1, 0, 0, 0], upright), (lying, 0.1)):
                a = body("a", shape=shape, position_m=[0, 0, height], orientation_wxyz=q, inertia_kg_m2=inertia)
                run = Run(DEFAULT, scene(floor(), a, gravity=(0, 0, -10)), 0.2, 120)
                self.assertAlmostEqual(run.body(1)["p"][2], height, delta=2e-3)

    def test_every_shape_rests_where_its_lowest_point_is(self):
        cube = [[x, y, z] for x in (-0.1, 0.1) for y in (-0.1, 0.1) for z in (-0.1, 0.1)]
        square = {"points_m": [[-2, -2, 0], [2, -2, 0], [2, 2, 0], [-2, 2, 0]], "triangles": [[0, 1, 2], [0, 2, 3]]}
        floors = [floor(), body("f", fixed=True, mass_kg=0, shape={"rectangle": {"half_extents_m": [2, 2]}}), body("f", fixed=True, mass_kg=0, shape={"mesh": square}),
                  body("f", fixed=True, mass_kg=0, position_m=[0, 0, -1], shape={"box": {"half_extents_m": [2, 2, 1]}})]
        parts = [{"half_extents_m": [0.05, 0.1, 0.1], "position_body_m": [x, 0, 0], "orientation_wxyz": [1, 0, 0, 0]} for x in (-0.05, 0.05)]
        for under in floors:
            for shape in (self.BALL, {"box": {"half_extents_m": [0.1, 0.1, 0.1]}}, {"convex": {"points_m": cube}}, {"compound": {"boxes": parts}}):
                run = Run(DEFAULT, scene(under, body("a", shape=shape, position_m=[0.1, 0.2, 0.1]), gravity=(0, 0, -10)), 0.5, 240)
                self.assertEqual(run.done["status"], "ok", run.done)
                self.assertAlmostEqual(run.body(1)["p"][2], 0.1, delta=1e-3, msg=f"{under['shape']} {shape}")

    def test_contacts_point_from_the_first_body_to_the_second_and_carry_the_weight(self):
        ball = body("a", shape=self.BALL, position_m=[0, 0, 0.1])
        for bodies, up in (((floor(), ball), 1), ((ball, floor()), -1)):
            run = Run(DEFAULT, scene(*bodies, gravity=(0, 0, -10)), 1, 240, 4)
            (row,) = run.samples[-1]["contacts"]
            self.assertEqual(row[:2], [0, 1])
            self.assertAlmostEqual(row[7], up, delta=1e-6)
            self.assertAlmostEqual(row[9], 20, delta=0.05)
            self.assertLess(abs(row[4]), 2e-3)
            self.assertEqual(row[10:], [0, 0, 0])
        rough = Run(DEFAULT, scene(floor(), ball, gravity=(0, 0, -10), laws=[law(friction=0.5)]), 1, 240, 4)
        self.assertEqual(rough.samples[-1]["contacts"][0][10:], ["nan"] * 3)

    def test_an_impact_is_an_event_with_its_impulse(self):
        ball = body("a", shape=self.BALL, position_m=[0, 0, 0.3], velocity_m_per_s=[0, 0, -2])
        run = Run(DEFAULT, scene(floor(), ball, laws=[law(restitution=0.5)]), 0.5, 480, 4)
        (impact,) = run.events
        self.assertAlmostEqual(impact["t_s"], 0.1, delta=0.012)  # solved ahead of the touch by up to the prediction distance
        self.assertAlmostEqual(impact["impulse_n_N_s"], 6, delta=0.01)
        self.assertAlmostEqual(impact["vn_before_m_per_s"], -2, delta=1e-4)
        self.assertAlmostEqual(impact["vn_after_m_per_s"], 1, delta=2e-3)


class Sources(unittest.TestCase):
    """Parts of the adapter asked alone."""

    def answer(self, script, given=None):
        if not workers.has_node():
            self.skipTest("no Node.js of version 18.3 or newer on the path")
        sources = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../../reference/rapier")
        ended = subprocess.run([shutil.which("node"), "--input-type=module", "-e", script, sources], input=json.dumps(given), text=True,
                               capture_output=True, timeout=60)
        self.assertEqual(ended.returncode, 0, ended.stderr)
        return json.loads(ended.stdout)

    def test_a_manifold_that_rapier_keeps_the_other_way_round_is_turned(self):
        """Rapier may keep a pair with the later collider first (`flipped`); no scene is known in which it does."""
        script = """
            import { pathToFileURL } from "node:url";
            const { RapierWorld } = await import(pathToFileURL(`${process.argv[1]}/world.mjs`).href);
            const colliders = [{ handle: 1 }, { handle: 2 }], up = { x: 0, y: 0, z: 1 };
            const manifold = { normal: () => up, numContacts: () => 1, numSolverContacts: () => 1, solverContactPoint: () => up,
                               contactDist: () => -0.5, contactImpulse: () => 3 };
            const told = (flipped) => RapierWorld.prototype.points.call({
              colliders, bodyOf: new Map([[1, 0], [2, 1]]), scene: { pairLaw: () => ({ friction: 0 }) },
              take: RapierWorld.prototype.take,
              world: { contactPairsWith: (one, use) => colliders.filter((each) => each !== one).forEach(use),
                       contactPair: (one, other, use) => use(manifold, flipped) } });
            console.log(JSON.stringify([false, true].map(told)));"""
        for rows, up in zip(self.answer(script), (1, -1), strict=True):
            (row,) = rows
            self.assertEqual((row["body_a"], row["body_b"], row["normal"][2]), (0, 1, up))

    def test_each_pair_meets_in_one_layer_under_its_law_and_no_other_pair_there(self):
        """Random laws of a few values each, so that layers, rules and shared groups all come up."""
        script = """
            import { readFileSync } from "node:fs";
            import { pathToFileURL } from "node:url";
            const { layersOf } = await import(pathToFileURL(`${process.argv[1]}/coefficients.mjs`).href);
            const told = JSON.parse(readFileSync(0, "utf8")).map(([count, pairs]) => layersOf(count, pairs)?.map((layer) =>
              ({ ...layer, groups: layer.groups && [...layer.groups] })) ?? null);
            console.log(JSON.stringify(told));"""
        rng = random.Random(5)
        cases = []
        for _ in range(400):
            count, values = rng.randint(2, 6), rng.choice(([0, 0.5], [0, 0.3, 0.7], [0.1, 0.2, 0.45, 0.8, 1]))
            every = [(i, j) for i in range(count) for j in range(i, count)]
            pairs = [[i, j, {"restitution": rng.choice(values), "friction": rng.choice(values)}] for i, j in every if rng.random() < 0.8]
            cases.append((count, pairs))
        combine = {"Average": lambda a, b: (a + b) / 2, "Max": max, "Min": min, "Multiply": lambda a, b: a * b}
        layered = refused = with_itself = 0
        for (count, pairs), layers in zip(cases, self.answer(script, cases), strict=True):
            if layers is None:
                refused += 1
                continue
            layered += len(layers) > 1
            # Colliders (layer, material, member, filter): two of them meet where each is in the other's filter.
            colliders = [(layer, material, *([0xffff, 0xffff] if each is None else [each["member"], each["filter"]]))
                         for layer in layers
                         for material, each in (layer["groups"] or [(m, None) for m in range(count)])]
            for i, j, law_of in pairs:
                met = [(one, other) for one in colliders for other in colliders
                       if one[1] == i and other[1] == j and one[2] & other[3] and other[2] & one[3]]
                self.assertEqual(len(met), 1, (i, j, pairs, layers))
                (((layer, *_), (same, *_)),) = met
                self.assertIs(layer, same)
                with_itself += i == j and len(layers) > 1
                for name, wanted in law_of.items():
                    found = combine[layer[name]["rule"]](*(layer[name]["values"][k] for k in (i, j)))
                    self.assertAlmostEqual(found, wanted, delta=2e-6)
        self.assertGreater(min(layered, with_itself), 100)
        self.assertLess(refused, 200)


class Joints(unittest.TestCase):
    """A body of 2 kg and 0.4 kg m2 about every axis, 1 m below its joint with the world unless said otherwise."""
    INERTIA = [0.4, 0, 0, 0, 0.4, 0, 0, 0, 0.4]

    def run_of(self, kind, t_end_s=1, steps=480, gravity=(0, -10, 0), **members):
        parts = {key: members.pop(key) for key in list(members) if key not in body("a")}
        joint = {"name": "j", "kind": kind, "bodies": ["world", "a"], "anchors_body_m": [[0, 0, 0], [0, 1, 0]],
                 "frame_wxyz": [1, 0, 0, 0], "coordinates": [0], "rates": [0], **parts}
        a = body("a", **{"position_m": [0, -1, 0], "inertia_kg_m2": self.INERTIA, **members})
        run = Run(DEFAULT, scene(a, gravity=gravity, joints=[joint]), t_end_s, steps)
        self.assertEqual(run.done["status"], "ok", run.done)
        return run

    def test_a_hinge_and_a_ball_swing_as_a_pendulum(self):
        # (I + m l^2) theta'' = -m g l sin(theta), theta(0) = 0.5: theta(1) = -0.477904, theta'(1) = -0.415901 (RK4).
        q = exp([0, 0, 0.5])
        start = {"position_m": [math.sin(0.5), -math.cos(0.5), 0], "orientation_wxyz": q}
        hinge = self.run_of("hinge", axis_body=[0, 0, 1], coordinates=[0.5], **start)
        ball = self.run_of("ball", coordinates=q, rates=[0, 0, 0], **start)
        for run in (hinge, ball):
            self.assertAlmostEqual(run.body(0)["p"][0], math.sin(-0.477904), delta=1e-3)
            self.assertAlmostEqual(run.body(0)["w"][2], -0.415901, delta=1e-3)
        self.assertAlmostEqual(hinge.samples[-1]["joints"][0][0], -0.477904, delta=1e-3)
        self.assertAlmostEqual(ball.samples[-1]["joints"][0][3], math.sin(-0.477904 / 2), delta=1e-3)

    def test_a_cylinder_slides_and_turns_about_its_axis_alone(self):
        run = self.run_of("cylindrical", axis_body=[0, 0, 1], gravity=(0, 0, -10), coordinates=[0, 0], rates=[1, 0.5],
                          velocity_m_per_s=[1, 0, 0.5], angular_velocity_body_rad_per_s=[0, 0, 1])
        for found, exact in zip(run.samples[-1]["joints"][0], (1, -4.5, 1, -9.5)):
            self.assertAlmostEqual(found, exact, delta=5e-3)

    def test_stops_hold_where_the_scene_says(self):
        turned_frame = {"frame_wxyz": exp([0, 0, 0.4]), "orientation_wxyz": exp([0, 0, 0.4])}
        slider = self.run_of("slider", axis_body=[0, 0, 1], limits_m=[-0.5, 1], gravity=(0, 0, -10))
        self.assertAlmostEqual(slider.samples[-1]["joints"][0][0], -0.5, delta=1e-3)
        place = {"position_m": [-x for x in turned(exp([0, 0, 0.4]), [0, 1, 0])]}
        hinge = self.run_of("hinge", axis_body=[0, 0, 1], limits_rad=[-0.3, 0.2], gravity=(0, 0, 0), **turned_frame, **place,
                            angular_velocity_body_rad_per_s=[0, 0, 1], velocity_m_per_s=turned(exp([0, 0, 0.4]), [1, 0, 0]))
        self.assertAlmostEqual(hinge.samples[-1]["joints"][0][0], 0.2, delta=2e-3)

    def test_a_child_that_overlaps_its_fixed_parent_is_not_pushed_out(self):
        # The pendulum above from 0.5 rad: its rod reaches into the block, or under the floor, that it hangs on.
        q, rod = exp([0, 0, 0.5]), {"box": {"half_extents_m": [0.1, 1.2, 0.1]}}
        a = body("a", inertia_kg_m2=self.INERTIA, shape=rod, position_m=[math.sin(0.5), -math.cos(0.5), 0], orientation_wxyz=q)
        block = body("block", fixed=True, mass_kg=0, shape={"box": {"half_extents_m": [0.3, 0.3, 0.3]}}, position_m=[0.1, 0.2, 0],
                     orientation_wxyz=TILTED)
        plane = body("plane", fixed=True, mass_kg=0, shape={"plane": {"normal": [0, 0, 1], "offset_m": 0}}, position_m=[0.1, 0.2, 0],
                     orientation_wxyz=TILTED)
        back = [TILTED[0], *(-x for x in TILTED[1:])]
        for parent in (block, plane):
            joint = {"name": "j", "kind": "hinge", "bodies": [parent["name"], "a"], "axis_body": [0, 0, 1], "coordinates": [0.5],
                     "anchors_body_m": [turned(back, [-0.1, -0.2, 0]), [0, 1, 0]], "frame_wxyz": back, "rates": [0]}
            run = Run(DEFAULT, scene(parent, a, gravity=(0, -10, 0), joints=[joint]), 1, 480)
            self.assertEqual(run.done["status"], "ok", run.done)
            self.assertAlmostEqual(run.body(1)["p"][0], math.sin(-0.477904), delta=1e-3, msg=parent["name"])
            self.assertAlmostEqual(run.body(1)["w"][2], -0.415901, delta=1e-3, msg=parent["name"])
            self.assertAlmostEqual(run.body(1)["p"][2], 0, delta=1e-3, msg=parent["name"])
            self.assertFalse(any(line.get("contacts") for line in run.samples), parent["name"])

    def test_a_spring_of_a_joint_is_evaluated_by_the_adapter(self):
        joint = {"name": "j", "kind": "hinge", "bodies": ["world", "a"], "anchors_body_m": [[0, 0, 0], [0, 0, 0]], "axis_body": [0, 0, 1],
                 "frame_wxyz": [1, 0, 0, 0], "coordinates": [0], "rates": [1]}
        spring = {"kind": "joint-spring", "joint": "j", "stiffness_N_m_per_rad": 1.6, "rest_rad": 0, "damping_N_m_s_per_rad": 0}
        a = body("a", inertia_kg_m2=self.INERTIA, angular_velocity_body_rad_per_s=[0, 0, 1])
        run = Run(DEFAULT, scene(a, joints=[joint], joint_forces=[spring]), 1, 960)
        self.assertAlmostEqual(run.samples[-1]["joints"][0][0], math.sin(2) / 2, delta=2e-3)  # omega = sqrt(1.6 / 0.4) = 2
        self.assertIn("joint-spring", run.done["reason"])

    def test_what_joints_are_refused(self):
        free = {"name": "j", "kind": "hinge", "bodies": ["world", "a"], "anchors_body_m": [[0, 0, 0], [0, 1, 0]], "axis_body": [0, 0, 1],
                "frame_wxyz": [1, 0, 0, 0], "coordinates": [0], "rates": [0]}
        a = body("a", position_m=[0, -1, 0])
        for members, word in (({"driven_rate_rad_per_s": 1}, "prescribed rate"), ({"limits_rad": [-1, 1], "stop_restitution": 0.5}, "restitution"),
                              ({"limits_rad": [-4, 1]}, "pi"),
                              ({"kind": "universal", "axes_body": [[1, 0, 0], [0, 0, 1]], "coordinates": [0, 0], "rates": [0, 0]}, "universal")):
            done = Run(DEFAULT, scene(a, joints=[{**free, **members}]), 1, 60).done
            self.assertEqual(done["status"], "unsupported")
            self.assertIn(word, done["reason"])
        rope = {"name": "r", "bodies": ["a", "b"], "points_body_m": [[0, 0, 0], [0, 0, 0]], "over": []}
        done = Run(DEFAULT, scene(a, body("b"), ropes=[rope]), 1, 60).done
        self.assertIn("ropes", done["reason"])


class Words(unittest.TestCase):
    def refused(self, method, *bodies, **members):
        done = Run(method, scene(*bodies, **members), 1, 60).done
        self.assertEqual(done["status"], "unsupported", done)
        return done["reason"]

    def test_refusals_name_what_is_not_there(self):
        ball = body("a", shape=Contacts.BALL, position_m=[0, 0, 1])
        for method, word in (("fast", "rapier/fast"), ("default:1e-6", "no error control"), ("default+impulse", "+impulse"),
                             ("default@double", "float"), ("default{erp=1}", "erp"), ("default{substeps=0}", "substeps"),
                             ("default{build=fast}", "deterministic"), ("default{max_linear_speed=500}", "max_linear_speed")):
            self.assertIn(word, self.refused(method, ball))
        moving = body("f", fixed=True, velocity_m_per_s=[1, 0, 0], shape=Contacts.BALL)
        self.assertIn("`f` moves", self.refused(DEFAULT, ball, moving))
        mesh = body("m", shape={"mesh": {"points_m": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "triangles": [[0, 1, 2]]}})
        self.assertIn("`m`", self.refused(DEFAULT, ball, mesh))
        rolling = scene(floor(), ball)
        rolling["pairs"][0]["rolling_friction_m"] = 0.01
        self.assertIn("rolling friction", Run(DEFAULT, rolling, 1, 60).done["reason"])
        compliant = scene(floor(), ball)
        compliant["pairs"][0].update(contact_law="linear", stiffness_N_per_m=1e4, damping_N_s_per_m=0)
        self.assertIn("compliant", Run(DEFAULT, compliant, 1, 60).done["reason"])
        names = "abcdefghi"  # 45 pairs, each with a friction of its own: more layers than Rapier has groups
        laws = [(x, y, 0, 0.01 * (7 * i * i + 3 * j + i * j) % 1) for i, x in enumerate(names) for j, y in enumerate(names) if i <= j]
        many = [body(f"{name}{k}", material=name, shape=Contacts.BALL, position_m=[i, k, 0]) for i, name in enumerate(names) for k in (0, 1)]
        self.assertIn("each pair its law", self.refused(DEFAULT, *many, laws=laws_of([(x, 0, 0) for x in names], laws)))

    def test_shapes_that_are_none_are_refused_by_name(self):
        for points in ([[0, 0, 0.1 * k] for k in range(5)], [[0, 0, -0.1], [0, 0, 0.1]], [[0.1, 0, 0]] * 4):
            self.assertIn("no hull of the points of `line`", self.refused(DEFAULT, floor(), body("line", shape={"convex": {"points_m": points}})))
        empty = body("empty", fixed=True, shape={"mesh": {"points_m": [[0, 0, 0]], "triangles": []}})
        self.assertIn("without triangles: `empty`", self.refused(DEFAULT, empty, body("a", shape=Contacts.BALL)))
        for radius_m in (1e39, 1e-50):  # infinite and nothing, in float
            self.assertIn("computes in float", self.refused(DEFAULT, floor(), body("a", shape={"sphere": {"radius_m": radius_m}})))

    def test_hello_has_every_setting_and_a_rule_for_each(self):
        hello = WORKER.hello()
        self.assertEqual(hello["scalar"], "float")
        self.assertIn("WebAssembly", hello["version"])
        for method in hello["methods"]:
            self.assertEqual(set(method["settings"]), set(method["setting_rules"]))
            self.assertTrue(all(rule["doc"] for rule in method["setting_rules"].values()))
            for name, rule in method["setting_rules"].items():  # choices are of words and flags, numbers have bounds
                value = method["settings"][name]
                self.assertFalse("choices" in rule and type(value) in (int, float), name)
                self.assertTrue("choices" in rule or type(value) is bool or rule["least"] <= value <= rule["most"], name)
            self.assertIsInstance(method["settings"]["contact_damping_ratio"], float)

    def test_times_are_marked_and_two_runs_are_the_same_to_the_bit(self):
        one = scene(body("a", angular_velocity_body_rad_per_s=[1, 2, 3], inertia_kg_m2=MIXED))
        timed = Run(DEFAULT, one, 1, 60, repeats=3, **{"pass": "timing"})
        self.assertEqual(timed.samples, [])
        self.assertEqual(len(timed.done["busy_ns"]), 3)
        self.assertGreater(timed.done["call_ns"], 0)
        for method in (DEFAULT, "deterministic"):
            self.assertEqual(Run(method, one, 10, 600, 10).samples, Run(method, one, 10, 600, 10).samples)


if __name__ == "__main__":
    if not os.path.exists(f"{BIN_DIR}/atwood-rapier"):
        print("rapier is not built")
        sys.exit(77)
    WORKER = Worker(BIN_DIR, "rapier")
    unittest.main(argv=sys.argv[:1] + sys.argv[2:])
