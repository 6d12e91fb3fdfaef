// Multistep methods: published coefficients, the recurrence as executed, starters, and a history that is dropped when
// it must.
#include <catch2/catch.hpp>

#include "integrators/multistep_tables.hpp"
#include "scenes.hpp"

namespace atwood::testing {
namespace {

bool same(const std::vector<Quad>& weights, const std::vector<double>& numerators, double denominator) {
  if (weights.size() != numerators.size()) return false;
  for (std::size_t i = 0; i < weights.size(); ++i)
    if (real::abs(weights[i] - Quad(numerators[i]) / Quad(denominator)) > 64 * real::epsilon<Quad>()) return false;
  return true;
}

// Hairer, Norsett, Wanner I, tables III.1.1 and III.1.2 and the lines below eq. III.1.22'.
TEST_CASE("Adams and BDF coefficients are the published fractions, in quad") {
  CHECK(same(adams_bashforth(4).rate, {55, -59, 37, -9}, 24));
  CHECK(same(adams_bashforth(6).rate, {4277, -7923, 9982, -7298, 2877, -475}, 1440));
  CHECK(
      same(adams_bashforth(8).rate, {434241, -1152169, 2183877, -2664477, 2102243, -1041723, 295767, -36799}, 120960));
  CHECK(same(adams_moulton(4).rate, {19, -5, 1}, 24));
  CHECK(same({adams_moulton(4).implicit}, {9}, 24));
  CHECK(same(adams_moulton(8).rate, {139849, -121797, 123133, -88547, 41499, -11351, 1375}, 120960));
  CHECK(same({adams_moulton(8).implicit}, {36799}, 120960));
  CHECK(same({bdf(5).implicit}, {60}, 137));
  // BDF 3: 11/6 y_(n+1) - 3 y_n + 3/2 y_(n-1) - 1/3 y_(n-2) = h f: in increments 11 d_0 - 7 d_1 + 2 d_2 = 6 h f
  CHECK(same(bdf(3).increment, {7, -2}, 11));
  CHECK(same({bdf(3).implicit}, {6}, 11));
}

// y = t^p through y_(n+1) = ...: exact up to the order, not beyond.
TEST_CASE("every multistep table is exact for polynomials up to its order, and no further") {
  const auto power = [](Quad t, int n) {
    Quad product = Quad(1);
    for (int k = 0; k < n; ++k) product *= t;
    return product;
  };
  const auto misfit = [&](const MultistepTable& t, int p) {  // n + 1 at time 1, h = 1
    Quad value = Quad(1) - t.implicit * Quad(p) - (p == 0 ? Quad(1) : Quad(0));
    for (std::size_t i = 0; i < t.increment.size(); ++i) {
      const Quad at = -Quad(static_cast<int>(i));
      value -= t.increment[i] * (power(at, p) - power(at - 1, p));
    }
    for (std::size_t j = 0; j < t.rate.size(); ++j)
      if (p > 0) value -= t.rate[j] * Quad(p) * power(-Quad(static_cast<int>(j)), p - 1);
    return static_cast<double>(real::abs(value));
  };
  std::vector<MultistepTable> tables;
  for (int k = 2; k <= 8; ++k) tables.insert(tables.end(), {adams_bashforth(k), adams_moulton(k)});
  for (int k = 1; k <= 5; ++k) tables.push_back(bdf(k));
  for (const MultistepTable& t : tables) {
    INFO(t.order << " " << t.rate.size() << " rates");
    for (int p = 1; p <= t.order; ++p) CHECK(misfit(t, p) < 1e-26);
    CHECK(misfit(t, t.order + 1) > 1e-3);
  }
}

struct March {
  RigidModel<double> model;
  std::unique_ptr<Stepper<double>> stepper;
  std::vector<double> y, y_new;
  double t = 0;
  March(const std::string& scheme, const Scene& scene)
      : model(scene), stepper(stepper_of(scheme, model)), y(model.state_size()), y_new(y.size()) {
    model.initial_state(y.data());
  }
  void steps(int count, double h) {
    for (int n = 0; n < count; ++n, t += h) {
      REQUIRE(stepper->step(t, h, y.data(), y_new.data()));
      y.swap(y_new);
    }
  }
};

std::vector<std::string> all_schemes() {
  std::vector<std::string> all;
  for (int k = 2; k <= 8; ++k)
    all.insert(all.end(), {"adams-bashforth" + std::to_string(k), "adams-moulton" + std::to_string(k)});
  for (int k = 1; k <= 5; ++k) all.push_back("bdf" + std::to_string(k));
  return all;
}

TEST_CASE("an edited state, another step size and another law start a multistep method afresh") {
  const double h = 1.0 / 64;
  for (const std::string& scheme : all_schemes())
    for (const Scene& scene : {kepler(0.3), thrust_and_drag()}) {
      INFO(scheme);
      const auto fresh_from = [&](const March& old, double step_s) {
        March fresh(scheme, scene);
        fresh.y = old.y;
        fresh.t = old.t;
        fresh.steps(12, step_s);
        return fresh.y;
      };
      March edited(scheme, scene);
      edited.steps(12, h);
      edited.y[kAtVelocity] += 0.25;  // an impulse
      const auto after_edit = fresh_from(edited, h);
      edited.steps(12, h);
      CHECK(edited.y == after_edit);

      March resized(scheme, scene);
      resized.steps(12, h);
      const auto after_resize = fresh_from(resized, h / 2);
      resized.steps(12, h / 2);
      CHECK(resized.y == after_resize);

      March switched(scheme, scene);
      switched.steps(12, h);
      ++switched.model.system().epoch;
      const auto after_switch = fresh_from(switched, h);
      switched.steps(12, h);
      CHECK(switched.y == after_switch);
      if (scheme != "bdf1" && scheme != "adams-moulton2" && scheme.back() <= '4') {  // the history is felt at all
        March steady(scheme, scene);
        steady.steps(24, h);
        CHECK(steady.y != after_switch);
      }
    }
}

TEST_CASE("a step retaken, whole or in part, leaves the history as it was") {
  const double h = 1.0 / 64;
  for (const std::string& scheme : all_schemes()) {
    INFO(scheme);
    March plain(scheme, kepler(0.3)), retaking(scheme, kepler(0.3));
    std::vector<double> part(plain.y.size());
    for (int n = 0; n < 24; ++n) {
      plain.steps(1, h);
      const double t = retaking.t;
      const std::vector<double> start = retaking.y;
      retaking.steps(1, h);
      REQUIRE(retaking.stepper->step(t, 0.3 * h, start.data(), part.data()));
      if (n % 2 == 0) {
        REQUIRE(retaking.stepper->step(t, h, start.data(), part.data()));
        CHECK(part == retaking.y);
      }
    }
    CHECK(plain.y == retaking.y);
  }
}

TEST_CASE("a thruster that switches at a step keeps the order") {
  Scene scene = thrust_and_drag();
  std::get<Thruster>(scene.forces[0]).on_s = {{0.5, 1.25}};
  const auto end = [&](const std::string& scheme, std::int64_t steps) {
    return run(scheme, scene, {2, steps, 1}, "long-double").samples.at(1).bodies[0].v_m_per_s;
  };
  const auto truth = end("gauss8", 512);
  for (const std::string scheme : {"adams-bashforth4", "adams-moulton4", "bdf4"}) {
    INFO(scheme);
    CHECK(std::log2(distance(end(scheme, 128), truth) / distance(end(scheme, 256), truth)) == Approx(4).margin(0.35));
  }
}

// The first steps, in quad: of an order above the method's own, so that their error never shows.
TEST_CASE("starters are of higher order than what they start") {
  const auto error = [](const std::string& scheme, int steps, double h_s) {
    const Plan plan{steps * h_s, steps, 1};
    const Recorded r = run(scheme, kepler(0.3), plan, "quad"),
                   truth = run("gauss8", kepler(0.3), {steps * h_s, 64 * steps, 1}, "quad");
    return distance(r.samples.at(1).bodies[0].p_m, truth.samples.at(1).bodies[0].p_m);
  };
  for (const std::string& scheme : all_schemes()) {
    const int order = scheme.back() - '0';
    if (order < 3) continue;
    INFO(scheme);
    const int first = order - (scheme[6] == 'm' || scheme[0] == 'b' ? 2 : 1);  // steps before the history suffices
    CHECK(std::log2(error(scheme, first, 0.03125) / error(scheme, first, 0.015625)) > order + 1.5);
  }
}

// AB 3, AM 3 and BDF 3 written out: what runs is the recurrence.
TEST_CASE("on the oscillator three of order 3 are their recurrences, to round-off") {
  const double h = 8.0 / 256, w2 = 4;
  const auto residual = [&](const char* scheme, auto formula) {
    const Recorded r = run(scheme, oscillator(), {8, 256, 256});
    double worst = 0;
    for (std::size_t n = 2; n < 256; ++n) {
      double x[4], v[4];  // oldest first, n + 1 last
      for (int k = 0; k < 4; ++k) {
        x[k] = static_cast<double>(r.samples[n - 2 + k].bodies[0].p_m[0]);
        v[k] = static_cast<double>(r.samples[n - 2 + k].bodies[0].v_m_per_s[0]);
      }
      const double a[4] = {-w2 * x[0], -w2 * x[1], -w2 * x[2], -w2 * x[3]};
      worst = std::max({worst, std::fabs(formula(x, v)), std::fabs(formula(v, a))});
    }
    return worst;
  };
  CHECK(residual("adams-bashforth3", [&](const double* y, const double* f) {
          return y[3] - y[2] - h / 12 * (23 * f[2] - 16 * f[1] + 5 * f[0]);
        }) < 2e-15);
  CHECK(residual("adams-moulton3", [&](const double* y, const double* f) {
          return y[3] - y[2] - h / 12 * (5 * f[3] + 8 * f[2] - f[1]);
        }) < 2e-15);
  CHECK(residual("bdf3", [&](const double* y, const double* f) {
          return (11 * y[3] - 18 * y[2] + 9 * y[1] - 2 * y[0]) / 6 - h * f[3];
        }) < 2e-14);
}

}  // namespace
}  // namespace atwood::testing
