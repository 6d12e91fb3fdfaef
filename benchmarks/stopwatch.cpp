#include "benchmarks/stopwatch.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "scene/files.hpp"
#include "validation/metrics/order_statistics.hpp"

namespace atwood {

double median_time(std::vector<double> seconds) {
  std::erase_if(seconds, [](double value) { return !std::isfinite(value); });
  return seconds.empty() ? std::numeric_limits<double>::quiet_NaN() : metrics::median_in_place(seconds);
}

bool pinned(const std::string& method) { return method.find("threads") == std::string::npos; }

WorkerClient& Stopwatch::client(const Contender& contender) {
  const bool pin = pinned(contender.method);
  std::unique_ptr<WorkerClient>& held = clients_[{contender.worker->path, pin}];
  if (!held) held = std::make_unique<WorkerClient>(contender.worker->command, pin, contender.worker->foreign);
  return *held;
}

double Stopwatch::seconds(const Contender& contender) {
  constexpr double burst_s = 2e-3;
  const double expected_s = contender.expected_s > 0 ? contender.expected_s : burst_s;
  const int repeats = static_cast<int>(std::clamp(burst_s / expected_s, 1.0, 99.0));
  const Outcome outcome = client(contender)
                              .run(contender.method, scene_to_json(*contender.scene), sampled_bodies(*contender.scene),
                                   contender.plan, repeats, limit_s_ * repeats)
                              .outcome;
  const bool timed = outcome.status == Status::ok && !outcome.busy_ns.empty();
  if (!timed || outcome.busy_ns.back() < 0) return std::numeric_limits<double>::quiet_NaN();  // below 0: WebAssembly
  // Sampling may need some more evaluations; a difference of half of them shows another run or a failing worker.
  const double counted = static_cast<double>(outcome.rate_evaluations);
  if (contender.evaluations > 0 && counted > 0 && counted < 0.5 * contender.evaluations)
    return std::numeric_limits<double>::quiet_NaN();
  std::vector<double> values;
  for (const std::int64_t ns : outcome.busy_ns) values.push_back(1e-9 * static_cast<double>(ns));
  return median_time(values);
}

std::vector<std::vector<double>> Stopwatch::in_turns(const std::vector<Contender>& contenders, int rounds) {
  std::vector<std::vector<double>> times;
  for (int round = 0; round < rounds; ++round) {
    times.emplace_back();
    for (const Contender& contender : contenders) times.back().push_back(seconds(contender));
  }
  return times;
}

}  // namespace atwood
