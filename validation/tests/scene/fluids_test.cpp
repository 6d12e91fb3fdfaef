// Scenes with fluids: what is read, what is refused with its figure, where the particles are.
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "scene/fluid_fields.hpp"
#include "scene/fluid_points.hpp"
#include "scene/split_mix.hpp"
#include "text.hpp"

using namespace atwood;
using namespace scene_test;
using Catch::Contains;

namespace {

struct Parts {
  std::string run = "spacings_m = [0.25, 0.125]\nsound_speeds_m_per_s = [10, 20]\n";
  std::string world = "";
  std::string domain = "dimensions = 2\nperiodic_m = [1, 1, 0]\n";
  std::string region = "region.box = { min_m = [0, 0], max_m = [1, 1] }\n";
  std::string fluid = "arrangement = \"disturbed\"\nseed = 7\ninitial = \"taylor-green\"\nviscosity_m2_per_s = 0.01\n";
  std::string rest = "";
};

std::string scene(const Parts& p = {}) {
  return "id = \"t\"\n[run]\nt_end_s = 1\nsteps = [8]\nsamples = 4\n" + p.run + "[world]\n" + p.world + "[domain]\n" +
         p.domain + "[[fluid]]\nname = \"water\"\ndensity_kg_per_m3 = 1000\n" + p.region + p.fluid + p.rest;
}

Parts with(std::string Parts::*part, const std::string& text) {
  Parts p;
  p.*part = text;
  return p;
}

double total_mass(const Fluid& fluid) {
  double sum = 0;
  for (const double m : fluid.particles.mass_kg) sum += m;
  return sum;
}

}  // namespace

TEST_CASE("a fluid in a box: the disturbed lattice and its field") {
  const Scenario s = read(scene());
  REQUIRE(s.spacings_m == std::vector<double>{0.25, 0.125});
  REQUIRE(s.scene.bodies.empty());
  REQUIRE(s.scene.domain.dimensions == 2);
  const Fluid& water = s.scene.fluids.at(0);
  REQUIRE(water.spacing_m == 0.25);
  REQUIRE(water.sound_speed_m_per_s == 10);
  REQUIRE(water.disturbance == 0.2);
  REQUIRE(water.particles.position_m.size() == 16);
  // x is the slowest index; two random numbers a particle, in the order x, y.
  SplitMix64 random{7};
  const double k = 2 * std::numbers::pi;
  for (std::size_t n = 0; n < 16; ++n) {
    const double x = (static_cast<double>(n / 4) + 0.5) * 0.25 + 0.2 * 0.25 * random.next_unit();
    const double y = (static_cast<double>(n % 4) + 0.5) * 0.25 + 0.2 * 0.25 * random.next_unit();
    REQUIRE(water.particles.position_m[n][0] == x);
    REQUIRE(water.particles.position_m[n][1] == y);
    REQUIRE(water.particles.velocity_m_per_s[n][0] == Approx(-std::cos(k * x) * std::sin(k * y)).margin(1e-15));
    REQUIRE(water.particles.velocity_m_per_s[n][1] == Approx(std::sin(k * x) * std::cos(k * y)).margin(1e-15));
    const double p = -250 * (std::cos(2 * k * x) + std::cos(2 * k * y));
    REQUIRE(water.particles.density_kg_per_m3[n] == Approx(1000 + p / 100).epsilon(1e-14));
    REQUIRE(water.particles.mass_kg[n] == water.particles.density_kg_per_m3[n] * 0.0625);
  }
}

TEST_CASE("another resolution: spacing, sound speed, particles and densities change") {
  const Scenario s = read(scene());
  const Scene fine = at_resolution(s, 0.125, 20);
  REQUIRE(fine.fluids[0].particles.position_m.size() == 64);
  REQUIRE(fine.fluids[0].sound_speed_m_per_s == 20);
  const auto& p = fine.fluids[0].particles;
  const double k = 2 * std::numbers::pi;
  const double pressure = -250 * (std::cos(2 * k * p.position_m[5][0]) + std::cos(2 * k * p.position_m[5][1]));
  REQUIRE(p.density_kg_per_m3[5] == Approx(1000 + pressure / 400).epsilon(1e-14));
}

