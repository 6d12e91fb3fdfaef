// The weakly compressible equations by Fourier collocation: the rate against formulas, convergence, exact solutions,
// the error of the incompressible model.
#include <catch2/catch.hpp>

#include "fluid_scenes.hpp"
#include "fluid_truth/field.hpp"
#include "fluid_truth/spectral.hpp"

using namespace atwood;
using namespace atwood::fluid_truth;

namespace {

double d(Wide x) { return static_cast<double>(x); }

std::vector<FieldPosition> random_positions(int n, std::uint64_t seed) {
  Draw draw(seed);
  std::vector<FieldPosition> made;
  for (int k = 0; k < n; ++k) made.push_back({Wide(draw(-1, 2)), Wide(draw(-1, 2)), 0});
  return made;
}

Scenario vortices(double c) {
  Scenario made = fluid_scenario("taylor-green");
  made.truth.kind = TruthKind::weakly_compressible;
  made.t_end_s = 0.5;
  made.scene.fluids[0].sound_speed_m_per_s = c;
  return made;
}

}  // namespace

TEST_CASE("The spectral rate is the equations' right-hand side, with both viscous terms") {
  // u = sin a cos b, v = cos(a + 2 b), rho = 2 + sin(a - b) / 4 with a = 2 pi x / 2, b = 2 pi y: derivatives by hand.
  const double kx = M_PI, ky = 2 * M_PI;
  for (const double beta : {0.0, 2.0}) {
    SpectralProblem problem;
    problem.period_x = 2, problem.period_y = 1;
    problem.rho0 = 2, problem.c = 3, problem.gamma = 7, problem.nu = 0.05, problem.beta = beta;
    problem.gravity = {0.3, -0.2};
    problem.initial = [=](double x, double y) -> std::array<double, 3> {
      const double a = kx * x, b = ky * y;
      return {std::sin(a) * std::cos(b), std::cos(a + 2 * b), 2 + std::sin(a - b) / 4};
    };
    const int n = 15;
    Spectral spectral(problem, n, 1e-10, 1);
    const std::vector<double> y = spectral.state_at(0);
    std::vector<double> f(y.size());
    spectral.rate(0, y.data(), f.data());
    for (const auto& [i, j] : {std::pair{0, 0}, std::pair{3, 11}, std::pair{14, 7}}) {
      const double a = kx * 2.0 * i / n, b = ky * j / static_cast<double>(n), sa = std::sin(a), ca = std::cos(a),
                   sb = std::sin(b), cb = std::cos(b);
      const double u = sa * cb, v = std::cos(a + 2 * b), rho = 2 + std::sin(a - b) / 4, slope = std::cos(a - b) / 4;
      const double ux = kx * ca * cb, uy = -ky * sa * sb, vx = -kx * std::sin(a + 2 * b), vy = 2 * vx / kx * ky;
      const double lap_u = -(kx * kx + ky * ky) * u, lap_v = -(kx * kx + 4 * ky * ky) * v;
      const double divergence_x = -kx * kx * sa * cb - 2 * kx * ky * v,
                   divergence_y = -kx * ky * ca * sb - 4 * ky * ky * v;
      const double stiff = 9 * std::pow(rho / 2, 6) / rho, mu = 2 * 0.05 / rho;
      const std::size_t at = static_cast<std::size_t>(i) * n + j, size = static_cast<std::size_t>(n) * n;
      CHECK(f[at] ==
            Approx(0.3 - u * ux - v * uy - stiff * kx * slope + mu * (lap_u + beta * divergence_x)).epsilon(1e-12));
      CHECK(f[size + at] ==
            Approx(-0.2 - u * vx - v * vy + stiff * ky * slope + mu * (lap_v + beta * divergence_y)).epsilon(1e-12));
      CHECK(f[2 * size + at] == Approx(-u * kx * slope + v * ky * slope - rho * (ux + vy)).epsilon(1e-12));
      const SpectralPoint point = spectral.interpolate(y, 0.37 + 4, 0.81 - 3);
      CHECK(point.u == Approx(std::sin(kx * 0.37) * std::cos(ky * 0.81)).epsilon(1e-12));
      CHECK(point.rho == Approx(2 + std::sin(kx * 0.37 - ky * 0.81) / 4).epsilon(1e-12));
    }
  }
}

