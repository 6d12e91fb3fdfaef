// What a playback page draws of a scene.
#include <algorithm>
#include <cmath>
#include <type_traits>

#include "playback_parts.hpp"
#include "scene/inertia.hpp"

namespace atwood {
namespace {

template <std::size_t n> void append_values(JsonText& json, const char* key, const std::array<double, n>& values) {
  json.key(key).begin_array();
  for (const double value : values) json.number(value);
  json.end_array();
}

void append_intervals(JsonText& json, const std::vector<Interval>& on_s) {
  json.key("on").begin_array();
  for (const Interval& on : on_s) json.begin_array().number(on.from_s).number(on.to_s).end_array();
  json.end_array();
}

void append_triangles(JsonText& json, const std::vector<Real3>& points, const std::vector<std::array<int, 3>>& faces) {
  json.key("points").begin_array();
  for (const Real3& p : points)
    for (const double x : p) json.number(x, 6);
  json.end_array().key("faces").begin_array();
  for (const auto& face : faces)
    for (const int corner : face) json.integer(corner);
  json.end_array();
}

struct ShapeWriter {
  JsonText& json;
  void operator()(const std::monostate&) const { json.member("kind", "point"); }
  void operator()(const Sphere& s) const { json.member("kind", "sphere").member_number("r", s.radius_m); }
  void operator()(const Plane& s) const {
    json.member("kind", "plane").member_number("offset", s.offset_m);
    append_values(json, "normal", s.normal);
  }
  void operator()(const Rectangle& s) const {
    json.member("kind", "box");
    append_values(json, "half", Real3{s.half_extents_m[0], s.half_extents_m[1], 0});
  }
  void operator()(const Box& s) const {
    json.member("kind", "box");
    append_values(json, "half", s.half_extents_m);
  }
  void operator()(const Capsule& s) const {
    json.member("kind", "capsule").member_number("r", s.radius_m).member_number("h", s.half_length_m);
  }
  void operator()(const Cylinder& s) const {
    json.member("kind", "cylinder").member_number("r", s.radius_m).member_number("h", s.half_length_m);
  }
  void operator()(const Convex& s) const {
    json.member("kind", "mesh");
    append_triangles(json, s.points_m, convex_hull(s.points_m));
  }
  void operator()(const Mesh& s) const {
    json.member("kind", "mesh");
    append_triangles(json, s.points_m, s.triangles);
  }
  void operator()(const Compound& s) const {
    json.member("kind", "compound").key("boxes").begin_array();
    for (const Compound::Part& part : s.boxes) {
      json.begin_object();
      append_values(json, "half", part.half_extents_m);
      append_values(json, "p", part.position_body_m);
      append_values(json, "q", part.orientation_wxyz);
      json.end_object();
    }
    json.end_array();
  }
};

void append_body(JsonText& json, const Body& body) {
  json.begin_object().member("name", body.name).key("fixed").boolean(body.fixed);
  if (body.release_s > 0) json.member_number("release", body.release_s);
  append_values(json, "p", body.position_m);
  append_values(json, "q", body.orientation_wxyz);
  json.key("shape").begin_object();
  std::visit(ShapeWriter{json}, body.shape);
  json.end_object().end_object();
}

void append_joint(JsonText& json, const Joint& joint) {
  constexpr const char* names[] = {"fixed", "hinge", "slider", "cylindrical", "universal", "ball"};
  json.begin_object().member("name", joint.name).member("kind", names[static_cast<std::size_t>(joint.kind)]);
  json.member_integer("a", joint.parent).member_integer("b", joint.child);
  append_values(json, "pa", joint.anchors_body_m[0]);
  append_values(json, "pb", joint.anchors_body_m[1]);
  if (joint.kind == JointKind::universal) {
    append_values(json, "axis_a", joint.axes_body[0]);
    append_values(json, "axis_b", joint.axes_body[1]);
  } else if (joint.kind != JointKind::fixed && joint.kind != JointKind::ball) {
    append_values(json, "axis_b", joint.axis_body);
  }
  json.end_object();
}

void append_rope(JsonText& json, const Rope& rope) {
  json.begin_object().member("name", rope.name).member_integer("a", rope.bodies[0]).member_integer("b", rope.bodies[1]);
  append_values(json, "pa", rope.points_body_m[0]);
  append_values(json, "pb", rope.points_body_m[1]);
  json.key("over").begin_array();
  for (const Pulley& pulley : rope.over) {
    json.begin_object().member_number("r", pulley.radius_m);
    append_values(json, "axle", pulley.axle_m);
    append_values(json, "axis", pulley.axis);
    json.end_object();
  }
  json.end_array().end_object();
}

// Forces with a place and a direction of their own. Others act through fields and have nothing that could be drawn.
struct ForceWriter {
  JsonText& json;
  template <class F> void operator()(const F&) const {}
  void operator()(const Thruster& f) const {
    json.begin_object().member("kind", "thruster").member_integer("a", f.body).member_number("size", f.thrust_N);
    append_values(json, "pa", f.point_body_m);
    append_values(json, "direction", f.direction_body);
    append_intervals(json, f.on_s);
    json.end_object();
  }
  void operator()(const PointForce& f) const {
    json.begin_object().member("kind", "point-force").member_integer("a", f.body);
    append_values(json, "pa", f.point_body_m);
    append_values(json, "force", f.force_N);
    append_intervals(json, f.on_s);
    json.end_object();
  }
  void operator()(const Drive& f) const {
    for (const int body : f.bodies) {
      json.begin_object().member("kind", "drive").member_integer("a", body);
      json.member_number("w", f.angular_frequency_rad_per_s).member_number("phase", f.phase_rad);
      append_values(json, "force", f.force_N);
      json.end_object();
    }
  }
  void operator()(const Spring& f) const {
    if (f.bodies.empty()) return;
    const auto point = [&f](std::size_t i) { return i < f.points_body_m.size() ? f.points_body_m[i] : Real3{}; };
    json.begin_object()
        .member("kind", "spring")
        .member_integer("a", f.bodies[0])
        .member_number("rest", f.rest_length_m);
    json.member_integer("b", f.bodies.size() > 1 ? f.bodies[1] : -1);
    append_values(json, "pa", point(0));
    append_values(json, "pb", f.bodies.size() > 1 ? point(1) : f.anchor_m);
    json.end_object();
  }
  void operator()(const Attractor& f) const {
    json.begin_object().member("kind", "attractor");
    append_values(json, "pa", f.center_m);
    json.end_object();
  }
};

}  // namespace

void append_played_scene(JsonText& json, const Scene& scene) {
  json.begin_object();
  append_values(json, "gravity", scene.gravity_m_per_s2);
  json.member_integer("dimensions", scene.fluids.empty() ? 3 : scene.domain.dimensions);
  json.key("bodies").begin_array();
  if (scene.problem.empty()) {
    for (const Body& body : scene.bodies) append_body(json, body);
  } else {  // a bare system of equations is one point
    Body point;
    point.name = scene.problem;
    append_body(json, point);
  }
  json.end_array().key("joints").begin_array();
  for (const Joint& joint : scene.joints) append_joint(json, joint);
  json.end_array().key("ropes").begin_array();
  for (const Rope& rope : scene.ropes) append_rope(json, rope);
  json.end_array().key("forces").begin_array();
  for (const Force& force : scene.forces) std::visit(ForceWriter{json}, force);
  json.end_array().end_object();
}

}  // namespace atwood
