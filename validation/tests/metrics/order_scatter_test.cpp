// Orders of errors that scatter, h^p (1 + a h / h_0) exp(sigma N) with h_0 the coarsest step: the 95 % interval holds p
// in at least 93 % of the conclusive fits, few are inconclusive where a and sigma are small, and the intervals are not
// much wider than the narrowest that would do.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>

#include "validation/metrics/metrics.hpp"

using namespace atwood;

namespace {

// 1 + 0.1 cos(...): of a period of two to three rungs, or of another phase on each. Longer periods are no scatter but a
// change of slope that four to nine rungs cannot tell from a power.
enum class Factor { none, periodic, aliased };

struct Family {
  int rungs = 5;
  double ratio = 2, order = 2, a = 0, sigma = 0, floor = 0;
  Factor factor = Factor::none;
};

struct Draws {
  std::mt19937_64 random;
  std::normal_distribution<double> normal{0, 1};
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); }

  OrderFit fit(const Family& f) {
    constexpr double turn = 2 * std::numbers::pi;
    const double phase = uniform(0, turn), turns = uniform(0.3, 0.5), size = f.factor == Factor::none ? 0 : 0.1;
    std::vector<double> h, error, floor;
    for (int i = 0; i < f.rungs; ++i) {
      const double z = std::pow(f.ratio, -i), at = f.factor == Factor::periodic ? turns * i : uniform(0, 1);
      h.push_back(0.1 * z);
      error.push_back(std::pow(h.back(), f.order) * (1 + f.a * z) * (1 + size * std::cos(phase + turn * at)) *
                      std::exp(f.sigma * normal(random)));
    }
    floor.assign(h.size(), f.floor * error.back());
    return fit_order(h, error, floor);
  }
};

struct Count {
  int held = 0, conclusive = 0, all = 0;
  std::vector<double> half_width, share;  // share: of the half-width that p needs
  void add(const OrderFit& fit, double order) {
    ++all;
    if (!fit.conclusive) return;
    ++conclusive;
    held += std::fabs(fit.order - order) <= fit.half_width_95;
    half_width.push_back(fit.half_width_95);
    share.push_back(std::fabs(fit.order - order) / fit.half_width_95);
  }
};

double quantile_of(std::vector<double> x, double p) {
  std::sort(x.begin(), x.end());
  return x.empty() ? 0 : x[std::min(x.size() - 1, static_cast<std::size_t>(p * static_cast<double>(x.size())))];
}

// Mean half-width of the 93 % interval of an observer who knows the model and estimates its four parameters (Student's
// t of the fit's tangent at the true a; two degrees of freedom, where the mean of s is sigma sqrt(pi) / 2).
double narrowest(const Family& f) {
  constexpr double t_of_2 = 3.5782;  // quantile 0.965
  double m[3][3] = {};
  for (int i = 0; i < f.rungs; ++i) {
    const double z = std::pow(f.ratio, -i), row[3] = {1, std::log(z), z / (1 + f.a * z)};
    for (int j = 0; j < 3; ++j)
      for (int k = 0; k < 3; ++k) m[j][k] += row[j] * row[k];
  }
  const double minor = m[0][0] * m[2][2] - m[0][2] * m[0][2];
  const double determinant = m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[1][2]) -
                             m[0][1] * (m[0][1] * m[2][2] - m[1][2] * m[0][2]) +
                             m[0][2] * (m[0][1] * m[1][2] - m[1][1] * m[0][2]);
  return t_of_2 * std::sqrt(std::numbers::pi) / 2 * f.sigma * std::sqrt(minor / determinant);
}

}  // namespace

TEST_CASE("order with scatter: five rungs, a to 3 and sigma to 30 %") {
  constexpr int kLadders = 120;
  for (const double sigma : {0.01, 0.03, 0.1, 0.2, 0.3}) {
    Draws draws{std::mt19937_64(41)};
    Count of_sigma;
    for (const double a : {0.0, 0.5, 1.0, 2.0, 3.0}) {
      Count count;
      Family family;
      family.a = a;
      family.sigma = sigma;
      for (int i = 0; i < kLadders; ++i) {
        const OrderFit fit = draws.fit(family);
        count.add(fit, family.order);
        of_sigma.add(fit, family.order);
      }
      const double median = quantile_of(count.half_width, 0.5);
      CAPTURE(a, sigma, count.held, count.conclusive, median, narrowest(family));
      CHECK(count.held + (count.all - count.conclusive) >= 0.93 * count.all);
      if (sigma <= 0.1) CHECK(count.held >= 0.9 * count.conclusive);  // of so few
      if (a > 1 || sigma > 0.03) continue;
      CHECK(count.conclusive >= 0.9 * count.all);
      CHECK(median <= 2.5 * narrowest(family));
      CHECK(quantile_of(count.share, 0.93) >= 1 / 2.5);  // the same interval, scaled until it holds 93 %
    }
    CAPTURE(sigma, of_sigma.held, of_sigma.conclusive, of_sigma.all);
    if (sigma <= 0.1) CHECK(of_sigma.held >= 0.93 * of_sigma.conclusive);
    // Of such noise five rungs tell no order; those that happen to lie close to a curve are not to be many.
    else CHECK(of_sigma.conclusive <= 0.45 * of_sigma.all);
  }
}

TEST_CASE(
    "order with scatter: ladders of four to nine rungs and any ratio, oscillating factors, with and without bars") {
  constexpr int kLadders = 400;
  for (const Factor factor : {Factor::none, Factor::periodic, Factor::aliased})
    for (const double floor : {0.0, 1e-9, 1e-3}) {
      Draws draws{std::mt19937_64(42)};
      Count count;
      for (int i = 0; i < kLadders; ++i) {
        constexpr double orders[] = {0.5, 1, 2, 4, 8};
        const Family family{4 + static_cast<int>(draws.uniform(0, 6)),
                            std::exp2(draws.uniform(0.25, 1)),
                            orders[static_cast<int>(draws.uniform(0, 5))],
                            draws.uniform(0, 3),
                            0.3 * std::pow(draws.uniform(0, 1), 2),
                            floor,
                            factor};
        count.add(draws.fit(family), family.order);
      }
      CAPTURE(static_cast<int>(factor), floor, count.held, count.conclusive, count.all);
      CHECK(count.held >= 0.93 * count.conclusive);
      CHECK(count.conclusive >= 0.2 * count.all);
    }
}
