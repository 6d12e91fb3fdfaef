// Times the first two methods of a ranking alternately.
#pragma once

#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "benchmarks/stopwatch.hpp"
#include "validation/metrics/work_precision.hpp"
#include "validation/row.hpp"

namespace atwood {

// Times the first two of a contest alternately at their rungs. Where the second is clearly faster (the whole interval
// of the ratio is below kClearlyQuicker), the two are exchanged in a contest of an error; otherwise the order of the
// timed pass is kept, so that results from one store are reproducible.
constexpr double kClearlyQuicker = 0.8;
class TurnTimes {
 public:
  TurnTimes(std::span<const Cell> cells, const std::vector<Worker>& workers, const std::vector<Row>& rows,
            double limit_s)
      : cells_(cells), workers_(workers), rows_(rows), stopwatch_(limit_s) {}

  static constexpr int kPairs = 15;
  static constexpr double kPair_s = 1;  // a pair of longer runs is not timed: thirty would take too long

  // Leaves a contest as it is where one of the two cannot be timed, or a pair takes longer than `most_s`. Throws
  // Interrupted.
  void settle(Contest& contest, const std::string& scenario, bool of_error, double most_s = kPair_s);

 private:
  struct Turns {
    std::vector<double> first, second;
  };
  const Turns& measured(const Cell& a, const Cell& b, double a_s, double b_s);
  Contender contender(const Cell& cell, double seconds) const;
  const Cell* find_cell(const std::string& scenario, const Reached& reached) const;

  std::span<const Cell> cells_;
  const std::vector<Worker>& workers_;
  const std::vector<Row>& rows_;
  Stopwatch stopwatch_;
  std::map<std::pair<const Cell*, const Cell*>, Turns> known_;
};

}  // namespace atwood
