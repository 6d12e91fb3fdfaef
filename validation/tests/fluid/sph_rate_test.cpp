// The rate of +sph against the equations of docs/fluids.md, summed over all pairs, in quad; and its bits, whatever the
// lanes, the threads and the time at which lists were built.
#include <catch2/catch.hpp>

#include "fluid/sph.hpp"
#include "scenes.hpp"

using namespace atwood;
using namespace atwood::fluid;

namespace {

using Vector = std::array<Quad, 3>;
Quad dot3(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

// The equations as they are written, a particle after the other.
std::vector<Quad> direct_rate(const Scene& scene, const SphOptions& options, const Layout& at,
                              const std::vector<double>& y) {
  const int d = at.dimensions, count = at.particles;
  const auto kernel = make_kernel<Quad>(options.kernel, d, Quad(options.smoothing) * Quad(scene.fluids[0].spacing_m));
  std::vector<const Fluid*> of;
  std::vector<Quad> mass, density(count), temperature(count), pressure(count), mu(count);
  for (const Fluid& fluid : scene.fluids)
    for (const double m : fluid.particles.mass_kg) of.push_back(&fluid), mass.push_back(m);
  const auto vector_at = [&](int first, int i) {
    Vector v{};
    for (int c = 0; c < d; ++c) v[c] = y[first + i * d + c];
    return v;
  };
  const auto apart = [&](int i, int j) {
    Vector x = vector_at(at.positions(), i);
    const Vector other = vector_at(at.positions(), j);
    for (int c = 0; c < d; ++c) {
      x[c] -= other[c];
      const Quad period = scene.domain.periodic_m[c];
      if (period > 0) x[c] -= period * real::floor(x[c] / period + Quad(0.5));
    }
    return x;
  };
  for (int i = 0; i < count; ++i) {
    temperature[i] = at.temperature ? Quad(y[at.temperatures() + i]) : Quad(of[i]->temperature_K);
    density[i] = at.density ? Quad(y[at.densities() + i]) : mass[i] * kernel.value(0);
    for (int j = 0; j < count && !at.density; ++j)
      if (j != i) {
        const Vector x = apart(i, j);
        density[i] += mass[j] * kernel.value(real::sqrt(dot3(x, x)));
      }
    const Quad rho0 = of[i]->density_kg_per_m3, c = of[i]->sound_speed_m_per_s, ratio = density[i] / rho0;
    pressure[i] = c * c * (density[i] - rho0);
    if (of[i]->equation_of_state == EquationOfState::tait) {
      Quad power = 1;
      for (int n = 0; n < 7; ++n) power *= ratio;
      pressure[i] = rho0 * c * c / 7 * (power - 1);
    }
    // exp by its series: the argument is small.
    const Quad argument = -Quad(of[i]->viscosity_decay_per_K) * (temperature[i] - Quad(of[i]->temperature_K));
    Quad term = 1, sum = 0;
    for (int n = 1; n < 60; ++n) sum += term, term = term * argument / n;
    mu[i] = rho0 * Quad(of[i]->viscosity_m2_per_s) * sum;
  }
  std::vector<Quad> rate(at.size());
  // The transport velocities of shifting.
  Quad fastest = 0;
  for (int i = 0; i < count; ++i)
    fastest = real::max(fastest, real::sqrt(dot3(vector_at(at.velocities(), i), vector_at(at.velocities(), i))));
  std::vector<Vector> carried(count);
  for (int i = 0; i < count; ++i)
    for (int j = 0; j < count; ++j) {
      const Vector x = apart(i, j);
      const Quad F = j == i ? 0 : kernel.slope_over_distance(real::sqrt(dot3(x, x)));
      for (int c = 0; c < d; ++c)
        carried[i][c] -= Quad(options.shift) * fastest * kernel.support * mass[j] / density[j] * F * x[c];
    }
  for (int i = 0; i < count; ++i) {
    const Vector v_i = vector_at(at.velocities(), i);
    Vector a{};
    Quad density_rate = 0, heat = 0, warmth = 0;
    for (int j = 0; j < count; ++j) {
      if (j == i) continue;
      const Vector x = apart(i, j), v_j = vector_at(at.velocities(), j);
      const Vector v{v_i[0] - v_j[0], v_i[1] - v_j[1], v_i[2] - v_j[2]};
      const Quad r2 = dot3(x, x), F = kernel.slope_over_distance(real::sqrt(r2));
      if (F == 0) continue;
      density_rate += mass[j] * F * dot3(v, x);
      const Fluid& fluid = *of[i];
      if (of[i] == of[j])
        density_rate += Quad(2) * Quad(options.density_diffusion) * kernel.support / support_ratio(kernel.shape) *
                        Quad(fluid.sound_speed_m_per_s) * mass[j] / density[j] * (density[i] - density[j]) * F;
      const Quad push =
          mass[j] * (pressure[i] / (density[i] * density[i]) + pressure[j] / (density[j] * density[j])) * F;
      Vector A{};
      const Quad drag = (mu[i] + mu[j]) / (density[i] * density[j]) * F;
      for (int c = 0; c < d; ++c) {
        if (options.viscosity == Viscosity::morris) A[c] = drag * v[c];
        if (options.viscosity == Viscosity::central) A[c] = Quad(d + 2) * drag * dot3(v, x) / r2 * x[c];
        a[c] += mass[j] * A[c] - push * x[c];
      }
      const Quad V = mass[j] / density[j];
      Quad flux = 0, spread = 0;
      for (int c = 0; c < d; ++c) {
        flux += V * F * x[c] * (density[i] * carried[i][c] + density[j] * carried[j][c]);
        spread += V * F * x[c] * (carried[j][c] - carried[i][c]);
      }
      density_rate += flux - density[i] * spread;
      for (int c = 0; c < d; ++c) a[c] -= flux * v[c] / (2 * density[i]);
      warmth += flux * (temperature[j] - temperature[i]) / (2 * density[i]);
      if (fluid.viscous_heat) heat -= mass[j] * dot3(A, v) / 2;
      const Quad k_i = fluid.conductivity_W_per_m_K, k_j = of[j]->conductivity_W_per_m_K;
      if (k_i + k_j > 0)
        heat +=
            mass[j] * 4 * k_i * k_j / (k_i + k_j) * (temperature[i] - temperature[j]) * F / (density[i] * density[j]);
    }
    for (int c = 0; c < d; ++c) {
      rate[at.positions() + i * d + c] = v_i[c] + carried[i][c];
      rate[at.velocities() + i * d + c] =
          a[c] + (1 - Quad(of[i]->expansion_per_K) * (temperature[i] - Quad(of[i]->temperature_K))) *
                     Quad(scene.gravity_m_per_s2[c]);
    }
    if (at.density) rate[at.densities() + i] = density_rate;
    if (at.temperature && of[i]->heat_capacity_J_per_kg_K > 0)
      rate[at.temperatures() + i] = heat / Quad(of[i]->heat_capacity_J_per_kg_K) + warmth;
  }
  return rate;
}

// The largest difference of each block of the rate over the block's largest entry.
double difference(const Layout& at, const std::vector<double>& rate, const std::vector<Quad>& expected) {
  const int ends[5] = {0, at.velocities(), at.densities(), at.temperatures(), at.bodies()};
  double worst = 0;
  for (int block = 0; block < 4; ++block) {
    double error = 0, scale = 0;
    for (int i = ends[block]; i < ends[block + 1]; ++i) {
      error = std::max(error, static_cast<double>(real::abs(Quad(rate[i]) - expected[i])));
      scale = std::max(scale, static_cast<double>(real::abs(expected[i])));
    }
    if (scale > 0) worst = std::max(worst, error / scale);
  }
  return worst;
}

std::vector<double> rate_at(Sph<double>& sph, const std::vector<double>& y) {
  std::vector<double> rate(y.size());
  sph.system().rate(0, y.data(), rate.data());
  return rate;
}
std::vector<double> start_of(const Sph<double>& sph) {
  std::vector<double> y(sph.layout().size());
  sph.initial_state(y.data());
  return y;
}

void check_rate(const Scene& scene, const SphOptions& options) {
  Sph<double> sph(scene, options);
  REQUIRE(sph.unsupported() == "");
  const std::vector<double> y = start_of(sph), rate = rate_at(sph, y);
  CHECK(difference(sph.layout(), rate, direct_rate(scene, options, sph.layout(), y)) < 2e-13);
}

}  // namespace

TEST_CASE("the rate is that of the written equations, for every kernel and both dimensions") {
  for (const KernelShape kernel : {KernelShape::cubic, KernelShape::quintic, KernelShape::wendland_c2,
                                   KernelShape::wendland_c4, KernelShape::wendland_c6})
    for (const int d : {2, 3}) {
      Scene scene = block_scene({.dimensions = d, .across = d == 2 ? 10 : 7});
      scene.gravity_m_per_s2 = {0.3, -9.81, 0};
      SphOptions options;
      options.kernel = kernel;
      options.smoothing = kernel == KernelShape::quintic ? 1.0 : 1.4;
      INFO("kernel " << static_cast<int>(kernel) << " d " << d);
      check_rate(scene, options);
    }
}

TEST_CASE("the rate is that of the written equations, for every form of density, viscosity and heat") {
  for (const int d : {2, 3})
    for (const bool summation : {false, true})
      for (const Viscosity viscosity : {Viscosity::none, Viscosity::morris, Viscosity::central})
        for (const bool warm : {false, true}) {
          Scene scene = block_scene({.dimensions = d, .across = d == 2 ? 9 : 6, .periodic = !warm});
          scene.gravity_m_per_s2 = {0.3, -9.81, 0};
          scene.fluids[0].equation_of_state = warm ? EquationOfState::tait : EquationOfState::linear;
          if (warm) heat(scene.fluids[0]);
          SphOptions options;
          options.summation = summation;
          options.viscosity = viscosity;
          options.density_diffusion = warm ? 0.1 : 0;
          if (!warm && summation) scene.fluids[0].particles.mass_kg[3] *= 1.5;
          INFO("d " << d << " summation " << summation << " viscosity " << static_cast<int>(viscosity) << " heat "
                    << warm);
          check_rate(scene, options);
        }
}

TEST_CASE("two fluids have their own laws") {
  Scene scene = block_scene();
  heat(scene.fluids[0]);
  Fluid& water = scene.fluids[0];
  Fluid oil = water;
  oil.name = "oil";
  oil.density_kg_per_m3 = 800;
  oil.sound_speed_m_per_s = 14;
  oil.viscosity_m2_per_s = 0.05;
  oil.conductivity_W_per_m_K = 300;
  oil.particles = {};
  for (std::size_t i = water.particles.mass_kg.size(); i-- > 40;) {
    const auto move = [&](auto& from, auto& to) { to.push_back(from[i]), from.erase(from.begin() + i); };
    move(water.particles.position_m, oil.particles.position_m);
    move(water.particles.velocity_m_per_s, oil.particles.velocity_m_per_s);
    move(water.particles.mass_kg, oil.particles.mass_kg);
    move(water.particles.density_kg_per_m3, oil.particles.density_kg_per_m3);
    move(water.particles.temperature_K, oil.particles.temperature_K);
  }
  for (double& density : oil.particles.density_kg_per_m3) density *= 0.8;
  scene.fluids.push_back(oil);
  SphOptions options;
  options.density_diffusion = 0.2;
  check_rate(scene, options);
}

TEST_CASE("shifting carries mass, momentum and temperature as written") {
  for (const int d : {2, 3}) {
    Scene scene = block_scene({.dimensions = d, .across = d == 2 ? 9 : 6});
    heat(scene.fluids[0]);
    SphOptions options;
    options.shift = 0.3;
    check_rate(scene, options);
  }
}

TEST_CASE("corrected gradients are exact for linear pressures and velocities, at borders too") {
  for (const int d : {2, 3}) {
    Scene scene = block_scene({.dimensions = d, .across = d == 2 ? 9 : 6, .periodic = false});
    scene.fluids[0].viscosity_m2_per_s = 0;
    SphOptions options;
    options.corrected = true;
    Sph<double> sph(scene, options);
    const Layout& at = sph.layout();
    std::vector<double> y = start_of(sph);
    const double slope[3] = {0.01, 0.02, -0.015}, stretch[3] = {0.3, 0.5, -0.1};
    for (int i = 0; i < at.particles; ++i) {
      const double* const x = &y[at.positions() + i * d];
      double density = 1000;
      for (int c = 0; c < d; ++c) {
        density += 1000 * slope[c] * x[c];
        y[at.velocities() + i * d + c] = stretch[c] * x[c] + 0.7 * x[(c + 1) % d];
      }
      y[at.densities() + i] = density;
    }
    const std::vector<double> rate = rate_at(sph, y);
    for (int i = 0; i < at.particles; ++i) {
      const double density = y[at.densities() + i];
      const double divergence = stretch[0] + stretch[1] + (d == 3 ? stretch[2] : 0);
      CHECK(rate[at.densities() + i] == Approx(-density * divergence).epsilon(1e-11));
      for (int c = 0; c < d; ++c)
        CHECK(rate[at.velocities() + i * d + c] == Approx(-100 * 1000 * slope[c] / density).epsilon(1e-11));
    }
  }
}

TEST_CASE("lanes, threads and the time at which lists were built leave the bits") {
  for (const int d : {2, 3})
    for (const bool summation : {false, true}) {
      Scene scene = block_scene({.dimensions = d, .across = d == 2 ? 36 : 11});
      heat(scene.fluids[0]);
      SphOptions options;
      options.summation = summation;
      options.viscosity = Viscosity::central;
      options.shift = summation ? 0 : 0.7;
      Sph<double> sph(scene, options);
      const std::vector<double> y = start_of(sph), rate = rate_at(sph, y);
      SphOptions scalar = options;
      scalar.lane_by_lane = true;
      Sph<double> lane_by_lane(scene, scalar);
      CHECK(rate_at(lane_by_lane, y) == rate);
      SphOptions many = options;
      many.threads = 3;
      many.skin = 0.31;
      Sph<double> threads(scene, many);
      CHECK(rate_at(threads, y) == rate);
      // Lists that were built somewhere near, or elsewhere.
      for (const double way : {0.01, 0.3}) {
        std::vector<double> near = y;
        SplitMix64 random{3};
        for (int i = 0; i < sph.layout().velocities(); ++i)
          near[i] += way * scene.fluids[0].spacing_m * (random.next_unit() - 0.5);
        sph.system().rate(0, near.data(), std::vector<double>(y.size()).data());
        CHECK(rate_at(sph, y) == rate);
      }
    }
}

TEST_CASE("the same equations in float and quad") {
  Scene scene = block_scene();
  heat(scene.fluids[0]);
  Sph<double> sph(scene, {});
  Sph<Quad> wide(scene, {});
  Sph<float> narrow(scene, {});
  const std::vector<double> y = start_of(sph);
  const std::vector<Quad> y_wide(y.begin(), y.end());
  const std::vector<float> y_narrow(y.begin(), y.end());
  std::vector<Quad> rate_wide(y.size());
  std::vector<float> rate_narrow(y.size());
  wide.system().rate(0, y_wide.data(), rate_wide.data());
  narrow.system().rate(0, y_narrow.data(), rate_narrow.data());
  CHECK(difference(sph.layout(), rate_at(sph, y), rate_wide) < 1e-13);
  CHECK(difference(sph.layout(), std::vector<double>(rate_narrow.begin(), rate_narrow.end()), rate_wide) < 2e-3);
  std::vector<Quad> direct = direct_rate(scene, {}, sph.layout(), y);
  Quad worst = 0, scale = 0;
  for (std::size_t i = 0; i < direct.size(); ++i) {
    worst = real::max(worst, real::abs(direct[i] - rate_wide[i]));
    scale = real::max(scale, real::abs(direct[i]));
  }
  CHECK(worst < Quad(1e-30) * scale);
}

TEST_CASE("a position that is not finite makes a rate that is not finite") {
  const Scene scene = block_scene();
  Sph<double> sph(scene, {});
  std::vector<double> y = start_of(sph);
  y[7] = std::nan("");
  CHECK(std::isnan(rate_at(sph, y)[0]));
  CHECK_THAT(sph.fault(y.data()), Catch::Contains("particle 3 of `water`"));
}
