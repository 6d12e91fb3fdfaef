// Change points against a search through every partition, on planted levels, and on noise alone.
#include "validation/study/change_points.hpp"

#include <catch2/catch.hpp>

#include <cmath>
#include <limits>
#include <random>

namespace {

using atwood::find_change_points;

// The penalised cost of one partition, straight from its definition; infinite where a segment is too short.
double cost_of(const std::vector<double>& x, const std::vector<std::size_t>& starts, double penalty) {
  double total = penalty * static_cast<double>(starts.size());
  std::vector<std::size_t> ends = starts;
  ends.push_back(x.size());
  std::size_t from = 0;
  for (const std::size_t to : ends) {
    if (to < from + 2) return std::numeric_limits<double>::infinity();
    double mean = 0;
    for (std::size_t i = from; i < to; ++i) mean += x[i] / static_cast<double>(to - from);
    for (std::size_t i = from; i < to; ++i) total += (x[i] - mean) * (x[i] - mean);
    from = to;
  }
  return total;
}

}  // namespace

TEST_CASE("change points: the least of all partitions") {
  std::mt19937_64 random(1784);
  std::normal_distribution<double> normal;
  int with_changes = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const std::size_t n = 8 + static_cast<std::size_t>(trial) % 5;
    std::vector<double> values, logs;
    double level = 0;
    for (std::size_t i = 0; i < n; ++i) {
      if (normal(random) > 1) level += 2 * normal(random);
      logs.push_back(level + 0.3 * normal(random));
      values.push_back(std::exp(logs.back()));
    }
    const auto found = find_change_points(values);
    REQUIRE(found.enough);
    REQUIRE(found.logarithmic);
    double least = std::numeric_limits<double>::infinity();
    for (unsigned mask = 0; mask < 1u << (n - 1); ++mask) {
      std::vector<std::size_t> starts;
      for (std::size_t i = 1; i < n; ++i)
        if (mask >> (i - 1) & 1u) starts.push_back(i);
      least = std::min(least, cost_of(logs, starts, found.penalty));
    }
    CHECK(cost_of(logs, found.starts, found.penalty) == Approx(least).epsilon(1e-9));
    with_changes += !found.starts.empty();
  }
  CHECK(with_changes > 40);
  CHECK(with_changes < 200);
}

TEST_CASE("change points: planted levels") {
  std::vector<double> values(12, 1e-6);
  CHECK(find_change_points(values).starts.empty());
  for (std::size_t i = 7; i < 12; ++i) values[i] = 1.02e-6;
  CHECK(find_change_points(values).starts == std::vector<std::size_t>{7});
  for (std::size_t i = 10; i < 12; ++i) values[i] = 1e-6;
  CHECK(find_change_points(values).starts == std::vector<std::size_t>{7, 10});
  std::vector<double> outlier(12, 1e-6);  // one run alone is no level, where noise hides it
  for (std::size_t i = 0; i < 12; ++i) outlier[i] *= 1 + (i % 2 ? 0.05 : -0.05);
  outlier[6] *= 1.1;
  CHECK(find_change_points(outlier).starts.empty());
  const std::vector<double> signs{-1, -1, -1, -1, -1, 1, 1, 1, 1, 1};
  CHECK(find_change_points(signs).starts == std::vector<std::size_t>{5});
  CHECK_FALSE(find_change_points(signs).logarithmic);
  CHECK(find_change_points(std::vector<double>(20, 0.0)).starts.empty());
}

TEST_CASE("change points: too few runs, or no numbers") {
  CHECK_FALSE(find_change_points(std::vector<double>(7, 1.0)).enough);
  CHECK(find_change_points(std::vector<double>(8, 1.0)).enough);
  std::vector<double> values(20, 1.0);
  values[3] = std::nan("");
  CHECK_FALSE(find_change_points(values).enough);
}

TEST_CASE("change points: false alarms of noise, and power") {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  for (const std::size_t n : {20u, 100u}) {
    int alarms = 0, missed = 0;
    constexpr int kTrials = 400;
    for (int trial = 0; trial < kTrials; ++trial) {
      std::vector<double> values;
      for (std::size_t i = 0; i < n; ++i) values.push_back(std::exp(0.05 * normal(random)));
      alarms += !find_change_points(values).starts.empty();
      for (std::size_t i = n / 2; i < n; ++i) values[i] *= std::exp(0.05 * 4);  // four times the spread
      const auto starts = find_change_points(values).starts;
      bool near = false;
      for (const std::size_t start : starts) near |= start + 1 >= n / 2 && start <= n / 2 + 1;
      missed += !near;
    }
    INFO(n << " runs: " << alarms << " false alarms, " << missed << " missed, of " << kTrials);
    CHECK(alarms < kTrials / 10);
    CHECK(missed < kTrials / 20);
  }
}
