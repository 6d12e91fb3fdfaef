#include "markdown_contests.hpp"

#include <fmt/format.h>

#include <cmath>
#include <set>

#include "text.hpp"

namespace atwood {
namespace {

std::string mark(const Reached& reached) {
  return std::string(reached.coarsest ? " <" : "") + (reached.at_bar ? " *" : "");
}

// Another one's cost over the winner's.
std::string times(const Reached* other, const Reached& best) {
  return other == nullptr ? "- | -"
                          : fmt::format("{} | {:.2f}", escape_markdown_cell(other->family), other->cost / best.cost);
}

std::string runner_up(const Contest& contest) {
  if (contest.ranked.size() < 2) return "alone | -";
  if (!contest.to_next) return times(&contest.ranked[1], contest.ranked[0]);
  return fmt::format("{} | {:.2f} [{:.2f}, {:.2f}]", escape_markdown_cell(contest.ranked[1].family),
                     contest.to_next->value, contest.to_next->low, contest.to_next->high);
}

std::string error_words(const Reached* reached) {
  return reached == nullptr
             ? "- | -"
             : fmt::format("{} | {:.2g}{}", escape_markdown_cell(reached->family), reached->error, mark(*reached));
}

// Levels that our engine leads, and that another one leads.
std::string summary_line(const Dominance& table) {
  int ours = 0, theirs = 0;
  for (const Contest& contest : table.by_error) ++(engine_of(contest.ranked[0].family) == "atwood" ? ours : theirs);
  const auto finest = [&](bool own) {
    double level = 0;
    for (const Contest& contest : table.by_error) {
      if ((own ? best_of(contest, "atwood") : best_rival(contest, "atwood")) != nullptr) level = contest.asked;
    }
    return level > 0 ? fmt::format("{:.0e}", level) : std::string("-");
  };
  return fmt::format("| {} | {} | {} | {} | {} | {} |\n", escape_markdown_cell(table.scenario),
                     escape_markdown_cell(norm_words(table.metric)), ours, theirs, finest(true), finest(false));
}

std::string table_section(const Dominance& table) {
  std::string out = fmt::format("<details><summary>{}: {} against {} [{}]</summary>\n\n", escape_html(table.scenario),
                                table.cost == Cost::seconds ? "time of the run" : "evaluations",
                                escape_html(norm_words(table.metric)), escape_html(table.unit));
  if (!table.by_error.empty())
    out +=
        "| error | cheapest | at | cost | runner-up | ratio | best other engine | ratio |\n| ---: | --- | --- | ---: | "
        "--- | ---: | --- | ---: |\n";
  for (const Contest& contest : table.by_error) {
    const Reached& best = contest.ranked[0];
    out += fmt::format("| {:.0e} | {} | {} | {}{} | {} | {} |\n", contest.asked, escape_markdown_cell(best.family),
                       rung_words(best.method, best.steps, best.at), cost_words(best.cost, table.cost), mark(best),
                       runner_up(contest), times(best_rival(contest, engine_of(best.family)), best));
  }
  if (!table.by_budget.empty())
    out +=
        "\n| budget | most accurate | error | at | runner-up | error | best other engine | error |\n| ---: | --- | "
        "---: | --- | --- | ---: | --- | ---: |\n";
  for (const Contest& contest : table.by_budget) {
    const Reached& best = contest.ranked[0];
    out += fmt::format("| {} | {} | {:.2g}{} | {} | {} | {} |\n", cost_words(contest.asked, table.cost),
                       escape_markdown_cell(best.family), best.error, mark(best),
                       rung_words(best.method, best.steps, best.at),
                       error_words(contest.ranked.size() < 2 ? nullptr : &contest.ranked[1]),
                       error_words(best_rival(contest, engine_of(best.family))));
  }
  return out + "\n</details>\n\n";
}

std::string entrant_words(const GoalEntrant& entrant) {
  if (entrant.method.empty()) return "-";
  std::string words =
      escape_markdown_cell(entrant.method) + (method_family(entrant.method) == entrant.method && entrant.steps > 0
                                                  ? fmt::format(", {} steps", entrant.steps)
                                                  : "");
  if (std::isfinite(entrant.error)) words += ": " + format_measure(entrant.error, entrant.bar, 2);
  if (!std::isnan(entrant.last_quarter)) words += " (" + last_quarter_words(entrant.last_quarter) + ")";
  if (std::isfinite(entrant.evaluations)) words += fmt::format(", {:.0f} evaluations", entrant.evaluations);
  if (std::isfinite(entrant.seconds)) words += ", " + time_words(entrant.seconds);
  if (std::isfinite(entrant.ns_per_step)) words += fmt::format(", {:.4g} ns per step", entrant.ns_per_step);
  return words;
}

}  // namespace

std::string last_quarter_words(double error) {
  return std::isfinite(error) ? fmt::format("{:.2g} over the last quarter", error) : "not finite over the last quarter";
}

std::string floor_words(double error) {
  return fmt::format("error {:.2g} by rounding the initial state alone (condition x unit round-off)", error);
}

std::string left_out_words(const GoalResult& goal) {
  std::set<std::string> families;
  for (const std::string& method : goal.left_out) families.insert(method_family(method));
  return fmt::format(
      "{} finer rungs of {} rivals' methods, whose coarser ones need more than {:.0f} times the evaluations of their "
      "engine's cheapest that reaches the error",
      goal.left_out.size(), families.size(), kMaxEvaluations);
}

std::string machine_words(const MachineState& machine) {
  std::string words = fmt::format("{} of {} timings interrupted", machine.interrupted, machine.timings);
  if (std::isfinite(machine.ghz_low)) words += fmt::format(", {:.2f} to {:.2f} GHz", machine.ghz_low, machine.ghz_high);
  if (machine.again > 0) words += fmt::format(", the calmest of {}", 1 + machine.again);
  return words;
}

std::string busy_words(const std::vector<GoalResult>& goals) {
  std::string again, still;
  const auto add = [](std::string& list, const GoalResult& goal) {
    list += fmt::format("{}`{}` ({})", list.empty() ? "" : ", ", goal.id, machine_words(goal.machine));
  };
  for (const GoalResult& goal : goals) {
    if (busy(goal.machine)) add(still, goal);
    else if (goal.machine.again > 0) add(again, goal);
  }
  std::string words;
  if (!again.empty()) words += "Timed again, since the machine was busy at first: " + again + ".";
  if (!still.empty())
    words += (words.empty() ? "" : " ") + fmt::format("Timed on a busy machine, times may be too long: {}.", still);
  return words;
}

std::string goal_words(const GoalResult& goal) {
  std::string words;
  if (std::isfinite(goal.wanted_error))
    words = fmt::format("{} {:.2g}{}", goal.metric, goal.wanted_error,
                        goal.unit.empty() || goal.unit == "1" ? "" : " " + goal.unit);
  if (std::isfinite(goal.low)) words = fmt::format("{} from {:.4g} to {:.4g}", goal.metric, goal.low, goal.high);
  if (goal.wanted_ratio > 0 && !std::isfinite(goal.budget)) {
    return fmt::format("{}{}{:.3g} times as fast as the best rival", words, words.empty() ? "" : " and ",
                       goal.wanted_ratio);
  }
  const std::string join = words.empty() ? "" : " in ";
  if (goal.budget_kind == "seconds") return words + join + time_words(goal.budget);
  if (goal.budget_kind == "evaluations") return words + join + fmt::format("{:.0f} evaluations", goal.budget);
  if (goal.budget_kind == "ns_per_step")
    return words + (words.empty() ? "" : " at ") + fmt::format("{:.4g} ns per step", goal.budget);
  if (goal.budget_kind == "ns") return words + join + fmt::format("{:.4g} ns", goal.budget);
  return words;
}

std::string dominance_section(const std::vector<Dominance>& tables) {
  if (tables.empty()) return "";
  std::string out =
      "## Cheapest method for an error\n\nErrors from 1e-3 to 1e-13 that some method reaches; a ratio is the cost of "
      "the other method over that of the cheapest. All figures are of measured rungs. <: no cheaper rung was measured; "
      "*: the error is below three bars of the truth.\n\n"
      "| scenario | error | levels atwood leads | levels another engine leads | finest level of atwood | of others "
      "|\n| --- | --- | ---: | ---: | ---: | ---: |\n";
  std::string details, last;
  for (const Dominance& table : tables) {
    if (table.scenario != last) out += summary_line(table);
    last = table.scenario;
    details += table_section(table);
  }
  return out + "\n" + details;
}

// What interrupted the timings of all goals, and which of them were timed on a busy machine.
static std::string machine_sentences(const std::vector<GoalResult>& goals) {
  std::int64_t timings = 0, interrupted = 0, repeated = 0;
  for (const GoalResult& goal : goals)
    timings += goal.machine.timings, interrupted += goal.machine.interrupted, repeated += goal.machine.repeated;
  if (timings == 0) return "";
  std::string words =
      fmt::format("{} of {} timings were interrupted, {} of them taken again.", interrupted, timings, repeated);
  if (const std::string of_goals = busy_words(goals); !of_goals.empty()) words += " " + of_goals;
  return words + "\n\n";
}

// The best of a side, and those of it that are close.
static std::string entrants_words(const GoalEntrant& best, const GoalResult& goal, bool ours) {
  std::string words = entrant_words(best);
  for (const GoalEntrant& entrant : goal.close)
    if ((engine_of(entrant.method) == engine_of(goal.ours.method)) == ours)
      words += "; within 20 %: " + entrant_words(entrant);
  return words;
}

// Beside a library the ratio at the same rate comes first.
static std::string ratio_words(const GoalResult& goal) {
  const std::string native = std::isfinite(goal.ratio) ? fmt::format("{:.3g}", goal.ratio) : "-";
  if (!std::isfinite(goal.same_rate_ratio)) return native;
  return fmt::format("{:.3g} at the same rate ({}); native {}", goal.same_rate_ratio,
                     escape_markdown_cell(goal.library.method), native);
}

std::string goals_section(const std::vector<GoalResult>& goals) {
  if (goals.empty()) return "";
  std::string out =
      "## Goals\n\nMeasured beside the rivals in one run; a ratio is the best rival's cost over ours, where both reach "
      "the error.\n\n"
      "| goal | asked | | ours | best rival | ratio |\n| --- | --- | --- | --- | --- | ---: |\n";
  for (const GoalResult& goal : goals) {
    out += fmt::format("| {} | {} | {} | {}{} | {} | {} |\n", escape_markdown_cell(goal.title),
                       escape_markdown_cell(goal_words(goal)), goal.reached ? "reached" : "**not reached**",
                       entrants_words(goal.ours, goal, true),
                       (std::isfinite(goal.ours.floor) ? "; floor: " + floor_words(goal.ours.floor) : "") +
                           (goal.why.empty() ? "" : "; " + escape_markdown_cell(goal.why)),
                       entrants_words(goal.rival, goal, false), ratio_words(goal));
  }
  std::string left_out;
  for (const GoalResult& goal : goals)
    if (!goal.left_out.empty()) left_out += fmt::format("Left out of `{}`: {}. ", goal.id, left_out_words(goal));
  if (!left_out.empty()) left_out += "\n\n";
  return out + "\n" + left_out + machine_sentences(goals);
}

}  // namespace atwood
