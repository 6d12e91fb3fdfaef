#include "figures_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

#include "fluid_table.hpp"
#include "text.hpp"
#include "validation/metrics/metrics.hpp"

namespace atwood {
namespace {

constexpr std::size_t kMaxPairs = 40;

using Pair = std::pair<std::string, std::string>;  // scenario, method

// Rows of one pair that stand for whole runs.
struct Ladder {
  std::map<std::pair<std::int64_t, std::string>, const Row*> figures;  // steps, metric: rows that are ok
  std::set<std::int64_t> rungs, ended;                                 // ended: with the engine's own bad end
  std::map<Status, int> endings;
  std::map<Status, std::set<std::int64_t>> timing_failed;  // the timed pass alone crashed or hung

  const Row* at(std::int64_t steps, const std::string& metric) const {
    const auto found = figures.find({steps, metric});
    return found == figures.end() ? nullptr : found->second;
  }
  std::int64_t finest() const {  // of those that ended well
    for (auto rung = rungs.rbegin(); rung != rungs.rend(); ++rung)
      if (!ended.contains(*rung)) return *rung;
    return rungs.empty() ? 0 : *rungs.rbegin();
  }
};

struct Ladders {
  std::vector<Pair> order;
  std::map<Pair, Ladder> all;
};

Ladders ladders_of(const std::vector<Row>& rows) {
  Ladders result;
  for (const Row& row : rows) {
    if (!row.body.empty() || row.t_s || row.spacing_m || row.sound_speed_m_per_s) continue;  // fluids: fluid_table.hpp
    const auto [place, is_new] = result.all.try_emplace({row.scenario, row.method});
    if (is_new) result.order.push_back(place->first);
    Ladder& ladder = place->second;
    if (row.steps > 0) ladder.rungs.insert(row.steps);
    if (row.status == Status::ok) ladder.figures[{row.steps, row.metric}] = &row;
    else if (row.metric == "status" && ladder.ended.insert(row.steps).second) ++ladder.endings[row.status];
    else if (row.metric.starts_with("step-time") && (row.status == Status::crashed || row.status == Status::timeout))
      ladder.timing_failed[row.status].insert(row.steps);
  }
  return result;
}

// The quantity whose error decides on this scene: position, unless nothing moves but attitudes, or the system is a bare
// one of equations.
std::string deciding_quantity(const Ladders& ladders, const std::string& scenario) {
  constexpr std::array<const char*, 5> quantities{"position", "attitude", "velocity", "body-rate", "state"};
  std::map<std::string, double> conclusive, largest;
  for (const auto& [pair, ladder] : ladders.all) {
    if (pair.first != scenario) continue;
    for (const char* quantity : quantities) {
      const Row* order = ladder.at(0, std::string("order-") + quantity);
      if (order && !std::isnan(order->value)) conclusive[quantity] += 1;
      const Row* error = ladder.at(ladder.finest(), std::string("error-") + quantity + "-max");
      if (error && std::abs(error->value) > 3 * error->truth_bar)
        largest[quantity] = std::max(largest[quantity], std::abs(error->value));
    }
  }
  for (const char* quantity : quantities)
    if (conclusive[quantity] > 0) return quantity;
  if (largest["position"] < 1e-13 && largest["attitude"] > largest["position"]) return "attitude";
  for (const char* quantity : quantities)
    if (largest[quantity] > 0) return quantity;
  return "position";
}

std::string error_cell(const Ladder& ladder, const std::string& quantity) {
  for (const char* norm : {"-max", "-end"}) {
    const Row* error = ladder.at(ladder.finest(), "error-" + quantity + norm);
    if (error) return format_measure(error->value, error->truth_bar) + (error->unit == "1" ? "" : " " + error->unit);
  }
  return "-";
}

std::string order_cell(const ReportData& data, const Pair& pair, const Ladder& ladder, const std::string& quantity) {
  const std::string metric = "order-" + quantity;
  const Row* order = ladder.at(0, metric);
  if (!order) return "-";
  std::string text =
      std::isnan(order->value) ? "inconclusive" : fmt::format("{:.2f} +/- {:.2g}", order->value, order->truth_bar);
  for (const ClaimedOrder& claim : data.claimed_orders)
    if (claim.scenario == pair.first && claim.method == pair.second && claim.metric == metric)
      text += fmt::format(" (claims {})", figure(claim.claimed, 3));
  return text;
}

std::string energy_cell(const Ladder& ladder) {
  for (const char* metric : {"energy-max", "energy-drift"})
    if (const Row* row = ladder.at(ladder.finest(), metric)) return figure(row->value, 2);
  return "-";
}

std::string verdict_cell(const ReportData& data, const Pair& pair, const Ladder& ladder) {
  JudgementCounts counts;
  for (const Verdict& v : data.verdicts) {
    if (v.scenario != pair.first || v.method != pair.second || v.of_cell) continue;
    if (v.judgement == Judgement::pass) ++counts.pass;
    else if (v.judgement == Judgement::fail) ++counts.fail;
    else if (v.judgement == Judgement::unverifiable) ++counts.unverifiable;
    else ++counts.not_run;
  }
  std::string text = counts.fail > 0           ? "FAIL"
                     : counts.unverifiable > 0 ? "unverifiable"
                     : counts.not_run > 0      ? "not run"
                     : counts.pass > 0         ? "pass"
                                               : "no gate";
  for (const auto& [status, number] : ladder.endings) {
    const bool all = number == static_cast<int>(ladder.rungs.size());
    const std::string how_many = all ? "" : fmt::format("{} of {} ", number, ladder.rungs.size());
    text += (text.empty() ? "" : "; ") + how_many + to_string(status);
  }
  for (const auto& [status, steps] : ladder.timing_failed) {
    const auto number =
        std::count_if(steps.begin(), steps.end(), [&](std::int64_t n) { return !ladder.ended.contains(n); });
    if (number > 0)
      text += fmt::format("; {} of {} {} in the timed pass", number, ladder.rungs.size(), to_string(status));
  }
  return text;
}

}  // namespace

std::string claim_words(const ClaimedOrder& order) {
  if (std::isnan(order.observed)) return "";
  const double give = std::max(0.1, 0.02 * order.claimed);  // as gates on claims have it
  const char* side = order.observed + order.half_width_95 < order.claimed - give   ? "below its claim"
                     : order.observed - order.half_width_95 > order.claimed + give ? "above its claim"
                                                                                   : nullptr;
  if (side == nullptr) return "";
  return fmt::format("claims {}, observed {:.2f} +/- {:.2g}: {}", figure(order.claimed, 3), order.observed,
                     order.half_width_95, side);
}

std::string figures_table(const ReportData& data, const Palette& palette, std::size_t room) {
  const Ladders ladders = ladders_of(data.rows);
  if (ladders.order.empty() || ladders.order.size() > kMaxPairs) return fluid_text(data.rows);
  constexpr std::array<const char*, 7> heads{"method", "steps", "error", "order", "energy", "step time", "verdict"};
  std::string out;
  std::set<std::string> told;
  for (const auto& [scenario, first] : ladders.order) {
    if (!told.insert(scenario).second) continue;
    const std::string quantity = deciding_quantity(ladders, scenario);
    std::vector<std::array<std::string, 7>> lines;
    for (const Pair& pair : ladders.order) {
      if (pair.first != scenario) continue;
      const Ladder& ladder = ladders.all.at(pair);
      const Row* time = ladder.at(ladder.finest(), "step-time");
      lines.push_back({one_line(pair.second), ladder.finest() > 0 ? std::to_string(ladder.finest()) : "-",
                       error_cell(ladder, quantity), order_cell(data, pair, ladder, quantity), energy_cell(ladder),
                       time ? time_words(time->value) : "-", one_line(verdict_cell(data, pair, ladder))});
    }
    std::array<std::size_t, 7> widths{};
    for (std::size_t i = 0; i < heads.size(); ++i) {
      widths[i] = std::string_view(heads[i]).size();
      for (const auto& line : lines) widths[i] = std::max(widths[i], display_width(line[i]));
    }
    std::size_t others = 2;
    for (std::size_t i = 1; i < widths.size(); ++i) others += widths[i] + 2;
    widths[0] = std::min(widths[0], std::max<std::size_t>(room > others ? room - others : 0, 24));
    out += (out.empty() ? "" : "\n") + std::string(palette.bold) + one_line(scenario) + palette.off +
           fmt::format("  (error: {}, at the finest rung)\n", norm_words("error-" + quantity + "-max"));
    const auto print = [&](const std::array<std::string, 7>& line, const char* ink) {
      std::string text = "  " + std::string(ink) + padded(fit(line[0], widths[0]), widths[0]);
      for (std::size_t i = 1; i < line.size(); ++i)
        text += "  " + (i == 6 ? line[i] : i == 3 ? padded(line[i], widths[i]) : right(line[i], widths[i]));
      return text + palette.off + "\n";
    };
    std::array<std::string, 7> head;
    std::copy(heads.begin(), heads.end(), head.begin());
    out += print(head, palette.dim);
    for (const auto& line : lines) out += print(line, line[6].starts_with("FAIL") ? palette.red : "");
  }
  if (const std::string fluids = fluid_text(data.rows); !fluids.empty()) out += "\n" + fluids;
  return out;
}

}  // namespace atwood
