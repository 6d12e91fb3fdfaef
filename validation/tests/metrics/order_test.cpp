// The order fit on errors of known law: intervals that cover, floors respected, negative orders shown.
#include <catch2/catch.hpp>
#include <cmath>

#include "validation/metrics/metrics.hpp"

using namespace atwood;

namespace {

std::vector<double> halvings(int rungs, double ratio = 2) {
  std::vector<double> h;
  for (int i = 0; i < rungs; ++i) h.push_back(0.1 * std::pow(ratio, -i));
  return h;
}

}  // namespace

TEST_CASE("order: an exact power law gives its exponent, whatever the rungs' order and ratio") {
  std::vector<double> h = halvings(9, std::sqrt(std::sqrt(2.0)));
  std::swap(h[0], h[5]);
  std::vector<double> e;
  for (double x : h) e.push_back(7 * std::pow(x, 5));
  const OrderFit fit = fit_order(h, e, std::vector<double>(h.size(), 0));
  REQUIRE(fit.conclusive);
  CHECK(fit.order == Approx(5).epsilon(1e-10));
  CHECK(fit.half_width_95 < 1e-9);
}

TEST_CASE("order: an error that grows as h shrinks, above the floor, has a negative order") {
  const std::vector<double> h = halvings(6);
  std::vector<double> e;
  for (double x : h) e.push_back(1e-3 / std::sqrt(x));
  const OrderFit fit = fit_order(h, e, std::vector<double>(h.size(), 1e-12));
  REQUIRE(fit.conclusive);
  CHECK(fit.order == Approx(-0.5).epsilon(1e-9));
  CHECK(fit.used.size() == 6);
}

TEST_CASE("order: rungs after the least error are not left out") {
  // Falls as h^4, then grows: far above the stated floor, so the growing part may not be left out.
  const std::vector<double> h = halvings(10);
  std::vector<double> e;
  for (double x : h) e.push_back(std::pow(x, 4) + 1e-8 / x * 1e-3);
  const OrderFit fit = fit_order(h, e, std::vector<double>(h.size(), 1e-16));
  for (std::size_t i = 0; i < h.size(); ++i) CHECK(fit.left_out[i] != "floor");
  if (fit.conclusive) CHECK(fit.order < 0);
  // With the true floor given, the falling part alone remains.
  std::vector<double> floor;
  for (double x : h) floor.push_back(1e-11 / x);
  const OrderFit cut = fit_order(h, e, floor);
  REQUIRE(cut.conclusive);
  CHECK(cut.order == Approx(4).margin(0.05));
  CHECK(cut.left_out.back() == "floor");
}

TEST_CASE("order: rungs before the asymptotic range and near the floor are left out by name") {
  const std::vector<double> h = halvings(12);
  std::vector<double> e, floor;
  for (double x : h) {
    e.push_back(std::pow(x, 4) * (1 + 4000 * x * x * x));
    floor.push_back(1e-14);
  }
  const OrderFit fit = fit_order(h, e, floor);
  REQUIRE(fit.conclusive);
  CHECK(fit.left_out.front() == "pre-asymptotic");
  CHECK(fit.left_out.back() == "floor");
  CHECK(fit.order == Approx(4).margin(0.1));
  for (int i : fit.used) CHECK(e[i] > 30 * floor[i]);
}

TEST_CASE("order: fewer than four rungs are inconclusive, NaN rungs cut the ladder") {
  const std::vector<double> h = halvings(6);
  std::vector<double> e;
  for (double x : h) e.push_back(x * x);
  CHECK_FALSE(fit_order(std::span(h).first(3), std::span(e).first(3), std::vector<double>(3, 0)).conclusive);
  std::vector<double> all_floor(h.size(), 1.0);
  CHECK_FALSE(fit_order(h, e, all_floor).conclusive);
  e[3] = std::nan("");
  const OrderFit fit = fit_order(h, e, std::vector<double>(h.size(), 0));
  CHECK_FALSE(fit.conclusive);
  CHECK(fit.left_out[3] == "not finite");
}

TEST_CASE("order: slopes that keep changing are inconclusive, not averaged") {
  const std::vector<double> h = halvings(5);
  const std::vector<double> e = {1, 0.5, 0.1, 0.09, 0.005};
  const OrderFit fit = fit_order(h, e, std::vector<double>(h.size(), 0));
  CHECK_FALSE(fit.conclusive);
  CHECK_FALSE(fit.reason.empty());
}
