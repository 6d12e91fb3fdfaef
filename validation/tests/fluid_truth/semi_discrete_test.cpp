// The particles' own equations in the reference: a pair by hand, what they conserve, consistency, and the truth's bars.
#include <catch2/catch.hpp>

#include "fluid_scenes.hpp"
#include "fluid_truth/particles.hpp"
#include "fluid_truth/semi_discrete.hpp"

using namespace atwood;
using namespace atwood::fluid_truth;

namespace {

double d(Wide x) { return static_cast<double>(x); }

// n x n particles of a periodic unit square, disturbed, with a smooth velocity and density.
Scenario disturbed(int n, std::uint64_t seed, double disturbance = 0.2) {
  Scenario made = fluid_scenario("");
  Fluid& fluid = made.scene.fluids[0];
  fluid.initial = {};
  fluid.spacing_m = 1.0 / n;
  fluid.viscosity_m2_per_s = 0.02;
  Draw draw(seed);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const double x = (i + 0.5 + disturbance * draw(0, 1)) / n, y = (j + 0.5 + disturbance * draw(0, 1)) / n;
      const double k = 2 * M_PI;
      fluid.particles.position_m.push_back({x, y, 0});
      fluid.particles.velocity_m_per_s.push_back(
          {-std::cos(k * x) * std::sin(k * y), std::sin(k * x) * std::cos(k * y), 0});
      const double rho = 1000 * (1 + 0.01 * std::sin(k * (x + y)));
      fluid.particles.density_kg_per_m3.push_back(rho);
      fluid.particles.mass_kg.push_back(1000.0 / (n * n));
      fluid.particles.temperature_K.push_back(300 + std::sin(k * x));
    }
  return made;
}

Scenario pair_scene() {
  Scenario made = fluid_scenario("", 0, 0);
  Fluid& fluid = made.scene.fluids[0];
  fluid.initial = {};
  fluid.spacing_m = 0.5;
  fluid.particles.position_m = {{0, 0, 0}, {0.3, 0.4, 0}};
  fluid.particles.velocity_m_per_s = {{1, 0, 0}, {0, 2, 0}};
  fluid.particles.mass_kg = {2, 3};
  fluid.particles.density_kg_per_m3 = {1100, 900};
  fluid.particles.temperature_K = {300, 310};
  return made;
}

template <class S> std::vector<S> rate_of(const Scenario& scenario, const std::string& response) {
  const auto system = fluid_system<S>(scenario.scene, response);
  const std::vector<S> y = initial_state<S>(scenario.scene, system->data.layout);
  std::vector<S> f(y.size());
  system->rate(0, y.data(), f.data());
  return f;
}

}  // namespace

TEST_CASE("Two particles by hand: pressure, both viscosities, continuity, heat") {
  Scenario scenario = pair_scene();
  Fluid& fluid = scenario.scene.fluids[0];
  fluid.viscosity_m2_per_s = 0.1;
  // r = 1/2, h = 0.5, support 1: w' / s of Wendland C2 at s = 1/2 is -20 / 8; W'/r = 7 / pi (-2.5).
  const double F = -2.5 * 7 / M_PI, x[2] = {-0.3, -0.4}, v[2] = {1, -2}, vx = v[0] * x[0] + v[1] * x[1];
  const double p[2] = {100 * 100.0, 100 * -100.0}, rho[2] = {1100, 900}, m[2] = {2, 3}, mu = 1000 * 0.1;
  const double push = p[0] / (rho[0] * rho[0]) + p[1] / (rho[1] * rho[1]);
  for (const bool central : {false, true}) {
    const auto f = rate_of<Wide>(
        scenario, std::string("sph{kernel=wendland-c2,smoothing=1,viscosity=") + (central ? "central}" : "morris}"));
    REQUIRE(f.size() == 10);
    CHECK(d(f[0]) == 1);
    CHECK(d(f[3]) == 2);
    for (int a = 0; a < 2; ++a) {
      const double A =
          central ? 4 * 2 * mu / (rho[0] * rho[1]) * vx / 0.25 * F * x[a] : 2 * mu / (rho[0] * rho[1]) * F * v[a];
      CHECK(d(f[4 + a]) == Approx(-m[1] * push * F * x[a] + m[1] * A).epsilon(1e-13));
      CHECK(d(f[6 + a]) == Approx(m[0] * push * F * x[a] - m[0] * A).epsilon(1e-13));
    }
    CHECK(d(f[8]) == Approx(m[1] * F * vx).epsilon(1e-13));
    CHECK(d(f[9]) == Approx(m[0] * F * vx).epsilon(1e-13));
  }
  // Density diffusion: 2 delta h c (m_j / rho_j) (rho_i - rho_j) F.
  const auto diffused =
      rate_of<Wide>(scenario, "sph{kernel=wendland-c2,smoothing=1,viscosity=none,density_diffusion=0.1}");
  CHECK(d(diffused[8]) == Approx(m[1] * F * vx + 2 * 0.1 * 0.5 * 10 * m[1] / rho[1] * 200 * F).epsilon(1e-13));
  // Heat: conduction and the power of Morris's viscosity, half to each.
  fluid.heat_capacity_J_per_kg_K = 5;
  fluid.conductivity_W_per_m_K = 7;
  fluid.viscous_heat = true;
  const auto f = rate_of<Wide>(scenario, "sph{kernel=wendland-c2,smoothing=1}");
  const double power = -0.5 * 2 * mu / (rho[0] * rho[1]) * F * (v[0] * v[0] + v[1] * v[1]);
  const double conduction = 2 * 7 * (300 - 310) * F / (rho[0] * rho[1]);
  CHECK(d(f[10]) == Approx(m[1] * (conduction + power) / 5).epsilon(1e-13));
  CHECK(d(f[11]) == Approx(m[0] * (-conduction + power) / 5).epsilon(1e-13));
  // Summed densities: m_i W(0) + m_j W, W(0) = 7 / pi, W(1/2) = 7 / pi 3 / 16.
  const auto system = fluid_system<Wide>(scenario.scene, "sph{kernel=wendland-c2,smoothing=1,density=summation}");
  const auto y = initial_state<Wide>(scenario.scene, system->data.layout);
  CHECK(d(system->densities(y.data())[0]) == Approx(7 / M_PI * (2 + 3 * 3.0 / 16)).epsilon(1e-13));
}

