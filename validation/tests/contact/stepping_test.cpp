// "+impulse": conservation, cones, rest, and the same bits however many threads there are.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>

#include "stepping_scenes.hpp"

using namespace atwood;
using namespace atwood::stepping_scenes;

TEST_CASE("+impulse: collisions keep momentum and angular momentum, and never gain energy") {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> any(-1, 1);
  int met = 0;
  for (int k = 0; k < 200; ++k) {
    const double e = k % 3 == 0 ? 0 : k % 3 == 1 ? 1 : 0.5 * (1 + any(random)), mu = k % 2 == 0 ? 0 : 0.4;
    std::vector<Body> bodies;
    for (int i = 0; i < 2; ++i)
      bodies.push_back(ball("b" + std::to_string(i), 1.5 + any(random), 0.3,
                            {1.0 * i, 0.3 * any(random), 0.3 * any(random)}, {-1.0 * i, any(random), any(random)},
                            {any(random), any(random), any(random)}));
    const Scene scene = scene_of(bodies, e, mu);
    const Recorded r = run(euler, scene, {2, 60, 60});
    met += static_cast<int>(r.events.size());
    const Total start = total(scene, r.samples.front());
    double before = start.energy;
    for (const Sample& s : r.samples) {
      const Total now = total(scene, s);
      for (int c = 0; c < 3; ++c) {
        CHECK(std::abs(now.P[c] - start.P[c]) < 1e-13);
        CHECK(std::abs(now.L[c] - start.L[c]) < 1e-12);
      }
      CHECK(now.energy < before + 1e-13);
      before = now.energy;
    }
  }
  CHECK(met > 40);
}

TEST_CASE("+impulse: a run says what its sweeps left over") {
  std::vector<Body> bodies{floor_plane()};
  for (int i = 0; i < 5; ++i) bodies.push_back(box("box" + std::to_string(i), 1, {0.5, 0.5, 0.5}, {0, 0, 0.5 + i}));
  const Scene scene = scene_of(bodies, 0, 0.5, 9.8);
  const auto tally = [&](const std::string& settings, const char* solver) {
    const Recorded r = run(euler + settings, scene, {0.1, 6, 6});
    return r.outcome.solvers.at(solver);
  };
  const std::string sequential = "{iterations=N,rest_sweeps=0,solver=sequential}";
  const auto swept = [&](const char* n) {
    return tally(std::string(sequential).replace(sequential.find('N'), 1, n), "contact-sweeps");
  };
  const SolveTally one = swept("1"), fifty = swept("50");
  CHECK(one.solves() == 6);  // the last substep of each step
  CHECK(one.capped == 6);
  CHECK(one.iterations_max == 1);
  CHECK(fifty.iterations_max == 50);
  CHECK(one.residual_max > 0.01);
  CHECK(one.residual_max > 3 * fifty.residual_max);

  const SolveTally rest = tally("{solver=sequential}", "contact-sweeps");  // swept until it is still
  CHECK(rest.converged > 0);
  CHECK(rest.iterations_max == 1000);  // too few while the forces build up
  CHECK(rest.residual_max < 0.01 * one.residual_max);
  const SolveTally direct = tally("{solver=direct}", "contact-newton");
  CHECK(direct.capped == 0);
  CHECK(direct.residual_max < 1e4 * 2.3e-16);
}

TEST_CASE("+impulse: simultaneous impacts of several balls keep angular momentum to round-off") {
  // Position correction does not keep it: it displaces bodies across their velocities. Balls that stay in contact
  // overlap, so it is off for them.
  std::mt19937 random(5);
  std::uniform_real_distribution<double> any(-1, 1);
  std::size_t met = 0;
  for (int k = 0; k < 60; ++k) {
    std::vector<Body> bodies;
    for (int i = 0; i < 4; ++i) {  // from the corners of a square to its middle
      const double x = i % 2 == 0 ? 1 : -1, y = i / 2 == 0 ? 1 : -1;
      bodies.push_back(ball("b" + std::to_string(i), 1.5 + any(random), 0.4,
                            {x + 0.1 * any(random), y + 0.1 * any(random), 0.1 * any(random)},
                            {-x, -y, 0.1 * any(random)}, {any(random), any(random), any(random)}));
    }
    const Scene scene = scene_of(bodies, k % 3 == 0 ? 0 : k % 3 == 1 ? 1 : 0.5, k % 2 == 0 ? 0 : 0.4);
    const Recorded r = run(k % 3 == 0 ? euler + "{correction=0}" : euler, scene, {2, 60, 20});
    met += r.events.size();
    INFO(k);
    const Total start = total(scene, r.samples.front());
    double before = start.energy;
    for (const Sample& s : r.samples) {
      const Total now = total(scene, s);
      for (int c = 0; c < 3; ++c) {
        CHECK(std::abs(now.P[c] - start.P[c]) < 1e-12);
        CHECK(std::abs(now.L[c] - start.L[c]) < 1e-12);
      }
      CHECK(now.energy < before + 1e-12);
      before = now.energy;
    }
  }
  CHECK(met > 100);
}

