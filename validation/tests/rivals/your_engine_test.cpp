// The worked example of "bring your own engine": a worker in another language, through the same pipe as Bullet, moves
// as atwood/symplectic-euler does. The two sum in different orders, so a few ulp are theirs; 1e-12 of the size is not.
#include <catch2/catch.hpp>
#include <cmath>

#include "scene/files.hpp"
#include "validation/study/study.hpp"

namespace atwood {
namespace {

const char* const kHead = R"(
id = "example"
title = "An example"
claim = "Two engines agree."
[run]
t_end_s = 2.0
steps = [64, 1024]
samples = 64
)";

const char* const kThrown = R"(
[world]
gravity_m_per_s2 = [0, 0, -9.8]
[[body]]
name = "ball"
mass_kg = 2
shape.sphere = { radius_m = 0.1 }
velocity_m_per_s = [7.5, 0, 7.5]
[[force]]
kind = "drag"
model = "linear"
bodies = ["ball"]
coefficient_kg_per_s = 0.3
wind_m_per_s = [1, 2, 0]
)";

const char* const kPlanet = R"(
[[body]]
name = "planet"
mass_kg = 3
position_m = [0.4, 0, 0]
velocity_m_per_s = [0, 2, 0]
[[force]]
kind = "attractor"
bodies = ["planet"]
mu_m3_per_s2 = 1
)";

const char* const kThree = R"(
[[body]]
name = "sun"
mass_kg = 5
[[body]]
name = "earth"
mass_kg = 0.5
position_m = [2, 0, 0.1]
velocity_m_per_s = [0, 1.5, 0]
[[body]]
name = "moon"
mass_kg = 0.1
position_m = [2.4, 0, 0]
velocity_m_per_s = [0, 2.5, 0]
[[force]]
kind = "gravity"
bodies = "all"
constant_m3_per_kg_s2 = 1
[[force]]
kind = "spring"
bodies = ["earth", "moon"]
stiffness_N_per_m = 3
rest_length_m = 0.3
[[force]]
kind = "spring"
bodies = ["sun"]
anchor_m = [0, 1, 0]
stiffness_N_per_m = 7
)";

std::vector<Worker> workers() { return find_workers({ATWOOD_YOUR_ENGINE, ATWOOD_ENGINE}); }

Recording run_with(const Worker& worker, const std::string& method, const Scenario& scenario, std::int64_t steps) {
  return run_once(worker, method, scenario.scene, Plan{scenario.t_end_s, steps, scenario.samples}, 20);
}

Scenario scenario(const std::string& scene) { return read_scenario_text(kHead + scene, "example.toml", "."); }

// Largest difference of any value, against the largest value of its kind over the run.
double disagreement(const Recording& a, const Recording& b) {
  REQUIRE(a.values.size() == b.values.size());
  double worst = 0, size = 1;
  const auto compare = [&](const auto& x, const auto& y) {
    for (std::size_t k = 0; k < x.size(); ++k) {
      worst = std::max(worst, std::abs(static_cast<double>(x[k] - y[k])));
      size = std::max(size, std::abs(static_cast<double>(y[k])));
    }
  };
  for (std::size_t n = 0; n < a.values.size(); ++n) {
    CHECK(static_cast<double>(a.values[n].t_s - b.values[n].t_s) == Approx(0).margin(1e-14));
    REQUIRE(a.values[n].bodies.size() == b.values[n].bodies.size());
    for (std::size_t i = 0; i < a.values[n].bodies.size(); ++i) {
      const BodySample &x = a.values[n].bodies[i], &y = b.values[n].bodies[i];
      compare(x.p_m, y.p_m);
      compare(x.v_m_per_s, y.v_m_per_s);
      compare(x.q_wxyz, y.q_wxyz);
      compare(x.w_rad_per_s, y.w_rad_per_s);
    }
  }
  return worst / size;
}

}  // namespace

TEST_CASE("the example engine moves as atwood/symplectic-euler does") {
  const auto found = workers();
  REQUIRE(found.size() == 2);
  for (const auto& worker : found) {
    INFO(worker.path << ": " << worker.reason);
    REQUIRE(worker.status == Status::ok);
  }
  for (const char* scene : {kThrown, kPlanet, kThree}) {
    for (const std::int64_t steps : {64, 1024}) {
      const Scenario each = scenario(scene);
      const Recording theirs = run_with(found[0], "python/symplectic-euler", each, steps);
      const Recording ours = run_with(found[1], "atwood/symplectic-euler", each, steps);
      INFO(theirs.outcome.reason << ours.outcome.reason);
      REQUIRE(theirs.outcome.status == Status::ok);
      REQUIRE(ours.outcome.status == Status::ok);
      REQUIRE(theirs.values.size() == 65);
      CHECK(disagreement(theirs, ours) < 1e-12);
      // Something moved, and the scheme is not another one: explicit Euler differs at first order.
      CHECK(disagreement(theirs, run_with(found[1], "atwood/explicit-euler", each, steps)) > 1e-4);
    }
  }
}

TEST_CASE("the example engine refuses by name") {
  const auto found = workers();
  const auto answer = [&](const std::string& text) {
    const Recording run = run_with(found[0], "python/symplectic-euler", scenario(text), 64);
    CHECK(to_string(run.outcome.status) == "unsupported");
    CHECK(run.values.empty());
    return run.outcome.reason;
  };
  CHECK_THAT(answer(std::string(kPlanet) + "[[force]]\nkind = \"lorentz\"\nbodies = \"all\"\nmagnetic_T = [0, 0, 1]\n"),
             Catch::Contains("lorentz"));
  CHECK_THAT(answer("[[body]]\nname = \"a\"\nmass_kg = 1\nshape.sphere = { radius_m = 1 }\n"
                    "[[body]]\nname = \"floor\"\nfixed = true\nshape.plane = { normal = [0, 0, 1], offset_m = -2 }\n"),
             Catch::Contains("contacts"));
  CHECK_THAT(answer("[[body]]\nname = \"top\"\nmass_kg = 1\ninertia_kg_m2 = [1, 1, 1]\n"
                    "angular_velocity_body_rad_per_s = [0, 0, 1]\n"),
             Catch::Contains("turns"));
  const Recording fall = run_with(found[0], "python/symplectic-euler",
                                  scenario("[[body]]\nname = \"a\"\nmass_kg = 1\n[[force]]\nkind = \"attractor\"\n"
                                           "bodies = [\"a\"]\nmu_m3_per_s2 = 1\n"),
                                  64);
  CHECK(to_string(fall.outcome.status) == "not finite");
}

}  // namespace atwood
