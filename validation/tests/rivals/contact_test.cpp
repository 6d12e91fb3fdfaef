// Contacts: the scene's pair law, exactly, and what each preset makes of a bounce.
#include <catch2/catch.hpp>

#include "under_test.hpp"

namespace atwood::test {
namespace {

// Two materials whose product, mean and maximum all differ from the pair's own law.
Scene with_pair_law(Scene scene, double restitution, double friction) {
  scene.materials = {Material{"wood", 0.9, 0.5, 0}, Material{"steel", 0.8, 0.9, 0}};
  scene.pairs = {PairLaw{0, 0, 0.9, 0.5, 0}, PairLaw{0, 1, restitution, friction, 0}, PairLaw{1, 1, 0.8, 0.9, 0}};
  scene.bodies[1].material = 1;
  return scene;
}

double worst_bounce(const Engine& engine, const MethodId& id) {
  double worst = 0;
  for (const double h0_m : {0.1, 0.25, 0.5, 1.0, 1.3}) {
    const Run result = run(engine, id, bounce(0.8, h0_m), Plan{5, 1200, 1200});
    REQUIRE(result.outcome.status == Status::ok);
    worst = std::max(worst, worst_apex_error(result.samples, 1, 0.1, 0.8, h0_m));
  }
  return worst;
}

Scene sliding(double friction, const Real3& v) {
  Scene scene = with_pair_law(bounce(0, 0), 0, friction);
  scene.bodies[1].velocity_m_per_s = v;
  return scene;
}

}  // namespace

TEST_CASE(
    "its sharpest settings beat the default tenfold on bouncing, in Bullet; ODE stays within its step; tuned is no worse") {
  const Engine engine = engine_under_test();
  if (!bounces(engine) || engine.name == "dart") return;  // DART's law of a bounce: dart_test
  const double plain = worst_bounce(engine, method(engine, "default")), sharp = worst_bounce(engine, sharpest(engine)),
               tuned = worst_bounce(engine, method(engine, "tuned"));
  INFO("worst of five apexes, default " << plain << ", tuned " << tuned << ", sharpest " << sharp);
  if (is_bullet(engine)) {
    CHECK(sharp < 0.1 * plain);
    CHECK(sharp < 0.02);
  } else {
    CHECK(plain < 0.15);  // the impact is seen up to a step late
    CHECK(sharp <= plain);
  }
  CHECK(tuned <= plain * (1 + 1e-12));  // ODE's tuned solver differs in the last bit
  CHECK(sharp > 1e-6);  // a fixed-step impact can't be exact: an error of zero would mean that we measure nothing
}

TEST_CASE("restitution is the pair's, not a product of the bodies'") {
  const Engine engine = engine_under_test();
  if (!bounces(engine)) return;
  for (const double e : {0.0, 0.6, 1.0}) {
    for (const double m2_kg : {1.0, 3.0}) {
      const Run result = run(engine, sharpest(engine), with_pair_law(head_on(0, 1, m2_kg), e, 0), Plan{2, 480, 48});
      REQUIRE(result.outcome.status == Status::ok);
      const double margin = in_float(engine) ? 1e-5 : 1e-7;
      CHECK(result.v(1, 0) - result.v(0, 0) == Approx(e * 1.5).margin(margin));
      CHECK(result.v(0, 0) + m2_kg * result.v(1, 0) == Approx(1 - 0.5 * m2_kg).margin(margin));
      REQUIRE(result.events.size() == 1);
      const Event& impact = result.events[0];
      CHECK(static_cast<double>(impact.t_s) == Approx(0.8 / 1.5).margin(2.0 / 240));
      CHECK(impact.body_a == 0);
      CHECK(impact.body_b == 1);
      CHECK(static_cast<double>(impact.normal[0]) == Approx(1));
      CHECK(static_cast<double>(impact.impulse_n_N_s) == Approx((1 + e) * 1.5 * m2_kg / (1 + m2_kg)).epsilon(1e-5));
      CHECK(static_cast<double>(impact.vn_before_m_per_s) == Approx(-1.5).epsilon(1e-5));
    }
  }
}

TEST_CASE("the order of the bodies in the scene doesn't matter to the event's normal") {
  const Engine engine = engine_under_test();
  Scene scene = head_on(bounces(engine) ? 0.5 : 0, 1, 3);
  std::swap(scene.bodies[0], scene.bodies[1]);
  const Run result = run(engine, sharpest(engine), scene, Plan{2, 480, 48});
  REQUIRE(result.events.size() == 1);
  CHECK(static_cast<double>(result.events[0].normal[0]) == Approx(-1));
  CHECK(static_cast<double>(result.events[0].vn_before_m_per_s) < 0);
  if (bounces(engine)) CHECK(static_cast<double>(result.events[0].vn_after_m_per_s) > 0);
}

TEST_CASE("friction is the pair's, not a product of the bodies'") {
  // A ball that slides and does not yet roll: it loses v = mu (g t + v_z), mu times the impulse of the floor per mass
  // (v_z: how fast a soft floor moves it at the end), and gains w = 5/2 v / r. Rolling begins at 2 v0 / (7 mu g).
  const Engine engine = engine_under_test();
  const double mu = 0.3, t = 0.2, g = 9.81;
  const Run along_x = run(engine, method(engine, "default"), sliding(mu, {3, 0, 0}), Plan{t, 200, 10});
  REQUIRE(along_x.outcome.status == Status::ok);
  const double lost = mu * (g * t + along_x.v(1, 2));
  CHECK(3 - along_x.v(1, 0) == Approx(lost).epsilon(0.02));
  CHECK(along_x.w(1, 1) == Approx(2.5 * lost / 0.1).epsilon(0.02));
  // Off the axes, tuned: as strong, and straight against the slip.
  const double c = std::sqrt(0.5);
  const Run diagonal = run(engine, sharpest(engine), sliding(mu, {3 * c, 3 * c, 0}), Plan{t, 200, 10});
  CHECK(3 - std::hypot(diagonal.v(1, 0), diagonal.v(1, 1)) == Approx(mu * (g * t + diagonal.v(1, 2))).epsilon(0.02));
  CHECK(diagonal.v(1, 0) == Approx(diagonal.v(1, 1)).epsilon(1e-3));
}

TEST_CASE("a smooth pair passes no spin on") {
  const Engine engine = engine_under_test();
  Scene scene = with_pair_law(bounce(0, 0.3), bounces(engine) ? 0.8 : 0, 0);
  scene.bodies[1].velocity_m_per_s = {1, 0, 0};
  const Run result = run(engine, sharpest(engine), scene, Plan{1, 240, 24});
  CHECK(result.v(1, 0) == Approx(1).epsilon(1e-6));
  CHECK(result.w(1, 1) == Approx(0).margin(1e-6));
}

TEST_CASE("an oblique impact follows the line of centres") {
  // Equal spheres, offset half a radius sum: n = (cos 30, sin 30) at touch. Only the normal parts are exchanged.
  const Engine engine = engine_under_test();
  if (!bounces(engine)) return;
  Scene scene = head_on(0, 1, 1);
  scene.pairs[0].restitution = 1;
  scene.bodies[0].position_m = {-0.5, 0, 0};
  scene.bodies[1].position_m = {0.2, 0.1, 0};
  scene.bodies[0].velocity_m_per_s = {1, 0, 0};
  scene.bodies[1].velocity_m_per_s = {0, 0, 0};
  const Run result = run(engine, sharpest(engine), scene, Plan{2, 8000, 20});
  CHECK(result.v(1, 0) == Approx(0.75).epsilon(5e-3));
  CHECK(result.v(1, 1) == Approx(0.75 * std::tan(std::asin(0.5))).epsilon(5e-3));
  CHECK(result.v(0, 0) == Approx(0.25).epsilon(5e-3));
}

TEST_CASE("the contacts that samples tell of account for all change of momentum") {
  // A box dropped flat by a hair slides along x and y at once. Sampled every step, the pushes of the floor on whichever
  // body comes second in the scene sum up to the change of the box's momentum, and their moments to that of its spin.
  const Engine engine = engine_under_test();
  const double mu = 0.3, g = 9.81, m_kg = 2, c = std::sqrt(0.5), t_end_s = 0.25, i_kg_m2 = m_kg * 0.17 / 12;
  const std::int64_t steps = 240;
  for (const bool floor_first : {true, false}) {
    Scene scene = with_pair_law(bounce(0, 0), 0, mu);
    Body& box = scene.bodies[1];
    box.shape = Box{{0.2, 0.2, 0.05}};
    box.mass_kg = m_kg;
    box.inertia_kg_m2 = {i_kg_m2, 0, 0, 0, i_kg_m2, 0, 0, 0, m_kg * 0.32 / 12};
    box.position_m = {0, 0, 0.051};
    box.velocity_m_per_s = {3 * c, 2 * c, 0};
    if (!floor_first) std::swap(scene.bodies[0], scene.bodies[1]);
    const int moving = floor_first ? 1 : 0;
    const Run result = run(engine, engine.name == "mujoco" ? method(engine, "implicit") : sharpest(engine), scene,
                           Plan{t_end_s, steps, steps});
    REQUIRE(result.outcome.status == Status::ok);
    CHECK(result.samples.front().contacts.empty());
    const double sign = floor_first ? 1 : -1, h_s = t_end_s / steps;
    Real3 momentum{0, 0, -m_kg * g * t_end_s}, spin{};
    double friction = 0, load = 0, deepest = 0;
    for (std::size_t n = 1; n < result.samples.size(); ++n) {
      for (const auto& contact : result.samples[n].contacts) {
        CHECK(contact.body_a == 0);
        CHECK(contact.body_b == 1);
        CHECK(contact.normal[2] == Approx(sign).epsilon(1e-3));
        CHECK(contact.force_n_N >= 0);
        deepest = std::max(deepest, std::abs(contact.gap_m));
        Real3 f{}, r{};
        for (int k = 0; k < 3; ++k) {
          f[k] = sign * (contact.force_n_N * contact.normal[k] + contact.force_t_N[k]);
          r[k] = contact.x_m[k] - static_cast<double>(result.samples[n - 1].bodies[moving].p_m[k]);
          momentum[k] += h_s * f[k];
        }
        spin[0] += h_s * (r[1] * f[2] - r[2] * f[1]);
        spin[1] += h_s * (r[2] * f[0] - r[0] * f[2]);
        friction += std::hypot(contact.force_t_N[0], contact.force_t_N[1]);
        load += contact.force_n_N;
      }
    }
    const double margin = in_float(engine) ? 1e-4 : 1e-9;
    const Real3 v0{3 * c, 2 * c, 0};
    for (int k = 0; k < 3; ++k) CHECK(momentum[k] == Approx(m_kg * (result.v(moving, k) - v0[k])).margin(margin));
    for (int k = 0; k < 2; ++k) CHECK(spin[k] == Approx(i_kg_m2 * result.w(moving, k)).margin(0.02));
    CHECK(friction / load == Approx(mu).epsilon(engine.name == "mujoco" ? 0.35 : 0.05));  // a pyramid, off its axes
    CHECK(deepest < 2e-3);
    CHECK(deepest > 0);
  }
}

}  // namespace atwood::test
