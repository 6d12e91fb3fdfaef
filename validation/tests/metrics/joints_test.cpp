// Metrics of mechanisms on samples that are written by hand: a pendulum that turns at a constant rate, shifted, tilted
// and delayed by known amounts; reactions with components that are not unique; stops; recordings without joints.
#include <quadmath.h>

#include <catch2/catch.hpp>
#include <cmath>

#include "rows.hpp"
#include "validation/metrics/joints.hpp"
#include "validation/metrics/metrics.hpp"

using namespace atwood;
using atwood::testing::value_of;

namespace {

constexpr double kRate = 2.5;  // rad/s: at t = 4 s more than one turn
constexpr int kSamples = 8;

// A bar of 2 kg on a hinge about z at the origin, its centre of mass 0.5 m from it.
Scenario turning() {
  Scenario s;
  s.id = "turning";
  s.t_end_s = 4;
  s.samples = kSamples;
  s.steps = {8};
  s.scene.materials = {{"all", 0, 0, 0}};
  s.scene.pairs = {{0, 0, 0, 0, 0}};
  Body bar;
  bar.name = "bar";
  bar.mass_kg = 2;
  bar.inertia_kg_m2 = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  bar.position_m = {0.5, 0, 0};
  s.scene.bodies = {bar};
  Joint joint;
  joint.name = "pivot";
  joint.parent = -1, joint.child = 0;
  joint.anchors_body_m[1] = {-0.5, 0, 0};
  joint.axis_body = {0, 0, 1};
  joint.rates[0] = kRate;
  s.scene.joints = {joint};
  return s;
}

// The exact motion, `late` seconds late; its hinge pulls with 2 kg * 0.5 m * rate^2 = 6.25 N towards the pivot.
std::vector<Sample> motion(double late = 0) {
  std::vector<Sample> samples;
  for (int k = 0; k <= kSamples; ++k) {
    Sample sample;
    sample.t_s = Wide(4 * k) / kSamples;
    const Wide angle = Wide(kRate) * (k == 0 ? Wide(0) : sample.t_s - Wide(late));
    sample.bodies.resize(1);
    BodySample& bar = sample.bodies[0];
    bar.q_wxyz = {cosq(angle / 2), 0, 0, sinq(angle / 2)};
    bar.p_m = {cosq(angle) / 2, sinq(angle) / 2, 0};
    bar.v_m_per_s = {-sinq(angle) * kRate / 2, cosq(angle) * kRate / 2, 0};
    bar.w_rad_per_s = {0, 0, kRate};
    sample.joints.resize(1);
    JointSample& joint = sample.joints[0];
    joint.q[0] = angle;
    joint.u[0] = kRate;
    joint.force_N = {-cosq(angle) * 6.25, -sinq(angle) * 6.25, 0};
    joint.torque_N_m = {0, 0, 0};
    samples.push_back(sample);
  }
  return samples;
}

Truth exact() {
  Truth truth;
  truth.source = "by hand";
  truth.values = motion();
  return truth;
}

Recording recorded(std::vector<Sample> samples) {
  Recording run;
  run.values = std::move(samples);
  run.outcome.steps_taken = kSamples;
  return run;
}

double value_for(const std::vector<Row>& rows, const std::string& metric, const std::string& body) {
  for (const Row& r : rows)
    if (r.metric == metric && r.body == body) return r.value;
  return -999;
}

}  // namespace

TEST_CASE("joint metrics: the exact motion has no gap and no error") {
  const std::vector<Row> rows = measure(turning(), exact(), recorded(motion()));
  for (const char* metric : {"joint-gap", "joint-tilt", "error-joint-coordinate", "error-joint-coordinate-end",
                             "error-joint-rate", "error-reaction-force", "error-reaction-torque"}) {
    CAPTURE(metric);
    CHECK(value_for(rows, metric, "") == Approx(0).margin(1e-15));
  }
  CHECK(value_for(rows, "joint-gap", "pivot") == Approx(0).margin(1e-15));
  CHECK(value_of(rows, "size-joint-coordinate") == Approx(10));
}

