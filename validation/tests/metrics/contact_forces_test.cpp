// What contacts carry, on a box that slides over a floor with its forces written out by hand; regimes; overlaps.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "rows.hpp"
#include "validation/metrics/metrics.hpp"

using namespace atwood;
using atwood::testing::value_of;

namespace {

constexpr double kWeight = 20, kMu = 0.5, kSpeed = 3;

// A block of 20 N that slides along +x over a plane at 3 m/s, held by one contact in the middle of its face.
Scenario sliding() {
  Scenario s;
  s.id = "slider";
  s.t_end_s = 1;
  s.samples = 4;
  s.scene.materials = {{"all", 0, kMu, 0}};
  s.scene.pairs = {{0, 0, 0, kMu, 0}};
  Body floor;
  floor.name = "floor";
  floor.fixed = true;
  floor.shape = Plane{};
  Body block;
  block.name = "block";
  block.mass_kg = 2;
  block.shape = Sphere{0.25};
  block.position_m = {0, 0, 0.25};
  s.scene.bodies = {floor, block};
  return s;
}

Recording slide(const Scenario& s) {
  Recording run;
  for (int k = 0; k <= s.samples; ++k) {
    Sample sample;
    sample.t_s = Wide(k) / 4;
    sample.bodies.resize(2);
    sample.bodies[1].p_m = {Wide(kSpeed) * sample.t_s, 0, 0.25};
    sample.bodies[1].v_m_per_s = {kSpeed, 0, 0};
    if (k > 0) sample.contacts = {{0, 1, {kSpeed * k / 4, 0, 0}, {0, 0, 1}, 0, kWeight, {-kMu * kWeight, 0, 0}}};
    run.values.push_back(sample);
  }
  return run;
}

}  // namespace

TEST_CASE("contact forces: a block that slides as Coulomb says has no residual") {
  const std::vector<Row> rows = measure(sliding(), {}, slide(sliding()));
  CHECK(value_of(rows, "cone-violation") == 0);
  CHECK(value_of(rows, "signorini-gap") == 0);
  CHECK(value_of(rows, "signorini-pull") == 0);
  CHECK(value_of(rows, "dissipation-defect") == Approx(0).margin(1e-15));
}

TEST_CASE("contact forces: friction beyond the cone, in the diagonal of a pyramid") {
  Recording run = slide(sliding());
  run.values[2].contacts[0].force_t_N = {-kMu * kWeight, kMu * kWeight, 0};
  CHECK(value_of(measure(sliding(), {}, run), "cone-violation") == Approx(kMu * (std::sqrt(2.0) - 1)));
  Event impact;
  impact.body_b = 1;
  impact.impulse_n_N_s = 4;
  impact.impulse_t_N_s = 3;
  run.events = {impact};
  CHECK(value_of(measure(sliding(), {}, run), "cone-violation") == Approx((3 - kMu * 4) / 4));
}

TEST_CASE("contact forces: of an engine that does not tell friction's part neither cone nor dissipation is judged") {
  Recording run = slide(sliding());
  const double none = std::nan("");
  run.values[2].contacts[0].force_t_N = {none, none, none};
  const std::vector<Row> rows = measure(sliding(), {}, run);
  for (const Row& each : rows) CHECK((each.metric != "cone-violation" && each.metric != "dissipation-defect"));
  CHECK(value_of(rows, "signorini-gap") == 0);
}

TEST_CASE("contact forces: a gap under load and a pull are Signorini's residuals; an unloaded gap is none") {
  Recording run = slide(sliding());
  run.values[1].contacts[0].gap_m = 1e-3;
  std::vector<Sample> samples;
  for (const SampleView sample : run.values) samples.push_back(copy_of(sample));
  samples[3].contacts.push_back({0, 1, {}, {0, 0, 1}, 0.5, 0, {}});
  run.values = samples;
  CHECK(value_of(measure(sliding(), {}, run), "signorini-gap") == 1e-3);
  run.values[3].contacts[1].force_n_N = -2;
  const std::vector<Row> rows = measure(sliding(), {}, run);
  CHECK(value_of(rows, "signorini-pull") == 2);
  CHECK(value_of(rows, "signorini-gap") == 0.5);
}

