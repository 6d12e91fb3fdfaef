// Implicit one-step methods: order conditions, quadratic invariants, reversibility, stiffness, the solver's round-off.
#include <catch2/catch.hpp>

#include "integrators/implicit_stages.hpp"
#include "integrators/implicit_tableaux.hpp"
#include "scenes.hpp"

namespace atwood::testing {
namespace {

// Hairer, Norsett, Wanner I, table II.2.2: the eight trees of up to four vertices; 0 where the condition holds.
double misfit_of_order(const CollocationTableau& t, int order) {
  const int s = t.stages;
  std::vector<Quad> ac(s), acc(s), aac(s);
  Quad sums[9] = {};
  for (int i = 0; i < s; ++i)
    for (int j = 0; j < s; ++j) {
      ac[i] += t.a[i * s + j] * t.c[j];
      acc[i] += t.a[i * s + j] * t.c[j] * t.c[j];
    }
  for (int i = 0; i < s; ++i)
    for (int j = 0; j < s; ++j) aac[i] += t.a[i * s + j] * ac[j];
  for (int i = 0; i < s; ++i) {
    const Quad b = t.b[i], c = t.c[i];
    const Quad terms[] = {b, b * c, b * c * c, b * ac[i], b * c * c * c, b * c * ac[i], b * acc[i], b * aac[i]};
    for (int k = 0; k < 8; ++k) sums[k] += terms[k];
  }
  const int inverse[] = {1, 2, 3, 6, 4, 8, 12, 24}, of_order[] = {1, 2, 3, 3, 4, 4, 4, 4};
  Quad worst = Quad(0);
  for (int k = 0; k < 8; ++k)
    if (of_order[k] <= order) worst = real::max(worst, real::abs(sums[k] - Quad(1) / Quad(inverse[k])));
  for (int i = 0; i < s; ++i) {
    Quad row = -t.c[i];
    for (int j = 0; j < s; ++j) row += t.a[i * s + j];
    worst = real::max(worst, real::abs(row));
  }
  return static_cast<double>(worst / real::epsilon<Quad>());
}

TEST_CASE("trapezoid, SDIRK 2 and SDIRK 4 hold their order conditions in quad, and no more") {
  CHECK(misfit_of_order(trapezoid_tableau(), 2) < 4);
  CHECK(misfit_of_order(trapezoid_tableau(), 3) > 1e10);
  CHECK(misfit_of_order(sdirk2_tableau(), 2) < 4);
  CHECK(misfit_of_order(sdirk2_tableau(), 3) > 1e10);
  CHECK(misfit_of_order(sdirk4_tableau(), 4) < 64);  // entries up to 12
  CollocationTableau wrong = sdirk4_tableau();
  wrong.a[15] += Quad(1e-6);
  CHECK(misfit_of_order(wrong, 4) > 1e10);
}

template <class S> std::vector<S> march(const std::string& scheme, const Scene& scene, S h_s, int steps, int back = 0) {
  RigidModel<S> model(scene);
  const auto stepper = stepper_of(scheme, model);
  std::vector<S> y(model.state_size()), y_new(y.size());
  model.initial_state(y.data());
  for (int n = 0; n < steps + back; ++n) {
    const S t = S(n < steps ? n : 2 * steps - n) * h_s;
    REQUIRE(stepper->step(t, n < steps ? h_s : -h_s, y.data(), y_new.data()));
    y.swap(y_new);
  }
  return y;
}

// |q|, and of the free top w . I w and |I w|: all quadratic. No projection is there to hide a fault.
TEST_CASE("Gauss methods keep quadratic invariants to round-off, others do not") {
  const Scene scene = free_box(false);
  const RigidModel<double> model(scene);
  const auto invariants = [&](const std::vector<double>& y) {
    const Vec3<double> w = load3(&y[kAtBodyRate]), L = model.mass(0).times_inertia(w);
    const Quat<double> q = load4(&y[kAtAttitude]);
    return std::array<double, 3>{dot(w, L), norm(L), std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z)};
  };
  std::vector<double> start(model.state_size());
  model.initial_state(start.data());
  const auto drift = [&](const char* scheme) {
    const auto before = invariants(start), after = invariants(march<double>(scheme, scene, 0.02, 1000));
    double worst = 0;
    for (int i = 0; i < 3; ++i) worst = std::max(worst, std::fabs(after[i] / before[i] - 1));
    return worst;
  };
  for (const char* scheme : {"implicit-midpoint", "gauss2", "gauss4", "gauss6", "gauss8"}) {
    INFO(scheme);
    CHECK(drift(scheme) < 1e-13);
  }
  for (const char* scheme : {"radau5", "sdirk4", "trapezoid"}) CHECK(drift(scheme) > 1e-11);
}

TEST_CASE("Gauss methods and the trapezoid are reversible to round-off, Radau and SDIRK are not") {
  const auto returns = [](const char* scheme, const Scene& scene) {
    RigidModel<double> model(scene);
    std::vector<double> start(model.state_size());
    model.initial_state(start.data());
    const std::vector<double> end = march<double>(scheme, scene, 0.01, 200, 200);
    double worst = 0;
    for (std::size_t i = 0; i < start.size(); ++i) worst = std::max(worst, std::fabs(end[i] - start[i]));
    return worst;
  };
  for (const Scene& scene : {kepler(0.6), quadratic_drag(), e_cross_b()})
    for (const char* scheme : {"implicit-midpoint", "gauss4", "gauss8", "trapezoid"}) {
      INFO(scheme);
      CHECK(returns(scheme, scene) < 2e-11);
    }
  for (const char* scheme : {"gauss2", "gauss4", "gauss6"}) CHECK(returns(scheme, thrust_and_drag()) < 2e-11);
  CHECK(returns("sdirk2", kepler(0.6)) > 1e-6);
  CHECK(returns("radau5", kepler(0.6)) > 1e-10);
}

// An oscillator of h omega = 1000, and a spring damped so hard that its fast mode has h lambda = -1e3 .. -1e6.
Scene stiff_spring(double stiffness, double damping) {
  Scene scene = oscillator(damping);  // 2 kg
  std::get<Spring>(scene.forces[0]).stiffness_N_per_m = stiffness;
  scene.bodies[0].velocity_m_per_s = {3, 0, 0};
  return scene;
}

TEST_CASE("stiff: A-stable methods stay bounded at h lambda = 1e3, L-stable ones forget the fast motion") {
  const double h = 0.1, omega = 1e3 / h;
  const Scene undamped = stiff_spring(2 * omega * omega, 0);
  const auto amplitude = [&](const char* scheme, int steps) {
    const std::vector<double> y = march<double>(scheme, undamped, h, steps);
    return std::hypot(y[0], y[3] / omega) / std::hypot(1, 3 / omega);
  };
  for (const char* scheme : {"implicit-midpoint", "gauss4", "gauss6", "gauss8", "trapezoid"}) {
    INFO(scheme);  // |R(i y)| = 1
    CHECK(amplitude(scheme, 200) == Approx(1).epsilon(1e-9));
  }
  // |R(i 1000)|: implicit Euler 1e-3; Radau 5: 3 / 1000; SDIRK 2: (1 - 2 g) / g^2 / 1000 = 4.83e-3
  CHECK(amplitude("implicit-euler", 1) == Approx(1e-3).epsilon(1e-3));
  CHECK(amplitude("radau5", 1) == Approx(3e-3).epsilon(1e-2));
  CHECK(amplitude("sdirk2", 1) == Approx(4.828e-3).epsilon(1e-2));
  CHECK(amplitude("sdirk4", 2) < 1e-3);
  CHECK(amplitude("generalised-alpha", 100) < 1e-4);  // rho = 0.8 a step
  for (const char* scheme : {"bdf1", "bdf2"}) CHECK(amplitude(scheme, 60) < 1e-4);

  // Overdamped: y'' = -2000/2 ... fast mode -c/m, slow one -k/c. After many steps the slow motion alone is left, and
  // right.
  const Scene damped = stiff_spring(2e4, 2e4);  // fast -1e4 + 1, slow -1.0001
  for (const char* scheme :
       {"radau5", "sdirk2", "sdirk4", "bdf2", "bdf3", "bdf4", "bdf5", "implicit-euler", "gauss4", "trapezoid"}) {
    INFO(scheme);
    const std::vector<double> y = march<double>(scheme, damped, h, 30);
    const double slow = (1e4 - std::sqrt(1e8 - 4e4)) / 2;
    CHECK(std::fabs(y[0]) == Approx(std::exp(-slow * 3)).epsilon(0.2));
    if (scheme[0] != 'g' && scheme[0] != 't') CHECK(y[3] / y[0] == Approx(-slow).epsilon(1e-6));  // no fast motion left
  }
}

TEST_CASE("generalised alpha: rho_infinity is the factor of infinitely stiff motion") {
  Scene scene = stiff_spring(2e16, 0);  // h omega = 1e7
  for (const double rho : {0.0, 0.5, 0.8, 1.0}) {
    RigidModel<double> model(scene);
    const auto stepper = stepper_of("generalised-alpha", model, {{"rho_infinity", rho}});
    std::vector<double> y(model.state_size()), y_new(y.size());
    model.initial_state(y.data());
    std::vector<double> size;
    for (int n = 0; n < 42; ++n) {
      REQUIRE(stepper->step(n * 0.1, 0.1, y.data(), y_new.data()));
      y.swap(y_new);
      size.push_back(std::fabs(y[0]));
    }
    INFO(rho);  // all three roots meet at infinity: n^2 rho^n
    if (rho == 1) CHECK(size[41] / size[21] == Approx(1).epsilon(0.01));
    else if (rho > 0)
      CHECK(std::pow(size[41] / size[21], 1.0 / 20) == Approx(rho * std::pow(42.0 / 22, 0.1)).epsilon(0.015));
    else CHECK(size[41] < 1e-6);
  }
  RigidModel<double> model(kepler(0));
  const auto refused = make_stepper("generalised-alpha", model, {{"rho_infinity", 1.5}});
  REQUIRE(!refused);
  CHECK_THAT(refused.fault().reason, Catch::Contains("rho_infinity"));
}

// A tolerance in the solver would show here as a floor far above the round-off.
TEST_CASE("stage equations are solved to the scalar's round-off, by sweeps and by Newton") {
  const auto energy_error = [](auto scalar, const Scene& scene, int steps) {
    using S = decltype(scalar);
    const RigidModel<S> model(scene);
    std::vector<S> y(model.state_size());
    model.initial_state(y.data());
    const S before = model.energy(y.data());
    y = march<S>("gauss4", scene, S(1) / S(16), steps);
    return static_cast<double>(real::abs(model.energy(y.data()) / before - S(1)) / real::epsilon<S>());
  };
  for (const double stiffness : {8.0, 8e4, 8e10}) {  // h omega = 1/8 to 1e4: a quadratic energy, kept by Gauss
    Scene scene = oscillator();
    std::get<Spring>(scene.forces[0]).stiffness_N_per_m = stiffness;
    // In ulp, over 200 steps. Stiff steps are made of b A^-1 z, whose rounded coefficients push by a few ulp a step.
    const double bound = stiffness == 8 ? 20 : 2000;
    CHECK(energy_error(0.0, scene, 200) < bound);
    CHECK(energy_error(0.0L, scene, 200) < bound);
    CHECK(energy_error(Quad(0), scene, 200) < bound);
    CHECK(energy_error(0.0f, scene, 200) < bound);
  }
}

TEST_CASE("equations without a solution are refused; with one it is found to the last digit") {
  const auto solve = [](double (*law)(double), double h) {
    StageSolver<double> solver(1, {Quad(1)});
    const double y = 1, known = 0;
    double z = 0, k = 0;
    const auto rates = [](void* of, const double* at, double* rate) {
      *rate = (*static_cast<double (**)(double)>(of))(*at);
    };
    const bool solved = solver.solve(rates, &law, h, &y, &known, &z, &k);
    return std::pair(solved, z);
  };
  CHECK(!solve([](double z) { return 1 + z * z; }, 1).first);  // z = 1 + z^2 has no real root
  for (const double h : {0.1, 10.0, 1e5}) {  // z = h (1 - z^3): sweeps for the first, Newton for the others
    const auto [solved, z] = solve([](double x) { return 1 - x * x * x; }, h);
    CHECK(solved);
    CHECK(std::fabs(h * (1 - z * z * z) - z) <= 4e-16 * (1 + 3 * h));
  }
}

TEST_CASE("a solve says how it ended: converged, stagnated at round-off, or capped with its residual") {
  const auto report = [](double (*law)(double), double h) {
    StageSolver<double> solver(1, {Quad(1)});
    const double y = 1, known = 0;
    double z = 0, k = 0;
    const auto rates = [](void* of, const double* at, double* rate) {
      *rate = (*static_cast<double (**)(double)>(of))(*at);
    };
    solver.solve(rates, &law, h, &y, &known, &z, &k);
    return solver.report();
  };
  const SolveReport none = report([](double z) { return 1 + z * z; }, 1);  // no real root
  CHECK(none.ended == SolveEnd::capped);
  CHECK(none.iterations > 80);  // the limit of Newton's method, after the sweeps
  CHECK(none.residual > 1e-3);
  const SolveReport constant = report([](double) { return 3.0; }, 0.1);
  CHECK(constant.ended == SolveEnd::converged);
  CHECK(constant.iterations == 2);
  CHECK(constant.residual == 0);
  const SolveReport cubic = report([](double x) { return 1 - x * x * x; }, 10);
  CHECK(cubic.ended != SolveEnd::capped);
  CHECK(cubic.residual < 1e-12);
}

TEST_CASE("a run carries how its implicit steps ended") {
  const Recorded fine = run("gauss4", kepler(0.6), {10, 400, 1});
  REQUIRE(fine.outcome.status == Status::ok);
  const SolveTally& stages = fine.outcome.solvers.at("implicit-stages");
  CHECK(stages.solves() == 400);
  CHECK(stages.capped == 0);
  CHECK(stages.iterations_max > 3);
  CHECK(stages.residual_max < 256 * 3e-16);
  CHECK(run("rk4", kepler(0.6), {10, 400, 1}).outcome.solvers.empty());

  // Implicit Euler takes energy away until the orbit is as small as a step: Newton's method then finds no end of it.
  const Recorded coarse = try_run("implicit-euler", kepler(0.6), {20, 240, 1});
  REQUIRE(coarse.outcome.status == Status::diverged);
  const SolveTally& unsolved = coarse.outcome.solvers.at("implicit-stages");
  CHECK(unsolved.capped == 1);
  CHECK(!(unsolved.residual_max <= 1e-10));

  // A step that is rejected and repeated with a smaller h does not count as capped.
  const Recorded adaptive = run("radau5", kepler(0.9), {10, 1, 1}, "", 1e-6);
  REQUIRE(adaptive.outcome.status == Status::ok);
  CHECK(adaptive.outcome.solvers.at("implicit-stages").capped == 0);
}

TEST_CASE("radau5 with a tolerance: the error follows it, on a smooth orbit and on a stiff spring") {
  const auto orbit = [](double rtol) {
    const Recorded r = run("radau5", kepler(0.6), {10, 1000, 1}, "", rtol),
                   truth = run("gauss8", kepler(0.6), {10, 4000, 1});
    return distance(r.samples.at(1).bodies[0].p_m, truth.samples.at(1).bodies[0].p_m);
  };
  CHECK(orbit(1e-5) < 1e-3);
  CHECK(orbit(1e-9) < 1e-7);
  CHECK(orbit(1e-9) > 1e-13);
  const Recorded stiff = run("radau5", stiff_spring(2e6, 2e6), {3, 3000, 1}, "", 1e-6);
  CHECK(stiff.outcome.steps_taken < 200);  // an explicit method needs 1e6
}

}  // namespace
}  // namespace atwood::testing
