// Exact fields with a free surface, what fields refuse, and their bars.
#include <catch2/catch.hpp>

#include "fluid_scenes.hpp"
#include "fluid_truth/elliptic_drop.hpp"
#include "fluid_truth/field.hpp"

using namespace atwood;
using namespace atwood::fluid_truth;

namespace {

double d(Wide x) { return static_cast<double>(x); }

Scenario drop_scene() {
  Scenario made = fluid_scenario("elliptic-drop", 0, 0);
  Fluid& fluid = made.scene.fluids[0];
  fluid.viscosity_m2_per_s = 0;
  fluid.region = BallRegion{{0.5, -0.25, 0}, 1};
  fluid.initial.parameters = {{"rate_per_s", 100}};
  return made;
}

Scenario column_scene(EquationOfState law) {
  Scenario made = fluid_scenario("hydrostatic", 0, 0);
  Fluid& fluid = made.scene.fluids[0];
  fluid.equation_of_state = law;
  fluid.initial = {};
  fluid.region = BoxRegion{{0, 0.5, 0}, {1, 2.5, 0}};
  made.scene.gravity_m_per_s2 = {0, -9.81, 0};
  return made;
}

}  // namespace

TEST_CASE("Monaghan's drop: Euler's equations, no pressure on the surface, area and energy, a quadrature") {
  const Scenario scenario = drop_scene();
  const Field<Wide> field = wide_field(scenario, elliptic_drop());
  Draw draw(7);
  for (int k = 0; k < 15; ++k) {
    const Wide t = draw(1e-4, 0.02);
    const Residual left =
        flow_residual(field, scenario.scene.fluids[0], t, {draw(0, 1), draw(-1, 1), 0}, {}, {Wide(1e-8)});
    CHECK(left.momentum < 1e-12 * left.largest_term);
    CHECK(left.mass < 1e-9);
    const Drop<Wide> now = drop_at<Wide>({1, 1, 100, 0}, t);
    const double angle = draw(0, 6.28);
    const Point<Wide> border =
        field.at(t)({Wide(0.5) + now.a * Wide(std::cos(angle)), Wide(-0.25) + now.b * Wide(std::sin(angle)), 0});
    CHECK(std::fabs(d(border.p)) < 1e-15 * 1000 * 1e4);
    CHECK(d(magnitude(now.a * now.b - 1)) < 1e-25);
    CHECK(d(magnitude(now.A * now.A * (now.a * now.a + now.b * now.b) / 20000 - 1)) < 1e-25);
    CHECK(d(now.error) < 1e-24);
  }
  // a' = -A a with A from the energy: t is the integral of sqrt((a^2 + 1/a^2) / 2) / (100 a) da from a to 1, by
  // Simpson's rule.
  const Drop<Wide> end = drop_at<Wide>({1, 1, 100, 0}, Wide(0.0076));
  const int n = 4000;
  Wide time = 0;
  for (int k = 0; k <= n; ++k) {
    const Wide a = end.a + (1 - end.a) * k / n, f = sqrt((a * a + 1 / (a * a)) / 2) / (100 * a);
    time += f * ((k == 0 || k == n) ? 1 : k % 2 == 1 ? 4 : 2);
  }
  CHECK(d(time * (1 - end.a) / (3 * n)) == Approx(0.0076).epsilon(1e-13));
  // Monaghan's table: the semi-major axis is 1.083, 1.44, 1.95 at t = 0.0008, 0.0038, 0.0076 s.
  for (const auto& [t, b] : {std::pair{0.0008, 1.083}, std::pair{0.0038, 1.44}, std::pair{0.0076, 1.95}})
    CHECK(d(drop_at<Wide>({1, 1, 100, 0}, Wide(t)).b) == Approx(b).epsilon(0.005));
}

TEST_CASE("A settled column: weight, equation of state, mass; pressure at the bottom is that of the mass") {
  for (const EquationOfState law : {EquationOfState::linear, EquationOfState::tait}) {
    const Scenario scenario = column_scene(law);
    const Fluid& fluid = scenario.scene.fluids[0];
    const Field<Wide> field = wide_field(scenario, hydrostatic());
    const FluidProbe probe{"h", ProbeKind::column_height, {}, -1};
    const Wide height = field.probe(0, probe)->value;
    CHECK(d(height) < 2);
    CHECK(d(height) > 1.5);
    CHECK(d(field.at(0)({0, 0.5, 0}).p) == Approx(1000 * 9.81 * 2).epsilon(1e-14));
    CHECK(d(magnitude(field.at(0)({0, Wide(0.5) + height, 0}).p)) < 1e-25);
    const Differences by;
    Draw draw(8);
    for (int k = 0; k < 10; ++k) {
      const Wide y = draw(0.6, 0.4 + d(height));
      const Point<Wide> at = field.at(0)({0, y, 0});
      const Wide slope = by.first([&](Wide e) { return field.at(0)({0, y + e, 0}).p; });
      CHECK(d(slope / at.density) == Approx(-9.81).epsilon(1e-14));
      CHECK(d(pressure_of<Wide>(fluid, at.density)) == Approx(d(at.p)).epsilon(1e-14));
    }
    Wide mass = 0;
    const int n = 400;
    for (int k = 0; k <= n; ++k)
      mass += field.at(0)({0, Wide(0.5) + height * k / n, 0}).density * ((k == 0 || k == n) ? 1 : k % 2 == 1 ? 4 : 2);
    CHECK(d(mass * height / (3 * n)) == Approx(2000).epsilon(1e-11));
  }
}

