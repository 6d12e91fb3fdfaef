// Constraints between bodies, as rows: what a joint that closes a loop asks of the poses and twists of its two bodies.
//
// A row is one scalar condition g(poses, t) = 0. Its rate is linear in the bodies' twists, its second derivative in
// their accelerations:
//   g'  = sum over both bodies of (force . v  + torque . w)  - rate
//   g'' = sum over both bodies of (force . v' + torque . w') + drift
// The multiplier of the row is the size of the wrench (force, torque) that the constraint exerts on each body. All
// vectors are in world axes, v is that of the centre of mass, and torques are about it.
#pragma once

#include <vector>

#include "math/quat.hpp"
#include "scene/joint.hpp"

namespace atwood {

// A body as constraints read it. The world is a body at the origin with the world's axes, at rest.
template <class S> struct TiedBody {
  Vec3<S> p_WB;
  Quat<S> q_WB;
  Vec3<S> v_WB, w_WB;  // w in world axes
};

template <class S> struct Wrench { Vec3<S> force, torque; };

template <class S> struct JointRow {
  Wrench<S> on[2];  // on the parent and on the child
  S value{};        // g: m, or the sine of an angle
  S rate{};         // what the twists' product with `on` has to be: 0 unless the motion is prescribed
  S drift{};        // of g'' at zero accelerations
};

// The conditions of one joint on the poses of its bodies.
//   point    direction . (x_child - x_parent) = 0, direction fixed in the world
//   slide    b . (x_child - x_parent) = offset + rate t, b fixed in the child
//   square   a . b = offset, a fixed in the parent, b in the child
//   turn     the child's angle about the axis b is offset + rate t
enum class ConditionKind : unsigned char { point, slide, square, turn };
template <class S> struct Condition {
  ConditionKind kind = ConditionKind::point;
  Vec3<S> a, b;  // unit; point: a in world axes
  S offset{}, rate{};
};

template <class S> struct JointConstraint {
  int parent = -1, child = 0;  // -1: the world
  Vec3<S> anchor[2];           // of parent and child, from each centre of mass, body axes
  Quat<S> frame;
  std::vector<Condition<S>> conditions;
};

// The conditions of a joint: 6 less its degrees of freedom, and one more where its motion is prescribed. The directions
// of `point` are the joint's axis at the start and two across it, given the parent's attitude there; so a mechanism in
// a plane has its redundant conditions in rows of their own.
template <class S> JointConstraint<S> joint_constraint(const Joint& joint, const Quat<S>& parent_attitude);

// The row of condition `i` at time t.
template <class S>
void constraint_row(const JointConstraint<S>& joint, int i, const TiedBody<S>& parent, const TiedBody<S>& child, S t_s,
                    JointRow<S>& row);

// A joint's coordinates and rates from the poses and twists of its bodies (scene/joint.hpp). Angles continue those in
// `q` to the nearest turn, a ball's quaternion keeps its sign. Of poses off the constraints: of the nearest rotation
// about the axis.
template <class S>
void coordinates_of(const Joint& joint, const TiedBody<S>& parent, const TiedBody<S>& child, S* q, S* u);

// Two unit vectors that with `axis`, a unit vector, form a right-handed orthonormal frame (axis, first, second).
template <class S> void directions_across(const Vec3<S>& axis, Vec3<S>& first, Vec3<S>& second);

}  // namespace atwood
