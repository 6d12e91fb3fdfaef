// What `measure` makes of whole recordings: rows, statuses, conservation by the reference's formulas, timing.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>
#include <set>

#include "validation/metrics/metrics.hpp"

using namespace atwood;

namespace {

const Row* find(const std::vector<Row>& rows, const std::string& metric) {
  const auto found = std::find_if(rows.begin(), rows.end(), [&](const Row& r) { return r.metric == metric; });
  return found == rows.end() ? nullptr : &*found;
}
double value_of(const std::vector<Row>& rows, const std::string& metric) {
  const Row* row = find(rows, metric);
  REQUIRE(row != nullptr);
  return row->value;
}

// A circular orbit about mu = 1 at radius 1, exact in double; a second body at rest far from it is fixed.
Scenario circle() {
  Scenario s;
  s.id = "circle";
  s.t_end_s = 6;
  s.samples = 120;
  s.steps = {1200};
  s.scene.materials = {{"all", 0, 0, 0}};
  s.scene.pairs = {{0, 0, 0, 0, 0}};
  Body moon, rock;
  moon.name = "moon";
  moon.mass_kg = 2;
  moon.position_m = {1, 0, 0};
  moon.velocity_m_per_s = {0, 1, 0};
  rock.name = "rock";
  rock.fixed = true;
  rock.position_m = {9, 9, 9};
  s.scene.bodies = {moon, rock};
  s.scene.forces = {Attractor{{0}, {0, 0, 0}, 1.0}};
  s.invariants = {{"energy"}, {"angular-momentum"}, {"laplace-runge-lenz"}};
  return s;
}

// Radius r, speed v, at the angle of time t.
Recording orbit(const Scenario& s, double r, double v, double lag = 0) {
  Recording run;
  for (int k = 0; k <= s.samples; ++k) {
    Sample sample;
    sample.t_s = Wide(s.t_end_s) * k / Wide(s.samples);
    const double a = static_cast<double>(sample.t_s) * (1 - lag);
    sample.bodies.resize(2);
    sample.bodies[0].p_m = {r * std::cos(a), r * std::sin(a), 0};
    sample.bodies[0].v_m_per_s = {-v * std::sin(a), v * std::cos(a), 0};
    sample.bodies[1].p_m = {9, 9, 9};
    run.values.push_back(sample);
  }
  run.outcome.rate_evaluations = 480;
  return run;
}

Truth truth_of(const Recording& run, double bar = 1e-15) {
  Truth truth;
  truth.values = run.values;
  truth.bars = run.values;
  for (const SampleReference s : truth.bars)
    for (BodySample& b : s.bodies) b = BodySample{{bar, bar, bar}, {0, 0, 0, 0}, {bar, bar, bar}, {0, 0, 0}};
  return truth;
}

}  // namespace

TEST_CASE("measure: a lag in phase is an error in position and conserves everything") {
  const Scenario s = circle();
  const Truth truth = truth_of(orbit(s, 1, 1));
  const std::vector<Row> rows = measure(s, truth, orbit(s, 1, 1, 1e-3));
  const double end = 2 * std::sin(6e-3 / 2);
  CHECK(value_of(rows, "error-position-end") == Approx(end));
  CHECK(value_of(rows, "error-position-max") == Approx(end));
  CHECK(value_of(rows, "error-velocity-end") == Approx(end));
  CHECK(value_of(rows, "error-state-end") == Approx(end));  // sqrt(end^2 + end^2) / sqrt(1 + 1)
  CHECK(find(rows, "error-state-end")->truth_bar == Approx(std::sqrt(3.0) * 1e-15));
  // The mean of t^2 over k/120, k = 1..120, is T^2 (1/3 + 1/240 + ...).
  CHECK(value_of(rows, "error-position-rms") ==
        Approx(6e-3 * std::sqrt(121.0 * 241 / (6.0 * 120 * 120))).epsilon(1e-5));
  CHECK(find(rows, "error-position-end")->truth_bar == Approx(std::sqrt(3.0) * 1e-15));
  CHECK(find(rows, "error-attitude-end") == nullptr);
  CHECK(value_of(rows, "energy-max") < 1e-14);
  CHECK(value_of(rows, "angular-momentum-error-relative") < 1e-14);
  CHECK(value_of(rows, "laplace-runge-lenz-error") < 1e-14);
  CHECK(value_of(rows, "rate-evaluations") == 480);
  CHECK(value_of(rows, "size-position") == Approx(1));
  CHECK(find(rows, "growth-exponent-position")->reason == "t");
  CHECK(find(rows, "momentum-error") == nullptr);  // not declared
}

