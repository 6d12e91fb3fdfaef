// Exact fields of flows and of heat: each satisfies its equations at random points by differences in quad, its boundary
// and its initial conditions; formulas that have a second form agree with it.
#include <catch2/catch.hpp>

#include "fluid_scenes.hpp"
#include "fluid_truth/field.hpp"
#include "fluid_truth/manufactured.hpp"
#include "fluid_truth/slab.hpp"

using namespace atwood;
using namespace atwood::fluid_truth;

namespace {

constexpr double kSmall = 1e-15;  // of the largest term: differences of order 4 at 1e-6

double d(Wide x) { return static_cast<double>(x); }

Scenario taylor_green_scene() {
  Scenario made = fluid_scenario("taylor-green");
  made.scene.fluids[0].initial.parameters = {{"speed_m_per_s", 1.5}, {"length_m", 1}, {"mode", 2}};
  return made;
}

Scenario heat_scene(const std::string& solution) {
  Scenario made = fluid_scenario(solution);
  Fluid& fluid = made.scene.fluids[0];
  fluid.heat_capacity_J_per_kg_K = 4;
  fluid.conductivity_W_per_m_K = 80;  // alpha = 0.02
  fluid.temperature_K = 300;
  fluid.initial.parameters = {{"amplitude_K", 3}};
  return made;
}

// T_t + u.grad T - alpha lap T - q, relative to the largest term.
double heat_residual(const Field<Wide>& field, Wide alpha, Wide q, Wide t, const Vec<Wide>& x) {
  const Differences by;
  Wide left = by.first([&](Wide e) { return field.at(t + e)(x).T; }), largest = magnitude(left);
  left -= q;
  for (int j = 0; j < 3; ++j) {
    const auto T = [&](Wide e) {
      Vec<Wide> moved = x;
      moved[j] += e;
      return field.at(t)(moved).T;
    };
    const Wide convection = field.at(t)(x).v[j] * by.first(T), diffusion = alpha * by.second(T);
    left += convection - diffusion;
    largest = larger(largest, larger(magnitude(convection), magnitude(diffusion)));
  }
  return d(magnitude(left) / larger(largest, magnitude(q)));
}

}  // namespace

TEST_CASE("Taylor and Green's vortices and parallel streams solve the equations of an incompressible fluid") {
  Draw draw(1);
  const Scenario vortices = taylor_green_scene(), streams = fluid_scenario("shear");
  for (const auto& [scenario, solution] : {std::pair{&vortices, taylor_green()}, std::pair{&streams, shear()}}) {
    const Field<Wide> field = wide_field(*scenario, solution);
    for (int k = 0; k < 20; ++k) {
      const Residual left =
          flow_residual(field, scenario->scene.fluids[0], draw(0.1, 2), {draw(-3, 3), draw(-3, 3), 0});
      CHECK(left.momentum < kSmall * left.largest_term);
      CHECK(left.mass < 1e-12);
      CHECK(left.largest_term > 1e-6);
    }
  }
  // The start that is written in the scene's field: u = -U cos kx sin ky, p = -rho0 U^2 / 4 (cos 2kx + cos 2ky), k = 4
  // pi.
  const Point<Wide> at = wide_field(vortices, taylor_green()).at(0)({0.1, 0.03, 0});
  const double k = 4 * M_PI;
  CHECK(d(at.v[0]) == Approx(-1.5 * std::cos(k * 0.1) * std::sin(k * 0.03)).epsilon(1e-14));
  CHECK(d(at.v[1]) == Approx(1.5 * std::sin(k * 0.1) * std::cos(k * 0.03)).epsilon(1e-14));
  CHECK(d(at.p) == Approx(-1000 * 2.25 / 4 * (std::cos(2 * k * 0.1) + std::cos(2 * k * 0.03))).epsilon(1e-13));
}

