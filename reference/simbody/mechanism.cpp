#include "simbody/mechanism.hpp"

#include <algorithm>

#include "rivals/vector.hpp"
#include "rivals/world.hpp"

namespace atwood::simbody {
namespace {

using rivals::cross;
using rivals::Motion;
using rivals::operator+;
using rivals::operator-;
using rivals::operator*;
using rivals::Reaction;
using rivals::Wrench;
using SimTK::Constraint;
using SimTK::MobilizedBody;
using SimTK::Rotation;
using SimTK::Transform;
using SimTK::UnitVec3;

SimTK::Vec3 vec3(const Real3& v) { return SimTK::Vec3(v[0], v[1], v[2]); }
Real3 real3(const SimTK::Vec3& v) { return {v[0], v[1], v[2]}; }
Rotation rotation(const Real4& q) { return Rotation(SimTK::Quaternion(SimTK::Vec4(q[0], q[1], q[2], q[3]))); }

// The joint's frame in the parent and in the child.
struct Frames {
  Transform in_parent, in_child;
};
Frames frames_of(const Joint& joint) {
  Rotation in_child, in_parent;
  const Rotation turned = rotation(joint.frame_wxyz);
  if (joint.kind == JointKind::universal) {
    const UnitVec3 first(vec3(joint.axes_body[0]));
    in_parent = Rotation(first, SimTK::XAxis, turned * vec3(joint.axes_body[1]), SimTK::YAxis);
    in_child = ~turned * in_parent;
  } else {
    if (joint.kind == JointKind::hinge || joint.kind == JointKind::cylindrical)
      in_child = Rotation(UnitVec3(vec3(joint.axis_body)), SimTK::ZAxis);
    if (joint.kind == JointKind::slider) in_child = Rotation(UnitVec3(vec3(joint.axis_body)), SimTK::XAxis);
    in_parent = turned * in_child;
  }
  return {Transform(in_parent, vec3(joint.anchors_body_m[0])), Transform(in_child, vec3(joint.anchors_body_m[1]))};
}

double span(const Joint& joint) {
  const double lever = std::max(rivals::length(joint.anchors_body_m[0]), rivals::length(joint.anchors_body_m[1]));
  return lever > 0 ? lever : 1.0;
}

// A point of the parent's frame in the frame of Simbody's body, which is the ground for a fixed parent.
Transform base_of(const Scene& scene, int parent) {
  if (parent < 0 || !scene.bodies[static_cast<std::size_t>(parent)].fixed) return Transform();
  const Body& body = scene.bodies[static_cast<std::size_t>(parent)];
  return Transform(rotation(body.orientation_wxyz), vec3(body.position_m));
}

std::vector<Constraint> constraints_of(const Scene& scene, const Joint& joint, Mobilized& bodies,
                                       MobilizedBody& ground) {
  MobilizedBody& child = bodies[static_cast<std::size_t>(joint.child)];
  MobilizedBody& parent = joint.parent < 0 ? ground : bodies[static_cast<std::size_t>(joint.parent)];
  const Transform base = base_of(scene, joint.parent);
  const Rotation turned = base.R() * rotation(joint.frame_wxyz);
  const SimTK::Vec3 at_parent = base * vec3(joint.anchors_body_m[0]), at_child = vec3(joint.anchors_body_m[1]);
  const auto ball = [&] { return Constraint::Ball(parent, at_parent, child, at_child); };
  const auto on_line = [&](double offset) {
    return Constraint::PointOnLine(parent, UnitVec3(turned * vec3(joint.axis_body)), at_parent, child,
                                   at_child + offset * vec3(joint.axis_body));
  };
  switch (joint.kind) {
    case JointKind::fixed: return {Constraint::Weld(parent, Transform(turned, at_parent), child, Transform(at_child))};
    case JointKind::ball: return {ball()};
    case JointKind::hinge: return {ball(), on_line(span(joint))};
    case JointKind::slider: return {Constraint::ConstantOrientation(parent, turned, child, Rotation()), on_line(0)};
    case JointKind::cylindrical: return {on_line(-span(joint)), on_line(span(joint))};
    default:
      return {ball(), Constraint::ConstantAngle(parent, UnitVec3(base.R() * vec3(joint.axes_body[0])), child,
                                                UnitVec3(vec3(joint.axes_body[1])))};
  }
}

// Force and torque of a constraint on one of its bodies, about that body's centre of mass. Simbody's constraint forces
// have the opposite sign of applied ones.
Wrench wrench_on(const Constraint& constraint, SimTK::MobilizedBodyIndex body, const SimTK::State& state) {
  const SimTK::Vector_<SimTK::SpatialVec> forces = constraint.getConstrainedBodyForcesAsVector(state);
  for (SimTK::ConstrainedBodyIndex b(0); b < constraint.getNumConstrainedBodies(); ++b) {
    if (constraint.getMobilizedBodyFromConstrainedBody(b).getMobilizedBodyIndex() == body)
      return {real3(-forces[b][1]), real3(-forces[b][0])};
  }
  return {};
}

}  // namespace

std::string refused_mechanism(const Scene& scene) {
  for (const Joint& joint : scene.joints) {
    const std::string named = "; found it on the joint `" + joint.name + "`";
    if (joint.limits)
      return "Simbody's stops are springs (MobilityLinearStop); rigid stops belong to its experimental time stepper" +
             named;
    if (joint.closes_loop && joint.driven_rate) return "Simbody has no drive of a joint that closes a loop" + named;
  }
  for (const JointForce& force : scene.joint_forces) {
    const int j = std::visit([](const auto& f) { return f.joint; }, force);
    const Joint& joint = scene.joints[static_cast<std::size_t>(j)];
    if (joint.closes_loop)
      return "Simbody has no forces of a joint that closes a loop; found one on `" + joint.name + "`";
  }
  for (const Rope& rope : scene.ropes) {
    if (!rope.over.empty())
      return "Simbody has no rope of constant length over points; found `" + rope.name +
             "` (one between two points is a Rod)";
  }
  return "";
}

MobilizedBody add_placed_body(const Scene& scene, int j, const SimTK::Body& body, MobilizedBody parent) {
  const Joint& joint = scene.joints[static_cast<std::size_t>(j)];
  Frames frames = frames_of(joint);
  frames.in_parent = base_of(scene, joint.parent) * frames.in_parent;
  MobilizedBody child;
  switch (joint.kind) {
    case JointKind::fixed: return MobilizedBody::Weld(parent, frames.in_parent, body, frames.in_child);
    case JointKind::hinge: child = MobilizedBody::Pin(parent, frames.in_parent, body, frames.in_child); break;
    case JointKind::slider: child = MobilizedBody::Slider(parent, frames.in_parent, body, frames.in_child); break;
    case JointKind::cylindrical:
      child = MobilizedBody::Cylinder(parent, frames.in_parent, body, frames.in_child);
      break;
    case JointKind::universal: child = MobilizedBody::Universal(parent, frames.in_parent, body, frames.in_child); break;
    case JointKind::ball: child = MobilizedBody::Ball(parent, frames.in_parent, body, frames.in_child); break;
  }
  if (joint.driven_rate) SimTK::Motion::Steady(child, *joint.driven_rate);
  return child;
}

Closings add_closings(const Scene& scene, Mobilized& bodies) {
  Closings closings;
  closings.of_joint.resize(scene.joints.size());
  if (bodies.empty()) return closings;
  MobilizedBody ground = bodies[0].getMatterSubsystem().getGround();
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    if (scene.joints[j].closes_loop) closings.of_joint[j] = constraints_of(scene, scene.joints[j], bodies, ground);
  }
  for (const Rope& rope : scene.ropes) {
    Real3 ends[2];
    SimTK::Vec3 points[2];
    for (int k = 0; k < 2; ++k) {
      const Motion start = rivals::motion_at_start(scene, rope.bodies[k]);
      ends[k] = start.p_WB + rivals::to_world(start.q_WB, rope.points_body_m[k]);
      points[k] = base_of(scene, rope.bodies[k]) * vec3(rope.points_body_m[k]);
    }
    closings.of_rope.emplace_back(bodies[static_cast<std::size_t>(rope.bodies[0])], points[0],
                                  bodies[static_cast<std::size_t>(rope.bodies[1])], points[1],
                                  rivals::length(ends[1] - ends[0]));
  }
  return closings;
}

