#include "reports/command_line/contest.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "reports/render/text.hpp"

namespace atwood {
namespace {

// The rungs of one half of a method's ladders: equal steps, or tolerances.
struct Half {
  bool runs = false;
  std::int64_t fewest_steps = 0, most_steps = 0;
  double fewest_evaluations = 0, most_evaluations = 0;
  // Four times the steps, and hardly more work: they were not its steps.
  bool idle() const {
    return most_steps >= 4 * fewest_steps && most_evaluations > 0 && most_evaluations < 1.5 * fewest_evaluations;
  }
};

}  // namespace

std::vector<Row> without_idle_halves(const std::vector<Row>& rows, const std::vector<std::string>& asked,
                                     std::vector<std::string>& notes) {
  std::map<std::pair<std::string, std::string>, Half> halves;  // scenario, family
  for (const Row& row : rows) {
    if (row.steps == 0 || row.status != Status::ok || !row.body.empty() || row.t_s) continue;
    Half& half = halves[{row.scenario, method_family(row.method)}];
    half.runs = true;
    if (row.metric != "rate-evaluations") continue;
    half.fewest_steps = half.fewest_steps == 0 ? row.steps : std::min(half.fewest_steps, row.steps);
    half.most_steps = std::max(half.most_steps, row.steps);
    half.fewest_evaluations = half.fewest_evaluations == 0 ? row.value : std::min(half.fewest_evaluations, row.value);
    half.most_evaluations = std::max(half.most_evaluations, row.value);
  }
  const auto is_idle = [&](const Row& row) {
    const std::string family = method_family(row.method);
    const bool tolerance = family != row.method;
    if (tolerance && std::find(asked.begin(), asked.end(), row.method) != asked.end()) return false;
    const std::size_t at = tolerance ? family.find(":tol") : std::min(family.find_first_of("+@{"), family.size());
    const std::string other =
        tolerance ? family.substr(0, at) + family.substr(at + 4) : family.substr(0, at) + ":tol" + family.substr(at);
    const auto twin = halves.find({row.scenario, other});
    if (twin == halves.end() || !twin->second.runs) return false;
    const auto own = halves.find({row.scenario, family});
    return own == halves.end() || !own->second.runs || (!tolerance && own->second.idle());
  };
  std::vector<Row> kept;
  std::set<std::string> said;
  for (const Row& row : rows) {
    if (!is_idle(row)) kept.push_back(row);
    else if (method_family(row.method) == row.method && said.insert(row.method).second)
      notes.push_back(row.method + " chooses its own steps: run at a ladder of tolerances instead of equal steps.");
  }
  return kept;
}

std::string caution_words(const Reached& reached, double wanted) {
  if (!(reached.worst_finer > wanted)) return "";
  if (std::isinf(reached.worst_finer)) return "a finer step diverges: that this one does not may be luck";
  return fmt::format("a finer step errs by {:.2g}, more than was asked: this one may be luck", reached.worst_finer);
}

std::string under_wasm_note(const std::vector<Row>& rows) {
  std::set<std::string> families;
  for (const Row& row : rows)
    if (row.metric == "run-time-wasm" && row.status == Status::ok) families.insert(method_family(row.method));
  return families.empty() ? "" : fmt::format("{}: {}.", fmt::join(families, ", "), kUnrankedUnderWasm);
}

}  // namespace atwood