TEST_CASE("contact forces: friction on the wrong axis, or none, falls short of the greatest dissipation") {
  Recording run = slide(sliding());
  for (const SampleReference sample : run.values)
    for (ContactSample& c : sample.contacts) c.force_t_N = {0, kMu * kWeight, 0};
  CHECK(value_of(measure(sliding(), {}, run), "dissipation-defect") == Approx(1));
  for (const SampleReference sample : run.values)
    for (ContactSample& c : sample.contacts) c.force_t_N = {kMu * kWeight, 0, 0};  // it drives the slip
  CHECK(value_of(measure(sliding(), {}, run), "dissipation-defect") == Approx(2));
}

TEST_CASE("contact forces: slip is the surfaces': a rolling ball has none, body rates are in body axes") {
  Recording run = slide(sliding());
  for (const SampleReference sample : run.values) {
    sample.bodies[1].q_wxyz = {Wide(std::sqrt(0.5)), 0, 0,
                               Wide(std::sqrt(0.5))};  // a quarter turn about z: body x is world y
    sample.bodies[1].w_rad_per_s = {kSpeed / 0.25, 0, 0};
  }
  for (std::size_t k = 1; k < run.values.size(); ++k) run.values[k].contacts[0].force_t_N = {};
  run.values[4].bodies[1].w_rad_per_s = {0, 0, 0};  // slides in the last sample alone, without friction
  CHECK(value_of(measure(sliding(), {}, run), "dissipation-defect") == Approx(1));
  run.values[4].bodies[1].w_rad_per_s = {kSpeed / 0.25, 0, 0};
  CHECK(value_of(measure(sliding(), {}, run), "dissipation-defect") < 1e-9);
}

TEST_CASE("contact forces: the round-off of a body at rest is no slip") {
  Scenario s = sliding();
  s.scene.gravity_m_per_s2 = {0, 0, -10};
  Recording run = slide(s);
  for (const SampleReference sample : run.values) sample.bodies[1].v_m_per_s = {1e-14, 0, 0};
  for (std::size_t k = 1; k < run.values.size(); ++k) run.values[k].contacts[0].force_t_N = {3, 0, 0};
  CHECK(value_of(measure(s, {}, run), "dissipation-defect") == -999);
}

TEST_CASE("overlap: the deepest, its mean square over the samples, and in units of the ball") {
  Recording run = slide(sliding());
  run.values[1].bodies[1].p_m[2] = 0.25 - 0.03;
  run.values[2].bodies[1].p_m[2] = 0.25 - 0.04;
  const std::vector<Row> rows = measure(sliding(), {}, run);
  CHECK(value_of(rows, "penetration-max") == Approx(0.04));
  CHECK(value_of(rows, "penetration-rms") == Approx(0.05 / 2));
  CHECK(value_of(rows, "penetration-relative") == Approx(0.16));
}

TEST_CASE("overlap: in a heap the near pairs are found, and only they") {
  Scenario s = sliding();
  s.samples = 1;
  s.scene.bodies.resize(1);
  Sample heap;
  heap.bodies.resize(1);
  for (int i = 0; i < 5; ++i)
    for (int j = 0; j < 5; ++j) {
      Body ball;
      ball.name = "ball-" + std::to_string(i) + "-" + std::to_string(j);
      ball.mass_kg = 1;
      ball.shape = Sphere{0.1};
      ball.position_m = {0.21 * i, 0.21 * j, 0.1};
      s.scene.bodies.push_back(ball);
      heap.bodies.emplace_back().p_m = {ball.position_m[0], ball.position_m[1], ball.position_m[2]};
    }
  Recording run;
  run.values = {{heap, heap}};
  CHECK(value_of(measure(s, {}, run), "penetration-max") == Approx(0).margin(1e-15));
  run.values[1].bodies[13].p_m[1] += 0.03;  // into its neighbour along y
  CHECK(value_of(measure(s, {}, run), "penetration-max") == Approx(0.02));
}

