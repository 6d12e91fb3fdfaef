"""The figures of docs/rapier.md, docs/jolt.md and docs/mujoco3.md, measured anew. Each table is printed as CSV.

    python3 validation/tests/under_node/findings.py BIN_DIR [TABLE ...]

BIN_DIR: where the programs are (build/release/bin); without a table, the names of all are printed. Engines of a table have to be
built. Scenes of the catalogue are run by `atwood run`, others are asked of the worker."""
import json
import math
import os
import subprocess
import sys
import tempfile

from workers import Run, Worker, angle_between, ball, body, floor, law, scene, tumbled, turned

BIN_DIR = ""
WORKERS = {}


def worker(name):
    return WORKERS.setdefault(name, Worker(BIN_DIR, name))


def ended(method, of, t_end_s, steps, samples=1):
    """An accuracy pass of ENGINE/SCHEME that ended well."""
    engine, scheme = method.split("/", 1)
    run = Run(worker(engine), scheme, of, t_end_s, steps, samples)
    if run.done["status"] != "ok":
        raise SystemExit(f"{method}: {run.done}")
    return run


def catalogue(name):
    """{scene, run} of a scene of the catalogue."""
    return json.loads(subprocess.run([f"{BIN_DIR}/atwood", "describe", name, "--json"], capture_output=True, check=True).stdout)


def measured(scenario, methods, steps, metrics):
    """{(method, steps, metric): value} of `atwood run`; a run that did not end well has its status as the value."""
    options = [word for method in methods for word in ("--method", method)] + [word for n in steps for word in ("--steps", str(n))]
    with tempfile.TemporaryDirectory() as out:
        told = subprocess.run([f"{BIN_DIR}/atwood", "run", "--scenario", scenario, *options, "--no-timing", "--json", "--keep", "none", "--limit", "300",
                               "--out", out], capture_output=True, text=True)
    found = {}
    for row in json.loads(told.stdout)["rows"]:
        key = row["method"], row["steps"]
        if row["metric"] == "status":
            found.update({(*key, metric): row["status"] for metric in metrics})
        elif row["metric"] in metrics and row["value"] is not None:
            found[(*key, row["metric"])] = max(found.get((*key, row["metric"]), 0), row["value"], key=lambda x: abs(x) if x != "nan" else math.inf)
    return found


def show(*cells):
    print(",".join(f"{cell:.6g}" if isinstance(cell, float) else f'"{cell}"' if "," in str(cell) else str(cell) for cell in cells))


def show_catalogue(scenario, methods, steps, metrics):
    found = measured(scenario, methods, steps, metrics)
    for method in methods:
        for n in steps:
            show(scenario, method, n, *(found.get((method, n, metric), "") for metric in metrics))


def largest_shift(run, movable):
    """Largest displacement of a body over the samples, and the part of it across the vertical."""
    found = [0.0, 0.0]
    for sample in run.samples:
        for i in movable:
            d = [a - b for a, b in zip(sample["bodies"][i][:3], run.samples[0]["bodies"][i][:3])]
            found = [max(found[0], math.hypot(*d)), max(found[1], math.hypot(*d[:2]))]
    return found


def energy_and_momentum(moments, motion):
    momentum = turned(motion["q"], [i * w for i, w in zip(moments, motion["w"])])
    return sum(i * w * w for i, w in zip(moments, motion["w"])) / 2, momentum


# ---- the tumbling box -------------------------------------------------------------------------------------------------------


def attitudes(methods, steps):
    """Attitude at the end, w first, its error against RK4 in double, and the relative drifts of angular momentum and energy."""
    described = catalogue("free-box-complex")
    of, t_end_s = described["scene"], described["run"]["t_end_s"]
    box = of["bodies"][0]
    moments = box["inertia_kg_m2"][::4]
    truth, _ = tumbled(box["inertia_kg_m2"], box["orientation_wxyz"], box["angular_velocity_body_rad_per_s"], t_end_s, 100000)
    show("method", "steps", "q_w", "q_x", "q_y", "q_z", "attitude_error_rad", "angular_momentum_drift", "energy_drift")
    show("RK4 of 100 000 steps", "", *truth)
    for method in methods:
        for n in steps:
            run = Run(worker(method.split("/")[0]), method.split("/", 1)[1], of, t_end_s, n)
            if run.done["status"] != "ok":
                show(method, n, run.done["status"], run.done["reason"])
                continue
            (e0, l0), (e1, l1) = (energy_and_momentum(moments, run.body(0, k)) for k in (0, -1))
            q = run.body(0)["q"]
            sign = math.copysign(1, sum(a * b for a, b in zip(q, truth)))
            show(method, n, *(sign * x for x in q), angle_between(q, truth), math.dist(l0, l1) / math.hypot(*l0), e1 / e0 - 1)


