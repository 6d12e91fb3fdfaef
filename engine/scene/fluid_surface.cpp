#include "scene/fluid_surface.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "scene/fluid_walls.hpp"

namespace atwood {
namespace {

// Does a plane of a boundary that faces the fluid stand at this side (sign: of the normal) of a box?
bool walled(const Scene& scene, int axis, double sign, double at_m, double near_m) {
  for (const FluidBoundary& boundary : scene.fluid_boundaries) {
    const auto* plane = std::get_if<Plane>(&scene.bodies[static_cast<std::size_t>(boundary.body)].shape);
    if (plane == nullptr || plane->normal[static_cast<std::size_t>(axis)] != sign) continue;
    if (std::abs(sign * plane->offset_m - at_m) < near_m) return true;
  }
  return false;
}

void add_sides(const Scene& scene, const BoxRegion& box, double spacing, std::vector<Real3>& points) {
  const int d = scene.domain.dimensions;
  const auto cells = [&](int c) { return std::max(1.0, std::round((box.max_m[c] - box.min_m[c]) / spacing)); };
  for (int axis = 0; axis < d; ++axis) {
    const double length = box.max_m[axis] - box.min_m[axis], period = scene.domain.periodic_m[axis];
    if (period > 0 && std::abs(length - period) < spacing / 2) continue;
    const int b = (axis + 1) % d, c = d == 3 ? (axis + 2) % d : b;
    for (const bool lower : {true, false}) {
      const double at = lower ? box.min_m[axis] : box.max_m[axis];
      if (walled(scene, axis, lower ? 1 : -1, at, spacing / 2)) continue;
      const auto middle = [&](int of, int k) {
        return box.min_m[of] + (k + 0.5) * (box.max_m[of] - box.min_m[of]) / cells(of);
      };
      for (int i = 0; i < cells(b); ++i)
        for (int j = 0; j < (d == 3 ? cells(c) : 1); ++j) {
          Real3& x = points.emplace_back();
          x[axis] = at;
          x[b] = middle(b, i);
          if (d == 3) x[c] = middle(c, j);
        }
    }
  }
}

// A box without an extent is that of a scene made by hand.
bool is_known(const FluidRegion& region) {
  const auto* box = std::get_if<BoxRegion>(&region);
  return box != nullptr ? box->max_m[0] > box->min_m[0] : !std::holds_alternative<PointsRegion>(region);
}

void add_round(const Real3& centre, const Real3& axes, int d, double spacing, std::vector<Real3>& points) {
  using std::numbers::pi;
  if (d == 2) {
    const double n = std::max(3.0, std::round(2 * pi * std::sqrt(axes[0] * axes[1]) / spacing));
    for (int k = 0; k < n; ++k) {
      const double angle = 2 * pi * k / n;
      points.push_back({centre[0] + axes[0] * std::cos(angle), centre[1] + axes[1] * std::sin(angle), 0});
    }
    return;
  }
  const double radius = std::cbrt(axes[0] * axes[1] * axes[2]);
  const double n = std::max(4.0, std::round(4 * pi * radius * radius / (spacing * spacing)));
  for (int k = 0; k < n; ++k) {
    const double z = 1 - (2 * k + 1) / n, s = std::sqrt(1 - z * z), angle = k * pi * (3 - std::sqrt(5.0));
    points.push_back({centre[0] + axes[0] * s * std::cos(angle), centre[1] + axes[1] * s * std::sin(angle),
                      centre[2] + axes[2] * z});
  }
}

}  // namespace

std::vector<Real3> surface_points(const Scene& scene) {
  const Fluid& fluid = scene.fluids.front();
  const int d = scene.domain.dimensions;
  std::vector<Real3> points;
  if (const auto* box = std::get_if<BoxRegion>(&fluid.region); box != nullptr && is_known(fluid.region)) {
    add_sides(scene, *box, fluid.spacing_m, points);
  } else if (const auto* ball = std::get_if<BallRegion>(&fluid.region)) {
    add_round(ball->center_m, {ball->radius_m, ball->radius_m, ball->radius_m}, d, fluid.spacing_m, points);
  } else if (const auto* ellipsoid = std::get_if<EllipsoidRegion>(&fluid.region)) {
    add_round(ellipsoid->center_m, ellipsoid->semi_axes_m, d, fluid.spacing_m, points);
  }
  if (points.empty() && !is_known(fluid.region)) {
    for (int c = 0; c < d; ++c)
      if (scene.domain.periodic_m[c] == 0)
        throw std::invalid_argument(
            "the free surface of the fluid `" + fluid.name +
            "` is not known: its region is a file of points; expected a box, a circle, an ellipse, "
            "a ball or an ellipsoid");
  }
  std::erase_if(points, [&](const Real3& x) {
    return std::any_of(
        scene.fluid_boundaries.begin(), scene.fluid_boundaries.end(), [&](const FluidBoundary& boundary) {
          return depth_in_body_m(scene.bodies[static_cast<std::size_t>(boundary.body)], d, x) > -1e-9 * fluid.spacing_m;
        });
  });
  return points;
}

}  // namespace atwood
