// Compliant contacts, against Runge-Kutta steps on the law as stated in the scene format.
#include <catch2/catch.hpp>

#include "closed_form/hertz_phase.hpp"
#include "scenes.hpp"
#include "validation/tests/catalogued.hpp"

using namespace atwood;
using namespace atwood::testing;

namespace {

// Along x: the overlap of both, and the force on `right` (or the wall).
double force(const PairLaw& law, double R, double d, double rate) {
  if (d <= 0) return 0;
  if (law.contact_law == ContactLaw::hertz)
    return 4.0 / 3 * law.modulus_Pa * std::sqrt(R) * std::pow(d, 1.5) * (1 + law.damping_s_per_m * rate);
  const double f = law.stiffness_N_per_m * d + law.damping_N_s_per_m * rate;
  return law.pull || f > 0 ? f : 0;
}

struct End {
  double x[2], v[2], impulse;
};

End march(const Scenario& given, int steps) {
  const Scene& scene = given.scene;
  const bool wall = scene.bodies[1].fixed;
  const double r0 = std::get<Sphere>(scene.bodies[0].shape).radius_m;
  const double r1 = wall ? 0 : std::get<Sphere>(scene.bodies[1].shape).radius_m;
  const double inverse0 = 1 / scene.bodies[0].mass_kg, inverse1 = wall ? 0 : 1 / scene.bodies[1].mass_kg;
  const PairLaw& law = pair_law(scene, 0, 1);
  const double R = wall ? r0 : r0 * r1 / (r0 + r1), h = given.t_end_s / steps;
  double y[5] = {scene.bodies[0].position_m[0], wall ? 0.0625 : scene.bodies[1].position_m[0],
                 scene.bodies[0].velocity_m_per_s[0], scene.bodies[1].velocity_m_per_s[0], 0};
  const auto rates = [&](const double* at, double* out) {
    const double f = force(law, R, at[0] + r0 - at[1] + r1, at[2] - at[3]);
    out[0] = at[2], out[1] = at[3], out[2] = -f * inverse0, out[3] = f * inverse1, out[4] = f;
  };
  for (int k = 0; k < steps; ++k) {
    double k1[5], k2[5], k3[5], k4[5], at[5];
    rates(y, k1);
    for (int i = 0; i < 5; ++i) at[i] = y[i] + h / 2 * k1[i];
    rates(at, k2);
    for (int i = 0; i < 5; ++i) at[i] = y[i] + h / 2 * k2[i];
    rates(at, k3);
    for (int i = 0; i < 5; ++i) at[i] = y[i] + h * k3[i];
    rates(at, k4);
    for (int i = 0; i < 5; ++i) y[i] += h / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]);
  }
  return {{y[0], y[1]}, {y[2], y[3]}, y[4]};
}

void require_march(Scenario given) {
  for (const double share : {0.5, 1.0}) {
    Scenario part = given;
    part.t_end_s = share * given.t_end_s;
    const Truth truth = closed_form_truth(part, 60);
    INFO(given.id << " to " << part.t_end_s << ": " << truth.outcome.reason);
    REQUIRE(truth.outcome.status == Status::ok);
    const End near = march(part, 1000000);
    for (int i = 0; i < (part.scene.bodies[1].fixed ? 1 : 2); ++i) {
      CHECK(near.x[i] == Approx(static_cast<double>(truth.values.back().bodies[i].p_m[0])).margin(2e-7));
      CHECK(near.v[i] == Approx(static_cast<double>(truth.values.back().bodies[i].v_m_per_s[0])).margin(2e-5));
    }
    if (share == 1) CHECK(near.impulse == Approx(static_cast<double>(truth.events[0].impulse_n_N_s)).epsilon(2e-5));
  }
}

}  // namespace

TEST_CASE("Penalty contacts agree with an integration of their law in small steps, during and after the contact") {
  for (const char* id : {"penalty-linear", "penalty-linear-pull", "penalty-linear-pair", "penalty-hertz"}) {
    Scenario given = catalogued(id);
    require_march(given);
    const Truth truth = closed_form_truth(given, 60);
    REQUIRE(truth.events.size() == 2);
    // End in the middle of the touch too: at a third and two thirds of it.
    for (const double into : {1.0 / 3, 2.0 / 3}) {
      given.t_end_s = static_cast<double>(truth.events[0].t_s + (truth.events[1].t_s - truth.events[0].t_s) * into);
      const Truth inside = closed_form_truth(given, 60);
      const End near = march(given, 1000000);
      CHECK(near.x[0] == Approx(static_cast<double>(inside.values.back().bodies[0].p_m[0])).margin(2e-7));
      CHECK(near.v[0] == Approx(static_cast<double>(inside.values.back().bodies[0].v_m_per_s[0])).margin(2e-5));
    }
  }
}