TEST_CASE("Parallel streams and manufactured fields come out of the compressible equations as they are") {
  for (const char* name : {"shear", "mms-2d"}) {
    Scenario scenario = fluid_scenario(name);
    scenario.t_end_s = 0.15;
    Fluid& fluid = scenario.scene.fluids[0];
    if (std::string(name) == "mms-2d") {
      fluid.initial.parameters = {
          {"speed_m_per_s", 1}, {"angular_frequency_rad_per_s", 3}, {"density_amplitude", 0.05}};
      fluid.source = fluid.initial;
    }
    const FluidField exact = fluid_field_of(scenario);
    REQUIRE(exact.outcome.status == Status::ok);
    scenario.truth.kind = TruthKind::weakly_compressible;
    const FluidField field = fluid_field_of(scenario, "sph{viscosity=morris}");
    INFO(field.outcome.reason);
    REQUIRE(field.outcome.status == Status::ok);
    const auto positions = random_positions(20, 1);
    const FieldSample a = exact.at(Wide(0.15), positions), b = field.at(Wide(0.15), positions);
    for (std::size_t k = 0; k < positions.size(); ++k) {
      for (int i = 0; i < 2; ++i) {
        const double error = std::fabs(d(a.values[k].v_m_per_s[i] - b.values[k].v_m_per_s[i]));
        CHECK(error < 1e-8);
        CHECK(error <= d(b.bars[k].v_m_per_s[i]) + 1e-14);
      }
      CHECK(std::fabs(d(a.values[k].density_kg_per_m3 - b.values[k].density_kg_per_m3)) < 1e-6);
    }
  }
}

TEST_CASE("The incompressible model of Taylor and Green's vortices is off by some 0.072 M^2") {
  const auto positions = random_positions(200, 2);
  Scenario scenario = vortices(10);
  const FluidField compressible = fluid_field_of(scenario, "sph{viscosity=morris}");
  INFO(compressible.outcome.reason);
  REQUIRE(compressible.outcome.status == Status::ok);
  scenario.truth.kind = TruthKind::closed_form;
  const FluidField model = fluid_field_of(scenario);
  const FieldSample a = compressible.at(Wide(0.5), positions), b = model.at(Wide(0.5), positions);
  double error = 0, size = 0, bar = 0;
  for (std::size_t k = 0; k < positions.size(); ++k) {
    const auto &v = a.values[k].v_m_per_s, &w = b.values[k].v_m_per_s;
    error += std::hypot(d(v[0] - w[0]), d(v[1] - w[1]));
    size += std::hypot(d(w[0]), d(w[1]));
    bar = std::max(bar, d(a.bars[k].v_m_per_s[0]));
  }
  CHECK(error / size * 100 > 0.06);
  CHECK(error / size * 100 < 0.085);
  CHECK(bar < 1e-6);
  CHECK(bar < 3e-3 * error / static_cast<double>(positions.size()));
}

TEST_CASE("Each viscous term has a solution of its own") {
  const auto positions = random_positions(50, 4);
  Scenario scenario = vortices(5);
  scenario.t_end_s = 0.1;
  const FieldSample a = fluid_field_of(scenario, "sph{viscosity=morris}").at(Wide(0.1), positions),
                    b = fluid_field_of(scenario, "sph{viscosity=central}").at(Wide(0.1), positions),
                    c = fluid_field_of(scenario, "polynomial{degree=4}").at(Wide(0.1), positions);
  double apart = 0, bar = 0;
  for (std::size_t k = 0; k < positions.size(); ++k) {
    apart = std::max(apart, std::fabs(d(b.values[k].v_m_per_s[0] - a.values[k].v_m_per_s[0])));
    bar = std::max(bar, d(a.bars[k].v_m_per_s[0]));
    CHECK(d(c.values[k].v_m_per_s[0]) == d(a.values[k].v_m_per_s[0]));
  }
  CHECK(apart > 5 * bar);
}

