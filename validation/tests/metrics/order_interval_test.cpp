// Orders of deterministic ladders, whose deviations from a power law are no noise: the interval holds the order, or the
// fit says inconclusive.
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "validation/metrics/metrics.hpp"

using namespace atwood;

namespace {

struct Ladder {
  int order = 0;
  std::vector<double> h, error, floor;
};

std::vector<double> ladder_of(double coarsest, double ratio, int rungs) {
  std::vector<double> h;
  for (int i = 0; i < rungs; ++i) h.push_back(coarsest * std::pow(ratio, -i));
  return h;
}

// What the truth or round-off adds to every rung: nothing; a draw for each rung; one and the same offset.
enum class Bar { none, drawn, shared };

// The norm of 1 to 3 components C h^p (1 + a h^q + b h^2q), p = 1 to 8, q = 1 or 2, a and b of size 0.1 to 10, of
// steps from 1 down to 1e-2 at the coarsest rung; the bar between a thousandth of the finest error and all of it.
struct Family {
  std::mt19937_64 random;
  std::uniform_real_distribution<double> uniform{0, 1};
  std::normal_distribution<double> normal{0, 1};

  Ladder next(Bar bar) {
    constexpr int kOrders[] = {1, 2, 3, 4, 5, 6, 8};
    const double ratios[] = {2, 2, std::sqrt(2), std::pow(2, 0.25)};
    Ladder l;
    l.order = kOrders[static_cast<int>(uniform(random) * 7)];
    const int q = uniform(random) < 0.67 ? 1 : 2, components = 1 + static_cast<int>(uniform(random) * 3);
    const double ratio = ratios[static_cast<int>(uniform(random) * 4)];
    const int rungs = 5 + static_cast<int>(uniform(random) * (ratio == 2 ? 6 : 9));
    l.h = ladder_of(std::pow(10, -2 + 2 * uniform(random)), ratio, rungs);
    l.error.assign(l.h.size(), 0);
    const double size = std::pow(10, -1 + 2 * uniform(random));
    for (int c = 0; c < components; ++c) {
      const double scale = normal(random), a = size * normal(random), b = size * normal(random);
      for (std::size_t i = 0; i < l.h.size(); ++i) {
        const double x = std::pow(l.h[i], q), term = scale * std::pow(l.h[i], l.order) * (1 + a * x + b * x * x);
        l.error[i] += term * term;
      }
    }
    for (double& e : l.error) e = std::sqrt(e);
    const double floor = bar == Bar::none ? 0 : l.error.back() * std::pow(10, -3 + 3 * uniform(random));
    const double sign = uniform(random) < 0.5 ? -1 : 1;
    l.floor.assign(l.h.size(), floor);
    for (double& e : l.error) {
      const double off = bar == Bar::drawn ? 2 * uniform(random) - 1 : sign;
      e = std::fabs(e + off * floor);
    }
    return l;
  }
};

}  // namespace

TEST_CASE("order interval: of deterministic families 95 % hold the order or are inconclusive, and few are") {
  for (const Bar bar : {Bar::none, Bar::drawn, Bar::shared}) {
    Family family{std::mt19937_64(17)};
    int held = 0, conclusive = 0, wide = 0;
    constexpr int kLadders = 2000;
    for (int i = 0; i < kLadders; ++i) {
      const Ladder l = family.next(bar);
      const OrderFit fit = fit_order(l.h, l.error, l.floor);
      conclusive += fit.conclusive;
      held += fit.conclusive && std::fabs(fit.order - l.order) <= fit.half_width_95 + 1e-9;
      wide += fit.conclusive && fit.half_width_95 > 0.2;
    }
    CAPTURE(static_cast<int>(bar), held, conclusive, wide);
    CHECK(held >= 0.95 * conclusive);
    CHECK(conclusive >= 0.8 * kLadders);  // inconclusive: at most a fifth
    CHECK(wide <= 0.05 * conclusive);     // and conclusive orders have narrow intervals
  }
}

TEST_CASE("order interval: h^4 + h^5 holds 4") {
  for (const double ratio : {2.0, std::sqrt(2.0)})
    for (const double floor : {0.0, 1e-14})
      for (int rungs = 5; rungs <= 8; ++rungs) {
        const std::vector<double> h = ladder_of(0.1, ratio, rungs);
        std::vector<double> e;
        for (double x : h) e.push_back(std::pow(x, 4) + std::pow(x, 5));
        const OrderFit fit = fit_order(h, e, std::vector<double>(h.size(), floor));
        CAPTURE(ratio, floor, rungs, fit.order, fit.half_width_95, fit.reason);
        REQUIRE(fit.conclusive);
        CHECK(std::fabs(fit.order - 4) <= fit.half_width_95);
        CHECK(std::fabs(fit.finest_slope - fit.order) <= fit.half_width_95);
        CHECK(std::fabs(fit.extrapolated - 4) < 0.005);
        CHECK(fit.half_width_95 < 0.06);
      }
}

TEST_CASE("order interval: h^3 (0.01 + h) is never a proven 4, however coarse the ladder") {
  for (const double ratio : {2.0, std::sqrt(2.0), std::pow(2, 0.25)})
    for (double coarsest = 0.05; coarsest < 30; coarsest *= 1.5)
      for (int rungs = 4; rungs <= 12; ++rungs)
        for (const double floor : {0.0, 1e-12}) {
          const std::vector<double> h = ladder_of(coarsest, ratio, rungs);
          std::vector<double> e;
          for (double x : h) e.push_back(std::pow(x, 3) * (0.01 + x));
          const OrderFit fit = fit_order(h, e, std::vector<double>(h.size(), floor));
          CAPTURE(ratio, coarsest, rungs, floor, fit.order, fit.half_width_95);
          CHECK_FALSE((fit.conclusive && fit.order - fit.half_width_95 >= 3.9 && fit.order + fit.half_width_95 <= 4.1));
        }
}

TEST_CASE("order interval: what the bars explain is not curvature, what they do not is") {
  const std::vector<double> h = ladder_of(0.1, 2, 6);
  std::vector<double> e;
  for (double x : h) e.push_back(std::pow(x, 2) * (1 + 0.5 * x));
  const std::vector<double> tight(h.size(), 1e-9 * e.back());
  const OrderFit known = fit_order(h, e, tight);
  REQUIRE(known.conclusive);
  CHECK(std::fabs(known.order - 2) <= known.half_width_95);
  CHECK(known.half_width_95 < 0.02);
  // A bar of a fiftieth of the finest error: the interval is wider by what that may hide.
  const OrderFit blurred = fit_order(h, e, std::vector<double>(h.size(), e.back() / 50));
  REQUIRE(blurred.conclusive);
  CHECK(std::fabs(blurred.order - 2) <= blurred.half_width_95);
  CHECK(blurred.half_width_95 > known.half_width_95);
}

TEST_CASE("order interval: rungs of one and the same step tell no order") {
  const std::vector<double> same(6, 0.1), error{1, 2, 3, 4, 5, 6};
  CHECK_FALSE(fit_order(same, error, std::vector<double>(6, 0.001)).conclusive);
}
