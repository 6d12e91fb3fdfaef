#include "benchmarks/fluid_budget.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "benchmarks/fluid_scene.hpp"
#include "benchmarks/stopwatch.hpp"
#include "scene/files.hpp"
#include "validation/metrics/fluid.hpp"
#include "validation/study/process.hpp"
#include "validation/study/worker_client.hpp"

namespace atwood {
namespace {

constexpr std::array<double, 2> kFrames_ms{16.7, 40};
constexpr std::int64_t kSteps = 24;
constexpr int kPasses = 5;
constexpr double kMaxParticles = 400'000;  // what one message of the worker protocol holds
constexpr double kFluidCloseness = 1.05;   // the search ends when the smallest N beyond the budget is so much larger

struct BlockTime {
  double ms = std::nan("");  // a step: the median of the passes' means
  double evaluations = 0;    // a step
  double neighbours = std::nan("");
  std::string why;  // why there is no figure
  bool crashed = false;
};

class FluidBudget {
 public:
  FluidBudget(const Worker& worker, const std::string& method, int dimensions, const FrameBudgetSetup& setup)
      : worker_(worker), method_(method), dimensions_(dimensions), setup_(setup), client_(worker, pinned(method)) {}

  // Particles along an axis of the largest block within each frame; 0: not even the smallest.
  std::array<int, 2> largest() {
    int n = kMinCells;
    while (count(n) <= kMaxParticles && block(n).ms <= kFrames_ms.back()) n = std::max(n + 1, n * 3 / 2);
    std::array<int, 2> found{};
    for (std::size_t f = 0; f < kFrames_ms.size(); ++f) found[f] = between(kFrames_ms[f]);
    return found;
  }
  double count(int across) const { return std::pow(across, dimensions_); }
  const BlockTime& block(int across) {
    const auto [at, fresh] = blocks_.try_emplace(across);
    if (fresh) at->second = measure(across);
    return at->second;
  }
  const std::string& why() { return block(kMinCells).why; }
  bool crashed() const {
    return std::any_of(blocks_.begin(), blocks_.end(), [](const auto& block) { return block.second.crashed; });
  }
  // Whether the search ended at its own limit and not at the budget.
  bool may_be_larger(int across) const { return across > 0 && blocks_.upper_bound(across) == blocks_.end(); }

 private:
  static constexpr int kMinCells = 8;

  BlockTime measure(int across) {
    setup_.notice(fmt::format("{} with {:.0f} particles", method_, count(across)));
    const Scene scene = fluid_block(dimensions_, across);
    const Plan plan{fluid_block_step_s(across) * kSteps, kSteps, 1};
    const Outcome outcome =
        client_.run(method_, scene_to_json(scene), sampled_bodies(scene), plan, kPasses, setup_.limit_s).outcome;
    BlockTime time;
    if (outcome.status != Status::ok) time.why = to_string(outcome.status) + ": " + outcome.reason;
    time.crashed = outcome.status == Status::crashed;
    if (!time.why.empty() || outcome.busy_ns.empty()) return time;
    std::vector<double> ms;
    for (const std::int64_t ns : outcome.busy_ns) ms.push_back(1e-6 * static_cast<double>(ns) / kSteps);
    time.ms = median_time(ms);
    time.evaluations = static_cast<double>(outcome.rate_evaluations) / kSteps;
    const double support = kernel_support_m(response_settings(worker_, parse_method_id(method_)), 1.0 / across);
    if (support > 0) time.neighbours = mean_neighbours(scene.domain, scene.fluids[0].particles.position_m, support);
    return time;
  }

  int between(double budget_ms) {
    int low = 0, high = 0;
    for (const auto& [n, time] : blocks_) {
      if (time.ms <= budget_ms) low = std::max(low, n);
    }
    const auto next = blocks_.upper_bound(low);
    if (low == 0 || next == blocks_.end()) return low;
    for (high = next->first; high > low + 1 && count(high) > kFluidCloseness * count(low);) {
      const int middle = (low + high) / 2;
      (block(middle).ms <= budget_ms ? low : high) = middle;
    }
    return low;
  }

