#include "scene/bounding_radius.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace atwood {
namespace {

double hypot3(const Real3& v) { return std::hypot(v[0], v[1], v[2]); }

double farthest(const std::vector<Real3>& points) {
  double radius = 0;
  for (const Real3& point : points) radius = std::max(radius, hypot3(point));
  return radius;
}

struct BoundingRadius {
  double operator()(const std::monostate&) const { return 0; }
  double operator()(const Sphere& s) const { return s.radius_m; }
  double operator()(const Plane&) const { return std::numeric_limits<double>::infinity(); }
  double operator()(const Rectangle& s) const { return std::hypot(s.half_extents_m[0], s.half_extents_m[1]); }
  double operator()(const Box& s) const { return hypot3(s.half_extents_m); }
  double operator()(const Capsule& s) const { return s.radius_m + s.half_length_m; }
  double operator()(const Cylinder& s) const { return std::hypot(s.radius_m, s.half_length_m); }
  double operator()(const Convex& s) const { return farthest(s.points_m); }
  double operator()(const Mesh& s) const { return farthest(s.points_m); }
  double operator()(const Compound& s) const {
    double radius = 0;
    for (const auto& part : s.boxes)
      radius = std::max(radius, hypot3(part.position_body_m) + hypot3(part.half_extents_m));
    return radius;
  }
};

}  // namespace

double bounding_radius_m(const Shape& shape) { return std::visit(BoundingRadius{}, shape); }

}  // namespace atwood