TEST_CASE("rings: equal areas that fill the circle, and its ellipse") {
  Parts p;
  p.domain = "dimensions = 2\n";
  p.run = "spacings_m = [0.1]\nsound_speeds_m_per_s = [1000]\n";
  p.region = "region.circle = { center_m = [1, 2], radius_m = 1 }\n";
  p.fluid = "arrangement = \"rings\"\n";
  const Fluid drop = read(scene(p)).scene.fluids[0];
  REQUIRE(drop.particles.position_m.size() == 300);
  REQUIRE(total_mass(drop) == Approx(1000 * std::numbers::pi).epsilon(1e-12));
  Real3 middle{};
  for (const Real3& x : drop.particles.position_m) middle[0] += x[0] / 300, middle[1] += x[1] / 300;
  REQUIRE(middle[0] == Approx(1).margin(1e-12));
  REQUIRE(middle[1] == Approx(2).margin(1e-12));
  REQUIRE(std::hypot(drop.particles.position_m[0][0] - 1, drop.particles.position_m[0][1] - 2) == Approx(0.05));
  p.region = "region.ellipse = { semi_axes_m = [2, 0.5] }\n";
  const Fluid ellipse = read(scene(p)).scene.fluids[0];
  REQUIRE(ellipse.particles.position_m.size() == 300);
  for (const Real3& x : ellipse.particles.position_m) REQUIRE(x[0] * x[0] / 4 + x[1] * x[1] / 0.25 < 1);
}

TEST_CASE("round regions on a lattice have the region's mass") {
  Parts p;
  p.domain = "dimensions = 3\n";
  p.run = "spacings_m = [0.13]\nsound_speeds_m_per_s = [10]\n";
  p.region = "region.ball = { radius_m = 1 }\n";
  p.fluid = "velocity_m_per_s = [1, 0, 0]\nvelocity_gradient_per_s = [[0, 2, 0], [0, 0, 0], [0, 0, 3]]\n";
  const Fluid ball = read(scene(p)).scene.fluids[0];
  REQUIRE(total_mass(ball) == Approx(4000 * std::numbers::pi / 3).epsilon(1e-12));
  const Real3 x = ball.particles.position_m[3];
  REQUIRE(ball.particles.velocity_m_per_s[3] == Real3{1 + 2 * x[1], 0, 3 * x[2]});
}

TEST_CASE("fluids: JSON and back, to the bit") {
  Parts p;
  p.world = "gravity_m_per_s2 = [0, -9.81, 0]\n";
  p.domain = "dimensions = 2\nperiodic_m = [1, 0]\n";
  p.fluid =
      "equation_of_state = \"tait\"\narrangement = \"disturbed\"\ndisturbance = 0.1\nheat_capacity_J_per_kg_K = 4000\n"
      "conductivity_W_per_m_K = 0.6\ntemperature_K = 293\nviscous_heat = true\ninitial = \"hydrostatic\"\n";
  p.rest =
      "[[body]]\nname = \"floor\"\nfixed = true\nshape.plane = { normal = [0, 1, 0], offset_m = 0 }\n"
      "[[fluid_boundary]]\nbody = \"floor\"\nslip = \"free-slip\"\ntemperature_K = 300\n"
      "[[probe]]\nkind = \"pressure\"\nposition_m = [0.5, 0]\n[[probe]]\nname = \"top\"\nkind = \"column-height\"\n"
      "position_m = [0.5, 0]\n[[probe]]\nkind = \"force-on-body\"\nbody = \"floor\"\n";
  const Scenario s = read(scene(p));
  const std::string json = scenario_to_json(s);
  const Scenario back = scenario_from_json(json);
  REQUIRE(scenario_to_json(back) == json);
  const Fluid &a = s.scene.fluids[0], &b = back.scene.fluids[0];
  REQUIRE(a.particles.position_m == b.particles.position_m);
  REQUIRE(a.particles.velocity_m_per_s == b.particles.velocity_m_per_s);
  REQUIRE(a.particles.mass_kg == b.particles.mass_kg);
  REQUIRE(a.particles.density_kg_per_m3 == b.particles.density_kg_per_m3);
  REQUIRE(a.particles.temperature_K == b.particles.temperature_K);
  REQUIRE(a.initial.parameters == b.initial.parameters);
  REQUIRE(back.spacings_m == s.spacings_m);
  REQUIRE(back.sound_speeds_m_per_s == s.sound_speeds_m_per_s);
  REQUIRE(back.scene.fluid_boundaries[0].temperature_K == 300);
  REQUIRE(back.scene.fluid_boundaries[0].slip == Slip::free_slip);
  REQUIRE(back.scene.probes.size() == 3);
  REQUIRE(back.scene.probes[0].name == "pressure");
  REQUIRE(back.scene.probes[2].body == 0);
  REQUIRE(back.scene.domain.periodic_m == s.scene.domain.periodic_m);
  // Tait under gravity: (rho / rho0)^6 = 1 + 6 g d / c^2
  const double depth = 1 - a.particles.position_m[0][1];
  REQUIRE(std::pow(a.particles.density_kg_per_m3[0] / 1000, 6) == Approx(1 + 6 * 9.81 * depth / 100).epsilon(1e-13));
}

