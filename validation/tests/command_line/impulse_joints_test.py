"""Mechanisms that touch, in the time stepping of `+impulse`: closed forms, balances and conserved quantities. Called with the
program and the project's root."""
import csv
import io
import math
import os
import sys
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from case import ROOT, Case  # noqa: E402

METHOD = "atwood/symplectic-euler+impulse"
G = 9.81


def scene(bodies, joints=(), t_end_s=1.0, samples=20, gravity=G, restitution=0.0, friction=0.0, forces=(), more=""):
    """A scene's text. A body or joint is a dict of its keys, their values as TOML has them."""
    steps = samples * 12
    out = ['id = "scene"', f"[run]\nt_end_s = {t_end_s}\nsteps = [{steps}]\nsamples = {samples}",
           f"[world]\ngravity_m_per_s2 = [0, 0, {-gravity}]",
           f"[material.stuff]\nrestitution = {restitution}\nfriction = {friction}"]
    for kind, all_of in (("body", bodies), ("joint", joints), ("force", forces)):
        for one in all_of:
            lines = [f"{key} = {value}" for key, value in one.items()]
            out.append(f"[[{kind}]]\n" + "\n".join(lines + (['material = "stuff"'] if kind == "body" else [])))
    return "\n".join(out) + '\n[truth]\nkind = "none"\n' + more


def sphere(name, radius=0.1, mass=1.0, **more):
    return {"name": f'"{name}"', "mass_kg": mass, "shape.sphere": f"{{ radius_m = {radius} }}", **more}


def box(name, half, mass=1.0, **more):
    return {"name": f'"{name}"', "mass_kg": mass, "shape.box": f"{{ half_extents_m = {list(half)} }}", **more}


def plane(name="floor", normal=(0, 0, 1), offset=0.0):
    return {"name": f'"{name}"', "fixed": "true", "shape.plane": f"{{ normal = {list(normal)}, offset_m = {offset} }}"}


def joint(name, kind, bodies, anchors, **more):
    return {"name": f'"{name}"', "kind": f'"{kind}"', "bodies": "[" + ", ".join(f'"{b}"' for b in bodies) + "]",
            "anchors_body_m": str([list(a) for a in anchors]), **more}


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def rotate(q, v):
    t = [2 * x for x in cross(q[1:], v)]
    return [v[k] + q[0] * t[k] + cross(q[1:], t)[k] for k in range(3)]


def anchor_of(row, at):
    return [p + r for p, r in zip(row["p"], rotate(row["q"], at))]


def gap(rows, a, at_a, b, at_b):
    """The distance of two anchors in one sample; `a` None: the world."""
    x = at_a if a is None else anchor_of(rows[a], at_a)
    return math.dist(x, anchor_of(rows[b], at_b))


def quarter_period(amplitude, inertia, torque):
    """Of a pendulum with inertia th'' = -torque sin th: K(sin(amplitude / 2)) by the arithmetic-geometric mean."""
    a, b = 1.0, math.cos(amplitude / 2)
    for _ in range(20):
        a, b = (a + b) / 2, math.sqrt(a * b)
    return math.pi / (2 * a) * math.sqrt(inertia / torque)