TEST_CASE("measure: a quaternion that is not of norm 1 is a row of its own, the attitude's angle does not show it") {
  Scenario s = circle();
  s.scene.bodies[0].inertia_kg_m2 = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  const Truth truth = truth_of(orbit(s, 1, 1));
  Recording run = orbit(s, 1, 1);
  run.values[7].bodies[0].q_wxyz = {0.99 * 0.6, 0, 0.99 * 0.8, 0};    // 0.01 short
  run.values[9].bodies[0].q_wxyz = {0, 1.25 * 0.28, 0, 1.25 * 0.96};  // 0.25 long
  run.values[9].bodies[1].q_wxyz = {9, 0, 0, 0};                      // of a fixed body: not measured
  const std::vector<Row> rows = measure(s, truth, run);
  CHECK(value_of(rows, "quaternion-norm-drift") == Approx(0.25));
  CHECK(find(rows, "quaternion-norm-drift")->unit == "1");
  run = orbit(s, 1, 1);
  for (const SampleReference sample : run.values) sample.bodies[0].q_wxyz[0] *= Wide(1.02);
  CHECK(value_of(measure(s, truth, run), "error-attitude-max") == 0);
  CHECK(value_of(measure(s, truth, run), "quaternion-norm-drift") == Approx(0.02));
  for (const SampleReference sample : run.values)
    sample.bodies[0].q_wxyz = {Wide(1) - Wide(5e-7), 0, 0, 0};  // as float leaves it
  CHECK(find(measure(s, truth, run), "quaternion-norm-drift") == nullptr);
}

TEST_CASE("measure: the bar of a largest error encloses what every sample's bar allows") {
  const Scenario s = circle();
  Truth truth = truth_of(orbit(s, 1, 1), 0);
  Recording run = orbit(s, 1, 1);
  const auto off = [&](std::size_t k, double error, double bar) {
    run.values[k].bodies[0].p_m[2] += Wide(error);
    truth.bars[k].bodies[0].p_m[2] = Wide(bar);
  };
  off(20, 0.05, 0.0001);  // the worst sample, well known
  off(60, 0.03, 0.04);    // a smaller error of which less is known: up to 0.07
  const std::vector<Row> rows = measure(s, truth, run);
  const Row& largest = *find(rows, "error-position-max");
  CHECK(largest.value == Approx(0.05).epsilon(1e-12));
  CHECK(largest.value + largest.truth_bar >= 0.07 * (1 - 1e-12));  // max (e + b)
  CHECK(largest.value - largest.truth_bar <= 0.0499);              // max (e - b)
  CHECK(largest.truth_bar == Approx(0.02));
  // The worst sample's own bar where it is the widest, without loss beside a large value.
  off(20, 0, 1e-34);
  truth.bars[60].bodies[0].p_m[2] = 0;
  CHECK(find(measure(s, truth, run), "error-position-max")->truth_bar == Approx(1e-34));
}

TEST_CASE("measure: velocities on the instant of an impact are left out of maxima and means, and counted") {
  const Scenario s = circle();
  Truth truth = truth_of(orbit(s, 1, 1), 0);
  Recording run = orbit(s, 1, 1);
  Event impact;
  impact.t_s = truth.values[30].t_s + Wide(1e-12);
  truth.events = {impact};
  truth.event_bar_s = {2e-12};
  for (Wide& v : run.values[30].bodies[0].v_m_per_s) v = -v;
  run.values[31].bodies[0].v_m_per_s[2] += Wide(1e-3);
  const std::vector<Row> rows = measure(s, truth, run);
  CHECK(value_of(rows, "error-velocity-max") == Approx(1e-3));
  CHECK(value_of(rows, "error-velocity-rms") == Approx(1e-3 / std::sqrt(119.0)));
  CHECK(find(rows, "error-velocity-max")->reason == "1 samples on the instant of an impact left out");
  CHECK(find(rows, "error-position-max")->reason.empty());
  truth.event_bar_s = {0.5e-12};  // the sample lies outside the bar: the jump is an error
  CHECK(value_of(measure(s, truth, run), "error-velocity-max") > 1);
}