TEST_CASE("Start-up flows between plates: equations, walls, rest at t = 0, the developed flow") {
  Scenario scenario = fluid_scenario("poiseuille", 1, 1);
  scenario.scene.fluids[0].initial = {};
  scenario.scene.gravity_m_per_s2 = {0.3, 0, 0};
  add_channel(scenario, -0.25, 0.5, -0.2, 1.1);
  const Field<Wide> field = wide_field(scenario, poiseuille());
  Draw draw(2);
  for (int k = 0; k < 30; ++k) {
    const Wide t = std::pow(10.0, draw(-1, 1.5));
    const Residual left =
        flow_residual(field, scenario.scene.fluids[0], t, {0, draw(-0.24, 0.49), 0}, {Wide(0.3), 0, 0});
    CHECK(left.momentum < 1e-13 * left.largest_term);
  }
  for (const double t : {1e-3, 0.1, 10.0}) {
    CHECK(d(field.at(t)({0, -0.25, 0}).v[0]) == -0.2);
    CHECK(d(field.at(t)({0, 0.5, 0}).v[0]) == 1.1);
    CHECK(d(field.at(t)({0, -0.25 + 1e-12, 0}).v[0]) == Approx(-0.2).margin(1e-8));
  }
  CHECK(d(field.at(0)({0, 0.1, 0}).v[0]) == 0);
  CHECK(d(field.at(Wide(1e-4))({0, 0.1, 0}).v[0]) ==
        Approx(0.3e-4).epsilon(1e-12));  // free fall before the walls are felt
  const double s = 0.35, L = 0.75;
  CHECK(d(field.at(1000)({0, 0.1, 0}).v[0]) ==
        Approx(-0.2 + 1.3 * s / L + 0.3 / (2 * 0.01) * s * (L - s)).epsilon(1e-14));
}

TEST_CASE("Morris, Fox and Zhu's Poiseuille flow has the figures of its paper") {
  // L = 1e-3 m, nu = 1e-6 m^2/s, F = 1e-4 m/s^2: V0 = 1.25e-5 m/s in the middle.
  Scenario scenario = fluid_scenario("poiseuille", 1e-3, 1e-3);
  scenario.scene.fluids[0].initial = {};
  scenario.scene.fluids[0].viscosity_m2_per_s = 1e-6;
  scenario.scene.gravity_m_per_s2 = {1e-4, 0, 0};
  add_channel(scenario, 0, 1e-3, 0, 0);
  const Field<Wide> field = wide_field(scenario, poiseuille());
  CHECK(d(field.at(100)({0, 5e-4, 0}).v[0]) == Approx(1.25e-5).epsilon(1e-13));
  // The paper's series at t = 0.0225 s, summed here in double.
  double sum = 1e-4 / (2 * 1e-6) * 2.5e-7;
  for (int n = 0; n < 60; ++n) {
    const double m = 2 * n + 1;
    sum -= 4 * 1e-4 * 1e-6 / (1e-6 * std::pow(M_PI * m, 3)) * std::sin(M_PI * m / 2) *
           std::exp(-m * m * M_PI * M_PI * 1e-6 / 1e-6 * 0.0225);
  }
  CHECK(d(field.at(Wide(0.0225))({0, 5e-4, 0}).v[0]) == Approx(sum).epsilon(1e-12));
}

TEST_CASE("Eigenfunctions and images are one solution") {
  const Slab<Wide> slab{Wide(0.7), Wide(0.3), Wide(-2.1), Wide(0.4), Wide(-1.3), Wide(0.25)};
  const PeriodicStep<Wide> step{Wide(1.3), Wide(0.2), Wide(0.31), Wide(0.4), Wide(2.5)};
  for (const double t : {0.05, 0.166, 0.3}) {
    for (const double x : {0.001, 0.2, 0.36, 0.69}) {
      const SlabValue<Wide> late = slab_by_eigenfunctions<Wide>(slab, x, t, 40),
                            early = slab_by_images<Wide>(slab, x, t, 40);
      CHECK(d(magnitude(late.w - early.w)) < 1e-30);
      const SlabValue<Wide> used = slab_at<Wide>(slab, x, t);
      CHECK(d(magnitude(used.w - late.w)) <= d(used.neglected) + 1e-30);
      const SlabValue<Wide> a = step_by_eigenfunctions<Wide>(step, x, t, 40), b = step_by_images<Wide>(step, x, t, 40);
      CHECK(d(magnitude(a.w - b.w)) < 1e-30);
      const SlabValue<Wide> taken = step_at<Wide>(step, x, t);
      CHECK(d(magnitude(taken.w - a.w)) <= d(taken.neglected) + 1e-30);
    }
  }
  // The bound of what is left out holds where it is not small.
  const SlabValue<Wide> short_sum = slab_by_eigenfunctions<Wide>(slab, Wide(0.2), Wide(0.02), 3),
                        long_sum = slab_by_eigenfunctions<Wide>(slab, Wide(0.2), Wide(0.02), 60);
  const double error = d(magnitude(short_sum.w - long_sum.w));
  CHECK(error > 1e-9);
  CHECK(error <= d(short_sum.neglected));
}

