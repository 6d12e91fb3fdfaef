// The interface of the closed forms, and the evaluation of bodies that move independently of each other.
#pragma once

#include <algorithm>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "closed_form/features.hpp"
#include "closed_form/number.hpp"
#include "scene/scene.hpp"

namespace atwood::closed_form {

template <class S> struct Pose {
  Vec<S> p_WB{}, v_WB{}, w_WB_B{};
  Quat<S> q_WB{1, 0, 0, 0};
};

template <class S> struct ContactEvent {  // an Event over S
  S t_s{};
  EventKind kind = EventKind::impact;
  int body_a = 0, body_b = 0;
  Vec<S> x_W{}, normal_W{};
  S impulse_n_N_s{}, impulse_t_N_s{}, vn_before_m_per_s{}, vn_after_m_per_s{};
  S coupled_delay_s = -1;  // [s] until the next impact that is coupled with this one; negative: none
  S slack_s{};             // half-width of t_s by the round-off of the scene's doubles, as InputRoundOff
};

// Errors from conditions that the scene's doubles satisfy to round-off only (a closed gap, a flat floor) and that a
// solution assumes to be exact. They are added to every bar after t = 0.
template <class S> struct InputRoundOff { S p_m{}, q{}, v_m_per_s{}, w_rad_per_s{}; };

// A joint at one instant: coordinates, their rates (of a ball: quaternion and relative body rate) and the rates'
// derivatives; the reaction on the child at its anchor and about it, world axes; springs, dampers and motors along the
// rates.
template <class S> struct JointState {
  std::array<S, 4> q{};
  Vec<S> u{}, du{};
  Vec<S> force_N{}, torque_N_m{}, applied{};
  unsigned not_unique = 0;  // as in JointSample
  bool locked = false;      // at rest at a stop, whose force is not part of the reaction
  S stop{};                 // that force, along the rate
};
template <class S> struct RopeState {
  S tension_N{};
  std::vector<S> pulley_angle_rad;
};

template <class S> struct Motion {
  std::string refusal;    // why the solution does not cover the scene; empty: it does
  std::string undecided;  // why the motion after end_s is not decided; empty: it is
  S end_s{};
  std::vector<std::vector<Pose<S>>> poses;         // [time][body]; of times before end_s when `undecided`
  std::vector<std::vector<JointState<S>>> joints;  // [time][joint]; empty: the scene has none
  std::vector<std::vector<RopeState<S>>> ropes;    // [time][rope]; empty: the scene has none
  std::vector<ContactEvent<S>> events;
  InputRoundOff<S> input_round_off;
};

// One solution: its id, its citation, and the same formulas over both scalars at the times t_s.
struct Solution {
  const char* id;
  const char* citation;
  Features covers;  // a scene with any other feature is refused before the evaluation
  Motion<Narrow> (*narrow)(const Scenario&, const std::vector<Narrow>& t_s);
  Motion<Wide> (*wide)(const Scenario&, const std::vector<Wide>& t_s);
  bool each_instant_alone = false;  // without events: the pose at a time is the same whatever other times are asked for
};

// failure: not null when there is no value at this time, and why
template <class S> struct CenterMotion {
  Vec<S> p{}, v{};
  const char* failure = nullptr;
};
template <class S> struct Rotation {
  Quat<S> q{1, 0, 0, 0};
  Vec<S> w{};
};
template <class S> using CenterMotionAt = std::function<CenterMotion<S>(S)>;  // of the time since release
template <class S> using RotationAt = std::function<Rotation<S>(S)>;

// Motion of one body's centre from its forces; `refusal` when they are not covered.
template <class S> struct Translation {
  std::string refusal;
  CenterMotionAt<S> at;
  S end_s = std::numeric_limits<double>::infinity();  // since release: there is no motion from then on
  std::string end_why = {};
};

// Evaluates bodies that do not interact: each one's centre by `translation`, its attitude by free_rotation.
template <class S>
Motion<S> solve_each_body(const Scenario& scenario, const std::vector<S>& t_s,
                          const std::function<Translation<S>(const Scene&, int body)>& translation);

// Rotation of a body without torque, or with the torque -c w about a principal axis.
template <class S> struct RotationSolution {
  std::string refusal;
  RotationAt<S> at;
};
template <class S> RotationSolution<S> free_rotation(const Body& body, S angular_drag_N_m_s);
// The same without torque of a rigid body whose inertia (row-major, about its centre of mass, body axes) is given in S.
template <class S>
RotationAt<S> torque_free(const std::array<S, 9>& inertia, const Quat<S>& q_WB, const Vec<S>& w_WB_B);

// The pose at t = 0.
template <class S> Pose<S> initial_pose(const Body& body);

std::string force_name(const Force& force);
bool acts_on(const Force& force, int body);
// "the force `spring` on `ball`", for refusals.
std::string force_on_body(const Scene& scene, const Force& force, int body);
// A sentence with two bodies whose shapes could touch; empty: there are none.
std::string possible_contact(const Scene& scene);

// For a spin w about a principal axis that is treated as steady with an angular velocity `neglected` orthogonal to it:
// bound of this component at t. About the middle axis it grows as exp(|w| sqrt((I2 - I1)(I3 - I2) / (I1 I3)) t); about
// the others it stays within a factor of the moments' ratio.
template <class S> S grown_rate(const std::array<S, 3>& moment, S w, S neglected, S t) {
  const S least = std::min(moment[0], std::min(moment[1], moment[2])),
          most = std::max(moment[0], std::max(moment[1], moment[2])),
          middle = moment[0] + moment[1] + moment[2] - least - most;
  if (neglected == 0) return 0;
  return neglected * (most / least) *
         exp(w * t * sqrt(larger(S(0), (middle - least) * (most - middle)) / (least * most)));
}

// All principal moments are equal, so that every axis is a principal axis; true for fixed bodies.
bool has_spherical_inertia(const Body& body);
// Distance between the segments from a to b and from c to d.
double segment_distance(const Vec<double>& a, const Vec<double>& b, const Vec<double>& c, const Vec<double>& d);
template <class S> Vec<double> rounded(const Vec<S>& v) { return {double(v[0]), double(v[1]), double(v[2])}; }

// ---- the catalogue ----------------------------------------------------------------------------------------------
Solution ballistic();
Solution linear_drag();
Solution vertical_quadratic_drag();
Solution oscillator();
Solution kepler();
Solution coulomb_two_body();
Solution lorentz();
Solution free_rigid_body();
Solution axis_torque();
Solution bounce();
Solution sphere_impact();
Solution slide_or_roll();
Solution ball_flights();
Solution steady_roll();
Solution friction_cone();
Solution struck_rod();
Solution penalty();
Solution rest();
Solution pendulum();
Solution heavy_top();
Solution linear_joint();
Solution joint_stop();
Solution turning_rod();
Solution slider_crank();
Solution hooke_shaft();
Solution welded_bodies();
Solution four_bar();
Solution atwood_machine();

}  // namespace atwood::closed_form