TEST_CASE("measure: the whole state's relative error joins positions and velocities of the last sample in one norm") {
  const Scenario s = circle();
  Recording run = orbit(s, 1, 1);
  run.values[5].bodies[0].p_m[0] += Wide(1);
  run.values.back().bodies[0].p_m[2] += Wide(3e-6);
  run.values.back().bodies[0].v_m_per_s[1] += Wide(4e-6);
  const std::vector<Row> rows = measure(s, truth_of(orbit(s, 1, 1)), run);
  CHECK(value_of(rows, "error-state-end") == Approx(5e-6 / std::sqrt(2.0)).epsilon(1e-9));
}

TEST_CASE("measure: t = 0 is left out of every figure") {
  const Scenario s = circle();
  Recording run = orbit(s, 1, 1);
  run.values.front().bodies[0].p_m[2] = Wide(7);
  const std::vector<Row> rows = measure(s, truth_of(orbit(s, 1, 1)), run);
  CHECK(value_of(rows, "error-position-max") == 0);
  CHECK(value_of(rows, "error-position-rms") == 0);
}

TEST_CASE("measure: energy kept by rescaling still moves the orbit's vector and its angular momentum") {
  const Scenario s = circle();
  const Truth truth = truth_of(orbit(s, 1, 1));
  Recording run = orbit(s, 1, 1);
  // Radius grows, speed is rescaled so that v^2/2 - 1/r = -1/2 holds exactly.
  for (const SampleReference sample : run.values) {
    const double grow = 1 + 1e-3 * static_cast<double>(sample.t_s) / 6, v = std::sqrt(2 / grow - 1);
    for (Wide& x : sample.bodies[0].p_m) x *= grow;
    for (Wide& x : sample.bodies[0].v_m_per_s) x *= v;
  }
  const std::vector<Row> rows = measure(s, truth, run);
  CHECK(value_of(rows, "energy-max") < 1e-14);
  CHECK(value_of(rows, "laplace-runge-lenz-error") == Approx(1e-3).epsilon(0.1));
  CHECK(value_of(rows, "error-position-end") == Approx(1e-3).epsilon(1e-6));
}

TEST_CASE("measure: energy drift and scale by hand") {
  const Scenario s = circle();
  Recording run = orbit(s, 1, 1);
  for (const SampleReference sample : run.values)  // v^2 grows as 1 + 2e-4 t: E - E0 = m 1e-4 t
    for (Wide& x : sample.bodies[0].v_m_per_s) x *= std::sqrt(1 + 2e-4 * static_cast<double>(sample.t_s));
  const std::vector<Row> rows = measure(s, truth_of(orbit(s, 1, 1)), run);
  const double scale = 1;  // the truth's kinetic energy, m = 2; its potential does not change
  CHECK(value_of(rows, "energy-drift") == Approx(2e-4 / scale).epsilon(1e-6));
  CHECK(value_of(rows, "energy-max") == Approx(2e-4 * 6 / scale).epsilon(1e-6));
  CHECK(value_of(rows, "energy-oscillation") < 1e-10);
}

TEST_CASE(
    "measure: one energy scale a scene, the truth's: a run that blows up errs by more than 1, a worse one drifts "
    "more") {
  const Scenario s = circle();
  const Truth truth = truth_of(orbit(s, 1, 1));
  const auto blown = [&](double rate) {
    Recording run = orbit(s, 1, 1);
    for (const SampleReference sample : run.values)
      for (Wide& x : sample.bodies[0].v_m_per_s) x *= std::exp(rate * static_cast<double>(sample.t_s));
    return measure(s, truth, run);
  };
  const auto bad = blown(1), worse = blown(2);
  CHECK(value_of(bad, "energy-max") == Approx(std::exp(12.0) - 1));
  CHECK(value_of(worse, "energy-max") == Approx(std::exp(24.0) - 1));
  CHECK(value_of(worse, "energy-drift") > value_of(bad, "energy-drift"));
  CHECK_THAT(find(bad, "energy-drift")->reason, Catch::StartsWith("gains energy in each eighth of the run"));
  CHECK(value_of(bad, "energy-scale") == Approx(1));
  CHECK(find(bad, "energy-scale")->unit == "J");
  CHECK(find(bad, "energy-scale")->reason == "the truth's samples");
  CHECK(error_series(s, truth, orbit(s, 1, 1)).energy.size() == 121);
}

