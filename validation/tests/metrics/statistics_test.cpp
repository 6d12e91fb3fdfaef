// Statistics against published figures, and what they say when there is nothing to tell.
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <random>

#include "validation/metrics/metrics.hpp"

using namespace atwood;

namespace {

GridConvergence of(double h1, double f1, double h2, double f2, double h3, double f3) {
  return grid_convergence({h1, {f1}}, {h2, {f2}}, {h3, {f3}});
}

}  // namespace

TEST_CASE(
    "grid convergence: pressure recovery of a supersonic inlet on three grids (NPARC Alliance, after Roache 1998)") {
  const GridConvergence g = of(1, 0.97050, 2, 0.96854, 4, 0.96178);
  CHECK(g.kind == GridConvergence::Kind::monotone);
  CHECK(g.order == Approx(1.786170).epsilon(1e-6));
  CHECK(g.extrapolated.at(0) == Approx(0.971300).epsilon(1e-6));
  // Both published indices are relative, in per cent, each over its own finer value.
  CHECK(100 * g.index / 0.97050 == Approx(0.103083).epsilon(1e-5));
  CHECK(100 * g.index_coarse / 0.96854 == Approx(0.356249).epsilon(1e-5));
}

TEST_CASE("grid convergence: unequal ratios and oscillation (Celik et al. 2008, table 1)") {
  // Reattachment length over a backward-facing step, N = 18000, 8000, 4500 cells.
  const GridConvergence length = of(1, 6.063, 1.5, 5.972, 1.5 * 1.333, 5.863);
  CHECK(length.kind == GridConvergence::Kind::monotone);
  CHECK(length.order == Approx(1.53).margin(0.01));
  CHECK(length.extrapolated.at(0) == Approx(6.1685).margin(2e-3));
  CHECK(100 * length.index / 6.063 == Approx(2.2).margin(0.05));
  // Axial velocity at a point, p < 1; N = 18000, 4500, 980 cells.
  const GridConvergence velocity = of(1, 10.7880, 2, 10.7250, 2 * 2.143, 10.6050);
  CHECK(velocity.order == Approx(0.75).margin(0.01));
  CHECK(velocity.extrapolated.at(0) == Approx(10.8801).margin(2e-3));
  CHECK(100 * velocity.index / 10.7880 == Approx(1.1).margin(0.05));
  // Oscillatory convergence.
  const GridConvergence wavy = of(1, 6.0042, 2, 5.9624, 2 * 2.143, 6.0909);
  CHECK(wavy.kind == GridConvergence::Kind::oscillatory);
  CHECK(wavy.order == Approx(1.51).margin(0.01));
  CHECK(100 * wavy.index / 6.0042 == Approx(0.5).margin(0.05));
}

TEST_CASE("grid convergence: the asymptotic range is told by a fourth grid, never by three") {
  // h^2 + 8 h^3 far from its asymptotic range: whatever three steps say of themselves, they agree with themselves.
  const auto f = [](double h) { return 1 + h * h + 8 * h * h * h; };
  const auto order = [&](double h) { return of(h, f(h), 2 * h, f(2 * h), 4 * h, f(4 * h)).order; };
  const GridConvergence g = of(0.1, f(0.1), 0.2, f(0.2), 0.4, f(0.4));
  CHECK(g.index_coarse / (std::pow(2, g.order) * g.index) == Approx(1).epsilon(1e-12));
  CHECK(asymptotic_range(order(0.02), order(0.04), 0) == AsymptoticRange::disagrees);  // 2.35 and 2.51
  CHECK(asymptotic_range(2.75, 2.80, 0) == AsymptoticRange::agrees);                   // with each other,
  CHECK(asymptotic_range(2.75, 2.80, 2) == AsymptoticRange::disagrees);                // not with the formal order
  CHECK(asymptotic_range(order(0.001), order(0.002), 2) == AsymptoticRange::agrees);
  CHECK(asymptotic_range(2, std::nan(""), 2) == AsymptoticRange::not_tested);
}