TEST_CASE("joint metrics: gap and tilt come from the poses, whatever the joint reports") {
  std::vector<Sample> samples = motion();
  samples[3].bodies[0].p_m[2] += 3e-4;
  samples[5].bodies[0].p_m[0] -= 2e-4;
  // Tilted about its own long axis by 0.01: the anchor stays where it is.
  const auto [w, x, y, z] = samples[6].bodies[0].q_wxyz;
  const Wide c = cosq(Wide(0.005)), s = sinq(Wide(0.005));
  samples[6].bodies[0].q_wxyz = {w * c - x * s, w * s + x * c, y * c + z * s, z * c - y * s};
  const std::vector<Row> rows = measure(turning(), exact(), recorded(samples));
  CHECK(value_for(rows, "joint-gap", "") == Approx(3e-4));
  CHECK(value_for(rows, "joint-tilt", "pivot") == Approx(0.01));
  CHECK(value_for(rows, "error-joint-coordinate", "") == Approx(0).margin(1e-15));
}

TEST_CASE("joint metrics: errors of coordinates, rates and reactions") {
  std::vector<Sample> samples = motion(1e-3);
  samples[4].joints[0].u[0] += 0.03;
  samples[2].joints[0].torque_N_m = {0.3, 0, 0.4};
  const std::vector<Row> rows = measure(turning(), exact(), recorded(samples));
  CHECK(value_for(rows, "error-joint-coordinate", "pivot") == Approx(kRate * 1e-3));
  CHECK(value_for(rows, "error-joint-coordinate-end", "") == Approx(kRate * 1e-3));
  CHECK(value_for(rows, "error-joint-rate", "") == Approx(0.03));
  // A force of 6.25 N turned by 2.5e-3 rad.
  CHECK(value_for(rows, "error-reaction-force", "") == Approx(2 * 6.25 * std::sin(1.25e-3)));
  CHECK(value_for(rows, "error-reaction-torque", "pivot") == Approx(0.5));
}

TEST_CASE("joint metrics: coordinates are read from the poses where an engine reports none") {
  std::vector<Sample> samples = motion(1e-3);
  for (Sample& sample : samples) sample.joints.clear();
  std::vector<Row> rows = measure(turning(), exact(), recorded(samples));
  CHECK(value_for(rows, "error-joint-coordinate", "pivot") == Approx(kRate * 1e-3));
  CHECK(value_for(rows, "error-joint-rate", "pivot") == Approx(0).margin(1e-15));
  CHECK(value_for(rows, "error-reaction-force", "") == -999);

  // Two samples 10 rad apart: the poses do not tell how often it turned, which is then no error.
  Truth rare = exact();
  rare.values = {{copy_of(rare.values.front()), copy_of(rare.values.back())}};
  rows = measure(turning(), rare, recorded({samples.front(), samples.back()}));
  CHECK(value_for(rows, "error-joint-coordinate", "pivot") == Approx(kRate * 1e-3));

  // A truth without joints (a closed form of poses): the coordinate's bar is that of the attitude.
  Truth poses = exact();
  poses.values.clear();
  for (const SampleView sample : exact().values)
    poses.values.push_back(Sample{sample.t_s, {sample.bodies.begin(), sample.bodies.end()}});
  poses.bars = std::vector(poses.values.size(), Sample{0, {{{}, {3e-6, 0, 0, 4e-6}, {}, {}}}});
  rows = measure(turning(), poses, recorded(motion(1e-3)));
  for (const Row& r : rows)
    if (r.metric == "error-joint-coordinate") {
      CHECK(r.value == Approx(kRate * 1e-3));
      CHECK(r.truth_bar == Approx(1e-5));
    }
}

