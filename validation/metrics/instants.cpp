#include "validation/metrics/instants.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "validation/metrics/joints.hpp"
#include "validation/metrics/measurements.hpp"

namespace atwood {
namespace {

constexpr std::int64_t kMaxShared = 256, kMaxSharedOfMechanism = 128, kMaxTimesOwn = 4, kMaxStates = 16384;
constexpr std::int64_t kJudged = 64;

bool is_integrated(TruthKind kind) { return kind == TruthKind::extended || kind == TruthKind::cvode; }

bool judges_instants(const Scenario& scenario) {
  if (!scenario.scene.fluids.empty() || !scenario.frame_ends_s.empty() || scenario.samples < 1) return false;
  return is_integrated(scenario.truth.kind) || scenario.truth.kind == TruthKind::closed_form ||
         metrics::declares_energy(scenario);
}

int different_primes(std::int64_t n) {
  int count = 0;
  for (std::int64_t p = 2; p * p <= n; ++p) {
    if (n % p != 0) continue;
    ++count;
    while (n % p == 0) n /= p;
  }
  return count + (n > 1 ? 1 : 0);
}

// Of a sample what is judged between the own ones.
Sample state_of(const SampleView& sample) {
  Sample state = copy_of(sample);
  state.contacts.clear();
  state.ropes.clear();
  return state;
}

Truth without_samples(const Truth& truth) {
  return {truth.source, {}, {}, truth.events, truth.event_bar_s, truth.condition, truth.note, truth.outcome};
}

}  // namespace

std::int64_t shared_samples(const Scenario& scenario) {
  const std::int64_t own = scenario.samples;
  if (!judges_instants(scenario)) return own;
  std::int64_t divisor = 0;
  for (const std::int64_t steps : scenario.steps) divisor = std::gcd(divisor, steps);
  const bool dear = has_mechanism(scenario.scene) && is_integrated(scenario.truth.kind);
  const std::int64_t most = std::max(dear ? kMaxSharedOfMechanism : kMaxShared, kMaxTimesOwn * own);
  const std::int64_t bodies = std::max<std::int64_t>(1, static_cast<std::int64_t>(scenario.scene.bodies.size()));
  std::int64_t best = own;
  for (std::int64_t n = 2 * own; n <= most && n * bodies <= kMaxStates; n += own)
    if (divisor % n == 0 && different_primes(n) >= different_primes(best)) best = n;
  return best;
}

std::int64_t shared_samples(const Scenario& scenario, std::int64_t divisor) {
  return std::gcd(shared_samples(scenario), divisor);
}

bool may_share(std::int64_t samples, std::int64_t shared) {
  return samples > 0 && shared % samples == 0 && shared <= std::max(kMaxShared, kMaxTimesOwn * samples);
}

std::vector<std::int64_t> judged_instants(std::int64_t samples, std::int64_t shared) {
  constexpr double golden = 0.6180339887498949;
  const std::int64_t n = std::max(kJudged, samples);
  std::vector<std::int64_t> judged;
  if (shared < 2 * n) {
    for (std::int64_t k = 1; k <= shared; ++k) judged.push_back(k);
    return judged;
  }
  const double part = static_cast<double>(shared) / static_cast<double>(n);
  for (std::int64_t i = 0; i < n; ++i) {
    const double turn = golden * static_cast<double>(i + 1);
    judged.push_back(1 + static_cast<std::int64_t>((static_cast<double>(i) + turn - std::floor(turn)) * part));
  }
  return judged;
}

Recording with_instants(Recording run, std::int64_t samples, std::int64_t shared) {
  if (shared == samples) return run;
  const std::int64_t each = shared / samples;
  const bool whole = run.outcome.status == Status::ok && run.values.size() == static_cast<std::size_t>(shared) + 1;
  Recording kept{{}, std::move(run.events), std::move(run.outcome)};
  for (std::size_t k = 0; k < run.values.size(); k += static_cast<std::size_t>(each))
    kept.values.push_back(run.values[k]);
  if (!whole) return kept;
  kept.shared = shared;
  for (const std::int64_t k : judged_instants(samples, shared))
    if (k % each != 0) kept.between.push_back(state_of(run.values[static_cast<std::size_t>(k)]));
  return kept;
}

const Truth& at_samples(const Truth& truth, std::size_t samples, std::optional<Truth>& fewer) {
  if (truth.values.size() <= samples + 1 || samples == 0 || (truth.values.size() - 1) % samples != 0) return truth;
  const std::size_t each = (truth.values.size() - 1) / samples;
  fewer = without_samples(truth);
  for (std::size_t k = 0; k < truth.values.size(); k += each) fewer->values.push_back(truth.values[k]);
  for (std::size_t k = 0; k < truth.bars.size(); k += each) fewer->bars.push_back(truth.bars[k]);
  return *fewer;
}

Observed observed_of(Recording run, Truth truth, std::vector<bool> judged) {
  auto kept_run = std::make_shared<const Recording>(std::move(run));
  auto kept_truth = std::make_shared<const Truth>(std::move(truth));
  return {kept_run, kept_truth, *kept_run, *kept_truth, std::move(judged)};
}

Observed observed(const Truth& truth, const Recording& run) {
  const std::size_t own = run.values.size() - 1;
  const auto shared = static_cast<std::size_t>(run.shared);
  if (run.between.empty() || shared <= own) {
    std::optional<Truth> fewer;
    const std::vector<bool> judged(own + 1, true);
    if (&at_samples(truth, own, fewer) == &truth) return {nullptr, nullptr, run, truth, judged};
    const auto kept = std::make_shared<const Truth>(std::move(*fewer));
    return {nullptr, kept, run, *kept, judged};
  }
  const std::size_t each = shared / own, finer = truth.values.empty() ? 0 : (truth.values.size() - 1) / shared;
  const bool known = finer > 0 && truth.values.size() == finer * shared + 1;
  Recording seen{{}, run.events, run.outcome};
  Truth known_at = without_samples(truth);
  std::vector<bool> counted;
  const std::vector<std::int64_t> judged = judged_instants(static_cast<std::int64_t>(own), run.shared);
  std::size_t next = 0, between = 0;
  for (std::size_t k = 0; k <= shared; ++k) {
    const bool counts = k == 0 || (next < judged.size() && judged[next] == static_cast<std::int64_t>(k));
    if (counts && k > 0) ++next;
    if (k % each != 0 && !counts) continue;
    seen.values.push_back(k % each == 0 ? run.values[k / each] : run.between.at(between++));
    counted.push_back(counts);
    if (!known) continue;
    known_at.values.push_back(truth.values[k * finer]);
    if (k * finer < truth.bars.size()) known_at.bars.push_back(truth.bars[k * finer]);
  }
  return observed_of(std::move(seen), std::move(known_at), std::move(counted));
}

}  // namespace atwood