TEST_CASE("The rotating square's pressure: Poisson's equation, the surface, Le Touze's double series") {
  Scenario scenario = fluid_scenario("square-patch", 0, 0);
  Fluid& fluid = scenario.scene.fluids[0];
  fluid.viscosity_m2_per_s = 0;
  fluid.region = BoxRegion{{-0.5, -0.5, 0}, {0.5, 0.5, 0}};
  fluid.initial.parameters = {{"rate_per_s", 5}};
  const Field<Wide> field = wide_field(scenario, square_patch());
  const Differences by{Wide(1e-4)};
  Draw draw(9);
  for (int k = 0; k < 10; ++k) {
    const Wide x = draw(-0.45, 0.45), y = draw(-0.45, 0.45);
    const Wide lap = by.second([&](Wide e) {
      return field.at(0)({x + e, y, 0}).p;
    }) + by.second([&](Wide e) {
      return field.at(0)({x, y + e, 0}).p;
    });
    CHECK(d(lap) == Approx(2 * 1000 * 25).epsilon(1e-8));
    const double X = d(x) + 0.5, Y = d(y) + 0.5;
    double series = 0;
    for (int m = 1; m < 400; m += 2)
      for (int n = 1; n < 400; n += 2)
        series += -32 * 25 / (m * n * M_PI * M_PI) / (std::pow(n * M_PI, 2) + std::pow(m * M_PI, 2)) *
                  std::sin(m * M_PI * X) * std::sin(n * M_PI * Y);
    CHECK(d(field.at(0)({x, y, 0}).p) == Approx(1000 * series).epsilon(2e-4));
  }
  for (const double s : {-0.5, -0.3, 0.1, 0.5})
    for (const auto& [x, y] : {std::pair{s, -0.5}, std::pair{s, 0.5}, std::pair{-0.5, s}, std::pair{0.5, s}}) {
      const Point<Wide> at = field.at(0)({x, y, 0});
      CHECK(d(magnitude(at.p)) <= d(at.neglected_p) + 1e-25);
    }
  CHECK(d(field.at(0)({0, 0.25, 0}).v[0]) == 1.25);
  Scenario later = scenario;
  const FluidField whole = fluid_field_of(later);
  REQUIRE(whole.outcome.status == Status::ok);
  CHECK_THROWS_WITH(whole.at(Wide(0.1), {{0, 0, 0}}), Catch::Contains("only at t = 0"));
}

TEST_CASE("Ritter's dam: the equations of shallow water, no bound") {
  Scenario scenario = fluid_scenario("ritter", 0, 0);
  Fluid& fluid = scenario.scene.fluids[0];
  fluid.initial = {};
  fluid.viscosity_m2_per_s = 0;
  fluid.region = BoxRegion{{-3, 0, 0}, {1, 0.5, 0}};
  scenario.scene.gravity_m_per_s2 = {0, -9.81, 0};
  const Field<Wide> field = wide_field(scenario, ritter());
  const Wide t = 0.5;
  const auto height = [&](Wide s, Wide x) { return field.at(s)({x, 0, 0}).p / (1000 * Wide(9.81)); };
  const auto speed = [&](Wide s, Wide x) { return field.at(s)({x, 0, 0}).v[0]; };
  const Differences by;
  for (const double x : {0.2, 1.0, 1.5, 2.5}) {
    const Wide mass = by.first([&](Wide e) { return height(t + e, x); }) +
                      by.first([&](Wide e) { return height(t, x + e) * speed(t, x + e); });
    const Wide momentum = by.first([&](Wide e) { return speed(t + e, x); }) + speed(t, x) * by.first([&](Wide e) {
      return speed(t, x + e);
    }) + Wide(9.81) * by.first([&](Wide e) { return height(t, x + e); });
    CHECK(d(magnitude(mass)) < 1e-18);
    CHECK(d(magnitude(momentum)) < 1e-18);
  }
  CHECK(d(height(t, 1)) == Approx(0.5 * 4 / 9).epsilon(1e-14));  // at the dam for all t
  scenario.scene.probes.push_back({"tip", ProbeKind::front, {}, -1});
  const FluidField whole = fluid_field_of(scenario);
  const FieldSample at = whole.at(t, {{1, 0, 0}});
  CHECK(std::isinf(d(at.bars[0].v_m_per_s[0])));
  REQUIRE(at.probes.size() == 1);
  CHECK(d(at.probes[0]->value) == Approx(1 + 2 * std::sqrt(9.81 * 0.5) * 0.5).epsilon(1e-14));
  CHECK_THROWS_WITH(whole.at(5, {{1, 0, 0}}), Catch::Contains("back of the reservoir"));
}