TEST_CASE("grid convergence: what diverges says so, with a negative order and no index") {
  const GridConvergence g = of(1, 1.0, 2, 1.4, 4, 1.5);
  CHECK(g.kind == GridConvergence::Kind::divergent);
  CHECK(g.order == Approx(-2));
  CHECK(g.extrapolated.empty());
  CHECK(of(1, 1.0, 2, 1.0, 4, 2.0).kind == GridConvergence::Kind::none);
  CHECK(of(1, 1.0, 2, 0.5, 4, std::nan("")).kind == GridConvergence::Kind::divergent);
}

// Ratios at which the fixed point of Celik et al. repels: the order is found all the same.
TEST_CASE("grid convergence: the order of C h^p is found at any ratios") {
  for (const auto& [r21, r32] : {std::pair{1.5, 3.0}, {2.0, 4.0}, {4.0, 1.1}, {1.1, 4.0}, {1.2, 1.5}})
    for (const double p : {-2.0, -1.0, 0.25, 1.0, 2.0, 4.0, 6.0}) {
      const double h2 = r21, h3 = r21 * r32;
      const GridConvergence g = of(1, 1, h2, std::pow(h2, p), h3, std::pow(h3, p));
      CAPTURE(r21, r32, p);
      CHECK(g.kind == (p > 0 ? GridConvergence::Kind::monotone : GridConvergence::Kind::divergent));
      CHECK(g.order == Approx(p).epsilon(1e-10));
      if (p > 0) CHECK(std::fabs(g.extrapolated.at(0)) < 1e-9);
    }
  CHECK(of(1, 1, 1.001, 1 + 1e-12, 1.01, 2).kind == GridConvergence::Kind::not_found);
}

TEST_CASE("grid convergence: of a vector, by its norm; the index bounds the error of a smooth law") {
  const auto at = [](double h) {
    return GridLevel{h, {1 + 3 * std::pow(h, 4), 2 - std::pow(h, 4) + 5 * std::pow(h, 5), 0}};
  };
  const GridConvergence g = grid_convergence(at(0.01), at(0.02), at(0.04));
  CHECK(g.kind == GridConvergence::Kind::monotone);
  CHECK(g.order == Approx(4).margin(0.1));
  const double error = std::hypot(3e-8, 1e-8);
  CHECK(error < g.index);
  CHECK(g.index < 1.5 * error);
  CHECK(g.extrapolated[0] == Approx(1).margin(3e-9));
}

TEST_CASE("ensemble growth: biased rounding is told from unbiased; too few runs and no difference are inconclusive") {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal(0, 1);
  std::vector<double> t;
  for (int i = 0; i <= 60; ++i) t.push_back(i);
  std::vector<std::vector<double>> energy(64, std::vector<double>(t.size())), phase = energy;
  for (std::size_t k = 0; k < energy.size(); ++k)
    for (std::size_t i = 0; i < t.size(); ++i) {
      energy[k][i] = 1e-16 * (t[i] + 0.1 * normal(random));
      phase[k][i] = 1e-16 * t[i] * t[i] * (1 + 0.1 * normal(random));
    }
  CHECK(fit_growth_ensemble(t, energy).law == "t");
  CHECK(fit_growth_ensemble(t, phase).law == "t^2");
  energy.resize(31);
  CHECK(fit_growth_ensemble(t, energy).reason.find("31 runs") == 0);
  CHECK(fit_growth_ensemble(t, std::vector<std::vector<double>>(40, std::vector<double>(t.size()))).law ==
        "inconclusive");
}