def rapier_tumbling():
    attitudes(["rapier/default"], [120, 240, 480, 960, 1920, 3840, 7680])
    attitudes(["rapier/default{solver_iterations=1}"], [480, 960, 1920, 3840])


def rapier_free_spin():
    show("rate_rad_per_s", "moments", "gained", "gained_a_substep")
    for rate, moments in ((0.001, [1, 1, 1]), (1, [1, 1, 1]), (5, [0.4, 0.4, 0.4]), (1, [1, 2, 3])):
        of = scene(body(inertia_kg_m2=[moments[0], 0, 0, 0, moments[1], 0, 0, 0, moments[2]], angular_velocity_body_rad_per_s=[0, 0, rate]))
        gained = math.hypot(*ended("rapier/default", of, 10, 2400).body(0)["w"]) / rate - 1
        show(rate, " ".join(map(str, moments)), gained, gained / 9600)


def rapier_free_top():
    inertia, w = [1.0, 0, 0, 0, 2.0, 0, 0, 0, 3.0], [0.5, 0.3, 1.0]
    truth, _ = tumbled(inertia, [1, 0, 0, 0], w, 10, 20000)
    show("substeps", "attitude_error_rad")
    for n in (60, 240, 960, 3840, 15360, 61440):
        end = ended("rapier/default", scene(body(inertia_kg_m2=inertia, angular_velocity_body_rad_per_s=w)), 10, n).body(0)
        show(4 * n, angle_between(end["q"], truth))


def jolt_tumbling():
    attitudes(["jolt/default"], [480, 960, 1920, 3840, 7680, 15360])
    attitudes(["jolt/default{gyroscopic=false}"], [480, 960, 3840])


def jolt_960():
    """Jolt at 960 steps: how far its attitude moves when only what lies below float's last places, or the set-up, changes."""
    described = catalogue("free-box-complex")
    of, t_end_s = described["scene"], described["run"]["t_end_s"]
    box = of["bodies"][0]
    truth, _ = tumbled(box["inertia_kg_m2"], box["orientation_wxyz"], box["angular_velocity_body_rad_per_s"], t_end_s, 100000)
    quoted = [0.0242, -0.659, 0.0199, 0.7515]
    show("variant", "q_w", "q_x", "q_y", "q_z", "attitude_error_rad", "angle_to_quoted_rad")
    show("quoted", *quoted, angle_between([x / math.hypot(*quoted) for x in quoted], truth), 0.0)
    faster = {**box, "angular_velocity_body_rad_per_s": [x * (1 + 2e-7) for x in box["angular_velocity_body_rad_per_s"]]}
    damped = "default{linear_damping_per_s=0.05,angular_damping_per_s=0.05}"
    for name, scheme, scene_of in (("as in the catalogue", "default", of), ("without gravity", "default", {**of, "gravity_m_per_s2": [0, 0, 0]}),
                                   ("rates larger by 2e-7 of them", "default", {**of, "bodies": [faster]}),
                                   ("attitude negated", "default", {**of, "bodies": [{**box, "orientation_wxyz": [-x for x in box["orientation_wxyz"]]}]}),
                                   ("Jolt's own damping, 0.05 per second", damped, of),
                                   ("Jolt's own limit of rates, 47.1 rad/s", "default{max_angular_velocity_rad_per_s=47.1}", of),
                                   ("gyroscopic=false", "default{gyroscopic=false}", of)):
        q = ended(f"jolt/{scheme}", scene_of, t_end_s, 960).body(0)["q"]
        sign = math.copysign(1, sum(a * b for a, b in zip(q, truth)))
        show(name, *(sign * x for x in q), angle_between(q, truth), angle_between(q, [x / math.hypot(*quoted) for x in quoted]))


