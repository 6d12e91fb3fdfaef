// Goals as a terminal shows them: what was asked, what is reached, and the best of each side.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "reports/report.hpp"
#include "text.hpp"

namespace atwood {
namespace {

std::string line(const char* who, const GoalEntrant& entrant, const GoalResult& goal) {
  if (entrant.method.empty()) return fmt::format("    {:<10} none\n", who);
  std::string words = fmt::format("    {:<10} {}", who, entrant.method);
  if (entrant.steps > 0 && method_family(entrant.method) == entrant.method)
    words += fmt::format(", {} steps", entrant.steps);
  std::string figures;
  const auto add = [&](const std::string& text) { figures += (figures.empty() ? "" : ", ") + text; };
  if (std::isfinite(goal.low)) add(fmt::format("{:.4g} +/- {:.2g}", entrant.error, entrant.bar));
  else if (std::isfinite(entrant.error)) add(fmt::format("error {}", format_measure(entrant.error, entrant.bar, 2)));
  if (!std::isnan(entrant.last_quarter)) add(last_quarter_words(entrant.last_quarter));
  if (std::isfinite(entrant.evaluations)) add(fmt::format("{:.0f} evaluations", entrant.evaluations));
  if (std::isfinite(entrant.seconds)) add(time_words(entrant.seconds));
  if (std::isfinite(entrant.ns_per_step))
    add(fmt::format("{:.4g} ns{}", entrant.ns_per_step, entrant.steps > 0 ? " per step" : ""));
  if (!entrant.accurate && !std::isfinite(goal.low)) add("not accurate enough");
  return words + ": " + figures + "\n";
}

}  // namespace

std::string goals_text(const std::vector<GoalResult>& goals) {
  std::string text;
  for (const GoalResult& goal : goals) {
    text += fmt::format("{}  {}\n    asked      {}\n", goal.reached ? "reached    " : "NOT REACHED", goal.title,
                        goal_words(goal));
    text += line("ours", goal.ours, goal) + line("rival", goal.rival, goal);
    if (std::isfinite(goal.ours.floor)) text += fmt::format("    floor      {}\n", floor_words(goal.ours.floor));
    for (const GoalEntrant& entrant : goal.close) text += line("within 20%", entrant, goal);
    if (!goal.uncounted.method.empty()) text += line("uncounted", goal.uncounted, goal);
    if (std::isfinite(goal.ratio)) {
      const bool interval = std::isfinite(goal.ratio_low) && goal.ratio_low < goal.ratio_high;
      text += fmt::format("    ratio      {}the rival costs {:.3g} x ours{}\n",
                          goal.library.method.empty() ? "" : "at native rates ", goal.ratio,
                          interval ? fmt::format(" [{:.3g}, {:.3g}]", goal.ratio_low, goal.ratio_high) : "");
    }
    if (!goal.library.method.empty() && !goal.same_rate.method.empty()) {
      text += line("same rate", goal.same_rate, goal) + line("library", goal.library, goal);
      text += std::isfinite(goal.same_rate_ratio)
                  ? fmt::format("    ratio      at the same rate the library costs {:.3g} x ours [{:.3g}, {:.3g}]\n",
                                goal.same_rate_ratio, goal.same_rate_low, goal.same_rate_high)
                  : "";
    }
    if (!goal.left_out.empty()) text += fmt::format("    left out   {}\n", left_out_words(goal));
    if (goal.machine.timings > 0)
      text += fmt::format("    machine    {}{}\n", machine_words(goal.machine),
                          busy(goal.machine) ? ": a busy machine, times may be too long" : "");
    if (!goal.why.empty()) text += fmt::format("    missing    {}\n", goal.why);
  }
  const auto reached = std::count_if(goals.begin(), goals.end(), [](const GoalResult& goal) { return goal.reached; });
  if (const std::string words = busy_words(goals); !words.empty()) text += words + "\n";
  return text + fmt::format("{} of {} goals reached\n", reached, goals.size());
}

}  // namespace atwood
