// Two oracles: here the discrete one. Each scheme's own recurrence, written out by hand; the error is round-off.
#include <catch2/catch.hpp>

#include "step_checks.hpp"

namespace atwood::testing {
namespace {

constexpr double omega2 = 4;  // the oscillator's k / m
struct Line {
  double x, v;
};
using Recurrence = Line (*)(Line, double h);

Line explicit_euler(Line s, double h) { return {s.x + h * s.v, s.v - h * omega2 * s.x}; }
Line symplectic_euler(Line s, double h) {
  const double v = s.v - h * omega2 * s.x;
  return {s.x + h * v, v};
}
Line implicit_euler(Line s, double h) {
  const double v = (s.v - h * omega2 * s.x) / (1 + h * h * omega2);
  return {s.x + h * v, v};
}
// I + hA + (hA)^2 / 2: midpoint and Heun agree on linear problems.
Line second_order(Line s, double h) {
  const double c = 1 - h * h * omega2 / 2;
  return {c * s.x + h * s.v, c * s.v - h * omega2 * s.x};
}
Line rk4(Line s, double h) {
  const double z = h * h * omega2, c = 1 - z / 2 + z * z / 24, t = 1 - z / 6;
  return {c * s.x + h * t * s.v, c * s.v - h * t * omega2 * s.x};
}
Line velocity_verlet(Line s, double h) {
  const double half = s.v - h / 2 * omega2 * s.x, x = s.x + h * half;
  return {x, half - h / 2 * omega2 * x};
}
Line leapfrog(Line s, double h) {
  const double half = s.x + h / 2 * s.v, v = s.v - h * omega2 * half;
  return {half + h / 2 * v, v};
}

struct Oracle {
  const char* scheme;
  Recurrence next;
};
const Oracle oracles[] = {{"explicit-euler", explicit_euler},
                          {"symplectic-euler", symplectic_euler},
                          {"implicit-euler", implicit_euler},
                          {"midpoint", second_order},
                          {"heun", second_order},
                          {"rk4", rk4},
                          {"velocity-verlet", velocity_verlet},
                          {"leapfrog", leapfrog}};

TEST_CASE("on the oscillator each scheme is its recurrence, to round-off") {
  for (const auto& [scheme, next] : oracles) {
    INFO(scheme);
    const Recorded r = run(scheme, oscillator(), {8, 256, 256});
    Line s{1, 0};
    double worst = 0;
    for (int n = 1; n <= 256; ++n) {
      s = next(s, 8.0 / 256);
      const BodySample& bob = r.samples.at(n).bodies[0];
      worst = std::max({worst, std::fabs(static_cast<double>(bob.p_m[0]) - s.x),
                        std::fabs(static_cast<double>(bob.v_m_per_s[0]) - s.v)});
    }
    CHECK(worst < 2e-13);
  }
}

// (h omega)^2 = 2 and 5000: fixed-point sweeps grow, so this is Newton's work.
TEST_CASE("implicit Euler solves a stiff step to round-off") {
  for (const double stiffness : {400.0, 1e6}) {
    Scene stiff = oscillator();
    std::get<Spring>(stiff.forces[0]).stiffness_N_per_m = stiffness;
    const Recorded r = run("implicit-euler", stiff, {0.4, 4, 4});
    CHECK(r.outcome.rate_evaluations < 4 * 60);
    double x = 1, v = 0;
    for (int n = 1; n <= 4; ++n) {
      v = (v - 0.1 * stiffness / 2 * x) / (1 + 0.01 * stiffness / 2);
      x += 0.1 * v;
      CHECK(static_cast<double>(r.samples.at(n).bodies[0].v_m_per_s[0]) == Approx(v).epsilon(1e-11));
    }
  }
}

// A method of order 1 keeps its order with the force at the wrong end of the step; the recurrence shows the fault.
TEST_CASE("the Euler methods see a driving force at their own instants") {
  const double h = 3.0 / 64;
  const auto drive = [](double t) { return 3.0 / 2 * std::cos(2.7 * t + 0.4); };
  Line implicit{1, 0}, symplectic{1, 0}, forward{1, 0};
  for (int n = 0; n < 64; ++n) {
    implicit.v = (implicit.v - h * omega2 * implicit.x + h * drive((n + 1) * h)) / (1 + h * h * omega2);
    implicit.x += h * implicit.v;
    symplectic.v += h * (drive(n * h) - omega2 * symplectic.x);
    symplectic.x += h * symplectic.v;
    forward = {forward.x + h * forward.v, forward.v + h * (drive(n * h) - omega2 * forward.x)};
  }
  const auto end = [](const char* scheme) {
    return static_cast<double>(run(scheme, driven_oscillator(), {3, 64, 1}).samples.at(1).bodies[0].p_m[0]);
  };
  CHECK(end("implicit-euler") == Approx(implicit.x).epsilon(1e-12));
  CHECK(end("symplectic-euler") == Approx(symplectic.x).epsilon(1e-12));
  CHECK(end("explicit-euler") == Approx(forward.x).epsilon(1e-12));
}

// A falling body with quadratic drag, v' = f(v): distinguishes midpoint from Heun, and uses v_n in symplectic Euler.
TEST_CASE("on a nonlinear velocity-dependent force each scheme is its recurrence") {
  Scene scene = quadratic_drag();
  scene.bodies[0].velocity_m_per_s = {0, 0, 0};
  auto& drag = std::get<QuadraticDrag>(scene.forces[0]);
  drag.wind_m_per_s = {0, 0, 0};
  const double c = 0.5 * drag.density_kg_per_m3 * drag.drag_coefficient * drag.area_m2 / scene.bodies[0].mass_kg;
  const auto f = [&](double v) { return -9.8 - c * std::fabs(v) * v; };
  const double h = 2.0 / 64;
  const auto end_speed = [&](const char* scheme) {
    return static_cast<double>(run(scheme, scene, {2, 64, 1}).samples.at(1).bodies[0].v_m_per_s[2]);
  };
  double midpoint = 0, heun = 0, euler = 0, implicit = 0, verlet = 0;
  for (int n = 0; n < 64; ++n) {
    midpoint += h * f(midpoint + h / 2 * f(midpoint));
    heun += h / 2 * (f(heun) + f(heun + h * f(heun)));
    euler += h * f(euler);
    // v1 = v + h (-g + c v1^2) for v1 < 0: the root that tends to v.
    implicit = (1 - std::sqrt(1 - 4 * h * c * (implicit - 9.8 * h))) / (2 * h * c);
    for (int half = 0; half < 2; ++half) {  // implicit midpoint over h/2, twice
      const double k = h / 4, m = (1 - std::sqrt(1 - 4 * k * c * (verlet - 9.8 * k))) / (2 * k * c);
      verlet = 2 * m - verlet;
    }
  }
  CHECK(end_speed("midpoint") == Approx(midpoint).epsilon(1e-13));
  CHECK(end_speed("heun") == Approx(heun).epsilon(1e-13));
  CHECK(end_speed("explicit-euler") == Approx(euler).epsilon(1e-13));
  CHECK(end_speed("symplectic-euler") == Approx(euler).epsilon(1e-13));
  CHECK(end_speed("implicit-euler") == Approx(implicit).epsilon(1e-11));  // the closed root cancels
  CHECK(end_speed("velocity-verlet") == Approx(verlet).epsilon(1e-11));
  CHECK(std::fabs(midpoint - heun) > 1e-6);
}

TEST_CASE("explicit Euler lands one step late: v_x h = 0.125 m at 60 Hz") {
  const Recorded r = run("explicit-euler", ballistic(), {2, 120, 120});
  // The parabola through three samples around the ground: z is exactly quadratic in n.
  std::size_t n = 1;
  while (r.samples.at(n + 1).bodies[0].p_m[2] > 0) ++n;
  const auto z = [&](std::size_t k) { return static_cast<double>(r.samples.at(k).bodies[0].p_m[2]); };
  const double a = (z(n + 1) - 2 * z(n) + z(n - 1)) / 2, b = (z(n + 1) - z(n - 1)) / 2;
  const double s = (-b - std::sqrt(b * b - 4 * a * z(n))) / (2 * a);
  const double range = 7.5 * (n + s) / 60, exact = 7.5 * 2 * 7.5 / 9.8;
  CHECK(range - exact == Approx(0.125).epsilon(1e-10));
}

// Energies must be the schemes' own: a run that rescales velocities would pass a drift gate and fail here.
TEST_CASE("the energy of each scheme is that of its recurrence") {
  const double h = 8.0 / 256;
  const auto invariant = [&](const BodySample& s, double of_x) {
    const double x = static_cast<double>(s.p_m[0]), v = static_cast<double>(s.v_m_per_s[0]);
    return v * v + of_x * x * x;
  };
  const Recorded euler = run("explicit-euler", oscillator(), {8, 256, 256});
  const Recorded verlet = run("velocity-verlet", oscillator(), {8, 256, 256});
  double oscillation = 0;
  for (int n = 1; n <= 256; ++n) {
    // Explicit Euler multiplies the energy by 1 + h^2 omega^2 a step; Verlet keeps v^2 + omega^2 (1 - h^2 omega^2 / 4)
    // x^2.
    CHECK(invariant(euler.samples[n].bodies[0], omega2) == Approx(4 * std::pow(1 + h * h * omega2, n)).epsilon(1e-11));
    const double kept = omega2 * (1 - h * h * omega2 / 4);
    CHECK(invariant(verlet.samples[n].bodies[0], kept) == Approx(kept).epsilon(1e-12));
    oscillation = std::max(oscillation, std::fabs(invariant(verlet.samples[n].bodies[0], omega2) - omega2));
  }
  CHECK(oscillation == Approx(omega2 * h * h * omega2 / 4).epsilon(0.01));
}

TEST_CASE("Verlet and leapfrog are reversible, on velocity-dependent forces and rotation too; others are not") {
  for (const Scene& scene : {kepler(0.6), quadratic_drag(), e_cross_b(), free_box(), thrust_and_drag()}) {
    CHECK(back_and_forth("velocity-verlet", scene, 0.01, 200) < 2e-11);
    CHECK(back_and_forth("leapfrog", scene, 0.01, 200) < 2e-11);
    CHECK(back_and_forth("heun", scene, 0.01, 200) > 1e-9);
    CHECK(back_and_forth("symplectic-euler", scene, 0.01, 200) > 1e-9);
  }
}

TEST_CASE("leapfrog and velocity Verlet are different schemes") {
  const auto end = [](const char* scheme) {
    return run(scheme, kepler(0.6), {10, 2000, 1}).samples.at(1).bodies[0].p_m;
  };
  CHECK(distance(end("leapfrog"), end("velocity-verlet")) > 1e-5);
}

// The splitting of the free top keeps the body's momentum in the world to round-off, at any step.
TEST_CASE("partitioned methods keep a free body's angular momentum") {
  for (const char* scheme : {"symplectic-euler", "velocity-verlet", "leapfrog"}) {
    Scene scene = free_box(false);
    scene.bodies[0].inertia_kg_m2 = {0.6, 0.02, 0.01, 0.02, 0.8, -0.03, 0.01, -0.03, 1.0};
    const Recorded r = run(scheme, scene, {10, 500, 1});
    const RigidModel<double> model(scene);
    const auto momentum = [&](const BodySample& s) {
      const MassProperties<double>& mass = model.mass(0);
      const Quat<double> q{double(s.q_wxyz[0]), double(s.q_wxyz[1]), double(s.q_wxyz[2]), double(s.q_wxyz[3])};
      return rotate(q,
                    mass.times_inertia({double(s.w_rad_per_s[0]), double(s.w_rad_per_s[1]), double(s.w_rad_per_s[2])}));
    };
    const Vec3<double> before = momentum(r.samples.at(0).bodies[0]), after = momentum(r.samples.at(1).bodies[0]);
    CHECK(norm(after - before) < 1e-12 * norm(before));
  }
}

}  // namespace
}  // namespace atwood::testing
