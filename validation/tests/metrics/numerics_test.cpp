// Least squares, quantiles and bisection, against what is exact.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "protocol/sample.hpp"
#include "validation/metrics/bisection.hpp"
#include "validation/metrics/least_squares.hpp"
#include "validation/metrics/quantile.hpp"

namespace atwood::test {
namespace {

using Columns = std::vector<std::vector<double>>;

// Powers 0 .. degree of x: the condition number of degree 5 on [0, 1] is about 1e4 squared for the normal equations.
Columns powers(const std::vector<double>& x, int degree) {
  Columns made(static_cast<std::size_t>(degree) + 1);
  for (double v : x)
    for (int k = 0; k <= degree; ++k) made[static_cast<std::size_t>(k)].push_back(std::pow(v, k));
  return made;
}

}  // namespace

TEST_CASE("least squares gives a polynomial's last coefficient, whatever the weights") {
  std::vector<double> x, y, root;
  for (int i = 0; i < 12; ++i) {
    x.push_back(i / 8.0);
    y.push_back(3 - 2 * x[i] + 0.5 * std::pow(x[i], 3) + 7 * std::pow(x[i], 5));
    root.push_back(1 + i % 3);
  }
  for (const std::span<const double> roots : {std::span<const double>(), std::span<const double>(root)}) {
    const metrics::ColumnFit fit = metrics::fit_columns(powers(x, 5), y, roots);
    CHECK(fit.last == Approx(7).epsilon(1e-11));
    CHECK(fit.squares < 1e-22);
    double sum = 0;
    for (std::size_t i = 0; i < y.size(); ++i) sum += fit.weight[i] * y[i];
    CHECK(sum == Approx(fit.last).epsilon(1e-9));
  }
}

TEST_CASE("least squares leaves what no column holds, and weighs as 1 / variance") {
  // A mean with weights 1, 1, 4 (roots 1, 1, 2) of 0, 0, 3: 12 / 6; squares 4 + 4 + 4.
  const metrics::ColumnFit mean =
      metrics::fit_columns({{1, 1, 1}}, std::vector<double>{0, 0, 3}, std::vector<double>{1, 1, 2});
  CHECK(mean.last == Approx(2).epsilon(1e-15));
  CHECK(mean.squares == Approx(12).epsilon(1e-15));
  CHECK(mean.weight[2] == Approx(4 / 6.0).epsilon(1e-15));
  REQUIRE(mean.residual.size() == 3);
  CHECK(mean.residual[2] == Approx(2).epsilon(1e-15));
}

TEST_CASE("least squares: a column that others span is left out, as the last one it has no coefficient") {
  const std::vector<double> y{1, 2, 4};
  const metrics::ColumnFit twice = metrics::fit_columns({{1, 1, 1}, {0, 0, 0}, {0, 1, 2}}, y);
  CHECK(twice.last == Approx(1.5).epsilon(1e-15));
  CHECK(std::isnan(metrics::fit_columns({{1, 1, 1}, {0, 0, 0}}, y).last));
}

TEST_CASE("quantiles: definitions 7 and 1 of Hyndman and Fan, the median, none and one") {
  const std::vector<double> x{1, 2, 4, 8};
  CHECK(metrics::quantile(x, 0) == 1);
  CHECK(metrics::quantile(x, 0.5) == 3);
  CHECK(metrics::quantile(x, 0.9) == Approx(4 + 0.7 * 4));
  CHECK(metrics::quantile(x, 1) == 8);
  CHECK(metrics::quantile({}, 0.5) == 0);
  CHECK(metrics::quantile({5}, 0.3) == 5);
  std::vector<double> shuffled{8, 1, 4, 2}, odd{3, 9, 1}, none;
  CHECK(metrics::median_in_place(shuffled) == 3);
  CHECK(metrics::median_in_place(odd) == 3);
  CHECK(metrics::median_in_place(none) == 0);
  const auto first = [](int n) {
    std::vector<double> down;
    for (int i = n; i > 0; --i) down.push_back(i);
    return down;
  };
  CHECK(metrics::nearest_rank(first(20), 0.95) == 19);
  CHECK(metrics::nearest_rank(first(21), 0.95) == 20);
  CHECK(metrics::nearest_rank(first(1), 0.95) == 1);
  CHECK(metrics::nearest_rank(first(7), 1) == 7);
}

TEST_CASE("Student's t: tables, and the quantile inverts the tail") {
  CHECK(metrics::students_t(1, 0.975) == Approx(12.7062).epsilon(1e-5));
  CHECK(metrics::students_t(10, 0.975) == Approx(2.2281).epsilon(1e-4));
  CHECK(metrics::students_t_above(10, metrics::students_t(10, 0.975)) == Approx(0.025).epsilon(1e-12));
}

TEST_CASE("bisection ends at the root's two neighbours, at a jump too, and says when f is not a number") {
  const auto root = metrics::bisect([](double x) { return 2 - x * x; }, 1.0, 2.0, 200);
  CHECK(root.converged);
  CHECK(root.low < std::sqrt(2.0) + 1e-15);
  CHECK(root.high == std::nextafter(root.low, 2.0));
  const auto jump = metrics::bisect([](Wide x) { return x < Wide(1.3) ? 1 : -1; }, Wide(1), Wide(2), 113);
  CHECK(jump.converged);
  CHECK(jump.high == Wide(1.3));
  const auto few = metrics::bisect([](double x) { return 0.3 - x; }, 0.0, 1.0, 3);
  CHECK(few.converged);
  CHECK(few.low == 0.25);
  CHECK(few.high == 0.375);
  CHECK_FALSE(metrics::bisect([](double x) { return std::sqrt(0.4 - x); }, 0.0, 1.0, 50).converged);
}

}  // namespace atwood::test
