// What a closed form answers, and the walk over bodies that move independently of each other.
#pragma once

#include <algorithm>
#include <functional>
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

template <class S> struct Happening {  // an Event over S
  S t_s{};
  EventKind kind = EventKind::impact;
  int body_a = 0, body_b = 0;
  Vec<S> x_W{}, normal_W{};
  S impulse_n_N_s{}, impulse_t_N_s{}, vn_before_m_per_s{}, vn_after_m_per_s{};
  S rival_s = -1;  // how much later another contact that acts on this one would have been struck; negative: none
};

// What the doubles of a scene leave open, where a law takes for closed or flat what they close or flatten to round-off
// only: it goes into every bar after t = 0.
template <class S> struct Slack { S p_m{}, q{}, v_m_per_s{}, w_rad_per_s{}; };

template <class S> struct Motion {
  std::string misfit;  // why the scene is not one that the solution solves; empty: it is
  std::string branch;  // why it ends at end_s: what follows hangs on a convention
  S end_s{};
  std::vector<std::vector<Pose<S>>> poses;  // [instant][body]; of instants before a branch
  std::vector<Happening<S>> happenings;
  Slack<S> slack;
};

// One solution: its id, its citation, and the same formulas over both scalars. `t_s` are the instants.
struct Solution {
  const char* id;
  const char* citation;
  Features takes;  // all that a scene may hold: anything else is refused before the formulas see it
  Motion<Narrow> (*narrow)(const Scenario&, const std::vector<Narrow>& t_s);
  Motion<Wide> (*wide)(const Scenario&, const std::vector<Wide>& t_s);
};

// failure: why there is none at this instant
template <class S> struct Flight {
  Vec<S> p{}, v{};
  const char* failure = nullptr;
};
template <class S> struct Spin {
  Quat<S> q{1, 0, 0, 0};
  Vec<S> w{};
};
template <class S> using FlightAt = std::function<Flight<S>(S)>;  // of the time since release
template <class S> using SpinAt = std::function<Spin<S>(S)>;

// Motion of one body's centre, from its forces; a misfit's words when they are not covered.
template <class S> struct Translation {
  std::string misfit;
  FlightAt<S> at;
};

// Bodies that don't touch, attract or hold each other: each flies by `translation` of it, and turns by its spin.
template <class S>
Motion<S> move_each(const Scenario& scenario, const std::vector<S>& t_s,
                    const std::function<Translation<S>(const Scene&, int body)>& translation);

// How a body without torque turns (or with torque -c w about a principal axis). Principal moments are found first.
template <class S> struct Turning {
  std::string misfit;
  SpinAt<S> at;
};
template <class S> Turning<S> turning(const Body& body, S angular_drag_N_m_s);

// The pose at t = 0.
template <class S> Pose<S> initial_pose(const Body& body);

std::string force_name(const Force& force);
bool acts_on(const Force& force, int body);
// "the force `spring` on `ball`": a misfit's words.
std::string named(const Scene& scene, const Force& force, int body);
// Empty, or which two bodies have shapes that could touch.
std::string could_touch(const Scene& scene);

// A spin w about a principal axis taken for steady although a rate of `dropped` across it was left out: how large that
// rate may have become at t. It grows as exp(|w| sqrt((I2 - I1)(I3 - I2) / (I1 I3)) t) about the middle axis, and about
// the others stays within a factor of the moments' ratio.
template <class S> S grown(const std::array<S, 3>& moment, S w, S dropped, S t) {
  const S least = std::min(moment[0], std::min(moment[1], moment[2])),
          most = std::max(moment[0], std::max(moment[1], moment[2])),
          middle = moment[0] + moment[1] + moment[2] - least - most;
  if (dropped == 0) return 0;
  return dropped * (most / least) *
         exp(w * t * sqrt(larger(S(0), (middle - least) * (most - middle)) / (least * most)));
}

// The moments are all alike: a body that turns like a ball about every axis.
bool turns_like_a_ball(const Body& body);
// The least distance of the segments from a to b and from c to d.
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

}  // namespace atwood::closed_form
