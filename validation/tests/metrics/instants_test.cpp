// The instants at which errors over a run, drift and growth are judged: what all rungs share, and that no period of a
// motion falls on all of them.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>
#include <random>

#include "validation/metrics/instants.hpp"
#include "validation/metrics/metrics.hpp"

using namespace atwood;

namespace {

constexpr double kTurn = 6.283185307179586;

const Row& row_of(const std::vector<Row>& rows, const std::string& metric) {
  const auto found = std::find_if(rows.begin(), rows.end(), [&](const Row& r) { return r.metric == metric; });
  INFO(metric);
  REQUIRE(found != rows.end());
  return *found;
}

// A mass on a spring of this period, from rest at x = 1.
Scenario spring(double t_end_s, double period_s, std::int64_t samples, std::vector<std::int64_t> steps) {
  Scenario s;
  s.id = "spring";
  s.t_end_s = t_end_s;
  s.samples = samples;
  s.steps = std::move(steps);
  s.scene.materials = {{"all", 0, 0, 0}};
  s.scene.pairs = {{0, 0, 0, 0, 0}};
  Body ball;
  ball.name = "ball";
  ball.mass_kg = 1;
  ball.position_m = {1, 0, 0};
  s.scene.bodies = {ball};
  Spring force;
  force.bodies = {0};
  force.stiffness_N_per_m = std::pow(kTurn / period_s, 2);
  s.scene.forces = {force};
  s.truth.kind = TruthKind::closed_form;
  s.truth.solution = "oscillator";
  s.invariants = {{"energy"}};
  return s;
}

Sample state(double t, double x, double v) {
  Sample sample;
  sample.t_s = t;
  sample.bodies.resize(1);
  sample.bodies[0].p_m = {x, 0, 0};
  sample.bodies[0].v_m_per_s = {v, 0, 0};
  return sample;
}

double stiffness(const Scenario& s) { return std::get<Spring>(s.scene.forces[0]).stiffness_N_per_m; }

Truth exact(const Scenario& s, std::int64_t samples) {
  const double w = std::sqrt(stiffness(s));
  Truth truth;
  for (std::int64_t k = 0; k <= samples; ++k) {
    const double t = s.t_end_s * static_cast<double>(k) / static_cast<double>(samples);
    truth.values.push_back(state(t, std::cos(w * t), -w * std::sin(w * t)));
    truth.bars.push_back(state(t, 0, 0));
    truth.bars.back().bodies[0].q_wxyz = {0, 0, 0, 0};
  }
  return truth;
}

// Symplectic Euler, as a worker answers a plan of `shared` samples.
Recording symplectic_euler(const Scenario& s, std::int64_t steps, std::int64_t shared) {
  const double h = s.t_end_s / static_cast<double>(steps), k = stiffness(s);
  double x = 1, v = 0;
  Recording run;
  for (std::int64_t n = 0; n <= steps; ++n) {
    if (n % (steps / shared) == 0) run.values.push_back(state(h * static_cast<double>(n), x, v));
    v -= h * k * x;
    x += h * v;
  }
  run.outcome.steps_taken = steps;
  return with_instants(std::move(run), s.samples, shared);
}

// The rows of a ladder as a study makes them.
std::vector<Row> orders_of(const Scenario& s, std::int64_t shared) {
  const Truth truth = exact(s, shared);
  std::vector<Row> cells;
  LadderInstants instants{s.samples, {}};
  for (const std::int64_t steps : s.steps) {
    instants.shared[steps] = shared;
    for (Row row : measure(s, truth, symplectic_euler(s, steps, shared))) {
      row.method = "atwood/symplectic-euler";
      row.steps = steps;
      row.h_s = s.t_end_s / static_cast<double>(steps);
      cells.push_back(row);
    }
  }
  return fit_ladder(cells, instants);
}

}  // namespace

