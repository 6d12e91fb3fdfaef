// Compliant contacts: bounces and sliding compared with formulas, the restitution that results, refusals.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>

#include "contact/penalty_force.hpp"
#include "simulation.hpp"
#include "validation/tests/recorded.hpp"

using namespace atwood;

namespace {

// A ball of 2 kg and radius 1/4 that flies at 3 m/s into a plane, without gravity.
Scene into_plane(PairLaw law) {
  Scene scene;
  scene.materials = {{"all", law.restitution, law.friction, 0}};
  scene.pairs = {law};
  Body floor, ball;
  floor.name = "floor";
  floor.fixed = true;
  floor.shape = Plane{};
  ball.name = "ball";
  ball.mass_kg = 2;
  ball.inertia_kg_m2 = {0.05, 0, 0, 0, 0.05, 0, 0, 0, 0.05};
  ball.shape = Sphere{0.25};
  ball.position_m = {0, 0, 0.35};
  ball.velocity_m_per_s = {0, 0, -3};
  scene.bodies = {floor, ball};
  return scene;
}

PairLaw linear(double k, double c, bool pull) {
  PairLaw law;
  law.contact_law = ContactLaw::linear;
  law.stiffness_N_per_m = k;
  law.damping_N_s_per_m = c;
  law.pull = pull;
  return law;
}

using testing::Recorded;

// Whatever the outcome's status: for tests of a refusal.
Recorded try_run(const std::string& method, const Scene& scene, double t_end_s, std::int64_t steps,
                 std::int64_t samples = 1) {
  return testing::record(atwood_engine().run, parse_method_id(method), scene, {t_end_s, steps, samples});
}

// The test fails here unless the run ended ok with all its samples.
Recorded run(const std::string& method, const Scene& scene, double t_end_s, std::int64_t steps,
             std::int64_t samples = 1) {
  Recorded ran = try_run(method, scene, t_end_s, steps, samples);
  testing::require_whole(ran, method, {t_end_s, steps, samples});
  return ran;
}
double vz(const Recorded& ran) { return static_cast<double>(ran.samples.back().bodies[1].v_m_per_s[2]); }
double z(const Sample& s) { return static_cast<double>(s.bodies[1].p_m[2]); }

}  // namespace

TEST_CASE("a linear contact: restitution and duration by the damped oscillator's formulas") {
  const double k = 2e5, m = 2, w = std::sqrt(k / m);
  for (const double ratio : {0.05, 0.3, 0.8}) {
    const double s = std::sqrt(1 - ratio * ratio), c = 2 * ratio * w * m;
    for (const bool pull : {true, false}) {
      const double e = pull ? std::exp(-M_PI * ratio / s) : std::exp(-2 * ratio * std::acos(ratio) / s);
      const Recorded ran = run("atwood/rk4+penalty", into_plane(linear(k, c, pull)), 0.1, 20000, 10);
      INFO("damping ratio " << ratio << (pull ? ", pulls" : ""));
      // The dashpot's force sets in with a jump, somewhere within a step: of its impulse a step's worth may be missed.
      CHECK(vz(ran) == Approx(3 * e).margin(2 * ratio * w * 5e-6 * 3));
      REQUIRE(ran.events.size() == 1);
      CHECK(static_cast<double>(ran.events[0].t_s) == Approx(0.1 / 3).epsilon(1e-6));
      CHECK(static_cast<double>(ran.events[0].impulse_n_N_s) == Approx(2 * 3 * (1 + e)).epsilon(1e-3));
      // It leaves the plane at speed 3 e after it has given way for pi / w_d, or (unable to pull) at the end of the
      // force.
      const double touch = 0.1 / 3, height = z(ran.samples.back()) - 0.25;
      const double given_way = 0.1 - touch - height / (3 * e);
      if (pull) CHECK(given_way == Approx(M_PI / (w * s)).epsilon(2e-3));
    }
  }
}