TEST_CASE("Lyapunov exponent: the Lorenz system's 0.9056 (Sprott 2003) lies in its interval") {
  using State = std::array<double, 3>;
  const auto rate = [](const State& y) {
    return State{10 * (y[1] - y[0]), y[0] * (28 - y[2]) - y[1], y[0] * y[1] - 8.0 / 3 * y[2]};
  };
  const auto step = [&](State y, double h) {
    const auto at = [&](const State& k, double s) { return State{y[0] + s * k[0], y[1] + s * k[1], y[2] + s * k[2]}; };
    const State k1 = rate(y), k2 = rate(at(k1, h / 2)), k3 = rate(at(k2, h / 2)), k4 = rate(at(k3, h));
    for (int i = 0; i < 3; ++i) y[i] += h / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]);
    return y;
  };
  State y{1, 0, 0}, twin{1 + 1e-8, 0, 0};
  std::vector<double> local;
  for (int stretch = 0; stretch < 1000; ++stretch) {
    for (int i = 0; i < 100; ++i) {
      y = step(y, 0.005);
      twin = step(twin, 0.005);
    }
    const double d = std::hypot(twin[0] - y[0], twin[1] - y[1], twin[2] - y[2]);
    local.push_back(std::log(d / 1e-8) / 0.5);
    for (int i = 0; i < 3; ++i) twin[i] = y[i] + 1e-8 * (twin[i] - y[i]) / d;
  }
  const LyapunovFit fit = fit_lyapunov(local, 0.5);
  CHECK(fit.resolved);
  CAPTURE(fit.exponent_per_s, fit.half_width_95);
  CHECK(std::fabs(fit.exponent_per_s - 0.9056) <= fit.half_width_95);
  CHECK(fit.half_width_95 < 0.05);
  CHECK(fit_lyapunov(std::vector<double>(8, 1.0), 1).stretches == 0);
}

TEST_CASE("Lyapunov: separation that grows like a power of time resolves no exponent; e-foldings above t^2 do") {
  // The distance at the end of each of 60 stretches of 0.5 s.
  const auto fitted = [](const std::function<double(double)>& log_distance) {
    std::vector<double> local;
    for (int k = 0; k < 60; ++k) local.push_back((log_distance(0.5 * (k + 1)) - log_distance(0.5 * k)) / 0.5);
    return fit_lyapunov(local, 0.5);
  };
  for (const double offset : {0.01, 1.0, 30.0})
    for (const double power : {1.0, 2.0}) {
      const LyapunovFit fit = fitted([&](double t) { return power * std::log(t + offset); });
      CAPTURE(offset, power, fit.exponent_per_s, fit.half_width_95);
      CHECK(fit.exponent_per_s > fit.half_width_95);
      CHECK_FALSE(fit.resolved);
    }
  // Of a nearly circular orbit: linear with an oscillation. Neighbours first approach each other.
  CHECK_FALSE(fitted([](double t) { return std::log(1 + 0.4 * t + 0.3 * std::sin(2 * t)); }).resolved);
  CHECK_FALSE(fitted([](double t) { return 0.5 * std::log(1 + (t - 2) * (t - 2)); }).resolved);
  const LyapunovFit chaos = fitted([](double t) { return 0.4 * t + 0.2 * std::sin(t); });
  CHECK(chaos.resolved);
  CHECK(chaos.exponent_per_s == Approx(0.4).margin(chaos.half_width_95));
  CHECK(fitted([](double t) { return -0.4 * t; }).resolved);
  CHECK(fitted([](double t) { return 0.2 * std::sin(t); }).resolved);  // the interval holds 0
}

TEST_CASE("tolerances: the slope, what lies at the floor left out, too few inconclusive") {
  std::vector<double> rtol, error;
  for (int k = 3; k <= 14; ++k) {
    rtol.push_back(std::pow(10, -k));
    error.push_back(5 * rtol.back() + 1e-13);
  }
  const ToleranceFit fit = fit_tolerance(rtol, error, std::vector<double>(rtol.size(), 1e-13));
  CHECK(fit.conclusive);
  CHECK(fit.exponent == Approx(1).margin(0.01));
  CHECK(fit.used == 10);  // down to 5.1e-12 beside 30 x 1e-13
  CHECK_FALSE(fit_tolerance(rtol, error, std::vector<double>(rtol.size(), 1e-6)).conclusive);
}
