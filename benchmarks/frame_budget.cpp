// The largest heap that each engine steps within a frame, and the shares of our engine's phases in its time.
#include "benchmarks/frame_budget.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "benchmarks/fluid_budget.hpp"
#include "benchmarks/stopwatch.hpp"
#include "scene/files.hpp"
#include "scene/split_mix.hpp"
#include "validation/metrics/order_statistics.hpp"
#include "validation/study/process.hpp"
#include "validation/study/worker_client.hpp"

namespace atwood {
namespace {

constexpr int kFramesPerSecond = 60;
constexpr int kSettlingFrames = 90, kMeasuredFrames = 60;  // 1.5 s to fall and come to rest, one second to measure
constexpr std::array<double, 2> kBudgets_ms{16.7, 40};
constexpr int kMinBodies = 16, kMaxBodies = 64000;
constexpr double kCloseness = 1.08;  // the search ends when the smallest N that failed is at most this factor larger

// The scenes settling-N of the catalogue for any number of bodies, with a bin of matching size.
Scene settling_scene(const Scene& like, int count) {
  const auto first = std::find_if(like.bodies.begin(), like.bodies.end(),
                                  [](const Body& body) { return body.mass_kg > 0 && !body.fixed; });
  const auto second = std::find_if(first + 1, like.bodies.end(), [](const Body& body) { return body.mass_kg > 0; });
  const double spacing_m =
      std::round(100 * std::abs(second->position_m[2] - first->position_m[2])) / 100;  // without the jitter
  const int side = static_cast<int>(std::ceil(std::cbrt(count) - 1e-9));
  Scene scene = like;
  std::erase_if(scene.bodies, [](const Body& body) { return body.mass_kg > 0; });
  for (Body& wall : scene.bodies) {
    if (auto* plane = std::get_if<Plane>(&wall.shape); plane != nullptr && plane->normal[2] == 0)
      plane->offset_m = -(spacing_m * side / 2 + 0.05);
  }
  SplitMix64 random{42};
  for (int n = 0; n < count; ++n) {
    Body body = *first;
    body.name = "body." + std::to_string(n);
    const std::array<double, 3> at{(n % side - 0.5 * (side - 1)) * spacing_m,
                                   (n / side % side - 0.5 * (side - 1)) * spacing_m,
                                   spacing_m / 2 + 0.005 + n / side / side * spacing_m};
    for (std::size_t k = 0; k < 3; ++k) body.position_m[k] = at[k] + 0.001 * (2 * random.next_unit() - 1);
    scene.bodies.push_back(std::move(body));
  }
  return scene;
}

struct HeapTime {
  double p95_ms = std::nan("");   // over the steps of the settled heap; infinite: the run exceeded the limit
  double mean_ms = std::nan("");  // over all steps
  std::map<std::string, std::int64_t> phase_ns;
  std::string why;       // why there is no figure
  bool refused = false;  // the engine refuses: a second measurement would not differ
  bool crashed = false;
};

struct Entrant {
  const Worker* worker;
  std::string method;
};

class FrameBudget {
 public:
  FrameBudget(const Entrant& entrant, const Scene& like, const FrameBudgetSetup& setup)
      : entrant_(entrant), like_(like), setup_(setup), client_(*entrant.worker, pinned(entrant.method)) {}

  // Doubles N until both budgets are exceeded, then bisects log N for each budget.
  std::array<int, 2> largest() {
    int n = kMinBodies;
    while (n <= kMaxBodies && holds(n, kBudgets_ms.back())) n *= 2;
    std::array<int, 2> found{};
    for (std::size_t b = 0; b < kBudgets_ms.size(); ++b) found[b] = between(kBudgets_ms[b]);
    return found;
  }

  const HeapTime& heap(int count) {
    const auto [at, fresh] = heaps_.try_emplace(count);
    if (fresh) at->second = measure(count);
    return at->second;
  }

  const std::string& why() { return heap(kMinBodies).why; }
  bool crashed() const {
    return std::any_of(heaps_.begin(), heaps_.end(), [](const auto& heap) { return heap.second.crashed; });
  }

  // Why the search ended above this N where it was not by the budget; empty: by the budget.
  std::string ended_by(int largest_held) const {
    const auto next = heaps_.upper_bound(largest_held);
    if (next == heaps_.end()) return fmt::format("the search ends at {} bodies", kMaxBodies);
    if (std::isinf(next->second.p95_ms))
      return fmt::format("{} bodies were not stepped within --limit {:g} (seconds a run)", next->first, setup_.limit_s);
    return next->second.why.empty() ? "" : fmt::format("{} bodies: {}", next->first, next->second.why);
  }

