// Contact metrics on a bouncing ball written out by hand, and on the landing of a thrown one.
#include <catch2/catch.hpp>
#include <cmath>

#include "rows.hpp"
#include "validation/metrics/metrics.hpp"

using namespace atwood;
using atwood::testing::value_of;

namespace {

constexpr double kG = 9.8, kRadius = 0.25, kE = 0.5;

Scenario bounce() {
  Scenario s;
  s.id = "ball";
  s.t_end_s = 2;
  s.samples = 400;
  s.scene.gravity_m_per_s2 = {0, 0, -kG};
  s.scene.materials = {{"all", kE, 0, 0}};
  s.scene.pairs = {{0, 0, kE, 0, 0}};
  Body floor;
  floor.name = "floor";
  floor.fixed = true;
  floor.shape = Plane{};
  Body ball;
  ball.name = "ball";
  ball.mass_kg = 2;
  ball.shape = Sphere{kRadius};
  ball.position_m = {0, 0, kRadius + 1};
  s.scene.bodies = {floor, ball};
  return s;
}

// The ball of clearance 1 with restitution e, late by `late` seconds from the first impact on.
Recording motion(const Scenario& s, double e, double late = 0) {
  Recording run;
  std::vector<double> start{0};  // of each flight, and its speed up
  std::vector<double> speed{0};
  const double fall = std::sqrt(2 / kG);
  double t = fall + late, v = kG * fall;
  while (t < s.t_end_s && v * v > 2 * kG * 1e-9) {
    Event event;
    event.t_s = t;
    event.body_a = 0;
    event.body_b = 1;
    event.normal = {0, 0, 1};
    event.vn_before_m_per_s = -v;
    event.vn_after_m_per_s = e * v;
    event.impulse_n_N_s = 2 * (1 + e) * v;
    run.events.push_back(event);
    v *= e;
    start.push_back(t);
    speed.push_back(v);
    t += 2 * v / kG;
  }
  for (int k = 0; k <= s.samples; ++k) {
    Sample sample;
    sample.t_s = Wide(s.t_end_s) * k / Wide(s.samples);
    const double now = static_cast<double>(sample.t_s);
    std::size_t flight = 0;
    while (flight + 1 < start.size() && start[flight + 1] <= now) ++flight;
    const double dt = now - start[flight];
    const double height = flight == 0 ? 1 - kG * dt * dt / 2 : std::max(0.0, speed[flight] * dt - kG * dt * dt / 2);
    sample.bodies.resize(2);
    sample.bodies[1].p_m = {0, 0, Wide(kRadius) + Wide(height)};
    run.values.push_back(sample);
  }
  return run;
}

Truth truth_of(const Recording& run) {
  Truth truth;
  truth.source = "by hand";
  truth.values = run.values;
  truth.bars = run.values;
  for (const SampleReference b : truth.bars)
    for (BodySample& q : b.bodies) q = {{}, {0, 0, 0, 0}, {}, {}};
  truth.events = run.events;
  truth.event_bar_s.assign(run.events.size(), 1e-15);
  return truth;
}

}  // namespace

TEST_CASE("bounce: the truth compared with itself has no error, and its figures are those derived by hand") {
  const Scenario s = bounce();
  const Recording run = motion(s, kE);
  const std::vector<Row> rows = measure(s, truth_of(run), run);
  CHECK(value_of(rows, "impact-time-error") == 0);
  CHECK(value_of(rows, "impact-count-error") == 0);
  CHECK(value_of(rows, "apex-error") == 0);
  CHECK(value_of(rows, "restitution-error") < 1e-15);
  CHECK(value_of(rows, "penetration-max") == 0);
  // The gentlest of the impacts loses least: the work is negative for all.
  CHECK(value_of(rows, "contact-energy-gain") < 0);
}

TEST_CASE("bounce: restitution applied twice shows in apexes, impact times and realised restitution") {
  const Scenario s = bounce();
  const Truth truth = truth_of(motion(s, kE));
  const std::vector<Row> rows = measure(s, truth, motion(s, kE * kE));
  CHECK(value_of(rows, "restitution-error") == Approx(kE - kE * kE));
  // First apex e^4 instead of e^2; the later flights are not even in step.
  CHECK(value_of(rows, "apex-error") >= 1 - kE * kE - 1e-9);
  CHECK((std::isnan(value_of(rows, "impact-time-error")) || value_of(rows, "impact-time-error") > 0.1));
}

TEST_CASE("bounce: lateness is the impact time's error and not the apex's") {
  const Scenario s = bounce();
  const Truth truth = truth_of(motion(s, kE));
  const std::vector<Row> rows = measure(s, truth, motion(s, kE, 1e-3));
  CHECK(value_of(rows, "impact-time-error") == Approx(1e-3));
  CHECK(value_of(rows, "apex-error") < 1e-9);
}

