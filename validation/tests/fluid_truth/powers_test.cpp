// Powers of the terms of +sph against sums that are written out for few particles.
#include <catch2/catch.hpp>
#include <cmath>

#include "fluid_scenes.hpp"
#include "fluid_truth/kernel.hpp"
#include "fluid_truth/manufactured.hpp"
#include "fluid_truth/powers.hpp"

using namespace atwood;
using namespace atwood::fluid_truth;

namespace {

constexpr double kSpacing = 0.1, kSmoothing = 1.5, kSupport = 2 * kSmoothing * kSpacing;

// Two particles of 1 and 2 kg, 0.12 m apart.
Scenario pair_scene() {
  Scenario made = fluid_scenario("taylor-green", 0, 0);
  Fluid& fluid = made.scene.fluids[0];
  fluid.initial = {};
  fluid.spacing_m = kSpacing;
  fluid.particles.position_m = {{0, 0, 0}, {0.12, 0, 0}};
  fluid.particles.velocity_m_per_s = {{1, 0.5, 0}, {-1, 0, 0}};
  fluid.particles.mass_kg = {1, 2};
  fluid.particles.density_kg_per_m3 = {1020, 990};
  fluid.particles.temperature_K.assign(2, 0);
  return made;
}

std::vector<ParticleSample> start_of(const Scenario& scenario) {
  const Particles& p = scenario.scene.fluids[0].particles;
  std::vector<ParticleSample> made;
  for (std::size_t i = 0; i < p.mass_kg.size(); ++i) {
    ParticleSample& one = made.emplace_back();
    for (std::size_t a = 0; a < 3; ++a) one.p_m[a] = p.position_m[i][a], one.v_m_per_s[a] = p.velocity_m_per_s[i][a];
    one.density_kg_per_m3 = p.density_kg_per_m3[i];
    one.temperature_K = p.temperature_K[i];
  }
  return made;
}

double slope(double r) { return kernel_of<double>(KernelKind::wendland_c2, 2, kSupport).slope_over_r(r); }

}  // namespace

TEST_CASE("The power of density diffusion, shift and viscosity of two particles, by hand") {
  Scenario scenario = pair_scene();
  const double F = slope(0.12), c = 10, p[] = {c * c * 20, c * c * -10}, rho[] = {1020, 990}, m[] = {1, 2};
  const double own[] = {m[0] * p[0] / (rho[0] * rho[0]), m[1] * p[1] / (rho[1] * rho[1])};  // grad E of a density
  const std::string kernel = "sph{kernel=wendland-c2,smoothing=1.5,density_diffusion=";
  SECTION("diffusion: 2 delta h c sum_j m_j / rho_j (rho_i - rho_j) F") {
    const FluidPowersOf powers(scenario.scene, kernel + "0.1,shift=0}");
    REQUIRE(powers.unsupported() == "");
    const double rate = 2 * 0.1 * kSmoothing * kSpacing * c * F * 30;
    const FluidPowers now = powers.at(0, start_of(scenario), {});
    CHECK(now.diffusion == Approx(own[0] * rate * m[1] / rho[1] - own[1] * rate * m[0] / rho[0]).epsilon(1e-12));
    CHECK(now.diffusion < 0);
    CHECK(now.shift == 0);
    CHECK(now.walls == 0);
  }
  SECTION("viscosity: of the pair m_i m_j A . v, all of it becomes heat where viscous_heat is set") {
    const double A = 2 * 1000 * 0.01 / (rho[0] * rho[1]) * F;
    const double power = m[0] * m[1] * A * (2 * 2 + 0.5 * 0.5);
    const FluidPowersOf cold(scenario.scene, kernel + "0,shift=0}");
    CHECK(cold.at(0, start_of(scenario), {}).viscosity == Approx(power).epsilon(1e-12));
    scenario.scene.fluids[0].heat_capacity_J_per_kg_K = 2;
    scenario.scene.fluids[0].viscous_heat = true;
    const FluidPowersOf warm(scenario.scene, kernel + "0,shift=0}");
    CHECK(std::fabs(warm.at(0, start_of(scenario), {}).viscosity) < 1e-14 * std::fabs(power));
  }
  SECTION("shift, in gravity: positions that are moved, and the fluxes relative to the motion") {
    scenario.scene.gravity_m_per_s2 = {3, 0, 0};
    const FluidPowersOf powers(scenario.scene, kernel + "0.1,shift=0.5}");
    const double U = std::hypot(1, 0.5), V[] = {m[0] / rho[0], m[1] / rho[1]}, x = -0.12;
    const double u[] = {-0.5 * U * kSupport * V[1] * F * x, 0.5 * U * kSupport * V[0] * F * x};
    const double flux = x * (rho[0] * u[0] + rho[1] * u[1]), spread = x * (u[1] - u[0]);
    const double rates[] = {V[1] * F * (flux - rho[0] * spread), V[0] * F * (-flux - rho[1] * spread)};
    const double dv = F * flux / 2;  // times V_j / rho_i (v_j - v_i); the other's has the opposite sign twice
    const double kinetic = m[0] * V[1] / rho[0] * dv * (1 * -2 + 0.5 * -0.5) - m[1] * V[0] / rho[1] * dv * (-1 * 2);
    const double expected = -3 * (m[0] * u[0] + m[1] * u[1]) + own[0] * rates[0] + own[1] * rates[1] + kinetic;
    CHECK(powers.at(0, start_of(scenario), {}).shift == Approx(expected).epsilon(1e-12));
  }
}