void add_springs(const Scene& scene, SimTK::GeneralForceSubsystem& forces, Mobilized& bodies) {
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    const Joint& joint = scene.joints[j];
    const bool ball = joint.kind == JointKind::ball;
    for (int k = 0; k < rate_count(joint.kind); ++k) {
      const rivals::PassiveForce passive = rivals::passive_force(scene, static_cast<int>(j), ball ? 0 : k);
      const MobilizedBody& child = bodies[static_cast<std::size_t>(joint.child)];
      if (passive.stiffness > 0 && !ball)
        SimTK::Force::MobilityLinearSpring(forces, child, k, passive.stiffness, passive.rest);
      if (passive.damping > 0) SimTK::Force::MobilityLinearDamper(forces, child, k, passive.damping);
    }
  }
}

void set_joint(const Joint& joint, const MobilizedBody& child, SimTK::State& state) {
  for (int k = 0; k < coordinate_count(joint.kind); ++k) child.setOneQ(state, k, joint.coordinates[k]);
  const Real3 u = joint.kind == JointKind::ball ? rivals::to_world(joint.coordinates, joint.rates) : joint.rates;
  for (int k = 0; k < rate_count(joint.kind); ++k) child.setOneU(state, k, u[k]);
}

rivals::JointState joint_of(const Joint& joint, const MobilizedBody& child, const SimTK::State& state) {
  rivals::JointState now;
  for (int k = 0; k < coordinate_count(joint.kind); ++k) now.q[k] = child.getOneQ(state, k);
  for (int k = 0; k < rate_count(joint.kind); ++k) now.u[k] = child.getOneU(state, k);
  if (joint.kind != JointKind::ball) return now;
  double norm = 0;
  for (const double q : now.q) norm += q * q;
  for (double& q : now.q) q /= std::sqrt(norm);
  now.u = rivals::to_body(now.q, now.u);
  return now;
}

