// Where contacts begin inside a step, and how a bouncing ball comes to rest on a plane. Balls against each other,
// planes and fixed rectangles and boxes; Newton's restitution, Coulomb's friction.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "dynamics/contacts.hpp"
#include "dynamics/instants.hpp"
#include "dynamics/rates.hpp"

namespace atwood::extended {

using dynamics::Instant;
using dynamics::Laid;

template <class S> class Impacts {
 public:
  using Pair = dynamics::ContactPair;
  Impacts(const Scene& scene, dynamics::Dynamics<S>& dynamics, dynamics::Dynamics<double>& narrow, double t_end_s);

  bool any() const { return !pairs_.empty() || !held_.empty(); }
  const std::string& failure() const { return failure_; }

  // The failure is the instant's own: up to it all is well.
  bool branch() const { return branch_; }

  // Contacts at (t, y) itself: strikes what touches and approaches, by the scene's convention where several contacts
  // act on each other; lays to rest what bounces no more. Tells what happened.
  Instant<S> settle(S t, S* y, int interval, std::vector<Event>& events);

  // The first instant in (0, taken] after `before` at which a pair touches, if any; `after` is the state at `taken`,
  // and `again(tau)` is the state at tau, stepped from `before` once more.
  using Again = std::function<std::vector<S>(S tau)>;
  std::optional<S> first_touch(const S* before, const S* after, S taken, const Again& again) const;
  // Pairs that came near in the step before `until` and did not touch: when, and the state there.
  struct Passage {
    S tau{};
    Pair pair;
    std::vector<S> y;
  };
  std::vector<Passage> passages(const S* before, const S* after, S taken, S until, const Again& again) const;

  // What rests on a plane must stay there: fills failure() if it left.
  void check_held(const S* y);

 private:
  std::optional<S> touch(const Pair& pair, const S* before, const S* after, S taken, const Again& again) const;
  // The least gap inside the step, if the pair comes nearer and goes away again within it.
  std::optional<Passage> nearest(const Pair& pair, const S* before, const S* after, S taken, const Again& again) const;
  S locate(const Pair& pair, const S* before, S high, S gap_high, const Again& again) const;
  S tiny(const Pair& pair, const S* y) const;  // a gap that round-off can make [m]
  S slow(const Pair& pair) const;              // a speed that round-off can make [m/s]
  void see_speeds(const S* y);
  bool may_strike(const Pair& pair, S t, const S* y);
  void tell(const dynamics::Blow<S>& blow, const S* after, S t, std::vector<Event>& events) const;
  void advances(S t);
  std::optional<Laid<S>> rests(const Pair& pair, S t, S* y, int interval, std::vector<Event>& events);

  const Scene& scene_;
  dynamics::Dynamics<S>& dynamics_;
  dynamics::Dynamics<double>& narrow_;
  double t_end_s_;
  std::vector<Pair> pairs_, held_;
  std::vector<S> fastest_;  // each body's largest speed so far
  std::string failure_;
  bool branch_ = false;
  S last_strike_ = -1;
  int stalled_ = 0;
};

extern template class Impacts<double>;
extern template class Impacts<Wide>;

}  // namespace atwood::extended