TEST_CASE("Hertz: an impact without damping sinks in by (5 m v^2 / 4 K)^(2/5) and loses nothing") {
  PairLaw law;
  law.contact_law = ContactLaw::hertz;
  law.modulus_Pa = 1e7;
  const double K = 4.0 / 3 * 1e7 * std::sqrt(0.25), deepest = std::pow(1.25 * 2 * 9 / K, 0.4);
  const Recorded ran = run("atwood/rk4+penalty", into_plane(law), 0.1, 40000, 20000);
  double lowest = 1;
  for (const Sample& s : ran.samples) lowest = std::min(lowest, z(s));
  CHECK(0.25 - lowest == Approx(deepest).epsilon(1e-6));
  CHECK(vz(ran) == Approx(3).epsilon(1e-9));
  law.damping_s_per_m = 0.1;
  CHECK(vz(run("atwood/rk4+penalty", into_plane(law), 0.1, 4000)) < 2.9);
}

TEST_CASE("a rigid pair's restitution comes out, and the overlap that was wanted") {
  for (const double e : {1.0, 0.8, 0.3, 0.05}) {
    PairLaw law;
    law.restitution = e;
    const Recorded ran = run("atwood/rk4+penalty{overlap=0.01}", into_plane(law), 0.1, 50000, 25000);
    INFO(e << " " << ran.outcome.reason);
    CHECK(vz(ran) ==
          Approx(3 * e).margin(2 * damping_ratio_of(e) * 2400 * 2e-6 * 3 + 1e-9));  // as above, w = 6 / (0.01 0.25)
    double lowest = 1;
    for (const Sample& s : ran.samples) lowest = std::min(lowest, z(s));
    if (e == 1) CHECK(0.25 - lowest == Approx(0.01 * 0.25 / 2).epsilon(1e-4));  // the scene's speed is twice 3 m/s
    else CHECK(0.25 - lowest < 0.01 * 0.25);
  }
  CHECK(damping_ratio_of(1) == 0);
  CHECK(damping_ratio_of(std::exp(-2)) == Approx(1).epsilon(1e-5));
}

TEST_CASE("sliding friction slows by mu g, and the tangential spring holds on a slope") {
  PairLaw law = linear(2e5, 200, false);
  law.friction = 0.4;
  Scene scene = into_plane(law);
  scene.gravity_m_per_s2 = {0, 0, -10};
  scene.bodies[1].position_m = {0, 0, 0.25 - 2 * 10 / 2e5};  // where the spring carries its weight
  scene.bodies[1].velocity_m_per_s = {2, 0, 0};
  // 5/7 of 2 m/s when it rolls, after 2 / (3.5 mu g) seconds; a ball has no static hold, so the slope is for a box.
  const Recorded rolls = run("atwood/rk4+penalty", scene, 0.5, 20000, 10);
  const auto vx = [](const Sample& s) { return static_cast<double>(s.bodies[1].v_m_per_s[0]); };
  CHECK(vx(rolls.samples[2]) == Approx(2 - 0.4 * 10 * 0.1).epsilon(1e-3));
  CHECK(vx(rolls.samples[10]) == Approx(2 * 5.0 / 7).epsilon(1e-3));
  for (const ContactSample& c : rolls.samples[2].contacts)
    CHECK(c.force_t_N[0] == Approx(-0.4 * c.force_n_N).epsilon(1e-9));

  scene.bodies[1].shape = Box{{0.3, 0.3, 0.25}};
  scene.bodies[1].velocity_m_per_s = {0, 0, 0};
  scene.bodies[1].position_m = {0, 0, 0.25 - 2 * 10 / (4 * 2e5)};  // on four corners
  scene.gravity_m_per_s2 = {3, 0, -10};
  const Recorded holds = run("atwood/rk4+penalty", scene, 1, 20000, 10);
  CHECK(std::fabs(static_cast<double>(holds.samples.back().bodies[1].p_m[0])) < 1e-3);
  CHECK(std::fabs(vx(holds.samples.back())) < 1e-4);
  scene.gravity_m_per_s2 = {5, 0, -10};
  const Recorded slides = run("atwood/rk4+penalty", scene, 1, 20000, 10);
  CHECK(vx(slides.samples.back()) == Approx(5 - 4).epsilon(1e-2));
}

TEST_CASE("any integrator steps it: partitioned, implicit, adaptive, multistep; energy kept where nothing is lost") {
  PairLaw law;
  law.restitution = 1;
  Scene scene = into_plane(law);
  for (const char* method : {"atwood/velocity-verlet+penalty", "atwood/symplectic-euler+penalty",
                             "atwood/dopri5:1e-9+penalty", "atwood/gauss4+penalty", "atwood/adams-bashforth4+penalty",
                             "atwood/leapfrog+penalty", "atwood/rk4+penalty@long-double"}) {
    const Recorded ran = run(method, scene, 0.1, 20000);
    INFO(method << ": " << ran.outcome.reason);
    CHECK(vz(ran) == Approx(3).epsilon(2e-3));
  }
}

