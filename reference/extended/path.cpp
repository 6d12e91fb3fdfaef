#include "extended/path.hpp"

#include "extended/impacts.hpp"

namespace atwood::extended {

namespace {

// The walk's moving parts; `interval` is read by the rate functions that the stepper holds.
template <class S>
struct Walk {
  dynamics::Dynamics<S> dynamics;
  dynamics::Dynamics<double> narrow;
  Impacts<S> impacts;
  int interval = 0;
  std::unique_ptr<Stepper<S>> stepper;
  S t = 0;
  std::vector<S> y;
  Path<S> path;

  Walk(const Scene& scene, double t_end_s, const std::vector<S>& initial, const MakeStepper<S>& make)
      : dynamics(scene, t_end_s), narrow(scene, t_end_s), impacts(scene, dynamics, narrow, t_end_s), y(initial) {
    stepper = make([this](S at, const S* state, S* dydt) { dynamics.rate(at, state, dydt, interval); },
                   [this](double at, const double* state, double* dydt) { narrow.rate(at, state, dydt, interval); });
  }
  Walk(const Walk&) = delete;
  Walk& operator=(const Walk&) = delete;

  bool failed() {
    if (path.failure.empty()) path.failure = impacts.failure();
    return !path.failure.empty();
  }

  bool singular() {
    path.failure = "no step is small enough at t = " + format_double(static_cast<double>(t)) + " s: the motion is singular";
    return false;
  }

  // One step towards `target`, cut at the first touch within it.
  bool step_to(S target) {
    const S left = target - t;
    std::vector<S> before;
    if (impacts.any()) before = y;
    const S taken = stepper->step(t, y.data(), left);
    if (!(taken > 0)) return singular();
    if (impacts.any()) {
      const auto again = [&](S tau) {
        std::vector<S> state = before;
        if (!advance(*stepper, t, state.data(), tau)) singular();
        return state;
      };
      if (const auto tau = impacts.first_touch(before.data(), y.data(), taken, again)) {
        y = again(*tau);
        t += *tau;
        impacts.settle(t, y.data(), interval, path.events);
        return !failed();
      }
      impacts.check_held(y.data());
      if (failed()) return false;
    }
    t = taken == left ? target : t + taken;
    return true;
  }

  bool go_to(S target) {
    while (t < target)
      if (!step_to(target)) return false;
    return true;
  }

  void run(double t_end_s, std::int64_t samples) {
    const std::vector<double>& switches = dynamics.switch_times();
    impacts.settle(S(0), y.data(), interval, path.events);
    path.states.push_back(y);
    if (failed()) return;
    std::size_t next = 0;
    for (std::int64_t k = 1; k <= samples; ++k) {
      const S target = S(t_end_s) * S(k) / S(samples);
      for (; next < switches.size() && switches[next] <= target; ++next) {
        if (!go_to(S(switches[next]))) return;
        ++interval;
        impacts.settle(t, y.data(), interval, path.events);
        if (failed()) return;
      }
      if (!go_to(target)) return;
      path.states.push_back(y);
    }
  }
};

}  // namespace

template <class S>
Path<S> walk(const Scene& scene, double t_end_s, std::int64_t samples, const std::vector<S>& initial,
             const MakeStepper<S>& make) {
  Walk<S> going(scene, t_end_s, initial, make);
  going.run(t_end_s, samples);
  going.path.steps = going.stepper->steps;
  going.path.evaluations = going.stepper->evaluations;
  return std::move(going.path);
}

template Path<double> walk(const Scene&, double, std::int64_t, const std::vector<double>&, const MakeStepper<double>&);
template Path<Wide> walk(const Scene&, double, std::int64_t, const std::vector<Wide>&, const MakeStepper<Wide>&);

}  // namespace atwood::extended