std::vector<Reaction> reactions_of(const Scene& scene, const Mobilized& bodies, const Closings& closings,
                                   const std::vector<Motion>& motions, const std::vector<Wrench>& wrenches,
                                   const SimTK::State& state) {
  std::vector<Wrench> missing(scene.bodies.size());
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const Body& body = scene.bodies[i];
    if (body.fixed) continue;
    const SimTK::SpatialVec& a = bodies[i].getBodyAcceleration(state);
    const Real3 alpha = rivals::to_body(motions[i].q_WB, real3(a[0])), &w = motions[i].w_WB_B;
    const Real3 rate = rivals::times(body.inertia_kg_m2, alpha) + cross(w, rivals::times(body.inertia_kg_m2, w));
    missing[i].force_N = body.mass_kg * (real3(a[1]) - scene.gravity_m_per_s2);
    missing[i].torque_N_m = rivals::to_world(motions[i].q_WB, rate);
    const auto take = [&](const Wrench& acting) {
      missing[i].force_N = missing[i].force_N - acting.force_N;
      missing[i].torque_N_m = missing[i].torque_N_m - acting.torque_N_m;
    };
    if (!wrenches.empty()) take(wrenches[i]);
    const SimTK::MobilizedBodyIndex index = bodies[i].getMobilizedBodyIndex();
    for (const auto& constraints : closings.of_joint)
      for (const Constraint& constraint : constraints) take(wrench_on(constraint, index, state));
    for (const Constraint& rod : closings.of_rope) take(wrench_on(rod, index, state));
  }
  std::vector<Reaction> reactions(scene.joints.size());
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    const Joint& joint = scene.joints[j];
    if (!joint.closes_loop) continue;
    const auto i = static_cast<std::size_t>(joint.child);
    Wrench sum;
    for (const Constraint& constraint : closings.of_joint[j]) {
      const Wrench part = wrench_on(constraint, bodies[i].getMobilizedBodyIndex(), state);
      rivals::add(sum.force_N, part.force_N);
      rivals::add(sum.torque_N_m, part.torque_N_m);
    }
    const Real3 arm = rivals::to_world(motions[i].q_WB, joint.anchors_body_m[1]);
    reactions[j] = {sum.force_N, sum.torque_N_m - cross(arm, sum.force_N)};
  }
  return rivals::subtree_reactions(scene, motions, std::move(missing), std::move(reactions));
}

std::vector<RopeSample> ropes_of(const Closings& closings, const SimTK::State& state) {
  std::vector<RopeSample> samples;
  for (const Constraint::Rod& rod : closings.of_rope) {
    RopeSample sample;
    sample.tension_N = rod.getRodTension(state);
    samples.push_back(sample);
  }
  return samples;
}

}  // namespace atwood::simbody