TEST_CASE("+impulse: an isolated impact ends where straight flight and the closed form put it, at any step") {
  for (const int steps : {3, 10, 64}) {
    const Scene scene =
        scene_of({ball("a", 1, 0.5, {-2, 0, 0}, {2, 0, 0}), ball("b", 3, 0.5, {0, 0, 0}, {0, 0, 0})}, 0.5, 0);
    const Recorded r = run(euler, scene, {2, steps, 1});
    REQUIRE(r.events.size() == 1);
    // They touch at 0.5 s; J = (1 + e) 2 / (1 + 1/3)
    const double J = 1.5 * 2 / (4.0 / 3), a = 2 - J, b = J / 3;
    CHECK(static_cast<double>(r.events[0].t_s) == Approx(0.5).epsilon(1e-14));
    CHECK(static_cast<double>(r.samples[1].bodies[0].p_m[0]) == Approx(-1 + 1.5 * a).epsilon(1e-13));
    CHECK(static_cast<double>(r.samples[1].bodies[1].p_m[0]) == Approx(1.5 * b).epsilon(1e-13));
  }
}

TEST_CASE("+impulse: elastic balls in a heap never gain energy, and a touching cradle transfers it to the last ball") {
  const Scene heap = catalogue("elastic-216");
  const Recorded r = run(euler, heap, {1, 240, 60});
  double before = total(heap, r.samples[0]).energy;
  for (const Sample& s : r.samples) {
    const double now = total(heap, s).energy;
    CHECK(now <= before * (1 + 1e-13));
    before = now;
  }
  const Scene cradle = catalogue("cradle-touching-1");
  const Recorded c = run(euler, cradle, {1, 240, 1});
  const Total start = total(cradle, c.samples[0]), end = total(cradle, c.samples[1]);
  CHECK(end.energy == Approx(start.energy).epsilon(1e-13));
  CHECK(static_cast<double>(c.samples[1].bodies[4].v_m_per_s[0]) ==
        Approx(start.P[0] / cradle.bodies[4].mass_kg).epsilon(1e-13));
}

TEST_CASE("+impulse: friction stays inside the round cone, whatever its direction") {
  const Scene scene = catalogue("pile-216");
  for (const char* solver : {"sequential", "auto"}) {
    const Recorded r = run(euler + "{substeps=1,solver=" + solver + "}", scene, {1, 240, 10});
    int loaded = 0;
    for (const Sample& s : r.samples)
      for (const ContactSample& c : s.contacts) {
        ++loaded;
        const double t = std::sqrt(c.force_t_N[0] * c.force_t_N[0] + c.force_t_N[1] * c.force_t_N[1] +
                                   c.force_t_N[2] * c.force_t_N[2]);
        CHECK(t <= 0.5 * c.force_n_N * (1 + 1e-10));
      }
    CHECK(loaded > 200);
  }
}

TEST_CASE("+impulse: a box slides straight, with mu g, in any direction of the plane") {
  for (const char* solver : {"sequential", "direct"})
    for (const double angle : {0.0, 0.3, 0.785398, 1.2}) {
      Body slab = box("slab", 2, {0.5, 0.5, 0.05}, {0, 0, 0.05});
      slab.velocity_m_per_s = {2 * std::cos(angle), 2 * std::sin(angle), 0};
      const Scene scene = scene_of({floor_plane(), slab}, 0, 0.4, 10);
      const Recorded r = run(euler + "{iterations=40,solver=" + solver + "}", scene, {0.25, 60, 1});
      const auto& v = r.samples[1].bodies[1].v_m_per_s;
      INFO(solver << " " << angle);
      CHECK(static_cast<double>(v[0]) == Approx(std::cos(angle)).margin(1e-5));
      CHECK(static_cast<double>(v[1]) == Approx(std::sin(angle)).margin(1e-5));
    }
}

