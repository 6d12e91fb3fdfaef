// Impacts during a run: their location inside a step, their outcome, and balls that come to rest on a plane. Spheres
// against each other, planes and fixed rectangles and boxes; Newton's restitution, Coulomb's friction.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "dynamics/contacts.hpp"
#include "dynamics/impact_events.hpp"
#include "dynamics/instants.hpp"
#include "dynamics/rates.hpp"
#include "extended/step_course.hpp"

namespace atwood::extended {

using dynamics::BounceSeries;
using dynamics::Instant;

template <class S> class Impacts {
 public:
  using Pair = dynamics::ContactPair;
  Impacts(const Scene& scene, dynamics::Dynamics<S>& dynamics, dynamics::Dynamics<double>& double_dynamics,
          double t_end_s);

  bool any() const { return !pairs_.empty() || !held_.empty(); }
  const std::string& failure() const { return failure_; }

  // The motion up to the instant of the failure is valid.
  bool valid_until_failure() const { return valid_until_failure_; }

  // Applies the impact laws at (t, y) to the pairs that touch and approach (coupled contacts by the scene's convention)
  // and brings balls to rest at the end of their bounces. Changes y, appends events, and returns what happened. On
  // failure() the returned instant has no state after it.
  Instant<S> resolve(S t, S* y, int interval, std::vector<Event>& events);

  // state_at(tau) integrates from the start of the step to tau.
  using StateAt = std::function<std::vector<S>(S tau)>;
  // Not `located`: the iteration ended before the gap was within its round-off; the motion is known up to the start of
  // the step only.
  struct Touch {
    S tau{};
    Pair pair;
    bool located = true;
  };
  // A closest approach without contact: time and state. Not `located`, as above.
  struct Passage {
    S tau{};
    Pair pair;
    std::vector<S> y;
    bool located = true;
  };
  // What happens in a step: the first time in (0, span] at which a pair touches, and the closest approaches before it,
  // in order. undecided: whether this pair touches cannot be told from the step's dense output; a shorter step can.
  struct Found {
    std::optional<Touch> touch;
    std::vector<Passage> passages;
    std::optional<Pair> undecided;
  };
  Found search(const StepCourse<S>& course, const StateAt& state_at) const;

  // Fills failure() where a touch or a passage of the step from t was not located.
  void check_located(S t, const Pair& pair, bool located);
  // Fills failure(): no step from t is short enough to tell whether the bodies touch (or part: `what`).
  void end_undecided(S t, const Pair& pair, const char* what);

  // The first time in the step at which the plane under a ball at rest would have to pull, and the ball's pair.
  // undecided: a shorter step can tell. Fills failure() where it cannot be told at all, and where friction acts on the
  // ball.
  struct Lift {
    std::optional<S> tau;
    Pair pair;
    bool undecided = false;
  };
  // `until`: of the step, where a pair touches or the step ends.
  Lift find_lift(const StepCourse<S>& course, int interval, const StateAt& state_at, S until);
  // The span around a touch at y in which the gap is within its round-off.
  S location_span(const Pair& pair, const S* y) const;
  // Where the motion ends inside a step; empty: where the step begins.
  const std::optional<S>& failed_at() const { return failed_at_; }
  // A speed below which a ball at rest is held to round-off alone, as a vector of velocities; empty: no ball is at
  // rest.
  std::vector<S> speeds_at_rest(S t, const S* y, int interval) const;
  // The ball of this pair leaves its plane at (t, y).
  Instant<S> release(const Pair& pair, S t, const S* y, int interval, std::vector<Event>& events);

 private:
  struct Step;
  void search(const Pair& pair, const Step& step, Found& found) const;
  bool is_far(const Pair& pair, const Step& step) const;
  // The closest approach between two places of the step, at which the gap's rate is negative and then positive. Empty:
  // it is not, or the approach is not close.
  std::optional<Passage> closest_approach(const Pair& pair, S low, S high, const StateAt& state_at) const;
  S pull_to_plane(const Pair& pair, S t, const S* y, int interval) const;
  Touch locate(const Pair& pair, const S* before, S low, S high, S gap_high, const StateAt& state_at) const;
  S gap_tolerance(const Pair& pair, const S* y) const;  // round-off of the gap [m]
  S speed_tolerance(const Pair& pair) const;            // round-off of the gap's rate [m/s]
  void update_fastest(const S* y);
  // Sums the remaining bounces of a ball on a plane when they are short or low enough. Empty: there is nothing to sum,
  // or the case is not covered (failure()).
  std::optional<BounceSeries<S>> bring_to_rest(const Pair& pair, S t, S* y, int interval, std::vector<Event>& events);

  const Scene& scene_;
  dynamics::Dynamics<S>& dynamics_;
  dynamics::Dynamics<double>& double_dynamics_;
  dynamics::Dynamics<S> free_dynamics_;  // without the planes' reactions
  double t_end_s_;
  std::vector<Pair> pairs_, held_;
  std::vector<S> fastest_;  // each body's largest speed so far
  std::string failure_;
  bool valid_until_failure_ = false;
  std::optional<S> failed_at_;
  dynamics::ImpactProgress<S> progress_;
};

extern template class Impacts<double>;
extern template class Impacts<Wide>;

}  // namespace atwood::extended