TEST_CASE("a step beyond the stability limit is refused with the limit; so is a contact without a spring") {
  PairLaw law;
  law.restitution = 0.9;
  const Scene scene = into_plane(law);
  const Recorded coarse = try_run("atwood/velocity-verlet+penalty", scene, 0.1, 10);
  CHECK(coarse.outcome.status == Status::unsupported);
  CHECK(coarse.outcome.reason.find("beyond the stability limit of atwood/velocity-verlet") != std::string::npos);
  // k / m = (6 m/s / 0.25 mm)^2: Verlet's limit is 2 / w, a little less with the damping of e = 0.9.
  CHECK(coarse.outcome.reason.find("(24000 rad/s)") != std::string::npos);
  // No step is too long for implicit Euler; its equations may still have no solution that it finds across the onset.
  CHECK(try_run("atwood/implicit-euler+penalty", scene, 0.1, 100).outcome.reason.find("stability") ==
        std::string::npos);

  Scene inelastic = scene;
  inelastic.pairs[0].restitution = 0;
  CHECK(try_run("atwood/rk4+penalty", inelastic, 0.1, 20000).outcome.reason.find("cannot have a restitution of 0") !=
        std::string::npos);
  run("atwood/rk4+penalty{damping_ratio=1}", inelastic, 0.1, 20000);
  const Recorded series = try_run("atwood/taylor+penalty", scene, 0.1, 20000);
  CHECK(series.outcome.status == Status::unsupported);
  INFO(series.outcome.reason);
  CHECK(series.outcome.reason.find("contact forces") != std::string::npos);
  Scene still = scene;
  still.bodies[1].velocity_m_per_s = {0, 0, 0};
  CHECK(try_run("atwood/rk4+penalty", still, 0.1, 20000).outcome.reason.find("impact_speed_m_per_s") !=
        std::string::npos);
}

TEST_CASE("momentum of two balls passes over to round-off, spin and friction with it") {
  PairLaw law;
  law.restitution = 0.7;
  law.friction = 0.3;
  Scene scene = into_plane(law);
  scene.bodies[0] = scene.bodies[1];
  scene.bodies[0].name = "other";
  scene.bodies[0].position_m = {0.1, 0.05, -0.2};
  scene.bodies[0].velocity_m_per_s = {0, 0, 0};
  scene.bodies[0].angular_velocity_body_rad_per_s = {3, -4, 5};
  const Recorded ran = run("atwood/rk4+penalty", scene, 0.1, 20000);
  Wide p[3] = {0, 0, 0}, L[3] = {0, 0, 0}, p0[3] = {0, 0, -6}, L0[3] = {0.05 * 3, 0.05 * -4, 0.05 * 5};
  for (const BodySample& b : ran.samples.back().bodies) {
    const auto &x = b.p_m, &v = b.v_m_per_s;
    const auto& q = b.q_wxyz;
    const Wide u[3] = {q[1], q[2], q[3]};
    const auto cross = [](const Wide* a, const Wide* c, int i) {
      return a[(i + 1) % 3] * c[(i + 2) % 3] - a[(i + 2) % 3] * c[(i + 1) % 3];
    };
    const Wide* w = b.w_rad_per_s.data();
    Wide c[3], cc[3];
    for (int i = 0; i < 3; ++i) c[i] = cross(u, w, i);
    for (int i = 0; i < 3; ++i) cc[i] = cross(u, c, i);
    for (int i = 0; i < 3; ++i) {
      p[i] += 2 * v[i];
      L[i] += 2 * cross(x.data(), v.data(), i) + Wide(0.05) * (w[i] + 2 * (q[0] * c[i] + cc[i]));
    }
  }
  for (int i = 0; i < 3; ++i) {
    CHECK(static_cast<double>(p[i]) == Approx(static_cast<double>(p0[i])).margin(1e-11));
    CHECK(static_cast<double>(L[i]) == Approx(static_cast<double>(L0[i])).margin(1e-9));
  }
}

