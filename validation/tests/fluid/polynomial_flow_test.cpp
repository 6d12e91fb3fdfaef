// Flows by +polynomial whose exact solutions are known: orders in space, decay rates, uniform flow, refusals.
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>

#include "fluid/polynomial.hpp"
#include "rk4_run.hpp"
#include "scene/split_mix.hpp"

using namespace atwood;
using namespace atwood::fluid;

namespace {

constexpr double kPi = 3.14159265358979323846;

// A periodic square of 1 m with n^2 particles, each moved by up to `disturbance` of the spacing.
Scene square(int n, double disturbance, double sound_speed) {
  Scene scene;
  scene.domain.dimensions = 2;
  scene.domain.periodic_m = {1, 1, 0};
  Fluid fluid;
  fluid.name = "water";
  fluid.spacing_m = 1.0 / n;
  fluid.density_kg_per_m3 = 1;
  fluid.sound_speed_m_per_s = sound_speed;
  fluid.viscosity_m2_per_s = 0.01;
  SplitMix64 random{3};
  for (int i = 0; i < n * n; ++i) {
    const double x = (i / n + 0.5 + disturbance * random.next_unit()) / n;
    const double y = (i % n + 0.5 + disturbance * random.next_unit()) / n;
    fluid.particles.position_m.push_back({x, y, 0});
    fluid.particles.velocity_m_per_s.push_back({0, 0, 0});
    fluid.particles.density_kg_per_m3.push_back(1);
    fluid.particles.temperature_K.push_back(0);
    fluid.particles.mass_kg.push_back(fluid.spacing_m * fluid.spacing_m);
  }
  scene.fluids.push_back(fluid);
  return scene;
}

void set_velocities(Scene& scene, const std::function<Real3(const Real3&)>& of) {
  Particles& particles = scene.fluids.front().particles;
  for (std::size_t i = 0; i < particles.position_m.size(); ++i)
    particles.velocity_m_per_s[i] = of(particles.position_m[i]);
}

// The state at t_end_s by RK4 with a Courant number of .7; empty, with the fault, where the run ends earlier.
std::vector<double> run(Polynomial<double>& fluid, const Scene& scene, double t_end_s, std::string* fault = nullptr) {
  const Fluid& f = scene.fluids.front();
  const int steps = static_cast<int>(std::ceil(t_end_s * f.sound_speed_m_per_s / (0.7 * f.spacing_m)));
  return run_rk4(fluid, t_end_s, steps, fault);
}

// Mean error of the velocity over its mean size at t = .25 s of u = sin(2 pi y), which decays by exp(-4 pi^2 nu t) in
// the weakly compressible equations too.
double shear_error(int n, int degree) {
  Scene scene = square(n, 0.2, 10);
  set_velocities(scene, [](const Real3& x) { return Real3{std::sin(2 * kPi * x[1]), 0, 0}; });
  PolynomialOptions options;
  options.degree = degree;
  Polynomial<double> fluid(scene, options);
  REQUIRE(fluid.unsupported() == "");
  const std::vector<double> y = run(fluid, scene, 0.25);
  const Layout& at = fluid.layout();
  double error = 0, size = 0;
  for (int i = 0; i < at.particles; ++i) {
    const double exact = std::exp(-4 * kPi * kPi * 0.01 * 0.25) * std::sin(2 * kPi * y[2 * i + 1]);
    error += std::hypot(y[at.velocities() + 2 * i] - exact, y[at.velocities() + 2 * i + 1]);
    size += std::abs(exact);
  }
  return error / size;
}

double fitted_order(const std::vector<int>& counts, int degree, double& finest) {
  double sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (const int n : counts) {
    finest = shear_error(n, degree);
    const double x = -std::log(double(n)), y = std::log(finest);
    sx += x, sy += y, sxx += x * x, sxy += x * y;
  }
  const double count = static_cast<double>(counts.size());
  return (count * sxy - sx * sy) / (count * sxx - sx * sx);
}

}  // namespace