def mujoco3_tumbling():
    attitudes([f"{engine}/{scheme}" for scheme in ("default{integrator=RK4}", "default", "default{integrator=implicit}") for engine in ("mujoco", "mujoco3")]
              + ["mujoco3/default{integrator=discrete}", "mujoco3/implicitfast"], [120, 240, 480, 960, 1920, 3840, 7680])


# ---- bounces ----------------------------------------------------------------------------------------------------------------


def last_apex(method, steps):
    """Height above rest of the last apex within 20 s of a ball that falls 1 m, e = 1, from v^2 / 2 g + z of the last rise."""
    of = scene(floor(), ball(position_m=[0, 0, 1.1]), gravity=(0, 0, -9.81), laws=[law(restitution=1)])
    heights = [sample["bodies"][1][2] - 0.1 for sample in ended(method, of, 20, steps, steps).samples]
    tops = [b for a, b, c in zip(heights, heights[1:], heights[2:]) if a < b >= c]
    return tops[-1]


def rapier_bounce():
    show("steps", "prediction 0.02", "0.002", "0")
    for n in (600, 1200, 2400, 4800, 9600):
        show(n, *(last_apex(f"rapier/default{{prediction_distance={d}}}", n) for d in (0.02, 0.002, 0)))


def rapier_impacts():
    show("mass_ratio", "restitution_error", "momentum_error_kg_m_per_s")
    for ratio in (1, 10, 1000):
        of = scene(ball("a", mass_kg=ratio, position_m=[-1, 0, 0], velocity_m_per_s=[1, 0, 0]), ball("b", position_m=[1, 0, 0], velocity_m_per_s=[-1, 0, 0]),
                   laws=[law(restitution=0.5)])
        v = [ended("rapier/default", of, 2, 480).body(i)["v"][0] for i in (0, 1)]
        show(ratio, (v[1] - v[0]) / 2 - 0.5, ratio * v[0] + v[1] - (ratio - 1))


def oblique_bounce():
    show("mu", "rapier", "rapier, prediction 0", "mu / (1 + e)", "jolt")
    for mu in (0.1, 0.35):
        of = scene(floor(), ball("thrown", 0.2, position_m=[0, 0, 0.6001], velocity_m_per_s=[6, 0, -4]), laws=[law(restitution=0.5, friction=mu)])
        ratios = []
        for method in ("rapier/default", "rapier/default{prediction_distance=0}", "jolt/default"):
            x, _, z = ended(method, of, 0.5, 120).body(1)["v"]
            ratios.append((6 - x) / (z + 4))
        show(mu, *ratios[:2], mu / 1.5, ratios[2])


def jolt_bounce():
    show("scenario", "method", "steps", "apex_error", "energy_drift_per_s", "position_error_m")
    metrics = ["apex-error", "energy-drift", "error-position-max"]
    show_catalogue("bounce-e1", ["jolt/default"], [1200, 2400, 4800, 9600], metrics)
    show_catalogue("bounce-e0.8", ["jolt/default"], [1200], metrics)
    for name in ("bounce-e0.5", "oblique-phase"):
        show_catalogue(name, ["jolt/default", "jolt/default{speculative_contact_distance_m=0.005}"], [480], metrics)
    show_catalogue("head-on", ["jolt/default"], [catalogue("head-on")["run"]["steps"][-1]], metrics)


# ---- cradles ----------------------------------------------------------------------------------------------------------------


def cradle(method, count, run_up_m=0.0, mirrored=False):
    """Balls of 0.1 m in a row that touch; the first has 1 m/s and begins run_up_m ahead of the row."""
    balls = [ball(str(k), position_m=[0.2 * k - (run_up_m if k == 0 else 0), 0, 0], velocity_m_per_s=[1.0 if k == 0 else 0, 0, 0])
             for k in range(count)]
    bodies = balls[::-1] if mirrored else balls
    run = ended(method, scene(*bodies, laws=[law(restitution=1)]), 1.5, 360)
    v = [run.body(i)["v"][0] for i in range(count)]
    v = v[::-1] if mirrored else v
    show(method, count, run_up_m, "last first" if mirrored else "in order", " ".join(f"{x:.4f}" for x in v), sum(x * x for x in v))