 private:
  HeapTime measure(int count) {
    setup_.notice(fmt::format("{} with {} bodies", entrant_.method, count));
    Profile profile;
    const std::int64_t steps = kSettlingFrames + kMeasuredFrames;
    const Outcome outcome =
        client_.profile(entrant_.method, scene_to_json(settling_scene(like_, count)),
                        {static_cast<double>(steps) / kFramesPerSecond, steps, 1}, setup_.limit_s, profile);
    HeapTime time;
    time.refused = outcome.status == Status::unsupported;
    time.crashed = outcome.status == Status::crashed;
    if (outcome.status == Status::timeout) time.p95_ms = std::numeric_limits<double>::infinity();
    if (outcome.status != Status::ok) time.why = to_string(outcome.status) + ": " + outcome.reason;
    else if (profile.step_ns.empty())
      time.refused = true, time.why = "the engine does not report the times of its steps";
    if (!time.why.empty()) return time;
    time.p95_ms = 1e-6 * metrics::nearest_rank({profile.step_ns.end() - kMeasuredFrames, profile.step_ns.end()}, 0.95);
    double sum_ns = 0;
    for (const std::int64_t ns : profile.step_ns) sum_ns += static_cast<double>(ns);
    time.mean_ms = 1e-6 * sum_ns / static_cast<double>(steps);
    time.phase_ns = profile.phase_ns;
    return time;
  }

  // Whether N keeps the budget; false for NaN. Other load can spoil a measurement, so a failure is measured again and
  // the better of the two counts.
  bool holds(int count, double budget_ms) {
    if (heap(count).p95_ms <= budget_ms) return true;
    HeapTime& first = heaps_.at(count);
    if (first.refused || !measured_again_.insert(count).second) return false;
    HeapTime second = measure(count);
    if (std::isnan(first.p95_ms) || second.p95_ms < first.p95_ms) first = std::move(second);
    return first.p95_ms <= budget_ms;
  }

  int between(double budget_ms) {
    int low = 0, high = 0;
    do {  // an N measured once for the other budget may be measured a second time here
      for (const auto& [n, time] : heaps_) {
        if (time.p95_ms <= budget_ms) low = std::max(low, n);
      }
      const auto next = heaps_.upper_bound(low);
      high = next == heaps_.end() ? 0 : next->first;
    } while (high > 0 && holds(high, budget_ms));
    if (low == 0 || high == 0) return low;
    while (high > kCloseness * low && high > low + 1) {
      const int middle =
          std::clamp(static_cast<int>(std::lround(std::sqrt(static_cast<double>(low) * high))), low + 1, high - 1);
      (holds(middle, budget_ms) ? low : high) = middle;
    }
    return low;
  }

