#include "extrapolation.hpp"

#include <algorithm>

namespace atwood::fuzz {
namespace {

constexpr int kColumns = 16;  // of the extrapolation: order 2 kColumns

}  // namespace

// Gragg's modified midpoint rule with 2, 4, ..., 2 kColumns substeps: Hairer, Norsett and Wanner, Solving Ordinary
// Differential Equations I, section II.9.

State midpoints(const Rate& f, const Long& t_s, const State& y, const Long& H, int substeps) {
  const Long h = H / substeps;
  State before = y, now = y, slope(y.size());
  f(t_s, y, slope);
  for (std::size_t i = 0; i < y.size(); ++i) now[i] += h * slope[i];
  for (int m = 1; m < substeps; ++m) {
    f(t_s + m * h, now, slope);
    for (std::size_t i = 0; i < y.size(); ++i) {
      const Long after = before[i] + 2 * h * slope[i];
      before[i] = now[i];
      now[i] = after;
    }
  }
  f(t_s + H, now, slope);
  for (std::size_t i = 0; i < y.size(); ++i) now[i] = (before[i] + now[i] + h * slope[i]) / 2;
  return now;
}

Step extrapolate(const Rate& f, const Long& t_s, const State& y, const Long& H, const State& scale) {
  std::vector<State> row;
  Step made;
  for (int j = 1; j <= kColumns; ++j) {
    std::vector<State> next{midpoints(f, t_s, y, H, 2 * j)};
    for (int k = 1; k < j; ++k) {
      const Long ratio = Long(j * j) / Long((j - k) * (j - k)) - 1;
      State value = next[k - 1];
      for (std::size_t i = 0; i < y.size(); ++i) value[i] += (next[k - 1][i] - row[k - 1][i]) / ratio;
      next.push_back(std::move(value));
    }
    row = std::move(next);
  }
  made.error = 0;
  for (std::size_t i = 0; i < y.size(); ++i) {
    const Long off = abs(row[kColumns - 1][i] - row[kColumns - 2][i]);
    if (!(off <= scale[i] * 1e300)) made.error = 1;  // not finite
    else if (scale[i] > 0) made.error = std::max(made.error, Long(off / scale[i]));
  }
  made.y = std::move(row.back());
  return made;
}

Integration::Integration(const Rate& f, const State& start, const std::vector<int>& kind, const Long& t_s,
                         const Long& first_step_s, int digits)
    : f_(f), y_(start), scale_(start.size()), kind_(kind), t_s_(t_s), step_s_(first_step_s),
      asked_(pow(Long(10), -digits)) {
  widen_scale(scale_, y_);
}

// Scales each component by the largest absolute value of its kind so far.
void Integration::widen_scale(State& scale, const State& y) const {
  State largest(static_cast<std::size_t>(kind_.back() + 1));
  for (std::size_t i = 0; i < y.size(); ++i) {
    Long& of = largest[static_cast<std::size_t>(kind_[i])];
    of = std::max({of, Long(abs(y[i])), scale[i]});
  }
  for (std::size_t i = 0; i < y.size(); ++i) scale[i] = largest[static_cast<std::size_t>(kind_[i])];
}

bool Integration::advance(const Long& target_s) {
  while (t_s_ < target_s) {
    if (++steps_ > kMaxSteps) return false;
    const Long H = std::min(step_s_, Long(target_s - t_s_));
    // Components that are 0 at the start get their scale from a first attempt of the step.
    State wider = scale_;
    widen_scale(wider, midpoints(f_, t_s_, y_, H, 2));
    Step step = extrapolate(f_, t_s_, y_, H, wider);
    if (step.error > asked_) {
      step_s_ = H / 2;
      continue;
    }
    t_s_ = H == target_s - t_s_ ? target_s : Long(t_s_ + H);
    y_ = std::move(step.y);
    widen_scale(scale_, y_);
    if (step.error < asked_ / 10000) step_s_ = std::max(step_s_, Long(H * 1.25));
  }
  return true;
}

std::vector<State> solve(const Rate& f, const State& start, const std::vector<int>& kind,
                         const std::vector<Long>& times_s, int digits) {
  const Long from = times_s.front();
  Integration integration(f, start, kind, from, times_s.size() > 1 ? Long(times_s[1] - from) : Long(0), digits);
  std::vector<State> at{start};
  for (std::size_t k = 1; k < times_s.size(); ++k) {
    if (!integration.advance(times_s[k])) return {};
    at.push_back(integration.state());
  }
  return at;
}

std::vector<Long> sample_times(double t_end_s, std::int64_t samples) {
  std::vector<Long> made;
  for (std::int64_t k = 0; k <= samples; ++k) made.push_back(Long(t_end_s) * k / samples);
  return made;
}

}  // namespace atwood::fuzz
