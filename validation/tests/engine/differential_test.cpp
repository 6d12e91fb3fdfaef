// The engine's rates against the reference's, which share no code with them, at random states: in quad to a few of its
// ulp (the same laws), in double to a few of its own (the same arithmetic quality).
#include <catch2/catch.hpp>
#include <random>

#include "dynamics/rates.hpp"
#include "scenes.hpp"

namespace atwood::testing {
namespace {

std::mt19937_64 dice(20);
double draw() { return std::uniform_real_distribution<double>(-1, 1)(dice); }
Real3 draw3() { return {draw(), draw(), draw()}; }

Scene points_in_fields() {
  Scene scene = empty_scene();
  scene.gravity_m_per_s2 = draw3();
  for (int i = 0; i < 4; ++i) {
    scene.bodies.push_back(point("p" + std::to_string(i), 1.5 + draw(), draw3(), draw3()));
    scene.bodies[i].charge_C = draw();
  }
  scene.bodies[3].fixed = true;
  const std::vector<int> all{0, 1, 2, 3}, moving{0, 1, 2};
  scene.forces = {MutualGravity{all, 0.7, 0.1},
                  Attractor{moving, draw3(), 1.3},
                  Coulomb{all, 0.9},
                  Lorentz{moving, draw3(), draw3()},
                  RotatingFrame{draw3()},
                  Potential{moving, "henon-heiles", {{"lambda", 0.8}}},
                  Drive{moving, draw3(), 1.7, 0.4}};
  return scene;
}

Scene turning_bodies() {
  Scene scene = empty_scene();
  scene.gravity_m_per_s2 = draw3();
  for (int i = 0; i < 3; ++i) {
    Body body = box({0.6, 0.8, 1.0}, draw3());
    body.name = "b" + std::to_string(i);
    body.mass_kg = 1.5 + draw();
    body.position_m = draw3();
    body.velocity_m_per_s = draw3();
    body.inertia_kg_m2 = {0.6, 0.02, 0.01, 0.02, 0.8, -0.03, 0.01, -0.03, 1.0};
    scene.bodies.push_back(body);
  }
  LinearDrag linear{{0, 1}, 0.4, draw3(), 0.2};
  QuadraticDrag quadratic{{1, 2}, 1.2, 0.5, 0.3, draw3(), 0.1};
  Spring between{{0, 1}, {}, 5, 0.3, 0.7, {draw3(), draw3()}};
  Spring anchored{{2}, draw3(), 4, 0.2, 0, {draw3()}};
  scene.forces = {linear,
                  quadratic,
                  between,
                  anchored,
                  Thruster{0, draw3(), {0, 0.6, 0.8}, 2, {{0, 1}}},
                  Thruster{1, draw3(), {1, 0, 0}, 2, {{1, 2}}},
                  PointForce{2, draw3(), draw3(), {}}};
  return scene;
}

// Both rates as samples: velocities and attitude rates of every body, in quad.
template <class S, class R> double largest_difference(const Scene& scene, double t_s) {
  RigidModel<S> model(scene);
  REQUIRE(model.unsupported().empty());
  model.select_interval(S(t_s), S(t_s));
  std::vector<S> y(model.state_size()), rate(model.state_size());
  model.initial_state(y.data());
  model.system().rate(S(t_s), y.data(), rate.data());

  const dynamics::Dynamics<R> reference(scene, 10);
  const dynamics::Layout& layout = reference.layout();
  const std::vector<R> z = dynamics::pack<R>(scene);
  std::vector<R> z_rate(z.size());
  reference.rate(R(t_s), z.data(), z_rate.data(), reference.interval_at(t_s));

  double worst = 0;
  const auto compare = [&](int ours, int theirs, int count) {
    for (int k = 0; k < count; ++k)
      worst = std::max(worst, std::fabs(static_cast<double>(Wide(rate[ours + k]) - Wide(z_rate[theirs + k]))));
  };
  for (int i = 0; i < model.body_count(); ++i) {
    const dynamics::Slot& slot = layout.slots[i];
    REQUIRE((slot.position < 0) == (model.offset(i) < 0));
    if (slot.position < 0) continue;
    compare(model.offset(i) + kAtPosition, slot.position, 3);
    compare(model.offset(i) + kAtVelocity, slot.velocity, 3);
    if (slot.attitude < 0) continue;
    compare(model.offset(i) + kAtAttitude, slot.attitude, 4);
    compare(model.offset(i) + kAtBodyRate, slot.rate, 3);
  }
  return worst;
}

TEST_CASE("engine and reference agree on every force, at random states") {
  for (int round = 0; round < 200; ++round)
    for (const Scene& scene : {points_in_fields(), turning_bodies()})
      for (const double t_s : {0.5, 1.5}) {
        // Rates are of order 10, up to 1e3 at close encounters.
        CHECK(largest_difference<Quad, Wide>(scene, t_s) < 1e-28);
        CHECK(largest_difference<double, Wide>(scene, t_s) < 1e-11);
      }
}

}  // namespace
}  // namespace atwood::testing
