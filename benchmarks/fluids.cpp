// Time of a particle and an evaluation of the rate, against the number of particles.
//
//   fluid/sph-2d/N, fluid/sph-3d/N, fluid/sph-2d-2-threads/N, fluid/sph-2d-shift/N, fluid/polynomial4-2d/N
//       ns_per_step: nanoseconds a particle and evaluation, over a run of classical RK4 with its neighbour lists;
//       neighbours, within the support of the kernel.
//
// The pairwise sums conserve: density by continuity, symmetric pressure, viscosity. Only sph-2d-shift has the transport
// velocity and the diffusion of density that +sph adds in a periodic domain unless told otherwise. Fitted exponents of
// the time of an evaluation in N are printed to standard error at the end.
#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdio>
#include <map>
#include <memory>

#include "benchmarks/fluid_scene.hpp"
#include "simulation.hpp"
#include "validation/metrics/fluid.hpp"
#include "validation/metrics/metrics.hpp"

namespace {

using namespace atwood;

struct Family {
  std::string name, method;
  int dimensions = 2;
  double smoothing = 1.3;  // for the neighbours counted
};

std::map<std::string, std::map<double, double>> seen;  // seconds of an evaluation, the fastest by particles

// Scenes are made once: those of a million particles take longer than their runs.
const Scene& scene_of(int dimensions, int across) {
  static std::map<std::pair<int, int>, std::unique_ptr<Scene>> made;
  auto& scene = made[{dimensions, across}];
  if (!scene) {
    made.clear();  // one at a time in memory
    auto& fresh = made[{dimensions, across}];
    fresh = std::make_unique<Scene>(fluid_block(dimensions, across));
    return *fresh;
  }
  return *scene;
}

void evaluations(benchmark::State& state, const Family& family, int across) {
  const Scene& scene = scene_of(family.dimensions, across);
  const Fluid& fluid = scene.fluids.front();
  const auto particles = static_cast<double>(fluid.particles.mass_kg.size());
  const auto steps = static_cast<std::int64_t>(std::max(8.0, 1e6 / particles));
  const Plan plan{fluid_block_step_s(across) * static_cast<double>(steps), steps, 1};
  const MethodId id = parse_method_id(family.method);
  const Engine engine = atwood_engine();
  double total_ns = 0, runs = 0;
  for (auto _ : state) {
    const Outcome outcome = engine.run(id, scene, plan, {}, 1);
    if (outcome.status != Status::ok) return state.SkipWithError(outcome.reason.c_str());
    const auto ns = static_cast<double>(outcome.busy_ns.front());
    state.SetIterationTime(ns * 1e-9);
    const double seconds = ns * 1e-9 / static_cast<double>(outcome.rate_evaluations);
    double& least = seen[family.name][particles];
    if (least == 0 || seconds < least) least = seconds;
    total_ns += 1e9 * seconds;
    ++runs;
  }
  state.counters["ns_per_step"] = total_ns / runs / particles;
  state.counters["neighbours"] =
      mean_neighbours(scene.domain, fluid.particles.position_m, 2 * family.smoothing * fluid.spacing_m);
}

void add(const Family& family, std::initializer_list<int> across) {
  for (const int n : across) {
    const auto count = static_cast<std::int64_t>(std::llround(std::pow(n, family.dimensions)));
    benchmark::RegisterBenchmark(("fluid/" + family.name + "/" + std::to_string(count)).c_str(),
                                 [=](benchmark::State& state) { evaluations(state, family, n); })
        ->UseManualTime()
        ->MinTime(0.02);
  }
}

void print_fits() {
  for (const auto& [family, runs] : seen) {
    std::vector<double> particles, seconds;
    for (const auto& [n, s] : runs) particles.push_back(n), seconds.push_back(s);
    const ScalingFit fit = fit_scaling(particles, seconds);
    if (fit.rungs < 4) continue;
    std::fprintf(stderr, "%-24s time of an evaluation ~ N^(%.3f +- %.3f) over N = %.0f .. %.0f\n", family.c_str(),
                 fit.exponent, fit.half_width_95, particles.front(), particles.back());
  }
}

}  // namespace

int main(int argc, char** argv) {
  add({"sph-2d", "atwood/rk4+sph{smoothing=1.3,shift=0}"}, {100, 200, 400, 1000});
  add({"sph-3d", "atwood/rk4+sph{smoothing=1.23,shift=0}", 3, 1.23}, {22, 32, 64, 100});
  add({"sph-2d-2-threads", "atwood/rk4+sph{smoothing=1.3,shift=0,threads=2}"}, {100, 200, 400, 1000});
  add({"sph-2d-shift", "atwood/rk4+sph{smoothing=1.3}"}, {100, 200, 400, 1000});
  add({"polynomial4-2d", "atwood/rk4+polynomial{degree=4}", 2, 1.55}, {50, 100, 200, 400});
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  print_fits();
  return 0;
}
