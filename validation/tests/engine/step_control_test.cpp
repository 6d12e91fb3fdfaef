// Tolerances: every pair keeps its error near what was asked, from any first guess; its settings act; known rates are
// reused, and only where they hold.
#include <catch2/catch.hpp>

#include "integrators/adaptive.hpp"
#include "integrators/families.hpp"
#include "scenes.hpp"

namespace atwood::testing {
namespace {

std::vector<std::string> pairs() {
  std::vector<std::string> schemes;
  for (const auto& family : {explicit_runge_kutta_methods(), nystrom_methods()})
    for (const MethodInfo& info : family)
      if (info.adaptive) schemes.push_back(info.id.substr(7));
  return schemes;
}

Outcome adaptive(const std::string& scheme, const Scene& scene, const Plan& plan, double rtol, Settings overrides,
                 std::vector<Sample>& samples) {
  MethodId id;
  id.engine = "atwood";
  id.scheme = scheme;
  id.rtol = rtol;
  id.overrides = std::move(overrides);
  samples.clear();
  Observer observer;
  observer.sample = [&](const Sample& sample) { samples.push_back(sample); };
  return atwood_engine().run(id, scene, plan, observer, 0);
}

double end_error(const std::vector<Sample>& samples, const Sample& truth) {
  return distance(samples.back().bodies[0].p_m, truth.bodies[0].p_m);
}

Sample orbit_truth() { return run("verner9", kepler(0.6), {10, 4000, 1}, "quad").samples.back(); }

TEST_CASE("there are twelve pairs with error control") { CHECK(pairs().size() == 12); }

TEST_CASE("a smaller tolerance gives a smaller error, not far from what was asked") {
  const Sample truth = orbit_truth();
  std::vector<Sample> samples;
  for (const std::string& scheme : pairs()) {
    INFO(scheme);
    double first = 0;
    for (const double rtol : {1e-5, 1e-7, 1e-9}) {
      const Outcome outcome = adaptive(scheme, kepler(0.6), {10, 1000, 1}, rtol, {}, samples);
      REQUIRE(outcome.status == Status::ok);
      const double error = end_error(samples, truth);
      INFO(rtol << " gave " << error << " in " << outcome.steps_taken << " steps");
      CHECK(error < 3000 * rtol);
      if (rtol == 1e-5) first = error;
      if (rtol == 1e-9) CHECK(error < first / 300);
    }
  }
}

// An implicit method's equations have no solution that it finds where the guess is far too long: it takes a shorter
// step.
TEST_CASE("a bad first guess of the step is no problem") {
  const Sample truth = orbit_truth();
  std::vector<Sample> samples;
  std::vector<std::string> schemes = pairs();
  schemes.push_back("radau5");
  for (const std::string& scheme : schemes) {
    INFO(scheme);
    const Outcome good = adaptive(scheme, kepler(0.6), {10, 1000, 1}, 1e-8, {}, samples);
    for (const std::int64_t steps : {std::int64_t{1}, std::int64_t{2}, std::int64_t{100'000'000}}) {
      INFO("--steps " << steps);
      const Outcome outcome = adaptive(scheme, kepler(0.6), {10, steps, 1}, 1e-8, {}, samples);
      REQUIRE(outcome.status == Status::ok);
      CHECK(end_error(samples, truth) < 3e-5);
      CHECK(static_cast<double>(outcome.rate_evaluations) < 1.3 * static_cast<double>(good.rate_evaluations) + 300);
    }
  }
}

TEST_CASE("the controller's settings act") {
  std::vector<Sample> samples;
  for (const std::string& scheme : pairs()) {
    INFO(scheme);
    const auto evaluations = [&](Settings overrides) {
      const Outcome outcome = adaptive(scheme, kepler(0.6), {10, 1000, 1}, 1e-8, std::move(overrides), samples);
      REQUIRE(outcome.status == Status::ok);
      return outcome.rate_evaluations;
    };
    const auto standard = evaluations({});
    CHECK(evaluations({{"safety", 0.6}}) > standard);  // shorter steps
    CHECK(evaluations({{"beta", 0.08}}) != standard);
    CHECK(evaluations({{"most_factor", 1.01}}) != standard);
    CHECK(evaluations({{"least_factor", 0.999}}) != standard);
  }
}

// HW II, eq. IV.2.43, by hand: k + 1 = 5, err = 0.5 after err = 0.1, beta = 0.04.
TEST_CASE("the controller's formula") {
  StepControl<double> control(4);
  control.next_step(1, 0.1);
  CHECK(control.accepted());
  CHECK(control.next_step(1, 0.5) == Approx(0.9 * std::pow(0.5, -(0.2 - 0.03)) * std::pow(0.1, 0.04)));
  CHECK(control.next_step(1, 32) == Approx(std::max(0.2, 0.9 * std::pow(32, -(0.2 - 0.03)))));
  CHECK(!control.accepted());
  CHECK(control.next_step(1, 1e-9) == 1);  // no growth right after a rejection
  CHECK(control.next_step(1, std::nan("")) == Approx(0.2));
  CHECK(!control.accepted());
}

struct Stepping {
  RigidModel<double> model;
  std::unique_ptr<Stepper<double>> stepper;
  std::vector<double> y, y_new;