  const Worker& worker_;
  const std::string method_;
  const int dimensions_;
  const FrameBudgetSetup& setup_;
  WorkerClient client_;
  std::map<int, BlockTime> blocks_;
};

struct Entry {
  const Worker* worker;
  std::string method;
};

std::vector<Entry> entries(const FrameBudgetSetup& setup) {
  std::vector<Entry> all;
  for (const Worker& worker : setup.workers) {
    if (worker.status != Status::ok || !worker.engine.fluids) continue;
    const std::string& name = worker.engine.name;
    std::vector<std::string> methods;
    if (!setup.methods.empty()) {
      for (const std::string& method : setup.methods)
        if (method.substr(0, method.find('/')) == name && steps_fluids(method, setup.workers))
          methods.push_back(method);
    } else if (name == "atwood") {
      methods = {"atwood/rk4+sph", "atwood/rk4+sph{threads=2}", "atwood/rk4+polynomial{degree=2}"};
    } else {
      for (const MethodInfo& info : worker.engine.methods) methods.push_back(info.id);
    }
    for (const std::string& method : methods) all.push_back({&worker, method});
  }
  return all;
}

BenchTable empty_table() {
  return {
      "fluid-budget",
      "Frame budget of fluids: the largest block of particles whose step fits a frame",
      {"method", "dimensions", "N in 16.7 ms", "ms", "N in 40 ms", "ms", "neighbours", "ns a particle and evaluation"},
      {},
      {fmt::format("A periodic block of vortices, {} steps of a quarter of the time of sound from particle to "
                   "particle; ms a step: the median of {} passes' means, lists of neighbours included. N is found "
                   "by bisection to {:.0f} %.",
                   kSteps, kPasses, 100 * (kFluidCloseness - 1)),
       "neighbours: particles within the support of the method's kernel, the mean of the block; -: the engine does "
       "not say what its kernel is."}};
}

void add_row(FluidBudget& measured, const std::string& method, int dimensions, BenchTable& table) {
  const std::string shape = fmt::format("{}-D", dimensions);
  const std::array<int, 2> n = measured.largest();
  if (!measured.why().empty()) {
    const double none = std::nan("");
    table.rows.push_back(
        {method, shape, measured.why().substr(0, measured.why().find(": ")), none, none, none, none, none});
    table.notes.push_back(fmt::format("{}, {}: {}", method, shape, measured.why()));
    return;
  }
  const auto ms = [&](int across) { return across > 0 ? measured.block(across).ms : std::nan(""); };
  const BlockTime last = n[1] > 0 ? measured.block(n[1]) : BlockTime{};
  table.rows.push_back({method, shape, n[0] > 0 ? measured.count(n[0]) : 0, ms(n[0]),
                        n[1] > 0 ? measured.count(n[1]) : 0, ms(n[1]), last.neighbours,
                        1e6 * last.ms / (measured.count(n[1]) * last.evaluations)});
  if (measured.may_be_larger(n[1]))
    table.notes.push_back(
        fmt::format("{}, {}: N may be larger: the search ends at {:.0f} particles", method, shape, kMaxParticles));
}

}  // namespace

bool steps_fluids(const std::string& method, const std::vector<Worker>& workers) {
  const std::string engine = method.substr(0, method.find('/'));
  if (engine == "atwood")
    return method.find("+sph") != std::string::npos || method.find("+polynomial") != std::string::npos;
  return std::any_of(workers.begin(), workers.end(), [&](const Worker& worker) {
    return worker.status == Status::ok && worker.engine.name == engine && worker.engine.fluids;
  });
}

FrameBudgetTables measure_fluid_budget(const FrameBudgetSetup& setup) {
  BenchTable table = empty_table();
  FrameBudgetTables result;
  try {
    for (const int dimensions : {2, 3})
      for (const Entry& entry : entries(setup)) {
        FluidBudget measured(*entry.worker, entry.method, dimensions, setup);
        add_row(measured, entry.method, dimensions, table);
        result.failed = result.failed || measured.crashed();
      }
  } catch (const Interrupted&) {
    result.interrupted = true;
  }
  if (!table.rows.empty()) result.tables.push_back(table);
  return result;
}

}  // namespace atwood
