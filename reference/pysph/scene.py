"""The scene of a request as PySPH needs it: one fluid, its walls as particles, and what it has that PySPH has not.

Points of a wall stand as `engine/scene/fluid_walls.hpp` says: layers at the depths (l + 1/2) D below a plane, l D < reach.
"""
import math

import numpy

from outcome import Refusal


class Fluid:
    """The scene's fluid: its law, its particles as arrays of n rows, its walls."""

    def __init__(self, scene):
        refuse(scene)
        fluid, domain, particles = scene["fluids"][0], scene["domain"], scene["fluids"][0]["particles"]
        self.name, self.dimensions, self.spacing = fluid["name"], domain["dimensions"], fluid["spacing_m"]
        self.rho0, self.c = fluid["density_kg_per_m3"], fluid["sound_speed_m_per_s"]
        self.tait = fluid.get("equation_of_state", "linear") == "tait"
        self.gamma = fluid.get("tait_exponent", 7.0) if self.tait else 1.0
        self.nu = fluid.get("viscosity_m2_per_s", 0.0)
        self.gravity = [float(g) for g in scene["gravity_m_per_s2"]]
        self.period = numpy.array((list(domain.get("periodic_m", [])) + [0, 0, 0])[:3], float)
        self.x = padded(particles["position_m"], None)
        self.u = padded(particles["velocity_m_per_s"], len(self.x))
        self.mass, self.rho, self.temperature = (numpy.broadcast_to(numpy.asarray(particles[key], float), len(self.x))
                                                 for key in ("mass_kg", "density_kg_per_m3", "temperature_K"))
        self.boundaries = [Boundary(each, scene) for each in scene.get("fluid_boundaries", [])]
        self.corner = box_corner(fluid, self.x, self.spacing)
        self.solids = sorted({boundary.array for boundary in self.boundaries})
        self.has_free_surface = any(not self.closed(axis) for axis in range(self.dimensions))

    def closed(self, axis):
        """Whether the fluid has no end along an axis: it is periodic, or lies between two planes that it fills."""
        if self.period[axis] > 0:
            return True
        ends = {boundary.sign: boundary.at for boundary in self.boundaries if boundary.axis == axis}
        low, high = self.x[:, axis].min(), self.x[:, axis].max()
        return len(ends) == 2 and low - ends[1] < self.spacing and ends[-1] - high < self.spacing

    def pressure(self, rho):
        """[Pa], of the scene's equation of state."""
        return self.rho0 * self.c**2 / self.gamma * ((rho / self.rho0)**self.gamma - 1)


class Boundary:
    def __init__(self, boundary, scene):
        body = next(each for each in scene["bodies"] if each["name"] == boundary["body"])
        plane = body["shape"]["plane"]
        self.axis = next(axis for axis in range(3) if abs(plane["normal"][axis]) == 1)
        self.sign = int(plane["normal"][self.axis])  # of the normal, into the fluid
        self.at = self.sign * plane["offset_m"]      # the plane's coordinate along its axis
        self.velocity = [float(v) for v in body["velocity_m_per_s"]]
        self.array = "free_slip" if boundary.get("slip", "no-slip") == "free-slip" else "no_slip"

    def depth(self, x):
        return self.sign * (self.at - x[:, self.axis])


def padded(vectors, count):
    """Rows of three numbers; a plain 0 stands for vectors that all are 0."""
    if not isinstance(vectors, list):
        return numpy.zeros((count, 3))
    rows = numpy.array(vectors, float)
    return numpy.hstack([rows, numpy.zeros((len(rows), 3 - rows.shape[1]))])


def box_corner(fluid, x, spacing):
    box = fluid["region"].get("box") if isinstance(fluid.get("region"), dict) else None
    return numpy.array((list(box["min_m"]) + [0])[:3], float) if box else x.min(axis=0) - spacing / 2


def refuse(scene):
    fluids = scene.get("fluids", [])
    if len(fluids) != 1:
        raise Refusal(f"this adapter supports exactly one fluid; the scene has {len(fluids) or 'none'}")
    fluid = fluids[0]
    if fluid.get("heat_capacity_J_per_kg_K", 0) > 0:
        raise Refusal("PySPH's schemes have no temperature")
    if fluid.get("source"):
        raise Refusal("PySPH's schemes have no body acceleration that depends on the place")
    for body in scene.get("bodies", []):
        if not body["fixed"]:
            raise Refusal(f"PySPH's schemes move no rigid bodies: `{body['name']}`")
        if any(body["angular_velocity_body_rad_per_s"]):
            raise Refusal(f"this adapter supports walls that slide, not walls that rotate: `{body['name']}`")
    for boundary in scene.get("fluid_boundaries", []):
        body = next(each for each in scene["bodies"] if each["name"] == boundary["body"])
        normal = body.get("shape", {}).get("plane", {}).get("normal", [])
        if [abs(n) for n in normal].count(1) != 1:
            raise Refusal(f"this adapter supports only planes perpendicular to an axis as walls: `{body['name']}` is not")


def ticks(first, pitch, last):
    """first, first + pitch, ... while below last."""
    at = first + pitch * numpy.arange(max(0, math.ceil((last - first) / pitch) + 1))
    return at[at < last]


def wall_points(fluid, reach):
    """(boundary, points as rows of three) of every boundary; a point behind an earlier boundary is that one's."""
    walls, d, spacing = [], fluid.dimensions, fluid.spacing
    low, high = fluid.x.min(axis=0) - spacing / 2, fluid.x.max(axis=0) + spacing / 2
    beyond = 4 * (high - low)[:d].max() + reach  # as engine/scene/fluid_walls.cpp
    for n, boundary in enumerate(fluid.boundaries):
        at = [numpy.zeros(1)] * 3
        for axis in range(d):
            if axis == boundary.axis:
                layers = numpy.arange(math.ceil(reach / spacing))
                at[axis] = boundary.at - boundary.sign * (layers[layers * spacing < reach] + 0.5) * spacing
            elif fluid.period[axis] > 0:
                pitch = fluid.period[axis] / max(1, round(fluid.period[axis] / spacing))
                at[axis] = ticks(pitch / 2, pitch, fluid.period[axis])
            else:
                ends = [low[axis], high[axis]] + [other.at for other in fluid.boundaries if other.axis == axis]
                steps = math.ceil((fluid.corner[axis] - (min(ends) - beyond)) / spacing)
                at[axis] = ticks(fluid.corner[axis] + (0.5 - steps) * spacing, spacing, max(ends) + beyond)
        points = numpy.stack(numpy.meshgrid(*at, indexing="ij"), axis=-1).reshape(-1, 3)
        for earlier in fluid.boundaries[:n]:
            points = points[earlier.depth(points) <= 0]
        walls.append((boundary, points))
    return walls


def density_behind(fluid, points):
    """Of each point of a wall: that of the nearest particle, with the weight of the fluid between them."""
    rho = numpy.empty(len(points))
    for first in range(0, len(points), 256):
        apart = points[first:first + 256, None, :] - fluid.x[None, :, :]
        period = numpy.where(fluid.period > 0, fluid.period, 1)
        apart -= numpy.where(fluid.period > 0, fluid.period * numpy.round(apart / period), 0)
        near = (apart**2).sum(axis=2).argmin(axis=1)
        over = apart[numpy.arange(len(near)), near] @ numpy.array(fluid.gravity)
        rho[first:first + 256] = fluid.rho[near] * (1 + over / fluid.c**2)
    return rho