TEST_CASE("The pair form conserves momentum, and angular momentum with central forces, and energy with heat") {
  Scenario scenario = disturbed(8, 1);
  Fluid& fluid = scenario.scene.fluids[0];
  fluid.equation_of_state = EquationOfState::tait;
  fluid.heat_capacity_J_per_kg_K = 3;
  fluid.conductivity_W_per_m_K = 10;
  fluid.viscous_heat = true;
  for (const char* viscosity : {"morris", "central"}) {
    const std::string response = std::string("sph{kernel=wendland-c4,smoothing=1.5,viscosity=") + viscosity + "}";
    const auto f = rate_of<Wide>(scenario, response);
    const Particles& at = fluid.particles;
    const int n = 64;
    Wide momentum[2] = {0, 0}, power = 0, size = 0;
    for (int i = 0; i < n; ++i) {
      const Wide rho = at.density_kg_per_m3[i], p = pressure_of<Wide>(fluid, rho), m = at.mass_kg[i];
      for (int a = 0; a < 2; ++a) {
        momentum[a] += m * f[2 * n + 2 * i + a];
        power += m * Wide(at.velocity_m_per_s[i][a]) * f[2 * n + 2 * i + a];
        size += magnitude(m * Wide(at.velocity_m_per_s[i][a]) * f[2 * n + 2 * i + a]);
      }
      power += m * p / (rho * rho) * f[4 * n + i] + m * 3 * f[5 * n + i];
    }
    CHECK(d(magnitude(momentum[0])) < 1e-28 * d(size));
    CHECK(d(magnitude(momentum[1])) < 1e-28 * d(size));
    CHECK(d(magnitude(power)) < 1e-28 * d(size));
  }
  // A block in open space turns with its angular momentum under central forces, not under Morris's.
  scenario.scene.domain.periodic_m = {0, 0, 0};
  for (const bool central : {false, true}) {
    const auto f = rate_of<Wide>(
        scenario, std::string("sph{kernel=quintic,smoothing=1,viscosity=") + (central ? "central}" : "morris}"));
    const Particles& at = fluid.particles;
    Wide turn = 0, size = 0;
    for (int i = 0; i < 64; ++i) {
      const Wide m = at.mass_kg[i], torque = m * (Wide(at.position_m[i][0]) * f[128 + 2 * i + 1] -
                                                  Wide(at.position_m[i][1]) * f[128 + 2 * i]);
      turn += torque;
      size += magnitude(torque);
    }
    if (central) CHECK(d(magnitude(turn)) < 1e-28 * d(size));
    else CHECK(d(magnitude(turn)) > 1e-6 * d(size));
  }
}