TEST_CASE("scenes without fluids keep their JSON") {
  const std::string json = scene_to_json(read(kHead + "[[body]]\nname = \"b\"\nmass_kg = 1\n").scene);
  for (const char* key : {"domain", "fluid", "probe", "spacings"}) REQUIRE(json.find(key) == std::string::npos);
}

TEST_CASE("refused with the figure") {
  const auto refused = [](const Parts& p, const std::string& words) { CHECK_THAT(message(scene(p)), Contains(words)); };
  refused(
      with(&Parts::run, "spacings_m = [0.3]\nsound_speeds_m_per_s = [10]\n"),
      "`spacings_m` in [run] has 0.3, which does not fill the region of the fluid `water`: 1 m along x is 3.33333 spacings of "
      "0.3 m");
  refused(with(&Parts::run, "spacings_m = [0.125, 0.25]\nsound_speeds_m_per_s = [10]\n"), "0.25 after 0.125");
  refused(with(&Parts::run, "spacings_m = [0.25]\nsound_speeds_m_per_s = [0]\n"), "expected a number above 0");
  refused(with(&Parts::run, "spacings_m = [0.25]\n"), "missing key `sound_speed_m_per_s`");
  refused(with(&Parts::fluid, "spacing_m = 0.25\n"), "found `spacing_m` in [[fluid]] `water` beside `spacings_m`");
  refused(with(&Parts::domain, "dimensions = 2\nperiodic_m = [0.5, 1, 0]\n"),
          "reaches from 0 to 1 m along x, outside the domain; expected it within the period, 0 to 0.5 m");
  refused(with(&Parts::region, "region.box = { min_m = [0, 0, 0.5], max_m = [1, 1, 1] }\n"),
          "the domain has two dimensions");
  refused(with(&Parts::region, "region.ball = { radius_m = 1 }\n"),
          "the region `ball` in [[fluid]] `water` has three dimensions");
  refused(with(&Parts::world, "gravity_m_per_s2 = [0, 0, -9.81]\n"), "`gravity_m_per_s2` in [world] is -9.81 along z");
  refused(with(&Parts::fluid, "initial = \"taylor-gren\"\n"), "did you mean taylor-green?");
  refused(with(&Parts::fluid, "initial = { field = \"taylor-green\", speed = 2 }\n"), "did you mean speed_m_per_s?");
  refused(with(&Parts::fluid, "initial = \"heat-sine\"\n"), "expected `heat_capacity_J_per_kg_K` above 0");
  refused(with(&Parts::fluid, "conductivity_W_per_m_K = 1\n"), "is given without a temperature");
  refused(with(&Parts::fluid, "initial = \"square-patch\"\nvelocity_m_per_s = [1, 0]\n"),
          "found `velocity_m_per_s` beside `initial`");
  refused(with(&Parts::fluid, "arrangement = \"rings\"\n"), "expected a circle or an ellipse");
  refused(with(&Parts::fluid, "disturbance = 0.1\n"), "expected it with `arrangement = \"disturbed\"` only");
  refused(with(&Parts::fluid, "tait_exponent = 7\n"), "beside a linear equation of state");
  const std::string second = "[[fluid]]\nname = \"oil\"\ndensity_kg_per_m3 = 800\n";
  refused(with(&Parts::rest, second + "region.box = { min_m = [0.5, 0], max_m = [1, 1] }\n"),
          "the fluids `water` and `oil` overlap");
  const std::string wall = "[[body]]\nname = \"wall\"\nfixed = true\n", bound = "[[fluid_boundary]]\nbody = \"wall\"\n";
  refused(
      with(&Parts::rest, wall + "position_m = [0.5, -0.1, 0]\nshape.box = { half_extents_m = [1, 0.1, 1] }\n" + bound),
      "the boundary `wall` is 0.2 m thick and leaks at a spacing of 0.25 m; expected at least two spacings, 0.5 m");
  refused(with(&Parts::rest, wall + "shape.plane = { normal = [0, 1, 0], offset_m = 0.2 }\n" + bound),
          "behind the plane of the boundary `wall`");
  refused(
      with(&Parts::rest, wall + "shape.plane = { normal = [0, 1, 0], offset_m = 0 }\n" + bound + "slip = \"inflow\"\n"),
      "open boundaries (inflow, outflow) are not simulated");
  for (const std::string heat : {"temperature_K", "heat_flux_W_per_m2"})
    refused(
        with(&Parts::rest, wall + "shape.plane = { normal = [0, 1, 0], offset_m = 0 }\n" + bound + heat + " = 300\n"),
        "`" + heat + "` in [[fluid_boundary]] is given, and no fluid has a temperature");
  const std::string floor = wall + "shape.plane = { normal = [0, 1, 0], offset_m = 0 }\n" + bound;
  for (const std::string open : {"kind = \"inflow\"", "inflow = true", "outflow = true", "type = \"outlet\"",
                                 "inlet = true", "velocity_profile = [1, 0]"})
    refused(with(&Parts::rest, floor + open + "\n"),
            "found `" + open.substr(0, open.find(' ')) +
                "` in [[fluid_boundary]]; open boundaries (inflow, outflow) are not simulated");
  refused(with(&Parts::rest, floor + "velocity_m_per_s = [1, 0]\n"), "and the velocity of the wall in its [[body]]");
  refused(
      with(&Parts::rest, wall + "shape.plane = { normal = [0.6, 0.8, 0], offset_m = -1 }\n" + bound),
      "the plane of the body `wall` in [[fluid_boundary]] is not perpendicular to a coordinate axis: its normal is [0.6, 0.8, 0]");
  const std::string warm = "heat_capacity_J_per_kg_K = 1\n";
  for (const std::string heat : {"temperature_K", "heat_flux_W_per_m2"}) {
    Parts p = with(&Parts::rest, floor + heat + " = 300\n");
    p.fluid += warm;
    refused(p, "`" + heat + "` in [[fluid_boundary]] is given, and no fluid conducts heat");
    p.fluid += "conductivity_W_per_m_K = 1\n";
    CHECK(message(scene(p)) == "no error");
  }
  Parts insulated = with(&Parts::rest, floor + "heat_flux_W_per_m2 = 0\n");
  insulated.fluid += warm;
  CHECK(message(scene(insulated)) == "no error");
  refused(with(&Parts::run, "spacings_m = [1e-7]\nsound_speeds_m_per_s = [10]\n"), "has 1e+14 particles");
  refused(with(&Parts::rest, wall + "shape.plane = { normal = [0, 1, 0], offset_m = 0 }\n" + bound + bound),
          "a second [[fluid_boundary]] of the body `wall`");
  refused(
      with(&Parts::rest, wall + "velocity_m_per_s = [1, 0, 0]\nshape.plane = { normal = [0, 1, 0], offset_m = 0 }\n"),
      "the velocity of the body `wall` is not 0 for a fixed body");
  refused(with(&Parts::rest,
               wall + "velocity_m_per_s = [1, 1, 0]\nshape.plane = { normal = [0, 1, 0], offset_m = 0 }\n" + bound),
          "has a component along the plane's normal");
  CHECK(message(
            scene(with(&Parts::rest, wall +
                                         "velocity_m_per_s = [1, 0, 0]\nshape.plane = { normal = [0, 1, 0], offset_m = "
                                         "0 }\n" +
                                         bound))) == "no error");
  refused(with(&Parts::rest, "[[probe]]\nkind = \"pressure\"\n"), "missing key `position_m` in [[probe]]");
  CHECK_THAT(message(kHead + "[domain]\ndimensions = 2\n[[body]]\nname = \"b\"\nmass_kg = 1\n"),
             Contains("found `domain` without [[fluid]]"));
}