TEST_CASE("The power of a wall on one particle, by hand") {
  Scenario scenario = pair_scene();
  add_channel(scenario, -0.1, 10, 0, 0);
  for (FluidBoundary& boundary : scenario.scene.fluid_boundaries) boundary.slip = Slip::free_slip;
  scenario.scene.domain.periodic_m = {};
  Particles& p = scenario.scene.fluids[0].particles;
  p.position_m = {{0.03, 0, 0}};
  p.velocity_m_per_s = {{1, 0.5, 0}};
  p.mass_kg = {1};
  p.density_kg_per_m3 = {1020};
  p.temperature_K = {0};
  scenario.scene.fluids[0].region = BoxRegion{{0, 0, 0}, {1, 1, 0}};
  const FluidPowersOf powers(scenario.scene, "sph{kernel=wendland-c2,smoothing=1.5,density_diffusion=0,shift=0}");
  REQUIRE(powers.unsupported() == "");
  // Points at depths 0.05, 0.15, ... below y = -0.1, at x = 0.05 + 0.1 k: all take the particle's own pressure and
  // density. What p_i / rho_i^2 takes from motion it gives to compression; p_w / rho_w^2 is left.
  double expected = 0;
  const double share = 100 * 20.0 / (1020.0 * 1020.0);
  for (int k = -9; k < 9; ++k)
    for (int layer = 0; layer < 3; ++layer) {
      const double x = 0.03 - (0.05 + 0.1 * k), y = 0.1 + 0.05 + 0.1 * layer, r = std::hypot(x, y);
      if (r < kSupport) expected -= 1000 * kSpacing * kSpacing * share * slope(r) * (1 * x + 0.5 * y);
    }
  CHECK(powers.at(0, start_of(scenario), {}).walls == Approx(expected).epsilon(1e-12));
  CHECK(expected > 0);
}

TEST_CASE("The power of a body that has moved on one particle, by hand") {
  Scenario scenario = pair_scene();
  scenario.scene.domain.periodic_m = {};
  Particles& p = scenario.scene.fluids[0].particles;
  p.position_m = {{0, 0, 0}};
  p.velocity_m_per_s = {{1, 0.5, 0}};
  p.mass_kg = {2};
  p.density_kg_per_m3 = {1020};
  p.temperature_K = {0};
  Body& box = scenario.scene.bodies.emplace_back();
  box.name = "box";
  box.mass_kg = 3;
  box.shape = Box{{0.1, 0.1, 0.1}};
  box.position_m = {5, 0, 0};
  FluidBoundary& boundary = scenario.scene.fluid_boundaries.emplace_back();
  boundary.body = 0;
  boundary.slip = Slip::free_slip;
  const FluidPowersOf powers(scenario.scene, "sph{kernel=wendland-c2,smoothing=1.5,density_diffusion=0,shift=0}");
  REQUIRE(powers.unsupported() == "");
  // At the sample the box, of four points at (+-0.05, +-0.05) in its axes, is at (0.2, 0.05), turned by 30 degrees, and
  // moves. All points take the particle's pressure and density.
  BodySample moved;
  moved.p_m = {0.2, 0.05, 0};
  const double half = std::acos(-1.0) / 12;
  moved.q_wxyz = {std::cos(half), 0, 0, std::sin(half)};
  moved.v_m_per_s = {-0.5, 0.25, 0};
  moved.w_rad_per_s = {0, 0, 3};
  double expected = 0;
  const double share = 100 * 20.0 / (1020.0 * 1020.0);
  for (const double a : {-0.05, 0.05})
    for (const double b : {-0.05, 0.05}) {
      const double rx = std::cos(2 * half) * a - std::sin(2 * half) * b,
                   ry = std::sin(2 * half) * a + std::cos(2 * half) * b;
      const double x = -(0.2 + rx), y = -(0.05 + ry), ux = -0.5 - 3 * ry, uy = 0.25 + 3 * rx;
      expected -= 2 * 1000 * kSpacing * kSpacing * share * slope(std::hypot(x, y)) * (x * (1 + ux) + y * (0.5 + uy));
    }
  const FluidPowers now = powers.at(0, start_of(scenario), std::vector{moved});
  CHECK(now.bodies == Approx(expected).epsilon(1e-12));
  CHECK(std::fabs(expected) > 1e-3);
  CHECK(now.walls == 0);
}