TEST_CASE("A body that floats: the fluid carries its weight, the floor that of both") {
  Scenario scenario = fluid_scenario("floating", 0, 0);
  scenario.scene.gravity_m_per_s2 = {0, -10, 0};
  Fluid& fluid = scenario.scene.fluids[0];
  fluid.initial.name = "hydrostatic";
  fluid.particles.mass_kg = {300, 500};
  const auto add = [&](const char* name, bool fixed, const Shape& shape) {
    Body& body = scenario.scene.bodies.emplace_back();
    body.name = name, body.fixed = fixed, body.shape = shape, body.mass_kg = fixed ? 0 : 80;
    scenario.scene.fluid_boundaries.push_back(
        {static_cast<int>(scenario.scene.bodies.size()) - 1, Slip::no_slip, {}, {}});
    scenario.scene.probes.push_back(
        {name, ProbeKind::force_on_body, {}, static_cast<int>(scenario.scene.bodies.size()) - 1});
  };
  add("cube", false, Box{{0.2, 0.25, 0.2}});
  add("floor", true, Plane{{0, 1, 0}, 0});
  const FluidField field = fluid_field_of(scenario);
  REQUIRE(field.outcome.reason == "");
  CHECK_FALSE(field.known.velocity);
  const FieldSample at = field.at(1, {{0.5, 0.5, 0}});
  REQUIRE(at.probes.size() == 2);
  CHECK(d(at.probes[0]->value) == 800);
  CHECK(d(at.probes[1]->value) == 8800);
  scenario.scene.bodies[0].mass_kg = 4 * 0.2 * 0.25 * 1000 + 1;
  CHECK(fluid_field_of(scenario).outcome.reason.find("`cube` sinks") != std::string::npos);
}

TEST_CASE("Bars of exact fields are round-off and more than nothing") {
  const Scenario scenario = fluid_scenario("taylor-green");
  const FluidField field = fluid_field_of(scenario);
  REQUIRE(field.outcome.status == Status::ok);
  CHECK(field.known.velocity);
  CHECK_FALSE(field.known.temperature);
  const FieldSample at = field.at(Wide(0.3), {{0.1, 0.2, 0}, {1.1, 0.2, 0}, {0.7, 0.9, 0}});
  REQUIRE(at.values.size() == 3);
  for (const ParticleSample& bar : at.bars) {
    CHECK(d(bar.v_m_per_s[0]) > 1e-34);
    CHECK(d(bar.v_m_per_s[0]) < 1e-29);
    CHECK(d(bar.pressure_Pa) < 1e-26);
  }
  CHECK(d(magnitude(at.values[0].v_m_per_s[0] - at.values[1].v_m_per_s[0])) < 1e-15);  // periodic; 1.1 is no 0.1 + 1
}

TEST_CASE("A field that does not cover a scene says why") {
  const auto why = [](Scenario scenario) {
    const FluidField field = fluid_field_of(scenario);
    CHECK(field.outcome.status == Status::unsupported);
    CHECK_FALSE(field.at);
    return field.outcome.reason;
  };
  Scenario scenario = fluid_scenario("taylor-green");
  scenario.truth.solution = "no-such";
  CHECK_THAT(why(scenario), Catch::Contains("expected one of taylor-green"));
  scenario = fluid_scenario("taylor-green");
  scenario.scene.domain.periodic_m = {1, 1.5, 0};
  CHECK_THAT(why(scenario), Catch::Contains("whole number of waves along axis 1; found 1.5"));
  scenario = fluid_scenario("taylor-green");
  scenario.scene.gravity_m_per_s2 = {0, -1, 0};
  CHECK_THAT(why(scenario), Catch::Contains("no gravity"));
  scenario = fluid_scenario("taylor-green");
  scenario.scene.fluids.push_back(scenario.scene.fluids[0]);
  CHECK_THAT(why(scenario), Catch::Contains("one fluid; found 2"));
  scenario = fluid_scenario("poiseuille");
  scenario.scene.fluids[0].initial = {};
  CHECK_THAT(why(scenario), Catch::Contains("two boundaries; found 0"));
  add_channel(scenario, 0, 1, 0, 0);
  std::get<Plane>(scenario.scene.bodies[1].shape).normal = {0, 1, 0};
  CHECK_THAT(why(scenario), Catch::Contains("face the same way"));
  scenario = fluid_scenario("taylor-green");
  scenario.truth.kind = TruthKind::none;
  CHECK_THAT(why(scenario), Catch::Contains("not a field"));
  const FluidField field = fluid_field_of(fluid_scenario("taylor-green"));
  CHECK_THROWS_WITH(field.at(-1, {}), Catch::Contains("before 0"));
}