TEST_CASE("instants: a multiple of the samples that divides every step count; judged ones in each part of the run") {
  std::mt19937_64 random(1);
  const auto draw = [&](std::int64_t from, std::int64_t to) {
    return std::uniform_int_distribution<std::int64_t>(from, to)(random);
  };
  int more = 0;
  for (int i = 0; i < 400; ++i) {
    const std::int64_t samples = draw(1, 150);
    std::vector<std::int64_t> steps;
    for (int rung = 0; rung < 4; ++rung) steps.push_back(samples * draw(1, 12) * (draw(0, 1) == 0 ? 1 : draw(1, 60)));
    const Scenario s = spring(10, 1, samples, steps);
    const std::int64_t shared = shared_samples(s);
    INFO(samples << " samples, " << shared << " shared");
    CHECK(shared % samples == 0);
    for (const std::int64_t n : steps) CHECK(n % shared == 0);
    CHECK(may_share(samples, shared));
    more += shared > samples ? 1 : 0;
    const std::vector<std::int64_t> judged = judged_instants(samples, shared);
    const auto parts = static_cast<std::int64_t>(judged.size());
    CHECK(parts >= std::min<std::int64_t>(shared, std::max<std::int64_t>(64, samples)));
    for (std::int64_t part = 0; part < parts; ++part) {
      const double first = static_cast<double>(shared * part) / static_cast<double>(parts);
      const auto k = static_cast<double>(judged[static_cast<std::size_t>(part)]);
      CHECK(k > first);
      CHECK(k <= first + static_cast<double>(shared) / static_cast<double>(parts) + 1);
    }
  }
  CHECK(more > 40);
  CHECK(more < 360);
  Scenario frames = spring(10, 1, 20, {320, 640});
  CHECK(shared_samples(frames) == 160);
  frames.frame_ends_s = {5, 10};
  CHECK(shared_samples(frames) == 20);  // recorded frames
  CHECK(shared_samples(spring(10, 1, 20, {320, 340})) == 20);
}

TEST_CASE("instants: no period of the grid falls on more of the judged ones than its share and a tenth of them") {
  for (const std::int64_t samples : {1, 10, 20, 40, 60, 64, 100, 120}) {
    for (const std::int64_t shared : {2 * samples, 3 * samples, 4 * samples, 160L, 240L, 256L}) {
      if (shared % samples != 0 || shared < 128) continue;
      const std::vector<std::int64_t> judged = judged_instants(samples, shared);
      for (std::int64_t period = 2; period <= shared / 4; ++period) {
        for (std::int64_t phase = 0; phase < period; ++phase) {
          const auto on = std::ranges::count_if(judged, [&](std::int64_t k) { return k % period == phase; });
          INFO(samples << " of " << shared << ", every " << period << " from " << phase);
          CHECK(static_cast<double>(on) <
                (1 / static_cast<double>(period) + 0.1) * static_cast<double>(judged.size()) + 2);
        }
      }
    }
  }
}

TEST_CASE(
    "orders over a run: symplectic Euler has 1, whatever period divides the samples, and superconverges at them") {
  std::mt19937_64 random(2);
  for (int i = 0; i < 12; ++i) {
    const std::int64_t samples = std::vector<std::int64_t>{5, 10, 20, 40}[random() % 4];
    const double periods_a_sample = 0.5 * static_cast<double>(1 + random() % (samples <= 10   ? 4
                                                                              : samples == 20 ? 2
                                                                                              : 1));
    const Scenario s =
        spring(10, 10 / (periods_a_sample * static_cast<double>(samples)), samples, {2560, 5120, 10240, 20480, 40960});
    const std::int64_t shared = shared_samples(s);
    INFO(samples << " samples, " << periods_a_sample << " periods between two, " << shared << " shared");
    REQUIRE(shared >= 160);
    const std::vector<Row> orders = orders_of(s, shared);
    const Row &largest = row_of(orders, "order-position"), &end = row_of(orders, "order-position-end");
    INFO(largest.value << " +/- " << largest.truth_bar << " " << largest.reason << "; end " << end.value);
    CHECK(std::fabs(largest.value - 1) < std::max(0.05, std::min(largest.truth_bar, 0.3)));
    CHECK(row_of(orders, "order-position-max").value == largest.value);
    CHECK(std::fabs(row_of(orders, "order-position-rms").value - 1) < 0.1);
    CHECK(end.value > 1.9);
    CHECK(largest.reason.find("superconvergent at the samples: order ") != std::string::npos);
    CHECK(end.reason.find("superconvergent at the samples") != std::string::npos);
  }
}