TEST_CASE("Conduction: a sine, a step in a period and between insulated ends, walls of another temperature") {
  Draw draw(3);
  const auto check = [&](const Scenario& scenario, const Solution& solution, double low, double high) {
    const Field<Wide> field = wide_field(scenario, solution);
    for (int k = 0; k < 15; ++k)
      CHECK(heat_residual(field, Wide(80.0) / 4000, 0, std::pow(10.0, draw(-0.5, 1.3)),
                          {draw(low, high), draw(low, high), 0}) < 1e-12);
    return field;
  };
  check(heat_scene("heat-sine"), heat_sine(), 0, 1);
  {
    Scenario scenario = heat_scene("heat-step");
    scenario.scene.fluids[0].initial.parameters["position_m"] = 0.3;
    const Field<Wide> field = check(scenario, heat_step(), 0, 1);
    CHECK(d(field.at(0)({0.299, 0, 0}).T) == 303);
    CHECK(d(field.at(0)({0.301, 0, 0}).T) == 300);
    CHECK(d(field.at(Wide(1e-3))({0.3, 0, 0}).T) == Approx(301.5).epsilon(1e-12));
    CHECK(d(field.at(Wide(1e-3))({1, 0, 0}).T) == Approx(301.5).epsilon(1e-12));  // the period's own step
    CHECK(d(field.at(1000)({0.7, 0, 0}).T) == Approx(300 + 3 * 0.3).epsilon(1e-12));
    scenario.scene.domain.periodic_m[0] = 0;  // insulated ends
    const Field<Wide> closed = check(scenario, heat_step(), 0, 1);
    const Differences by;
    for (const double end : {0.0, 1.0})
      CHECK(d(magnitude(by.first([&](Wide e) { return closed.at(Wide(2))({end + e, 0, 0}).T; }))) < 1e-20);
    CHECK(d(closed.at(1000)({0.7, 0, 0}).T) == Approx(300 + 3 * 0.3).epsilon(1e-12));
    CHECK(d(closed.at(Wide(1e-3))({0, 0, 0}).T) == Approx(303).epsilon(1e-12));
  }
  Scenario scenario = heat_scene("heat-step");
  scenario.scene.fluids[0].initial = {};
  add_channel(scenario, 0, 1, 0, 0);
  scenario.scene.fluid_boundaries[0].temperature_K = 310;
  for (const bool both : {false, true}) {
    if (both) scenario.scene.fluid_boundaries[1].temperature_K = 280;
    const Field<Wide> field = check(scenario, heat_step(), 0, 1);
    CHECK(d(field.at(3)({0, 0, 0}).T) == 310);
    // Far from the other wall: erfc.
    const Wide t = 0.1, y = 0.05;
    CHECK(d(field.at(t)({0, y, 0}).T) ==
          Approx(300 + 10 * std::erfc(0.05 / (2 * std::sqrt(0.02 * 0.1)))).epsilon(1e-12));
    CHECK(d(field.at(10000)({0, 0.25, 0}).T) == Approx(both ? 302.5 : 310).epsilon(1e-12));
    const Differences by;
    if (!both) CHECK(d(magnitude(by.first([&](Wide e) { return field.at(5)({0, 1 - 2 * by.h + e, 0}).T; }))) < 1e-4);
  }
}

