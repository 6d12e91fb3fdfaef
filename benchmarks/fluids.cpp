// Time a particle and evaluation of the rate of +sph, against the number of particles: a periodic box of disturbed
// particles, density by continuity, symmetric pressure, Morris's viscosity, Wendland's C2 kernel.
//
//   fluid/2d/N, fluid/3d/N, and -2-threads
//       ns_per_particle_evaluation: one evaluation in the middle of a run, the lists brought up to date but not built
//       with_builds: the mean over a run of RK4 at half of its acoustic step, lists and the steps' own sums included
//       neighbours: within the support, of a particle; bytes_per_particle
#include <benchmark/benchmark.h>
#include <malloc.h>

#include <chrono>
#include <cmath>

#include "fluid/sph.hpp"
#include "scene/fluid_points.hpp"
#include "simulation.hpp"

namespace {

using namespace atwood;

constexpr double kSoundSpeed_m_per_s = 10;

Scene box_of_fluid(int dimensions, int across) {
  Scene scene;
  const double spacing = 1.0 / across, turn = 2 * std::acos(-1.0);
  scene.domain.dimensions = dimensions;
  Fluid fluid;
  fluid.name = "fluid";
  BoxRegion box;
  for (int c = 0; c < dimensions; ++c) scene.domain.periodic_m[c] = box.max_m[c] = 1;
  fluid.region = box;
  fluid.arrangement = Arrangement::disturbed;
  fluid.disturbance = 0.2;
  fluid.spacing_m = spacing;
  fluid.density_kg_per_m3 = 1;
  fluid.sound_speed_m_per_s = kSoundSpeed_m_per_s;
  fluid.viscosity_m2_per_s = 0.1 * spacing;
  scene.fluids.push_back(fluid);
  place_particles(scene);
  Particles& particles = scene.fluids.front().particles;
  for (std::size_t i = 0; i < particles.position_m.size(); ++i) {
    const Real3& x = particles.position_m[i];
    particles.velocity_m_per_s[i] = {-std::cos(turn * x[0]) * std::sin(turn * x[1]),
                                     std::sin(turn * x[0]) * std::cos(turn * x[1]), 0};
  }
  return scene;
}

double bytes_in_use() {
  const struct mallinfo2 info = mallinfo2();
  return static_cast<double>(info.uordblks) + static_cast<double>(info.hblkhd);
}

void evaluations(benchmark::State& state, int dimensions, int across, int threads) {
  const Scene scene = box_of_fluid(dimensions, across);
  fluid::SphOptions options;
  options.smoothing = dimensions == 2 ? 1.3 : 1.225;
  options.threads = threads;
  double bytes = bytes_in_use();
  fluid::Sph<double> sph(scene, options);
  std::vector<double> y(static_cast<std::size_t>(sph.layout().size())), rate(y.size());
  sph.initial_state(y.data());
  sph.system().rate(0, y.data(), rate.data());
  bytes = bytes_in_use() - bytes;
  const double particles = sph.layout().particles;
  double total_ns = 0, runs = 0;
  for (auto _ : state) {
    const auto start = std::chrono::steady_clock::now();
    sph.system().rate(0, y.data(), rate.data());
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    state.SetIterationTime(seconds);
    total_ns += seconds * 1e9;
    ++runs;
  }
  state.counters["ns_per_particle_evaluation"] = total_ns / runs / particles;
  state.counters["neighbours"] = sph.mean_neighbours(y.data());
  state.counters["bytes_per_particle"] = bytes / particles;

  const std::int64_t steps = particles > 2e5 ? 20 : 200;
  const double h_s = 0.5 / across / kSoundSpeed_m_per_s;
  const std::string id =
      "atwood/rk4+sph{kernel=wendland-c2,smoothing=" + std::string(dimensions == 2 ? "1.3" : "1.225") +
      ",threads=" + std::to_string(threads) + "}";
  const Outcome run =
      atwood_engine().run(parse_method_id(id), scene, {static_cast<double>(steps) * h_s, steps, 1}, {}, 1);
  if (run.status != Status::ok) return state.SkipWithError(run.reason.c_str());
  state.counters["with_builds"] =
      static_cast<double>(run.busy_ns.front()) / particles / static_cast<double>(run.rate_evaluations);
}

void register_fluids() {
  for (const int threads : {1, 2})
    for (const int dimensions : {2, 3})
      for (const int across :
           dimensions == 2 ? std::vector<int>{32, 100, 316, 1000} : std::vector<int>{10, 22, 47, 100}) {
        const int particles = dimensions == 2 ? across * across : across * across * across;
        const std::string family =
            "fluid/" + std::to_string(dimensions) + "d" + (threads == 1 ? "" : "-2-threads") + "/";
        benchmark::RegisterBenchmark((family + std::to_string(particles)).c_str(),
                                     [=](benchmark::State& state) { evaluations(state, dimensions, across, threads); })
            ->UseManualTime()
            ->MinTime(0.2);
      }
}

}  // namespace

int main(int argc, char** argv) {
  register_fluids();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
