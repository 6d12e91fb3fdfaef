"""A scene as a small picture: its shapes at the start and the paths of the true motion."""
import math

from drawing import COLOURS, document, number, polyline

WIDTH, HEIGHT, EDGE = 320, 190, 12
MOST_DRAWN = 600  # bodies, particles: of more, every n-th
FAR = 15  # a body that moves this many times its own size, or not at all, is shown from its own centre


def rotated(q, v):
    w, x, y, z = q
    tx, ty, tz = 2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]), 2 * (x * v[1] - y * v[0])
    return (v[0] + w * tx + y * tz - z * ty, v[1] + w * ty + z * tx - x * tz, v[2] + w * tz + x * ty - y * tx)


def placed_at(q, place, points):
    return [tuple(a + b for a, b in zip(rotated(q, p), place)) for p in points]


def corners(half):
    return [(a * half[0], b * half[1], c * half[2]) for a in (-1, 1) for b in (-1, 1) for c in (-1, 1)]


def outline(shape):
    """(points in body axes, radius of the sphere swept over them); no points: a plane."""
    (kind, s), = shape.items()
    if kind == "sphere":
        return [(0, 0, 0)], s["radius_m"]
    if kind == "box":
        return corners(s["half_extents_m"]), 0
    if kind == "rectangle":
        return corners([*s["half_extents_m"], 0]), 0
    if kind == "capsule":
        return [(0, 0, -s["half_length_m"]), (0, 0, s["half_length_m"])], s["radius_m"]
    if kind == "cylinder":
        turn = [2 * math.pi * k / 24 for k in range(24)]
        return [(s["radius_m"] * math.cos(a), s["radius_m"] * math.sin(a), z * s["half_length_m"]) for a in turn
                for z in (-1, 1)], 0
    if kind in ("convex", "mesh"):
        return s["points_m"], 0
    return [], 0


def parts_of(shape):
    """The convex parts of a shape as (points, radius)."""
    if "compound" in shape:
        return [(placed_at(p["orientation_wxyz"], p["position_body_m"], corners(p["half_extents_m"])), 0)
                for p in shape["compound"]["boxes"]]
    points, radius = outline(shape)
    return [(points, radius)] if points else []


def hull(points):
    points = sorted(set(points))
    if len(points) < 3:
        return points

    def half(sequence):
        chain = []
        for p in sequence:
            while len(chain) > 1 and ((chain[-1][0] - chain[-2][0]) * (p[1] - chain[-2][1])
                                      - (chain[-1][1] - chain[-2][1]) * (p[0] - chain[-2][0])) <= 0:
                chain.pop()
            chain.append(p)
        return chain[:-1]

    return half(points) + half(points[::-1])


def view_of(points):
    """A projection to the plane: along an axis in which nothing extends, else from above the front."""
    extents = [max(p[i] for p in points) - min(p[i] for p in points) for i in range(3)]
    thin = [i for i in range(3) if extents[i] <= 0.02 * max(extents)]
    for axis, shown in ((1, (0, 2)), (2, (0, 1)), (0, (1, 2))):
        if axis in thin and any(extents[i] > 0 for i in shown):
            return lambda p, a=shown[0], b=shown[1]: (p[a], p[b])
    c, s, rise = math.cos(math.radians(-30)), math.sin(math.radians(-30)), math.sin(math.radians(22))
    up = math.cos(math.radians(22))
    return lambda p: (p[0] * c - p[1] * s, p[2] * up + (p[0] * s + p[1] * c) * rise)


