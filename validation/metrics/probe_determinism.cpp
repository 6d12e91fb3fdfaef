// Determinism: a run repeated, and repeated by other numbers of threads, has the same bits.
#define XXH_INLINE_ALL
#include <xxhash.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "protocol/method.hpp"
#include "validation/metrics/probe_parts.hpp"

namespace atwood::metrics {
namespace {

constexpr std::int64_t kThreads[] = {1, 2, 4, 16};

// All state of a sample, in fixed order: instant, bodies, particles, joints, ropes.
void append_state(const SampleView& sample, std::vector<Wide>& state) {
  const auto append = [&](const auto& values) { state.insert(state.end(), values.begin(), values.end()); };
  state.push_back(sample.t_s);
  for (const BodySample& b : sample.bodies) {
    append(b.p_m);
    append(b.q_wxyz);
    append(b.v_m_per_s);
    append(b.w_rad_per_s);
  }
  for (const ParticleSample& p : sample.particles) {
    append(p.p_m);
    append(p.v_m_per_s);
    append(std::array{p.density_kg_per_m3, p.pressure_Pa, p.temperature_K});
  }
  for (const JointSample& j : sample.joints) {
    append(j.q);
    append(j.u);
  }
  for (const RopeSample& r : sample.ropes) append(r.pulley_angle_rad);
}

// Of the samples from number `from` on.
std::vector<Wide> state_of(const SampleSeries& samples, std::size_t from = 0) {
  std::vector<Wide> state;
  for (std::size_t k = from; k < samples.size(); ++k) append_state(samples[k], state);
  for (Wide& x : state)
    if (x != x) x = Wide(std::nan(""));  // a value that is not reported: one bit pattern
  return state;
}

bool same_bits(const Wide& a, const Wide& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

std::size_t differences(const std::vector<Wide>& a, const std::vector<Wide>& b) {
  std::size_t count = std::max(a.size(), b.size()) - std::min(a.size(), b.size());
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) count += same_bits(a[i], b[i]) ? 0 : 1;
  return count;
}

// By xxHash (XXH64). The upper 48 of its 64 bits: an integer that a double holds.
double hash_of(const std::vector<Wide>& state) {
  return static_cast<double>(XXH64(state.data(), state.size() * sizeof(Wide), 0) >> 16);
}

}  // namespace

// The method as it is named, twice; one that names a number of threads also with each of 1, 2, 4 and 16.
std::vector<Row> probe_determinism(const ProbeRequest& request) {
  const Scene& scene = request.scenario.scene;
  const Recording first = good_run(request, scene, request.plan);
  const std::vector<Wide> state = state_of(first.values);
  std::vector<std::string> methods = {request.method};
  MethodId id = parse_method_id(request.method);
  if (id.overrides.contains("threads"))
    for (const std::int64_t threads : kThreads) {
      id.overrides["threads"] = threads;
      methods.push_back(to_string(id));
    }
  std::size_t most = 0;
  std::string reason = std::to_string(methods.size()) + " more runs, " + std::to_string(state.size()) + " numbers each";
  for (const std::string& method : methods) {
    const std::size_t count = differences(state, state_of(good_run(request, method, scene, request.plan).values));
    if (count > most) reason = method + " differs from the first run of " + request.method;
    most = std::max(most, count);
  }
  return {row("state-differences", static_cast<double>(most), 0, reason),
          row("state-hash", hash_of(state_of(first.values, first.values.size() - 1)))};
}

}  // namespace atwood::metrics
