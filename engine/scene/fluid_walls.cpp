#include "scene/fluid_walls.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <stdexcept>

namespace atwood {
namespace {

constexpr double kBeyond = 4;  // how far planes extend beyond the fluids, over their largest extent

struct Extent {
  Real3 min_m{}, max_m{};
};

// Of all particles, with half a spacing around them.
Extent extent_of(const Scene& scene, std::size_t fluids) {
  Extent extent;
  extent.min_m.fill(std::numeric_limits<double>::infinity());
  extent.max_m.fill(-std::numeric_limits<double>::infinity());
  for (std::size_t f = 0; f < fluids; ++f)
    for (const Real3& x : scene.fluids[f].particles.position_m)
      for (std::size_t c = 0; c < 3; ++c) {
        extent.min_m[c] = std::min(extent.min_m[c], x[c] - scene.fluids[f].spacing_m / 2);
        extent.max_m[c] = std::max(extent.max_m[c], x[c] + scene.fluids[f].spacing_m / 2);
      }
  return extent;
}

Real3 lattice_corner(const Fluid& fluid, const Extent& particles) {
  if (const auto* box = std::get_if<BoxRegion>(&fluid.region)) return box->min_m;
  return particles.min_m;
}

// v by the quaternion or its conjugate.
Real3 turned(const Real4& q, double sign, const Real3& v) {
  const Real3 u{sign * q[1], sign * q[2], sign * q[3]};
  const auto cross = [](const Real3& a, const Real3& b) {
    return Real3{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  };
  const Real3 once = cross(u, v), twice = cross(u, once);
  return {v[0] + 2 * (q[0] * once[0] + twice[0]), v[1] + 2 * (q[0] * once[1] + twice[1]),
          v[2] + 2 * (q[0] * once[2] + twice[2])};
}
Real3 to_world(const Body& body, const Real3& x) {
  const Real3 turn = turned(body.orientation_wxyz, 1, x);
  return {turn[0] + body.position_m[0], turn[1] + body.position_m[1], turn[2] + body.position_m[2]};
}

}  // namespace

int normal_axis(const Plane& plane, int dimensions) {
  for (int axis = 0; axis < dimensions; ++axis)
    if (std::abs(plane.normal[axis]) == 1) return axis;
  return -1;
}

Real3 to_body(const Body& body, const Real3& x) {
  return turned(body.orientation_wxyz, -1,
                {x[0] - body.position_m[0], x[1] - body.position_m[1], x[2] - body.position_m[2]});
}

namespace {

// first, first + pitch, ... while below last.
struct Ticks {
  double first = 0, pitch = 1, last = 1;
  double count() const { return std::max(0.0, std::ceil((last - first) / pitch)); }  // to one, by round-off
};
std::vector<double> values_of(const Ticks& ticks) {
  std::vector<double> at;
  for (int i = 0; ticks.first + i * ticks.pitch < ticks.last; ++i) at.push_back(ticks.first + i * ticks.pitch);
  return at;
}

// The lattice of a plane. Along its normal the ticks are depths, in spacings.
struct PlaneLattice {
  int normal = 0;
  std::array<Ticks, 3> along{};
  double area = 1;  // of a point's square (in two dimensions its length) in the plane
};

PlaneLattice lattice_of(const Scene& scene, const Plane& plane, double max_depth) {
  const int d = scene.domain.dimensions, normal = normal_axis(plane, d);
  const double spacing = scene.fluids.front().spacing_m;
  const Extent all = extent_of(scene, scene.fluids.size()), first = extent_of(scene, 1);
  PlaneLattice lattice{normal};
  double widest = 0;
  for (int c = 0; c < d; ++c) widest = std::max(widest, all.max_m[c] - all.min_m[c]);
  for (int c = 0; c < d; ++c) {
    if (c == normal) {
      lattice.along[c] = {0, 1, max_depth / spacing};
    } else if (const double period = scene.domain.periodic_m[c]; period > 0) {
      const double pitch = period / std::max(1.0, std::round(period / spacing));
      lattice.along[c] = {pitch / 2, pitch, period};
      lattice.area *= pitch;
    } else {
      double low = all.min_m[c], high = all.max_m[c];
      for (const FluidBoundary& boundary : scene.fluid_boundaries)
        if (const auto* other = std::get_if<Plane>(&scene.bodies[boundary.body].shape);
            other && normal_axis(*other, d) == c) {
          low = std::min(low, other->offset_m * other->normal[c]);
          high = std::max(high, other->offset_m * other->normal[c]);
        }
      const double beyond = kBeyond * widest + max_depth;
      const double anchor = lattice_corner(scene.fluids.front(), first)[c];
      const double steps = std::ceil((anchor - (low - beyond)) / spacing);
      lattice.along[c] = {anchor + (0.5 - steps) * spacing, spacing, high + beyond};
      lattice.area *= spacing;
    }
  }
  return lattice;
}

// Returns the area of a point's square (in two dimensions its length) in the plane.
double fill_plane(const Scene& scene, const Body& body, const Plane& plane, double max_depth,
                  std::vector<Real3>& points) {
  const double spacing = scene.fluids.front().spacing_m;
  if (normal_axis(plane, scene.domain.dimensions) < 0)
    throw std::invalid_argument("the plane of the boundary `" + body.name +
                                "` is not perpendicular to a coordinate axis; walls of particles require it");
  const PlaneLattice lattice = lattice_of(scene, plane, max_depth);
  std::array<std::vector<double>, 3> at;
  for (int c = 0; c < 3; ++c) at[c] = values_of(lattice.along[c]);
  at[lattice.normal].clear();
  for (int layer = 0; layer * spacing < max_depth; ++layer)
    at[lattice.normal].push_back(plane.normal[lattice.normal] * (plane.offset_m - (layer + 0.5) * spacing));
  for (const double x : at[0])
    for (const double y : at[1])
      for (const double z : at[2]) points.push_back({x, y, z});
  return lattice.area;
}

double cells_along(double edge, double spacing) { return std::max(1.0, std::round(edge / spacing)); }

// Points in the body's axes.
void fill_box(const Box& box, int d, double spacing, std::vector<Real3>& points) {
  std::array<std::vector<double>, 3> at{std::vector<double>{0}, {0}, {0}};
  for (int c = 0; c < d; ++c) {
    const double edge = 2 * box.half_extents_m[c], cells = cells_along(edge, spacing);
    at[c].clear();
    for (int i = 0; i < cells; ++i) at[c].push_back((i + 0.5) * (edge / cells) - box.half_extents_m[c]);
  }
  for (const double x : at[0])
    for (const double y : at[1])
      for (const double z : at[2]) points.push_back({x, y, z});
}

Box around(const Sphere& ball, double spacing) {
  const double half = std::ceil(ball.radius_m / spacing) * spacing;
  return {{half, half, half}};
}

double depth_in_box(const Box& box, int d, const Real3& x) {
  double depth = std::numeric_limits<double>::infinity();
  for (int c = 0; c < d; ++c) depth = std::min(depth, box.half_extents_m[c] - std::abs(x[c]));
  return depth;
}

}  // namespace

double depth_in_body_m(const Body& body, int dimensions, const Real3& x) {
  if (const auto* plane = std::get_if<Plane>(&body.shape))
    return plane->offset_m - (plane->normal[0] * x[0] + plane->normal[1] * x[1] + plane->normal[2] * x[2]);
  const Real3 at = to_body(body, x);
  if (const auto* box = std::get_if<Box>(&body.shape)) return depth_in_box(*box, dimensions, at);
  if (const auto* ball = std::get_if<Sphere>(&body.shape))
    return ball->radius_m - std::sqrt(at[0] * at[0] + at[1] * at[1] + (dimensions == 3 ? at[2] * at[2] : 0));
  return -std::numeric_limits<double>::infinity();
}

namespace {

// Surface of a box or a ball, in two dimensions the circumference.
double surface_of(const Shape& shape, int d) {
  using std::numbers::pi;
  if (const auto* ball = std::get_if<Sphere>(&shape))
    return d == 2 ? 2 * pi * ball->radius_m : 4 * pi * ball->radius_m * ball->radius_m;
  const Real3& half = std::get<Box>(shape).half_extents_m;
  return d == 2 ? 4 * (half[0] + half[1]) : 8 * (half[0] * half[1] + half[1] * half[2] + half[2] * half[0]);
}

// Whether a point of boundary b is on or behind another one; a plane's point at its place on the surface.
bool covered(const Scene& scene, std::size_t b, Real3 world, double depth) {
  const Body& own = scene.bodies[scene.fluid_boundaries[b].body];
  if (const auto* plane = std::get_if<Plane>(&own.shape))
    for (std::size_t c = 0; c < 3; ++c) world[c] += depth * plane->normal[c];
  const double touching = -1e-9 * scene.fluids.front().spacing_m;
  for (std::size_t other = 0; other < scene.fluid_boundaries.size(); ++other)
    if (other != b &&
        depth_in_body_m(scene.bodies[scene.fluid_boundaries[other].body], scene.domain.dimensions, world) > touching)
      return true;
  return false;
}

}  // namespace

std::optional<WallCount> too_many_wall_points(const Scene& scene, double max_depth) {
  const int d = scene.domain.dimensions;
  double total = 0;
  for (std::size_t b = 0; b < scene.fluid_boundaries.size(); ++b) {
    const Body& body = scene.bodies[scene.fluid_boundaries[b].body];
    const double spacing = scene.fluids.front().spacing_m;
    double points = 1;
    if (const auto* plane = std::get_if<Plane>(&body.shape)) {
      if (normal_axis(*plane, d) < 0) continue;
      for (const Ticks& ticks : lattice_of(scene, *plane, max_depth).along) points *= ticks.count();
    } else {
      const auto* box = std::get_if<Box>(&body.shape);
      const auto* ball = std::get_if<Sphere>(&body.shape);
      if (!box && !ball) continue;
      const Box filled = box ? *box : around(*ball, spacing);
      for (int c = 0; c < d; ++c) points *= cells_along(2 * filled.half_extents_m[c], spacing);
    }
    total += points;
    if (total > kMaxWallPoints) {
      char figure[32];
      std::snprintf(figure, sizeof figure, total < 1e15 ? "%.0f" : "%.3g", total);
      return WallCount{b, "the wall of the boundary `" + body.name + "`" +
                              (b > 0 ? " and those before it have " : " has ") + figure + " points at a spacing of " +
                              describe(Value(spacing)) + " m; expected at most " + std::to_string(kMaxWallPoints) +
                              ": a coarser spacing, or fluids and planes that lie nearer to each other"};
    }
  }
  return std::nullopt;
}

std::vector<WallPoint> wall_points(const Scene& scene, double max_depth) {
  const int d = scene.domain.dimensions;
  const double spacing = scene.fluids.front().spacing_m;
  if (const auto beyond = too_many_wall_points(scene, max_depth)) throw std::invalid_argument(beyond->words);
  std::vector<WallPoint> walls;
  for (std::size_t b = 0; b < scene.fluid_boundaries.size(); ++b) {
    const Body& body = scene.bodies[scene.fluid_boundaries[b].body];
    std::vector<Real3> points;  // in the body's axes, except of planes
    const bool plane = std::holds_alternative<Plane>(body.shape);
    double area = 0;  // of each point at the surface
    if (plane) area = fill_plane(scene, body, std::get<Plane>(body.shape), max_depth, points);
    else if (const auto* box = std::get_if<Box>(&body.shape)) fill_box(*box, d, spacing, points);
    else if (const auto* ball = std::get_if<Sphere>(&body.shape)) fill_box(around(*ball, spacing), d, spacing, points);
    else
      throw std::invalid_argument("the boundary `" + body.name +
                                  "` is neither a plane nor a box nor a ball; walls of particles fill no other shape");
    const auto placed = [&](const Real3& x) { return plane ? x : to_world(body, x); };
    if (!plane) {
      int outer = 0;
      for (const Real3& x : points) {
        const double depth = depth_in_body_m(body, d, placed(x));
        outer += depth > 0 && depth < spacing;
      }
      area = surface_of(body.shape, d) / std::max(outer, 1);
    }
    for (const Real3& x : points) {
      const Real3 world = placed(x);
      const double depth = depth_in_body_m(body, d, world);
      if (!plane && !(depth > 0 && depth < max_depth)) continue;
      bool taken = false;
      for (std::size_t earlier = 0; earlier < b && !taken; ++earlier)
        taken = depth_in_body_m(scene.bodies[scene.fluid_boundaries[earlier].body], d, world) > 0;
      if (taken) continue;
      const bool surface = depth < spacing && !covered(scene, b, world, depth);
      walls.push_back({static_cast<int>(b), body.fixed ? world : x, surface ? area : 0});
    }
  }
  return walls;
}

}  // namespace atwood
