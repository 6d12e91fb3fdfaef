// Paired timings: what slows both cancels, and the interval covers.
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "validation/metrics/metrics.hpp"

using namespace atwood;

TEST_CASE("timing ratio: a drift of the machine's speed cancels in pairs") {
  std::vector<double> a, b;
  for (int i = 0; i < 15; ++i) {
    b.push_back(1e-6 * (1 + 0.2 * i));
    a.push_back(1.25 * b.back() * (i % 5 == 0 ? 30 : 1));  // some runs of A were interrupted
  }
  const PairedRatio r = paired_ratio(a, b);
  CHECK(r.pairs == 15);
  CHECK(r.ratio == Approx(1.25));
  CHECK(r.low == Approx(1.25));
  CHECK(r.low <= r.ratio);
  CHECK(r.ratio <= r.high);
}

TEST_CASE("timing ratio: few pairs give their range; none, or times of zero, give nothing") {
  const std::vector<double> a{2, 3, 4}, b{2, 2, 2};
  const PairedRatio r = paired_ratio(a, b);
  CHECK(r.low == 1);
  CHECK(r.ratio == 1.5);
  CHECK(r.high == 2);
  CHECK(paired_ratio({}, b).pairs == 0);
  CHECK(std::isnan(paired_ratio({}, b).ratio));
  CHECK(paired_ratio(a, std::vector<double>{0, 0, 0}).pairs == 0);
}

TEST_CASE("timing ratio: 95 % intervals cover the true ratio in 93 to 97 % of noisy series of pairs") {
  std::mt19937_64 random(99);
  std::normal_distribution<double> noise(0, 0.05);
  std::exponential_distribution<double> stall(1);
  for (const int pairs : {11, 20}) {
    int covered = 0;
    for (int series = 0; series < 2000; ++series) {
      std::vector<double> a, b;
      double speed = 1;
      for (int i = 0; i < pairs; ++i) {
        speed *= std::exp(noise(random));  // both halves of a pair see the same machine; either may stall
        a.push_back(1.5 * speed * std::exp(noise(random)) * (1 + 0.1 * stall(random)));
        b.push_back(speed * std::exp(noise(random)) * (1 + 0.1 * stall(random)));
      }
      const PairedRatio r = paired_ratio(a, b);
      covered += r.low <= 1.5 && 1.5 <= r.high;
    }
    CAPTURE(pairs, covered);
    CHECK(covered >= 0.93 * 2000);
    CHECK(covered <= 0.97 * 2000);
  }
}