TEST_CASE("A slab that is heated through its walls: equation, slopes at the walls, mean rise") {
  Scenario scenario = heat_scene("heat-flux");
  scenario.scene.fluids[0].initial = {};
  add_channel(scenario, 0, 1, 0, 0);
  scenario.scene.fluid_boundaries[0].heat_flux_W_per_m2 = 120;
  scenario.scene.fluid_boundaries[1].heat_flux_W_per_m2 = -40;
  const Field<Wide> field = wide_field(scenario, heat_flux());
  const Fluid& fluid = scenario.scene.fluids[0];
  const Wide k = fluid.conductivity_W_per_m_K,
             heat = Wide(fluid.density_kg_per_m3) * Wide(fluid.heat_capacity_J_per_kg_K), D = k / heat;
  Draw draw(3);
  for (int n = 0; n < 15; ++n) CHECK(heat_residual(field, D, 0, draw(0.2, 20), {0, draw(0.01, 0.99), 0}) < 1e-12);
  const Wide e = 1e-9;
  for (const double t : {0.3, 2.0, 40.0}) {
    const auto T = [&](Wide y) { return field.at(Wide(t))({0, y, 0}).T; };
    CHECK(d((T(0) - T(e)) / e * k) == Approx(120).epsilon(1e-6));
    CHECK(d((T(1) - T(1 - e)) / e * k) == Approx(-40).epsilon(1e-6));
    Wide mean = 0;  // the midpoint rule on a function with known slopes at its ends: h^2 / 24 of their difference
    const int cells = 2000;
    for (int n = 0; n < cells; ++n) mean += (T((Wide(n) + Wide(0.5)) / cells) - 300) / cells;
    mean += (Wide(120) / k - Wide(40) / k) / (24 * Wide(cells) * cells);
    CHECK(d(mean) == Approx(d(80 * Wide(t) / heat)).epsilon(1e-9));
  }
  CHECK(d(field.at(0)({0, 0.25, 0}).T) == 300);
  // The two formulas where both converge.
  const HeatedSlab<Wide> slab{Wide(1.5), Wide(0.25), Wide(2)};
  for (const double s : {0.0, 0.4, 1.5}) {
    const SlabValue<Wide> late = heated_by_eigenfunctions(slab, Wide(s), Wide(1), 20),
                          early = heated_by_images(slab, Wide(s), Wide(1), 8);
    CHECK(d(magnitude(late.w - early.w)) < 1e-28);
  }
  scenario.scene.fluid_boundaries[0].temperature_K = 300;
  CHECK_THROWS_AS(wide_field(scenario, heat_flux()), Refused);
}

TEST_CASE("Viscous heating of a Couette flow, and a viscosity that depends on temperature") {
  Scenario scenario = heat_scene("viscous-heating");
  Fluid& fluid = scenario.scene.fluids[0];
  add_channel(scenario, 0, 0.5, 0, 2);
  scenario.scene.fluid_boundaries[0].temperature_K = 300;
  scenario.scene.fluid_boundaries[1].temperature_K = 305;
  fluid.initial = {};
  fluid.initial.velocity_gradient_per_s[1] = 4;
  fluid.viscous_heat = true;
  const Field<Wide> field = wide_field(scenario, viscous_heating());
  const Wide q = Wide(0.01) * 16 / 4;  // nu (U / L)^2 / c
  Draw draw(4);
  for (int k = 0; k < 15; ++k)
    CHECK(heat_residual(field, Wide(80.0) / 4000, q, draw(0.2, 6), {0, draw(0.01, 0.49), 0}) < 1e-12);
  // Steady: Brinkman's parabola on the line between the walls' temperatures, mu U^2 / (8 k) in the middle.
  CHECK(d(field.at(1000)({0, 0.25, 0}).T) == Approx(302.5 + 10.0 * 4 / (8 * 80)).epsilon(1e-13));
  CHECK(d(field.at(0)({0, 0.25, 0}).T) == 300);
  fluid.initial.velocity_gradient_per_s[1] = 4.1;
  CHECK_THROWS_AS(wide_field(scenario, viscous_heating()), Refused);

  fluid.viscous_heat = false;
  fluid.viscosity_decay_per_K = 0.3;
  fluid.initial.name = "couette-thermal";
  const Field<Wide> thermal = wide_field(scenario, couette_thermal());
  const Differences by;
  for (int k = 0; k < 10; ++k) {
    const Wide y = draw(0.01, 0.49);
    const auto stress = [&](Wide at) {
      const Wide slope = by.first([&](Wide e) { return thermal.at(1)({0, at + e, 0}).v[0]; });
      return exp(-Wide(0.3) * (thermal.at(1)({0, at, 0}).T - 300)) * slope;
    };
    CHECK(d(stress(y) / stress(Wide(0.25))) == Approx(1).epsilon(1e-14));
  }
  CHECK(d(thermal.at(1)({0, 0, 0}).v[0]) == 0);
  CHECK(d(thermal.at(1)({0, 0.5, 0}).v[0]) == Approx(2).epsilon(1e-15));
}

