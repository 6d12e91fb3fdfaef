// "+impulse": where impacts and corners are within a step, and who sleeps.
#include <catch2/catch.hpp>

#include <cmath>

#include "stepping_scenes.hpp"

using namespace atwood;
using namespace atwood::stepping_scenes;

namespace {

double apart(const std::array<Wide, 3>& a, const std::array<Wide, 3>& b) {
  double square = 0;
  for (int c = 0; c < 3; ++c) square += static_cast<double>((a[c] - b[c]) * (a[c] - b[c]));
  return std::sqrt(square);
}

Scene tower_and_ball(const Real3& from, double along_x_m_per_s) {  // three cubes on each other, and a ball in flight
  std::vector<Body> bodies{floor_plane()};
  for (int i = 0; i < 3; ++i) bodies.push_back(box("cube" + std::to_string(i), 1, {0.1, 0.1, 0.1}, {0, 0, 0.1 + 0.2 * i}));
  bodies.push_back(ball("ball", 0.5, 0.05, from, {along_x_m_per_s, 0, 0}));
  return scene_of(bodies, 0, 0.5, 9.81);
}

double speed_of(const BodySample& body) {
  double square = 0;
  for (int c = 0; c < 3; ++c)
    square += static_cast<double>(body.v_m_per_s[c] * body.v_m_per_s[c] + body.w_rad_per_s[c] * body.w_rad_per_s[c]);
  return std::sqrt(square);
}

}  // namespace

TEST_CASE("+impulse: an impact on a round or turning surface is where the shapes touch, at any step") {
  // The ball meets the cap of a capsule aslant: its normal is known only when it is there. Momentum is kept whatever the normal, so it is
  // the motion afterwards that tells.
  const Scene scene = catalogue("struck-rod-rough");
  const Recorded fine = run(euler, scene, {2.0, 7680, 60});
  for (const int steps : {60, 120, 420, 1920}) {
    const Recorded coarse = run(euler, scene, {2.0, steps, 60});
    REQUIRE(coarse.outcome.status == Status::ok);
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) CHECK(apart(coarse.samples.back().bodies[i].p_m, fine.samples.back().bodies[i].p_m) < 1e-11);
  }
}

TEST_CASE("+impulse: an impact at a step's very end is as fast as any other") {
  const Recorded at_end = run(euler, catalogue("struck-rod"), {2.0, 1920, 60});  // it touches at t = 458 / 1920 of two seconds
  const auto impact = std::find_if(at_end.events.begin(), at_end.events.end(), [](const Event& e) { return e.kind == EventKind::impact; });
  REQUIRE(impact != at_end.events.end());
  CHECK(static_cast<double>(impact->vn_before_m_per_s) == Approx(-6).epsilon(1e-13));
  CHECK(static_cast<double>(impact->vn_after_m_per_s) == Approx(3).epsilon(1e-13));
}

TEST_CASE("+impulse: corners that come near within a step are met") {
  // A cube falls past the edge of a fixed one, tumbling at 40 rad/s: 0.17 rad a step, in which a corner gets 3 cm. Contacts as they were at
  // the step's start would let one sink in.
  Body lower = box("lower", 1, {0.2, 0.2, 0.2}, {0, 0, 0}), upper = box("upper", 1, {0.1, 0.1, 0.1}, {0.05, 0.03, 0.38});
  lower.fixed = true;
  upper.velocity_m_per_s = {0, 0, -3};
  upper.angular_velocity_body_rad_per_s = {25, 30, 10};
  const Scene scene = scene_of({lower, upper}, 0, 0.5);
  const Recorded r = run(euler, scene, {0.125, 30, 30});
  double deepest = 0;
  for (const Sample& s : r.samples)
    for (int i = 0; i < 8; ++i) {  // corners of the upper cube below the lower one's top, within its sides
      const BodySample& b = s.bodies[1];
      const double corner[3] = {i & 1 ? 0.1 : -0.1, i & 2 ? 0.1 : -0.1, i & 4 ? 0.1 : -0.1};
      const double w = static_cast<double>(b.q_wxyz[0]);
      const double q[3] = {static_cast<double>(b.q_wxyz[1]), static_cast<double>(b.q_wxyz[2]), static_cast<double>(b.q_wxyz[3])};
      const auto cross = [](const double* x, const double* y, int c) { return x[(c + 1) % 3] * y[(c + 2) % 3] - x[(c + 2) % 3] * y[(c + 1) % 3]; };
      double t[3], at[3];
      for (int c = 0; c < 3; ++c) t[c] = 2 * cross(q, corner, c);
      for (int c = 0; c < 3; ++c) at[c] = static_cast<double>(b.p_m[c]) + corner[c] + w * t[c] + cross(q, t, c);
      if (std::abs(at[0]) < 0.2 && std::abs(at[1]) < 0.2 && at[2] < 0.2) deepest = std::max(deepest, std::min({0.2 - at[2], 0.2 - std::abs(at[0]), 0.2 - std::abs(at[1])}));
    }
  CHECK(deepest < 1e-3);
  CHECK(speed_of(r.samples.back().bodies[1]) > 0.1);  // they met, and it goes on
}