def thinned(items):
    return items[::max(1, -(-len(items) // MOST_DRAWN))]


def body_shape(body):
    """Its shape; of a body without one, the box that has its inertia; a point otherwise."""
    if body.get("shape"):
        return body["shape"]
    moments = [body["inertia_kg_m2"][i] for i in (0, 4, 8)]
    squares = [1.5 * (sum(moments) - 2 * moment) / body["mass_kg"] if body["mass_kg"] else 0 for moment in moments]
    if min(squares) < 0 or sum(s > 0 for s in squares) < 2:
        return {"sphere": {"radius_m": 0}}
    return {"box": {"half_extents_m": [math.sqrt(s) for s in squares]}}


def from_its_centre(scene, poses):
    """(scene, path of the tip of the body's longest axis) of a single body that turns on a path far larger than it."""
    if len(scene["bodies"]) != 1 or scene.get("joints") or not poses or len(poses[0]) < 2:
        return None
    body = scene["bodies"][0]
    points = [p for part, _ in parts_of(body_shape(body)) for p in part]
    size = max((max(map(abs, p)) for p in points), default=0)
    reach = max(math.dist(p, poses[0][0][0]) for p, _ in poses[0])
    turned = any(math.dist(q, poses[0][0][1]) > 1e-6 for _, q in poses[0])
    if not (turned and size > 0 and (reach > FAR * size or reach < 1e-9)):
        return None
    axis = max(range(3), key=lambda i: max(abs(p[i]) for p in points))
    tip = [1.15 * size if i == axis else 0 for i in range(3)]
    centred = {**scene, "bodies": [{**body, "position_m": [0, 0, 0]}], "forces": []}
    return centred, [rotated(q, tip) for _, q in poses[0]]


def links(scene):
    """From each joint's point to the centres of the bodies that it ties: pairs of points in the world."""
    bodies = {b["name"]: b for b in scene["bodies"]}
    for joint in scene.get("joints", []):
        for name, point in zip(joint["bodies"], joint.get("anchors_body_m", [[0, 0, 0], [0, 0, 0]])):
            if name in bodies:
                body = bodies[name]
                yield (*placed_at(body["orientation_wxyz"], body["position_m"], [point]), tuple(body["position_m"]))


def picture(title, scene, poses):
    """SVG of a resolved scene; `poses`: for each body its positions and orientations along the truth."""
    trails = [[p for p, _ in path] for path in poses]
    near = from_its_centre(scene, poses)
    if near:
        scene, trails = near[0], [near[1]]
    ties = list(links(scene))
    tied = {name for joint in scene.get("joints", []) for name in joint["bodies"]}
    movable = [b for b in scene["bodies"] if not (b.get("shape") and "plane" in b["shape"])]
    solids = []  # (fixed, points in the world, radius)
    for body in thinned(movable):
        bare = body["name"] in tied and not body.get("shape")
        for points, radius in parts_of({"sphere": {"radius_m": 0}} if bare else body_shape(body)):
            solids.append((body["fixed"], placed_at(body["orientation_wxyz"], body["position_m"], points), radius))
    particles = [(*p, *(0,) * (3 - len(p))) for f in scene.get("fluids", []) for p in f["particles"]["position_m"]]
    centers = [f["center_m"] for f in scene["forces"] if f["kind"] == "attractor"]
    everything = [p for group in ([s[1] for s in solids], trails, [particles], [list(map(tuple, centers))], ties)
                  for points in group for p in points]
    if not everything:
        return None
    view = view_of(everything)
    low3, high3 = [min(p[i] for p in everything) for i in range(3)], [max(p[i] for p in everything) for i in range(3)]
    grounds = [plane["offset_m"] for plane in ((b.get("shape") or {}).get("plane") for b in scene["bodies"])
               if plane and plane["normal"][2] > 0.999 and low3[2] - 1 <= plane["offset_m"] <= high3[2]]
    edge = 0.15 * max(b - a for a, b in zip(low3, high3))
    sides = [(low3[i] - edge, high3[i] + edge) for i in (0, 1)]
    everything += [(x, y, z) for z in grounds for x in sides[0] for y in sides[1]]
    low, high = [math.inf] * 2, [-math.inf] * 2
    for placed, radius in [(s[1], s[2]) for s in solids] + [(everything, 0)]:
        for p in map(view, placed):
            low, high = [min(a, b - radius) for a, b in zip(low, p)], [max(a, b + radius) for a, b in zip(high, p)]
    scale = min((WIDTH - 2 * EDGE) / max(high[0] - low[0], 1e-12), (HEIGHT - 2 * EDGE) / max(high[1] - low[1], 1e-12))
    middle = [(a + b) / 2 for a, b in zip(low, high)]

    def at(p):
        x, y = view(p)
        return WIDTH / 2 + (x - middle[0]) * scale, HEIGHT / 2 - (y - middle[1]) * scale

    parts = []
    for height in grounds:
        (a, c), (b, d) = sides
        around = [at((x, y, height)) for x, y in ((a, b), (c, b), (c, d), (a, d), (a, b))]
        parts.append(polyline(around, "#888", 1))
    for p in thinned(particles):
        x, y = at(p)
        parts.append(f'<circle cx="{number(x)}" cy="{number(y)}" r="1.4" fill="{COLOURS[4]}"/>')
    for x, y in map(at, centers):
        parts.append(f'<path class="ink" d="M{number(x - 4)} {number(y)}h8m-4-4v8" fill="none"/>')
    for k, trail in enumerate(trails):
        if len(trail) > 1:
            parts.append(polyline([at(p) for p in trail], COLOURS[k % len(COLOURS)], 1.1, ' opacity=".8"'))
    for tie in ties:
        parts.append(polyline(map(at, tie), "#888", 2, ' stroke-linecap="round"'))
        parts.append('<circle class="ink" cx="{}" cy="{}" r="2" fill="none"/>'.format(*map(number, at(tie[0]))))
    for fixed, placed, radius in solids:
        colour = "#8888" if fixed else COLOURS[0]
        flat, r = [at(p) for p in placed], radius * scale
        if max(math.dist(flat[0], p) for p in flat) + r < 4:  # too small to have a shape
            flat, r = flat[:1], 2.5
        if len(flat) == 1:
            x, y = flat[0]
            parts.append(f'<circle cx="{number(x)}" cy="{number(y)}" r="{number(max(r, 2.5))}" '
                         f'fill="{colour}" fill-opacity=".45" stroke="{colour}"/>')
        elif radius:
            parts.append(polyline(flat, colour, f"{max(2 * r, 2):.1f}", ' stroke-linecap="round" opacity=".6"'))
        else:
            shape = " ".join(f"{number(x)},{number(y)}" for x, y in hull(flat))
            parts.append(f'<polygon points="{shape}" fill="{colour}" fill-opacity=".35" stroke="{colour}" '
                         f'stroke-linejoin="round"/>')
    return document(WIDTH, HEIGHT, title, parts)
