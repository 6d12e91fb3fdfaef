// Parts of what is said of a baseline, for the terminal, Markdown and annotations.
#pragma once

#include <string>
#include <vector>

#include "reports/report.hpp"

namespace atwood {

// A scenario and method of which some figure became worse.
struct ChangedPair {
  const BaselineChange* worst = nullptr;
  int regressions = 0;
};
std::vector<ChangedPair> changed_pairs(const std::vector<BaselineChange>& changes);  // worst ratio first
std::string change_words(const ChangedPair& pair);  // "error-position-end at 960 steps: 1e-6 -> 2e-6 m, allowed ..."
// "kepler-e0.6: 12 figures of 3 methods", a line a scenario.
std::vector<std::string> counted_by_scenario(const std::vector<BaselineChange>& changes, BaselineChange::Kind kind);
std::string change_counts(const std::string& path, const std::vector<BaselineChange>& changes);

}  // namespace atwood