TEST_CASE("A shear flow on disturbed particles: order 2 with degree 2, small errors with degree 4") {
  double finest = 0;
  CHECK(fitted_order({12, 16, 24, 32}, 2, finest) == Approx(2).margin(0.25));
  CHECK(finest < 1e-3);
  // The Laplacian of degree 4 is of order 3 on disturbed particles, and shear flow has no larger error.
  CHECK(fitted_order({20, 28, 40, 56}, 4, finest) == Approx(2.5).margin(0.4));
  CHECK(finest < 3e-6);
}

TEST_CASE("Uniform flow stays uniform to round-off while particles are shifted") {
  Scene scene = square(12, 0.2, 10);
  set_velocities(scene, [](const Real3&) { return Real3{1, 0.5, 0}; });
  for (const int degree : {2, 4}) {
    PolynomialOptions options;
    options.degree = degree;
    Polynomial<double> fluid(scene, options);
    const std::vector<double> y = run(fluid, scene, 0.3);
    const Layout& at = fluid.layout();
    double moved = 0;
    for (int i = 0; i < at.particles; ++i) {
      CHECK(std::abs(y[at.velocities() + 2 * i] - 1) < 1e-12);
      CHECK(std::abs(y[at.velocities() + 2 * i + 1] - 0.5) < 1e-12);
      CHECK(std::abs(y[at.densities() + i] - 1) < 1e-12);
      moved = std::max(moved, std::abs(y[2 * i] - scene.fluids.front().particles.position_m[i][0] - 0.3));
    }
    CHECK(moved > 0.001);
  }
}

TEST_CASE("A sine of temperature decays at its rate, and viscous heat is the power that viscosity takes") {
  Scene scene = square(16, 0.2, 1);
  Fluid& f = scene.fluids.front();
  f.heat_capacity_J_per_kg_K = 2;
  f.conductivity_W_per_m_K = 0.02;
  for (std::size_t i = 0; i < f.particles.temperature_K.size(); ++i)
    f.particles.temperature_K[i] = std::sin(2 * kPi * f.particles.position_m[i][0]);
  Polynomial<double> fluid(scene, {});
  const std::vector<double> y = run(fluid, scene, 1);
  const Layout& at = fluid.layout();
  double error = 0;
  for (int i = 0; i < at.particles; ++i)
    error = std::max(
        error, std::abs(y[at.temperatures() + i] - std::exp(-4 * kPi * kPi * 0.01) * std::sin(2 * kPi * y[2 * i])));
  CHECK(error < 1e-3);

  f.viscous_heat = true;
  for (double& T : f.particles.temperature_K) T = 0;
  set_velocities(scene, [](const Real3& x) { return Real3{std::sin(2 * kPi * x[1]), 0, 0}; });
  Polynomial<double> hot(scene, {});
  std::vector<double> start(hot.layout().size()), rate(start.size());
  hot.initial_state(start.data());
  hot.system().rate(0, start.data(), rate.data());
  for (int i = 0; i < at.particles; ++i) {
    const double slope = 2 * kPi * std::cos(2 * kPi * start[2 * i + 1]);
    CHECK(rate[at.temperatures() + i] == Approx(0.01 * slope * slope / 2).margin(2e-3));
  }
}

TEST_CASE("Threads give the same bits") {
  Scene scene = square(24, 0.2, 10);
  set_velocities(scene, [](const Real3& x) {
    return Real3{-std::cos(2 * kPi * x[0]) * std::sin(2 * kPi * x[1]),
                 std::sin(2 * kPi * x[0]) * std::cos(2 * kPi * x[1]), 0};
  });
  PolynomialOptions options;
  Polynomial<double> one(scene, options);
  options.threads = 3;
  Polynomial<double> three(scene, options);
  CHECK(run(one, scene, 0.02) == run(three, scene, 0.02));
}

TEST_CASE("Degree 4 from a perfect lattice that is strained is refused with the condition of the fit") {
  Scene scene = square(16, 0, 10);
  set_velocities(scene, [](const Real3& x) {
    return Real3{-std::cos(2 * kPi * x[0]) * std::sin(2 * kPi * x[1]),
                 std::sin(2 * kPi * x[0]) * std::cos(2 * kPi * x[1]), 0};
  });
  Polynomial<double> fluid(scene, {});
  std::string fault;
  CHECK(run(fluid, scene, 0.3, &fault).empty());
  CHECK(fault.find("does not determine a polynomial of degree 4") != std::string::npos);
}
