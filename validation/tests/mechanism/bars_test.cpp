// Bars of mechanisms' truths: the certified ones hold both formulations at other steps and tolerances, those of CVODE
// the certified motion.
#include <catch2/catch.hpp>
#include <cmath>

#include "cvode/cvode.hpp"
#include "extended/mechanism_path.hpp"
#include "extended/mechanism_truth.hpp"
#include "mechanism/start.hpp"
#include "mechanism/values.hpp"
#include "random_mechanism.hpp"
#include "scenes.hpp"
#include "validation/tests/catalogued.hpp"

using namespace atwood;

namespace {

// Every value within the sum of both bars; bars below `widest` of their scales.
void check_bars(const Scenario& scenario, std::int64_t samples, double widest) {
  const Truth certified = mechanism_truth(scenario, samples), truth = cvode_truth(scenario, samples);
  INFO(certified.outcome.reason << " | " << truth.outcome.reason);
  REQUIRE(truth.outcome.status == certified.outcome.status);
  REQUIRE(truth.values.size() == certified.values.size());
  REQUIRE(truth.values.size() > 2);
  const std::vector<Wide> scale = mechanism::scales(scenario.scene, certified.values);
  for (std::size_t k = 0; k < truth.values.size(); ++k) {
    const std::vector<Wide> apart = mechanism::differences(scenario.scene, truth.values[k], {certified.values[k]});
    const std::vector<Wide> ours = mechanism::values_of(scenario.scene, truth.bars[k]);
    const std::vector<Wide> theirs = mechanism::values_of(scenario.scene, certified.bars[k]);
    const std::vector<char> open = mechanism::undetermined_values(scenario.scene, certified.values[k]);
    CHECK(open == mechanism::undetermined_values(scenario.scene, truth.values[k]));
    double breach = 0, bar = 0;
    std::size_t i = 0;
    mechanism::each_value(scenario.scene, truth.values[k], [&](const Wide&, mechanism::ValueKind kind) {
      if (!open[i]) {
        breach = std::max(breach, static_cast<double>(apart[i] / (ours[i] + theirs[i])));
        bar = std::max(bar, static_cast<double>(ours[i] / scale[kind]));
      }
      ++i;
    });
    INFO("sample " << k);
    CHECK(breach <= 1);
    CHECK(bar < widest);
    CHECK(bar > 0);
  }
}

}  // namespace

TEST_CASE("the bars of random mechanisms hold both formulations at other steps") {
  double narrowest = 1, breach = 0;
  for (int seed = 21; seed <= 24; ++seed) {
    INFO("seed " << seed);
    Scenario scenario;
    scenario.scene = random_tree(static_cast<std::uint64_t>(seed), 1 + seed % 3);
    scenario.t_end_s = 0.25;
    const Scene& scene = scenario.scene;
    const Truth truth = mechanism_truth(scenario, 1);
    INFO(truth.outcome.reason);
    REQUIRE(truth.outcome.status == Status::ok);
    const Sample start = mechanism::start_sample(scene);
    const std::vector<Wide> bars = mechanism::values_of(scene, truth.bars[1]),
                            scale = mechanism::scales(scene, truth.values);
    for (const bool in_maximal : {false, true}) {
      const auto motion =
          in_maximal ? extended::maximal_motion(scene, 0.25, start) : extended::reduced_motion(scene, 0.25, start);
      const extended::MechanismPath path =
          extended::integrate_mechanism(*motion, start, {scene, 0.25, 3, 1e-29, 1e-13});
      REQUIRE(path.failure.empty());
      const std::vector<Wide> apart = mechanism::differences(scene, truth.values[1], {path.samples[3]});
      std::size_t i = 0;
      mechanism::each_value(scene, truth.values[1], [&](const Wide&, mechanism::ValueKind kind) {
        breach = std::max(breach, static_cast<double>(apart[i] / bars[i]));
        narrowest = std::min(narrowest, static_cast<double>(bars[i] / scale[kind]));
        ++i;
      });
    }
    CHECK(breach <= 1);
  }
  CHECK(narrowest < 1e-24);
}

TEST_CASE("CVODE's truth of trees of joints: its bars hold the certified motion") {
  check_bars(double_pendulum(1, 0.5, 0.5), 4, 1e-8);
  for (const int seed : {3, 11}) {
    INFO("seed " << seed);
    Scenario scenario;
    scenario.scene = random_tree(static_cast<std::uint64_t>(seed), 3);
    scenario.t_end_s = 0.5;
    check_bars(scenario, 3, 1e-7);
  }
}

TEST_CASE("CVODE's truth of a loop marks what is not unique and holds the certified motion") {
  check_bars(four_bar(0.5, 0), 4, 1e-7);
}

TEST_CASE("CVODE's truth of a rope ends by name where the certified one does") {
  Scenario scenario = mechanism_scenario(1);
  scenario.scene.bodies = {point_mass("counterweight", 3, {-0.25, 0, -2}), point_mass("bob", 1, {0.95, 0, -0.7})};
  Rope rope;
  rope.name = "rope";
  rope.bodies = {0, 1};
  Pulley pulley;
  pulley.axis = {0, 1, 0};
  pulley.radius_m = 0.25;
  pulley.inertia_kg_m2 = 0.0625;
  rope.over = {pulley};
  scenario.scene.ropes = {rope};
  const Truth truth = cvode_truth(scenario, 40);
  INFO(truth.outcome.reason);
  CHECK(truth.outcome.status == Status::unsupported);
  CHECK(truth.outcome.reason.find("rope `rope`: an end reaches its pulley at t = 0.5559") != std::string::npos);
  CHECK(truth.values.size() == 23);
}

TEST_CASE("CVODE's truth refuses the stops of joints by name") {
  Scenario scenario = double_pendulum(1, 0.5, 0.5);
  scenario.scene.joints[0].limits = JointLimits{-1, 1, 0};
  const Truth truth = cvode_truth(scenario, 2);
  CHECK(truth.outcome.status == Status::unsupported);
  CHECK(truth.outcome.reason.find("joint `hinge--1-0` has stops") != std::string::npos);
}

// The pendulum moves in a plane: the rates about its axes in that plane are 0, while those across it differ by what the
// motion magnifies.
TEST_CASE("a rate that is identically 0 has no difference of its kind in its bar") {
  const Scenario given = testing::catalogued("double-pendulum-chaotic");
  const Truth truth = cvode_truth(given, 8);
  REQUIRE(truth.outcome.status == Status::ok);
  const BodySample &value = truth.values.back().bodies[1], &bar = truth.bars.back().bodies[1];
  CHECK(value.w_rad_per_s[0] == 0);
  CHECK(static_cast<double>(bar.w_rad_per_s[0]) < 1e-11);
  CHECK(static_cast<double>(bar.w_rad_per_s[0]) > 0);
  CHECK(static_cast<double>(bar.w_rad_per_s[2]) > 1e-9);
}
