// The overhead of a method: what is left of its time when its rates cost nothing.
#include <catch2/catch.hpp>

#include <array>
#include <cmath>

#include "scene/split_mix.hpp"
#include "validation/metrics/overhead.hpp"
#include "validation/metrics/resample.hpp"

using namespace atwood;

namespace {

constexpr std::array kRepeats{1, 2, 4, 8};

// Timings as a busy machine gives them: a factor a round that all share, noise of a hundredth each, and now and then
// one that was interrupted.
std::vector<std::vector<double>> timings(double overhead_ns, double rate_ns, int rounds, SplitMix64& random) {
  std::vector<std::vector<double>> ns;
  for (int r = 0; r < rounds; ++r) {
    const double speed = std::exp(0.02 * metrics::draw_normal(random));
    ns.emplace_back();
    for (const int k : kRepeats) {
      const double noise = std::exp(0.01 * metrics::draw_normal(random)), stop = random.next_unit() < 0.03 ? 1.5 : 1;
      ns.back().push_back((overhead_ns + k * rate_ns) * speed * noise * stop);
    }
  }
  return ns;
}

}  // namespace

TEST_CASE("a line without noise gives the overhead and the rate") {
  const std::vector<std::vector<double>> ns{{45, 87, 171, 339}, {45, 87, 171, 339}};
  const OverheadFit fit = fit_overhead(kRepeats, ns);
  CHECK(fit.rounds == 2);
  CHECK(fit.overhead_ns.value == Approx(3).epsilon(1e-9));
  CHECK(fit.rate_ns.value == Approx(42).epsilon(1e-12));
  CHECK(fit.straight);
}

TEST_CASE(
    "the intervals hold the overhead and the rate in 95 of 100 campaigns at least, and are no wider than they need") {
  SplitMix64 random{1784};
  for (const double overhead : {0.5, 5.0, 50.0}) {
    int held = 0, rate_held = 0;
    double width = 0;
    constexpr int kCampaigns = 600;
    for (int c = 0; c < kCampaigns; ++c) {
      const OverheadFit fit = fit_overhead(kRepeats, timings(overhead, 42, 15, random));
      held += fit.overhead_ns.low <= overhead && overhead <= fit.overhead_ns.high;
      rate_held += fit.rate_ns.low <= 42 && 42 <= fit.rate_ns.high;
      width += (fit.overhead_ns.high - fit.overhead_ns.low) / kCampaigns;
    }
    CAPTURE(overhead, width);
    CHECK(held >= 0.93 * kCampaigns);  // 600 trials of 0.95: three standard deviations below are 0.923
    CHECK(rate_held >= 0.93 * kCampaigns);
    CHECK(width < 2 + 0.2 * overhead);
  }
}

TEST_CASE("times that do not lie on a line are recognised") {
  SplitMix64 random{42};
  auto bent = timings(5, 42, 15, random);
  for (auto& round : bent) round[2] *= 0.9, round[3] *= 0.75;  // the later calls of a burst are cheaper
  CHECK_FALSE(fit_overhead(kRepeats, bent).straight);
  CHECK(fit_overhead(kRepeats, timings(5, 42, 15, random)).straight);
}

TEST_CASE("rounds with a failed run are left out; without rounds there is no figure") {
  const double nan = std::nan("");
  CHECK(fit_overhead(kRepeats, {{1, 2, nan, 8}, {45, 87, 171, 339}}).rounds == 1);
  CHECK(fit_overhead(kRepeats, {{nan, nan, nan, nan}}).rounds == 0);
  CHECK(fit_overhead(kRepeats, {}).rounds == 0);
}

TEST_CASE("overhead: no cost is below zero; longer runs that other load slows down more give none") {
  SplitMix64 random{11};
  std::vector<std::vector<double>> slowed = timings(5, 42, 15, random);
  CHECK(fit_overhead(kRepeats, slowed).possible);
  for (std::vector<double>& round : slowed)
    for (std::size_t i = 0; i < round.size(); ++i) round[i] *= 1 + 0.3 * static_cast<double>(i);
  const OverheadFit fit = fit_overhead(kRepeats, slowed);
  CHECK(fit.overhead_ns.high < 0);
  CHECK_FALSE(fit.possible);
}
