// Nanoseconds per step of every method of one engine on the catalogue: step/SCENARIO/METHOD/STEPS.
//
// The engine times its own stepping (no start-up, no sampling), so a benchmark's manual time is a run's busy time, and
// the counter ns_per_step is that over the steps taken. A scene that a method cannot run ends as a skipped benchmark
// with the reason; only benchmarks that match the filter run.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <filesystem>
#include <memory>

#include ATWOOD_ENGINE_HEADER
#include "benchmarks/free_flight_scene.hpp"
#include "protocol/method.hpp"
#include "scene/files.hpp"

namespace {

using namespace atwood;

std::vector<Scenario> catalogue() {
  std::vector<std::string> paths;
  for (const auto& entry : std::filesystem::directory_iterator(ATWOOD_SOURCE_DIR "/validation/scenarios")) {
    if (entry.path().extension() == ".toml") paths.push_back(entry.path().string());
  }
  std::sort(paths.begin(), paths.end());
  std::vector<Scenario> scenarios;
  for (const auto& path : paths) scenarios.push_back(read_scenario(path));
  return scenarios;
}

// A rung that runs in about a millisecond: enough steps to time, few enough to repeat.
std::int64_t rung_of(const Scenario& scenario) {
  std::int64_t chosen = scenario.steps.front();
  for (const auto steps : scenario.steps) {
    if (steps <= 2000) chosen = std::max(chosen, steps);
  }
  return chosen;
}

void step(benchmark::State& state, const Engine& engine, const MethodId& id, const Scenario& scenario,
          std::int64_t steps) {
  double total_ns = 0, total_steps = 0;
  for (auto _ : state) {
    const Outcome outcome = engine.run(id, scenario.scene, {scenario.t_end_s, steps, scenario.samples}, {}, 1);
    if (outcome.status != Status::ok || outcome.busy_ns.empty()) {
      state.SkipWithError(("not timed: " + outcome.reason).c_str());
      return;
    }
    const auto ns = static_cast<double>(outcome.busy_ns.front());
    state.SetIterationTime(ns * 1e-9);
    total_ns += ns;
    total_steps += static_cast<double>(outcome.steps_taken > 0 ? outcome.steps_taken : steps);
  }
  state.counters["ns_per_step"] = total_ns / total_steps;
}

bool fits(const Engine& engine, const Scenario& scenario) {
  if (std::find(scenario.tags.begin(), scenario.tags.end(), "pile") != scenario.tags.end())
    return false;  // `atwood bench frame-budget`
  const bool rival = engine.name.rfind("bullet", 0) == 0 || engine.name == "ode";
  return !rival || std::find(scenario.tags.begin(), scenario.tags.end(), "rivals") != scenario.tags.end();
}

void register_all(const std::shared_ptr<Engine>& engine) {
  for (const auto& scenario : catalogue()) {
    if (!fits(*engine, scenario)) continue;
    const bool contact = std::find(scenario.tags.begin(), scenario.tags.end(), "contact") != scenario.tags.end();
    for (const auto& info : engine->methods) {
      std::vector<std::string> ids{info.id};
      if (engine->name == "atwood" && contact) ids = {info.id + "+event", info.id + "+impulse"};
      if (engine->name == "cvode") ids = {info.id + ":1e-10"};
      for (const auto& text : ids) {
        const std::int64_t steps = rung_of(scenario);
        const MethodId id = parse_method_id(text);
        benchmark::RegisterBenchmark(
            ("step/" + scenario.id + "/" + text + "/" + std::to_string(steps)).c_str(),
            [engine, id, scenario, steps](benchmark::State& state) { step(state, *engine, id, scenario, steps); })
            ->UseManualTime()
            ->MinTime(0.005);
      }
    }
  }
}

// Free flight of many bodies in rivals, for comparison with scaling.cpp: scaling/ENGINE/free-flight/N.
void register_scaling(const std::shared_ptr<Engine>& engine) {
  if (engine->name != "ode" && engine->name != "bullet64" && engine->name != "bullet32") return;
  for (const int bodies : {1, 100, 1000, 10000, 100000}) {
    Scenario scenario;
    scenario.id = "free-flight";
    scenario.t_end_s = 1;
    scenario.samples = 1;
    const std::int64_t steps = std::max<std::int64_t>(5, 200000 / bodies);
    const auto run = [engine, scenario, steps, bodies](benchmark::State& state) mutable {
      if (scenario.scene.bodies.empty()) scenario.scene = free_flight_scene(bodies);
      step(state, *engine, parse_method_id(engine->name + "/default"), scenario, steps);
      state.counters["ns_per_body_step"] = state.counters["ns_per_step"].value / bodies;
    };
    benchmark::RegisterBenchmark(("scaling/" + engine->name + "/free-flight/" + std::to_string(bodies)).c_str(), run)
        ->UseManualTime()
        ->MinTime(0.005);
  }
}

}  // namespace

int main(int argc, char** argv) {
  const auto engine = std::make_shared<Engine>(atwood::ATWOOD_ENGINE_FACTORY());
  register_all(engine);
  register_scaling(engine);
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
