// Coordinates of joints that close loops: turns are counted between samples too.
#include <catch2/catch.hpp>

#include "ida/ida.hpp"
#include "runs.hpp"
#include "scenes.hpp"
#include "simulation.hpp"

using namespace atwood;

// The crank turns at a constant rate, nine times; the coupler swings, so that the hinge between them loses nine turns.
TEST_CASE("a closing hinge counts its turns, however few samples there are") {
  Scenario scenario = four_bar(4.5, 2);
  scenario.scene.joints[0].driven_rate = 12.566;
  scenario.scene.joints[0].rates[0] = 12.566;
  for (const char* method : {"atwood/dop853", "atwood/dop853:1e-9", "atwood/gauss4", "ida/bdf:1e-8"}) {
    const Engine engine = std::string(method).starts_with("ida") ? ida_engine() : atwood_engine();
    const Recorded many = run(engine, method, scenario, 640, 160), one = run(engine, method, scenario, 640, 1);
    INFO(method << ": " << many.outcome.reason << one.outcome.reason);
    double largest_change = 0;
    for (std::size_t k = 1; k < many.samples.size(); ++k)
      largest_change =
          std::max(largest_change,
                   std::fabs(static_cast<double>(many.samples[k].joints[3].q[0] - many.samples[k - 1].joints[3].q[0])));
    CHECK(largest_change < 1.5);  // radians between two of 160 samples: no turn is lost
    const auto turned = static_cast<double>(many.samples.back().joints[3].q[0] - many.samples.front().joints[3].q[0]);
    CHECK(std::fabs(turned + 4.5 * 12.566) < 1.0);
    CHECK(std::fabs(static_cast<double>(one.samples.back().joints[3].q[0] - many.samples.back().joints[3].q[0])) <
          1e-6);
  }
}

// A bob on a thread of 1 m with 6 m/s at the bottom: too fast to swing back, too slow for a full turn (7 m/s).
TEST_CASE("IDA ends where a rope slackens") {
  Scenario scenario = mechanism_scenario(2);
  scenario.scene.gravity_m_per_s2 = {0, 0, -9.81};
  Body post = point_mass("post", 0, {0, 0, 0});
  post.fixed = true;
  Body bob = point_mass("bob", 1, {0, 0, -1});
  bob.velocity_m_per_s = {6, 0, 0};
  scenario.scene.bodies = {post, bob};
  Rope rope;
  rope.name = "rope";
  rope.bodies = {0, 1};
  scenario.scene.ropes = {rope};
  const Recorded ran = try_run(ida_engine(), "ida/bdf:1e-8", scenario, 40, 40);
  CHECK(ran.outcome.status == Status::diverged);
  const std::string words = "rope `rope` is slack at t = ";
  REQUIRE(ran.outcome.reason.find(words) == 0);
  // Slack at the height h over the post where v^2 = g h: h = (v0^2 / g - 2) / 3, at 0.48 s.
  CHECK(std::fabs(std::stod(ran.outcome.reason.substr(words.size())) - 0.484) < 2e-3);
  CHECK(ran.samples.size() == 10);
}

TEST_CASE("a joint that starts at its stop and moves into it: the sample at t = 0 is before the impact") {
  Scenario scenario = mechanism_scenario(1);
  scenario.scene.gravity_m_per_s2 = {0, 0, 0};
  scenario.scene.bodies = {solid("door", 2, 0.5)};
  Joint joint = hinge(-1, 0, {}, {0, 0, 0.5}, 0, -2);
  joint.limits = JointLimits{0, 3, 0.5};
  scenario.scene.joints = {joint};
  for (const char* method : {"atwood/rk4", "atwood/dopri5:1e-9"}) {
    const Recorded made = run(atwood_engine(), method, scenario, 100, 4);
    INFO(made.outcome.reason);
    REQUIRE(made.outcome.status == Status::ok);
    CHECK(made.samples[0].joints[0].u[0] == -2);
    CHECK(std::fabs(static_cast<double>(made.samples[4].joints[0].u[0] - 1)) < 1e-12);
    CHECK(std::fabs(static_cast<double>(made.samples[4].joints[0].q[0] - 1)) < 1e-12);
  }
}
