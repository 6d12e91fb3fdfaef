// Joints and ropes as they are simulated: what ties which bodies together, and how a mechanism starts. Plain data, SI
// units.
//
// Notation: R_parent and R_child turn a body's axes into world axes; F is the joint's frame (frame_wxyz); exp(a q) is
// the rotation by q about the unit vector a. The world stands for a body at the origin with the world's axes, at rest.
//
//   kind         orientation                               child's anchor - parent's   coordinates q        rates u
//   fixed        R_child = R_parent F                      0                           none                 none
//   hinge        R_child = R_parent F exp(axis q0)         0                           angle                q0'
//   slider       R_child = R_parent F                      R_child axis q0             offset               q0'
//   cylindrical  R_child = R_parent F exp(axis q0)         R_child axis q1             angle, offset        q0', q1'
//   universal    R_child = R_parent exp(a1 q0) F exp(a2 q1)  0                         angles about a1, a2  q0', q1'
//   ball         R_child = R_parent F Q(q)                 0                           quaternion (w, x, y, z)  w_rel
//
// w_rel of a ball is the body rate of the child relative to the parent in the child's axes: w_child - R_child^T
// w_parent, w_parent in world axes.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "scene/interval.hpp"

namespace atwood {

enum class JointKind { fixed, hinge, slider, cylindrical, universal, ball };

// How many coordinates and rates a joint of this kind has: 0 and 0, 1 and 1, 2 and 2, or 4 and 3 (ball).
constexpr int coordinate_count(JointKind kind) {
  switch (kind) {
    case JointKind::fixed: return 0;
    case JointKind::hinge:
    case JointKind::slider: return 1;
    case JointKind::cylindrical:
    case JointKind::universal: return 2;
    case JointKind::ball: return 4;
  }
  return 0;
}
constexpr int rate_count(JointKind kind) { return kind == JointKind::ball ? 3 : coordinate_count(kind); }

// An interval of a joint's coordinate that it cannot leave (hinge [rad], slider [m]), and what a stop gives back.
struct JointLimits {
  double lower = 0, upper = 0;
  double restitution = 0;  // of the coordinate's rate at a stop, in [0, 1]
};

struct Joint {
  std::string name;
  JointKind kind = JointKind::hinge;
  int parent = -1;                                        // index into Scene::bodies; -1: the world
  int child = 0;                                          // index into Scene::bodies, not fixed
  std::array<std::array<double, 3>, 2> anchors_body_m{};  // of parent and child, from each centre of mass, body axes
  std::array<double, 3> axis_body{};  // unit; hinge, slider, cylindrical: in the child's axes (F's axes are the same)
  std::array<std::array<double, 3>, 2> axes_body{};  // unit; universal: a1 in the parent's axes, a2 in the child's
  std::array<double, 4> frame_wxyz{1, 0, 0, 0};

  // The start. Of a loop: after its projection, so that the constraints hold to round-off. A joint that closes a loop
  // has the coordinates that the poses of its bodies give it.
  std::array<double, 4> coordinates{};  // the first coordinate_count() of them
  std::array<double, 3> rates{};        // the first rate_count() of them

  std::optional<JointLimits> limits;  // hinge, slider
  // Prescribed motion of a hinge or slider: its coordinate is the start's plus t times this rate.
  std::optional<double> driven_rate;

  // Places no body: the loop that it closes is a constraint on the tree of the other joints.
  bool closes_loop = false;
  bool assemble = false;  // the start's gap may be of any size
  std::vector<int> hold;  // indices into Scene::joints: their coordinates stay as given in the projection of the start
};

// A pulley turns about a fixed axle without slip of the rope. Along the rope from its first body to its last, the rope
// runs over the side on which axis x (point - axle) points along the rope, so that the rope's motion from the first
// body to the last turns the pulley by positive angles about the axis.
struct Pulley {
  std::array<double, 3> axle_m{};       // a point of the axle, in the plane of the rope
  std::array<double, 3> axis{0, 0, 1};  // unit, orthogonal to the plane of the rope
  double radius_m = 0;                  // >= 0; 0: a fixed frictionless point
  double inertia_kg_m2 = 0;             // >= 0, about the axle
  double angle_rad = 0;                 // at t = 0
};

// An inextensible rope from a point of one body to a point of another, over fixed pulleys; its length stays as it is at
// the start (equality). A tension below zero ends a run: the rope would be slack.
struct Rope {
  std::string name;
  std::array<int, 2> bodies{};                           // indices into Scene::bodies
  std::array<std::array<double, 3>, 2> points_body_m{};  // from each centre of mass, body axes
  std::vector<Pulley> over;                              // in order from the first body to the last
};

// ---- forces along a joint's first coordinate (hinge, slider; cylindrical and universal: `coordinate` 0 or 1)
// ----------
struct JointSpring {  // -stiffness (q - rest) - damping u; a ball takes damping alone, on its rates
  int joint = 0;
  int coordinate = 0;
  double stiffness = 0;  // N m/rad or N/m, >= 0
  double rest = 0;       // rad or m
  double damping = 0;    // N m s/rad or N s/m, >= 0
};
struct JointTorque {  // torque cos(angular_frequency t + phase), while on; always on where on_s is empty
  int joint = 0;
  int coordinate = 0;
  double torque = 0;  // N m or N
  double angular_frequency_rad_per_s = 0, phase_rad = 0;
  std::vector<Interval> on_s;
};
using JointForce = std::variant<JointSpring, JointTorque>;

}  // namespace atwood
