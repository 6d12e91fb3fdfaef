// Executed order of every method on every class of motion: right tableaux can be stepped wrong.
#include <algorithm>
#include <catch2/catch.hpp>

#include "mechanisms.hpp"
#include "scenes.hpp"

namespace atwood::testing {
namespace {

struct Problem {
  std::string name, motion;  // class of motion
  Scene scene;
  double t_end_s;
  std::int64_t steps;  // of the finest rung for methods above order 1
  Sample truth;
  double floor = 1e-16;  // an error below it is not well above the truth's own, or above the run's round-off
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
  // The problem is its scene's doubles: e = 0.6 and the root of (1 + e) / (1 - e) are rounded, 1e-16 of the orbit.
  all.push_back({"kepler-e0.6", "point-mass", kepler(0.6), 10, 15360, kepler_truth(0.6L, 10), 3e-14});
  all.push_back({"charge-in-e-cross-b", "velocity-dependent", e_cross_b(), 10, 960, e_cross_b_truth(e_cross_b(), 10)});
  all.push_back({"driven-oscillator", "point-mass", driven_oscillator(), 3, 960, driven_truth(driven_oscillator(), 3)});
  all.push_back(
      {"quadratic-drag", "velocity-dependent", quadratic_drag(), 2, 480, fine_run(quadratic_drag(), 2, 4096)});
  all.push_back({"free-box", "rotation", free_box(false), 10, 3840, fine_run(free_box(false), 10, 16384)});
  all.push_back({"thrust-and-drag", "rotation", thrust_and_drag(), 4, 320, fine_run(thrust_and_drag(), 4, 4096)});
  const auto mechanism = [&](const std::string& name, const Scene& scene, double t_end_s, std::int64_t steps) {
    const Sample truth = run("gbs", scene, {t_end_s, 400, 1}, "quad").samples.at(1);
    all.push_back({name, "mechanism", scene, t_end_s, steps, truth});
  };
  // From rest the rates of semi-implicit methods would be of order 2.
  mechanism("double-pendulum", hinge_chain({0.5, 0.2}, {0.4, -0.3}), 2, 640);
  mechanism("joints-of-all-kinds", random_tree(7, 6, false), 0.5, 320);
  return all;
}

struct Errors {  // the largest of all bodies
  double position, velocity, attitude, body_rate;
};
Errors errors(const Problem& problem, const std::string& scheme, std::int64_t steps) {
  const Recorded r = run(scheme, problem.scene, {problem.t_end_s, steps, 1}, "long-double");
  Errors worst{};
  for (std::size_t i = 0; i < problem.truth.bodies.size(); ++i) {
    const BodySample &a = r.samples.at(1).bodies[i], &b = problem.truth.bodies[i];
    worst.position = std::max(worst.position, distance(a.p_m, b.p_m));
    worst.velocity = std::max(worst.velocity, distance(a.v_m_per_s, b.v_m_per_s));
    worst.attitude = std::max(worst.attitude, attitude_distance(a.q_wxyz, b.q_wxyz));
    worst.body_rate = std::max(worst.body_rate, distance(a.w_rad_per_s, b.w_rad_per_s));
  }
  return worst;
}

// The errors of a problem's motion: those whose order is checked.
std::vector<double> checked(const Problem& problem, const Errors& e) {
  if (problem.motion != "rotation") return {e.position, e.velocity};
  if (problem.name == "thrust-and-drag" || problem.motion == "mechanism")
    return {e.position, e.velocity, e.attitude, e.body_rate};
  return {e.attitude, e.body_rate};
}

// Of each error the finest two rungs on which it is above the problem's floor. Steps are halved in number up to four
// times.
struct Rungs {
  std::vector<double> coarse, fine;
};
Rungs finest_rungs(const Problem& problem, const std::string& scheme, std::int64_t steps) {
  Rungs rungs{checked(problem, errors(problem, scheme, steps / 2)), checked(problem, errors(problem, scheme, steps))};
  const auto below = [&](double error) { return error < problem.floor; };
  for (int k = 0; k < 4 && std::any_of(rungs.fine.begin(), rungs.fine.end(), below); ++k) {
    steps /= 2;
    const std::vector<double> coarser = checked(problem, errors(problem, scheme, steps / 2));
    for (std::size_t i = 0; i < coarser.size(); ++i) {
      if (!below(rungs.fine[i])) continue;
      rungs.fine[i] = rungs.coarse[i];
      rungs.coarse[i] = coarser[i];
    }
  }
  return rungs;
}

// Which methods refuse which problems: methods that keep an energy where there is none, and Boris's push under drag.
bool is_refused(const Problem& problem, const std::string& scheme) {
  const bool drag = problem.name == "quadratic-drag" || problem.name == "thrust-and-drag";
  const bool keeps_energy = scheme == "discrete-gradient" || scheme == "average-vector-field" ||
                            scheme == "projected-rk4" || scheme == "relaxation-rk4";
  return (keeps_energy && (drag || problem.name == "driven-oscillator")) || (drag && scheme.rfind("boris", 0) == 0);
}

TEST_CASE("executed order is the claimed order, per class of motion") {
  int orders = 0, exact = 0, refused = 0;
  std::size_t claims = 0, expected_orders = 0;
  for (const Problem& problem : problems())
    for (const MethodInfo& info : integrator_catalogue()) {
      const std::string scheme = info.id.substr(7);
      const auto claim = info.claimed_order.find(problem.motion);
      if (claim == info.claimed_order.end() || claim->second > 5) continue;  // higher ones in quad: study `laboratory`
      INFO(problem.name << " by " << scheme);
      ++claims;
      if (is_refused(problem, scheme)) {
        CHECK(try_run(scheme, problem.scene, {problem.t_end_s, 1, 1}).outcome.status == Status::unsupported);
        ++refused;
        continue;
      }
      const double claimed = claim->second;
      if (problem.name == "free-box" && scheme.rfind("jacobi", 0) == 0) {  // exact: there is no error to fit
        const Errors e = errors(problem, scheme, problem.steps / 2);
        CHECK(e.attitude + e.body_rate < 1e-12);
        ++exact;
        continue;
      }
      // Near the separatrix, and where a pendulum whips round, methods of large error constants show their order late.
      const bool multistep = scheme.rfind("adams", 0) == 0 || scheme.rfind("bdf", 0) == 0;
      const bool late = multistep && claimed <= 4 && (problem.name == "free-box" || problem.name == "double-pendulum");
      const bool slow_tsit5 = scheme == "tsit5" && problem.name == "double-pendulum";  // 4.9 from the fourth halving on
      const Rungs rungs = finest_rungs(problem, scheme,
                                       (claimed == 1 || late ? 8
                                        : slow_tsit5         ? 4
                                                             : 1) *
                                           problem.steps);
      expected_orders += rungs.fine.size();
      // From rung to rung tsit5's slope under drag falls slowly, 5.8, 5.6, 5.4, 5.2, and meets round-off there.
      const double margin = scheme == "tsit5" && problem.name == "quadratic-drag" ? 0.25 : 0.2;
      for (std::size_t i = 0; i < rungs.fine.size(); ++i) {
        CAPTURE(i, rungs.coarse[i], rungs.fine[i]);
        REQUIRE(rungs.fine[i] >= problem.floor);
        CHECK(std::log2(rungs.coarse[i] / rungs.fine[i]) == Approx(claimed).margin(margin));
        ++orders;
      }
    }
  CHECK(orders == static_cast<int>(expected_orders));
  // What the catalogue has had: methods and claims may be added, none may be lost.
  CAPTURE(claims, refused, exact, orders);
  CHECK(claims >= 356);
  CHECK(refused == 16);
  CHECK(exact == 2);
  CHECK(orders >= 782);
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
  const std::array<Wide, 3> at_one{-9.4084505670560362, -9.0961990711864790, 28.581627624392339};
  CHECK(distance(r.samples[1].bodies[0].p_m, at_one) < 1e-11);
  CHECK(distance(r.samples[0].bodies[0].v_m_per_s, {-10, 28, 0}) == 0);
}

}  // namespace
}  // namespace atwood::testing
