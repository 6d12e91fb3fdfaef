// "+impulse": impacts on round and rotating surfaces, corners that touch within a step, sleep.
#include <catch2/catch.hpp>

#include <cmath>

#include "collision/contacts.hpp"
#include "stepping_scenes.hpp"

using namespace atwood;
using namespace atwood::stepping_scenes;

namespace {

double apart(const std::array<Wide, 3>& a, const std::array<Wide, 3>& b) {
  double square = 0;
  for (int c = 0; c < 3; ++c) square += static_cast<double>((a[c] - b[c]) * (a[c] - b[c]));
  return std::sqrt(square);
}

double deepest_overlap(const Scene& scene, const Sample& sample) {
  std::vector<Geometry<double>> shapes;
  std::vector<Transform<double>> places;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const BodySample& b = sample.bodies[i];
    const auto at = [](const auto& v, int c) { return static_cast<double>(v[c]); };
    shapes.push_back(make_geometry<double>(scene.bodies[i].shape));
    places.push_back(transform<double>({at(b.p_m, 0), at(b.p_m, 1), at(b.p_m, 2)},
                                       {at(b.q_wxyz, 0), at(b.q_wxyz, 1), at(b.q_wxyz, 2), at(b.q_wxyz, 3)}));
  }
  double deepest = 0;
  std::vector<Manifold<double>> found;
  for (std::size_t a = 0; a < shapes.size(); ++a)
    for (std::size_t b = 0; b < shapes.size(); ++b) {
      const bool plane = shapes[b].kind == ShapeKind::plane;
      if (shapes[a].kind == ShapeKind::plane || (!plane && b <= a)) continue;
      found.clear();
      find_contacts(shapes[a], places[a], shapes[b], places[b], 0.0, found);
      for (const Manifold<double>& m : found)
        for (int i = 0; i < m.count; ++i) deepest = std::max(deepest, -m.points[i].gap);
    }
  return deepest;
}

Scene tower_and_ball(const Real3& from, double along_x_m_per_s) {  // three cubes on each other, and a ball in flight
  std::vector<Body> bodies{floor_plane()};
  for (int i = 0; i < 3; ++i)
    bodies.push_back(box("cube" + std::to_string(i), 1, {0.1, 0.1, 0.1}, {0, 0, 0.1 + 0.2 * i}));
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

TEST_CASE("+impulse: an impact on a round or rotating surface is where the shapes touch, at any step") {
  // The ball hits the cap of a capsule obliquely, so the normal depends on where it touches. Momentum is kept with any
  // normal; a wrong one shows in the motion afterwards.
  const Scene scene = catalogue("struck-rod-rough");
  const Recorded fine = run(euler, scene, {2.0, 7680, 60});
  for (const int steps : {60, 120, 420, 1920}) {
    const Recorded coarse = run(euler, scene, {2.0, steps, 60});
    for (std::size_t i = 0; i < scene.bodies.size(); ++i)
      CHECK(apart(coarse.samples.back().bodies[i].p_m, fine.samples.back().bodies[i].p_m) < 1e-11);
  }
}

TEST_CASE("+impulse: an impact at a step's very end is as fast as any other") {
  // it touches at t = 458 / 1920 of two seconds
  const Recorded at_end = run(euler, catalogue("struck-rod"), {2.0, 1920, 60});
  const auto impact = std::find_if(at_end.events.begin(), at_end.events.end(),
                                   [](const Event& e) { return e.kind == EventKind::impact; });
  REQUIRE(impact != at_end.events.end());
  CHECK(static_cast<double>(impact->vn_before_m_per_s) == Approx(-6).epsilon(1e-13));
  CHECK(static_cast<double>(impact->vn_after_m_per_s) == Approx(3).epsilon(1e-13));
}

TEST_CASE("+impulse: corners that come near within a step do not penetrate") {
  // Boxes tumble into a heap at 60 steps a second: within a step, corners come near that were far apart when it began.
  // With the manifolds of the step's beginning, boxes penetrate by more than half an edge.
  const Scene scene = catalogue("settling-boxes-100");
  const Recorded r = run(euler, scene, {0.5, 30, 30});
  double deepest = 0;
  for (const Sample& sample : r.samples) deepest = std::max(deepest, deepest_overlap(scene, sample));
  CHECK(deepest > 0);
  CHECK(deepest < 0.01);  // a tenth of half an edge
}

TEST_CASE("+impulse: sleeping is off by default, and holds bodies that have been at rest") {
  const Scene scene = tower_and_ball({0, 0, 1e3}, 0);
  const Plan plan{2.0, 480, 20};
  const Recorded sleeping = run(euler + "{sleeping=true,sleep_after_s=0.25}", scene, plan);
  for (const Sample& s : sleeping.samples) {
    if (static_cast<double>(s.t_s) < 0.3) continue;
    for (int i = 1; i <= 3; ++i) CHECK(speed_of(s.bodies[i]) == 0);
    CHECK(s.contacts.empty());  // contacts of sleeping bodies are not solved
  }
  const Recorded awake = run(euler, scene, plan);
  CHECK(!awake.samples.back().contacts.empty());
}

TEST_CASE("+impulse: a sleeping island wakes as a whole before a moving body hits it") {
  // meets the uppermost cube's side after half a second
  const Scene scene = tower_and_ball({-1.65, 0, 0.5 + 9.81 / 8}, 3);
  const Plan plan{1.5, 720, 90};
  const Recorded sleeping = run(euler + "{sleeping=true,sleep_after_s=0.25}", scene, plan),
                 awake = run(euler, scene, plan);
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

TEST_CASE("+impulse: sleeping is refused where forces act whose changes would not wake a body") {
  Scene scene = tower_and_ball({0, 0, 2}, 0);
  LinearDrag drag;
  drag.bodies = {1};
  drag.coefficient_kg_per_s = 0.1;
  scene.forces.push_back(drag);
  const Recorded r = try_run(euler + "{sleeping=true}", scene, {1.0, 240, 1});
  CHECK(r.outcome.status == Status::unsupported);
  CHECK(r.outcome.reason.find("sleeping") != std::string::npos);
}

TEST_CASE("+impulse: sleep does not depend on the number of threads") {
  const Scene scene = catalogue("settling-boxes-100");
  const Plan plan{3.0, 720, 12};
  const Recorded one = run(euler + "{sleeping=true}", scene, plan),
                 two = run(euler + "{sleeping=true,threads=2}", scene, plan);
  REQUIRE(one.samples.size() == two.samples.size());
  for (std::size_t k = 0; k < one.samples.size(); ++k) CHECK(same_bits(one.samples[k], two.samples[k]));
}
