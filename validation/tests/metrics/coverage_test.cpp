// Each 95 % interval on noisy series of known law, seeded: it covers in 93 to 97 % of 2000, orders in at least 93 %.
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <utility>

#include "validation/metrics/metrics.hpp"

using namespace atwood;

namespace {

constexpr int kSeries = 2000;

struct Noise {
  std::mt19937_64 random;
  std::normal_distribution<double> normal{0, 1};
  explicit Noise(unsigned seed) : random(seed) {}
  double operator()() { return normal(random); }
};

// x_i = rho x_(i-1) + sqrt(1 - rho^2) n_i: unit variance throughout.
std::vector<double> correlated(Noise& noise, std::size_t n, double rho) {
  std::vector<double> x;
  double now = noise();
  for (std::size_t i = 0; i < n; ++i) {
    x.push_back(now);
    now = rho * now + std::sqrt(1 - rho * rho) * noise();
  }
  return x;
}

void check_coverage(int covered, int of = kSeries) {
  CAPTURE(covered, of);
  CHECK(covered >= 0.93 * of);
  CHECK(covered <= 0.97 * of);
}

}  // namespace

TEST_CASE("coverage: order of a pure power, log-normal noise, 4 to 10 rungs, ratios 2 and 2^(1/4)") {
  constexpr int kLadders = 150;
  Noise noise(11);
  int all_held = 0, all_conclusive = 0;
  for (const int rungs : {4, 5, 6, 8, 10}) {
    int held = 0, conclusive = 0, all = 0;
    for (const auto& [ratio, sigma] : {std::pair{2.0, 0.003}, {2.0, 0.01}, {2.0, 0.03}, {std::pow(2, 0.25), 0.003}}) {
      if (rungs < 6 && ratio < 2) continue;  // a range of 1.7 or 2 in h tells no order under noise
      for (int ladder = 0; ladder < kLadders; ++ladder) {
        std::vector<double> h, e;
        for (int i = 0; i < rungs; ++i) {
          h.push_back(0.1 * std::pow(ratio, -i));
          e.push_back(3 * std::pow(h.back(), 4) * std::exp(sigma * noise()));
        }
        const OrderFit fit = fit_order(h, e, std::vector<double>(h.size(), 0));
        ++all;
        conclusive += fit.conclusive;
        held += fit.conclusive && std::fabs(fit.order - 4) <= fit.half_width_95;
      }
    }
    CAPTURE(rungs, held, conclusive, all);
    CHECK(conclusive > (rungs == 4 ? 0.75 : 0.9) * all);  // four rungs seldom tell scatter from curvature
    CHECK(held >= 0.91 * conclusive);                     // of so few
    all_held += held;
    all_conclusive += conclusive;
  }
  CAPTURE(all_held, all_conclusive);
  CHECK(all_held >= 0.93 * all_conclusive);
}

TEST_CASE("coverage: growth exponent of an ensemble of random walks and of their integrals") {
  constexpr int kRuns = 40, kSamples = 60, kSub = 8;
  Noise noise(12);
  std::vector<double> t;
  for (int i = 0; i <= kSamples; ++i) t.push_back(0.5 * i);
  int walk_covered = 0, phase_covered = 0, named = 0;
  for (int series = 0; series < kSeries; ++series) {
    std::vector<std::vector<double>> walk(kRuns, std::vector<double>(t.size())), phase = walk;
    for (int k = 0; k < kRuns; ++k) {
      double energy = 0, angle = 0;
      for (int i = 1; i <= kSamples * kSub; ++i) {
        const double kick = noise();
        angle += energy + kick / 2;
        energy += kick;
        if (i % kSub == 0) {
          walk[k][i / kSub] = energy;
          phase[k][i / kSub] = angle;
        }
      }
    }
    const GrowthFit e = fit_growth_ensemble(t, walk), p = fit_growth_ensemble(t, phase);
    walk_covered += std::fabs(e.exponent - 0.5) <= e.half_width_95;
    phase_covered += std::fabs(p.exponent - 1.5) <= p.half_width_95;
    named += (e.law == "t^1/2") + (p.law == "t^3/2");
  }
  check_coverage(walk_covered);
  check_coverage(phase_covered);
  CHECK(named > 0.9 * 2 * kSeries);  // what is not named is inconclusive, for its width
}

TEST_CASE("coverage: growth exponent of one run's error above the floor") {
  Noise noise(13);
  std::vector<double> t;
  for (int i = 0; i <= 120; ++i) t.push_back(i);
  for (const double exponent : {0.5, 1.0, 2.0}) {
    int covered = 0;
    for (int series = 0; series < kSeries; ++series) {
      std::vector<double> e;
      for (double x : t) e.push_back(1e-6 * std::pow(x, exponent) * std::exp(0.3 * noise()));
      const GrowthFit fit = fit_growth(t, e, 0);
      covered += std::fabs(fit.exponent - exponent) <= fit.half_width_95;
    }
    CAPTURE(exponent);
    check_coverage(covered);
  }
}

