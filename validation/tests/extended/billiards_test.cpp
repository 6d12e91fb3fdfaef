// Bars of motions that magnify errors, against sixty digits: breaches must be zero.
#include <catch2/catch.hpp>

#include "billiard.hpp"
#include "cvode/cvode.hpp"
#include "extended/extended.hpp"

using namespace atwood;

TEST_CASE("a ball among fixed balls: the certified truth's bars hold through every impact, in any unit") {
  int breaches = 0, impacts = 0, answered = 0;
  double worst = 0;
  for (const double unit : {1.0, 1e-18, 1e18})
    for (const double restitution : {1.0, 0.75})
      for (std::uint64_t seed = 1; seed <= 8; ++seed) {
        const Scenario given = scenes::sinai(seed, restitution, 15, unit);
        int hits = 0;
        const auto exact = scenes::fly60(given, 60, hits);
        const Truth truth = extended_truth(given, 60);
        INFO("seed " << seed << ", restitution " << restitution << ", unit " << unit << ": " << truth.outcome.reason);
        CHECK(truth.outcome.status == Status::ok);
        CHECK(truth.events.size() == static_cast<std::size_t>(hits));
        const double ratio = scenes::worst_ratio(truth, exact);
        breaches += ratio > 1;
        worst = std::max(worst, ratio);
        impacts += hits;
        ++answered;
        // And not by being absurd: ten impacts among balls magnify quad's round-off by less than 1e13.
        if (truth.outcome.status == Status::ok && hits < 12)
          CHECK(truth.bars.back().bodies.back().p_m[0] < Wide(1e-18 * unit));
      }
  INFO(breaches << " breaches in " << answered << " billiards of " << impacts << " impacts, worst ratio " << worst);
  CHECK(breaches == 0);
  CHECK(impacts > 300);
}

TEST_CASE("a ball among fixed balls: CVODE's bars hold, or it ends where it cannot follow") {
  int breaches = 0, samples = 0;
  double worst = 0;
  for (const double unit : {1.0, 1e-18})
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      const Scenario given = scenes::sinai(seed, 1, 15, unit);
      int hits = 0;
      const auto exact = scenes::fly60(given, 60, hits);
      const Truth truth = cvode_truth(given, 60);
      INFO("seed " << seed << ", unit " << unit << ": " << truth.outcome.reason);
      const double ratio = scenes::worst_ratio(truth, exact);
      breaches += ratio > 1;
      worst = std::max(worst, ratio);
      samples += static_cast<int>(truth.values.size());
      if (truth.outcome.status == Status::ok) CHECK(truth.values.size() == 61);
      else CHECK(truth.outcome.reason.find(" at t = ") != std::string::npos);
    }
  INFO(breaches << " breaches, " << samples << " samples, worst ratio " << worst);
  CHECK(breaches == 0);
  CHECK(samples > 1200);
}
