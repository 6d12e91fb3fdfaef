"""Scenes as the worker protocol has them, the answers of workers to them, and rotations. Quaternions are w, x, y, z."""
import json
import math
import shutil
import subprocess


def body(name="body", **changes):
    """A free body of 1 kg at the origin, at rest, with the moments of inertia 0.1, 0.2, 0.25 kg m2."""
    made = {"name": name, "mass_kg": 1.0, "inertia_kg_m2": [0.1, 0, 0, 0, 0.2, 0, 0, 0, 0.25], "material": "stone",
            "position_m": [0, 0, 0], "orientation_wxyz": [1, 0, 0, 0], "velocity_m_per_s": [0, 0, 0],
            "angular_velocity_body_rad_per_s": [0, 0, 0], "charge_C": 0, "fixed": False, "release_s": 0}
    return {**made, **changes}


def ball(name="ball", radius_m=0.1, mass_kg=1.0, **changes):
    i = 0.4 * mass_kg * radius_m**2
    return body(name, mass_kg=mass_kg, inertia_kg_m2=[i, 0, 0, 0, i, 0, 0, 0, i], shape={"sphere": {"radius_m": radius_m}},
                **changes)


def floor(**changes):
    return body("floor", fixed=True, shape={"plane": {"normal": [0, 0, 1], "offset_m": 0}}, **changes)


def law(a="stone", b="stone", restitution=0.0, friction=0.0, rolling_friction_m=0.0):
    return {"between": [a, b], "restitution": restitution, "friction": friction, "rolling_friction_m": rolling_friction_m}


def scene(*bodies, gravity=(0, 0, 0), forces=(), laws=(law(),), **more):
    materials = sorted({name for each in laws for name in each["between"]})
    return {"problem": "", "gravity_m_per_s2": list(gravity), "bodies": list(bodies), "forces": list(forces),
            "materials": [{"name": name, "restitution": 0, "friction": 0, "rolling_friction_m": 0} for name in materials],
            "pairs": [dict(law) for law in laws], **more}


def has_node():
    """Whether there is a Node.js of version 18.3 or newer on the path."""
    node = shutil.which("node")
    told = node and subprocess.run([node, "-p", "process.versions.node"], text=True, capture_output=True, timeout=60).stdout
    return bool(told) and [int(part) for part in told.split(".")[:2]] >= [18, 3]


class Worker:
    """A worker process: `name` in the folder of the programs, or the program `path`."""

    def __init__(self, bin_dir, name, path=None):
        self.name = name
        self.process = subprocess.Popen([path or f"{bin_dir}/atwood-{name}"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def answer(self, **request):
        """The lines of the answer, as objects; numbers that are text as they are."""
        print(json.dumps(request), file=self.process.stdin, flush=True)
        lines = []
        while not lines or not ("done" in lines[-1] or "engine" in lines[-1]):
            text = self.process.stdout.readline()
            if not text:
                raise AssertionError(f"{self.name} ended with exit code {self.process.wait()}")
            lines.append(json.loads(text))
        return lines

    def hello(self):
        return self.answer(protocol=1, request="hello")[0]

    def end(self, scheme, of, t_end_s, steps, **more):
        """Rows of bodies at the end: [p, q, v, w] of each, of three, four, three and three numbers."""
        run = Run(self, scheme, of, t_end_s, steps, **more)
        if run.done["status"] != "ok":
            raise AssertionError(f"{self.name}/{scheme}: {run.done}")
        return [(row[:3], row[3:7], row[7:10], row[10:]) for row in run.samples[-1]["bodies"]]

    def reason(self, scheme, of, t_end_s=0.1, steps=1):
        done = Run(self, scheme, of, t_end_s, steps).done
        return f"{done['status']}: {done['reason']}"

    def close(self):
        self.process.stdin.close()
        self.process.wait()
        self.process.stdout.close()


class Run:
    """An accuracy pass: `samples`, the lines of the protocol; all `events`; `done`, the outcome."""

    def __init__(self, worker, scheme, of, t_end_s, steps, samples=1, **more):
        lines = worker.answer(**{"request": "run", "cell": 1, "method": f"{worker.name}/{scheme}", "pass": "accuracy",
                                 "t_end_s": t_end_s, "steps": steps, "samples": samples, "repeats": 0, "scene": of, **more})
        self.done = lines[-1]["done"]
        self.samples = [line for line in lines if "t_s" in line]
        self.events = [event for line in lines for event in line.get("events", [])]

    def body(self, i, k=-1):
        """{p, q, v, w} of body i at sample k."""
        row = self.samples[k]["bodies"][i]
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


def bounced(radius_m, v, n, restitution, friction):
    """Velocity and rate (world axes) over the mass of a solid ball that struck a fixed plane of unit normal n at v, without spin:
    the friction impulse opposes the slip, and is the least of what stops it, 2/7 of the slip, and friction times the normal one."""
    normal = sum(a * b for a, b in zip(v, n))
    slip = [a - normal * b for a, b in zip(v, n)]
    size = math.hypot(*slip)
    stopped = min(2 / 7, friction * (1 + restitution) * -normal / size)
    lost = [stopped * a for a in slip]
    x, y, z = n
    turning = [y * lost[2] - z * lost[1], z * lost[0] - x * lost[2], x * lost[1] - y * lost[0]]  # -r n x -lost / (2/5 r^2)
    return [a - (1 + restitution) * normal * b - c for a, b, c in zip(v, n, lost)], [2.5 / radius_m * a for a in turning]


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


def across_a_weld():
    """A hinge from a to b and a weld from b to c: a and c overlap, and no joint connects them."""
    box = {"box": {"half_extents_m": [0.5, 0.1, 0.1]}}
    at = [("a", [0, 0, 0]), ("b", [1.0, 0, 0]), ("c", [0.9, 0.15, 0])]
    bodies = [body(name, position_m=p, shape=box) for name, p in at]
    hinge = {"name": "hinge", "kind": "hinge", "bodies": ["a", "b"], "anchors_body_m": [[0.5, 0, 0], [-0.5, 0, 0]],
             "axis_body": [0, 0, 1], "coordinates": [0.0]}
    weld = {"name": "weld", "kind": "fixed", "bodies": ["b", "c"], "anchors_body_m": [[-0.1, 0.15, 0], [0, 0, 0]], "coordinates": []}
    joints = [{"frame_wxyz": [1, 0, 0, 0], "rates": [0.0] * len(each["coordinates"]), "closes_loop": False, **each}
              for each in (hinge, weld)]
    return scene(*bodies, joints=joints)
