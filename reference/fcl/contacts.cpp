#include "fcl/contacts.hpp"

#include <fcl/fcl.h>

#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>

#include "rivals/pairs.hpp"
#include "rivals/vector.hpp"

namespace atwood::fcl_adapter {
namespace {

using Vector = fcl::Vector3d;
using Geometry = std::shared_ptr<fcl::CollisionGeometryd>;
using Objects = std::vector<std::unique_ptr<fcl::CollisionObjectd>>;

Vector vector(const Real3& v) { return {v[0], v[1], v[2]}; }
std::array<Wide, 3> wide(const Vector& v) { return {v[0], v[1], v[2]}; }

fcl::Transform3d transform(const Real3& p, const Real4& q) {
  fcl::Transform3d at = fcl::Transform3d::Identity();
  at.linear() = fcl::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
  at.translation() = vector(p);
  return at;
}

struct Maker {
  const Body& body;
  Objects& made;

  void keep_at(Geometry geometry, const fcl::Transform3d& at) const {
    made.push_back(std::make_unique<fcl::CollisionObjectd>(std::move(geometry), at));
  }
  void keep(Geometry geometry) const {
    keep_at(std::move(geometry), transform(body.position_m, body.orientation_wxyz));
  }
  void operator()(const std::monostate&) const { throw std::invalid_argument("a body without a shape"); }
  void operator()(const Sphere& s) const { keep(std::make_shared<fcl::Sphered>(s.radius_m)); }
  void operator()(const Plane& s) const {
    const double n = rivals::length(s.normal);
    keep_at(std::make_shared<fcl::Halfspaced>(vector(s.normal) / n, s.offset_m / n), fcl::Transform3d::Identity());
  }
  void operator()(const Rectangle& s) const {
    keep(std::make_shared<fcl::Boxd>(2 * s.half_extents_m[0], 2 * s.half_extents_m[1], 0.0));
  }
  void operator()(const Box& s) const { keep(std::make_shared<fcl::Boxd>(Vector(2 * vector(s.half_extents_m)))); }
  void operator()(const Capsule& s) const { keep(std::make_shared<fcl::Capsuled>(s.radius_m, 2 * s.half_length_m)); }
  void operator()(const Cylinder& s) const { keep(std::make_shared<fcl::Cylinderd>(s.radius_m, 2 * s.half_length_m)); }
  void operator()(const Convex& s) const {
    auto vertices = std::make_shared<std::vector<Vector>>();
    for (const Real3& p : s.points_m) vertices->push_back(vector(p));
    const auto triangles = rivals::hull_of(s);
    auto faces = std::make_shared<std::vector<int>>();
    for (const auto& t : triangles) faces->insert(faces->end(), {3, t[0], t[1], t[2]});
    keep(std::make_shared<fcl::Convexd>(vertices, static_cast<int>(triangles.size()), faces));
  }
  void operator()(const Mesh& s) const {
    std::vector<Vector> vertices;
    for (const Real3& p : s.points_m) vertices.push_back(vector(p));
    std::vector<fcl::Triangle> triangles;
    for (const auto& t : s.triangles)
      triangles.emplace_back(static_cast<std::size_t>(t[0]), static_cast<std::size_t>(t[1]),
                             static_cast<std::size_t>(t[2]));
    auto model = std::make_shared<fcl::BVHModel<fcl::OBBRSSd>>();
    model->beginModel();
    model->addSubModel(vertices, triangles);
    model->endModel();
    keep(model);
  }
  void operator()(const Compound& s) const {
    for (const Compound::Part& part : s.boxes) {
      const fcl::Transform3d in_body = transform(part.position_body_m, part.orientation_wxyz);
      keep_at(std::make_shared<fcl::Boxd>(Vector(2 * vector(part.half_extents_m))),
              transform(body.position_m, body.orientation_wxyz) * in_body);
    }
  }
};

Objects make(const Body& body) {
  Objects made;
  std::visit(Maker{body, made}, body.shape);
  return made;
}

void ask(const Scene& scene, int i, int j, ContactAnswer& answer) {
  const Objects of_a = make(scene.bodies[static_cast<std::size_t>(i)]),
                of_b = make(scene.bodies[static_cast<std::size_t>(j)]);
  for (const auto& a : of_a)
    for (const auto& b : of_b) {
      const fcl::CollisionRequestd request(64, true);
      fcl::CollisionResultd result;
      fcl::collide(a.get(), b.get(), request, result);
      for (std::size_t k = 0; k < result.numContacts(); ++k) {
        const auto& c = result.getContact(k);
        // FCL reports contacts in the order of its tables of shapes: a mesh first; for spheres against triangles it
        // reports negative depths.
        const double sign = c.o1 == a->collisionGeometry().get() ? 1 : -1;
        answer.contacts.push_back({i, j, wide(c.pos), wide(sign * c.normal), std::fabs(c.penetration_depth)});
      }
    }
}

}  // namespace

ContactAnswer find_contacts(const Scene& scene, const ContactQuery& query) {
  return rivals::ask_pairs("fcl", scene, [&](int a, int b, ContactAnswer& answer) {
    if (query.swept) throw std::invalid_argument("its sweeps are not asked: they go by a list of times");
    ask(scene, a, b, answer);
  });
}

PairGap find_gap(const Scene& scene, int i, int j) {
  PairGap gap;
  const Body &one = scene.bodies.at(static_cast<std::size_t>(i)), &other = scene.bodies.at(static_cast<std::size_t>(j));
  // Its distance to a half-space ends in a null support function.
  if (std::holds_alternative<Plane>(one.shape) || std::holds_alternative<Plane>(other.shape)) {
    gap.gap_m = std::numeric_limits<double>::quiet_NaN();
    return gap;
  }
  gap.gap_m = HUGE_VAL;
  const Objects of_a = make(one), of_b = make(other);
  for (const auto& a : of_a)
    for (const auto& b : of_b) {
      const fcl::DistanceRequestd request(true);
      fcl::DistanceResultd result;
      const double d = fcl::distance(a.get(), b.get(), request, result);
      if (!(d < static_cast<double>(gap.gap_m))) continue;
      const Vector across = result.nearest_points[1] - result.nearest_points[0];
      gap.gap_m = d;
      gap.normal = wide(across / across.norm());
      gap.x_m = wide(0.5 * (result.nearest_points[0] + result.nearest_points[1]));
    }
  return gap;
}

}  // namespace atwood::fcl_adapter
