#include "reports/command_line/stopwatch.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "scene/files.hpp"

namespace atwood {

double median(std::vector<double> values) {
  std::erase_if(values, [](double value) { return !std::isfinite(value); });
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return n % 2 == 1 ? values[n / 2] : (values[n / 2 - 1] + values[n / 2]) / 2;
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
  if (outcome.status != Status::ok || outcome.busy_ns.empty()) return std::numeric_limits<double>::quiet_NaN();
  // Sampling may cost some evaluations more; half of them is another run, or a worker that is not well.
  const double counted = static_cast<double>(outcome.rate_evaluations);
  if (contender.evaluations > 0 && counted > 0 && counted < 0.5 * contender.evaluations)
    return std::numeric_limits<double>::quiet_NaN();
  std::vector<double> values;
  for (const std::int64_t ns : outcome.busy_ns) values.push_back(1e-9 * static_cast<double>(ns));
  return median(values);
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
