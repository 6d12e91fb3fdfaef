// The two interfaces of odeint's steppers with error control. The including file includes Boost's headers.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "odeint/catalogue.hpp"

namespace atwood::odeint {

inline constexpr std::int64_t kMaxTrials = 2000000;  // per run

[[noreturn]] inline void refuse_equal_steps() {
  throw stepping::Failure(Status::unsupported, "this stepper has error control: expected a tolerance, as in `:1e-8`");
}

// try_step(system, x, t, dt): t and x change when the step is accepted, dt becomes the next step size in any case. The
// last step before a sample is cut to end there; after it the step size before the cut is used again.
template <class S, class Controlled, class TheSystem, class State> class ByTrial : public stepping::Stepper<S> {
 public:
  ByTrial(TheSystem system, Controlled controlled, std::size_t size, S h_s)
      : system_(std::move(system)), controlled_(std::move(controlled)), x_(size), dt_(h_s) {}
  void step(S, S, std::vector<S>&) override { refuse_equal_steps(); }
  std::int64_t advance(S t_s, S to_s, std::vector<S>& y) override {
    std::copy(y.begin(), y.end(), x_.begin());
    std::int64_t steps = 0;
    const S near = 4 * std::numeric_limits<S>::epsilon() * std::fabs(to_s);
    while (to_s - t_s > near) {
      if (++trials_ > kMaxTrials) throw stepping::Failure(Status::diverged, "more than 2000000 trial steps");
      const bool cut = t_s + dt_ > to_s;
      S dt = cut ? to_s - t_s : dt_;
      const bool done = controlled_.try_step(system_, x_, t_s, dt) == boost::numeric::odeint::success;
      if (done) ++steps;
      if (!cut || !done || dt > dt_) dt_ = dt;
      if (!(dt_ > 0) || !std::isfinite(dt_))
        throw stepping::Failure(Status::diverged, "the step became " + format_double(static_cast<double>(dt_)));
    }
    std::copy(x_.begin(), x_.end(), y.begin());
    return steps;
  }

 private:
  TheSystem system_;
  Controlled controlled_;
  State x_;
  S dt_;
  std::int64_t trials_ = 0;
};

// initialize(x, t, dt), do_step(system) until the sample is passed, calc_state(t, x): interpolation.
template <class S, class Dense, class TheSystem, class State> class ByDenseOutput : public stepping::Stepper<S> {
 public:
  ByDenseOutput(TheSystem system, Dense dense, const std::vector<S>& y, S h_s)
      : system_(std::move(system)), dense_(std::move(dense)), x_(y.size()) {
    std::copy(y.begin(), y.end(), x_.begin());
    dense_.initialize(x_, S(0), h_s);
  }
  void step(S, S, std::vector<S>&) override { refuse_equal_steps(); }
  std::int64_t advance(S, S to_s, std::vector<S>& y) override {
    std::int64_t steps = 0;
    while (dense_.current_time() < to_s) {
      if (++trials_ > kMaxTrials) throw stepping::Failure(Status::diverged, "more than 2000000 steps");
      dense_.do_step(system_);
      ++steps;
    }
    dense_.calc_state(to_s, x_);
    std::copy(x_.begin(), x_.end(), y.begin());
    return steps;
  }

 private:
  TheSystem system_;
  Dense dense_;
  State x_;
  std::int64_t trials_ = 0;
};

template <class S, class State = std::vector<S>, class TheSystem, class Controlled>
std::unique_ptr<stepping::Stepper<S>> by_trial(TheSystem system, Controlled controlled, const std::vector<S>& y,
                                               S h_s) {
  return std::make_unique<ByTrial<S, Controlled, TheSystem, State>>(std::move(system), std::move(controlled), y.size(),
                                                                    h_s);
}
template <class S, class State = std::vector<S>, class TheSystem, class Dense>
std::unique_ptr<stepping::Stepper<S>> by_dense_output(TheSystem system, Dense dense, const std::vector<S>& y, S h_s) {
  return std::make_unique<ByDenseOutput<S, Dense, TheSystem, State>>(std::move(system), std::move(dense), y, h_s);
}

}  // namespace atwood::odeint