TEST_CASE("Neighbours by cells are those of all pairs, whatever the images") {
  Scenario scenario = disturbed(20, 2);  // 400 points: cells
  auto data = particle_data<double>(scenario.scene, true);
  std::vector<Vec<double>> x;
  Draw draw(3);
  for (const Real3& p : scenario.scene.fluids[0].particles.position_m)
    x.push_back({p[0] + std::floor(draw(-3, 3)), p[1] + std::floor(draw(-3, 3)), 0});
  for (const bool periodic : {true, false}) {
    if (!periodic) data.period = {};
    const auto near = neighbours_of<double>(data, x, 0.13);
    std::size_t pairs = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      std::vector<int> expected;
      for (std::size_t j = 0; j < x.size(); ++j) {
        double r2 = 0;
        for (int a = 0; a < 2; ++a) {
          double gap = x[i][a] - x[j][a];
          if (periodic) gap -= std::round(gap);
          r2 += gap * gap;
        }
        if (j != i && r2 < 0.13 * 0.13) expected.push_back(static_cast<int>(j));
      }
      std::vector<int> found;
      for (const auto& each : near[i]) found.push_back(each.other);
      CHECK(found == expected);
      pairs += found.size();
    }
    CHECK(pairs > 0);
  }
}

TEST_CASE("Gradients with correction and fits of degree P are exact for what they are exact for") {
  // Linear fields: with `corrected`, dv/dt is -c^2 grad rho / rho and drho/dt is -rho div v, away from the border.
  Scenario scenario = disturbed(12, 4, 0.4);
  scenario.scene.domain.periodic_m = {0, 0, 0};
  Fluid& fluid = scenario.scene.fluids[0];
  fluid.viscosity_m2_per_s = 0;
  for (std::size_t i = 0; i < fluid.particles.position_m.size(); ++i) {
    const Real3& x = fluid.particles.position_m[i];
    fluid.particles.velocity_m_per_s[i] = {0.3 * x[0] - 0.2 * x[1], 0.5 * x[0] + 0.1 * x[1], 0};
    fluid.particles.density_kg_per_m3[i] = 1000 + 3 * x[0] - 2 * x[1];
  }
  const int n = 144, middle = 6 * 12 + 6;
  const double rho = fluid.particles.density_kg_per_m3[middle];
  const auto corrected = rate_of<Wide>(scenario, "sph{kernel=wendland-c2,smoothing=1.4,viscosity=none,corrected=true}");
  CHECK(d(corrected[2 * n + 2 * middle]) == Approx(-100 * 3 / rho).epsilon(1e-12));
  CHECK(d(corrected[2 * n + 2 * middle + 1]) == Approx(100 * 2 / rho).epsilon(1e-12));
  CHECK(d(corrected[4 * n + middle]) == Approx(-rho * 0.4).epsilon(1e-12));
  // A quartic velocity: exact with degree 4, its Laplacian and divergence; the filter vanishes. shift = 0.
  // Of a period that the particles do not fill: neighbourhoods end at the border, and no free surface is stated.
  scenario.scene.domain.periodic_m = {100, 100, 0};
  fluid.region = BoxRegion{{0, 0, 0}, {100, 100, 0}};
  fluid.viscosity_m2_per_s = 0.7;
  for (std::size_t i = 0; i < fluid.particles.position_m.size(); ++i) {
    const Real3& x = fluid.particles.position_m[i];
    fluid.particles.velocity_m_per_s[i] = {std::pow(x[0], 4) + x[0] * x[1], std::pow(x[1], 3) - x[0] * x[0], 0};
    fluid.particles.density_kg_per_m3[i] = 1000;
  }
  const Real3 at = fluid.particles.position_m[middle];
  const auto fitted = rate_of<Wide>(scenario, "polynomial{degree=4,smoothing=1.6,shift=0,filter=0.1}");
  CHECK(d(fitted[2 * n + 2 * middle]) == Approx(0.7 * 12 * at[0] * at[0]).epsilon(1e-9));
  CHECK(d(fitted[2 * n + 2 * middle + 1]) == Approx(0.7 * (6 * at[1] - 2)).epsilon(1e-9));
  CHECK(d(fitted[4 * n + middle]) ==
        Approx(-1000 * (4 * std::pow(at[0], 3) + at[1] + 3 * at[1] * at[1])).epsilon(1e-9));
  const auto second = rate_of<Wide>(scenario, "polynomial{degree=2,smoothing=1.3,shift=0,filter=0}");
  CHECK(std::fabs(d(second[4 * n + middle]) / d(fitted[4 * n + middle]) - 1) > 1e-6);  // degree 2 is not exact here
}

