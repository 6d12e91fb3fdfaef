// Spheres under uniform gravity, their contacts, and the outcome of impacts at one instant: Newton's restitution and
// Coulomb's friction (E. J. Routh, Dynamics of a System of Rigid Bodies, art. 169 and 180).
//
// The surfaces slip at s = u_t - (r_a W_a + r_b W_b) x n. The normal impulse is J = -(1 + e) u_n / (1/m_a + 1/m_b), and
// the friction impulse the lesser of mu J and |s| / (1/m_a + 1/m_b + r_a^2/I_a + r_b^2/I_b), against s, which keeps its
// direction. Impacts at one instant whose impulses act on each other follow the scene's convention: in sequence, the
// fastest approach first, ties in the order of the bodies, until none approaches (E. Mariotte, 1673); or together
// (J. J. Moreau, 1988). Without a convention the outcome is undecided, unless all of them agree.
#pragma once

#include <string>
#include <type_traits>
#include <vector>

#include "closed_form/solution.hpp"

namespace atwood::closed_form {

template <class S> struct Ball {
  int body = -1;
  S radius{}, inverse_mass{}, inverse_inertia{};
  S t{};  // [s] start of its present flight: its release or its last impact; before it the ball is held
  Vec<S> p{}, v{}, w_B{};
  Quat<S> q{1, 0, 0, 0};
};

// The ball's pose at t; before ball.t its pose at ball.t.
template <class S> Pose<S> pose_at(const Ball<S>& ball, const Vec<S>& g, S t) {
  const S since = t - ball.t;
  if (!(since > 0)) return {ball.p, ball.v, ball.w_B, ball.q};
  const S rate = norm(ball.w_B);
  return {ball.p + since * (ball.v + (since / 2) * g), ball.v + since * g, ball.w_B,
          rate == 0 ? ball.q : ball.q * turn((1 / rate) * ball.w_B, rate * since)};
}

// Two bodies in contact.
template <class S> struct BallContact {
  int ball = -1, other = -1;     // indices of balls; other = -1: a fixed body
  int body_a = -1, body_b = -1;  // indices of bodies, a < b
  S sign{};                      // 1: ball is body_a, otherwise -1
  Vec<S> normal{};               // unit, from ball to other
};

// Relative speeds below this are round-off.
template <class S> inline constexpr double kSpeedRoundOff = 64 * (std::is_same_v<S, Wide> ? 0x1p-113 : 0x1p-64);

template <class S> class BallImpacts {
 public:
  BallImpacts(const Scene& scene, std::vector<Ball<S>>& balls) : scene_(scene), balls_(balls) {}

  const PairLaw& law_of(const BallContact<S>& contact) const;
  // Does an impulse at one contact change the velocities at the other?
  bool coupled(const BallContact<S>& one, const BallContact<S>& other) const;
  // Applies the impact laws to a group of coupled contacts at t_s, at which its balls' states are given; changes the
  // balls and appends one event per impact. Answers why the outcome is undecided; empty: it is decided.
  std::string resolve(const std::vector<BallContact<S>>& group, S t_s, std::vector<ContactEvent<S>>& events);

 private:
  S approach_speed(const BallContact<S>& contact) const;
  S speed_tolerance(const BallContact<S>& contact) const;
  bool same_velocities(const std::vector<Ball<S>>& end, const std::vector<Ball<S>>& start) const;
  // One impact after another until none approaches. `order` gives the order of preference; empty: the fastest first.
  // False: it does not end.
  bool resolve_in_sequence(const std::vector<BallContact<S>>& group, const std::vector<std::size_t>& order);
  // Moreau's law: 0 <= Lambda_i, v_i+ + e_i min(v_i-, 0) >= 0, complementary. False: friction, too many contacts, or no
  // solution.
  bool solve_moreau(const std::vector<BallContact<S>>& group);
  void apply_impact_law(const BallContact<S>& contact);
  void append_event(const BallContact<S>& contact, S normal_impulse, S friction_impulse, S vn_before, S vn_after);

  const Scene& scene_;
  std::vector<Ball<S>>& balls_;
  S t_s_{}, largest_speed_{};  // largest_speed_: of the group's balls before the impact
  std::vector<ContactEvent<S>>* events_ = nullptr;
};

extern template class BallImpacts<Narrow>;
extern template class BallImpacts<Wide>;

}  // namespace atwood::closed_form
