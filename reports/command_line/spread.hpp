// How far apart runs of one scene are, where no truth says which of them is right.
#pragma once

#include <string>
#include <vector>

#include "reports/command_line/command_line.hpp"

namespace atwood {

struct NamedRun {
  std::string name;
  Recording run;
};

// One run of each engine that can do the scene, at its finest steps (rounded up to a multiple of `samples`), each
// within `limit_s`. Engines that refuse or fail fall away.
std::vector<NamedRun> run_engines(const Scenario& scenario, std::int64_t samples, const std::vector<Worker>& workers,
                                  double limit_s);

// Runs of these cells again, of each method the finest that ended well by `rows`.
std::vector<NamedRun> run_finest(const std::vector<Cell>& cells, const std::string& scenario,
                                 const std::vector<Row>& rows, const std::vector<Worker>& workers, double limit_s);

// A line a pair: the largest distance of a body in the one run from itself in the other, and when. Runs with different
// counts of samples are not compared. `with_first`: only pairs with the first run. The first line says what the figures
// are not.
std::vector<std::string> spread_lines(const std::vector<NamedRun>& runs, bool with_first = false);

}  // namespace atwood