TEST_CASE("One solution serves all arrangements of the particles, and no other fluid, start or length of the run") {
  const auto positions = random_positions(3, 5);
  const auto field_of = [&](const Scenario& scenario) {
    return fluid_field_of(scenario, "sph{viscosity=morris}").at(Wide(0.1), positions).values;
  };
  Scenario first = vortices(5);
  first.t_end_s = 0.1;
  const auto values = field_of(first);
  Scenario other = first;
  other.scene.fluids[0].seed = 7;
  other.scene.fluids[0].spacing_m = 0.01;
  other.scene.fluids[0].particles = {};
  CHECK(field_of(other)[0].v_m_per_s == values[0].v_m_per_s);
  for (const auto& change : {+[](Scenario& s) { s.scene.fluids[0].viscosity_m2_per_s *= 2; },
                             +[](Scenario& s) { s.scene.fluids[0].sound_speed_m_per_s = 6; },
                             +[](Scenario& s) { s.scene.fluids[0].initial.parameters["speed_m_per_s"] = 0.5; }}) {
    Scenario changed = first;
    change(changed);
    CHECK(field_of(changed)[0].v_m_per_s != values[0].v_m_per_s);
    CHECK(field_of(first)[0].v_m_per_s == values[0].v_m_per_s);
  }
}

TEST_CASE("What a linear wave neglects lies within its bars, and what is asked first does not change the answer") {
  Scenario scenario = fluid_scenario("standing-wave");
  scenario.t_end_s = 0.12;
  Fluid& fluid = scenario.scene.fluids[0];
  fluid.initial.parameters = {{"amplitude", 1e-3}};
  fluid.equation_of_state = EquationOfState::tait;
  for (const char* response : {"sph{viscosity=morris}", "sph{viscosity=central}"}) {
    scenario.truth.kind = TruthKind::closed_form;
    const FluidField linear = fluid_field_of(scenario, response);
    scenario.truth.kind = TruthKind::weakly_compressible;
    const FluidField whole = fluid_field_of(scenario, response);
    Scenario other = scenario;
    other.t_end_s = 0.01;
    fluid_field_of(other, response);  // the last solution is kept: this one takes its place
    const FluidField again = fluid_field_of(scenario, response);
    REQUIRE(whole.outcome.status == Status::ok);
    const auto positions = random_positions(30, 3);
    for (const double t : {0.12, 0.03, 0.07}) {
      const FieldSample a = linear.at(t, positions), b = whole.at(t, positions);
      double error = 0, bar = 0;
      for (std::size_t k = 0; k < positions.size(); ++k) {
        error = std::max(error, std::fabs(d(a.values[k].v_m_per_s[0] - b.values[k].v_m_per_s[0])));
        bar = d(a.bars[k].v_m_per_s[0]);
      }
      CHECK(error < bar);
      CHECK(bar < 100 * error);
    }
    CHECK(d(again.at(Wide(0.07), positions).values[0].v_m_per_s[0]) ==
          d(whole.at(Wide(0.07), positions).values[0].v_m_per_s[0]));
  }
}

TEST_CASE("Scenes that the spectral solution does not cover are refused by name") {
  Scenario scenario = vortices(10);
  scenario.scene.domain.periodic_m[1] = 0;
  CHECK_THAT(fluid_field_of(scenario).outcome.reason, Catch::Contains("doubly periodic"));
  scenario = vortices(10);
  scenario.scene.fluids[0].initial.name = "elliptic-drop";
  CHECK_THAT(fluid_field_of(scenario).outcome.reason, Catch::Contains("elliptic-drop"));
  scenario = vortices(10);
  CHECK_THAT(fluid_field_of(scenario, "sph{viscosity=x}").outcome.reason, Catch::Contains("viscosity=morris"));
}
