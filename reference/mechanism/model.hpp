// A scene's joints and ropes as constraints on the motions of their bodies, in double, long double and quad. The
// conventions are those of scene/joint.hpp. Unit vectors and quaternions of the scene are normalised in quad first.
//
// A motion has the velocity v of the centre of mass and the angular velocity w, both in world axes. A row is one linear
// form in the velocities of two bodies a and b (and of a rope's pulleys):
//   row . velocities = la . v_a + aa . w_a + lb . v_b + ab . w_b + cp s'
// It is the derivative of its residual; the derivative of the form is row . accelerations + gamma. As a load, a row's
// multiplier is the force (la, lb) at the centres of mass and the torque (aa, ab) about them.
#pragma once

#include <string>
#include <vector>

#include "mechanism/rotation.hpp"

namespace atwood::mechanism {

template <class S> struct Motion {
  Triple<S> p{}, v{}, w{};
  Quaternion<S> q{S(1), S(0), S(0), S(0)};
};
template <class S> struct Acceleration { Triple<S> a{}, alpha{}; };
template <class S> struct Wrench {  // about the centre of mass of its body
  Triple<S> force{}, torque{};
};

template <class S> struct Row {
  int a = 0, b = 0;
  Triple<S> la{}, aa{}, lb{}, ab{};
  int joint = -1;       // whose constraint it is; -1: a rope's or a stop's
  int tension_of = -1;  // the rope whose tension at the first body is minus its multiplier
  int rope = -1;        // of the pulley's part cp
  S cp{};
  S gamma{}, residual{};
  S bias{};  // row . velocities = bias: a driven joint's rate
};

template <class S> struct JointModel {
  JointKind kind{};
  int parent = 0, child = 0;
  Triple<S> anchor_parent{}, anchor_child{};  // body axes
  Triple<S> axis{};                           // child's axes
  std::array<Triple<S>, 2> across{};          // with the axis orthogonal, child's axes
  Triple<S> first{}, second{};                // universal: in the parent's and in the child's axes
  Triple<S> second_at_zero{};                 // F second
  S cosine{};                                 // of the angle between them, constant
  Quaternion<S> frame{};
  bool driven = false;
  S start{}, rate{};  // of the driven coordinate
};

template <class S> struct RopeEnd {
  bool straight = false;  // from body to body, over nothing
  Triple<S> axle{}, axis{}, b1{}, b2{};
  S radius{};
};
template <class S> struct RopeModel {
  int a = 0, b = 0;
  Triple<S> point_a{}, point_b{};  // body axes
  RopeEnd<S> first, last;
  S inertia{};               // sum of I / r^2 over the pulleys [kg]; 0: one constraint, no coordinate
  std::vector<S> radii;      // of all pulleys
  S length_a{}, length_b{};  // at the start; without inertia their sum is constant
  // Where the rope goes on from its first pulley, and comes to its last: the angle of that point of the pulley, in the
  // branch in which what it covers at the start lies in [-pi / 4, 7 pi / 4). With one pulley both are 2 pi k.
  S onward_first{}, inward_last{};
  bool one_pulley = false;
};

// What has to stay positive while the rope's constraint holds: its free parts at both ends [m], and the angles that it
// covers on its first and on its last pulley [rad]; 1 where it runs over a point or over nothing. closing: -d(free)/dt.
template <class S> struct RopeMargins {
  std::array<S, 2> free_m{S(1), S(1)}, closing_m_per_s{S(0), S(0)}, covered_rad{S(1), S(1)};
};

// Branches of angles and signs of quaternions: those nearest to these values are taken.
struct Memory {
  std::vector<std::array<double, 4>> joints;
  std::vector<std::array<double, 2>> ropes;
};

template <class S> struct Model {
  const Scene* scene = nullptr;
  int world = 0;  // index of the motion that stands for the world
  std::vector<JointModel<S>> joints;
  std::vector<RopeModel<S>> ropes;
  std::vector<int> tree, closing;  // joints: those that place bodies, parents first; those that close loops
  std::vector<int> placing;        // of each body: its joint in the tree, or -1
  std::vector<char> mobile, turns;
  std::vector<S> mass;
  std::vector<Matrix<S>> inertia, inverse_inertia;  // body axes
};

// Why the mechanisms of this scene are not covered; empty when they are.
std::string unsupported(const Scene& scene);

// The scene outlives its model.
template <class S> Model<S> make_model(const Scene& scene);
// Branches at the start; `start` has the joints' coordinates. Driven coordinates begin there too.
template <class S> Memory begin_at(Model<S>& model, const Sample& start);

// Rows that hold the joint together; with a driven coordinate its row is the last.
template <class S>
void add_constraint_rows(const Model<S>& model, int joint, const std::vector<Motion<S>>& motions, const S& t_s,
                         const Memory& memory, std::vector<Row<S>>& rows);
// Row k gives the joint's rate u_k. gamma of hinges and sliders alone.
template <class S>
std::vector<Row<S>> rate_rows(const Model<S>& model, int joint, const std::vector<Motion<S>>& motions);
template <class S>
std::array<S, 4> coordinates(const Model<S>& model, int joint, const std::vector<Motion<S>>& motions,
                             const Memory& memory);
template <class S> std::array<S, 3> rates(const Model<S>& model, int joint, const std::vector<Motion<S>>& motions);
// Of springs, dampers and torques, along each rate. `interval_s`: an instant inside the interval between switches.
template <class S>
std::array<S, 3> applied(const Model<S>& model, int joint, const std::array<S, 4>& q, const std::array<S, 3>& u,
                         const S& t_s, double interval_s);

// One row; with inertia of pulleys two, for the lengths on both sides. s: the rope's way from its first body to its
// last.
template <class S>
void add_rope_rows(const Model<S>& model, int rope, const std::vector<Motion<S>>& motions, const S& s,
                   const Memory& memory, std::vector<Row<S>>& rows);
// Free lengths up to constants: on the side of the first and of the last body.
template <class S>
std::array<S, 2> rope_lengths(const Model<S>& model, int rope, const std::vector<Motion<S>>& motions,
                              const Memory& memory);
// Fixes lengths and branches of all ropes at the start.
template <class S> void begin_ropes(Model<S>& model, const std::vector<Motion<S>>& motions, const Memory& memory);
template <class S>
RopeMargins<S> rope_margins(const Model<S>& model, int rope, const std::vector<Motion<S>>& motions,
                            const Memory& memory);
// Largest distance of a rope's end from the plane of its pulley, where the pulley has a radius [m].
template <class S> S off_pulley_planes(const Model<S>& model, const std::vector<Motion<S>>& motions);
// The branches of these motions.
template <class S> void remember(const Model<S>& model, const std::vector<Motion<S>>& motions, Memory& memory);

template <class S> S velocity_of(const Row<S>& row, const std::vector<Motion<S>>& motions) {
  return dot(row.la, motions[row.a].v) + dot(row.aa, motions[row.a].w) + dot(row.lb, motions[row.b].v) +
         dot(row.ab, motions[row.b].w);
}
template <class S> S acceleration_of(const Row<S>& row, const std::vector<Acceleration<S>>& a) {
  return dot(row.la, a[row.a].a) + dot(row.aa, a[row.a].alpha) + dot(row.lb, a[row.b].a) + dot(row.ab, a[row.b].alpha);
}
template <class S> void add_load(const Row<S>& row, const S& multiplier, std::vector<Wrench<S>>& loads) {
  loads[row.a].force += multiplier * row.la;
  loads[row.a].torque += multiplier * row.aa;
  loads[row.b].force += multiplier * row.lb;
  loads[row.b].torque += multiplier * row.ab;
}

// I v and I^-1 v with the body's inertia, world axes.
template <class S> Triple<S> turned(const Matrix<S>& I, const Quaternion<S>& q, const Triple<S>& v) {
  return rotate(q, multiply(I, rotate_back(q, v)));
}

}  // namespace atwood::mechanism