TEST_CASE("planes at the edges of a wall's region let the fluid be; finite bodies take its place") {
  Parts p;
  p.domain = "dimensions = 2\n";
  p.rest =
      "[[body]]\nname = \"floor\"\nfixed = true\nshape.plane = { normal = [0, 1, 0], offset_m = 0 }\n"
      "[[fluid_boundary]]\nbody = \"floor\"\n"
      "[[body]]\nname = \"ball\"\nmass_kg = 1\nposition_m = [0.5, 0.5, 0]\nshape.sphere = { radius_m = 0.26 }\n"
      "[[fluid_boundary]]\nbody = \"ball\"\n";
  p.fluid = "";
  const Fluid water = read(scene(p)).scene.fluids[0];
  REQUIRE(water.particles.position_m.size() == 12);  // the four nearest to the middle, 0.177 m away, are the ball's
  for (const Real3& x : water.particles.position_m) REQUIRE(std::hypot(x[0] - 0.5, x[1] - 0.5) > 0.26);
}

TEST_CASE("points of walls are counted before they are made") {
  const std::string body = "[[body]]\nname = \"wall\"\nfixed = true\n", bound = "[[fluid_boundary]]\nbody = \"wall\"\n";
  const std::string floor = body + "shape.plane = { normal = [0, 1, 0], offset_m = 0 }\n";
  // A floor reaches four times the fluid's extent beyond it: 9 million squares of 0.25 m, in four layers.
  Parts far = with(&Parts::rest, floor + bound);
  far.run = "spacings_m = [0.25]\nsound_speeds_m_per_s = [10]\n", far.domain = "dimensions = 2\n", far.fluid = "";
  far.rest +=
      "[[fluid]]\nname = \"drop\"\ndensity_kg_per_m3 = 1000\nregion.circle = { center_m = [2.5e5, 1], "
      "radius_m = 0.5 }\n";
  CHECK_THAT(
      message(scene(far)),
      Contains("the wall of the boundary `wall` has 36000104 points at a spacing of 0.25 m; expected at most 4000000"));
  // The layers of a box are counted with all below them.
  Parts solid =
      with(&Parts::rest, body + "position_m = [0, -300, 0]\nshape.box = { half_extents_m = [300, 300, 1] }\n" + bound);
  solid.domain = "dimensions = 2\n", solid.fluid = "";
  CHECK_THAT(message(scene(solid)), Contains("has 5760000 points at a spacing of 0.25 m"));
  // A finer spacing of the ladder.
  solid.rest = body + "position_m = [0, -200, 0]\nshape.box = { half_extents_m = [200, 200, 1] }\n" + bound;
  const Scenario s = read(scene(solid));
  CHECK_THROWS_WITH(at_resolution(s, 0.125, 10), Contains("has 10240000 points at a spacing of 0.125 m"));
}

