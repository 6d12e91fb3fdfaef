// Time against the number of bodies: free flight, gravity over all pairs, gravity by a tree, chains of links, loops.
//
//   scaling/free-flight/SCALAR/N, scaling/free-flight-2-threads/SCALAR/N
//       ns_per_step of all N; ns_per_body_step
//   scaling/gravity-pair/N
//       ns_per_step: nanoseconds per interaction, the force of one body on another (N (N - 1) of them);
//       pairs_per_s counts those, unordered_pairs_per_s halves of them, N (N - 1) / 2
//   scaling/gravity-direct/N, scaling/gravity-tree/N (opening 0.5), and -2-threads
//       ns_per_step: one evaluation of all rates
//   scaling/chain-hinges/N, scaling/chain-planar/N
//       ns_per_step: one evaluation of the rates of a chain of N links; ns_per_body_step: of a link
//   scaling/four-bars/N
//       the same of (N - 1) / 2 loops in a row, which are one group of constraints: its factors are dense
//
// Fitted exponents and memory per body are printed to standard error at the end.
#include <benchmark/benchmark.h>
#include <malloc.h>

#include <chrono>
#include <cstdio>
#include <map>

#include "benchmarks/chain_scene.hpp"
#include "benchmarks/free_flight_scene.hpp"
#include "rigid/model.hpp"
#include "simulation.hpp"
#include "smooth/run.hpp"
#include "validation/metrics/metrics.hpp"

