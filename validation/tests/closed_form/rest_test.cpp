// Scenes in equilibrium and others: the check of the solution `rest`, against statics by hand.
#include <catch2/catch.hpp>

#include "scenes.hpp"
#include "validation/tests/catalogued.hpp"

using namespace atwood;
using namespace atwood::testing;

namespace {

Body cube(const std::string& name, Real3 half, Real3 p) {
  const double m = 2;
  Body made = solid(name, m,
                    {m / 3 * (half[1] * half[1] + half[2] * half[2]), m / 3 * (half[2] * half[2] + half[0] * half[0]),
                     m / 3 * (half[0] * half[0] + half[1] * half[1])},
                    {0, 0, 0});
  made.shape = Box{half};
  made.position_m = p;
  return made;
}

Body ground() {
  Body made = point("ground", 0, {0, 0, 0}, {0, 0, 0});
  made.shape = Plane{{0, 0, 1}, 0};
  made.fixed = true;
  return made;
}

Scenario standing(double friction, std::vector<Body> bodies) {
  Scenario given = scenario("rest", 10);
  given.scene.gravity_m_per_s2 = {0, 0, -9.81};
  given.scene.pairs[0].friction = friction;
  given.scene.bodies = std::move(bodies);
  return given;
}

std::string why(const Scenario& given) { return closed_form_truth(given, 60).outcome.reason; }

}  // namespace

TEST_CASE("Stacks, walls and houses of cards of the catalogue stand still") {
  for (const char* id : {"stack-10", "wall", "card-house"}) {
    const Scenario given = catalogued(id);
    const Truth truth = closed_form_truth(given, given.samples);
    INFO(id << ": " << truth.outcome.reason);
    REQUIRE(truth.outcome.status == Status::ok);
    for (std::size_t i = 0; i < given.scene.bodies.size(); ++i) {
      for (int k = 0; k < 3; ++k)
        CHECK(truth.values.back().bodies[i].p_m[k] == Wide(given.scene.bodies[i].position_m[k]));
      CHECK(truth.values.back().bodies[i].v_m_per_s == std::array<Wide, 3>{});
      CHECK(static_cast<double>(truth.bars.back().bodies[i].p_m[0]) < 1e-14);
    }
  }
}

TEST_CASE("The house of cards falls where friction is below tan t - d / L") {
  // The feet of the lowest cards need H over the whole weight they bear: (W / 2 + P) (tan t - d / L) over W + P, and
  // the joint above needs at most tan t = 0.268. Below half of 0.228 no foot holds.
  Scenario given = catalogued("card-house");
  for (PairLaw& law : given.scene.pairs) law.friction = 0.11;
  CHECK_THAT(why(given), Catch::Contains("no contact forces within the friction cones were found that hold"));
}

TEST_CASE(
    "Overhangs: two bricks are stable up to 1/2, three to 1/2 + 1/4 of their half length beyond the table's edge") {
  // The harmonic stack: brick k from the top may reach 1 / (2 k) of a length over the one below it.
  const auto stack = [](double share) {
    const Real3 half{0.5, 0.25, 0.125};
    const double top = share * 1.0 / 2, middle = share * 1.0 / 4;
    return standing(0.5, {ground(), cube("low", half, {0, 0, 0.125}), cube("middle", half, {middle, 0, 0.375}),
                          cube("top", half, {middle + top, 0, 0.625})});
  };
  CHECK(why(stack(0.98)) == "");
  CHECK_THAT(why(stack(1.02)), Catch::Contains("hold"));
}

TEST_CASE("A box on a slope is at rest below atan mu if it does not tip") {
  const auto on_slope = [](double degrees, double friction, Real3 half) {
    const double t = degrees * M_PI / 180;
    Body slope = ground();
    std::get<Plane>(slope.shape).normal = {std::sin(t), 0, std::cos(t)};
    Body box = cube("box", half, {half[2] * std::sin(t), 0, half[2] * std::cos(t)});
    box.orientation_wxyz = {std::cos(t / 2), 0, std::sin(t / 2), 0};
    return standing(friction, {slope, box});
  };
  CHECK(why(on_slope(29, std::tan(30 * M_PI / 180), {0.2, 0.2, 0.1})) == "");
  CHECK_THAT(why(on_slope(31, std::tan(30 * M_PI / 180), {0.2, 0.2, 0.1})), Catch::Contains("`box`"));
  CHECK(why(on_slope(25, 1, {0.1, 0.1, 0.2})) == "");  // tan 26.57 degrees = 1/2
  CHECK_THAT(why(on_slope(28, 1, {0.1, 0.1, 0.2})), Catch::Contains("`box`"));
}

