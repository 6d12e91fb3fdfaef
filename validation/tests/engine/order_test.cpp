// Executed order of every method on every class of motion: right tableaux can be stepped wrong.
#include <catch2/catch.hpp>
#include <functional>

#include "scenes.hpp"

namespace atwood::testing {
namespace {

struct Problem {
  std::string name, motion;  // class of motion
  Scene scene;
  double t_end_s;
  std::int64_t steps;  // of the finest rung for methods above order 1
  Sample truth;
};

// Kepler's equation E - e sin E = t, mu = a = 1, from pericentre.
Sample kepler_truth(long double e, long double t) {
  long double E = t;
  for (int k = 0; k < 200; ++k) E -= (E - e * std::sin(E) - t) / (1 - e * std::cos(E));
  const long double b = std::sqrt(1 - e * e), rate = 1 / (1 - e * std::cos(E));
  Sample sample;
  sample.bodies.resize(1);
  sample.bodies[0].p_m = {std::cos(E) - e, b * std::sin(E), 0};
  sample.bodies[0].v_m_per_s = {-std::sin(E) * rate, b * std::cos(E) * rate, 0};
  return sample;
}

// Gyration about the drift E x B / B^2, B along z: u = v - drift turns by -q B / m t.
Sample e_cross_b_truth(const Scene& scene, long double t) {
  const auto& field = std::get<Lorentz>(scene.forces[0]);
  const Body& ion = scene.bodies[0];
  const long double B = field.magnetic_T[2], omega = ion.charge_C * B / ion.mass_kg;
  const long double dx = field.electric_V_per_m[1] / B, dy = -field.electric_V_per_m[0] / B;
  const long double ux = ion.velocity_m_per_s[0] - dx, uy = ion.velocity_m_per_s[1] - dy, vz = ion.velocity_m_per_s[2];
  const long double c = std::cos(omega * t), s = std::sin(omega * t);
  Sample sample;
  sample.bodies.resize(1);
  sample.bodies[0].v_m_per_s = {dx + c * ux + s * uy, dy + c * uy - s * ux, vz};
  sample.bodies[0].p_m = {dx * t + (s * ux + (1 - c) * uy) / omega, dy * t + (s * uy - (1 - c) * ux) / omega, vz * t};
  return sample;
}

// x'' = -w^2 x + f cos(u t + phase): a particular solution a cos(u t + phase), a = f / (w^2 - u^2), and a free one.
Sample driven_truth(const Scene& scene, long double t) {
  const auto& spring = std::get<Spring>(scene.forces[0]);
  const auto& drive = std::get<Drive>(scene.forces[1]);
  const Body& bob = scene.bodies[0];
  const long double w2 = spring.stiffness_N_per_m / bob.mass_kg, w = std::sqrt(w2),
                    u = drive.angular_frequency_rad_per_s;
  const long double a = drive.force_N[0] / bob.mass_kg / (w2 - u * u), phase = drive.phase_rad;
  const long double x0 = bob.position_m[0] - a * std::cos(phase),
                    v0 = bob.velocity_m_per_s[0] + a * u * std::sin(phase);
  Sample sample;
  sample.bodies.resize(1);
  sample.bodies[0].p_m[0] = x0 * std::cos(w * t) + v0 / w * std::sin(w * t) + a * std::cos(u * t + phase);
  sample.bodies[0].v_m_per_s[0] = v0 * std::cos(w * t) - x0 * w * std::sin(w * t) - a * u * std::sin(u * t + phase);
  return sample;
}

Sample fine_run(const Scene& scene, double t_end_s, std::int64_t steps) {
  return run("dopri5", scene, {t_end_s, steps, 1}, "quad").samples.at(1);
}

std::vector<Problem> problems() {
  std::vector<Problem> all;
  all.push_back({"kepler-e0.6", "point-mass", kepler(0.6), 10, 15360, kepler_truth(0.6L, 10)});
  // The problem is its scene's doubles: e = 0.6 and the root of (1 + e) / (1 - e) are rounded, 1e-16 of the orbit.
  all.push_back({"charge-in-e-cross-b", "velocity-dependent", e_cross_b(), 10, 960, e_cross_b_truth(e_cross_b(), 10)});
  all.push_back({"driven-oscillator", "point-mass", driven_oscillator(), 3, 960, driven_truth(driven_oscillator(), 3)});
  all.push_back(
      {"quadratic-drag", "velocity-dependent", quadratic_drag(), 2, 480, fine_run(quadratic_drag(), 2, 4096)});
  all.push_back({"free-box", "rotation", free_box(false), 10, 3840, fine_run(free_box(false), 10, 16384)});
  all.push_back({"thrust-and-drag", "rotation", thrust_and_drag(), 4, 320, fine_run(thrust_and_drag(), 4, 4096)});
  return all;
}

struct Errors {
  double position, velocity, attitude, body_rate;
};
Errors errors(const Problem& problem, const std::string& scheme, std::int64_t steps) {
  const Recorded r = run(scheme, problem.scene, {problem.t_end_s, steps, 1}, "long-double");
  REQUIRE(r.outcome.status == Status::ok);
  const BodySample &a = r.samples.at(1).bodies[0], &b = problem.truth.bodies[0];
  return {distance(a.p_m, b.p_m), distance(a.v_m_per_s, b.v_m_per_s), attitude_distance(a.q_wxyz, b.q_wxyz),
          distance(a.w_rad_per_s, b.w_rad_per_s)};
}

// Order between the two finest rungs, where the error is well above the truth's own.
void check_order(double coarse, double fine, double claimed) {
  if (fine < 1e-13) return;  // the rounded problem differs from the truth by parts in 1e15
  CHECK(std::log2(coarse / fine) == Approx(claimed).margin(0.2));
}

TEST_CASE("executed order is the claimed order, per class of motion") {
  for (const Problem& problem : problems())
    for (const MethodInfo& info : integrator_catalogue()) {
      const std::string scheme = info.id.substr(7);
      const auto claim = info.claimed_order.find(problem.motion);
      if (claim == info.claimed_order.end() || claim->second > 5) continue;  // higher ones in quad: study `laboratory`
      if (run(scheme, problem.scene, {problem.t_end_s, 1, 1}).outcome.status == Status::unsupported) {
        const std::string& why = run(scheme, problem.scene, {problem.t_end_s, 1, 1}).outcome.reason;
        const bool no_energy = why.find("needs an energy to keep") != std::string::npos;
        CHECK((no_energy ||
               (scheme.rfind("boris", 0) == 0 && problem.scene.forces.size() > 0)));  // drag is not for Boris's push
        continue;
      }
      const double claimed = claim->second;
      // Near the separatrix methods of large error constants show their order late.
      const bool multistep = scheme.rfind("adams", 0) == 0 || scheme.rfind("bdf", 0) == 0;
      const bool late = multistep && claimed <= 4 && problem.name == "free-box";
      const std::int64_t steps = claimed == 1 || late ? 8 * problem.steps : problem.steps;
      const Errors coarse = errors(problem, scheme, steps / 2), fine = errors(problem, scheme, steps);
      INFO(problem.name << " by " << scheme);
      if (problem.name == "free-box" && scheme.rfind("jacobi", 0) == 0) {  // exact: nothing to fit
        CHECK(coarse.attitude + coarse.body_rate < 1e-12);
        continue;
      }
      if (problem.motion != "rotation" || problem.name == "thrust-and-drag") {
        CHECK(fine.position > 1e-15);  // an error to measure
        check_order(coarse.position, fine.position, claimed);
        check_order(coarse.velocity, fine.velocity, claimed);
      }
      if (problem.motion == "rotation") {
        CHECK(fine.attitude > 1e-15);
        check_order(coarse.attitude, fine.attitude, claimed);
        check_order(coarse.body_rate, fine.body_rate, claimed);
      }
    }
}

// Jacobi elliptic functions, evaluated elsewhere to 15 digits.
TEST_CASE("free-box-complex ends where the elliptic functions say") {
  const BodySample box = fine_run(free_box(), 10, 32768).bodies[0];
  CHECK(distance(box.w_rad_per_s, {2.75584040514685, -3.73596351921622, -3.16180900346752}) < 1e-13);
  CHECK(attitude_distance(box.q_wxyz, {0.225164563413958, -0.619927562499452, -0.277029150687195, 0.69874572364031}) <
        1e-13);
}

TEST_CASE("lorenz: position is the unknowns, velocity their rates") {
  Scene scene = empty_scene();
  scene.problem = "lorenz";
  scene.bodies.push_back(point("lorenz", 1, {1, 0, 0}, {0, 0, 0}));
  const Recorded r = run("dopri5", scene, {1, 2000, 1}, "long-double");
  REQUIRE(r.outcome.status == Status::ok);
  const std::array<Wide, 3> at_one{-9.4084505670560362, -9.0961990711864790, 28.581627624392339};
  CHECK(distance(r.samples[1].bodies[0].p_m, at_one) < 1e-11);
  CHECK(distance(r.samples[0].bodies[0].v_m_per_s, {-10, 28, 0}) == 0);
}

}  // namespace
}  // namespace atwood::testing
