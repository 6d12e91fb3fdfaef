#include "extrapolation.hpp"

#include <algorithm>

namespace atwood::fuzz {
namespace {

constexpr int columns = 16;  // of the extrapolation: order 2 columns
constexpr int most_steps = 20'000;

// Scales each component by the largest absolute value of its kind so far.
void widen_scale(State& scale, const State& y, const std::vector<int>& kind) {
  std::vector<Long> most(static_cast<std::size_t>(kind.back() + 1));
  for (std::size_t i = 0; i < y.size(); ++i) {
    Long& of = most[static_cast<std::size_t>(kind[i])];
    of = std::max({of, Long(abs(y[i])), scale[i]});
  }
  for (std::size_t i = 0; i < y.size(); ++i) scale[i] = most[static_cast<std::size_t>(kind[i])];
}

}  // namespace

// Gragg's modified midpoint rule with 2, 4, ..., 2 columns substeps: Hairer, Norsett and Wanner, Solving Ordinary
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
  for (int j = 1; j <= columns; ++j) {
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
    const Long off = abs(row[columns - 1][i] - row[columns - 2][i]);
    if (!(off <= scale[i] * 1e300)) made.error = 1;  // not finite
    else if (scale[i] > 0) made.error = std::max(made.error, Long(off / scale[i]));
  }
  made.y = std::move(row.back());
  return made;
}

std::vector<State> solve(const Rate& f, const State& start, const std::vector<int>& kind,
                         const std::vector<Long>& times_s, int digits) {
  const Long asked = pow(Long(10), -digits);
  State y = start, scale(y.size());
  widen_scale(scale, y, kind);
  std::vector<State> at{y};
  Long t = times_s.front(), length = times_s.size() > 1 ? Long(times_s[1] - t) : Long(0);
  int steps = 0;
  for (std::size_t k = 1; k < times_s.size(); ++k) {
    const Long target = times_s[k];
    while (t < target) {
      if (++steps > most_steps) return {};
      const Long H = std::min(length, Long(target - t));
      // Components that are 0 at the start get their scale from a first attempt of the step.
      State wider = scale;
      widen_scale(wider, midpoints(f, t, y, H, 2), kind);
      Step step = extrapolate(f, t, y, H, wider);
      if (step.error > asked) {
        length = H / 2;
        continue;
      }
      t = H == target - t ? target : Long(t + H);
      y = std::move(step.y);
      widen_scale(scale, y, kind);
      if (step.error < asked / 10000) length = std::max(length, Long(H * 1.25));
    }
    at.push_back(y);
  }
  return at;
}

std::vector<Long> sample_times(double t_end_s, std::int64_t samples) {
  std::vector<Long> made;
  for (std::int64_t k = 0; k <= samples; ++k) made.push_back(Long(t_end_s) * k / samples);
  return made;
}

}  // namespace atwood::fuzz