TEST_CASE("Crossed planks, balls in a corner; floating, overlapping and moving bodies are refused by name") {
  // Two planks cross over a third: the edges meet in points that are corners of none.
  Scenario given = standing(
      0.3, {ground(), cube("below", {1, 0.1, 0.1}, {0, 0, 0.1}), cube("across", {0.1, 1, 0.1}, {0.3, 0, 0.3})});
  CHECK(why(given) == "");
  given.scene.bodies[2].position_m = {0.3, 0.2, 0.3};  // its centre beyond the plank below
  CHECK_THAT(why(given), Catch::Contains("hold"));
  Body wall = ground();
  wall.name = "wall";
  wall.shape = Plane{{1, 0, 0}, 0};
  given = standing(0, {ground(), wall, ball("ball", 1, 0.25, {0.25, 0, 0.25}, {0, 0, 0})});
  CHECK(why(given) == "");
  given.scene.gravity_m_per_s2 = {1, 0, -9.81};  // leaves the wall
  CHECK_THAT(why(given), Catch::Contains("`ball`"));
  given.scene.gravity_m_per_s2 = {0, 0, -9.81};
  given.scene.bodies[2].position_m[2] = 0.3;
  CHECK_THAT(why(given), Catch::Contains("hold `ball`"));
  given.scene.bodies[2].position_m[2] = 0.2;
  CHECK_THAT(why(given), Catch::Contains("overlap"));
  given.scene.bodies[2].position_m[2] = 0.25;
  given.scene.bodies[2].velocity_m_per_s[1] = 1;
  CHECK_THAT(why(given), Catch::Contains("has an initial velocity"));
}

TEST_CASE(
    "A slope and friction are compared in quad: boxes rest on slopes of 1e-13 as on those of 0.3, up to the limit") {
  const Real3 half{0.25, 0.25, 0.125};
  const auto stack = [&](double slope, double friction) {
    Scenario given = standing(friction, {ground(), cube("low", half, {0, 0, 0.125}), cube("top", half, {0, 0, 0.375})});
    given.scene.gravity_m_per_s2 = {8 * slope, 0, -8};
    return given;
  };
  for (const double slope : {0.3, 1e-3, 3e-7, 1e-9, 1e-13, 1e-15, 1e-18})
    for (const double above : {1e-2, 1e-8, 1e-14}) {
      INFO("slope " << slope << ", friction larger by " << above);
      const Truth truth = closed_form_truth(stack(slope, slope * (1 + above)), 4);
      CHECK(truth.outcome.reason == "");
      REQUIRE(truth.outcome.status == Status::ok);
      CHECK(static_cast<double>(truth.bars.back().bodies[1].p_m[0]) < 1e-25);
      CHECK(static_cast<double>(truth.bars.back().bodies[1].v_m_per_s[0]) < 1e-25);
    }
  for (const double slope : {0.3, 1e-3, 3e-7, 1e-9, 1e-13})
    for (const double below : {1e-2, 1e-8, 1e-14, 1.0}) {
      INFO("slope " << slope << ", friction smaller by " << below);
      CHECK_THAT(why(stack(slope, slope * (1 - below))),
                 Catch::Contains(slope < 1e-6 ? "`ground` have a slope" : "that hold"));
    }
  CHECK_THAT(
      why(stack(1e-9, 2e-10)),
      Catch::Contains("a slope of 1e-09 and friction of 2e-10: whether another contact keeps them from sliding"));
  // Forces along gravity do not hold a box whose weight passes the edge below it.
  Scenario leans = stack(1e-9, 1e-7);
  leans.scene.bodies[2].position_m[0] = 0.26;
  CHECK_THAT(why(leans), Catch::Contains("forces along gravity do not hold `top`"));
}

TEST_CASE(
    "What is below round-off is in the bars: slopes without friction, balls on slopes, faces that are not parallel") {
  const Real3 half{0.25, 0.25, 0.125};
  const double T = 10;  // of standing()
  Scenario slides = standing(0, {ground(), cube("box", half, {0, 0, 0.125})});
  slides.scene.gravity_m_per_s2 = {4e-15, 0, -8};
  Truth truth = closed_form_truth(slides, 4);
  INFO(truth.outcome.reason);
  REQUIRE(truth.outcome.status == Status::ok);
  CHECK(static_cast<double>(truth.bars.back().bodies[1].p_m[0]) >= 4e-15 * T * T / 2);
  CHECK(static_cast<double>(truth.bars.back().bodies[1].v_m_per_s[0]) >= 4e-15 * T);
  Scenario rolls = standing(0.5, {ground(), ball("ball", 1, 0.25, {0, 0, 0.25}, {0, 0, 0})});
  CHECK(static_cast<double>(closed_form_truth(rolls, 4).bars.back().bodies[1].p_m[0]) < 1e-25);
  rolls.scene.gravity_m_per_s2 = {4e-15, 0, -8};
  truth = closed_form_truth(rolls, 4);
  REQUIRE(truth.outcome.status == Status::ok);
  CHECK(static_cast<double>(truth.bars.back().bodies[1].p_m[0]) >= 4e-15 * 5 / 7 * T * T / 2);
  CHECK(static_cast<double>(truth.bars.back().bodies[1].w_rad_per_s[1]) >= 4e-15 * 5 / 7 * T / 0.25);
  // It stands on an edge, and the opposite one is 0.5 x 2e-12 above the floor.
  Scenario rocks = standing(0.5, {ground(), cube("box", half, {0, 0, 0.125 + 0.25 * 2e-12})});
  rocks.scene.bodies[1].orientation_wxyz = {1, 0, 1e-12, 0};
  truth = closed_form_truth(rocks, 4);
  REQUIRE(truth.outcome.status == Status::ok);
  CHECK(static_cast<double>(truth.bars.back().bodies[1].p_m[2]) >= 0.25 * 2e-12);
  CHECK(static_cast<double>(truth.bars.back().bodies[1].q_wxyz[2]) >= 1e-12);
}
