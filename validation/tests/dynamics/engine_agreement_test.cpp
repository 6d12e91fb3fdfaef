// The engine's right-hand sides and the reference's share no code. At random states they agree to a few ulp.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>

#include "dynamics/rates.hpp"
#include "force_scenes.hpp"
#include "rigid/model.hpp"

using namespace atwood;

namespace {

// Largest difference of the two rates, in units of the last place of the largest rate of the same kind: sums of
// forces cancel, so a component near zero is compared relative to the others.
double disagreement_ulp(const Scene& scene, double t_s, const std::vector<double>& y) {
  const dynamics::Dynamics<Wide> reference(scene, 2);
  const std::vector<Wide> wide(y.begin(), y.end());
  std::vector<Wide> exact(y.size());
  reference.rate(Wide(t_s), wide.data(), exact.data(), reference.interval_at(t_s));

  RigidModel<double> model(scene);
  REQUIRE(model.unsupported() == "");
  model.select_interval(t_s, t_s);
  std::vector<double> state(model.state_size()), rates(model.state_size());
  model.initial_state(state.data());
  const auto each = [&](auto visit) {  // engine index, reference index
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
      const dynamics::Slot& slot = reference.layout().slots[i];
      const int at = model.offset(static_cast<int>(i));
      if (slot.position < 0) continue;
      for (int k = 0; k < 3; ++k) visit(at + kAtPosition + k, slot.position + k);
      for (int k = 0; k < 3 && slot.velocity >= 0; ++k) visit(at + kAtVelocity + k, slot.velocity + k);
      for (int k = 0; k < 4 && slot.attitude >= 0; ++k) visit(at + kAtAttitude + k, slot.attitude + k);
      for (int k = 0; k < 3 && slot.rate >= 0; ++k) visit(at + kAtBodyRate + k, slot.rate + k);
    }
  };
  each([&](int engine, int mine) { state[engine] = y[mine]; });
  model.system().rate(t_s, state.data(), rates.data());
  double size[4] = {0, 0, 0, 0}, worst = 0;
  const auto kind = [&](int mine) { return static_cast<int>(reference.layout().kinds[mine]); };
  each([&](int, int mine) {
    size[kind(mine)] = std::max(size[kind(mine)], std::fabs(static_cast<double>(exact[mine])));
  });
  each([&](int engine, int mine) {
    const double difference = std::fabs(static_cast<double>(Wide(rates[engine]) - exact[mine]));
    if (size[kind(mine)] == 0) {
      CHECK(difference == 0);
      return;
    }
    worst = std::max(worst, difference / size[kind(mine)] / std::numeric_limits<double>::epsilon());
  });
  return worst;
}

// A held body is at its initial position.
void stand_still(const Scene& scene, double t_s, std::vector<double>& y) {
  const dynamics::Layout layout = dynamics::layout(scene);
  const std::vector<double> initial = dynamics::pack<double>(scene);
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const int at = layout.slots[i].position;
    if (at >= 0 && scene.bodies[i].release_s > t_s) std::copy_n(initial.begin() + at, 3, y.begin() + at);
  }
}

}  // namespace

TEST_CASE("the engine's rates and the reference's agree to a few ulp, every force") {
  std::mt19937_64 random(2024);
  std::uniform_real_distribution<double> uniform(-0.3, 0.3);
  for (const auto& trial : force_scenes::all()) {
    double worst = 0;
    for (int k = 0; k < 50; ++k) {
      std::vector<double> y = dynamics::pack<double>(trial.scene);
      for (double& value : y) value += uniform(random);
      stand_still(trial.scene, trial.t_s, y);
      y = dynamics::pack<double>(trial.scene, dynamics::unpack<double>(trial.scene, 0, y.data()));  // unit quaternions
      worst = std::max(worst, disagreement_ulp(trial.scene, trial.t_s, y));
    }
    INFO(trial.name << ": " << worst << " ulp");
    CHECK(worst < 16);
  }
}

TEST_CASE("the engine's lorenz is the reference's") {
  Scene scene = force_scenes::bodies(1, false);
  scene.problem = "lorenz";
  CHECK(disagreement_ulp(scene, 0, {1.1, -7.3, 24.9}) < 16);
}
