#include <algorithm>
#include <cmath>
#include <cstdint>

#include "dynamics/rates.hpp"
#include "extended/extended.hpp"
#include "extended/extrapolation.hpp"
#include "extended/path.hpp"

namespace atwood {

namespace {

using namespace extended;

constexpr double kPerturbation = 1e-9, kNarrowTolerance = 1e-12;
constexpr double kMaxWork = 5e7;  // rate evaluations x components of the state, over all perturbed runs
constexpr int kSignTrials = 8;
constexpr std::int64_t kMostTimesBase = 10, kLeastEvaluations = 1000;

std::size_t events_until(const Path<double>& path, double t_s) {
  return static_cast<std::size_t>(
      std::count_if(path.events.begin(), path.events.end(), [&](const Event& e) { return e.t_s <= t_s; }));
}

// Adds |perturbed - base| / (perturbation x scale) of each sample and component to `growth` (columns), or takes the
// larger of the two (directions of random signs). Samples between an impact of one run and the same impact of the other
// are left out, because they do not measure growth.
void accumulate_growth(RaggedArray<double>& growth, const Path<double>& base, const Path<double>& perturbed,
                       const std::vector<double>& scale, double t_end_s, bool columns) {
  const std::size_t samples = base.states.size() - 1;
  for (std::size_t k = 1; k <= samples && k < perturbed.states.size(); ++k) {
    const double t = t_end_s * static_cast<double>(k) / static_cast<double>(samples);
    if (events_until(base, t) != events_until(perturbed, t)) continue;
    for (std::size_t i = 0; i < scale.size(); ++i) {
      if (scale[i] == 0) continue;
      const double moved = std::fabs(perturbed.states[k][i] - base.states[k][i]) / (kPerturbation * scale[i]);
      growth[k][i] = columns ? growth[k][i] + moved : std::max(growth[k][i], moved);
    }
  }
}

// One bit of SplitMix64 (Steele, Lea and Flood 2014).
double random_sign(std::uint64_t& state) {
  std::uint64_t z = (state += 0x9e3779b97f4a7c15u);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return ((z ^ (z >> 31)) >> 63) != 0 ? 1 : -1;
}

}  // namespace

double flow_condition(const Scene& scene, double t_end_s, std::int64_t samples) {
  const dynamics::Layout layout = dynamics::layout(scene);
  std::vector<int> groups;
  for (const dynamics::Kind kind : layout.kinds) groups.push_back(static_cast<int>(kind));
  const MakeStepper<double> make = [&](Rate<double> rate, Rate<double>) {
    return std::make_unique<Extrapolation<double>>(layout.size, groups, std::move(rate), kNarrowTolerance);
  };
  const std::vector<double> initial = dynamics::pack<double>(scene);
  std::int64_t most = static_cast<std::int64_t>(kMaxWork);
  bool all_ended = true;
  const auto run = [&](const std::vector<double>& from) {
    Path<double> made = integrate_path<double>(scene, t_end_s, samples, from, make, Grid::samples, most);
    all_ended = all_ended && (most == 0 || made.evaluations <= most);
    return made;
  };
  const Path<double> base = run(initial);
  if (!base.failure.empty()) return 0;
  // A perturbed motion may have very many more impacts, as of a ball that is lifted off its floor.
  most = kMostTimesBase * (base.evaluations + kLeastEvaluations);

  const int n = layout.size;
  std::vector<double> of_kind(4, 0.0), scale(n);
  for (std::size_t k = 0; k < base.states.size(); ++k)
    for (int i = 0; i < n; ++i) of_kind[groups[i]] = std::max(of_kind[groups[i]], std::fabs(base.states[k][i]));
  for (int i = 0; i < n; ++i) scale[i] = of_kind[groups[i]];

  RaggedArray<double> growth(base.states.size(), static_cast<std::size_t>(n));
  const double work = static_cast<double>(base.evaluations) * n;
  if (work * n <= kMaxWork) {
    for (int j = 0; j < n; ++j) {
      if (scale[j] == 0) continue;
      std::vector<double> from = initial;
      from[j] += kPerturbation * scale[j];
      accumulate_growth(growth, base, run(from), scale, t_end_s, true);
    }
  } else {
    std::uint64_t seed = 1784;
    for (int trial = 0; trial < kSignTrials; ++trial) {
      std::vector<double> from = initial;
      for (int j = 0; j < n; ++j) from[j] += random_sign(seed) * kPerturbation * scale[j];
      accumulate_growth(growth, base, run(from), scale, t_end_s, false);
    }
  }
  if (!all_ended) return 0;
  double largest = 0;
  for (std::size_t k = 0; k < growth.size(); ++k)
    for (const double value : growth[k]) largest = std::max(largest, value);
  return largest;
}

}  // namespace atwood