TEST_CASE("+impulse: a ball on a sliding slab and a cylinder on a slope roll by Newton's and Euler's equations") {
  const Scene slab = catalogue("friction-cone-60");
  for (const int steps : {60, 240}) {
    const Recorded r = run(euler, slab, {1, steps, 1});
    const auto speed = [&](std::size_t i) {
      const auto& v = r.samples[1].bodies[i].v_m_per_s;
      CHECK(static_cast<double>(v[1]) ==
            Approx(std::sqrt(3.0) * static_cast<double>(v[0])).epsilon(1e-10));  // 60 degrees
      return std::hypot(static_cast<double>(v[0]), static_cast<double>(v[1]));
    };
    // each of 25 balls of 1 kg adds 2/7 of its mass to the slab's inertia
    const double push = 150 - 0.4 * 35 * 9.81, slab_a = push / (10 + 25 / 3.5);
    CHECK(speed(0) == Approx(slab_a).epsilon(1e-10));
    for (std::size_t i = 1; i <= 25; ++i) CHECK(speed(i) == Approx(slab_a / 3.5).epsilon(1e-10));
  }
  const Scene cylinder = catalogue("roll-cylinder");
  const Recorded r = run(euler, cylinder, {1, 60, 1});
  const auto& end = r.samples[1].bodies[0].v_m_per_s;
  const double speed = std::sqrt(static_cast<double>(end[0] * end[0] + end[1] * end[1] + end[2] * end[2]));
  CHECK(speed == Approx(9.81 * 0.5 / 1.5).epsilon(1e-10));  // g sin 30 / (1 + 1/2), for a second
}

TEST_CASE("+impulse: a stack, a house of cards and a wall stand still, at a long step too") {
  for (const char* id : {"stack-10", "card-house", "wall"})
    for (const int steps : {60, 240}) {
      const Scene scene = catalogue(id);
      const Recorded r = run(euler, scene, {1, steps, 10});
      INFO(id << " " << steps);
      CHECK(farthest_moved(r, scene) < 1e-6);  // a stack drifts only in the first second, while contact forces build up
    }
}

TEST_CASE("+impulse: an impact within a substep acts on the contacts around it") {
  for (const auto& [id, steps] : {std::pair{"cradle-touching-3", 480}, std::pair{"cradle-unequal-apart", 60}}) {
    const Scenario scenario = testing::catalogued(id);
    const Recorded r = run(euler, scenario.scene, {scenario.t_end_s, steps, 1});
    INFO(id);
    CHECK(total(scenario.scene, r.samples[1]).energy ==
          Approx(total(scenario.scene, r.samples[0]).energy).epsilon(1e-12));
  }
}

TEST_CASE("+impulse: solver=direct refuses what is too large for it") {
  const Recorded r = try_run(euler + "{solver=direct}", catalogue("wall"), {1, 60, 1});
  CHECK(r.outcome.status == Status::unsupported);
  CHECK(r.outcome.reason.find("direct_points") != std::string::npos);
}

TEST_CASE("+impulse: position correction removes overlap and gives no velocity") {
  // Two balls overlap at the start and no force acts: they are moved apart, and have no velocity afterwards.
  const Scene inside = scene_of({ball("a", 1, 0.5, {0, 0, 0}, {}), ball("b", 1, 0.5, {0.9, 0, 0}, {})}, 0, 0);
  for (const char* solver : {"sequential", "direct"}) {
    const Recorded r = run(euler + "{solver=" + solver + "}", inside, {1, 240, 1});
    const auto& a = r.samples[1].bodies[0];
    const auto& b = r.samples[1].bodies[1];
    CHECK(static_cast<double>(b.p_m[0] - a.p_m[0]) > 0.999);
    CHECK(static_cast<double>(b.p_m[0] - a.p_m[0]) < 1.0);
    CHECK(static_cast<double>(b.v_m_per_s[0]) == 0);
    CHECK(static_cast<double>(a.v_m_per_s[0]) == 0);
  }
}

TEST_CASE("+impulse: the same bits for any number of threads, again and again") {
  for (const char* id : {"settling-1000", "settling-boxes-100"}) {
    const Scene scene = catalogue(id);
    const Plan plan{0.5, 60, 2};
    const Recorded one = run(euler, scene, plan);
    for (const char* threads : {"{threads=1}", "{threads=2}", "{threads=3}"}) {
      const Recorded other = run(euler + threads, scene, plan);
      INFO(id << threads);
      CHECK(same_bits(one.samples.back(), other.samples.back()));
      // how the sweeps ended is measured over all bodies, by shares of them
      const SolveTally &swept = one.outcome.solvers.at("contact-sweeps"),
                       &by_shares = other.outcome.solvers.at("contact-sweeps");
      CHECK(swept.residual_max == by_shares.residual_max);
    }
  }
}