def rapier_cradle():
    show("method", "balls", "run_up_m", "bodies", "velocities_m_per_s", "energy_kept")
    for count, run_up_m, mirrored in ((3, 0.3, False), (3, 0.3, True), (3, 0.0, False), (5, 0.3, False), (5, 0.0, False)):
        cradle("rapier/default", count, run_up_m, mirrored)


def jolt_cradle():
    show("method", "balls", "run_up_m", "bodies", "velocities_m_per_s", "energy_kept")
    for count in (3, 5):
        for settings in ("", "{min_velocity_for_restitution_m_per_s=0}", "{min_velocity_for_restitution_m_per_s=0,velocity_steps=100}"):
            cradle(f"jolt/default{settings}", count)


# ---- sliding, stacks, the coin ------------------------------------------------------------------------------------------------


def slide(method, steps, angle):
    """Where a box of 0.2 m stops that slides at 3 m/s, mu = 0.3, g = 10 (after 1.5 m), along a direction; then across it."""
    box = body("box", shape={"box": {"half_extents_m": [0.1, 0.1, 0.1]}}, position_m=[0, 0, 0.1], inertia_kg_m2=[1 / 150, 0, 0, 0, 1 / 150, 0, 0, 0, 1 / 150],
               velocity_m_per_s=[3 * math.cos(angle), 3 * math.sin(angle), 0])
    x, y, _ = ended(method, scene(floor(), box, gravity=(0, 0, -10), laws=[law(friction=0.3)]), 1.5, steps).body(1)["p"]
    return x * math.cos(angle) + y * math.sin(angle), y * math.cos(angle) - x * math.sin(angle)


def sliding(methods):
    show("method", "steps", "along x", "sideways", "along the diagonal", "sideways")
    for method in methods:
        for n in (120, 480, 1920):
            show(method, n, *slide(method, n, 0), *slide(method, n, math.pi / 4))


SLIDES = (("stop-distance-0", 360), ("stop-distance-30", 360), ("friction-cone-0", 960), ("friction-cone-60", 960), ("slide-10", 240), ("slip-to-roll", 240),
          ("roll", 240), ("mesh-floor-roll", 360), ("oblique-rough", 480))


def slides(methods):
    show("scenario", "method", "steps", "position_error_m", "attitude_error_rad")
    for name, steps in SLIDES:
        show_catalogue(name, methods, [steps], ["error-position-max", "error-attitude-max"])


def standing(methods):
    show("scenario", "method", "steps", "largest displacement_m", "sideways_m")
    for name, t_end_s in (("stack-10", 10), ("card-house", 5)):
        of = catalogue(name)["scene"]
        movable = [i for i, each in enumerate(of["bodies"]) if not each["fixed"]]
        for method in methods:
            show(name, method, 240 * t_end_s, *largest_shift(ended(method, of, t_end_s, 240 * t_end_s, 60 * t_end_s), movable))


def rapier_stack():
    inertia = [1 / 150, 0, 0, 0, 1 / 150, 0, 0, 0, 1 / 150]
    boxes = [body(f"box{k}", shape={"box": {"half_extents_m": [0.1, 0.1, 0.1]}}, position_m=[0, 0, 0.1 + 0.2 * k], inertia_kg_m2=inertia) for k in range(10)]
    of = scene(floor(), *boxes, gravity=(0, 0, -9.81), laws=[law(friction=0.5)])
    show("method", "steps", "sinks at the top_m", "sideways_m")
    for settings in ("", "{solver_iterations=16}", "{contact_natural_frequency_Hz=120}"):
        for n in (600, 2400):
            run = ended(f"rapier/default{settings}", of, 10, n, 60)
            show(f"rapier/default{settings}", n, 1.9 - run.body(10)["p"][2], largest_shift(run, range(1, 11))[1])
    standing(["rapier/default"])