TEST_CASE("+penalty refuses a convention for simultaneous impacts, unless the scene says how its pairs give way") {
  PairLaw law;
  law.restitution = 0.5;
  Scene scene = into_plane(law);
  run("atwood/rk4+penalty", scene, 0.001, 2000);
  scene.simultaneous_impacts = SimultaneousImpacts::sequential;
  const Recorded refused = try_run("atwood/rk4+penalty", scene, 0.001, 2000);
  CHECK(refused.outcome.status == Status::unsupported);
  CHECK(refused.outcome.reason.find("simultaneous_impacts") != std::string::npos);
  law.contact_law = ContactLaw::linear;
  law.restitution = 0;
  law.stiffness_N_per_m = 1e4;
  Scene gives_way = into_plane(law);
  gives_way.simultaneous_impacts = SimultaneousImpacts::together;
  run("atwood/rk4+penalty", gives_way, 0.001, 2000);
}

TEST_CASE("searches for the direction of least overlap are counted, and how they ended") {
  Scene scene = into_plane(linear(2e5, 0, false));
  CHECK(run("atwood/rk4+penalty", scene, 0.05, 5000).outcome.solvers.count("expanding-polytope") == 0);  // closed form
  scene.bodies[0].shape = Box{{1, 1, 0.5}};
  scene.bodies[0].position_m = {0, 0, -0.5};
  scene.bodies[1].shape =
      Convex{{{0.25, 0, 0}, {-0.25, 0, 0}, {0, 0.25, 0}, {0, -0.25, 0}, {0, 0, 0.25}, {0, 0, -0.25}}};
  const Recorded ran = run("atwood/rk4+penalty", scene, 0.05, 5000);
  REQUIRE(ran.outcome.solvers.count("expanding-polytope") == 1);
  const SolveTally& tally = ran.outcome.solvers.at("expanding-polytope");
  CHECK(tally.converged > 1000);  // in each of four rates a step, for 10 ms of contact
  CHECK(tally.capped == 0);
  CHECK(tally.iterations_max > 0);
}

// In free flight steps grow without bound, and a contact of milliseconds may lie between two stages of one. The force's
// slope jumps at the first touch, which the error estimates of high orders (gbs) understate: a hundredth of the change.
TEST_CASE("Adaptive steps do not pass over a contact: head-on from any distance, and grazes") {
  Scene pair = into_plane(linear(1e4, 0, false));
  pair.bodies[0] = pair.bodies[1];
  pair.bodies[0].name = "left";
  for (const char* method : {"atwood/dopri5:1e-9+penalty", "atwood/gbs:1e-9+penalty"})
    for (int start = 0; start < 21; ++start) {
      const double apart = 0.6 * std::pow(1.2, start);
      for (int side = 0; side < 2; ++side) {
        pair.bodies[side].position_m = {side == 0 ? -apart : apart, 0, 0};
        pair.bodies[side].velocity_m_per_s = {side == 0 ? 1.0 : -1.0, 0, 0};
      }
      const Recorded ran = run(method, pair, 2 * apart + 1, 1);
      INFO(method << " from " << apart << " m: " << ran.outcome.steps_taken << " steps");
      CHECK(std::fabs(static_cast<double>(ran.samples.back().bodies[0].v_m_per_s[0]) + 1) <
            (std::string(method).find("gbs") == std::string::npos ? 1e-6 : 1e-4));
      CHECK(ran.outcome.steps_taken < 2000);
    }
  // Past a fixed ball at 70 m/s with an overlap of 2 mm, for some 0.5 ms of 2 s: 0.1697795 m is CVODE's, whose search
  // is other code.
  Scene post = into_plane(linear(1e5, 0, false));
  for (Body& body : post.bodies) body.shape = Sphere{0.05};
  post.bodies[1].mass_kg = 1;
  post.bodies[1].position_m = {-73, 0, 0.098};
  post.bodies[1].velocity_m_per_s = {70, 0, 0};
  for (const char* method : {"atwood/dopri5:1e-10+penalty", "atwood/gbs:1e-10+penalty"}) {
    const Recorded ran = run(method, post, 2, 1);
    INFO(method << ": " << ran.outcome.steps_taken << " steps");
    CHECK(std::fabs(z(ran.samples.back()) - 0.1697795266) <
          (std::string(method).find("gbs") == std::string::npos ? 1e-6 : 2e-3));  // of 0.072
  }
}
