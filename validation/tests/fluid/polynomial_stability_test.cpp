// The stability limit of +polynomial: just below it noise grows no more than with short steps, above it it explodes: a
// quarter above that of rk4. Heun's and Dormand and Prince's methods are unstable first on long undamped sound waves,
// which the filter may damp: four times above their limit.
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>

#include "fluid/polynomial.hpp"
#include "fluid/run.hpp"
#include "fluid/spectrum.hpp"
#include "integrators/catalogue.hpp"
#include "scenes.hpp"

using namespace atwood;
using namespace atwood::fluid;

namespace {

// Disturbed particles in periodic space, almost at rest: the noise has all wave lengths.
Scene noisy_scene() {
  Scene scene = block_scene({.across = 12, .spacing_m = 1.0 / 12});
  Particles& particles = scene.fluids.front().particles;
  SplitMix64 random{7};
  for (std::size_t i = 0; i < particles.position_m.size(); ++i) {
    particles.velocity_m_per_s[i] = {1e-6 * (random.next_unit() - 0.5), 1e-6 * (random.next_unit() - 0.5), 0};
    particles.density_kg_per_m3[i] = 1000;
  }
  return scene;
}

// The limit that a refusal of long steps prints for a run of so many steps at the limit.
double limit_s(const std::string& method, const Scene& scene, int steps) {
  double t_end_s = 100, limit = 0;
  for (int n = 0; n < 8; ++n, t_end_s = steps * limit) {
    const Outcome refused = run_fluid(parse_method_id(method), scene, {t_end_s, 10, 1, {}}, {}, 0);
    INFO(refused.reason);
    REQUIRE(refused.status == Status::unsupported);
    const std::string before = "stability limit of ";
    const std::size_t at = refused.reason.find(", ", refused.reason.find(before));
    REQUIRE(at != std::string::npos);
    limit = std::stod(refused.reason.substr(at + 2));
  }
  return limit;
}

// The number of steps that a refusal asks for; 0: the run was not refused.
std::int64_t needed_steps(const std::string& method, const Scene& scene, double t_end_s, std::int64_t steps,
                          std::int64_t samples) {
  const Outcome made = run_fluid(parse_method_id(method), scene, {t_end_s, steps, samples, {}}, {}, 0);
  const std::string before = "needs at least ";
  const std::size_t at = made.reason.find(before);
  INFO(method << ": " << made.reason);
  REQUIRE((made.status == Status::unsupported) == (at != std::string::npos));
  return at == std::string::npos ? 0 : std::stoll(made.reason.substr(at + before.size()));
}

double largest_speed(const std::string& scheme, const Scene& scene, int degree, double h_s, int steps) {
  PolynomialOptions options;
  options.degree = degree;
  options.shift = 0;
  options.filter = 0.2;  // with less, noise grows without an error of time too
  Polynomial<double> particles(scene, options);
  auto stepper = make_stepper<double>(scheme, particles.system(), {});
  REQUIRE(stepper);
  const Layout& at = particles.layout();
  std::vector<double> y(at.size()), next(at.size());
  particles.initial_state(y.data());
  for (int n = 0; n < steps; ++n) {
    (*stepper)->step(n * h_s, h_s, y.data(), next.data());
    y.swap(next);
  }
  double most = 0;
  for (int i = at.velocities(); i < at.densities(); ++i)
    if (!(std::abs(y[i]) <= most)) most = std::abs(y[i]);
  return most;
}

}  // namespace

TEST_CASE("steps of +polynomial below the limit are stable, steps above it are not") {
  const Scene scene = noisy_scene();
  for (const int degree : {2, 4})
    for (const char* scheme : {"rk4", "heun", "dopri5"}) {
      const int steps = 1000;
      const double limit = limit_s(
          "atwood/" + std::string(scheme) + "+polynomial{degree=" + std::to_string(degree) + ",shift=0,filter=0.2}",
          scene, steps);
      INFO(scheme << " degree " << degree << " limit " << limit << " s");
      const double below = 0.97 * limit, above = (scheme == std::string("rk4") ? 1.25 : 4) * limit;
      CHECK(largest_speed(scheme, scene, degree, below, steps) <
            3 * largest_speed(scheme, scene, degree, below / 4, 4 * steps));
      CHECK_FALSE(largest_speed(scheme, scene, degree, above, steps) <
                  100 * largest_speed(scheme, scene, degree, above / 4, 4 * steps));
    }
}

TEST_CASE("the number of steps that a refusal asks for is accepted, and a tenth less is not") {
  const Scene scene = noisy_scene();
  const double t_end_s = 0.1;
  const std::int64_t samples = 2;
  for (const char* response : {"+polynomial{degree=2,shift=0,filter=0.2}", "+sph"})
    for (const char* scheme : {"explicit-euler", "heun", "rk4"}) {
      const std::string method = "atwood/" + std::string(scheme) + response;
      const std::int64_t needed = needed_steps(method, scene, t_end_s, samples, samples);
      REQUIRE(needed > samples);
      CHECK(needed % samples == 0);
      CHECK(needed_steps(method, scene, t_end_s, needed, samples) == 0);
      const std::int64_t fewer = std::max(samples, needed * 9 / 10 / samples * samples);
      if (fewer < needed) CHECK(needed_steps(method, scene, t_end_s, fewer, samples) == needed);
    }
}

TEST_CASE("extremal eigenvalues of a matrix whose spectrum is known") {
  // y' = A y with eigenvalues -1 -+ 50 i, -200 and many between 0 and -1, in units of their own.
  System<double> system;
  system.size = 60;
  system.rate_of = [](void*, double, const double* y, double* dydt) {
    dydt[0] = -1 * y[0] - 50 * 1e3 * y[1];
    dydt[1] = 50 * 1e-3 * y[0] - y[1];
    dydt[2] = -200 * y[2];
    for (int i = 3; i < 60; ++i) dydt[i] = -(i / 60.0) * y[i];
  };
  std::vector<double> y(60, 0.0), scale(60, 1.0);
  scale[0] = 1e3;
  bool decay = false, oscillation = false;
  const Spectrum spectrum = extremal_eigenvalues(system, 0, y.data(), scale, 20);
  CHECK(spectrum.residual < 1e-6);
  CHECK(extremal_eigenvalues(system, 0, y.data(), scale, 2).residual > 1e-3);  // known to no more
  for (const std::complex<double>& lambda : spectrum.eigenvalues) {
    decay = decay || std::abs(lambda + 200.0) < 1e-3;
    oscillation = oscillation || std::abs(lambda - std::complex<double>(-1, 50)) < 1e-3;
    CHECK(std::abs(lambda) < 200.001);
  }
  CHECK(decay);
  CHECK(oscillation);
  system.rate_of = [](void*, double, const double*, double* dydt) { std::fill(dydt, dydt + 60, std::nan("")); };
  CHECK(extremal_eigenvalues(system, 0, y.data(), scale, 20).eigenvalues.empty());
}