TEST_CASE("measure: without a truth the scale is a converged reference run's, else energies are in joules") {
  Scenario s = circle();
  Recording run = orbit(s, 1, 1);
  run.values.back().bodies[0].v_m_per_s[2] = Wide(0.1);  // E - E0 = 2 / 2 0.01 J
  const std::vector<Row> rows = measure(s, {}, run);
  CHECK(value_of(rows, "energy-scale") == Approx(1).epsilon(1e-6));
  CHECK(find(rows, "energy-scale")->reason == "reference run: classical RK4, 2048 steps, energy converged to 1e-3");
  CHECK(value_of(rows, "energy-max") == Approx(0.01));
  // Scaled up, what is relative stays and what is in joules grows: bodies that can touch have no such run.
  s.scene.bodies[0].shape = Sphere{0.1};
  s.scene.bodies[0].mass_kg = 200;
  s.scene.bodies[1].shape = Sphere{0.1};
  const std::vector<Row> joules = measure(s, {}, run);
  CHECK(find(joules, "energy-max") == nullptr);
  CHECK(find(joules, "energy-scale") == nullptr);
  CHECK(value_of(joules, "energy-change-max") == Approx(1));
  CHECK(find(joules, "energy-change-max")->unit == "J");
}

TEST_CASE("measure: the energy scale does not depend on where the truth's samples fall") {
  // x'' = -(2 pi)^2 x from rest at 1 m: 2 T - T0 = 4 pi^2 J in the middle, and nothing to see after whole periods.
  Scenario s = circle();
  s.id = "spring";
  s.t_end_s = 3;
  s.scene.bodies.pop_back();
  s.scene.bodies[0].mass_kg = 1;
  s.scene.bodies[0].velocity_m_per_s = {0, 0, 0};
  Spring spring;
  spring.bodies = {0};
  spring.stiffness_N_per_m = 4 * M_PI * M_PI;
  s.scene.forces = {spring};
  s.invariants = {{"energy"}};
  const auto swing = [&](std::int64_t samples) {
    Recording run;
    for (std::int64_t k = 0; k <= samples; ++k) {
      Sample sample;
      sample.t_s = Wide(s.t_end_s) * k / Wide(samples);
      sample.bodies.resize(1);
      sample.bodies[0].p_m[0] = std::cos(2 * M_PI * static_cast<double>(sample.t_s));
      sample.bodies[0].v_m_per_s[0] = -2 * M_PI * std::sin(2 * M_PI * static_cast<double>(sample.t_s));
      run.values.push_back(sample);
    }
    return run;
  };
  const double scale = 4 * M_PI * M_PI;
  for (const std::int64_t samples : {1, 3, 6, 120}) {
    s.samples = samples;
    Recording run = swing(samples);
    run.values.back().bodies[0].p_m[0] *= 1.01;
    const std::vector<Row> rows = measure(s, truth_of(swing(samples)), run);
    CAPTURE(samples);
    CHECK(value_of(rows, "energy-scale") == Approx(scale).epsilon(1e-3));
    CHECK(value_of(rows, "energy-max") == Approx(0.5 * 0.0201).epsilon(1e-3));
    if (samples < 120)
      CHECK(find(rows, "energy-scale")->reason ==
            "reference run: classical RK4, 2048 steps, energy converged to 1e-3, "
            "above all " +
                std::to_string(samples + 1) + " samples of the truth");
    else CHECK(find(rows, "energy-scale")->reason == "the truth's samples");
  }
  // 256 periods, four of the reference run's intervals each.
  s.t_end_s = 256;
  s.samples = 64;
  CHECK(value_of(measure(s, {}, swing(64)), "energy-scale") == Approx(scale).epsilon(1e-2));
  // Bodies that can touch have no reference run.
  s.t_end_s = 3;
  s.scene.bodies.push_back(s.scene.bodies[0]);
  s.scene.bodies[1].position_m = {9, 9, 9};
  s.scene.bodies[1].fixed = true;
  for (Body& body : s.scene.bodies) body.shape = Sphere{0.1};
  const auto both = [](Recording run) {
    Recording two;
    for (const SampleView one : run.values) {
      Sample sample;
      sample.t_s = one.t_s;
      sample.bodies = {one.bodies[0], {}};
      sample.bodies[1].p_m = {9, 9, 9};
      two.values.push_back(sample);
    }
    return two;
  };
  s.samples = 3;
  const std::vector<Row> unseen = measure(s, truth_of(both(swing(3))), both(swing(3)));
  CHECK(find(unseen, "energy-scale") == nullptr);
  REQUIRE(find(unseen, "energy-change-max") != nullptr);
  CHECK_THAT(find(unseen, "energy-change-max")->reason, Catch::StartsWith("in joules: the truth's samples show no"));
  s.samples = 5;
  const std::vector<Row> seen = measure(s, truth_of(both(swing(5))), both(swing(5)));
  REQUIRE(find(seen, "energy-scale") != nullptr);
  CHECK(find(seen, "energy-scale")->reason == "the truth's 6 samples; between them it may be larger");
}