TEST_CASE("coverage: drift under white, correlated and periodic noise, of which none knows that it hides no walk") {
  Noise noise(14);
  constexpr double kSlope = 0.01;
  // `widest`: mean half-width over that of noise known to be white.
  const auto cover = [&](std::size_t n, double rho, double amplitude, double period, double least, double widest) {
    int covered = 0, stationary = 0;
    double width = 0;
    std::vector<double> t;
    for (std::size_t i = 0; i < n; ++i) t.push_back(static_cast<double>(i));
    for (int series = 0; series < kSeries; ++series) {
      std::vector<double> v = correlated(noise, n, rho);
      const double phase = noise();
      for (std::size_t i = 0; i < n; ++i)
        v[i] += kSlope * t[i] + amplitude * std::sin(6.283185307179586 * t[i] / period + phase);
      const DriftFit fit = fit_drift(t, v);
      if (!fit.stationary) continue;
      ++stationary;
      covered += std::fabs(fit.slope_per_s - kSlope) <= fit.half_width_95;
      width += fit.half_width_95;
    }
    const double white = 1.96 * std::sqrt(12 / std::pow(static_cast<double>(n), 3));
    CAPTURE(n, rho, amplitude, period, stationary, covered, width / stationary / white);
    CHECK(covered >= 0.93 * stationary);
    CHECK(width < widest * white * stationary);
    CHECK(stationary >= least * kSeries);
  };
  cover(61, 0, 0, 1, 0.95, 3);
  cover(121, 0, 0, 1, 0.95, 3);
  cover(61, 0.5, 0, 1, 0.75, 9);
  cover(121, 0.5, 0, 1, 0.95, 5);
  cover(121, 0.8, 0, 1, 0.65, 25);
  cover(61, 0, 10, 8.7, 0.9, 3);
}

TEST_CASE("coverage: drift of a random walk under white noise, which passes for stationary") {
  Noise noise(21);
  constexpr double kSlope = 0.01;
  constexpr int kWalks = 400;
  for (const int n : {61, 121})
    for (const double ratio : {1.0, 5.0, 10.0, 30.0}) {
      int covered = 0;
      double width = 0;
      for (int series = 0; series < kWalks; ++series) {
        std::vector<double> t, v;
        double walk = 0;
        for (int i = 0; i < n; ++i) {
          t.push_back(i);
          v.push_back(walk + kSlope * i + ratio * noise());
          walk += noise();
        }
        const DriftFit fit = fit_drift(t, v);
        covered += std::fabs(fit.slope_per_s - kSlope) <= fit.half_width_95;
        width += fit.half_width_95;
      }
      const double size = std::sqrt(1.2 / n + 12 * ratio * ratio / std::pow(static_cast<double>(n), 3));
      CAPTURE(n, ratio, covered, width / kWalks / size);
      CHECK(covered >= 0.88 * kWalks);
      CHECK(width < 5 * size * kWalks);
    }
}

TEST_CASE("coverage: drift of few samples, which do not show whether they are stationary") {
  Noise noise(22);
  constexpr double kSlope = 0.4;
  for (const int n : {5, 6, 9})
    for (const bool walks : {true, false}) {
      int covered = 0;
      for (int series = 0; series < kSeries; ++series) {
        std::vector<double> t, v;
        double walk = 0;
        for (int i = 0; i < n; ++i) {
          t.push_back(i);
          v.push_back(kSlope * i + (walks ? walk : noise()));
          walk += noise();
        }
        const DriftFit fit = fit_drift(t, v);
        CHECK_FALSE(fit.stationary);
        covered += std::fabs(fit.slope_per_s - kSlope) <= fit.half_width_95;
      }
      CAPTURE(n, walks, covered);
      CHECK(covered >= 0.93 * kSeries);
      if (walks) CHECK(covered <= 0.97 * kSeries);
    }
}

TEST_CASE("coverage: the mean slope of a random walk, whether or not it is seen not to be stationary") {
  Noise noise(18);
  constexpr double kSlope = 0.03;
  for (const int n : {61, 121, 241}) {
    int seen = 0, covered = 0, one_sign = 0;
    for (int series = 0; series < kSeries; ++series) {
      std::vector<double> t, v;
      double walk = 0;
      for (int i = 0; i < n; ++i) {
        t.push_back(i);
        v.push_back(walk);
        walk += kSlope + noise();
      }
      const DriftFit fit = fit_drift(t, v);
      seen += !fit.stationary;
      covered += std::fabs(fit.slope_per_s - kSlope) <= fit.half_width_95;
      one_sign += fit.one_sign;
    }
    CAPTURE(n, seen, covered, one_sign);
    CHECK(seen >= 0.93 * kSeries);
    check_coverage(covered);
    CHECK(one_sign <= 0.02 * kSeries);
  }
}