TEST_CASE("The truth of the particles' equations: bars hold against CVODE, energy is kept, refusals have names") {
  Scenario scenario = disturbed(6, 5);
  scenario.t_end_s = 0.004;
  scenario.truth.kind = TruthKind::semi_discrete;
  scenario.truth.response = "sph{kernel=wendland-c4,smoothing=1.5,viscosity=none}";
  const Truth truth = semi_discrete_truth(scenario, 4);
  INFO(truth.outcome.reason);
  REQUIRE(truth.outcome.status == Status::ok);
  INFO(truth.source);
  REQUIRE(truth.values.size() == 5);
  REQUIRE(truth.values[4].particles.size() == 36);
  CHECK(d(truth.bars[4].particles[0].v_m_per_s[0]) < 1e-13);
  CHECK(d(truth.bars[4].particles[0].v_m_per_s[0]) > 0);
  CHECK(truth.bars[0].particles[0].v_m_per_s[0] == 0);
  // Kinetic and elastic energy of the linear equation of state: c^2 (ln(rho / rho0) + rho0 / rho - 1).
  const auto energy = [&](const SampleView& sample) {
    Wide sum = 0;
    for (const ParticleSample& each : sample.particles) {
      Wide square = 0;
      for (const Wide& v : each.v_m_per_s) square += v * v;
      sum += square / 2 + 100 * (log(each.density_kg_per_m3 / 1000) + 1000 / each.density_kg_per_m3 - 1);
    }
    return sum;
  };
  CHECK(d(magnitude(energy(truth.values[4]) / energy(truth.values[0]) - 1)) < 1e-13);
  scenario.truth.response = "sph{kernel=wendland-c4}";
  CHECK_THAT(semi_discrete_truth(scenario, 4).outcome.reason, Catch::Contains("smoothing"));
  scenario.truth.response = "sph{kernel=gauss,smoothing=1}";
  CHECK_THAT(semi_discrete_truth(scenario, 4).outcome.reason, Catch::Contains("gauss"));
  Scenario open = scenario;
  open.scene.domain.periodic_m[1] = 0;
  open.truth.response = "polynomial{degree=2}";
  CHECK_THAT(semi_discrete_truth(open, 4).outcome.reason, Catch::Contains("free surface"));
  scenario.truth.response = "";
  CHECK(semi_discrete_truth(scenario, 4).outcome.status == Status::unsupported);
  scenario.scene.fluids[0].particles = {};
  scenario.truth.response = "sph{kernel=cubic,smoothing=1}";
  CHECK_THAT(semi_discrete_truth(scenario, 4).outcome.reason, Catch::Contains("no particles"));
}

TEST_CASE("The truth of more than 256 particles: bars that are small and hold against small steps of Runge and Kutta") {
  Scenario scenario = disturbed(17, 6);
  scenario.t_end_s = 0.03;
  scenario.truth.kind = TruthKind::semi_discrete;
  for (const char* response :
       {"polynomial{degree=4,smoothing=1.55,shift=1,filter=0.1}", "sph{kernel=wendland-c2,smoothing=1.5,shift=1}"}) {
    scenario.truth.response = response;
    const Truth truth = semi_discrete_truth(scenario, 2);
    INFO(response << ": " << truth.source << truth.outcome.reason);
    REQUIRE(truth.outcome.status == Status::ok);
    const auto system = fluid_system<double>(scenario.scene, response);
    const ParticleLayout& layout = system->data.layout;
    std::vector<double> y = initial_state<double>(scenario.scene, layout), k[4];
    constexpr int kSteps = 400;
    const double h = scenario.t_end_s / kSteps;
    for (int n = 0; n < kSteps; ++n) {
      std::vector<double> at = y;
      for (int stage = 0; stage < 4; ++stage) {
        const double along = stage == 0 ? 0 : stage == 3 ? h : h / 2;
        if (stage > 0)
          for (std::size_t i = 0; i < y.size(); ++i) at[i] = y[i] + along * k[stage - 1][i];
        k[stage].resize(y.size());
        system->rate(n * h + along, at.data(), k[stage].data());
      }
      for (std::size_t i = 0; i < y.size(); ++i) y[i] += h / 6 * (k[0][i] + 2 * k[1][i] + 2 * k[2][i] + k[3][i]);
    }
    const double bar = d(truth.bars[2].particles[0].v_m_per_s[0]);
    CHECK(bar < 2e-8);
    double largest = 0;
    for (int i = 0; i < layout.count; ++i)
      for (int a = 0; a < 2; ++a)
        largest = std::fmax(largest,
                            std::fabs(d(truth.values[2].particles[i].v_m_per_s[a]) - y[layout.velocity + 2 * i + a]));
    CAPTURE(largest);
    CHECK(largest <= bar);
  }
}
