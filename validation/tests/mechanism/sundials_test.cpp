// CVODE and IDA on mechanisms, against the extended truth.
#include <catch2/catch.hpp>
#include <cmath>

#include "cvode/cvode.hpp"
#include "extended/mechanism_truth.hpp"
#include "ida/ida.hpp"
#include "mechanism/start.hpp"
#include "random_mechanism.hpp"
#include "runs.hpp"
#include "scenes.hpp"

using namespace atwood;

namespace {

// Largest differences over all samples: coordinates, rates, determined components of reactions.
struct Apart {
  double q = 0, u = 0, reaction = 0;
};
Apart apart(const SampleSeries& samples, const Truth& truth) {
  Apart made;
  REQUIRE(samples.size() == truth.values.size());
  for (std::size_t k = 0; k < samples.size(); ++k) {
    REQUIRE(samples[k].joints.size() == truth.values[k].joints.size());
    for (std::size_t j = 0; j < samples[k].joints.size(); ++j) {
      const JointSample &a = samples[k].joints[j], &b = truth.values[k].joints[j];
      const auto grow = [](double& largest, Wide x, Wide y) {
        largest = std::max(largest, std::fabs(static_cast<double>(x - y)));
      };
      for (int c = 0; c < 4; ++c) grow(made.q, a.q[c], b.q[c]);
      for (int c = 0; c < 3; ++c) grow(made.u, a.u[c], b.u[c]);
      for (int c = 0; c < 3; ++c) {
        if (!((b.not_unique >> c) & 1u)) grow(made.reaction, a.force_N[c], b.force_N[c]);
        if (!((b.not_unique >> (c + 3)) & 1u)) grow(made.reaction, a.torque_N_m[c], b.torque_N_m[c]);
      }
    }
  }
  return made;
}

}  // namespace

TEST_CASE("CVODE on trees of all kinds of joints") {
  Scenario scenario;
  scenario.scene = random_tree(6, 3);
  scenario.t_end_s = 0.5;
  scenario.scene.joint_forces.emplace_back(JointTorque{1, 0, 2.5, 0, 0, {{0.125, 0.25}}});  // a restart at each switch
  const Truth truth = mechanism_truth(scenario, 4);
  INFO(truth.outcome.reason);
  REQUIRE(truth.outcome.status == Status::ok);
  for (const char* method : {"cvode/adams:1e-11", "cvode/bdf:1e-11"}) {
    INFO(method);
    const Recorded ran = run(cvode_engine(), method, scenario, 4, 4);
    const Apart found = apart(ran.samples, truth);
    CHECK(found.q < 1e-8);
    CHECK(found.u < 1e-7);
    CHECK(found.reaction < 1e-5);
    CHECK(found.q > 1e-15);  // a method of its own, not the truth
  }
}

TEST_CASE("IDA on a loop, in the form of Gear, Gupta and Leimkuhler") {
  const Scenario scenario = four_bar(0.5, 0);
  const Truth truth = mechanism_truth(scenario, 4);
  REQUIRE(truth.outcome.status == Status::ok);
  double last = 1;
  for (const char* method : {"ida/bdf:1e-6", "ida/bdf:1e-8", "ida/bdf:1e-10"}) {
    const Recorded ran = run(ida_engine(), method, scenario, 4, 4);
    const Apart found = apart(ran.samples, truth);
    CHECK(found.q < 0.2 * last);
    last = found.q;
  }
  CHECK(last < 1e-7);
}

// The bar of an IDA run is its difference to a run at a looser tolerance. Here both are known, and so is whether the
// looser one is far off: at 1e-4 the two disagree by far more than either tolerance.
TEST_CASE("the difference of two tolerances of IDA is a bar: at least the error of the tighter run") {
  for (const int cut : {0, 1}) {
    const Scenario scenario = four_bar(0.5, cut);
    const Truth truth = mechanism_truth(scenario, 4);
    REQUIRE(truth.outcome.status == Status::ok);
    Recorded looser = run(ida_engine(), "ida/bdf:1e-4", scenario, 4, 4);
    for (const char* method : {"ida/bdf:1e-6", "ida/bdf:1e-8", "ida/bdf:1e-10"}) {
      INFO(method << ", cut " << cut);
      const Recorded tighter = run(ida_engine(), method, scenario, 4, 4);  // fails with multipliers in the error test
      Truth as_truth = truth;
      as_truth.values = tighter.samples;
      for (std::size_t k = 0; k < truth.values.size(); ++k)
        for (std::size_t j = 0; j < truth.values[k].joints.size(); ++j)
          as_truth.values[k].joints[j].not_unique = truth.values[k].joints[j].not_unique;
      const Apart bar = apart(looser.samples, as_truth), error = apart(tighter.samples, truth);
      CAPTURE(bar.q, error.q, bar.u, error.u, bar.reaction, error.reaction);
      CHECK(bar.q >= error.q);
      CHECK(bar.u >= error.u);
      CHECK(bar.reaction >= error.reaction);
      CHECK(bar.q > std::stod(std::string(method).substr(8)));  // disagreeing runs do not report the tolerance
      looser = tighter;
    }
  }
}

TEST_CASE("what SUNDIALS does not cover of mechanisms is refused by name") {
  const Recorded loop = try_run(cvode_engine(), "cvode/adams", four_bar(0.5, 0), 2, 2);
  CHECK(loop.outcome.status == Status::unsupported);
  CHECK(loop.outcome.reason.find("closes a loop") != std::string::npos);
  Scenario stopped = double_pendulum(1, 0.5, 0.5);
  stopped.scene.joints[0].limits = JointLimits{-1, 1, 0};
  for (const Engine& engine : {cvode_engine(), ida_engine()}) {
    const Recorded ran = try_run(engine, engine.name == "ida" ? "ida/bdf" : "cvode/bdf", stopped, 2, 2);
    CHECK(ran.outcome.status == Status::unsupported);
    CHECK(ran.outcome.reason.find("joint `hinge--1-0` has stops") != std::string::npos);
  }
}
