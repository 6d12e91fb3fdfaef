"""Scenes as the worker protocol has them, and the answers of workers to them."""
import json
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
            "pairs": list(laws), **more}


class Worker:
    """A worker process; `bin_dir`: the folder of the programs."""

    def __init__(self, bin_dir, name):
        self.name = name
        self.process = subprocess.Popen([f"{bin_dir}/atwood-{name}"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def ask(self, **request):
        print(json.dumps(request), file=self.process.stdin, flush=True)
        return self.process.stdout

    def hello(self):
        return json.loads(self.ask(protocol=1, request="hello").readline())

    def run(self, scheme, of, t_end_s, steps, samples=1, **more):
        """(samples, done): each sample the line of the protocol, numbers that are text as they are."""
        lines = self.ask(**{"request": "run", "cell": 1, "method": f"{self.name}/{scheme}", "pass": "accuracy", "t_end_s": t_end_s,
                            "steps": steps, "samples": samples, "repeats": 0, "scene": of, **more})
        found = []
        while True:
            line = json.loads(lines.readline())
            if "done" in line:
                self.last = line
                return found, line["done"]
            found.append(line)

    def end(self, scheme, of, t_end_s, steps, **more):
        """Rows of bodies at the end: [p, q, v, w] of each, of three, four, three and three numbers."""
        samples, done = self.run(scheme, of, t_end_s, steps, **more)
        if done["status"] != "ok":
            raise AssertionError(f"{self.name}/{scheme}: {done}")
        return [(row[:3], row[3:7], row[7:10], row[10:]) for row in samples[-1]["bodies"]]

    def reason(self, scheme, of, t_end_s=0.1, steps=1):
        done = self.run(scheme, of, t_end_s, steps)[1]
        return f"{done['status']}: {done['reason']}"

    def close(self):
        self.process.stdin.close()
        self.process.wait()
        self.process.stdout.close()
