// Compositions and rotation methods in motion: executed order, symmetry, what they keep, and the exact free top.
#include <catch2/catch.hpp>

#include "rigid/free_top.hpp"
#include "step_checks.hpp"

namespace atwood::testing {
namespace {

const std::vector<std::string> composed{"forest-ruth", "pefrl",        "mclachlan4",   "suzuki4",
                                        "suzuki6",     "suzuki8",      "yoshida4",     "yoshida6",
                                        "yoshida8",    "blanes-moan4", "blanes-moan6", "kahan-li8"};
const std::vector<std::string> charges{"boris", "boris4", "boris6"};
const std::vector<std::string> turning{
    "rkmk4",   "lie4",   "free-top2", "free-top4", "free-top6", "moser-veselov", "implicit-midpoint-so3",
    "jacobi2", "jacobi4"};

std::vector<std::string> joined(std::initializer_list<std::vector<std::string>> lists) {
  std::vector<std::string> all;
  for (const auto& list : lists) all.insert(all.end(), list.begin(), list.end());
  return all;
}

// The tumbling body, in a magnetic field too, pulled by a spring at a corner: torque that depends on attitude, position
// and velocity.
Scene charged_box_on_a_spring() {
  Scene scene = thrust_and_drag();
  scene.bodies[0].charge_C = 1;
  scene.forces.push_back(Lorentz{{0}, {0.1, 0.3, 0}, {0.2, 0, 1.5}});
  return scene;
}

Scene tumbling(Real3 moments, Real3 w) {
  Scene scene = empty_scene();
  scene.bodies.push_back(box(moments, w));
  return scene;
}

// Neither free nor driven by velocities: a thruster off the centre.
Scene thrust_only() {
  Scene scene = thrust_and_drag();
  scene.forces.pop_back();
  return scene;
}

// A charge in a magnetic field and a central force: position and velocity both matter.
Scene charge_round_a_center() {
  Scene scene = e_cross_b();
  scene.bodies[0].position_m = {1, 0.2, 0};
  scene.forces.push_back(Attractor{{0}, {0, 0, 0}, 1.3});
  return scene;
}

double apart(const BodySample& a, const BodySample& b) {
  return distance(a.p_m, b.p_m) + distance(a.v_m_per_s, b.v_m_per_s) + attitude_distance(a.q_wxyz, b.q_wxyz) +
         distance(a.w_rad_per_s, b.w_rad_per_s);
}

BodySample end_of(const std::string& scheme, const Scene& scene, double t_end_s, std::int64_t steps,
                  const std::string& scalar) {
  const Recorded r = run(scheme, scene, {t_end_s, steps, 1}, scalar);
  INFO(scheme << ": " << r.outcome.reason);
  return r.samples.at(1).bodies[0];
}

double claimed(const std::string& scheme) { return find_integrator(scheme)->claimed_order.at("point-mass"); }

// Order over the last two rungs where the error falls by two orders of the finest.
void check_orders(const std::vector<std::string>& schemes, const Scene& scene, double t_end_s, std::int64_t base) {
  const BodySample truth = end_of("gauss8", scene, t_end_s, 48 * base, "quad");
  for (const std::string& scheme : schemes) {
    const double order = claimed(scheme);
    const std::int64_t steps = order > 6 ? 2 * base : order > 4 ? 4 * base : order > 2 ? 16 * base : 128 * base;
    const double coarse = apart(end_of(scheme, scene, t_end_s, steps, "quad"), truth);
    const double fine = apart(end_of(scheme, scene, t_end_s, 2 * steps, "quad"), truth);
    INFO(scheme << ", " << 2 * steps << " steps: " << fine);
    CHECK(std::log2(coarse / fine) == Approx(order).margin(0.15));
  }
}

TEST_CASE("executed order of compositions: points, position-only and time-dependent forces") {
  check_orders(joined({composed, charges, turning}), kepler(0.3), 1, 8);
  check_orders(joined({composed, charges, turning}), driven_oscillator(), 1, 8);
}

TEST_CASE("executed order of compositions: forces that depend on velocity") {
  check_orders(joined({composed, charges, turning}), charge_round_a_center(), 1, 8);
  check_orders(joined({composed, turning}), quadratic_drag(), 0.5, 8);
}

TEST_CASE("executed order of compositions: rotation") {
  check_orders(joined({composed, charges, turning}), thrust_only(), 1, 8);
  check_orders(joined({composed, turning}), charged_box_on_a_spring(), 1, 8);
  auto inexact = turning;
  inexact.resize(inexact.size() - 2);
  check_orders(joined({composed, charges, inexact}), tumbling({0.6, 0.8, 1.0}, {3, 0.5, -0.9}), 1, 8);
}

TEST_CASE("symmetric methods reverse to round-off, on every class of motion; Lie group Runge-Kutta methods do not") {
  const Scene scenes[] = {kepler(0.6), driven_oscillator(), charge_round_a_center(), thrust_only(),
                          charged_box_on_a_spring()};
  for (std::size_t k = 0; k < std::size(scenes); ++k) {
    const bool drag = k == 4;
    for (const std::string& scheme : joined({composed, charges, turning})) {
      if (drag && scheme.rfind("boris", 0) == 0) continue;
      INFO(scheme << ", scene " << k);
      const double error = back_and_forth(scheme, scenes[k], 0.02, 100);
      if (scheme != "rkmk4" && scheme != "lie4") CHECK(error < 1e-11);
      else if (k == 0) CHECK(error > 1e-8);
    }
  }
}

// Kepler, e = 0.6, 150 periods in double: energy's largest error over the last ten against that over the first ten.
TEST_CASE("symplectic methods keep energy over long times") {
  const double period = 6.283185307179586;
  const auto energy_error = [&](const std::string& scheme, std::int64_t a_period) {
    const Recorded r = run(scheme, kepler(0.6), {150 * period, 150 * a_period, 150 * a_period});
    double first = 0, last = 0;
    for (std::int64_t n = 0; n <= 150 * a_period; ++n) {
      const BodySample& s = r.samples[n].bodies[0];
      double v2 = 0, r2 = 0;
      for (int i = 0; i < 3; ++i) {
        v2 += static_cast<double>(s.v_m_per_s[i] * s.v_m_per_s[i]);
        r2 += static_cast<double>(s.p_m[i] * s.p_m[i]);
      }
      const double error = std::fabs(v2 / 2 - 1 / std::sqrt(r2) + 0.5);
      if (n < 10 * a_period) first = std::max(first, error);
      if (n > 140 * a_period) last = std::max(last, error);
    }
    return std::pair{first, last};
  };
  for (const std::string& scheme :
       joined({composed, charges, {"free-top2", "leapfrog-kdk", "leapfrog-dkd", "jacobi4"}})) {
    const double order = claimed(scheme);
    const auto [first, last] = energy_error(scheme, scheme == "suzuki8" ? 45 : order > 4 ? 90 : 180);
    INFO(scheme << ": " << first << " then " << last);
    CHECK(first > 1e-11);  // an error of truncation, not of round-off
    CHECK(last < 1.2 * first);
  }
  const auto [first, last] = energy_error("lie4", 180);  // classical RK4 on a point
  CHECK(last > 5 * first);
}

// Without an electric field Boris's turn keeps the speed, whatever the step.
TEST_CASE("Boris's push keeps a charge's speed in a magnetic field to round-off") {
  Scene scene = e_cross_b();
  std::get<Lorentz>(scene.forces[0]).electric_V_per_m = {0, 0, 0};
  for (const std::string& scheme : charges) {
    const BodySample s = end_of(scheme, scene, 4000, 4000, "double");
    double v2 = 0;
    for (int i = 0; i < 3; ++i) v2 += static_cast<double>(s.v_m_per_s[i] * s.v_m_per_s[i]);
    CHECK(v2 == Approx(1 + 0.04 + 0.09).epsilon(2 * 9 * 4000 * 1.2e-16));  // a rounding a kick, of one sign at worst
  }
}

// v turns by 2 atan(h q B / 2 m) about B each step, not by half of it, nor the other way.
TEST_CASE("a step of Boris's push turns the velocity by twice the arctangent of half the angle") {
  Scene scene = e_cross_b();
  std::get<Lorentz>(scene.forces[0]).electric_V_per_m = {0, 0, 0};
  const double h = 0.4, omega = 2 * 1.5 / 1.5, angle = 2 * std::atan(h * omega / 2);
  const BodySample s = end_of("boris", scene, h, 1, "double");
  CHECK(static_cast<double>(s.v_m_per_s[0]) == Approx(std::cos(angle) * 1 + std::sin(angle) * 0.2).epsilon(1e-14));
  CHECK(static_cast<double>(s.v_m_per_s[1]) == Approx(std::cos(angle) * 0.2 - std::sin(angle) * 1).epsilon(1e-14));
  CHECK(static_cast<double>(s.v_m_per_s[2]) == Approx(0.3).epsilon(1e-15));
}

TEST_CASE("a method refuses by name a scene on which it loses its order") {
  for (const std::string& scheme : charges) {
    const Recorded r = try_run(scheme, quadratic_drag(), {1, 10, 1});
    CHECK(r.outcome.status == Status::unsupported);
    CHECK(r.outcome.reason.find("atwood/" + scheme) != std::string::npos);
  }
  Scene bare = empty_scene();
  bare.problem = "lorenz";
  bare.bodies.push_back(point("lorenz", 1, {1, 0, 0}, {0, 0, 0}));
  for (const std::string& scheme : joined({composed, charges, turning})) {
    const Recorded r = try_run(scheme, bare, {1, 10, 1});
    CHECK(r.outcome.status == Status::unsupported);
    CHECK(r.outcome.reason.find("system of equations without bodies") != std::string::npos);
  }
}

// In double, far below the step where truncation ends: what is left is round-off, and compensation takes most of it.
TEST_CASE("compensated summation lowers the floor, in translation and in attitude") {
  const auto floor_of = [](const std::string& scheme, const Scene& scene, std::int64_t steps, bool compensated) {
    MethodId id;
    id.engine = "atwood";
    id.scheme = scheme;
    id.overrides["compensated"] = compensated;
    double worst = 0;
    const auto samples_of = [&](const MethodId& method) { return run(method, scene, {20, steps, 10}).samples; };
    const auto narrow = samples_of(id);
    id.scalar = "long-double";  // the same steps in wider arithmetic: the truth of the floor
    const auto wide = samples_of(id);
    for (std::size_t k = 1; k < wide.size(); ++k)
      worst = std::max(worst, apart(narrow[k].bodies[0], wide[k].bodies[0]));
    return worst;
  };
  for (const std::string scheme :
       {"symplectic-euler", "leapfrog-kdk", "yoshida4", "blanes-moan6", "kahan-li8", "boris4", "rkmk4", "lie4",
        "free-top4", "moser-veselov", "implicit-midpoint-so3", "jacobi2"}) {
    const double plain = floor_of(scheme, kepler(0.3), 8000, false), kept = floor_of(scheme, kepler(0.3), 8000, true);
    INFO(scheme << " on an orbit: " << plain << ", compensated " << kept);
    CHECK(kept < plain / 4);
    if (scheme.rfind("jacobi", 0) == 0) continue;  // its attitude is not a sum of increments
    const double loose = floor_of(scheme, thrust_only(), 8000, false),
                 tight = floor_of(scheme, thrust_only(), 8000, true);
    INFO(scheme << " on a body: " << loose << ", compensated " << tight);
    CHECK(tight < loose / 4);
  }
}

}  // namespace
}  // namespace atwood::testing