TEST_CASE("measure: an energy drift needs five samples, and ten to be stationary about a line") {
  Scenario s = circle();
  const auto drift = [&](std::int64_t samples) {
    s.samples = samples;
    Recording run = orbit(s, 1, 1);
    for (const SampleReference sample : run.values)
      for (Wide& x : sample.bodies[0].v_m_per_s) x *= std::sqrt(1 + 2e-4 * static_cast<double>(sample.t_s));
    const std::vector<Row> rows = measure(s, truth_of(orbit(s, 1, 1)), run);
    REQUIRE(find(rows, "energy-drift") != nullptr);
    return *find(rows, "energy-drift");
  };
  CHECK(std::isnan(drift(3).value));
  CHECK(drift(3).reason == "inconclusive: no interval follows from 4 samples; a drift needs 5");
  CHECK(drift(4).value == Approx(2e-4).epsilon(1e-6));
  CHECK(drift(4).reason ==
        "gains energy; 5 samples are too few to show that it is stationary about a line: the mean "
        "slope, and its bar from the slopes of its 4 parts");
  CHECK(drift(9).reason == "gains energy");
}

TEST_CASE(
    "measure: at round-off one run has no drift and no law; above it a slope that changes has a bar from its parts") {
  const Scenario s = circle();
  const Truth truth = truth_of(orbit(s, 1, 1));
  Recording run = orbit(s, 1, 1);
  run.outcome.steps_taken = 1200;
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal(0, 1);
  double walk = 0;
  for (const SampleReference sample : run.values) {
    for (Wide& x : sample.bodies[0].v_m_per_s) x = static_cast<double>(x * Wide(1 + walk));
    walk += 2e-16 * normal(random);
  }
  const std::vector<Row> floor = measure(s, truth, run);
  for (const char* metric : {"energy-drift", "growth-exponent-energy"}) {
    CHECK(std::isnan(value_of(floor, metric)));
    CHECK(find(floor, metric)->reason.starts_with("inconclusive: round-off: "));
  }
  Recording bent = orbit(s, 1, 1);
  for (const SampleReference sample : bent.values)
    for (Wide& x : sample.bodies[0].v_m_per_s) x *= 1 + 1e-5 * sample.t_s * sample.t_s;
  const std::vector<Row> rows = measure(s, truth, bent);
  const Row& drift = *find(rows, "energy-drift");
  CHECK(drift.value == Approx(1.2e-4).epsilon(0.05));  // 2e-5 t^2 over 6 s
  // Slopes of the eight parts from 0.15e-4 to 2.25e-4: a standard deviation of 0.73e-4, times 1.25 t(7) / sqrt(8).
  CHECK(drift.truth_bar == Approx(0.77e-4).epsilon(0.02));
  CHECK(drift.reason.starts_with("gains energy in each eighth of the run; not stationary"));
}

TEST_CASE("measure: gravity's impulse is accounted for, a lost push is not") {
  Scenario s = circle();
  s.scene.forces.clear();
  s.scene.gravity_m_per_s2 = {0, 0, -10};
  s.invariants = {{"momentum"}, {"center-of-mass"}};
  Recording run;
  for (int k = 0; k <= s.samples; ++k) {
    Sample sample;
    sample.t_s = Wide(s.t_end_s) * k / Wide(s.samples);
    sample.bodies.resize(2);
    const Wide t = sample.t_s;
    sample.bodies[0].p_m = {1, t, -5 * t * t};
    sample.bodies[0].v_m_per_s = {0, 1, -10 * t};
    run.values.push_back(sample);
  }
  const Truth truth = truth_of(run);
  CHECK(value_of(measure(s, truth, run), "momentum-error") < 1e-15);
  CHECK(value_of(measure(s, truth, run), "center-of-mass-error") < 1e-15);
  run.values.back().bodies[0].v_m_per_s[0] += Wide(0.25);
  CHECK(value_of(measure(s, truth, run), "momentum-error") == Approx(0.5));
}

