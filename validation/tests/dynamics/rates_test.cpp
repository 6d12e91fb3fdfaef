#include "dynamics/rates.hpp"

#include <quadmath.h>

#include <catch2/catch.hpp>
#include <random>

#include "dynamics/invariants.hpp"
#include "force_scenes.hpp"

using namespace atwood;
using namespace atwood::dynamics;

namespace {

// A state of order one near the scene's own, quaternions unit.
std::vector<Wide> random_state(const Scene& scene, std::mt19937_64& random) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<Wide> y = pack<Wide>(scene);
  for (Wide& value : y) value += Wide(0.3) * Wide(uniform(random));
  return pack<Wide>(scene, unpack<Wide>(scene, Wide(0), y.data()));
}

Wide total_energy(const Scene& scene, const std::vector<Wide>& y) {
  const Energy e = energy(scene, unpack<Wide>(scene, Wide(0), y.data()));
  return e.kinetic_J + e.potential_J;
}

// d/dt of a function of the state along the rates, by a central difference: error of order 1e-20.
template <class Function>
Wide along_rates(const std::vector<Wide>& y, const std::vector<Wide>& dydt, Function function) {
  const Wide step = 1e-10;
  std::vector<Wide> ahead = y, behind = y;
  for (std::size_t i = 0; i < y.size(); ++i) {
    ahead[i] += step * dydt[i];
    behind[i] -= step * dydt[i];
  }
  return (function(ahead) - function(behind)) / (2 * step);
}

std::vector<Wide> rate_of(const Scene& scene, double t_s, const std::vector<Wide>& y) {
  const Dynamics<Wide> dynamics(scene, 2);
  std::vector<Wide> dydt(y.size());
  dynamics.rate(Wide(t_s), y.data(), dydt.data(), dynamics.interval_at(t_s));
  return dydt;
}

Scene one_body() { return force_scenes::bodies(1, false); }

}  // namespace

TEST_CASE("conservative forces do no work on the whole, the others do") {
  std::mt19937_64 random(7);
  for (const auto& trial : force_scenes::all()) {
    INFO(trial.name);
    CHECK((conserves(trial.scene, "energy") || !trial.conservative));
    for (int k = 0; k < 5; ++k) {
      const std::vector<Wide> y = random_state(trial.scene, random);
      const auto power = along_rates(y, rate_of(trial.scene, trial.t_s, y),
                                     [&](const auto& state) { return total_energy(trial.scene, state); });
      if (trial.conservative) CHECK(static_cast<double>(fabsq(power)) < 1e-16);
    }
  }
}

TEST_CASE("internal forces keep both momenta") {
  std::mt19937_64 random(11);
  int tried = 0;
  for (const auto& trial : force_scenes::all()) {
    INFO(trial.name);
    const std::vector<Wide> y = random_state(trial.scene, random);
    const std::vector<Wide> dydt = rate_of(trial.scene, trial.t_s, y);
    for (int axis = 0; axis < 3; ++axis) {
      const auto momentum_rate = along_rates(y, dydt, [&](const auto& state) {
        return momentum(trial.scene, unpack<Wide>(trial.scene, Wide(0), state.data()))[axis];
      });
      const auto spin_rate = along_rates(y, dydt, [&](const auto& state) {
        return angular_momentum(trial.scene, unpack<Wide>(trial.scene, Wide(0), state.data()))[axis];
      });
      const auto centre_rate = along_rates(y, dydt, [&](const auto& state) {
        return angular_momentum_about_center(trial.scene, unpack<Wide>(trial.scene, Wide(0), state.data()))[axis];
      });
      if (conserves(trial.scene, "momentum")) CHECK(static_cast<double>(fabsq(momentum_rate)) < 1e-16);
      if (conserves(trial.scene, "angular-momentum")) CHECK(static_cast<double>(fabsq(spin_rate)) < 1e-16);
      if (conserves(trial.scene, "angular-momentum-center")) CHECK(static_cast<double>(fabsq(centre_rate)) < 1e-16);
    }
    tried += conserves(trial.scene, "momentum");
  }
  CHECK(tried == 6);  // free rotation, two gravities, two springs of two bodies, Coulomb
}

