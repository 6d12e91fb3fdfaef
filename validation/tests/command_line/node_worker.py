"""Engines under Node.js, asked by the worker protocol itself: scenes of known answer need no other program. Called with the
program, beside which the workers are, and the project's root."""
import atexit
import json
import math
import os
import subprocess
import sys

BIN = os.path.dirname(os.path.abspath(sys.argv[1] if len(sys.argv) > 1 else "build/release/bin/atwood"))
NOT_BUILT = 77  # the exit code of a test that is skipped


def worker_path(engine):
    return os.path.join(BIN, "atwood-" + engine)


def require(engine):
    if not os.path.exists(worker_path(engine)):
        print(f"atwood-{engine} is not there")
        sys.exit(NOT_BUILT)


_running = {}


def ask(engine, *requests):
    """The lines of the answer to requests, as objects. One process answers them all, as in a study."""
    if engine not in _running:
        _running[engine] = subprocess.Popen([worker_path(engine)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        atexit.register(_running[engine].communicate)
    process, lines = _running[engine], []
    for request in requests:
        process.stdin.write(json.dumps(request) + "\n")
        process.stdin.flush()
        while True:
            text = process.stdout.readline()
            if not text:
                raise AssertionError(f"atwood-{engine} ended with exit code {process.wait()}")
            lines.append(json.loads(text))
            if "done" in lines[-1] or "engine" in lines[-1]:
                break
    return lines


def body(name, **members):
    """A resolved body: a ball of 0.1 m and 2 kg without a shape, at rest at the origin, unless said otherwise."""
    mass = members.get("mass_kg", 2)
    moment = 0.4 * mass * 0.1**2
    return {"name": name, "mass_kg": mass, "inertia_kg_m2": [moment, 0, 0, 0, moment, 0, 0, 0, moment], "material": "default",
            "position_m": [0, 0, 0], "orientation_wxyz": [1, 0, 0, 0], "velocity_m_per_s": [0, 0, 0],
            "angular_velocity_body_rad_per_s": [0, 0, 0], "charge_C": 0, "fixed": False, "release_s": 0, **members}


def ground(**members):
    return body("ground", fixed=True, mass_kg=0, inertia_kg_m2=[0] * 9, shape={"plane": {"normal": [0, 0, 1], "offset_m": 0}}, **members)


def scene(*bodies, gravity=(0, 0, 0), materials=(("default", 0, 0),), pairs=(), **members):
    """A resolved scene. Materials (name, restitution, friction) combine by the geometric mean where `pairs`,
    (a, b, restitution, friction), has no entry."""
    given = {frozenset(pair[:2]): pair[2:] for pair in pairs}
    laws = []
    for i, (a, *of_a) in enumerate(materials):
        for b, *of_b in materials[i:]:
            restitution, friction = given.get(frozenset((a, b)), [math.sqrt(x * y) for x, y in zip(of_a, of_b)])
            laws.append({"between": [a, b], "restitution": restitution, "friction": friction, "rolling_friction_m": 0})
    return {"problem": "", "gravity_m_per_s2": list(gravity), "pairs": laws, "bodies": list(bodies), "forces": [],
            "materials": [{"name": name, "restitution": e, "friction": mu, "rolling_friction_m": 0} for name, e, mu in materials],
            **members}


class Run:
    """An accuracy pass: samples (t_s, rows of bodies), contacts, events and the outcome."""

    def __init__(self, method, scene, t_end_s, steps, samples=1, **members):
        lines = ask(method.partition("/")[0], {"request": "run", "cell": 3, "method": method, "pass": "accuracy", "t_end_s": t_end_s,
                                               "steps": steps, "samples": samples, "repeats": 0, "scene": scene, **members})
        self.done = lines[-1]["done"]
        self.lines = [line for line in lines if "t_s" in line]
        self.events = [event for line in lines for event in line.get("events", [])]

    def body(self, i, k=-1):
        """{p, q, v, w} of body i at sample k."""
        row = self.lines[k]["bodies"][i]
        return {"p": row[0:3], "q": row[3:7], "v": row[7:10], "w": row[10:13]}


def times(a, b):
    """The product of two quaternions w, x, y, z."""
    w, x, y, z = a
    s, i, j, k = b
    return [w * s - x * i - y * j - z * k, w * i + x * s + y * k - z * j, w * j - x * k + y * s + z * i, w * k + x * j - y * i + z * s]


def turned(q, v):
    return times(times(q, [0, *v]), [q[0], -q[1], -q[2], -q[3]])[1:]


def exp(v):
    """The quaternion of a rotation vector [rad]."""
    angle = math.sqrt(sum(x * x for x in v))
    return [math.cos(angle / 2), *(math.sin(angle / 2) * x / angle if angle else 0 for x in v)]


def angle_between(a, b):
    return 2 * math.acos(min(1, abs(sum(x * y for x, y in zip(a, b)))))


def tumbled(inertia, q, w, t_s, steps=4000):
    """Attitude and body rate of a free body after t_s by RK4 in double; inertia: nine numbers, body axes."""
    def times_inertia(m, v):
        return [sum(m[3 * r + c] * v[c] for c in range(3)) for r in range(3)]

    def solve(m, b):
        def det(rows):
            (a, p, c), (d, e, f), (g, h, i) = rows
            return a * (e * i - f * h) - p * (d * i - f * g) + c * (d * h - e * g)
        rows = [m[0:3], m[3:6], m[6:9]]
        return [det([[b[r] if k == c else rows[r][k] for k in range(3)] for r in range(3)]) / det(rows) for c in range(3)]

    def rate(state):
        q, w = state[:4], state[4:]
        (a, b, c), (d, e, f) = w, times_inertia(inertia, w)
        turning = [-(b * f - c * e), -(c * d - a * f), -(a * e - b * d)]
        return [0.5 * x for x in times(q, [0, *w])] + solve(inertia, turning)

    h, y = t_s / steps, [*q, *w]
    for _ in range(steps):
        k1 = rate(y)
        k2 = rate([a + h / 2 * b for a, b in zip(y, k1)])
        k3 = rate([a + h / 2 * b for a, b in zip(y, k2)])
        k4 = rate([a + h * b for a, b in zip(y, k3)])
        y = [a + h / 6 * (p + 2 * r + 2 * s + u) for a, p, r, s, u in zip(y, k1, k2, k3, k4)]
    return y[:4], y[4:]