  Stepping(const std::string& scheme, const Scene& scene)
      : model(scene), y(static_cast<std::size_t>(model.state_size())), y_new(y.size()) {
    stepper = stepper_of(scheme, model);
    model.initial_state(y.data());
  }
  std::int64_t evaluations_of_step(double t_s, double h_s) {
    const std::int64_t before = model.system().evaluations;
    REQUIRE(stepper->step(t_s, h_s, y.data(), y_new.data()));
    return model.system().evaluations - before;
  }
};

TEST_CASE("a step taken again knows its first rate; an edited state or another law does not") {
  for (const std::string& scheme : pairs()) {
    INFO(scheme);
    Stepping s(scheme, kepler(0.6));
    const auto full = s.evaluations_of_step(0, 0.1);
    CHECK(s.evaluations_of_step(0, 0.05) == full - 1);
    const std::vector<double> again = s.y_new;
    Stepping fresh(scheme, kepler(0.6));
    fresh.evaluations_of_step(0, 0.05);
    CHECK(fresh.y_new == again);

    s.y.swap(s.y_new);
    s.y[3] += 0.01;  // a kick from outside
    CHECK(s.evaluations_of_step(0.05, 0.05) == full);
    Stepping kicked(scheme, kepler(0.6));
    kicked.y = s.y;
    kicked.evaluations_of_step(0.05, 0.05);
    CHECK(kicked.y_new == s.y_new);

    ++s.model.system().epoch;
    CHECK(s.evaluations_of_step(0.05, 0.05) == full);
  }
}

TEST_CASE("dop853's three further stages are evaluated when its interpolant is asked for, once a step") {
  Stepping s("dop853", kepler(0.6));
  s.evaluations_of_step(0, 0.1);
  const std::int64_t before = s.model.system().evaluations;
  std::vector<double> inside(s.y.size());
  for (const double theta : {0.2, 0.7}) s.stepper->dense(theta, inside.data());
  CHECK(s.model.system().evaluations == before + 3);
  CHECK(s.evaluations_of_step(0, 0.05) == 12);  // the shared last one of 13 included, the known first one not
  s.stepper->dense(0.5, inside.data());
  CHECK(s.model.system().evaluations == before + 3 + 12 + 3);
}

// dopri5, tsit5, dop853 and bogacki-shampine3 by their interpolants, the others by shorter steps.
TEST_CASE("samples inside steps are as good as the steps") {
  std::vector<Sample> samples;
  const auto truth = run("verner9", kepler(0.6), {10, 5000, 50}, "quad").samples;
  for (const std::string& scheme : pairs()) {
    INFO(scheme);
    REQUIRE(adaptive(scheme, kepler(0.6), {10, 1000, 50}, 1e-8, {}, samples).status == Status::ok);
    REQUIRE(samples.size() == 51);
    double worst = 0;
    for (std::size_t k = 0; k < samples.size(); ++k)
      worst = std::max(worst, distance(samples[k].bodies[0].p_m, truth[k].bodies[0].p_m));
    INFO("worst " << worst << ", at the end " << end_error(samples, truth.back()));
    CHECK(worst < 30 * end_error(samples, truth.back()));
  }
}

}  // namespace
}  // namespace atwood::testing