TEST_CASE("points of a fluid from a table") {
  const auto folder = std::filesystem::temp_directory_path() / "atwood-points-test";
  std::filesystem::create_directories(folder);
  Parts parts = with(&Parts::region, "region.file = \"points.csv\"\n");
  parts.run = "spacings_m = [0.25]\nsound_speeds_m_per_s = [10]\n";
  parts.domain = "dimensions = 2\n";
  parts.fluid = "";  // arrangement: the table's
  const auto write = [&](const std::string& table) { std::ofstream(folder / "points.csv") << table; };
  write("\xEF\xBB\xBFx_m,y_m\r\n# two\n0, 0\n\n2.5e8,-0.25\n");
  const Scenario s = read(scene(parts), folder);
  REQUIRE(s.scene.fluids.at(0).particles.position_m.size() == 2);
  CHECK(s.scene.fluids[0].particles.position_m[1] == Real3{2.5e8, -0.25, 0});
  const auto refused = [&](const std::string& row) {
    write("x_m,y_m\n0,0\n" + row + "\n");
    return message(scene(parts), folder);
  };
  for (const char* row : {"1,nan", "1", "1,2,3", "0x1p3,0", "1,2m", "1,", "1e999,0"}) {
    INFO(row);
    CHECK_THAT(refused(row), Contains("points.csv:3:1: found `" + std::string(row) + "`; expected 2 finite numbers"));
  }
  CHECK_THAT(refused("2.6e8,0"), Contains("expected coordinates up to 10^9 spacings of 0.25 m"));
  parts.domain = "dimensions = 2\nperiodic_m = [0, 1]\n";
  CHECK_THAT(refused("5,1.25"),
             Contains("points.csv:3:1: found `5,1.25`; expected y from 0 to 1 m, within the period"));
  CHECK(refused("5,1") == "no error");
  parts.domain = "dimensions = 2\n";
  write("");
  CHECK_THAT(message(scene(parts), folder), Contains("found no point"));
  write("x,y\n0,0\n");
  CHECK_THAT(message(scene(parts), folder), Contains("points.csv:1:1: found `x,y`; expected the header x_m,y_m"));
  std::filesystem::remove_all(folder);
}
