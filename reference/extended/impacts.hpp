// Where contacts begin inside a step, and how a bouncing ball comes to rest on a plane. Balls against each other,
// planes and fixed rectangles and boxes; Newton's restitution, Coulomb's friction.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "dynamics/contacts.hpp"
#include "dynamics/rates.hpp"

namespace atwood::extended {

template <class S>
class Impacts {
 public:
  Impacts(const Scene& scene, dynamics::Dynamics<S>& dynamics, dynamics::Dynamics<double>& narrow, double t_end_s);

  bool any() const { return !pairs_.empty() || !held_.empty(); }
  const std::string& failure() const { return failure_; }

  // Contacts at (t, y) itself: strikes every pair that touches and approaches, lays to rest what bounces no more.
  void settle(S t, S* y, int interval, std::vector<Event>& events);

  // The first instant in (0, taken] after `before` at which a pair touches, if any; `after` is the state at `taken`,
  // and `again(tau)` is the state at tau, stepped from `before` once more.
  using Again = std::function<std::vector<S>(S tau)>;
  std::optional<S> first_touch(const S* before, const S* after, S taken, const Again& again) const;

  // What rests on a plane must stay there: fills failure() if it left.
  void check_held(const S* y);

 private:
  using Pair = dynamics::ContactPair;
  std::optional<S> touch(const Pair& pair, const S* before, const S* after, S taken, const Again& again) const;
  S locate(const Pair& pair, const S* before, S high, S gap_high, const Again& again) const;
  void strike_pair(const Pair& pair, S t, S* y, std::vector<Event>& events);
  bool rests(const Pair& pair, S t, S* y, int interval, std::vector<Event>& events);

  const Scene& scene_;
  dynamics::Dynamics<S>& dynamics_;
  dynamics::Dynamics<double>& narrow_;
  double t_end_s_;
  S tiny_ = 0;   // a gap that round-off can make [m]
  std::vector<Pair> pairs_, held_;
  std::string failure_;
  int strikes_ = 0;
};

extern template class Impacts<double>;
extern template class Impacts<Wide>;

}  // namespace atwood::extended
