#include "libccd/contacts.hpp"

#include <ccd/ccd.h>

#include <algorithm>
#include <stdexcept>

#include "rivals/pairs.hpp"
#include "rivals/vector.hpp"

namespace atwood::libccd {
namespace {

using rivals::operator+;
using rivals::operator*;

struct Object {
  Shape shape;
  Real3 p_W{};
  Real33 r_WB{};
};

// Support function: the point furthest along n, in body axes.
struct Support {
  Real3 n;
  static double side(double along, double h) { return along >= 0 ? h : -h; }
  Real3 round(double radius) const {
    const double length = rivals::length(n);
    return length > 0 ? (radius / length) * n : Real3{radius, 0, 0};
  }
  Real3 operator()(const std::monostate&) const { return {}; }
  Real3 operator()(const Plane&) const { return {}; }
  Real3 operator()(const Mesh&) const { return {}; }
  Real3 operator()(const Compound&) const { return {}; }
  Real3 operator()(const Sphere& s) const { return round(s.radius_m); }
  Real3 operator()(const Rectangle& s) const {
    return {side(n[0], s.half_extents_m[0]), side(n[1], s.half_extents_m[1]), 0};
  }
  Real3 operator()(const Box& s) const {
    const Real3& h = s.half_extents_m;
    return {side(n[0], h[0]), side(n[1], h[1]), side(n[2], h[2])};
  }
  Real3 operator()(const Capsule& s) const { return round(s.radius_m) + Real3{0, 0, side(n[2], s.half_length_m)}; }
  Real3 operator()(const Cylinder& s) const {
    const double across = std::hypot(n[0], n[1]);
    const double r = across > 0 ? s.radius_m / across : 0;
    return {r * n[0], r * n[1], side(n[2], s.half_length_m)};
  }
  Real3 operator()(const Convex& s) const {
    return *std::max_element(s.points_m.begin(), s.points_m.end(),
                             [&](const Real3& a, const Real3& b) { return rivals::dot(a, n) < rivals::dot(b, n); });
  }
};

void support(const void* object, const ccd_vec3_t* direction, ccd_vec3_t* point) {
  const auto& o = *static_cast<const Object*>(object);
  const Real3 n = rivals::transposed_times(o.r_WB, {direction->v[0], direction->v[1], direction->v[2]});
  const Real3 x = o.p_W + rivals::times(o.r_WB, std::visit(Support{n}, o.shape));
  ccdVec3Set(point, x[0], x[1], x[2]);
}

std::vector<Object> objects(const Body& body) {
  if (std::holds_alternative<Plane>(body.shape)) throw std::invalid_argument("no planes, only bounded convex shapes");
  if (std::holds_alternative<Mesh>(body.shape)) throw std::invalid_argument("no meshes, only bounded convex shapes");
  const Real33 r = rivals::matrix_of(body.orientation_wxyz);
  const auto* compound = std::get_if<Compound>(&body.shape);
  if (!compound) return {{body.shape, body.position_m, r}};
  std::vector<Object> boxes;
  for (const Compound::Part& part : compound->boxes) {
    const Real33 inner = rivals::matrix_of(part.orientation_wxyz);
    Real33 both{};
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j)
        for (std::size_t k = 0; k < 3; ++k) both[3 * i + j] += r[3 * i + k] * inner[3 * k + j];
    boxes.push_back({Box{part.half_extents_m}, body.position_m + rivals::times(r, part.position_body_m), both});
  }
  return boxes;
}

void ask(const Scene& scene, int i, int j, ContactAnswer& answer) {
  ccd_t ccd;
  CCD_INIT(&ccd);
  ccd.support1 = ccd.support2 = support;
  ccd.max_iterations = 1000;
  for (const Object& a : objects(scene.bodies[static_cast<std::size_t>(i)]))
    for (const Object& b : objects(scene.bodies[static_cast<std::size_t>(j)])) {
      ccd_real_t depth = 0;
      ccd_vec3_t direction, point;
      const int result = ccdGJKPenetration(&a, &b, &ccd, &depth, &direction, &point);
      if (result == -2) throw std::runtime_error("libccd: out of memory");
      if (result != 0) continue;
      const auto wide = [](const ccd_vec3_t& v) { return std::array<Wide, 3>{v.v[0], v.v[1], v.v[2]}; };
      answer.contacts.push_back({i, j, wide(point), wide(direction), depth});
    }
}

}  // namespace

ContactAnswer find_contacts(const Scene& scene, const ContactQuery& query) {
  return rivals::ask_pairs("libccd", scene, [&](int a, int b, ContactAnswer& answer) {
    if (query.swept) throw std::invalid_argument("no sweeps in time");
    ask(scene, a, b, answer);
  });
}

}  // namespace atwood::libccd
