// Loops and ropes of a mechanism as linear conditions: the unknowns that may change, and the rows that closing joints
// and ropes give.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "scene/mechanism.hpp"
#include "scene/rope_path.hpp"

namespace atwood::loop_rows {

using quad::Real;
using quad::Vector;

// One unknown: a rate of a placing joint, or of a free body that no joint places (0 to 2: velocity, 3 to 5: turning
// about its own axes). It moves the bodies as a screw does: along `axis`, or by turning about it through `point`
// (world).
struct Freedom {
  int body = -1;   // a root, or the child of `joint`
  int joint = -1;  // -1: of a root
  std::size_t component = 0;
  bool slides = false;
  Vector axis{}, point{};
};

// A linear form on the motions of two bodies: force . v + torque . w, w in world axes, v of the centre of mass.
struct Row {
  std::array<int, 2> bodies{-1, -1};
  std::array<Vector, 2> force{}, torque{};
  Real residual = 0;      // of the positions
  Real target = 0;        // the rate that it should have
  bool is_length = true;  // else an angle
};

struct Loops {
  const Scene& scene;
  std::vector<int> order;      // placing joints from the root
  std::vector<int> placing;    // of each body
  std::vector<bool> involved;  // bodies of mechanisms with loops or ropes
  std::vector<Freedom> freedoms;
  std::vector<std::vector<int>> movers;  // of each body the freedoms that move it
  Real size = 1;                         // [m]
};

// Bodies of mechanisms with loops or ropes, by body.
std::vector<bool> involved_bodies(const Scene& scene);
// Joints whose coordinates the projection leaves as they are, by joint.
std::vector<bool> held_joints(const Scene& scene);
// Sets the unknowns, and of each body those that move it.
void add_freedoms(Loops& loops);
// The screws of all freedoms in the present configuration.
void set_screws(Loops& loops, const MechanismStart& start);

Vector world_point(const MechanismStart& start, int body, const Real3& point_body);
Vector point_velocity(const MechanismStart& start, int body, const Real3& point_body);

// Calls f(body, point) for all anchors of joints, ends of ropes and centres of mass of mechanisms with loops or ropes.
template <class F> void each_point(const Scene& scene, const std::vector<bool>& involved, F f) {
  const auto take = [&](int body, const Real3& point, int other) {
    const auto in = [&](int b) { return b >= 0 && involved[static_cast<std::size_t>(b)]; };
    if (in(body) || in(other)) f(body, point);
  };
  for (const Joint& joint : scene.joints) {
    take(joint.parent, joint.anchors_body_m[0], joint.child);
    take(joint.child, joint.anchors_body_m[1], joint.parent);
  }
  for (const Rope& rope : scene.ropes)
    for (std::size_t i = 0; i < 2; ++i) take(rope.bodies[i], rope.points_body_m[i], rope.bodies[1 - i]);
  for (std::size_t b = 0; b < involved.size(); ++b)
    if (involved[b]) f(static_cast<int>(b), Real3{});
}
// The diagonal [m] of the box around these points; 1 where it is 0.
Real mechanism_size(const Scene& scene, const std::vector<bool>& involved, const MechanismStart& start);

std::vector<Row> joint_rows(const Joint& joint, const MechanismStart& start);
// The course of a rope. Throws MechanismError where it has none.
RopePath path_of(const Scene& scene, const MechanismStart& start, std::size_t rope);
Row rope_row(const Scene& scene, const MechanismStart& start, std::size_t rope, const RopePath& path);
Real rate_of(const Row& row, const MechanismStart& start);

}  // namespace atwood::loop_rows
