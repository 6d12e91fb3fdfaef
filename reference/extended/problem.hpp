// A system of equations y' = f(t, y), smooth on the stretch over which it is integrated, and the interface of the two
// methods that integrate it.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "protocol/sample.hpp"

namespace atwood::extended {

template <class S> using Rate = std::function<void(S t, const S* y, S* dydt)>;

struct Problem {
  int size = 0;
  std::vector<int> group;  // index of the scale of each component; empty: all share one
  Rate<Wide> rate;
  Rate<double> narrow_rate;  // the same equations in double: the first iterations of collocation use them
};

// A problem from one generic function f(t, const auto* y, auto* dydt), for systems without a scene.
template <class F> Problem problem_of(int size, F f) {
  return {size,
          {},
          [f](Wide t, const Wide* y, Wide* dydt) { f(t, y, dydt); },
          [f](double t, const double* y, double* dydt) { f(t, y, dydt); }};
}

// The largest magnitude of each group of components over the run: errors are relative to it, so that a component that
// passes through zero needs no higher absolute accuracy than the others of its group.
template <class S> class Scale {
 public:
  Scale(int size, std::vector<int> group) : group_(std::move(group)) {
    if (group_.empty()) group_.assign(size, 0);
    int groups = 0;
    for (const int g : group_) groups = g >= groups ? g + 1 : groups;
    largest_.assign(groups, S(0));
  }
  void include(const S* y) {
    for (std::size_t i = 0; i < group_.size(); ++i) {
      const S size = y[i] < 0 ? -y[i] : y[i];
      if (size > largest_[group_[i]]) largest_[group_[i]] = size;
    }
  }
  S of(std::size_t i) const { return largest_[group_[i]] > 0 ? largest_[group_[i]] : S(1); }

 private:
  std::vector<int> group_;
  std::vector<S> largest_;
};

// A step between its ends: the state y and its rate f at the start, in the middle and at the end.
template <class S> struct DenseStep {
  S t{}, span{};
  std::vector<S> y0, f0, ym, fm, y1, f1;
};

// An integrator with step-size control. It keeps its step size between calls; any state may be given to any call.
template <class S> class Stepper {
 public:
  virtual ~Stepper() = default;
  // One accepted step from (t, y) of at most `limit` > 0: y becomes the state after it, and the size of the step is
  // returned. 0: no step was accepted (the motion is singular or not finite); y is unchanged.
  virtual S step(S t, S* y, S limit) = 0;
  // The step that the last call of step() took; its middle comes from the step's own stages.
  virtual DenseStep<S> dense() = 0;
  // From now on errors of each kind are relative to at least these sizes: where a kind's values are round-off alone,
  // errors relative to them would be large at any step.
  virtual void raise_scale(const S* sizes) = 0;
  std::int64_t evaluations = 0, steps = 0;
};

// Where the steps of a run may end. Two runs of which one ends steps at the samples and the other does not share no
// instant but switches, and an event that one of them misses is one on which they disagree.
enum class Grid {
  samples,  // every sample is the end of a step
  free  // a sample's state is integrated from the start of the step that contains it; no step is longer than a share
        // of the time between switches
};

inline constexpr double kFreeShare = 0.2763932022500210;  // of the time between switches: (5 - sqrt 5) / 10
inline constexpr double kShortestSearch = 1e-15;  // of the run: no shorter step is halved to see what happens in it

// Integrates to exactly t + span. False: a step failed; y is then the state reached.
template <class S> bool advance(Stepper<S>& stepper, S t, S* y, S span) {
  S done = 0;
  while (done < span) {
    const S left = span - done;
    const S taken = stepper.step(t + done, y, left);
    if (!(taken > 0)) return false;
    done = taken == left ? span : done + taken;
  }
  return true;
}

}  // namespace atwood::extended