TEST_CASE("+impulse: Newton on all contacts and sweeps to convergence agree") {
  std::vector<Body> bodies{floor_plane(), ball("a", 2, 0.5, {0, 0, 0.5}, {1, 0.3, 0}, {0, 2, 1}),
                           ball("b", 1, 0.25, {2, 0, 0.25}, {-1, 0, 0})};
  const Scene scene = scene_of(bodies, 0, 0.3, 9.81);
  const Recorded direct = run(euler + "{solver=direct}", scene, {1, 240, 1});
  const Recorded swept = run(euler + "{solver=sequential,iterations=200}", scene, {1, 240, 1});
  for (int i : {1, 2})
    for (int c = 0; c < 3; ++c)
      CHECK(static_cast<double>(direct.samples[1].bodies[i].p_m[c]) ==
            Approx(static_cast<double>(swept.samples[1].bodies[i].p_m[c])).margin(1e-9));
}

TEST_CASE("+impulse: exchanging the bodies or rotating the world changes a collision by round-off alone") {
  const Body a = ball("a", 1, 0.5, {-2, 0.3, 0.1}, {2, 0, 0}, {1, 2, 3}),
             b = ball("b", 3, 0.4, {0, 0, 0}, {0.1, 0.2, -0.3});
  const Recorded straight = run(euler, scene_of({a, b}, 0.6, 0.3), {2, 30, 1});
  const Recorded swapped = run(euler, scene_of({b, a}, 0.6, 0.3), {2, 30, 1});
  for (int c = 0; c < 3; ++c)
    CHECK(static_cast<double>(straight.samples[1].bodies[0].v_m_per_s[c]) ==
          Approx(static_cast<double>(swapped.samples[1].bodies[1].v_m_per_s[c])).margin(1e-14));
  const auto turn = [](Body body) {  // by 90 degrees twice about other axes: x -> y -> z -> x
    const auto cycle = [](Real3& v) { v = {v[2], v[0], v[1]}; };
    cycle(body.position_m);
    cycle(body.velocity_m_per_s);
    cycle(body.angular_velocity_body_rad_per_s);
    return body;
  };
  const Recorded turned = run(euler, scene_of({turn(a), turn(b)}, 0.6, 0.3), {2, 30, 1});
  for (int i : {0, 1})
    for (int c = 0; c < 3; ++c)
      CHECK(static_cast<double>(straight.samples[1].bodies[i].v_m_per_s[c]) ==
            Approx(static_cast<double>(turned.samples[1].bodies[i].v_m_per_s[(c + 1) % 3])).margin(1e-14));
}

TEST_CASE("+impulse: between contacts other schemes take their own steps") {
  const Scene scene = scene_of({floor_plane(), ball("a", 1, 0.1, {0, 0, 1}, {3, 0, 0})}, 0, 0, 9.81);
  const Recorded flying = run("atwood/rk4+impulse", scene, {0.25, 10, 1});
  CHECK(static_cast<double>(flying.samples[1].bodies[1].p_m[2]) == Approx(1 - 9.81 * 0.25 * 0.25 / 2).epsilon(1e-14));
  const Recorded lying =
      run("atwood/rk4+impulse", scene_of({floor_plane(), ball("a", 1, 0.1, {0, 0, 0.1}, {})}, 0, 0, 9.81), {2, 480, 1});
  CHECK(std::abs(static_cast<double>(lying.samples[1].bodies[1].p_m[2]) - 0.1) < 1e-13);
}

TEST_CASE("+impulse: the force of a resting contact is reported, and the impact that began it") {
  const Scene scene = scene_of({floor_plane(), ball("a", 2, 0.1, {0, 0, 0.3}, {})}, 0, 0.5, 10);
  const Recorded r = run(euler, scene, {1, 240, 2});
  REQUIRE(r.samples.back().contacts.size() == 1);
  CHECK(r.samples.back().contacts[0].force_n_N == Approx(20).epsilon(1e-10));
  CHECK(r.samples.back().contacts[0].body_a == 0);
  CHECK(r.samples.back().contacts[0].normal[2] == Approx(1));
  REQUIRE(r.events.size() == 1);
  CHECK(static_cast<double>(r.events[0].vn_before_m_per_s) == Approx(-2).epsilon(0.03));
}
