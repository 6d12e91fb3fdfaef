// The checks of one joint or rope that span its keys.
#include <algorithm>
#include <cmath>

#include "scene/joint_keys.hpp"
#include "scene/orientation.hpp"

namespace atwood {
namespace {

constexpr double kOrthogonal = 1e-9;

double dot(const Real3& a, const Real3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Real3 cross(const Real3& a, const Real3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Real3 minus(const Real3& a, const Real3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

// R v of a unit quaternion.
Real3 rotate(const Real4& q, const Real3& v) {
  const Real3 u{q[1], q[2], q[3]}, t = cross(u, v), c = cross(u, t);
  return {v[0] + 2 * (q[0] * t[0] + c[0]), v[1] + 2 * (q[0] * t[1] + c[1]), v[2] + 2 * (q[0] * t[2] + c[2])};
}

const Body& body_of(const Reading& r, int index) { return r.scene->bodies[static_cast<std::size_t>(index)]; }

SourceLocation location_of(const Value& table, const char* key) {
  const Value* found = table.find(key);
  return found ? found->location : table.location;
}

// ---- which keys a kind takes ----------------------------------------------------------------------------------------
struct KeyOfKinds {
  const char* key;
  std::vector<JointKind> kinds;
};

const std::vector<KeyOfKinds>& keys_of_kinds() {
  using enum JointKind;
  static const std::vector<KeyOfKinds> all = {
      {"axis_body", {hinge, slider, cylindrical}},
      {"axes_body", {universal}},
      {"angle_rad", {hinge, cylindrical, universal}},
      {"offset_m", {slider, cylindrical}},
      {"orientation_wxyz", {ball}},
      {"axis_angle_deg", {ball}},
      {"euler_xyz_deg", {ball}},
      {"rate_rad_per_s", {hinge, cylindrical, universal}},
      {"rate_m_per_s", {slider, cylindrical}},
      {"angular_velocity_body_rad_per_s", {ball}},
      {"limits_rad", {hinge}},
      {"limits_m", {slider}},
      {"stop_restitution", {hinge, slider}},
      {"driven_rate_rad_per_s", {hinge}},
      {"driven_rate_m_per_s", {slider}},
  };
  return all;
}

void check_keys_of_kind(Reading& r, const Value& table, const JointDraft& joint) {
  for (const auto& [name, kinds] : keys_of_kinds()) {
    const Value* given = table.find(name);
    if (!given || std::find(kinds.begin(), kinds.end(), joint.kind) != kinds.end()) continue;
    std::vector<std::string> words;
    for (const JointKind kind : kinds) words.emplace_back(to_word(kind));
    fail(r, given->location,
         std::string("`") + name + "` in " + r.where + " is given for the kind " + to_word(joint.kind) +
             "; expected it with " + listed(words) + " only");
  }
  const bool universal = joint.kind == JointKind::universal;
  const char* needed = universal ? "axes_body" : "axis_body";
  const bool takes = universal || (joint.kind != JointKind::fixed && joint.kind != JointKind::ball);
  if (takes && !table.find(needed))
    fail(r, table.location,
         std::string("missing key `") + needed + "` in " + r.where + "; expected " +
             (universal ? "the axis in the parent and the axis in the child" : "the axis in the child's axes"));
}

// The second axis at coordinate 0, in the parent's axes, is F a2.
void check_universal(Reading& r, const Value& table, const JointDraft& joint) {
  if (joint.kind != JointKind::universal) return;
  const double cosine = dot(joint.axes_body[0], rotate(joint.frame_wxyz, joint.axes_body[1]));
  if (std::abs(cosine) > kOrthogonal)
    fail(r, location_of(table, "axes_body"),
         "`axes_body` in " + r.where + " has axes with a cosine of " + describe(Value(cosine)) +
             " between them (the second turned by frame_wxyz); expected orthogonal axes (within 1e-9)");
}

// ---- the start ------------------------------------------------------------------------------------------------------
void check_count(Reading& r, const Value& table, const char* key, const std::vector<double>& values,
                 std::size_t expected) {
  if (values.empty() || values.size() == expected) return;
  fail(r, table.find(key)->location,
       std::string("`") + key + "` in " + r.where + (values.size() == 1 ? " is a number" : " is a list of two") +
           "; expected " + (expected == 1 ? "a number" : "a list of two, about the first and the second axis"));
}

// Of a joint that closes a loop the poses decide the start, except for the turns of an angle and for a driven
// coordinate.
void check_closing_start(Reading& r, const Value& table, const JointDraft& joint) {
  const bool driven = joint.driven_rate_rad_per_s || joint.driven_rate_m_per_s;
  for (const char* key : {"offset_m", "orientation_wxyz", "axis_angle_deg", "euler_xyz_deg", "rate_rad_per_s",
                          "rate_m_per_s", "angular_velocity_body_rad_per_s"}) {
    const Value* given = table.find(key);
    if (!given || !joint.closes_loop || (driven && std::string(key) == "offset_m")) continue;
    fail(r, given->location,
         std::string("`") + key + "` in " + r.where +
             " is given for a joint that closes a loop; expected none: it follows from the bodies");
  }
  for (const char* key : {"assemble", "hold"})
    if (const Value* given = table.find(key); given && !joint.closes_loop)
      fail(r, given->location,
           std::string("`") + key + "` in " + r.where + " is given without closes_loop; expected it with " +
               "closes_loop = true only");
}

void read_start(Reading& r, const Value& table, JointDraft& joint) {
  const bool two_angles = joint.kind == JointKind::universal;
  check_count(r, table, "angle_rad", joint.angle_rad, two_angles ? 2 : 1);
  check_count(r, table, "rate_rad_per_s", joint.rate_rad_per_s, two_angles ? 2 : 1);
  check_closing_start(r, table, joint);
  std::copy(joint.angle_rad.begin(), joint.angle_rad.end(), joint.coordinates.begin());
  std::copy(joint.rate_rad_per_s.begin(), joint.rate_rad_per_s.end(), joint.rates.begin());
  const std::size_t slide = joint.kind == JointKind::cylindrical ? 1 : 0;
  if (joint.offset_m) joint.coordinates[slide] = *joint.offset_m;
  if (joint.rate_m_per_s) joint.rates[slide] = *joint.rate_m_per_s;
  if (joint.kind == JointKind::ball) {
    require_one_orientation(r, table);
    joint.coordinates = joint.orientation.value_or(Real4{1, 0, 0, 0});
    joint.rates = joint.angular_velocity.value_or(Real3{});
  }
}

void read_resolved_start(Reading& r, const Value& table, JointDraft& joint) {
  const auto take = [&](const char* key, const std::vector<double>& from, int count, auto& out) {
    if (static_cast<int>(from.size()) != count)
      fail(r, location_of(table, key),
           std::string("`") + key + "` in " + r.where + " is a list of " + std::to_string(from.size()) + "; expected " +
               std::to_string(count) + " numbers for the kind " + to_word(joint.kind));
    std::copy(from.begin(), from.end(), out.begin());
  };
  take("coordinates", joint.resolved_coordinates, coordinate_count(joint.kind), joint.coordinates);
  take("rates", joint.resolved_rates, rate_count(joint.kind), joint.rates);
  if (joint.kind != JointKind::ball) return;
  double square = 0;
  for (const double x : joint.coordinates) square += x * x;
  if (!(std::abs(std::sqrt(square) - 1) <= 1e-9))
    fail(r, location_of(table, "coordinates"),
         "`coordinates` in " + r.where + " is not a unit quaternion; expected one");
}

// ---- limits, driven joints ---------------------------------------------------------------------------------------
void read_limits(Reading& r, const Value& table, JointDraft& joint) {
  const std::optional<Real2>& limits = joint.kind == JointKind::hinge ? joint.limits_rad : joint.limits_m;
  const char* key = joint.kind == JointKind::hinge ? "limits_rad" : "limits_m";
  if (!limits && joint.stop_restitution)
    fail(r, table.find("stop_restitution")->location,
         "`stop_restitution` in " + r.where + " is given without limits; expected it beside limits_rad or limits_m");
  if (!limits) return;
  if (!((*limits)[0] < (*limits)[1]))
    fail(r, table.find(key)->location,
         std::string("`") + key + "` in " + r.where + " is [" + describe(Value((*limits)[0])) + ", " +
             describe(Value((*limits)[1])) + "]; expected the smaller value first");
  joint.limits = JointLimits{(*limits)[0], (*limits)[1], joint.stop_restitution.value_or(0)};
}

void read_driven(Reading& r, const Value& table, JointDraft& joint) {
  joint.driven_rate = joint.kind == JointKind::hinge ? joint.driven_rate_rad_per_s : joint.driven_rate_m_per_s;
  if (!joint.driven_rate) return;
  if (joint.limits)
    fail(r, location_of(table, joint.kind == JointKind::hinge ? "limits_rad" : "limits_m"),
         "found limits in " + r.where + " beside a driven rate; expected one of the two: a driven joint does not stop");
  const char* rate = joint.kind == JointKind::hinge ? "rate_rad_per_s" : "rate_m_per_s";
  if (const Value* given = table.find(rate); given && joint.rates[0] != *joint.driven_rate)
    fail(r, given->location,
         std::string("`") + rate + "` in " + r.where + " is " + describe(*given) + " beside a driven rate of " +
             describe(Value(*joint.driven_rate)) + "; expected only the driven rate");
  joint.rates[0] = *joint.driven_rate;
}

void check_ends(Reading& r, const Value& table, const JointDraft& joint) {
  const Value& bodies = *table.find("bodies");
  const SourceLocation child_at = bodies.list() ? (*bodies.list())[1].location : bodies.location;
  if (joint.parent == joint.child)
    fail(r, child_at,
         "`bodies` in " + r.where + " names `" + body_of(r, joint.child).name + "` twice; expected two bodies");
  if (body_of(r, joint.child).fixed)
    fail(r, child_at,
         "the child `" + body_of(r, joint.child).name + "` of " + r.where +
             " is fixed; expected a body that moves (a fixed body can be the parent)");
  for (const int body : {joint.parent, joint.child})
    if (body >= 0 && body_of(r, body).release_s > 0)
      fail(r, bodies.location,
           "the body `" + body_of(r, body).name + "` of " + r.where +
               " has a release_s; expected a body that moves from the start");
}

}  // namespace

void finish_joint(Reading& r, const Value& table, JointDraft& joint) {
  check_keys_of_kind(r, table, joint);
  check_universal(r, table, joint);
  check_ends(r, table, joint);
  if (r.form == Form::file) read_start(r, table, joint);
  else read_resolved_start(r, table, joint);
  read_limits(r, table, joint);
  read_driven(r, table, joint);
}

// ---- ropes -------------------------------------------------------------------------------------------------------
namespace {

// The side on which the rope bends around a pulley: the axis of the turn from the way to the axle to the way on from
// it.
void choose_axes(Reading& r, const Value& table, Rope& rope) {
  const auto end = [&](std::size_t i) {
    const Body& body = body_of(r, rope.bodies[i]);
    const Real3 turned = rotate(body.orientation_wxyz, rope.points_body_m[i]);
    return Real3{body.position_m[0] + turned[0], body.position_m[1] + turned[1], body.position_m[2] + turned[2]};
  };
  for (std::size_t k = 0; k < rope.over.size(); ++k) {
    Pulley& pulley = rope.over[k];
    if (pulley.axis != Real3{}) continue;
    pulley.axis = {0, 0, 1};
    if (pulley.radius_m == 0) continue;
    const Real3 before = k == 0 ? end(0) : rope.over[k - 1].axle_m;
    const Real3 after = k + 1 == rope.over.size() ? end(1) : rope.over[k + 1].axle_m;
    const Real3 in = minus(pulley.axle_m, before), out = minus(after, pulley.axle_m), bend = cross(in, out);
    const double sine = std::sqrt(dot(bend, bend) / (dot(in, in) * dot(out, out)));
    if (!(sine > 1e-6))
      fail(
          r, table.find("over_m")->location,
          "the side of pulley " + std::to_string(k) + " of " + r.where +
              " is undetermined: the rope passes straight over its axle; expected `axis`, a unit vector: the rope runs "
              "on the side where axis x (point - axle) points along it");
    for (std::size_t i = 0; i < 3; ++i) pulley.axis[i] = bend[i] / std::sqrt(dot(bend, bend)) + 0.0;
  }
}

}  // namespace

void finish_rope(Reading& r, const Value& table, Rope& rope) {
  const Value& bodies = *table.find("bodies");
  if (rope.bodies[0] == rope.bodies[1])
    fail(r, bodies.location, "`bodies` in " + r.where + " names one body twice; expected two bodies");
  if (body_of(r, rope.bodies[0]).fixed && body_of(r, rope.bodies[1]).fixed)
    fail(r, bodies.location, "both bodies of " + r.where + " are fixed; expected one that moves");
  for (std::size_t i = 0; i < 2; ++i) {
    const Body& body = body_of(r, rope.bodies[i]);
    if (body.release_s > 0)
      fail(
          r, bodies.location,
          "the body `" + body.name + "` of " + r.where + " has a release_s; expected a body that moves from the start");
    if (!body.fixed && !rotates(body) && rope.points_body_m[i] != Real3{})
      fail(r, location_of(table, "points_body_m"),
           "`points_body_m` in " + r.where + " holds the point mass `" + body.name +
               "` beside its centre; expected [0, 0, 0], or a shape or `inertia_kg_m2` for the body");
  }
  for (std::size_t k = 0; k < rope.over.size(); ++k)
    if (rope.over[k].radius_m == 0 && rope.over[k].inertia_kg_m2 > 0)
      fail(r, location_of(table, "over_m"),
           "pulley " + std::to_string(k) + " of " + r.where +
               " has an inertia and no radius; expected a radius above 0: the rope turns it");
  if (r.form == Form::file) choose_axes(r, table, rope);
}

}  // namespace atwood
