// What `compare` and `advise` share: the ladders that methods run on a scene, and who wins on them. The judgement itself
// is in validation/metrics/work_precision.
#pragma once

#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "reports/command_line/command_line.hpp"
#include "reports/command_line/stopwatch.hpp"
#include "validation/metrics/work_precision.hpp"

namespace atwood {

// Rungs below the ladder's coarsest: halved while the samples divide them. Methods of high order live there, and it
// shows from which step on a method is stable.
void lengthen_ladder(Scenario& scenario);

// A method that takes a tolerance was run both ways. A half that it refuses is no failure of it, and where equal steps
// change nothing (it chooses its own, at a tolerance of its own) they are no ladder: the other half stands for it.
// `asked`: ids that were named as they are; `notes` gets a sentence on each method whose half was left out.
std::vector<Row> without_idle_halves(const std::vector<Row>& rows, const std::vector<std::string>& asked,
                                     std::vector<std::string>& notes);

// The first two of a contest, timed in turns at their rungs. Where the second proves clearly quicker (the whole interval
// of the ratio is under kClearlyQuicker), an error's contest is theirs in that order; nearer ones stay as the timed pass
// has them, so that whoever asks the same store gets the same answer.
constexpr double kClearlyQuicker = 0.8;
class TurnTimes {
 public:
  TurnTimes(std::span<const Cell> cells, const std::vector<Worker>& workers, const std::vector<Row>& rows,
            double limit_s)
      : cells_(cells), workers_(workers), rows_(rows), stopwatch_(limit_s) {}

  // Leaves a contest as it is where one of the two cannot be timed. Throws Interrupted.
  void settle(Contest& contest, const std::string& scenario, bool of_error);

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

// The margin of what was reached, in words, and what the finer rungs say against it.
std::string caution_words(const Reached& reached, double wanted);

}  // namespace atwood