TEST_CASE("Restitution of the linear laws, and how long each touch lasts") {
  const double z = 0.2, w0 = 200, w_d = w0 * std::sqrt(1 - z * z);
  const auto realised = [](const Truth& truth) {
    return static_cast<double>(-truth.values.back().bodies[0].v_m_per_s[0] /
                               truth.values.front().bodies[0].v_m_per_s[0]);
  };
  const auto lasts = [](const Truth& truth) { return static_cast<double>(truth.events[1].t_s - truth.events[0].t_s); };
  const Truth clamped = closed_form_truth(catalogued("penalty-linear"), 60);
  CHECK(realised(clamped) == Approx(std::exp(-2 * z * std::acos(z) / std::sqrt(1 - z * z))).epsilon(1e-14));
  CHECK(lasts(clamped) == Approx(2 * std::acos(z) / w_d).epsilon(1e-13));
  const Truth pulls = closed_form_truth(catalogued("penalty-linear-pull"), 60);
  CHECK(realised(pulls) == Approx(std::exp(-M_PI * z / std::sqrt(1 - z * z))).epsilon(1e-14));
  CHECK(lasts(pulls) == Approx(M_PI / w_d).epsilon(1e-13));
  // Elastic: 2 / 5 sqrt(pi) Gamma(2/5) / Gamma(9/10) = 1.4716 times d_m / v, each way.
  const Truth hertz = closed_form_truth(catalogued("penalty-hertz"), 60);
  const double m = 0.75, v = 1.5, K = 4.0 / 3 * 5e5 * std::sqrt(0.125 * 0.25 / 0.375);
  const double deepest = std::pow(5 * m * v * v / (4 * K), 0.4);
  CHECK(lasts(hertz) ==
        Approx(0.8 * std::sqrt(M_PI) * std::tgamma(0.4) / std::tgamma(0.9) * deepest / v).epsilon(1e-13));
  CHECK(static_cast<double>(hertz.values.back().bodies[0].v_m_per_s[0]) == Approx(1 - 2 * m * v).epsilon(1e-14));
  CHECK(static_cast<double>(hertz.values.back().bodies[1].v_m_per_s[0]) == Approx(-0.5 + 2 * m * v / 3).epsilon(1e-14));
  for (const SampleView bar : hertz.bars) CHECK(static_cast<double>(bar.bodies[0].p_m[0]) < 1e-28);
}

TEST_CASE("Contacts that penalty has no closed form for are refused") {
  Scenario given = catalogued("penalty-linear");
  for (PairLaw& law : given.scene.pairs) law.damping_N_s_per_m = 500;
  CHECK_THAT(closed_form_truth(given, 60).outcome.reason, Catch::Contains("overdamped"));
  given = catalogued("penalty-hertz");
  given.scene.bodies[1].velocity_m_per_s[1] = 0.1;
  CHECK_THAT(closed_form_truth(given, 60).outcome.reason, Catch::Contains("along the line of centres"));
  given = catalogued("head-on");
  given.truth.solution = "penalty";
  CHECK_THAT(closed_form_truth(given, 60).outcome.reason, Catch::Contains("rigid"));
}

TEST_CASE("Newton's method for the phase of a Hertz contact says whether it converged") {
  using closed_form::hertz_phase;
  // dt/da of this clock is that of the contact to a factor: 4 d_m / (5 v) = 1.
  const auto clock = [](long double a) { return a; };
  const auto met = hertz_phase<long double>(0.25L, 0.8L, 1.0L, [](long double a) { return std::pow(a, 0.8L) / 0.8L; });
  CHECK(met.converged);
  CHECK(static_cast<double>(met.a) == Approx(std::pow(0.2, 1.25)).epsilon(1e-15));
  CHECK(hertz_phase<long double>(0.25L, 0.8L, 1.0L, clock).converged);
  // A clock that never shows the time, and one that is not a number.
  CHECK_FALSE(hertz_phase<long double>(0.25L, 0.8L, 1.0L, [](long double) { return 0.3L; }).converged);
  CHECK_FALSE(hertz_phase<long double>(0.25L, 0.8L, 1.0L, [](long double) { return std::nanl(""); }).converged);
}
