// Exponents of time against the number of bodies.
#include <catch2/catch.hpp>

#include <cmath>
#include <random>
#include <vector>

#include "validation/metrics/metrics.hpp"

using namespace atwood;

namespace {

const std::vector<double> ladder{1e3, 2e3, 4e3, 8e3, 1.6e4, 3.2e4, 6.4e4};

template <class Law> std::vector<double> times(const Law& law) {
  std::vector<double> t;
  for (const double n : ladder) t.push_back(law(n));
  return t;
}

}  // namespace

TEST_CASE("scaling: exact power laws give their exponents") {
  const ScalingFit square = fit_scaling(ladder, times([](double n) { return 3e-9 * n * n; }));
  CHECK(square.rungs == 7);
  CHECK(square.exponent == Approx(2));
  CHECK(square.half_width_95 < 1e-9);
  const ScalingFit n_log_n = fit_scaling(ladder, times([](double n) { return 1e-7 * n * std::log(n); }));
  CHECK(n_log_n.exponent_over_log == Approx(1));
  CHECK(n_log_n.half_width_over_log_95 < 1e-9);
  CHECK(n_log_n.exponent > 1.1);   // the log of N shows
  CHECK(n_log_n.exponent < 1.15);  // d ln(N ln N) / d ln N = 1 + 1 / ln N, ln N from 6.9 to 11.1
}

// Times with 5 % of noise, of N^1.3: the interval holds the exponent in 95 of 100, within what 2000 draws can tell.
TEST_CASE("scaling: the 95 % interval covers the exponent") {
  std::mt19937_64 random(5);
  std::normal_distribution<double> noise(0, 0.05);
  int covered = 0;
  for (int draw = 0; draw < 2000; ++draw) {
    const ScalingFit fit =
        fit_scaling(ladder, times([&](double n) { return 1e-8 * std::pow(n, 1.3) * std::exp(noise(random)); }));
    covered += std::abs(fit.exponent - 1.3) < fit.half_width_95;
  }
  CHECK(covered > 0.93 * 2000);
  CHECK(covered < 0.97 * 2000);
}

TEST_CASE("scaling: fewer than four rungs give NaN") {
  const std::vector<double> few{1e3, 2e3, 4e3}, no_time{1e-3, 0, std::nan(""), 2e-3};
  CHECK(std::isnan(fit_scaling(few, few).exponent));
  CHECK(fit_scaling(std::vector<double>{1e3, 2e3, 3e3, 4e3}, no_time).rungs == 2);
}