TEST_CASE("joint metrics: components that are not unique are not compared") {
  Truth truth = exact();
  std::vector<Sample> samples = motion();
  for (std::size_t k = 0; k < samples.size(); ++k) {
    samples[k].joints[0].force_N[2] = 17;  // any value: the constraints leave it open
    samples[k].joints[0].torque_N_m = {1, 2, 3};
    truth.values[k].joints[0].not_unique = 0b111100;
  }
  const std::vector<Row> rows = measure(turning(), truth, recorded(samples));
  CHECK(value_for(rows, "error-reaction-force", "pivot") == Approx(0).margin(1e-15));
  CHECK(value_for(rows, "error-reaction-torque", "") == -999);
  for (const Row& r : rows)
    if (r.metric == "error-reaction-torque") {
      CHECK(r.status == Status::unsupported);
      CHECK(r.reason == "not unique");
    }
}

TEST_CASE("joint metrics: an offset is in metres; the row of all joints has angles and offsets") {
  Scenario scenario = turning();
  scenario.scene.joints[0].kind = JointKind::cylindrical;
  std::vector<Sample> samples = motion();
  samples[3].joints[0].q[0] += 1e-6;
  samples[8].joints[0].q[1] = 2e-5;
  samples[8].joints[0].u[1] = 0.25;
  const std::vector<Row> rows = measure(scenario, exact(), recorded(samples));
  for (const Row& r : rows) {
    if (r.metric == "error-joint-coordinate")
      CHECK(r.unit == (r.body == "pivot.offset" ? "m" : r.body.empty() ? "rad, m" : "rad"));
    if (r.metric == "error-joint-rate" && r.body.empty()) CHECK(r.unit == "rad/s, m/s");
  }
  CHECK(value_for(rows, "error-joint-coordinate", "pivot") == Approx(1e-6));
  CHECK(value_for(rows, "error-joint-coordinate", "pivot.offset") == Approx(2e-5));
  CHECK(value_for(rows, "error-joint-coordinate", "") == Approx(2e-5));
  CHECK(value_for(rows, "error-joint-coordinate-end", "") == Approx(2e-5));
  CHECK(value_for(rows, "error-joint-rate", "") == Approx(0.25));
  CHECK(value_for(rows, "error-joint-angle", "") == Approx(1e-6));
  CHECK(value_for(rows, "error-joint-offset", "") == Approx(2e-5));
}

TEST_CASE("joint metrics: a prescribed joint has rows of its own and no part in those of all joints") {
  Scenario scenario = turning();
  scenario.scene.joints[0].driven_rate = kRate;
  std::vector<Row> rows = measure(scenario, exact(), recorded(motion(1e-3)));
  CHECK(value_for(rows, "error-joint-coordinate", "pivot") == Approx(kRate * 1e-3));
  for (const char* metric :
       {"error-joint-coordinate", "error-joint-coordinate-end", "error-joint-rate", "error-joint-angle"}) {
    CAPTURE(metric);
    CHECK(value_for(rows, metric, "") == -999);
  }

  Joint slider = scenario.scene.joints[0];
  slider.name = "slider";
  slider.kind = JointKind::slider;
  slider.driven_rate.reset();
  scenario.scene.joints.push_back(slider);
  Truth truth = exact();
  std::vector<Sample> samples = motion(1e-3);
  std::vector<Sample> true_samples;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    true_samples.push_back(copy_of(truth.values[k]));
    true_samples[k].joints.resize(2), samples[k].joints.resize(2);
    samples[k].joints[1].q[0] = k == 0 ? 0 : 3e-7;
  }
  truth.values = true_samples;
  rows = measure(scenario, truth, recorded(samples));
  CHECK(value_for(rows, "error-joint-coordinate", "") == Approx(3e-7));
  CHECK(value_for(rows, "error-joint-offset", "") == Approx(3e-7));
  CHECK(value_for(rows, "error-joint-angle", "") == -999);
  for (const Row& r : rows)
    if (r.metric == "error-joint-coordinate" && r.body.empty()) CHECK(r.unit == "m");
}