TEST_CASE("measure: one status row when a run did not end well") {
  const Scenario s = circle();
  const Truth truth = truth_of(orbit(s, 1, 1));
  const auto status_of = [&](const Recording& run) {
    const std::vector<Row> rows = measure(s, truth, run);
    REQUIRE(rows.size() == 1);
    CHECK(rows[0].metric == "status");
    CHECK_FALSE(rows[0].reason.empty());
    return rows[0].status;
  };
  Recording late_nan = orbit(s, 1, 1);
  late_nan.values[118].bodies[0].v_m_per_s[1] = std::numeric_limits<double>::quiet_NaN();
  CHECK(status_of(late_nan) == Status::not_finite);
  Recording infinite = orbit(s, 1, 1);
  infinite.values.back().bodies[0].p_m[1] = std::numeric_limits<double>::infinity();
  CHECK(status_of(infinite) == Status::not_finite);
  Recording refused;
  refused.outcome = {Status::unsupported, "no attractor", 0, 0, {}};
  CHECK(status_of(refused) == Status::unsupported);
  Recording early = orbit(s, 1, 1);
  early.values.truncate(50);
  CHECK(status_of(early) == Status::crashed);
  Recording shifted = orbit(s, 1, 1);
  for (const SampleReference sample : shifted.values) sample.t_s += Wide(0.02);
  CHECK(status_of(shifted) == Status::crashed);
  CHECK(error_series(s, truth, late_nan).t_s.empty());
}

TEST_CASE("measure: the condition of a circular orbit is the along-track shear of Kepler's third law") {
  const Scenario s = circle();
  const std::vector<Row> rows = measure(s, truth_of(orbit(s, 1, 1)), orbit(s, 1, 1));
  // dv/v = d changes a by 2 d, the phase by 3 d t = 18 d at t = 6; dr/r adds as much again.
  CHECK(value_of(rows, "condition") > 5);
  CHECK(value_of(rows, "condition") < 50);
}

// 955 periods: 1000 steps of the ladder are about one a period, and no run of so few follows the motion.
TEST_CASE(
    "measure: the condition does not depend on how coarse the ladder is; what was not followed is a lower bound") {
  Scenario s = circle();
  s.t_end_s = 6000;
  s.steps = {1000};
  const Recording run = orbit(s, 1, 1);
  const std::vector<Row> rows = measure(s, truth_of(run), run);
  CHECK(value_of(rows, "condition") > 1.8e4);
  CHECK(value_of(rows, "condition") < 5e4);
  CHECK(accuracy_floor("error-position-end", rows) == 0x1p-53 * value_of(rows, "condition"));
  // A truth of another motion is followed by no run.
  const Recording other = orbit(s, 1, 1, 0.1);
  const std::vector<Row> bound = measure(s, truth_of(other), other);
  CHECK(value_of(bound, "condition") == Approx(6001));
  CHECK(std::isnan(accuracy_floor("error-position-end", bound)));
}

TEST_CASE("measure: how the solvers of a run ended, each by its name and all together, also of a run that diverged") {
  const Scenario s = circle();
  Recording run = orbit(s, 1, 1);
  const auto of = [](const std::vector<Row>& rows, const std::string& metric, const std::string& body) {
    for (const Row& r : rows)
      if (r.metric == metric && r.body == body) return r;
    FAIL("no row " << metric << " of `" << body << "`");
    return Row{};
  };
  for (const Row& r : measure(s, truth_of(run), run)) CHECK_FALSE(r.metric.starts_with("solver-"));
  run.outcome.solvers["implicit-stages"] = {90, 8, 2, 80, 1e-3};
  run.outcome.solvers["own-solver"] = {10, 0, 1, 7, 1e-4};
  const auto check = [&](const std::vector<Row>& rows) {
    CHECK(of(rows, "solver-converged", "implicit-stages").value == 90);
    CHECK(of(rows, "solver-stagnated", "implicit-stages").value == 8);
    CHECK(of(rows, "solver-capped", "implicit-stages").value == 2);
    CHECK(of(rows, "solver-iterations-max", "own-solver").value == 7);
    CHECK(of(rows, "solver-residual-max", "own-solver").value == 1e-4);
    CHECK(of(rows, "solver-residual-max", "own-solver").reason == "scaled by the engine; see its documentation");
    CHECK(of(rows, "solver-capped", "").value == 3);
    CHECK(of(rows, "solver-residual-max", "").value == 1e-3);
    CHECK(of(rows, "solver-residual-max", "").reason.find("implicit-stages: estimated remaining change") !=
          std::string::npos);
  };
  check(measure(s, truth_of(run), run));
  run.outcome.status = Status::diverged;
  check(measure(s, truth_of(run), run));
  CHECK(of(measure(s, truth_of(run), run), "status", "").status == Status::diverged);
  run.outcome.solvers["own-solver"].residual_max = std::nan("");
  CHECK(std::isnan(of(measure(s, truth_of(run), run), "solver-residual-max", "").value));
}