def coin(methods, steps):
    show("scenario", "method", "steps", "attitude_error_rad", "position_error_m")
    show_catalogue("coin", methods, steps, ["error-attitude-max", "error-position-max"])


def rapier_coin():
    coin([f"rapier/default{settings}" for settings in ("", "{solver_iterations=16}", "{prediction_distance=0}", "{length_unit_m=0.01}")], [250, 500, 1000, 2000, 4000])


# ---- MuJoCo 3 beside 2.2.2 ----------------------------------------------------------------------------------------------------

PAIRED = ["mujoco/default", "mujoco3/default", "mujoco/stiff", "mujoco3/stiff"]


def mujoco3_versions():
    show("scenario", "method", "steps", "position_error_m", "attitude_error_rad")
    for name, steps in (("double-pendulum-regular", 1280), ("heavy-top-loop", 640), ("dzhanibekov", 8000), ("slide-10", 240), ("stop-distance-30", 360),
                        ("friction-cone-60", 960), ("slip-to-roll", 240), ("roll", 240), ("coin", 500), ("andrews", 640), ("four-bar-1", 640)):
        show_catalogue(name, PAIRED, [steps], ["error-position-max", "error-attitude-max"])


def mujoco3_henon():
    show("method", "steps", "status", "reason", "energy_J")
    of = catalogue("henon-heiles")["scene"]
    for method in ("mujoco3/rk4", "mujoco3/default"):
        for n in (960, 1920, 3840, 7680, 15360):
            run = Run(worker("mujoco3"), method.split("/")[1], of, 100, n, 60)
            if run.done["status"] != "ok":
                show(method, n, run.done["status"], run.done["reason"].split(";")[0])
                continue
            x, y, _, _, _, _, _, vx, vy = run.samples[-1]["bodies"][0][:9]
            show(method, n, "ok", "", (vx * vx + vy * vy + x * x + y * y) / 2 + x * x * y - y**3 / 3)


BESIDE_JOLT = ["jolt/default", "mujoco/default", "mujoco/stiff"]
TABLES = {
    "rapier-tumbling": rapier_tumbling, "rapier-free-spin": rapier_free_spin, "rapier-free-top": rapier_free_top, "rapier-bounce": rapier_bounce,
    "rapier-impacts": rapier_impacts, "oblique-bounce": oblique_bounce, "rapier-slide": lambda: sliding(["rapier/default"]),
    "rapier-slides": lambda: slides(["rapier/default"]), "rapier-cradle": rapier_cradle, "rapier-stack": rapier_stack, "rapier-coin": rapier_coin,
    "jolt-tumbling": jolt_tumbling, "jolt-960": jolt_960, "jolt-bounce": jolt_bounce, "jolt-cradle": jolt_cradle, "jolt-slide": lambda: sliding(["jolt/default"]),
    "jolt-slides": lambda: slides(BESIDE_JOLT), "jolt-stacks": lambda: standing(["jolt/default", *PAIRED]),
    "jolt-coin": lambda: coin(["jolt/default", "jolt/default{speculative_contact_distance_m=0}"], [250, 500, 1000, 2000]),
    "mujoco3-tumbling": mujoco3_tumbling, "mujoco3-slide": lambda: sliding(["mujoco/default", "mujoco3/default", "mujoco/stiff", "mujoco3/stiff"]),
    "mujoco3-versions": mujoco3_versions, "mujoco3-stacks": lambda: standing(PAIRED), "mujoco3-henon": mujoco3_henon,
    "mujoco3-coin": lambda: coin(["mujoco3/default", "mujoco3/stiff"], [250, 500, 1000, 2000]),
}

if __name__ == "__main__":
    if len(sys.argv) < 2 or not os.path.exists(f"{sys.argv[1]}/atwood"):
        raise SystemExit(__doc__)
    BIN_DIR = os.path.abspath(sys.argv[1])
    names = sys.argv[2:]
    unknown = [name for name in names if name not in TABLES]
    if unknown or not names:
        raise SystemExit(f"{' '.join(unknown)}{': no such table; ' if unknown else ''}the tables: {' '.join(TABLES)}")
    for name in names:
        print(f"# {name}", flush=True)
        TABLES[name]()
    for each in WORKERS.values():
        each.close()
