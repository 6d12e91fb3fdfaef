#!/usr/bin/env python3
"""A physics engine at Atwood's table: symplectic Euler, v += h a(x, v), then x += h v. Standard library only."""
import hashlib, json, sys, time  # noqa: E401

METHOD = {"id": "python/symplectic-euler", "doc": "Symplectic Euler of point masses.", "settings": {"rotation": "none"}}
FINGERPRINT = hashlib.sha256(open(__file__, "rb").read()).hexdigest()  # changes whenever this engine may
HELLO = {"engine": "python", "version": sys.version.split()[0], "scalar": "double", "fingerprint": FINGERPRINT,
         "methods": [METHOD]}

def refusal(method, scene):  # what this engine can't do, in words; None: it can run the scene
    if method != METHOD["id"]: return "python has no method " + method
    if scene.get("problem"): return "python moves bodies, it has no equations of " + scene["problem"]
    for f in scene["forces"]:
        known = f["kind"] in ("attractor", "gravity", "spring", "drag") and f.get("model") != "quadratic"
        if not known or f.get("damping_N_s_per_m") or any(map(any, f.get("points_body_m", []))):
            return "python has no force like " + json.dumps(f)
    if any(any(b["angular_velocity_body_rad_per_s"]) or b["release_s"] > 0 for b in scene["bodies"]):
        return "python neither turns bodies nor holds them until their release"
    return "python has no contacts" if sum("shape" in b for b in scene["bodies"]) > 1 else None

def accelerations(scene, index, m, p, v):
    a = [list(scene["gravity_m_per_s2"]) for _ in m]
    for f in scene["forces"]:
        kind, rest, b, pairs = f["kind"], f.get("rest_length_m"), [index[name] for name in f["bodies"]], []
        if kind == "drag":
            c, wind = f["coefficient_kg_per_s"], f["wind_m_per_s"]
            for i in b: a[i] = [x - c / m[i] * (u - w) for x, u, w in zip(a[i], v[i], wind)]
        elif kind == "attractor" or kind == "spring" and len(b) == 1:
            pairs = [(i, None, f.get("center_m") or f["anchor_m"]) for i in b]
        else:
            pairs = [(i, j, p[j]) for i in b for j in b if i != j]
        for i, j, center in pairs:  # along the line to `center`: a = -strength d
            d = [x - c for x, c in zip(p[i], center)]; r2 = sum(x * x for x in d)
            if kind == "attractor": strength = f["mu_m3_per_s2"] / r2**1.5
            elif kind == "gravity": strength = f["constant_m3_per_kg_s2"] * m[j] / (r2 + f["softening_m"]**2)**1.5
            else: strength = f["stiffness_N_per_m"] / m[i] * (1 - rest / r2**0.5 if rest else 1)
            a[i] = [x - strength * y for x, y in zip(a[i], d)]
    return a

def run(request, busy_ns):
    scene, steps, timed = request["scene"], request["steps"], request["pass"] == "timing"
    bodies, h, stride = scene["bodies"], request["t_end_s"] / steps, steps // request["samples"]
    index, m = {b["name"]: i for i, b in enumerate(bodies)}, [b["mass_kg"] for b in bodies]
    for _ in range(request["repeats"] if timed else 1):
        p, v = [list(b["position_m"]) for b in bodies], [list(b["velocity_m_per_s"]) for b in bodies]
        start = time.perf_counter_ns()  # the clock sees the stepping alone
        for n in range(steps + 1):
            if n % stride == 0 and not timed:
                rows = [p[i] + b["orientation_wxyz"] + v[i] + [0, 0, 0] for i, b in enumerate(bodies)]
                sample = {"cell": request["cell"], "t_s": request["t_end_s"] * n / steps, "bodies": rows, "events": []}
                print(json.dumps(sample, allow_nan=False))
            a = accelerations(scene, index, m, p, v) if n < steps else []
            for i, body in enumerate(bodies[:len(a)]):
                if not body["fixed"]:
                    v[i] = [u + h * x for u, x in zip(v[i], a[i])]
                    p[i] = [x + h * u for x, u in zip(p[i], v[i])]
        if timed: busy_ns.append(time.perf_counter_ns() - start)

for line in sys.stdin:
    request, busy_ns, status = json.loads(line), [], "unsupported"
    if request["request"] == "hello":
        print(json.dumps(HELLO), flush=True); continue
    reason = refusal(request["method"], request["scene"])
    try:
        if not reason: status = run(request, busy_ns) or "ok"
    except (ArithmeticError, ValueError) as error: status, reason = "not finite", str(error)
    done = {"status": status, "reason": reason or "", "busy_ns": busy_ns, "steps_taken": request["steps"]}
    print(json.dumps({"cell": request["cell"], "done": done}), flush=True)
