// Stops of joints in smooth motion: coordinates that reach a limit bounce off it, or come to rest there.
//
// After a step from (t, y) the first instant in it is located, to round-off, at which a free coordinate passes a limit
// or the force that holds a resting one changes its sign: by false position on shorter steps from the same state, so
// that the instant has the method's own order. An impact gives the coordinate the rate -e u by an impulse along it,
// under all constraints; several coordinates that reach their limits at once are solved for together. A coordinate
// rests once its next bounce, u^2 / 2 a high, is below 32 roundings of the limits; the instant of its rest is the end
// of the remaining bounces, 2 u / (a (1 - e)) later. It is then held by a constraint until that would have to pull.
#pragma once

#include <string>
#include <vector>

#include "smooth/run.hpp"

namespace atwood {

template <class S> class Stops {
 public:
  // Whether the model has any; it outlives this.
  explicit Stops(Simulation<S>& simulation);
  bool any() const { return !sides_.empty(); }

  // At the start, and again at each restart: releases all, and lets coordinates rest that are pressed on their limits.
  // False: a coordinate starts beyond its limits; fault() says which.
  bool start(const Observer* observer);
  // The impacts of coordinates that start at their limits and move beyond, at t = 0. As resolve().
  bool resolve_start();
  // After a step of h_s from (t_s, simulation.y) to simulation.y_new: the fraction of it up to the first event, 1 if
  // there is none. simulation.y_new is then the state there, by the stepper's last call. False: a step was not solved.
  bool locate(S t_s, S h_s, S& fraction);
  // Whether the last locate() found an event, which may be at the very end of the step.
  bool at_event() const { return at_event_; }
  // The event found at simulation.y, which is at t_s. False: the run cannot go on; fault() says why.
  bool resolve(S t_s);
  const std::string& fault() const { return fault_; }

 private:
  enum class Side : signed char { lower = -1, upper = 1 };
  struct Limit {
    int stop;  // index into the constraints' stops
    Side side;
    S at, round_off;
    bool resting = false;
    bool reached = false;  // by the last locate()
    S gap_start{}, gap_end{}, rate_start{}, rate_end{};
  };
  S gap(const Limit& limit, const S* y) const;   // >= 0 within the limits
  S rate(const Limit& limit, const S* y) const;  // of the gap
  bool probe(S t_s, S h_s, S fraction);
  // Reports how a search for an event ended; `width` is what it leaves undecided, as a share of the step.
  void note(int iterations, S width, bool converged);
  bool first_passage(S t_s, S h_s, Limit& limit, S until, S& fraction);
  bool first_release(S t_s, S h_s, Limit& limit, S until, S& fraction);
  S holding_force(const Limit& limit, S t_s, const S* y);
  bool resolve_impacts(S t_s);
  void settle(S t_s);
  void report(EventKind kind, const Limit& limit, S t_s, S impulse, S before, S after);

  Simulation<S>& simulation_;
  std::vector<Limit> sides_;
  const Observer* observer_ = nullptr;
  std::string fault_;
  std::vector<S> rates_, du_;
  S event_s_{}, moved_to_{};
  bool at_event_ = false;
  int events_at_instant_ = 0;
};

}  // namespace atwood