TEST_CASE("forces agree with values derived by hand") {
  SECTION("linear drag: m a = -c (v - wind)") {
    Scene scene = one_body();  // m = 1.5, v = (0.5, 0, -0.3)
    scene.forces = {LinearDrag{{0}, 3, {1, 0, 0}, 0}};
    const auto dydt = rate_of(scene, 0, pack<Wide>(scene));
    CHECK(static_cast<double>(dydt[3]) == 1.0);
    CHECK(static_cast<double>(dydt[5]) == Approx(0.6).epsilon(1e-15));
  }
  SECTION("quadratic drag: 1/2 rho C A |u| u, |u| = 5") {
    Scene scene = one_body();
    scene.bodies[0].velocity_m_per_s = {3, 4, 0};
    scene.forces = {QuadraticDrag{{0}, 2, 0.5, 0.3, {0, 0, 0}, 0}};  // 0.15 * 5 * (3, 4, 0) = (2.25, 3, 0) N
    const auto dydt = rate_of(scene, 0, pack<Wide>(scene));
    CHECK(static_cast<double>(dydt[3]) == Approx(-1.5).epsilon(1e-15));
    CHECK(static_cast<double>(dydt[4]) == Approx(-2.0).epsilon(1e-15));
  }
  SECTION("a damped spring pulls along itself: k (L - L0) + c dL/dt") {
    Scene scene = one_body();
    scene.bodies[0].position_m = {0, 0, 0};
    scene.bodies[0].velocity_m_per_s = {1, 5, 0};
    scene.forces = {Spring{{0}, {2, 0, 0}, 3, 0.5, 1, {}}};  // stretched by 1, shortening at 1: 3 - 0.5 N along x
    const auto dydt = rate_of(scene, 0, pack<Wide>(scene));
    CHECK(static_cast<double>(dydt[3]) == Approx(2.5 / 1.5).epsilon(1e-15));
    CHECK(static_cast<double>(dydt[4]) == 0);
  }
  SECTION("Coriolis and centrifugal: W = z, r = x, v = x: a = (1, -2, 0)") {
    Scene scene = one_body();
    scene.bodies[0].position_m = {1, 0, 0};
    scene.bodies[0].velocity_m_per_s = {1, 0, 0};
    scene.forces = {RotatingFrame{{0, 0, 1}}};
    const auto dydt = rate_of(scene, 0, pack<Wide>(scene));
    CHECK(static_cast<double>(dydt[3]) == 1);
    CHECK(static_cast<double>(dydt[4]) == -2);
  }
  SECTION("charge in a field: q (E + v x B) with v = x, B = z: -y") {
    Scene scene = one_body();
    scene.bodies[0].velocity_m_per_s = {1, 0, 0};
    scene.forces = {Lorentz{{0}, {0, 0, 3}, {0, 0, 2}}};  // q = 0.5, m = 1.5
    const auto dydt = rate_of(scene, 0, pack<Wide>(scene));
    CHECK(static_cast<double>(dydt[4]) == Approx(-2.0 / 3).epsilon(1e-15));
    CHECK(static_cast<double>(dydt[5]) == Approx(1.0).epsilon(1e-15));
  }
  SECTION("a thruster off the centre turns, and pushes along the turned body") {
    Scene scene = force_scenes::bodies(1, true);
    scene.bodies[0].orientation_wxyz = {0.5, 0.5, 0.5, 0.5};  // x -> y -> z -> x
    scene.bodies[0].angular_velocity_body_rad_per_s = {0, 0, 0};
    scene.forces = {Thruster{0, {0, 2, 0}, {1, 0, 0}, 3, {}}};  // torque (0, 2, 0) x (3, 0, 0) = (0, 0, -6), I_z = 1
    const auto dydt = rate_of(scene, 0, pack<Wide>(scene));
    CHECK(static_cast<double>(dydt[4]) == Approx(2).epsilon(1e-15));
    CHECK(static_cast<double>(dydt[12]) == Approx(-6).epsilon(1e-15));
  }
}

TEST_CASE("switches and releases cut time into intervals") {
  Scene scene = force_scenes::bodies(2, true);
  scene.bodies[1].release_s = 3;
  scene.forces = {Thruster{0, {0, 0, 0}, {1, 0, 0}, 3, {{0, 2}, {5, 6}}}};
  CHECK(switch_times(scene, 5.5) == std::vector<double>{2, 3, 5});
  const Dynamics<double> dynamics(scene, 5.5);
  CHECK(dynamics.interval_at(2) == 1);
  CHECK(dynamics.interval_at(1.999) == 0);
  const std::vector<double> y = pack<double>(scene);
  std::vector<double> dydt(y.size());
  const auto push = [&](int interval) {  // the time is the switch itself: the interval decides
    dynamics.rate(2, y.data(), dydt.data(), interval);
    return dydt[6];
  };
  CHECK(push(0) == Approx(2));
  CHECK(push(1) == 0);
  CHECK(push(3) == Approx(2));
  push(1);
  CHECK(dydt[3] == 0);  // held
  push(2);
  CHECK(dydt[3] == 0.5);
}

TEST_CASE("double and quad agree") {
  std::mt19937_64 random(5);
  for (const auto& trial : force_scenes::all()) {
    INFO(trial.name);
    const std::vector<Wide> y = random_state(trial.scene, random);
    const std::vector<Wide> exact = rate_of(trial.scene, trial.t_s, y);
    const Dynamics<double> narrow(trial.scene, 2);
    std::vector<double> y_narrow(y.begin(), y.end()), dydt(y.size());
    narrow.rate(trial.t_s, y_narrow.data(), dydt.data(), narrow.interval_at(trial.t_s));
    for (std::size_t i = 0; i < y.size(); ++i) CHECK(dydt[i] == Approx(static_cast<double>(exact[i])).margin(1e-13));
  }
}

TEST_CASE("scenes that the equations do not cover are refused by name") {
  Scene scene = one_body();
  scene.forces = {Potential{{0}, "toda", {}}};
  CHECK(unsupported(scene) == "no equations for the potential `toda`");
  CHECK_THROWS_AS(Dynamics<double>(scene, 1), std::invalid_argument);
  scene = one_body();
  scene.problem = "rossler";
  CHECK(unsupported(scene) == "no equations for the problem `rossler`");
}