TEST_CASE("A standing wave solves the linear equations with the damping of its viscous term") {
  Scenario scenario = fluid_scenario("standing-wave");
  scenario.scene.fluids[0].initial.parameters = {{"amplitude", 1e-3}};
  Draw draw(5);
  const Differences by;
  for (const auto& [response, factor] : {std::pair{"sph{viscosity=morris}", 1}, std::pair{"sph{viscosity=central}", 3},
                                         std::pair{"sph{viscosity=none}", 0}}) {
    const Field<Wide> field = wide_field(scenario, standing_wave(), response);
    for (int k = 0; k < 10; ++k) {
      const Wide t = draw(0.01, 3), x = draw(0, 1);
      const auto at = [&](Wide dt, Wide dx) { return field.at(t + dt)({x + dx, 0, 0}); };
      const Wide continuity =
          by.first([&](Wide e) { return at(e, 0).density; }) + 1000 * by.first([&](Wide e) { return at(0, e).v[0]; });
      const Wide momentum = by.first([&](Wide e) { return at(e, 0).v[0]; }) + by.first([&](Wide e) {
        return at(0, e).p;
      }) / 1000 - factor * Wide(0.01) * by.second([&](Wide e) { return at(0, e).v[0]; });
      CHECK(d(magnitude(continuity)) < 1e-14);
      CHECK(d(magnitude(momentum)) < 1e-14);
    }
    CHECK(d(field.at(0)({0.25, 0, 0}).v[0]) == 0);
    CHECK(d(field.at(0)({0, 0, 0}).density) == Approx(1001).epsilon(1e-15));
  }
}

TEST_CASE("Manufactured fields solve the equations with their sources, derived by hand and by differences") {
  for (const bool plane : {true, false})
    for (const bool tait : {false, true}) {
      Scenario scenario = fluid_scenario(plane ? "mms-2d" : "mms-3d");
      Scene& scene = scenario.scene;
      if (!plane) scene.domain = {3, {1, 1, 1}};
      Fluid& fluid = scene.fluids[0];
      fluid.equation_of_state = tait ? EquationOfState::tait : EquationOfState::linear;
      fluid.initial.parameters = {
          {"speed_m_per_s", 1.3}, {"length_m", 0.5}, {"angular_frequency_rad_per_s", 2.2}, {"density_amplitude", 0.1}};
      fluid.source = fluid.initial;
      const Field<Wide> field = wide_field(scenario, plane ? mms_2d() : mms_3d());
      const auto source = manufactured_of<Wide>(scene, fluid, fluid.source);
      Draw draw(6);
      for (int k = 0; k < 10; ++k) {
        const Wide t = draw(0.1, 2);
        const Vec<Wide> x{draw(0, 1), draw(0, 1), plane ? 0 : draw(0, 1)};
        const Residual left = flow_residual(field, fluid, t, x, source.source(t, x));
        CHECK(left.momentum < 1e-14 * left.largest_term);
        CHECK(left.mass < 1e-12);
        const auto narrow =
            manufactured_of<double>(scene, fluid, fluid.source).source(d(t), {d(x[0]), d(x[1]), d(x[2])});
        CHECK(narrow[0] == Approx(d(source.source(t, x)[0])).epsilon(1e-9).margin(1e-9));
      }
    }
}
