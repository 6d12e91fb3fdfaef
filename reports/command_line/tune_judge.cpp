// Compares settings at equal time, and decides which are kept.
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "reports/command_line/method_words.hpp"
#include "reports/command_line/tune.hpp"
#include "scene/files.hpp"

namespace atwood {
namespace {

using json = nlohmann::ordered_json;

// Errors under this of the figure's unit are round-off: none is better than another.
constexpr double kRoundOff = 1e-12;

// Of any figure, in its unit: what tune.cpp's search takes for no difference.
constexpr double kMinDifference = 1e-6;

double rounded_ratio(double ratio) {
  if (!(ratio > 0) || !std::isfinite(ratio)) return 1;
  const double quarters = std::floor(4 * std::log2(ratio));
  return quarters < 1 ? 1 : std::exp2(quarters / 4);
}

}  // namespace

double default_at_equal_time(const TuneFigure& figure) {
  const std::vector<double>& ladder = figure.of_default;
  if (ladder.empty()) return std::numeric_limits<double>::quiet_NaN();
  const double rung = std::log2(rounded_ratio(figure.time_ratio));  // runs of twice the steps take twice the time
  const auto below = std::min(static_cast<std::size_t>(rung), ladder.size() - 1);
  if (below + 1 >= ladder.size()) return ladder.back();
  const double part = rung - static_cast<double>(below), floor = kRoundOff;
  return std::exp((1 - part) * std::log(std::fabs(ladder[below]) + floor) +
                  part * std::log(std::fabs(ladder[below + 1]) + floor)) -
         floor;
}

double tune_score(std::span<const TuneFigure> figures) {
  std::map<std::string, std::pair<double, int>> scenes;
  for (const TuneFigure& figure : figures) {
    const double other = default_at_equal_time(figure);
    if (!std::isfinite(figure.of_trial)) return std::numeric_limits<double>::infinity();
    if (!std::isfinite(other)) continue;
    const double floor = std::max(figure.bar, kRoundOff);
    auto& [sum, count] = scenes[figure.scenario];
    sum += std::clamp(std::log((std::fabs(figure.of_trial) + floor) / (std::fabs(other) + floor)), -7.0, 7.0);
    ++count;
  }
  if (scenes.empty()) return std::numeric_limits<double>::infinity();
  double total = 0;
  for (const auto& [scene, one] : scenes) total += one.first / one.second;
  return total / static_cast<double>(scenes.size());
}

bool TuneEvidence::worse() const {
  return !(std::fabs(of_tuned) <= std::fabs(of_default) + interval + 1e-9 * std::fabs(of_default));
}

bool loses_to_default(double of_default, double of_tuned, double bar) {
  constexpr double most_ratio = 1.5;
  return !(std::fabs(of_tuned) <= most_ratio * std::fabs(of_default) + bar + kMinDifference);
}

bool TuneEvidence::better() const { return std::fabs(of_tuned) < std::fabs(of_default) - interval; }

std::string tuned_file_with(const std::string& text, const TuneResult& result) {
  json all;
  try {
    all = text.empty() ? json::object() : json::parse(text);
  } catch (const json::parse_error& fault) {
    throw InputError(fmt::format("the file of tuned settings: {}", fault.what()));
  }
  if (!all.is_object()) throw InputError("the file of tuned settings: expected an object of engines");
  json entry{{"verdict", result.verdict}, {"settings", json::object()}};
  for (const auto& [name, value] : result.settings) entry["settings"][name] = json_of(value);
  entry["trials"] = result.trials;
  entry["failed_trials"] = result.failed;
  entry["tried_held_out"] = result.tried_held_out;
  entry["seed"] = result.seed;
  entry["training"] = result.training;
  entry["held_out"] = result.held_out;
  entry["class_figures"] = result.class_figures;
  entry["evidence"] = json::array();
  for (const TuneEvidence& e : result.evidence)
    entry["evidence"].push_back({{"scenario", e.scenario},
                                 {"metric", e.metric},
                                 {"steps", e.steps},
                                 {"held_out", e.held_out},
                                 {"default", e.of_default},
                                 {"tuned", e.of_tuned},
                                 {"interval", e.interval},
                                 {"time_ratio", e.time_ratio}});
  all[result.engine][result.scene_class] = entry;
  return all.dump(1) + "\n";
}

}  // namespace atwood