TEST_CASE("+impulse: sleeping is off unless asked for, and holds still what has been at rest") {
  const Scene scene = tower_and_ball({0, 0, 1e3}, 0);
  const Plan plan{2.0, 480, 20};
  const Recorded sleeping = run(euler + "{sleeping=true,sleep_after_s=0.25}", scene, plan);
  REQUIRE(sleeping.outcome.status == Status::ok);
  for (const Sample& s : sleeping.samples) {
    if (static_cast<double>(s.t_s) < 0.3) continue;
    for (int i = 1; i <= 3; ++i) CHECK(speed_of(s.bodies[i]) == 0);
    CHECK(s.contacts.empty());  // nobody is solved any more
  }
  const Recorded awake = run(euler, scene, plan);
  CHECK(!awake.samples.back().contacts.empty());
}

TEST_CASE("+impulse: who sleeps wakes before he is hit, with all that lie on him") {
  const Scene scene = tower_and_ball({-1.65, 0, 0.5 + 9.81 / 8}, 3);  // meets the uppermost cube's side after half a second
  const Plan plan{1.5, 720, 90};
  const Recorded sleeping = run(euler + "{sleeping=true,sleep_after_s=0.25}", scene, plan), awake = run(euler, scene, plan);
  REQUIRE(sleeping.outcome.status == Status::ok);
  double fastest = 0;
  for (std::size_t k = 0; k < awake.samples.size(); ++k) {
    const auto t_s = static_cast<double>(awake.samples[k].t_s);
    if (t_s > 0.55) continue;
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
      CHECK(apart(sleeping.samples[k].bodies[i].p_m, awake.samples[k].bodies[i].p_m) < 1e-6);
      if (t_s > 0.51 && i == 3) fastest = std::max(fastest, speed_of(sleeping.samples[k].bodies[i]));
    }
  }
  CHECK(fastest > 0.5);
}

TEST_CASE("+impulse: sleeping is refused where forces act that would wake nobody") {
  Scene scene = tower_and_ball({0, 0, 2}, 0);
  LinearDrag drag;
  drag.bodies = {1};
  drag.coefficient_kg_per_s = 0.1;
  scene.forces.push_back(drag);
  const Recorded r = run(euler + "{sleeping=true}", scene, {1.0, 240, 1});
  CHECK(r.outcome.status == Status::unsupported);
  CHECK(r.outcome.reason.find("sleeping") != std::string::npos);
}

TEST_CASE("+impulse: who sleeps does not depend on the number of threads") {
  const Scene scene = catalogue("settling-boxes-100");
  const Plan plan{3.0, 720, 12};
  const Recorded one = run(euler + "{sleeping=true}", scene, plan), two = run(euler + "{sleeping=true,threads=2}", scene, plan);
  REQUIRE(one.samples.size() == two.samples.size());
  for (std::size_t k = 0; k < one.samples.size(); ++k) CHECK(same_bits(one.samples[k], two.samples[k]));
}
