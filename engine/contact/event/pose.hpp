// Position, orientation and velocity of a rigid body at one instant.
#pragma once

#include "math/quat.hpp"
#include "math/vec3.hpp"

namespace atwood::event {

// A body's pose and its rate of change, in world axes: p [m] is the centre of mass, v [m/s] its velocity, w [rad/s] the
// angular velocity.
template <class S> struct Pose {
  Vec3<S> p, v, w;
  Vec3<S> axis[3] = {{S(1), S(0), S(0)}, {S(0), S(1), S(0)}, {S(0), S(0), S(1)}};  // the body's axes in the world
};

// R_WB v and R_WB^T v, the same direction in the axes of the world and of the body.
template <class S> inline Vec3<S> to_world(const Pose<S>& pose, const Vec3<S>& v_B) {
  return v_B.x * pose.axis[0] + v_B.y * pose.axis[1] + v_B.z * pose.axis[2];
}
template <class S> inline Vec3<S> to_body(const Pose<S>& pose, const Vec3<S>& v_W) {
  return {dot(pose.axis[0], v_W), dot(pose.axis[1], v_W), dot(pose.axis[2], v_W)};
}

}  // namespace atwood::event