TEST_CASE("bounce: missing impacts are NaN, never a small maximum; engines without events have no such row") {
  const Scenario s = bounce();
  const Truth truth = truth_of(motion(s, kE));
  Recording run = motion(s, kE);
  run.events.resize(2);
  const std::vector<Row> rows = measure(s, truth, run);
  CHECK(std::isnan(value_of(rows, "impact-time-error")));
  CHECK(value_of(rows, "impact-count-error") < 0);
  run.events.clear();
  CHECK(value_of(measure(s, truth, run), "impact-time-error") == -999);
  CHECK(value_of(measure(s, truth, run), "apex-error") == 0);
}

TEST_CASE("bounce: an apex off by a part in 1e-10 is seen as that") {
  const Scenario s = bounce();
  const Truth truth = truth_of(motion(s, kE));
  Recording run = motion(s, kE);
  for (const SampleReference sample : run.values)
    sample.bodies[1].p_m[2] = Wide(kRadius) + (sample.bodies[1].p_m[2] - Wide(kRadius)) * (1 + Wide(1e-10));
  CHECK(value_of(measure(s, truth, run), "apex-error") == Approx(1e-10).epsilon(1e-6));
}

TEST_CASE("bounce: overlap is the deepest of the samples; a contact that gains energy shows it") {
  const Scenario s = bounce();
  const Recording good = motion(s, kE);
  Recording run = good;
  run.values[100].bodies[1].p_m[2] = Wide(kRadius) - Wide(0.01);
  run.events[0].vn_after_m_per_s = -run.events[0].vn_before_m_per_s * Wide(1.5);
  run.events[0].impulse_n_N_s = 2;
  const std::vector<Row> rows = measure(s, truth_of(good), run);
  CHECK(value_of(rows, "penetration-max") == Approx(0.01));
  const double v = static_cast<double>(-run.events[0].vn_before_m_per_s);
  CHECK(value_of(rows, "contact-energy-gain") == Approx(2 * 0.5 * v / 2));
}

TEST_CASE("bounce: energy that comes back after it was lower is a gain, from states alone") {
  const Scenario s = bounce();
  const Recording good = motion(s, kE);
  const auto gain_of = [&](const std::vector<double>& speeds) {
    Recording run = good;
    for (std::size_t k = 0; k < run.values.size(); ++k) {
      run.values[k].bodies[1] = good.values.front().bodies[1];
      run.values[k].bodies[1].v_m_per_s = {Wide(speeds[std::min(k, speeds.size() - 1)]), 0, 0};  // without an event
    }
    return value_of(measure(s, truth_of(good), run), "energy-gain");
  };
  // m (1.5^2 - 1) / 2 over the truth's scale, here m g times the metre fallen: its samples come without velocities.
  CHECK(gain_of({2, 1, 1.5, 1.25}) == Approx((1.5 * 1.5 - 1) / (2 * kG)));
  CHECK(gain_of({2, 1.5, 1, 1}) == 0);
}

TEST_CASE("landing: explicit Euler lands one step late on its own parabola, v_x h far") {
  Scenario s;
  s.id = "ballistic";
  s.t_end_s = 2;
  s.samples = 40;
  s.scene.gravity_m_per_s2 = {0, 0, -kG};
  s.scene.materials = {{"all", 0, 0, 0}};
  s.scene.pairs = {{0, 0, 0, 0, 0}};
  Body ball;
  ball.name = "ball";
  ball.mass_kg = 1;
  s.scene.bodies = {ball};
  Truth truth;
  Recording explicit_euler, symplectic_euler;
  const int steps = 120;
  const double h = s.t_end_s / steps, v0 = 7.5;
  for (int k = 0; k <= s.samples; ++k) {
    Sample sample;
    sample.t_s = Wide(s.t_end_s) * k / Wide(s.samples);
    sample.bodies.resize(1);
    const auto put = [&](SampleSeries& list, Wide late) {  // z_n = v0 t - g t (t - late) / 2
      const Wide t = sample.t_s;
      sample.bodies[0].p_m = {Wide(v0) * t, 0, Wide(v0) * t - Wide(kG) * t * (t - late) / 2};
      list.push_back(sample);
    };
    put(truth.values, 0);
    put(explicit_euler.values, h);
    put(symplectic_euler.values, -h);
  }
  CHECK(value_of(measure(s, truth, explicit_euler), "landing-range-error") == Approx(0.125).epsilon(1e-12));
  CHECK(value_of(measure(s, truth, symplectic_euler), "landing-range-error") == Approx(-0.125).epsilon(1e-12));
}