TEST_CASE("joint metrics: samples on the instant of a stop's impact do not count for rates and reactions") {
  Scenario scenario = turning();
  scenario.scene.joints[0].limits = JointLimits{-20, 20, 0.25};
  Truth truth = exact();
  Event impact;
  impact.t_s = 2;
  impact.body_a = -1, impact.body_b = 0;
  impact.vn_before_m_per_s = -2.5, impact.vn_after_m_per_s = 0.625;
  truth.events = {impact};
  truth.event_bar_s = {1e-12};
  std::vector<Sample> samples = motion();
  samples[4].joints[0].u[0] = -1;
  samples[4].joints[0].force_N = {9, 9, 9};
  samples[4].bodies[0].v_m_per_s = {7, 7, 7};
  Recording run = recorded(samples);
  run.events = {impact};
  run.events[0].t_s += Wide(1e-3);
  run.events[0].vn_after_m_per_s = 1.25;
  const std::vector<Row> rows = measure(scenario, truth, run);
  CHECK(value_for(rows, "error-joint-rate", "") == Approx(0).margin(1e-15));
  CHECK(value_for(rows, "error-reaction-force", "") == Approx(0).margin(1e-15));
  CHECK(value_for(rows, "error-velocity-max", "") == Approx(0).margin(1e-15));
  CHECK(value_of(rows, "impact-time-error") == Approx(1e-3));
  CHECK(value_of(rows, "impact-count-error") == 0);
  CHECK(value_of(rows, "restitution-error") == Approx(0.5 - 0.25));

  // An event without a body belongs to the stop of a joint to the world, else the recording cannot be measured.
  scenario.scene.joints[0].limits.reset();
  CHECK(value_of(measure(scenario, truth, run), "status") == 0);
}

TEST_CASE("joint metrics: the energy of a spring in a joint that turns") {
  Scenario scenario = turning();
  scenario.invariants = {{"energy"}};
  JointTorque torque;
  torque.torque = 0.5;  // V = -q / 2: at t = 4, q = 10
  scenario.scene.joint_forces = {torque};
  std::vector<Sample> samples = motion();
  for (Sample& sample : samples) sample.joints.clear();  // turns are counted along the samples
  const Series series = error_series(scenario, {}, recorded(samples));
  REQUIRE(series.energy.size() == samples.size());
  CHECK(series.energy.back() == Approx(-5));
}

TEST_CASE("joint metrics: a rope that stretches has a gap") {
  Scenario scenario = turning();
  scenario.scene.joints.clear();
  Body post;
  post.name = "post";
  post.fixed = true;
  scenario.scene.bodies.push_back(post);
  Rope rope;
  rope.name = "line";
  rope.bodies = {0, 1};
  scenario.scene.ropes = {rope};
  std::vector<Sample> samples = motion();
  for (Sample& sample : samples) sample.bodies.resize(2), sample.joints.clear();
  CHECK(value_for(measure(scenario, {}, recorded(samples)), "joint-gap", "line") == Approx(0).margin(1e-15));
  for (Wide& x : samples[7].bodies[0].p_m) x *= 1.25;
  CHECK(value_for(measure(scenario, {}, recorded(samples)), "joint-gap", "") == Approx(0.125));
}

TEST_CASE("joint metrics: the order of joint coordinates along a ladder") {
  std::vector<Row> cells;
  for (const std::int64_t steps : {40, 80, 160, 320, 640}) {
    const double h = 4.0 / static_cast<double>(steps);
    for (const auto& [metric, value] :
         {std::pair{"error-joint-coordinate-end", 0.3 * std::pow(h, 4)}, {"condition", 1.0}}) {
      Row r;
      r.scenario = "turning", r.method = "atwood/rk4", r.steps = steps, r.h_s = h;
      r.metric = metric, r.value = value;
      cells.push_back(r);
    }
  }
  CHECK(value_of(fit_ladder(cells), "order-joint-coordinate-end") == Approx(4).margin(1e-3));
}

TEST_CASE("joint metrics: links are the bodies that joints or ropes hold") {
  Scenario scenario = turning();
  Body free = scenario.scene.bodies[0];
  scenario.scene.bodies.push_back(free);
  CHECK(linked_bodies(scenario.scene) == 1);
  Joint second = scenario.scene.joints[0];
  second.parent = 0, second.child = 1;
  scenario.scene.joints.push_back(second);
  CHECK(linked_bodies(scenario.scene) == 2);
}