TEST_CASE("coverage: drift of an ensemble of random walks, by bootstrap over the runs") {
  Noise noise(19);
  constexpr double kSlope = 0.02;
  std::vector<double> t;
  for (int i = 0; i <= 60; ++i) t.push_back(i);
  for (const int runs : {32, 96}) {
    int covered = 0;
    for (int series = 0; series < kSeries; ++series) {
      std::vector<std::vector<double>> walks;
      for (int k = 0; k < runs; ++k) {
        walks.emplace_back();
        double walk = 0;
        for (double x : t) {
          walks.back().push_back(kSlope * x + walk);
          walk += noise();
        }
      }
      const EnsembleDrift drift = fit_drift_ensemble(t, walks);
      covered += std::fabs(drift.slope_per_s - kSlope) <= drift.half_width_95;
    }
    CAPTURE(runs);
    check_coverage(covered);
  }
  const std::vector<std::vector<double>> few(31, t);
  CHECK(std::isnan(fit_drift_ensemble(t, few).slope_per_s));
  CHECK(fit_drift_ensemble(t, few).reason == "31 runs, a drift at the floor needs 32");
}

TEST_CASE("coverage: slope of error against tolerance") {
  Noise noise(15);
  int covered = 0;
  for (int series = 0; series < kSeries; ++series) {
    std::vector<double> rtol, error;
    for (int k = 3; k <= 12; ++k) {
      rtol.push_back(std::pow(10, -k));
      error.push_back(20 * std::pow(rtol.back(), 0.9) * std::exp(0.4 * noise()));
    }
    const ToleranceFit fit = fit_tolerance(rtol, error, {});
    covered += fit.conclusive && std::fabs(fit.exponent - 0.9) <= fit.half_width_95;
  }
  check_coverage(covered);
}

TEST_CASE("coverage: Lyapunov exponent from stretches correlated with their neighbours") {
  Noise noise(16);
  for (const double rho : {0.0, 0.5}) {
    int covered = 0;
    for (int series = 0; series < kSeries; ++series) {
      std::vector<double> local = correlated(noise, 120, rho);
      for (double& x : local) x = 0.9 + 0.5 * x;
      const LyapunovFit fit = fit_lyapunov(local, 1);
      covered += fit.resolved && std::fabs(fit.exponent_per_s - 0.9) <= fit.half_width_95;
    }
    CAPTURE(rho);
    check_coverage(covered);
  }
}

TEST_CASE("coverage: orders of errors whose next term is half a power higher") {
  for (const double p : {1.0, 2.0, 3.0, 4.0})
    for (const double a : {-0.5, -0.2, 0.3, 1.0, 3.0})
      for (const int rungs : {5, 6, 8}) {
        std::vector<double> h, e;
        for (int k = 0; k < rungs; ++k) {
          h.push_back(0.1 * std::pow(0.5, k));
          e.push_back(std::pow(h.back(), p) * (1 + a * std::sqrt(h.back())));
        }
        const OrderFit fit = fit_order(h, e, {});
        CAPTURE(p, a, rungs, fit.order, fit.half_width_95);
        CHECK((!fit.conclusive || std::fabs(fit.order - p) <= fit.half_width_95));
      }
}

TEST_CASE("coverage: rates of exponential growth that sets in") {
  Noise noise(23);
  int found = 0;
  for (const double scatter : {0.0, 0.02})
    for (const double k : {5.0, 6.0, 8.0, 10.0, 14.0, 20.0})
      for (int shape = 0; shape < 3; ++shape) {
        std::vector<double> t, e;
        for (int i = 0; i <= 240; ++i) {
          t.push_back(i / 240.0);
          const double x = k * t.back();
          const double grown = shape == 0   ? std::exp(x)
                               : shape == 1 ? std::expm1(x)
                                            : std::sinh(x) + 0.5 * std::exp(0.3 * x);
          e.push_back(1e-6 * std::fabs(grown) * std::exp(scatter * noise()));
        }
        const GrowthFit fit = fit_growth(t, e, 0);
        CAPTURE(scatter, k, shape, fit.law, fit.reason);
        if (fit.law != "exponential") continue;
        ++found;
        CHECK(std::fabs(fit.rate_per_s - k) <= fit.rate_half_width_95);
      }
  CHECK(found >= 30);
}