TEST_CASE("measure: every metric is defined once, with words") {
  std::set<std::string> names;
  for (const MetricInfo& m : all_metrics()) {
    CHECK(names.insert(m.name).second);
    CHECK(m.definition.size() > 20);
  }
}

TEST_CASE("measure: the definitions of the solvers' metrics are short") {
  int found = 0;
  for (const MetricInfo& m : all_metrics()) {
    if (!m.name.starts_with("solver-")) continue;
    ++found;
    INFO(m.name);
    CHECK(m.definition.size() < 260);
    CHECK(m.definition.find("`body`") != std::string::npos);
  }
  CHECK(found == 5);
}

TEST_CASE(
    "timing: one median for a step and for the run, its interval as a bar, a 95th percentile from 20 repeats on") {
  Outcome outcome;
  CHECK(timing_rows(outcome, 100).empty());
  outcome.busy_ns = {5000, 1000, 3000, 2000, 100000};
  const std::vector<Row> five = timing_rows(outcome, 100);
  CHECK(value_of(five, "step-time") == Approx(30e-9));
  CHECK(find(five, "step-time")->truth_bar == Approx(970e-9));  // the range: 10 to 1000 ns
  CHECK(value_of(five, "run-time") == Approx(3000e-9));
  CHECK(find(five, "run-time")->truth_bar == Approx(97000e-9));
  CHECK(find(five, "step-time-p95") == nullptr);
  outcome.busy_ns = {1000, 3000};
  CHECK(value_of(timing_rows(outcome, 10), "step-time") == Approx(200e-9));
  CHECK(value_of(timing_rows(outcome, 10), "run-time") == Approx(2000e-9));  // the same median
  outcome.busy_ns = {1000};
  CHECK(value_of(timing_rows(outcome, 10), "step-time") == Approx(100e-9));
  CHECK(std::isnan(find(timing_rows(outcome, 10), "step-time")->truth_bar));  // one repeat has no interval
  CHECK(find(timing_rows(outcome, 10), "call-time-wasm") == nullptr);
}

TEST_CASE("timing: of twenty repeats the 6th and the 15th enclose the median, and the 19th is the 95th percentile") {
  Outcome outcome;
  for (int i = 19; i > 0; --i) outcome.busy_ns.push_back(100 * i);
  CHECK(find(timing_rows(outcome, 1), "step-time-p95") == nullptr);
  outcome.busy_ns.push_back(2000);
  const std::vector<Row> rows = timing_rows(outcome, 1);
  CHECK(value_of(rows, "step-time") == Approx(1050e-9));
  CHECK(find(rows, "step-time")->truth_bar == Approx(450e-9));  // P(Binomial(20, 1/2) <= 5) = 0.0207
  CHECK(value_of(rows, "step-time-p95") == Approx(1900e-9));
}

TEST_CASE("timing: an engine that runs as WebAssembly has rows of its own") {
  Outcome outcome;
  outcome.busy_ns = {5000, 1000, 3000};
  outcome.call_ns = 70;
  const std::vector<Row> rows = timing_rows(outcome, 10);
  CHECK(rows.size() == 3);
  CHECK(value_of(rows, "step-time-wasm") == Approx(300e-9));
  CHECK(value_of(rows, "run-time-wasm") == Approx(3000e-9));
  CHECK(value_of(rows, "call-time-wasm") == Approx(70e-9));
  CHECK(find(rows, "step-time") == nullptr);
  CHECK(find(rows, "run-time") == nullptr);
}