class ImpulseJoints(Case):
    def table(self, text, *words, method=METHOD, steps=None, code=0):
        words = list(words) + (["--steps", str(steps)] if steps else [])
        printed = self.ask("trace", self.path("scene.toml", text), "--method", method, *words, code=code).stdout
        return list(csv.DictReader(io.StringIO(printed)))

    def motion(self, text, **more):
        """A dict of bodies for each sample: p, q, v, w (body axes)."""
        samples = {}
        for row in self.table(text, **more):
            number = [float(x) for x in list(row.values())[2:]]
            samples.setdefault(float(row["t_s"]), {})[row["body"]] = {
                "p": number[0:3], "q": number[3:7], "v": number[7:10], "w": number[10:13]}
        return [samples[t] for t in sorted(samples)]

    # ---- impacts
    def swing(self, steps):
        """A bob that hits a wall where it hangs straight down: the times of its impacts, and closed form."""
        bodies = [plane("wall", (1, 0, 0), -0.1), sphere("bob")]
        pivot = joint("pivot", "hinge", ["world", "bob"], [(0, 0, 0), (0, 0, 1)], axis_body="[0, 1, 0]", angle_rad=-0.5)
        text = scene(bodies, [pivot], t_end_s=6.0, restitution=1.0)
        events = [row for row in self.table(text, "--events", steps=steps) if row["kind"] == "impact"]
        quarter = quarter_period(0.5, 1 + 0.4 * 0.01, G)
        return [float(row["t_s"]) - (2 * n + 1) * quarter for n, row in enumerate(events)], events

    def test_a_pendulum_that_hits_a_wall(self):
        coarse, events = self.swing(720)
        fine, _ = self.swing(2880)
        self.assertEqual(len(coarse), 6)
        self.assertEqual(len(fine), 6)
        self.assertLess(max(map(abs, coarse)), 0.012)
        self.assertLess(max(map(abs, fine)), max(map(abs, coarse)) / 3)  # order 1
        # m l v with v^2 = 2 m g l (1 - cos) l^2 / I at the point; the impulse doubles it
        speed = math.sqrt(2 * G * (1 - math.cos(0.5)) / (1 + 0.4 * 0.01))
        for row in events:
            self.assertAlmostEqual(-float(row["vn_after_m_per_s"]) / float(row["vn_before_m_per_s"]), 1, delta=1e-12)
            self.assertAlmostEqual(abs(float(row["vn_before_m_per_s"])), speed, delta=0.03 * speed)
            self.assertAlmostEqual(float(row["impulse_n_N_s"]), 2 * speed * 1.004, delta=0.06 * speed)

    def dumbbells(self, swap=False):
        def pair(name, x, speed):
            return [sphere(name + "1", position_m=f"[{x}, 0, 0.03]", velocity_m_per_s=f"[{speed}, 0, 0]",
                           angular_velocity_body_rad_per_s="[0.3, -1, 0.2]"), box(name + "2", (0.1, 0.06, 0.04), 2.0)]
        bodies = pair("a", -1.0, 2.0) + pair("b", 1.0, -1.0)
        joints = [joint("ja", "ball", ["a1", "a2"], [(0, 0.2, 0), (0, -0.2, 0)]),
                  joint("jb", "hinge", ["b1", "b2"], [(0, -0.2, 0.02), (0, 0.2, 0)], axis_body="[1, 0, 0]", angle_rad=0.4)]
        if swap:
            bodies, joints = bodies[2:] + bodies[:2], joints[::-1]
        return scene(bodies, joints, t_end_s=1.5, gravity=0.0, restitution=0.5, friction=0.3)

    def momenta(self, rows):
        inertia = {"1": [0.4 * 0.01] * 3, "2": [2 / 3 * (b * b + c * c) for b, c in ((0.06, 0.04), (0.1, 0.04), (0.1, 0.06))]}
        linear, angular = [0.0] * 3, [0.0] * 3
        for name, row in rows.items():
            mass = 1.0 if name[1] == "1" else 2.0
            spin = rotate(row["q"], [i * w for i, w in zip(inertia[name[1]], row["w"])])
            orbit = cross(row["p"], row["v"])
            for k in range(3):
                linear[k] += mass * row["v"][k]
                angular[k] += mass * orbit[k] + spin[k]
        return linear + angular

    def test_momenta_of_colliding_mechanisms(self):
        samples = self.motion(self.dumbbells())
        start = self.momenta(samples[0])
        for rows in samples:
            for before, now in zip(start, self.momenta(rows)):
                self.assertAlmostEqual(before, now, delta=1e-12)
            self.assertLess(gap(rows, "a1", (0, 0.2, 0), "a2", (0, -0.2, 0)), 1e-13)
            self.assertLess(gap(rows, "b1", (0, -0.2, 0.02), "b2", (0, 0.2, 0)), 1e-13)
        impacts = [row for row in self.table(self.dumbbells(), "--events") if row["kind"] == "impact"]
        self.assertGreater(len(impacts), 0)
        self.assertGreater(min(float(row["impulse_t_N_s"]) for row in impacts), 0)

    def test_the_order_of_bodies(self):
        one, other = self.motion(self.dumbbells()), self.motion(self.dumbbells(swap=True))
        for rows, same in zip(one, other):
            for name in rows:
                self.assertLess(math.dist(rows[name]["p"], same[name]["p"]), 1e-9)

    # ---- lasting contact
    def test_two_boxes_joined_are_one(self):
        pair = scene([plane(), box("left", (0.1, 0.1, 0.05), position_m="[0, 0, 0.05]", velocity_m_per_s="[2, 1, 0]"),
                      box("right", (0.1, 0.1, 0.05))],
                     [joint("weld", "fixed", ["left", "right"], [(0.1, 0, 0), (-0.1, 0, 0)])], friction=0.4)
        whole = scene([plane(), box("both", (0.2, 0.1, 0.05), 2.0, position_m="[0.1, 0, 0.05]", velocity_m_per_s="[2, 1, 0]")],
                      friction=0.4)
        stop = 5.0 / (2 * 0.4 * G)
        two, one = self.motion(pair), self.motion(whole)
        for rows, same in zip(two, one):
            middle = [(a + b) / 2 for a, b in zip(rows["left"]["p"], rows["right"]["p"])]
            self.assertLess(math.dist(middle, same["both"]["p"]), 1e-9)
        self.assertAlmostEqual(math.dist(middle, [0.1, 0, 0.05]), stop, delta=0.01)

    def test_a_car_that_slides_until_its_wheels_roll(self):
        """Friction on the wheels: the car keeps its angular momentum about the road, v = m v0 / (m + 4 I / r^2)."""
        bodies = [plane(), box("hull", (0.5, 0.2, 0.05), 4.0, position_m="[0, 0, 0.15]", velocity_m_per_s="[2, 0, 0]")]
        joints = []
        for k, (x, y) in enumerate(((0.4, 0.26), (0.4, -0.26), (-0.4, 0.26), (-0.4, -0.26))):
            bodies.append({"name": f'"w{k}"', "mass_kg": 0.5, "shape.cylinder": "{ radius_m = 0.15, half_length_m = 0.04 }"})
            joints.append(joint(f"a{k}", "hinge", ["hull", f"w{k}"], [(x, y, 0), (0, 0, 0)], axis_body="[0, 0, 1]",
                                frame_wxyz="[0.7071067811865476, 0.7071067811865476, 0, 0]"))
        text = scene(bodies, joints, t_end_s=2.0, friction=0.8)
        speed = 6 * 2 / (6 + 4 * 0.5 * 0.5)
        last = self.table(text, "--joints")[-4:]
        for row in last:
            self.assertAlmostEqual(float(row["u0"]), -speed / 0.15, delta=1e-9)
        self.assertAlmostEqual(self.motion(text)[-1]["hull"]["v"][0], speed, delta=1e-9)

    def test_a_chain_falls_and_rests(self):
        count, half = 6, 0.12
        bodies = [plane(), box("l0", (half, 0.04, 0.03), position_m="[0, 0, 0.3]", velocity_m_per_s="[0.5, 0, 0]",
                               orientation_wxyz="[0.9238795325112867, 0, -0.3826834323650898, 0]")]
        joints = []
        for k in range(1, count):
            bodies.append(box(f"l{k}", (half, 0.04, 0.03)))
            joints.append(joint(f"j{k}", "ball" if k % 2 else "hinge", [f"l{k - 1}", f"l{k}"], [(half, 0, 0), (-half, 0, 0)],
                                **({} if k % 2 else {"axis_body": "[0, 1, 0]", "angle_rad": 0.3})))
        text = scene(bodies, joints, t_end_s=4.0, friction=0.5)
        for rows in self.motion(text):
            for k in range(1, count):
                self.assertLess(gap(rows, f"l{k - 1}", (half, 0, 0), f"l{k}", (-half, 0, 0)), 1e-13)
        for name, row in rows.items():
            if name == "floor":
                continue
            self.assertLess(math.hypot(*row["v"]) + 0.1 * math.hypot(*row["w"]), 1e-6, name)
            for corner in ((x, y, z) for x in (-half, half) for y in (-0.04, 0.04) for z in (-0.03, 0.03)):
                self.assertGreater(anchor_of(row, corner)[2], -2e-3)

    def test_reactions_of_a_beam_on_the_floor(self):
        """A bar on a hinge, its far end a ball on the floor: the hinge carries what the floor does not."""
        bodies = [plane(offset=-0.1), box("bar", (0.5, 0.02, 0.02), 2.0), sphere("foot", 0.1, 1.0)]
        joints = [joint("pin", "hinge", ["world", "bar"], [(0, 0, 0), (-0.5, 0, 0)], axis_body="[0, 1, 0]"),
                  joint("weld", "fixed", ["bar", "foot"], [(0.5, 0, 0), (0, 0, 0)])]
        last = self.table(scene(bodies, joints), "--joints")[-2:]
        # about the pin: N = (2 * 0.5 + 1 * 1) g / 1
        self.assertAlmostEqual(float(last[0]["fz_N"]), (3 - 2) * G, delta=1e-9)
        self.assertAlmostEqual(float(last[1]["fz_N"]), -1 * G, delta=1e-9)  # on the foot: its weight less N
        self.assertAlmostEqual(float(last[0]["fx_N"]), 0, delta=1e-9)
        self.assertAlmostEqual(float(last[0]["q0"]), 0, delta=1e-12)

    def test_a_loop_on_the_floor(self):
        """A parallelogram of four rods that stands up leans over and falls flat, its joints closed."""
        rods = [box(name, (0.15, 0.02, 0.02)) for name in ("a", "b", "c")]  # with room between their ends
        hinge = {"axis_body": "[0, 1, 0]"}
        joints = [joint("j1", "hinge", ["world", "a"], [(0, 0, 0.05), (-0.2, 0, 0)], angle_rad=-1.0, **hinge),
                  joint("j2", "hinge", ["a", "b"], [(0.2, 0, 0), (-0.2, 0, 0)], angle_rad=1.0, **hinge),
                  joint("j3", "hinge", ["b", "c"], [(0.2, 0, 0), (0.2, 0, 0)], angle_rad=-1.0, **hinge),
                  joint("j4", "hinge", ["world", "c"], [(0.4, 0, 0.05), (-0.2, 0, 0)], closes_loop="true", **hinge)]
        samples = self.motion(scene([plane()] + rods, joints, t_end_s=2.0, friction=0.3))
        for rows in samples:
            self.assertLess(gap(rows, None, (0.4, 0, 0.05), "c", (-0.2, 0, 0)), 1e-12)
            self.assertLess(abs(rows["c"]["p"][1]), 1e-12)
        self.assertLess(samples[-1]["b"]["p"][2], 0.06)
        self.assertLess(math.hypot(*samples[-1]["b"]["v"]), 1e-6)

    # ---- joints alone, beside a pair that could touch
    def along(self, kind, t_end_s=2.0, forces=(), aside=(), **keys):
        bodies = [sphere("still", position_m="[9, 9, 9]", velocity_m_per_s="[0, 0, 0]"), sphere("bob", 0.1, 2.0)]
        keys = {"axis_body": "[1, 0, 0]", **keys}
        text = scene(bodies, [joint("along", kind, ["world", "bob"], [(0, 0, 0), (0, 0, 0)], **keys)], t_end_s=t_end_s,
                     gravity=0.0, forces=forces)
        return text

    def test_springs_dampers_and_motors(self):
        spring = {"kind": '"joint-spring"', "joint": '"along"'}
        rows = self.table(self.along("slider", offset_m=0.1, forces=[{**spring, "stiffness_N_per_m": 50.0}]), "--joints", steps=960)
        self.assertAlmostEqual(float(rows[-1]["q0"]), 0.1 * math.cos(5 * 2.0), delta=2e-3)
        rows = self.table(self.along("slider", rate_m_per_s=1.0, forces=[{**spring, "damping_N_s_per_m": 3.0}]), "--joints",
                          steps=960)
        self.assertAlmostEqual(float(rows[-1]["u0"]), math.exp(-3.0), delta=1e-3)
        stiff = self.table(self.along("slider", rate_m_per_s=1.0, forces=[{**spring, "damping_N_s_per_m": 1e6}]), "--joints")
        self.assertLess(abs(float(stiff[-1]["u0"])), 1e-9)  # stable at any damping
        motor = {"kind": '"joint-torque"', "joint": '"along"', "torque_N_m": 0.016}
        rows = self.table(self.along("hinge", forces=[motor]), "--joints", steps=960)
        self.assertAlmostEqual(float(rows[-1]["u0"]), 0.016 / (0.4 * 2 * 0.01) * 2.0, delta=1e-9)
        self.assertAlmostEqual(float(rows[-1]["applied0"]), 0.016, delta=1e-12)
        rows = self.table(self.along("hinge", driven_rate_rad_per_s=7.0), "--joints")
        self.assertAlmostEqual(float(rows[-1]["q0"]), 14.0, delta=1e-10)

    def test_stops(self):
        keys = {"rate_m_per_s": 1.0, "limits_m": "[-0.25, 0.25]"}
        rows = self.table(self.along("slider", stop_restitution=1.0, **keys), "--joints")
        self.assertAlmostEqual(float(rows[-1]["q0"]), 0.0, delta=1e-10)  # back and forth twice in 2 s
        self.assertAlmostEqual(float(rows[-1]["u0"]), 1.0, delta=1e-12)
        events = self.table(self.along("slider", stop_restitution=0.5, **keys), "--events")
        self.assertAlmostEqual(float(events[0]["t_s"]), 0.25, delta=1e-10)
        self.assertAlmostEqual(float(events[1]["t_s"]), 0.25 + 1.0, delta=1e-10)
        push = {"kind": '"joint-torque"', "joint": '"along"', "force_N": 4.0}
        rows = self.table(self.along("slider", forces=[push], limits_m="[-1, 0.25]"), "--joints")
        self.assertAlmostEqual(float(rows[-1]["q0"]), 0.25, delta=1e-10)
        self.assertAlmostEqual(float(rows[-1]["u0"]), 0.0, delta=1e-10)
        self.assertAlmostEqual(float(rows[-1]["applied0"]), 4.0, delta=1e-12)
        self.assertAlmostEqual(float(rows[-1]["stop0"]), -4.0, delta=1e-6)
        self.assertEqual((rows[0]["applied0"], rows[0]["stop0"]), ("", ""))

    def test_a_contact_throws_a_joint_against_its_stop_within_one_step(self):
        # equal masses: the ball stops at t = 0.1 s, the bob is back from its stop at 0.1002 s and gives the velocity back
        bodies = [sphere("bob"), sphere("ball", position_m="[-0.3, 0, 0]", velocity_m_per_s="[1, 0, 0]")]
        along = joint("along", "slider", ["world", "bob"], [(0, 0, 0), (0, 0, 0)], axis_body="[1, 0, 0]",
                      limits_m="[-1, 0.0001]", stop_restitution=1.0)
        for order in (bodies, bodies[::-1]):
            text = scene(order, [along], gravity=0, restitution=1.0, samples=4)
            end = self.motion(text, steps=4)[-1]
            self.assertAlmostEqual(end["ball"]["v"][0], -1.0, delta=1e-12)
            self.assertAlmostEqual(end["ball"]["p"][0], -0.2 - 0.8998, delta=1e-10)
            self.assertAlmostEqual(end["bob"]["p"][0], 0.0, delta=1e-10)
            kinds = [row["vn_after_m_per_s"] for row in self.table(text, "--events", steps=4) if row["kind"] == "impact"]
            self.assertEqual(len(kinds), 3)

    def test_energy_of_a_double_pendulum_beside_a_ball(self):
        """SHAKE: without contacts its energy has no drift."""
        bodies = [sphere("still", position_m="[9, 9, 9]", fixed="true"), sphere("upper"), sphere("lower")]
        hinge = {"axis_body": "[0, 1, 0]", "angle_rad": 0.7}
        joints = [joint("j1", "hinge", ["world", "upper"], [(0, 0, 0), (0, 0, 0.5)], **hinge),
                  joint("j2", "hinge", ["upper", "lower"], [(0, 0, 0), (0, 0, 0.5)], **hinge)]

        def energy(rows):
            return sum(0.5 * sum(v * v for v in row["v"]) + 0.5 * 0.004 * sum(w * w for w in row["w"]) + G * row["p"][2]
                       for name, row in rows.items() if name != "still")
        text = scene(bodies, joints, t_end_s=20.0, samples=400)
        samples = self.motion(text, steps=4800)
        start = energy(samples[0])
        halves = [max(abs(energy(rows) - start) for rows in half) for half in (samples[:200], samples[200:])]
        self.assertLess(halves[0], 0.1)
        self.assertLess(halves[1], 1.5 * halves[0])

    # ---- what is refused
    def test_refusals(self):
        text = self.dumbbells()
        for method, told in (("atwood/rk4+impulse", "+impulse steps mechanisms only by symplectic-euler"),
                             ("atwood/symplectic-euler+impulse{sleeping=true}", "takes no bodies on joints"),
                             ("atwood/rk4+event", "+event takes no bodies on joints or ropes; use +impulse or +penalty")):
            self.ask("trace", self.path("scene.toml", text), "--method", method, code=1, told=[told])
        rope = ('[[rope]]\nname = "rope"\nbodies = ["a", "b"]\nover_m = [[-0.5, 0, 1], [0.5, 0, 1]]\n')
        text = scene([sphere("a", position_m="[-0.5, 0, 0]"), sphere("b", position_m="[0.5, 0, 0]")], more=rope)
        self.ask("trace", self.path("scene.toml", text), "--method", METHOD, code=1, told=["+impulse takes no ropes"])
        outside = self.along("slider", limits_m="[1, 2]", offset_m=1.5).replace("offset_m = 1.5", "offset_m = 0.5")
        self.ask("trace", self.path("scene.toml", outside), "--method", METHOD, code=[1, 2], told=["limit"])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
