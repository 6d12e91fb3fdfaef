// Judging and reporting more cells than memory holds rows of: ladder by ladder.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "reports/command_line/command_line.hpp"
#include "reports/command_line/history.hpp"
#include "reports/command_line/verdicts.hpp"

namespace atwood {

// Whether this selection is gone through ladder by ladder (from 20 000 cells on, or $ATWOOD_MANY_CELLS). What needs all
// rows at once (documents of -o, --json, --junit, a baseline) is made from all of them, whatever their number.
bool has_many_cells(const Options& options, const Selection& selection, const Standards& standards);

// Counts of everything; rows and verdicts of the ladders that documents show: of each scene the most and least accurate
// ones, and those where something did not pass.
struct Condensed {
  StudyResult result;
  Judged judged;
  SceneCounts all;
  std::map<std::string, SceneCounts> scenes;
  std::size_t rows = 0;
  bool passes = false;
};
Condensed condense(const Place& place, const Options& options, const Selection& selection, const Standards& standards);

int gate_many(const Place& place, const Options& options, const Selection& selection, const Standards& standards);
// `ran` and `kept_run`: what `run` did before, and its entry in the history, which gets the counts and no figures.
int report_many(const Place& place, const Options& options, const Selection& selection, const Standards& standards,
                const StudyResult* ran = nullptr, std::optional<HistoryRun>* kept_run = nullptr);

}  // namespace atwood