  const Entrant entrant_;
  const Scene& like_;
  const FrameBudgetSetup& setup_;
  WorkerClient client_;
  std::map<int, HeapTime> heaps_;
  std::set<int> measured_again_;
};

// Our engine with one thread and with two; every other engine with its default settings.
std::vector<Entrant> entrants(const std::vector<Worker>& workers, const std::vector<std::string>& methods) {
  std::vector<Entrant> all;
  const auto add = [&](const std::string& method) {
    const std::string engine = method.substr(0, method.find('/'));
    for (const Worker& worker : workers) {
      if (worker.status == Status::ok && worker.engine.name == engine) return all.push_back({&worker, method});
    }
    throw InputError(fmt::format("--method {}: no available engine is called `{}`", method, engine));
  };
  for (const std::string& method : methods) {
    check_settings("--method ", method, workers);
    if (!steps_fluids(method, workers)) add(method);  // the others are in the table of fluids
  }
  if (!methods.empty()) return all;
  for (const Worker& worker : workers) {
    if (worker.status != Status::ok) continue;
    if (worker.engine.name == "atwood") {
      all.push_back({&worker, "atwood/symplectic-euler+impulse"});
      const auto& responses = worker.engine.responses;
      const bool teams = std::any_of(responses.begin(), responses.end(), [](const MethodInfo& r) {
        return r.id == "+impulse" && r.settings.contains("threads");
      });
      if (teams) all.push_back({&worker, "atwood/symplectic-euler+impulse{threads=2}"});
    }
    const bool world = std::any_of(worker.engine.methods.begin(), worker.engine.methods.end(),
                                   [&](const MethodInfo& m) { return m.id == worker.engine.name + "/default"; });
    if (world) all.push_back({&worker, worker.engine.name + "/default"});
    if (world && worker.engine.name == "ode")
      all.push_back({&worker, "ode/default{step=dWorldQuickStep}"});  // the step function for many bodies
  }
  return all;
}

BenchTable empty_budget() {
  return {"frame-budget",
          "Frame budget: the largest settled heap that an engine steps within a frame",
          {"method", "shape", "N in 16.7 ms", "p95 ms", "N in 40 ms", "p95 ms", "us a body"},
          {},
          {fmt::format("Bodies settle in a bin for {} steps of 1/{} s; the 95th percentile is of the {} "
                       "steps that follow. N is found by bisection to {:.0f} %; an N beyond the budget is "
                       "measured twice, and the better counts.",
                       kSettlingFrames, kFramesPerSecond, kMeasuredFrames, 100 * (kCloseness - 1)),
           "us a body: the mean step of the largest heap, settling included, over N. Every setting of a "
           "method: `atwood list methods`."}};
}

BenchTable empty_phases() {
  return {"phase-shares",
          "Where a step of ours goes: share of its time per phase [%]",
          {"method", "shape", "N", "ms a step", "broad", "narrow", "solve", "integrate", "rest"},
          {},
          {"Mean over all steps of the largest heap within 40 ms, settling included; rest: what no phase claims."}};
}

void add_refused(BenchTable& budget, const Entrant& entrant, const char* shape, const std::string& why) {
  budget.rows.push_back(
      {entrant.method, shape, why.substr(0, why.find(": ")), std::nan(""), std::nan(""), std::nan(""), std::nan("")});
  if (why.rfind("unsupported", 0) != 0) budget.notes.push_back(fmt::format("{}, {}: {}", entrant.method, shape, why));
}

void add_phases(BenchTable& phases, const Entrant& entrant, const char* shape, int bodies, const HeapTime& heap) {
  const double total_ns = 1e6 * heap.mean_ms * (kSettlingFrames + kMeasuredFrames);
  std::vector<TableCell> row{entrant.method, shape, double(bodies), heap.mean_ms};
  double rest = 100;
  for (const char* phase : {"broad", "narrow", "solve", "integrate"}) {
    const auto found = heap.phase_ns.find(phase);
    const double share = found == heap.phase_ns.end() ? 0 : 100 * static_cast<double>(found->second) / total_ns;
    row.emplace_back(share);
    rest -= share;
  }
  row.emplace_back(rest);
  phases.rows.push_back(row);
}

void measure_entrant(FrameBudget& measured, const Entrant& entrant, const char* shape, BenchTable& budget,
                     BenchTable& phases) {
  const std::array<int, 2> n = measured.largest();
  if (!measured.why().empty()) return add_refused(budget, entrant, shape, measured.why());
  for (std::size_t b = 0; b < n.size(); ++b) {
    const std::string end = measured.ended_by(n[b]);
    if (!end.empty())
      budget.notes.push_back(
          fmt::format("{}, {}: N in {} ms may be larger: {}", entrant.method, shape, kBudgets_ms[b], end));
  }
  const auto p95 = [&](int bodies) { return bodies > 0 ? measured.heap(bodies).p95_ms : std::nan(""); };
  const HeapTime last = n[1] > 0 ? measured.heap(n[1]) : HeapTime{};
  budget.rows.push_back(
      {entrant.method, shape, double(n[0]), p95(n[0]), double(n[1]), p95(n[1]), 1e3 * last.mean_ms / n[1]});
  if (!last.phase_ns.empty()) add_phases(phases, entrant, shape, n[1], last);
}

}  // namespace

FrameBudgetTables measure_frame_budget(const FrameBudgetSetup& setup) {
  BenchTable budget = empty_budget(), phases = empty_phases();
  FrameBudgetTables result;
  try {
    for (const auto& [shape, scene] : {std::pair{"spheres", &setup.spheres}, {"boxes", &setup.boxes}}) {
      for (const Entrant& entrant : entrants(setup.workers, setup.methods)) {
        FrameBudget measured(entrant, *scene, setup);
        measure_entrant(measured, entrant, shape, budget, phases);
        result.failed = result.failed || measured.crashed();
      }
    }
  } catch (const Interrupted&) {
    result.interrupted = true;
  }
  if (!budget.rows.empty() || setup.methods.empty()) result.tables.push_back(budget);
  if (!phases.rows.empty()) result.tables.push_back(phases);
  return result;
}

}  // namespace atwood