TEST_CASE(
    "orders over a run: where the steps share no other instant, the order says so; fewer instants leave a rung out") {
  Scenario s = spring(10, 1.7, 60, {60, 120, 240, 480, 960, 1920});
  REQUIRE(shared_samples(s) == 60);
  const std::vector<Row> alone = orders_of(s, 60);
  CHECK(row_of(alone, "order-position").reason.find("over the 60 samples alone: these steps share no other instant") !=
        std::string::npos);
  CHECK(row_of(alone, "order-position").reason.find("superconvergent") == std::string::npos);
  s.steps = {120, 240, 480, 960, 1920};
  const Truth truth = exact(s, 120);
  LadderInstants instants{60, {{60, 60}, {120, 120}, {240, 120}, {480, 120}, {960, 120}, {1920, 120}}};
  std::vector<Row> cells;
  for (const auto& [steps, shared] : instants.shared)
    for (Row row : measure(s, truth, symplectic_euler(s, steps, shared))) {
      row.method = "atwood/symplectic-euler", row.steps = steps, row.h_s = s.t_end_s / static_cast<double>(steps);
      cells.push_back(row);
    }
  const std::vector<Row> mixed = fit_ladder(cells, instants);
  CHECK(row_of(mixed, "order-position").reason.find("left out: 60 (fewer instants)") != std::string::npos);
  CHECK(row_of(mixed, "order-position-end").reason.find("fewer instants") == std::string::npos);
}

TEST_CASE("instants: samples near a period of the energy's oscillation show no drift") {
  // Symplectic Euler's energy oscillates twice a period: 41 of its periods less a little are 40 samples.
  std::mt19937_64 random(3);
  int wrong = 0;
  for (int i = 0; i < 20; ++i) {
    const std::int64_t samples = 40 + static_cast<std::int64_t>(random() % 80);
    const double near = 1 + 0.002 * static_cast<double>(1 + random() % 3) * (random() % 2 == 0 ? 1 : -1);
    const Scenario s = spring(0.5 * near * static_cast<double>(samples), 1, samples,
                              {samples * 48, samples * 96, samples * 192, samples * 384});
    const std::int64_t shared = shared_samples(s);
    REQUIRE(shared > samples);
    const std::vector<Row> rows = measure(s, exact(s, shared), symplectic_euler(s, samples * 96, shared));
    const Row& drift = row_of(rows, "energy-drift");
    INFO(samples << " samples, " << near << ": " << drift.value << " +/- " << drift.truth_bar << " " << drift.reason);
    wrong += std::fabs(drift.value) > drift.truth_bar ? 1 : 0;
    // The largest change is that of the instants between the samples too.
    CHECK(row_of(rows, "energy-max").value > 0.9 * kTurn * near / 8 / 96);  // h w / 4
  }
  CHECK(wrong <= 2);  // intervals of 95 %
}

TEST_CASE("instants: what needs only the samples has its bits whatever the run shares") {
  const Scenario s = spring(10, 1.7, 20, {320, 640, 1280});
  const std::vector<Row> alone = measure(s, exact(s, 20), symplectic_euler(s, 640, 20)),
                         shared = measure(s, exact(s, 160), symplectic_euler(s, 640, 160));
  for (const char* metric : {"error-position-end", "error-velocity-end", "error-state-end", "energy-scale",
                             "size-position", "size-velocity", "condition"})
    CHECK(row_of(alone, metric).value == row_of(shared, metric).value);
  CHECK(row_of(shared, "error-position-max").value >= row_of(alone, "error-position-max").value);
  CHECK(row_of(shared, "error-position-rms").value < row_of(shared, "error-position-max").value);
}

TEST_CASE("instants: a run that ended early or at its samples alone keeps those") {
  const Scenario s = spring(10, 1, 20, {320, 640});
  Recording early;
  for (int k = 0; k < 50; ++k) early.values.push_back(state(k, 0, 0));
  early.outcome.status = Status::diverged;
  const Recording kept = with_instants(early, 20, 160);
  CHECK(kept.values.size() == 7);
  CHECK(kept.values[6].t_s == 48);
  CHECK(kept.between.empty());
  const Recording own = symplectic_euler(s, 640, 20);
  CHECK(own.values.size() == 21);
  CHECK(own.between.empty());
}