TEST_CASE("overlap of boxes, tilted and on a plane") {
  Scenario s = sliding();
  s.samples = 1;
  s.scene.bodies[1].shape = Box{{0.5, 0.5, 0.5}};
  s.scene.bodies.push_back(s.scene.bodies[1]);
  s.scene.bodies[2].name = "upper";
  Recording run;
  run.values = std::vector(2, Sample{0, std::vector<BodySample>(3)});
  for (const SampleReference sample : run.values) {
    sample.bodies[1].p_m = {0, 0, 0.5};
    sample.bodies[2].p_m = {0.2, 0, 0.5 + 0.5 + std::sqrt(0.5) - 0.01};  // on its edge, turned by 45 degrees about y
    sample.bodies[2].q_wxyz = {Wide(std::cos(M_PI / 8)), 0, Wide(std::sin(M_PI / 8)), 0};
  }
  CHECK(value_of(measure(s, {}, run), "penetration-max") == Approx(0.01));
  CHECK(value_of(measure(s, {}, run), "penetration-relative") == Approx(0.02));
  run.values[1].bodies[1].p_m[2] -= 0.05;
  CHECK(value_of(measure(s, {}, run), "penetration-max") == Approx(0.05));
  s.scene.bodies[2].shape = Cylinder{0.5, 0.5};
  const std::vector<Row> unknown = measure(s, {}, run);
  CHECK(std::isnan(value_of(unknown, "penetration-max")));
  CHECK(std::ranges::any_of(
      unknown, [](const Row& row) { return row.reason == "the reference has no depth of box against cylinder"; }));
  CHECK(std::ranges::none_of(unknown, [](const Row& row) { return row.metric == "penetration-relative"; }));
}

TEST_CASE("impacts: place and impulses beside the truth's") {
  const Scenario s = sliding();
  Event hit;
  hit.t_s = 0.5;
  hit.body_b = 1;
  hit.x_m = {1, 2, 0};
  hit.vn_before_m_per_s = -2;
  hit.impulse_n_N_s = 4;
  hit.impulse_t_N_s = 1;
  Recording run = slide(s);
  Truth truth;
  truth.values = run.values;
  truth.bars = std::vector(run.values.size(), Sample{0, std::vector<BodySample>(2)});
  truth.events = {hit};
  truth.event_bar_s = {1e-15};
  run.events = {hit};
  run.events[0].x_m = {1.3, 2.4, 0};
  run.events[0].impulse_n_N_s = 4.5;
  run.events[0].impulse_t_N_s = 0.75;
  const std::vector<Row> rows = measure(s, truth, run);
  CHECK(value_of(rows, "impact-place-error") == Approx(0.5));
  CHECK(value_of(rows, "impact-normal-impulse-error") == Approx(0.5));
  CHECK(value_of(rows, "impact-tangential-impulse-error") == Approx(0.25));
}

TEST_CASE("regimes: stick at another time, and a stick that never comes") {
  const Scenario s = sliding();
  Event stick;
  stick.kind = EventKind::stick;
  stick.t_s = 0.5;
  stick.body_b = 1;
  Recording run = slide(s);
  Truth truth;
  truth.values = run.values;
  truth.bars = std::vector(run.values.size(), Sample{0, std::vector<BodySample>(2)});
  truth.events = {stick};
  truth.event_bar_s = {1e-15};
  CHECK(value_of(measure(s, truth, run), "transition-time-error") == -999);  // no event reported
  run.events = {stick};
  run.events[0].t_s = 0.625;
  CHECK(value_of(measure(s, truth, run), "transition-time-error") == 0.125);
  run.events[0].kind = EventKind::slip;
  CHECK(std::isnan(value_of(measure(s, truth, run), "transition-time-error")));
}
