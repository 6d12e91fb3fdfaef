#include "benchmarks/stopwatch.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <limits>

#include "scene/files.hpp"
#include "validation/metrics/order_statistics.hpp"

namespace atwood {

double median_time(std::vector<double> seconds) {
  std::erase_if(seconds, [](double value) { return !std::isfinite(value); });
  return seconds.empty() ? std::numeric_limits<double>::quiet_NaN() : metrics::median_in_place(seconds);
}

double clock_rate_ghz() {
  constexpr int length = 20000;
  double shortest_ns = std::numeric_limits<double>::infinity();
  for (int pass = 0; pass < 5; ++pass) {
    const auto begun = std::chrono::steady_clock::now();
    std::uint64_t x = static_cast<std::uint64_t>(begun.time_since_epoch().count());
    for (int i = 0; i < length; ++i) x = x * 6364136223846793005u + 1442695040888963407u;
    volatile std::uint64_t kept = x;
    static_cast<void>(kept);
    const std::chrono::duration<double, std::nano> taken = std::chrono::steady_clock::now() - begun;
    shortest_ns = std::min(shortest_ns, taken.count());
  }
  return 4 * length / shortest_ns;
}

namespace {

// How often the system took the processor away from this process, and how long it waited for one; 0 and NaN where the
// system does not say.
struct Waits {
  std::int64_t times = 0;
  double seconds = std::numeric_limits<double>::quiet_NaN();
};
Waits waits_of(pid_t process) {
  Waits waits;
  const std::string folder = "/proc/" + std::to_string(process);
  std::ifstream status(folder + "/status");
  const std::string name = "nonvoluntary_ctxt_switches:";
  for (std::string line; std::getline(status, line);)
    if (line.starts_with(name)) waits.times = std::stoll(line.substr(name.size()));
  std::int64_t run_ns = 0, wait_ns = 0;
  if (std::ifstream(folder + "/schedstat") >> run_ns >> wait_ns) waits.seconds = 1e-9 * static_cast<double>(wait_ns);
  return waits;
}

}  // namespace

bool pinned(const std::string& method) { return method.find("threads") == std::string::npos; }

WorkerClient& Stopwatch::client(const Contender& contender) {
  const bool pin = pinned(contender.method);
  std::unique_ptr<WorkerClient>& held = clients_[{contender.worker->path, pin}];
  if (!held) held = std::make_unique<WorkerClient>(*contender.worker, pin);
  return *held;
}

double Stopwatch::seconds(const Contender& contender) {
  constexpr int max_attempts = 3;
  constexpr double long_s = 0.05, long_wait = 0.01;  // a long run is interrupted on any machine
  double taken_s = 0;
  for (int attempt = 1; attempt <= max_attempts; ++attempt) {
    const pid_t process = client(contender).process_id();
    const Waits before = process > 0 ? waits_of(process) : Waits{};
    taken_s = once(contender);
    ++machine_.timings;
    if (process == 0 || client(contender).process_id() != process) break;
    const Waits after = waits_of(process);
    if (after.times == before.times) break;
    if (taken_s >= long_s && after.seconds - before.seconds <= long_wait * taken_s) break;
    ++machine_.interrupted;
    if (attempt == max_attempts || !(contender.expected_s < long_s)) break;
    ++machine_.repeated;
  }
  return taken_s;
}

double Stopwatch::once(const Contender& contender) {
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
    const double ghz = clock_rate_ghz();
    if (!(machine_.ghz_low <= ghz)) machine_.ghz_low = ghz;
    if (!(machine_.ghz_high >= ghz)) machine_.ghz_high = ghz;
    for (const Contender& contender : contenders)
      times.back().push_back(round < contender.most_rounds ? seconds(contender)
                                                           : std::numeric_limits<double>::quiet_NaN());
  }
  return times;
}

}  // namespace atwood