TEST_CASE("With a density by summation the powers are those of the sum of continuity") {
  const Scenario scenario = pair_scene();
  const std::string kernel = "sph{kernel=wendland-c2,smoothing=1.5,shift=0,density_diffusion=0,density=";
  const FluidPowersOf summed(scenario.scene, kernel + "summation}"), integrated(scenario.scene, kernel + "continuity}");
  REQUIRE(summed.unsupported() == "");
  const FluidPowers a = summed.at(0, start_of(scenario), {}), b = integrated.at(0, start_of(scenario), {});
  CHECK(a.viscosity == b.viscosity);
  CHECK(a.viscosity < 0);
}

TEST_CASE("The power of buoyancy and of a body acceleration, by hand") {
  Scenario scenario = pair_scene();
  Fluid& fluid = scenario.scene.fluids[0];
  const std::string response = "sph{kernel=wendland-c2,smoothing=1.5,density_diffusion=0,shift=0}";
  SECTION("buoyancy: -m expansion (T - T0) g . v") {
    scenario.scene.gravity_m_per_s2 = {3, -10, 0};
    fluid.heat_capacity_J_per_kg_K = 2;
    fluid.temperature_K = 300;
    fluid.expansion_per_K = 0.01;
    fluid.particles.temperature_K = {305, 310};
    const FluidPowers now = FluidPowersOf(scenario.scene, response).at(0, start_of(scenario), {});
    CHECK(now.sources == Approx(1 * -0.05 * (3 * 1 - 10 * 0.5) + 2 * -0.1 * (3 * -1)).epsilon(1e-12));
    CHECK(now.walls == 0);
  }
  SECTION("the acceleration of a manufactured field: m s . v") {
    fluid.source.name = "mms-2d";
    fluid.source.parameters = {{"speed_m_per_s", 3},
                               {"length_m", 1},
                               {"mode", 2},
                               {"angular_frequency_rad_per_s", 4},
                               {"density_amplitude", 0.03}};
    const FluidPowers now = FluidPowersOf(scenario.scene, response).at(0.125, start_of(scenario), {});
    const auto field = manufactured_of<double>(scenario.scene, fluid, fluid.source);
    double expected = 0;
    for (const ParticleSample& p : start_of(scenario)) {
      const auto i = p.p_m[0] == 0 ? 0 : 1;
      const Vec<double> s = field.source(0.125, {0.12 * i, 0, 0});
      for (std::size_t a = 0; a < 2; ++a)
        expected += fluid.particles.mass_kg[i] * s[a] * fluid.particles.velocity_m_per_s[i][a];
    }
    CHECK(std::fabs(expected) > 1);
    CHECK(now.sources == Approx(expected).epsilon(1e-12));
  }
}

TEST_CASE("Powers that are not known say why") {
  const Scenario scenario = pair_scene();
  CHECK(FluidPowersOf(scenario.scene, "polynomial{degree=2}").unsupported().find("only the terms of +sph") !=
        std::string::npos);
  CHECK(
      FluidPowersOf(scenario.scene, "sph{kernel=wendland-c2,smoothing=1.5,density=summation,shift=1}").unsupported() ==
      "shift with a density by summation");
  Scenario sliding = scenario;
  add_channel(sliding, -0.1, 10, 1, 0);
  CHECK(FluidPowersOf(sliding.scene, "sph{kernel=wendland-c2,smoothing=1.5,density=summation}")
            .unsupported()
            .find("stay where they are while its surface slides") != std::string::npos);
  CHECK(FluidPowersOf(scenario.scene, "sph{kernel=wendland-c2,smoothing=1.5,new=1}").unsupported() ==
        "the setting `new` of +sph is not covered");
}
