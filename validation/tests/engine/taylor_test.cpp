// The Taylor method: published and closed-form values, executed orders, what it refuses, its own step sizes.
#include <catch2/catch.hpp>

#include "step_checks.hpp"
#include "validation/tests/extended/reference_values.hpp"

namespace atwood::testing {
namespace {

Scene lorenz() {
  Scene scene = empty_scene();
  scene.problem = "lorenz";
  scene.bodies.push_back(point("lorenz", 1, {1, 0, 0}, {0, 0, 0}));
  return scene;
}

Scene henon_heiles() {
  Scene scene = empty_scene();
  scene.bodies.push_back(point("star", 1, {0.1, 0, 0}, {0, 0.5, 0}));
  scene.forces.push_back(Potential{{0}, "henon-heiles", {}});
  return scene;
}

Scene asymmetric_top() {
  Scene scene = empty_scene();
  scene.bodies.push_back(box({0.6, 0.8, 1.0}, {3, 0.5, -0.9}));
  return scene;
}

// Every force that has a recurrence, on bodies fixed, held and free.
Scene everything() {
  Scene scene = empty_scene();
  scene.gravity_m_per_s2 = {0, 0, -1};
  scene.bodies = {point("sun", 3, {0, 0, 0}, {0, 0, 0}), point("a", 1, {2, 0, 0}, {0, 1, 0.2}),
                  point("b", 0.5, {-1, 2, 0.5}, {0.3, 0, 0}), point("late", 0.7, {1, 3, 1}, {0.1, 0.2, 0})};
  scene.bodies[0].fixed = true;
  scene.bodies[3].release_s = 0.5;
  scene.bodies[1].charge_C = 0.7;
  scene.bodies[2].charge_C = -0.4;
  MutualGravity gravity{{0, 1, 2, 3}, 1, 0.1};
  Spring anchored, link;
  anchored.bodies = {1};
  anchored.anchor_m = {0.5, 0, 1};
  anchored.stiffness_N_per_m = 0.8;
  link.bodies = {2, 3};
  link.stiffness_N_per_m = 0.3;
  LinearDrag drag;
  drag.bodies = {1, 3};
  drag.coefficient_kg_per_s = 0.2;
  drag.wind_m_per_s = {1, 0, -0.5};
  PointForce push;
  push.body = 2;
  push.force_N = {0.1, -0.2, 0.3};
  scene.forces = {gravity,
                  Attractor{{1, 3}, {0, -5, 0}, 2},
                  anchored,
                  link,
                  drag,
                  push,
                  Coulomb{{1, 2}, 0.9},
                  Lorentz{{1, 2}, {0.1, 0.3, 0}, {0.2, -0.4, 1.5}},
                  RotatingFrame{{0.1, 0.2, 0.5}},
                  Drive{{1, 2}, {0.3, 0, 0.1}, 2.7, 0.4},
                  Potential{{2}, "henon-heiles", {{"lambda", 0.3}}}};
  return scene;
}

// Its torque comes from body rates alone.
Scene dragged_top() {
  Scene scene = thrust_and_drag();
  scene.forces.erase(scene.forces.begin());
  scene.gravity_m_per_s2 = {0, 0, -9.8};
  return scene;
}

MethodId taylor_of_order(const std::string& scalar, double rtol, std::int64_t order) {
  MethodId id = method_id("taylor", scalar, rtol);
  if (order > 0) id.overrides["order"] = order;
  return id;
}
Recorded taylor(const Scene& scene, const Plan& plan, const std::string& scalar, double rtol, std::int64_t order = 0) {
  return run(taylor_of_order(scalar, rtol, order), scene, plan);
}

double off(Wide value, const char* truth) { return std::abs(static_cast<double>(value - parse_wide(truth))); }

TEST_CASE("Lorenz at t = 10 to the last digits computed elsewhere") {
  const BodySample end = run("taylor", lorenz(), {10, 10, 1}, "quad", 1e-33).samples.back().bodies[0];
  for (int c = 0; c < 3; ++c) CHECK(off(end.p_m[c], reference_values::lorenz_10.at_end[c]) < 1e-26);
}

TEST_CASE("Pleiades at t = 3") {
  const Recorded wide = run("taylor", pleiades(), {3, 10, 1}, "quad", 1e-26),
                 narrow = run("taylor", pleiades(), {3, 10, 1}, "", 1e-13);
  for (int i = 0; i < 7; ++i)
    for (int c = 0; c < 2; ++c) {
      CHECK(off(wide.samples.back().bodies[i].p_m[c], reference_values::pleiades.at_end[7 * c + i]) < 2e-18);
      CHECK(off(narrow.samples.back().bodies[i].p_m[c], reference_values::pleiades.at_end[7 * c + i]) < 1e-10);
    }
  CHECK(wide.outcome.rate_evaluations == 0);
}

TEST_CASE("a circular orbit in quad") {  // cos 10, sin 10
  const BodySample end = run("taylor", kepler(0), {10, 10, 1}, "quad", 1e-32).samples.back().bodies[0];
  CHECK(off(end.p_m[0], "-0.83907152907645245225886394782406483") < 1e-29);
  CHECK(off(end.p_m[1], "-0.54402111088936981340474766185137728") < 1e-29);
}

TEST_CASE("Henon and Heiles, and a free top, up to the rounding of their decimals") {
  const BodySample star = run("taylor", henon_heiles(), {10, 10, 1}, "quad", 1e-20).samples.back().bodies[0];
  for (int c = 0; c < 2; ++c) CHECK(off(star.p_m[c], reference_values::henon_heiles_10.at_end[c]) < 1e-15);
  const BodySample top = run("taylor", asymmetric_top(), {10, 10, 1}, "quad", 1e-20).samples.back().bodies[0];
  const double moment[] = {0.6, 0.8, 1};
  for (int c = 0; c < 3; ++c)
    CHECK(off(Wide(moment[c]) * top.w_rad_per_s[c], reference_values::asymmetric_top.at_end[c]) < 1e-14);
  std::array<Wide, 4> attitude{};
  for (int c = 0; c < 4; ++c) attitude[c] = parse_wide(reference_values::asymmetric_top.at_end[3 + c]);
  CHECK(attitude_distance(top.q_wxyz, attitude) < 1e-14);
}

TEST_CASE("every law with a recurrence is the law that rates state") {
  for (const Scene& scene : {everything(), dragged_top(), e_cross_b(), driven_oscillator()}) {
    const Recorded truth = run("verner9", scene, {2, 4000, 4}, "quad"),
                   series = run("taylor", scene, {2, 40, 4}, "quad", 1e-25);
    for (std::size_t k = 0; k < truth.samples.size(); ++k) {
      Recorded a, b;
      a.samples = {series.samples[k]};
      b.samples = {truth.samples[k]};
      CHECK(end_error(a, b) < 1e-21);
    }
  }
  Scene damped = oscillator(0.6);
  damped.forces.push_back(Drive{{0}, {3, 0, 0}, 2.7, 0.4});
  CHECK(end_error(run("taylor", damped, {5, 100, 1}, "quad", 1e-25), run("verner9", damped, {5, 20000, 1}, "quad")) <
        1e-21);
}

TEST_CASE("the executed order is the order asked for") {
  for (const int order : {5, 12, 16})
    for (const Scene& scene : {kepler(0.3), e_cross_b(), free_box()}) {
      const Recorded truth = taylor(scene, {2, 400, 1}, "quad", 0, 24);
      const bool easy = !scene.forces.empty() && std::holds_alternative<Lorentz>(scene.forces[0]);
      const std::int64_t steps = easy ? 200 / order : 40;  // above quad's floor, and asymptotic
      const double coarse = end_error(taylor(scene, {2, steps, 1}, "quad", 0, order), truth),
                   fine = end_error(taylor(scene, {2, 2 * steps, 1}, "quad", 0, order), truth);
      INFO("order " << order << ", errors " << coarse << ", " << fine);
      CHECK(std::log2(coarse / fine) == Approx(order).margin(0.35));
    }
}

TEST_CASE("a scene without a power series is refused by name") {
  const auto reason = [](const Scene& scene) {
    const Outcome outcome = try_run("taylor", scene, {1, 10, 1}).outcome;
    CHECK(outcome.status == Status::unsupported);
    return outcome.reason;
  };
  CHECK(reason(quadratic_drag()).find("quadratic-drag") != std::string::npos);
  CHECK(reason(thrust_and_drag()).find("thruster") != std::string::npos);
  Scene damped = oscillator(0.5);
  damped.bodies[0].velocity_m_per_s = {0, 1, 0};
  CHECK(reason(damped).find("dashpot off a line") != std::string::npos);
  Scene stretched = oscillator();
  std::get<Spring>(stretched.forces[0]).rest_length_m = 0.3;
  CHECK(reason(stretched).find("rest length") != std::string::npos);
  const Outcome beyond = try_run(taylor_of_order("", 0, 101), kepler(0), {1, 10, 1}).outcome;
  CHECK(beyond.status == Status::unsupported);
  CHECK(beyond.reason.find("order") != std::string::npos);
}

TEST_CASE("steps follow the tolerance, in every scalar, and samples cost nothing of the run") {
  const Recorded truth = run("taylor", kepler(0.6), {10, 2000, 50}, "quad", 1e-28);
  for (const double rtol : {1e-6, 1e-9, 1e-12})
    CHECK(end_error(run("taylor", kepler(0.6), {10, 1, 1}, "", rtol), truth) < 100 * rtol);
  CHECK(end_error(run("taylor", kepler(0.6), {10, 1, 1}, "float", 1e-6), truth) < 2e-4);
  check_samples_change_nothing("taylor", truth);
}

TEST_CASE("a step taken again uses the series of its start, an edited state a new one") {
  Twins twins("taylor");
  twins.step(0.1);
  twins.check_step(0.05);
  twins.y[4] += 0.1;
  RigidModel<double> third(kepler(0.6));
  twins.fresh = stepper_of("taylor", third);
  twins.check_step(0.05);
}

}  // namespace
}  // namespace atwood::testing
