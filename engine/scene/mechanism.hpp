// The start of the bodies that joints and ropes tie together, in __float128.
//
// Each joint that does not close a loop places its child: the pose and the velocity of the child follow from those of
// the parent and from the joint's coordinates and rates (scene/joint.hpp). The doubles of the scene are the data: those
// of bodies without a placing joint, those of placing joints, axes and frames (normalised in __float128). The rest
// follows.
#pragma once

#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "scene/quad_vectors.hpp"
#include "scene/scene.hpp"

namespace atwood {

struct BodyMotion {
  quad::Vector p_m{};                   // of the centre of mass, world
  quad::Quaternion q_wxyz{1, 0, 0, 0};  // unit, body to world
  quad::Vector v_m_per_s{};             // world
  quad::Vector w_rad_per_s{};           // body axes
};
// The first coordinate_count() coordinates and the first rate_count() rates of a joint.
struct JointMotion {
  quad::Quaternion q{};
  quad::Vector u{};
};
struct MechanismStart {
  std::vector<BodyMotion> bodies;   // in the order of Scene::bodies, all of them
  std::vector<JointMotion> joints;  // in the order of Scene::joints, all of them
};

// A mechanism that has no start: joints in a cycle without a closing joint, two joints that place one body, a body that
// is tied to itself, a loop whose projection does not converge.
struct MechanismError : std::runtime_error {
  MechanismError(const std::string& what, int joint_at, int rope_at = -1)
      : std::runtime_error(what), joint(joint_at), rope(rope_at) {}
  int joint, rope;  // indices into Scene::joints and Scene::ropes of what is to blame, or -1
};

// Of each body the joint that places it (an index into Scene::joints), or -1. Throws MechanismError.
std::vector<int> placing_joints(const Scene& scene);
// The joints that place bodies, each after the one that places its parent; otherwise in the scene's order. Throws
// MechanismError.
std::vector<int> joints_from_root(const Scene& scene);

// Poses and velocities of all bodies and the coordinates and rates of all joints at t = 0. With loops or ropes, the
// coordinates and rates of the scene are projected onto the constraints (scene/loop_projection.hpp), so that these hold
// to about 1e-30; a scene as reading it made it moves by the rounding of its doubles. Coordinates of a closing joint
// are computed from the poses, those of an angle next to the scene's. Throws MechanismError.
MechanismStart mechanism_start(const Scene& scene);

// ---- parts of the kinematics ---------------------------------------------------------------------------------------
// The motion of bodies that no joint places, from the scene's doubles; others are not set.
std::vector<BodyMotion> given_motions(const Scene& scene);
// Coordinates and rates as the scene gives them, a ball's quaternion normalised.
std::vector<JointMotion> given_joint_motions(const Scene& scene);
// The child's motion from its parent's.
BodyMotion placed_child(const Joint& joint, const JointMotion& motion, const BodyMotion& parent);
// Coordinates and rates of a joint from the motions of its bodies: where these violate the joint, its nearest ones.
// Angles are within half a turn of `near`, a quaternion has a scalar product >= 0 with it.
JointMotion joint_motion(const Joint& joint, const BodyMotion& parent, const BodyMotion& child,
                         const JointMotion& near);
// A body at the origin with the world's axes, at rest: the parent -1.
BodyMotion world_motion();
const BodyMotion& motion_of(const std::vector<BodyMotion>& bodies, int body, const BodyMotion& world);

}  // namespace atwood
