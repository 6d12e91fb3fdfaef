#include "reports/command_line/compare_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>

#include "reports/command_line/contest.hpp"
#include "reports/command_line/manual.hpp"
#include "reports/command_line/same_rate.hpp"
#include "reports/render/scatter.hpp"
#include "reports/render/text.hpp"

namespace atwood {

namespace {

// A curve's letter, the same in plot and tables.
using Letters = std::map<std::string, char>;

constexpr int kFluidRung = 30;  // characters of "1280 steps, dx 0.02, c 40"

char letter(std::size_t index) {
  static const std::string all = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ";
  return index < all.size() ? all[index] : '?';
}

std::string fit_to(const std::string& text, std::size_t width) {
  return text.size() <= width ? text : text.substr(0, width - 3) + "...";
}
// Shortens a long id at its beginning: the end distinguishes it.
std::string fit_id(const std::string& id, std::size_t width) {
  return id.size() <= width ? id : "..." + id.substr(id.size() - width + 3);
}

std::string plot(const std::vector<WorkCurve>& curves, const Letters& letters, const std::string& metric,
                 const std::string& unit, int width) {
  const bool timed = std::any_of(curves.begin(), curves.end(), [](const WorkCurve& curve) {
    return std::any_of(curve.points.begin(), curve.points.end(),
                       [](const WorkPoint& point) { return point.seconds > 0; });
  });
  Scatter scatter;
  scatter.width = width;
  scatter.y_label = fmt::format("  error [{}]: {}", unit, norm_words(metric));
  scatter.x_label = timed ? "time of the run [s]" : "evaluations of the equations of motion";
  for (const WorkCurve& curve : curves) {
    ScatterCurve drawn{letters.at(curve.family), {}, {}};
    for (const WorkPoint& point : curve.points) {
      drawn.x.push_back(cost_of(point, timed ? Cost::seconds : Cost::evaluations));
      drawn.y.push_back(known_error(point));
    }
    scatter.curves.push_back(std::move(drawn));
  }
  return render_scatter(scatter);
}

std::string order_words(const ReportData& data, const std::string& scenario, const std::string& family) {
  std::string words;
  for (const Row& row : data.rows) {
    if (row.scenario != scenario || row.method != family || row.steps != 0 || !std::isfinite(row.value)) continue;
    const bool shown = row.spacing_m || row.sound_speed_m_per_s
                           ? row.metric == "order-space" || row.metric == "order-time"
                           : row.metric == "order-position" || row.metric == "order-attitude";
    if (!shown) continue;
    words += fmt::format("{}{} {:.2f} +/- {:.2f}", words.empty() ? "order of " : ", ", row.metric.substr(6), row.value,
                         row.truth_bar);
  }
  return words;
}

// Rungs that failed alike on one line. Of fluids the reasons hold each rung's own figures: those that differ in numbers
// alone are alike, and the first is shown.
std::string failed_lines(const std::vector<FailedRung>& failed) {
  struct Alike {
    std::string what;
    std::vector<std::string> rungs;
  };
  std::map<std::string, Alike> alike;
  for (const FailedRung& rung : failed) {
    const std::string what = to_string(rung.status) + ": " + rung.reason;
    std::string key = what;
    if (rung.at.first)
      std::erase_if(key, [](char c) { return (c >= '0' && c <= '9') || c == '.' || c == '-' || c == 'e'; });
    const auto [place, fresh] = alike.try_emplace(key, Alike{what, {}});
    place->second.rungs.push_back(rung_words(rung.method, rung.steps, rung.at));
  }
  std::string text;
  for (const auto& [key, group] : alike) {
    const std::vector<std::string>& rungs = group.rungs;
    const std::string where =
        rungs.size() == 1 ? rungs[0] : fmt::format("{} .. {} ({} rungs)", rungs.front(), rungs.back(), rungs.size());
    text += fmt::format("     {}: {}\n", where, fit_to(group.what, 200));
  }
  return text;
}

const WorkPoint* same_rung(const WorkCurve& curve, const WorkPoint& point) {
  for (const WorkPoint& other : curve.points) {
    if (other.method == point.method && other.steps == point.steps && other.at == point.at) return &other;
  }
  return nullptr;
}

std::string measured(const WorkPoint* point) {
  return point == nullptr ? "-" : format_measure(point->error, point->bar, 3);
}

std::string unit_of(const ReportData& data, const std::string& metric) {
  for (const MetricInfo& known : data.metrics) {
    if (known.name == metric) return known.unit;
  }
  return "";
}

// A metric's name at the head of a column: without "error-", and its unit where there is room.
std::string column_words(const std::string& metric, const ReportData& data) {
  std::string words = metric.rfind("error-", 0) == 0 ? metric.substr(6) : metric;
  std::replace(words.begin(), words.end(), '-', ' ');
  const std::string unit = " [" + unit_of(data, metric) + "]";
  return words.size() + unit.size() <= 18 ? words + unit : fit_to(words, 17);
}

std::string rungs_table(const ReportData& data, const Scenario& scenario, const std::vector<WorkCurve>& curves,
                        const Letters& letters, const std::string& metric) {
  const bool by_position = metric == "error-position-max", fluids = !scenario.scene.fluids.empty();
  const std::string other = fluids        ? (metric == "velocity-l1" ? "pressure-l1" : "velocity-l1")
                            : by_position ? "error-velocity-max"
                                          : "error-position-max";
  const auto others = work_curves(data.rows, scenario.id, other);
  const int width = fluids ? kFluidRung : 14;
  std::string text = fmt::format("     {:<{}} {:>17} {:>17} {:>8} {:>9}\n", "rung", width, column_words(metric, data),
                                 fluids        ? column_words(other, data)
                                 : by_position ? "velocity max[m/s]"
                                               : "position max [m]",
                                 "time", "evals");
  for (const WorkCurve& curve : curves) {
    text += fmt::format("  {}  {}{}\n", letters.at(curve.family), curve.family,
                        order_words(data, scenario.id, curve.family).empty()
                            ? ""
                            : "   " + order_words(data, scenario.id, curve.family));
    const auto second =
        std::find_if(others.begin(), others.end(), [&](const WorkCurve& o) { return o.family == curve.family; });
    for (const WorkPoint& point : curve.points) {
      text +=
          fmt::format("     {:<{}} {:>17} {:>17} {:>8} {:>9}\n", rung_words(point.method, point.steps, point.at), width,
                      measured(&point), measured(second == others.end() ? nullptr : same_rung(*second, point)),
                      curve.under_wasm ? "wasm" : time_words(point.seconds),
                      std::isfinite(point.evaluations) ? fmt::format("{:.0f}", point.evaluations) : "-");
    }
    text += failed_lines(curve.failed);
  }
  return text;
}

std::string mark(const Reached& reached) {
  return std::string(reached.coarsest ? "<" : " ") + (reached.at_bar ? "*" : " ");
}

// The cost of the next method relative to the first.
std::string over_next(const Contest& contest, const Letters& letters) {
  if (contest.ranked.size() < 2) return "alone";
  const Reached& next = contest.ranked[1];
  const char name = letters.at(next.family);
  if (!contest.to_next) return fmt::format("{} {:.2f}x", name, next.cost / contest.ranked[0].cost);
  return fmt::format("{} {:.2f}x [{:.2f}, {:.2f}]", name, contest.to_next->value, contest.to_next->low,
                     contest.to_next->high);
}

// The best of the other engine's side: ours where a rival leads, a rival where we do.
std::string cheapest_table(const Dominance& table, const Letters& letters) {
  std::string text =
      fmt::format("\n  cheapest for a wanted error, by {}\n  ({} [{}])\n",
                  table.cost == Cost::seconds ? "time" : "evaluations", norm_words(table.metric), table.unit);
  for (const Contest& contest : table.by_error) {
    const Reached& best = contest.ranked.front();
    text += fmt::format("    {:<6.2g} {} {:<19} {:<{}} {:>7}{} {}\n", contest.asked, letters.at(best.family),
                        fit_id(best.family, 19), rung_words(best.method, best.steps, best.at),
                        best.at.first ? kFluidRung : 12, cost_words(best.cost, table.cost), mark(best),
                        over_next(contest, letters));
    if (table.by_error.size() == 1)  // one error was asked for
      text += fmt::format("           its error is {:.3g}: {:.3g} times under the asked one\n", best.error,
                          contest.asked / best.error);
    if (const std::string caution = caution_words(best, contest.asked); !caution.empty() && table.by_error.size() == 1)
      text += "           " + caution + "\n";
  }
  return table.by_error.empty() ? "" : text;
}

std::string budget_table(const Dominance& table, const Letters& letters) {
  if (table.by_budget.empty()) return "";
  std::string text = fmt::format("\n  what {} buys ({} [{}])\n",
                                 table.cost == Cost::seconds ? "a budget of time" : "a number of evaluations",
                                 norm_words(table.metric), table.unit);
  for (const Contest& contest : table.by_budget) {
    const Reached& best = contest.ranked.front();
    const std::string next =
        contest.ranked.size() < 2
            ? "alone"
            : fmt::format("next {}: {:.2g}", letters.at(contest.ranked[1].family), contest.ranked[1].error);
    text += fmt::format("    {:>8} {}  {:<24} {:>8.2g}{} {:<11} {}\n", cost_words(contest.asked, table.cost),
                        letters.at(best.family), fit_id(best.family, 24), best.error, mark(best),
                        rung_words(best.method, best.steps, best.at), next);
  }
  return text;
}

// Of fluids: the methods at each spacing and sound speed.
std::string spacing_table(const Dominance& table, const Letters& letters) {
  if (table.by_spacing.empty()) return "";
  std::string text = fmt::format("\n  at equal spacing dx [m] and sound speed c [m/s] ({} [{}])\n",
                                 norm_words(table.metric), table.unit);
  for (const EqualSpacing& place : table.by_spacing) {
    bool first = true;
    for (const Reached& reached : place.ranked) {
      text += fmt::format("    {:<16} {}  {:<24} {:>8.2g}{} {:<11} {:>8}\n", first ? spacing_words(place.at) : "",
                          letters.at(reached.family), fit_id(reached.family, 24), reached.error,
                          reached.at_bar ? " *" : "  ", rung_words(reached.method, reached.steps),
                          time_words(reached.cost));
      first = false;
    }
  }
  return text + "    each method's cheapest rung within 1 % of its least error there\n";
}

std::string stable_table(const Dominance& table, const Letters& letters, double t_end_s) {
  std::string text = "\n  stable from (no finer rung diverges, its error is below the motion's size)\n";
  for (const StableRange& range : table.stable) {
    const std::string where =
        !range.stable         ? "nowhere on this ladder"
        : range.first.h_s > 0 ? fmt::format("{} steps (h = {:.3g} s), error {:.2g}", range.first.steps,
                                            t_end_s / static_cast<double>(range.first.steps), known_error(range.first))
                              : fmt::format("{}, error {:.2g}", rung_words(range.first.method, range.first.steps),
                                            known_error(range.first));
    text += fmt::format("    {}  {:<24} {}\n", letters.at(range.family), fit_id(range.family, 24), where);
    std::vector<FailedRung> unstable;
    std::copy_if(range.failed.begin(), range.failed.end(), std::back_inserter(unstable), [](const FailedRung& rung) {
      return rung.status == Status::diverged || rung.status == Status::not_finite;
    });
    text += failed_lines(unstable);
  }
  return text;
}

}  // namespace

std::string compare_text(const ReportData& data, const Scenario& scenario, const Question& question, int width) {
  std::string text = fmt::format("{}: {}\n", scenario.id, scenario.title);
  if (!data.rates.empty()) text += wrapped(data.rates, 2, 80);
  const std::string metric = question.metric.empty() ? telling_metric(data.rows, scenario.id) : question.metric;
  if (metric.empty()) {
    // Nothing was compared with a truth: prints the reasons.
    const char* any = scenario.scene.fluids.empty() ? "error-position-max" : "velocity-l1";
    for (const WorkCurve& curve : work_curves(data.rows, scenario.id, any))
      text += fmt::format("  {}\n{}", curve.family, failed_lines(curve.failed));
    return text + "  no run of this scenario was measured\n\n";
  }
  const auto curves = work_curves(data.rows, scenario.id, metric);
  Letters letters;
  for (const WorkCurve& curve : curves) letters.emplace(curve.family, letter(letters.size()));
  text += plot(curves, letters, metric, unit_of(data, metric), std::min(width, 80)) + "\n";
  text += rungs_table(data, scenario, curves, letters, metric);
  const Dominance* first = nullptr;
  for (const Dominance& table : data.dominance) {
    if (table.scenario != scenario.id) continue;
    if (first == nullptr) first = &table;
    text += cheapest_table(table, letters) + budget_table(table, letters) + spacing_table(table, letters);
  }
  text +=
      "    each figure is of a measured rung; < nothing cheaper was measured;\n"
      "    * at the truth's bar; x what the next costs, [ ] its 95 % interval in turns\n";
  text += overhead_text(data.overheads, scenario.id);
  if (first != nullptr && scenario.scene.fluids.empty()) text += stable_table(*first, letters, scenario.t_end_s);
  return text + "\n";
}

}  // namespace atwood
