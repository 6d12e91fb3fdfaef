// Joints of a scene in DART's terms. Conventions of DART 6.12:
//   - a tree of joints is a Skeleton; a joint's frame is [F, parent's anchor] in the parent and [1, child's anchor] in
//     the child, of a universal joint [1, parent's anchor] and [F^T, child's anchor], so that its axes are a1 and F a2;
//   - the coordinates of a ball are the logarithm of its rotation, its rates in the child's axes;
//   - joint springs and dampers are DART's own, implicit over the step; motors are generalised forces, evaluated by the
//     adapter at the beginning of a step; a prescribed rate is an actuator of velocity;
//   - closing joints are constraints of velocity: ball and fixed are DART's own, hinge is two balls on its axis. They
//     start from the poses, and their error reduction has no effect, so that gaps grow;
//   - stops are constraints of velocity, without restitution;
//   - reactions of trees come from DART's forward dynamics at the present state by Newton's and Euler's equations of
//     each subtree. With closing joints, contacts or at a stop they are not reported: constraints hide their impulses.
#pragma once

#include <string>
#include <vector>

#include "protocol/method.hpp"
#include "rivals/joints.hpp"

namespace dart::dynamics {
class BodyNode;
class Joint;
class Skeleton;
}  // namespace dart::dynamics
namespace dart::simulation {
class World;
}

namespace atwood::dartsim {

// Why DART cannot represent the scene's joints and ropes; empty when it can.
std::string refused_mechanism(const Scene& scene);

// A node for the joint's child, below `parent` (null: the world; a fixed body's pose is in the joint's frame), at the
// start of the scene.
dart::dynamics::BodyNode* add_placed_body(const Scene& scene, int joint, dart::dynamics::Skeleton& skeleton,
                                          dart::dynamics::BodyNode* parent);

// nodes: by body.
void add_closing_joints(const Scene& scene, const std::vector<dart::dynamics::BodyNode*>& nodes,
                        dart::simulation::World& world);

// Motors and prescribed rates of the step that begins at t_s.
void command(const Scene& scene, const std::vector<dart::dynamics::BodyNode*>& nodes, double t_s, double t_switch_s);

rivals::JointState joint_of(const Scene& scene, int joint, const dart::dynamics::BodyNode& child);

// After forward dynamics of all skeletons.
std::vector<rivals::Reaction> reactions_of(const Scene& scene, const std::vector<dart::dynamics::BodyNode*>& nodes,
                                           const std::vector<rivals::Motion>& motions,
                                           const std::vector<rivals::Wrench>& wrenches);
// Whether constraints act besides the joints of the tree.
bool reactions_hidden(const Scene& scene, const std::vector<dart::dynamics::BodyNode*>& nodes);

}  // namespace atwood::dartsim
