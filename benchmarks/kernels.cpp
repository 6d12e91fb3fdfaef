// Benchmarks of the parts of a run besides steps: rates, reading scenes, measuring.
#include <benchmark/benchmark.h>

#include "rigid/model.hpp"
#include "scene/files.hpp"
#include "simulation.hpp"
#include "validation/metrics/metrics.hpp"

namespace {

using namespace atwood;

std::string path_of(const char* id) { return std::string(ATWOOD_SOURCE_DIR) + "/validation/scenarios/" + id + ".toml"; }

template <class S> void rate(benchmark::State& state, const char* id) {
  const Scenario scenario = read_scenario(path_of(id));
  RigidModel<S> model(scenario.scene);
  std::vector<S> y(static_cast<std::size_t>(model.state_size())), dydt(y.size());
  model.initial_state(y.data());
  model.select_interval(S(0), S(0.001));
  for (auto _ : state) {
    model.system().rate(S(0), y.data(), dydt.data());
    benchmark::DoNotOptimize(dydt.data());
    benchmark::ClobberMemory();
  }
}

void rate_in_float(benchmark::State& state, const char* id) { rate<float>(state, id); }
void rate_in_double(benchmark::State& state, const char* id) { rate<double>(state, id); }
void rate_in_long_double(benchmark::State& state, const char* id) { rate<long double>(state, id); }

void reading(benchmark::State& state, const char* id) {
  for (auto _ : state) benchmark::DoNotOptimize(read_scenario(path_of(id)));
}

void measuring(benchmark::State& state, const char* id) {
  const Scenario scenario = read_scenario(path_of(id));
  Recording run;
  Observer observer;
  observer.sample = [&](const Sample& sample) { run.values.push_back(sample); };
  run.outcome = atwood_engine().run(parse_method_id("atwood/rk4"), scenario.scene,
                                    {scenario.t_end_s, scenario.steps.front(), scenario.samples}, observer, 0);
  Truth truth;  // the run itself serves as truth: the times do not depend on the values
  truth.values = run.values;
  const Sample no_bar{0, std::vector<BodySample>(scenario.scene.bodies.size())};
  for (std::size_t k = 0; k < run.values.size(); ++k) truth.bars.push_back(no_bar);
  for (auto _ : state) benchmark::DoNotOptimize(measure(scenario, truth, run));
}

BENCHMARK_CAPTURE(rate_in_double, kepler_e06, "kepler-e0.6");
BENCHMARK_CAPTURE(rate_in_double, free_box_complex, "free-box-complex");
BENCHMARK_CAPTURE(rate_in_double, pleiades, "pleiades");
BENCHMARK_CAPTURE(rate_in_double, quadratic_drag, "projectile-quadratic-drag");
BENCHMARK_CAPTURE(rate_in_float, pleiades, "pleiades");
BENCHMARK_CAPTURE(rate_in_long_double, pleiades, "pleiades");
BENCHMARK_CAPTURE(reading, kepler_e06, "kepler-e0.6");
BENCHMARK_CAPTURE(reading, thrusters, "thrusters");
BENCHMARK_CAPTURE(measuring, kepler_e06, "kepler-e0.6");
BENCHMARK_CAPTURE(measuring, free_box_complex, "free-box-complex");

}  // namespace