namespace {

using namespace atwood;

// The fastest run of each family, by number of bodies.
struct Seen {
  double seconds = 0, bytes = 0;
};
std::map<std::string, std::map<int, Seen>> seen;

void remember(const std::string& family, int bodies, double seconds, double bytes) {
  Seen& now = seen[family][bodies];
  if (now.seconds == 0 || seconds < now.seconds) now.seconds = seconds;
  now.bytes = bytes;
}

double bytes_in_use() {
  const struct mallinfo2 info = mallinfo2();
  return static_cast<double>(info.uordblks) + static_cast<double>(info.hblkhd);
}

// ---- free flight --------------------------------------------------------------------------------------------------
void free_flight(benchmark::State& state, const std::string& family, const std::string& method, int bodies) {
  const Scene scene = free_flight_scene(bodies);
  const std::int64_t steps = std::max<std::int64_t>(64, 200000 / bodies);
  const Plan plan{static_cast<double>(steps) / 1024, steps, 1};
  const MethodId id = parse_method_id(method);
  double bytes = bytes_in_use();
  const auto prepared = prepare<double>(id, scene);
  bytes = bytes_in_use() - bytes;
  const Engine engine = atwood_engine();
  double total_ns = 0, runs = 0;  // short runs, so that the fastest one was not preempted
  for (auto _ : state) {
    const Outcome outcome = engine.run(id, scene, plan, {}, 1);
    if (outcome.status != Status::ok) return state.SkipWithError(outcome.reason.c_str());
    const auto ns = static_cast<double>(outcome.busy_ns.front());
    state.SetIterationTime(ns * 1e-9);
    remember(family, bodies, ns * 1e-9 / static_cast<double>(steps), bytes / bodies);
    total_ns += ns;
    ++runs;
  }
  state.counters["ns_per_step"] = total_ns / runs / static_cast<double>(steps);
  state.counters["ns_per_body_step"] = total_ns / runs / static_cast<double>(steps) / bodies;
  state.counters["bytes_per_body"] = bytes / bodies;
}

void register_free_flight() {
  for (const std::string scalar : {"double", "float"})
    for (const int threads : {1, 2})
      for (const int bodies : {1, 100, 1000, 10000, 100000}) {
        if (bodies < 1000 && threads > 1) continue;
        const std::string family = threads == 1 ? "free-flight/" + scalar : "free-flight-2-threads/" + scalar;
        const std::string method = "atwood/rk4@" + scalar + "{threads=" + std::to_string(threads) + "}";
        benchmark::RegisterBenchmark(("scaling/" + family + "/" + std::to_string(bodies)).c_str(),
                                     [=](benchmark::State& state) { free_flight(state, family, method, bodies); })
            ->UseManualTime()
            ->MinTime(0.02);
      }
}

// ---- gravity ------------------------------------------------------------------------------------------------------
// Point masses uniform in a cube.
Scene cloud(int bodies) {
  Scene scene;
  scene.materials.push_back({"default", 0, 0, 0});
  SplitMix64 random{7};
  MutualGravity gravity;
  gravity.softening_m = 1e-3;
  for (int i = 0; i < bodies; ++i) {
    Body body;
    body.name = "body." + std::to_string(i);
    body.mass_kg = 1;
    for (double& x : body.position_m) x = random.next_unit();
    scene.bodies.push_back(body);
    gravity.bodies.push_back(i);
  }
  scene.forces.push_back(gravity);
  return scene;
}

struct Gravity {
  std::string family;
  int bodies;
  GravityOptions::Sum sum;
  int threads;
  bool per_pair;
};

void gravity(benchmark::State& state, const Gravity& g) {
  const Scene scene = cloud(g.bodies);
  ModelOptions options;
  options.gravity.sum = g.sum;
  options.threads = g.threads;
  double bytes = bytes_in_use();
  RigidModel<double> model(scene, options);
  std::vector<double> y(static_cast<std::size_t>(model.state_size())), rate(y.size());
  bytes = bytes_in_use() - bytes;
  model.initial_state(y.data());
  double total_ns = 0, runs = 0;
  for (auto _ : state) {
    const auto start = std::chrono::steady_clock::now();
    model.system().rate(0, y.data(), rate.data());
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    state.SetIterationTime(seconds);
    remember(g.family, g.bodies, seconds, bytes / g.bodies);
    total_ns += seconds * 1e9;
    ++runs;
  }
  const double ns = total_ns / runs, interactions = static_cast<double>(g.bodies) * (g.bodies - 1);
  state.counters["ns_per_step"] = g.per_pair ? ns / interactions : ns;
  state.counters["ns_per_body_step"] = ns / g.bodies;
  state.counters["bytes_per_body"] = bytes / g.bodies;
  if (g.sum == GravityOptions::Sum::tree) return;
  state.counters["pairs_per_s"] = 1e9 * interactions / ns;
  state.counters["unordered_pairs_per_s"] = 0.5e9 * interactions / ns;
}

void register_gravity(const Gravity& g) {
  benchmark::RegisterBenchmark(("scaling/" + g.family + "/" + std::to_string(g.bodies)).c_str(),
                               [=](benchmark::State& state) { gravity(state, g); })
      ->UseManualTime()
      ->MinTime(0.02);
}

void register_all_gravity() {
  using Sum = GravityOptions::Sum;
  for (const int bodies : {1024, 4096}) register_gravity({"gravity-pair", bodies, Sum::direct, 1, true});
  for (const int bodies : {256, 1024, 4096, 10000}) {
    register_gravity({"gravity-direct", bodies, Sum::direct, 1, false});
    register_gravity({"gravity-direct-2-threads", bodies, Sum::direct, 2, false});
  }
  for (const int bodies : {5000, 10000, 20000, 40000, 80000, 160000, 320000}) {
    register_gravity({"gravity-tree", bodies, Sum::tree, 1, false});
    if (bodies >= 20000) register_gravity({"gravity-tree-2-threads", bodies, Sum::tree, 2, false});
  }
}

// ---- chains of links, loops ---------------------------------------------------------------------------------------
// `batch`: long enough for the clock.
void links_of(benchmark::State& state, const std::string& family, const Scene& scene, int batch) {
  const int links = static_cast<int>(scene.bodies.size());
  double bytes = bytes_in_use();
  RigidModel<double> model(scene, {});
  std::vector<double> y(static_cast<std::size_t>(model.state_size())), rate(y.size());
  bytes = bytes_in_use() - bytes;
  model.initial_state(y.data());
  double total_ns = 0, runs = 0;
  for (auto _ : state) {
    const auto start = std::chrono::steady_clock::now();
    for (int i = 0; i < batch; ++i) {
      model.system().rate(0, y.data(), rate.data());
      benchmark::DoNotOptimize(rate.data());
    }
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() / batch;
    state.SetIterationTime(seconds);
    remember(family, links, seconds, bytes / links);
    total_ns += seconds * 1e9;
    ++runs;
  }
  state.counters["ns_per_step"] = total_ns / runs;
  state.counters["ns_per_body_step"] = total_ns / runs / links;
  state.counters["bytes_per_body"] = bytes / links;
}

void register_chains() {
  for (const bool planar : {false, true})
    for (const int links : {20, 100, 200, 500, 1000}) {
      const std::string family = planar ? "chain-planar" : "chain-hinges";
      benchmark::RegisterBenchmark(("scaling/" + family + "/" + std::to_string(links)).c_str(),
                                   [=](benchmark::State& state) {
                                     const int batch = std::max(1, 20000 / links);
                                     links_of(state, family, chain_scene(links, planar), batch);
                                   })
          ->UseManualTime()
          ->Iterations(50);
    }
  for (const int loops : {10, 20, 40, 80, 160}) {
    const int links = 2 * loops + 1, batch = std::max(1, 2000000 / (links * links * links));
    benchmark::RegisterBenchmark(
        ("scaling/four-bars/" + std::to_string(links)).c_str(),
        [=](benchmark::State& state) { links_of(state, "four-bars", four_bar_scene(loops), batch); })
        ->UseManualTime()
        ->Iterations(20);
  }
}

// ---- the fits -----------------------------------------------------------------------------------------------------
void print_fits() {
  for (const auto& [family, runs] : seen) {
    std::vector<double> bodies, seconds;
    double bytes = 0;
    for (const auto& [n, run] : runs) {
      if (n < (family == "four-bars" ? 40 : 100)) continue;
      bodies.push_back(n);
      seconds.push_back(run.seconds);
      bytes = run.bytes;
    }
    const ScalingFit fit = fit_scaling(bodies, seconds);
    if (fit.rungs < 4) continue;
    std::fprintf(stderr,
                 "%-32s T ~ N^(%.3f +- %.3f), T / log N ~ N^(%.3f +- %.3f) over N = %.0f .. %.0f; quickest at the "
                 "last: %.4g ns a body; %.0f bytes a body\n",
                 family.c_str(), fit.exponent, fit.half_width_95, fit.exponent_over_log, fit.half_width_over_log_95,
                 bodies.front(), bodies.back(), 1e9 * seconds.back() / bodies.back(), bytes);
  }
}

}  // namespace

int main(int argc, char** argv) {
  register_free_flight();
  register_all_gravity();
  register_chains();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  print_fits();
  return 0;
}
