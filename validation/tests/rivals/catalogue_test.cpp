// Every scenario that the catalogue promises for rivals runs in both presets: `unsupported` there is a failure.
#include <catch2/catch.hpp>

#include <algorithm>

#include "under_test.hpp"
#include "validation/tests/catalogued.hpp"

namespace atwood::test {
namespace {

// clang-format off
const std::vector<std::string> kPromised{
    "ballistic",     "projectile-linear-drag", "projectile-quadratic-drag", "free-box-simple", "free-box-complex",
    "symmetric-top", "dzhanibekov",            "thrusters",                 "force-at-a-point", "bounce-e0",
    "thrusters-spin", "force-at-a-point-body", "frame-rate-30",            "frame-rate-60",    "frame-rate-144",
    "bounce-e0.5",   "bounce-e0.8",            "bounce-e1",                 "head-on",         "oblique",
    "oblique-rough", "oblique-rough-stick"};
// clang-format on

bool asks_for_restitution(const Scene& scene) {
  return std::any_of(scene.pairs.begin(), scene.pairs.end(), [](const PairLaw& law) { return law.restitution != 0; });
}

}  // namespace

TEST_CASE("every promised scenario runs") {
  const Engine engine = engine_under_test();
  for (const auto& id : kPromised) {
    const Scenario scenario = testing::catalogued(id);
    for (const auto& scheme : {"default", "tuned"}) {
      // An explicit gyroscopic term blows up at the tumbling box's coarsest step.
      const bool fine = engine.name == "mujoco" || engine.name == "dart";
      const Plan plan{scenario.t_end_s, fine ? scenario.steps.back() : scenario.steps.front(), scenario.samples};
      const Run result = try_run(engine, method(engine, scheme), scenario.scene, plan);
      INFO(id << ", " << scheme << ": " << result.outcome.reason);
      if (!bounces(engine) && asks_for_restitution(scenario.scene)) {
        CHECK(to_string(result.outcome.status) == "unsupported");
        CHECK_THAT(result.outcome.reason, Catch::Contains("restitution"));
        continue;
      }
      CHECK(to_string(result.outcome.status) == "ok");
      CHECK(result.samples.size() == static_cast<std::size_t>(scenario.samples) + 1);
      for (const auto& sample : result.samples) CHECK(sample.bodies.size() == scenario.scene.bodies.size());
      // Something moved: the adapter didn't answer with the initial state.
      double moved = 0;
      for (std::size_t i = 0; i < scenario.scene.bodies.size(); ++i) {
        for (int k = 0; k < 3; ++k) {
          moved += std::abs(result.p(static_cast<int>(i), k) - scenario.scene.bodies[i].position_m[k]);
        }
        moved += angle_between(result.q(static_cast<int>(i)), scenario.scene.bodies[i].orientation_wxyz);
      }
      CHECK(moved > 1e-6);
    }
  }
}

}  // namespace atwood::test
