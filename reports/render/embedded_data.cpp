#include "embedded_data.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <unordered_map>

#include "bench_table.hpp"
#include "compressed.hpp"
#include "drawn_scenes.hpp"
#include "json_parts.hpp"
#include "text.hpp"

namespace atwood {
namespace {

class StringTable {
 public:
  std::int64_t index(const std::string& text) {
    const auto [where, is_new] = indices_.try_emplace(text, static_cast<std::int64_t>(strings_.size()));
    if (is_new) strings_.push_back(text);
    return where->second;
  }
  const std::vector<std::string>& strings() const { return strings_; }

 private:
  std::unordered_map<std::string, std::int64_t> indices_;
  std::vector<std::string> strings_;
};

bool ends_with(const std::string& text, std::string_view end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

// Neighbours that share scenario, method and metric compress to almost nothing: rows go in that order.
std::vector<const Row*> sorted_rows(const std::vector<Row>& rows, const Detail& detail, std::size_t& left_out) {
  std::unordered_map<std::string, int> scenarios, methods, metrics;
  const auto rank = [](std::unordered_map<std::string, int>& ranks, const std::string& name) {
    return ranks.try_emplace(name, static_cast<int>(ranks.size())).first->second;
  };
  struct Keyed {
    std::array<std::int64_t, 4> key;
    const Row* row;
  };
  std::vector<Keyed> keyed;
  for (const Row& row : rows) {
    if (!detail.rms_and_timed_rows && row.status == Status::ok && (row.t_s || ends_with(row.metric, "-rms"))) {
      ++left_out;
      continue;
    }
    keyed.push_back(
        {{rank(scenarios, row.scenario), rank(methods, row.method), rank(metrics, row.metric), row.steps}, &row});
  }
  std::stable_sort(keyed.begin(), keyed.end(), [](const Keyed& a, const Keyed& b) { return a.key < b.key; });
  std::vector<const Row*> sorted;
  for (const Keyed& entry : keyed) sorted.push_back(entry.row);
  return sorted;
}

// What is not as it was, figures that became worse first; at most max_changes, which a reader can read.
std::vector<BaselineChange> chosen_changes(const std::vector<BaselineChange>& all) {
  constexpr std::size_t max_changes = 400;
  using Kind = BaselineChange::Kind;
  std::vector<BaselineChange> changes;
  for (const Kind kind : {Kind::regression, Kind::improvement, Kind::missing, Kind::added}) {
    const auto from = static_cast<std::ptrdiff_t>(changes.size());
    for (const BaselineChange& change : all)
      if (change.kind == kind) changes.push_back(change);
    if (kind == Kind::regression)
      std::stable_sort(changes.begin() + from, changes.end(),
                       [](const BaselineChange& a, const BaselineChange& b) { return a.ratio > b.ratio; });
  }
  if (changes.size() > max_changes) changes.resize(max_changes);
  return changes;
}

// How many figures changed, by kind, those that are not embedded among them.
void append_change_counts(JsonText& json, const std::vector<BaselineChange>& all) {
  using Kind = BaselineChange::Kind;
  json.begin_object();
  for (const auto& [name, kind] : {std::pair{"regression", Kind::regression},
                                   {"improvement", Kind::improvement},
                                   {"missing", Kind::missing},
                                   {"added", Kind::added}})
    json.member_integer(name, std::count_if(all.begin(), all.end(), [kind = kind](const BaselineChange& change) {
                          return change.kind == kind;
                        }));
  json.end_object();
}

template <class Get>
void append_column(JsonText& json, const char* name, const std::vector<const Row*>& rows, Get get) {
  json.key(name).begin_array();
  for (const Row* row : rows) get(*row);
  json.end_array();
}

void append_rows(JsonText& json, const std::vector<const Row*>& rows, StringTable& strings, const Detail& detail) {
  const auto text = [&](const char* name, auto get) {
    append_column(json, name, rows, [&](const Row& row) { json.integer(strings.index(get(row))); });
  };
  json.begin_object();
  text("scenario", [](const Row& row) { return row.scenario; });
  // A fluid's ladder of steps is one of its resolution.
  text("method", [](const Row& row) {
    const std::string at = resolution_text(resolution_of(row));
    return at.empty() ? row.method : row.method + " at " + at;
  });
  append_column(json, "steps", rows, [&](const Row& row) { json.integer(row.steps); });
  append_column(json, "h_s", rows, [&](const Row& row) { json.number(row.h_s, 6); });
  text("body", [](const Row& row) { return row.body; });
  append_column(json, "t_s", rows, [&](const Row& row) { row.t_s ? json.number(*row.t_s, 6) : json.null(); });
  text("metric", [](const Row& row) { return row.metric; });
  text("unit", [](const Row& row) { return row.unit; });
  append_column(json, "value", rows, [&](const Row& row) { json.number(row.value, detail.value_digits); });
  append_column(json, "truth_bar", rows, [&](const Row& row) { json.number(row.truth_bar, 2); });
  text("status", [](const Row& row) { return to_string(row.status); });
  text("reason", [](const Row& row) { return row.reason; });
  text("settings_hash", [](const Row& row) { return row.settings_hash; });
  text("engine_version", [](const Row& row) { return row.provenance->engine_version; });
  json.end_object();
}

// First, last and evenly between, at most `wanted` of `count`.
std::vector<std::size_t> spread(std::size_t count, std::size_t wanted) {
  std::vector<std::size_t> chosen;
  if (wanted >= count) {
    chosen.resize(count);
    std::iota(chosen.begin(), chosen.end(), std::size_t{0});
  } else if (wanted == 1) {
    chosen.push_back(count / 2);
  } else {
    for (std::size_t i = 0; i < wanted; ++i) chosen.push_back(i * (count - 1) / (wanted - 1));
  }
  return chosen;
}

// Of each scenario x method the coarsest, the middle and the finest rung (or fewer).
std::vector<const StoredSeries*> chosen_series(const std::vector<StoredSeries>& all, std::size_t rungs) {
  std::map<std::pair<std::string, std::string>, std::vector<const StoredSeries*>> groups;
  for (const StoredSeries& stored : all) groups[{stored.scenario, stored.method}].push_back(&stored);
  std::vector<const StoredSeries*> chosen;
  for (auto& [key, group] : groups) {
    std::stable_sort(group.begin(), group.end(),
                     [](const StoredSeries* a, const StoredSeries* b) { return a->steps < b->steps; });
    for (const std::size_t index : spread(group.size(), rungs)) chosen.push_back(group[index]);
  }
  return chosen;
}

void append_series_column(JsonText& json, const char* name, const std::vector<double>& values,
                          const std::vector<std::size_t>& kept) {
  const bool empty = std::all_of(values.begin(), values.end(), [](double value) { return value == 0; });
  if (empty) return;  // all zero: the plot has nothing to draw
  json.key(name).begin_array();
  for (const std::size_t index : kept) {
    if (index < values.size()) json.number(values[index], 3);
  }
  json.end_array();
}

void append_series(JsonText& json, const std::vector<const StoredSeries*>& all, StringTable& strings,
                   const Detail& detail) {
  // Sampling instants are the same over many runs: each list is written once.
  std::map<std::vector<double>, std::int64_t> instants;
  std::vector<const std::vector<double>*> ordered;
  std::vector<std::pair<std::int64_t, std::vector<std::size_t>>> kept;
  std::vector<std::vector<double>> thinned;
  thinned.reserve(all.size());
  for (const StoredSeries* stored : all) {
    std::vector<std::size_t> indices = spread(stored->series.t_s.size(), detail.series_points);
    std::vector<double> times;
    for (const std::size_t index : indices) times.push_back(stored->series.t_s[index]);
    const auto [where, is_new] = instants.try_emplace(std::move(times), static_cast<std::int64_t>(instants.size()));
    if (is_new) ordered.push_back(&where->first);
    kept.emplace_back(where->second, std::move(indices));
  }
  json.begin_object().key("instants").begin_array();
  for (const std::vector<double>* times : ordered) {
    json.begin_array();
    for (const double t_s : *times) json.number(t_s, 6);
    json.end_array();
  }
  json.end_array().key("runs").begin_array();
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Series& series = all[i]->series;
    json.begin_object();
    json.member_integer("s", strings.index(all[i]->scenario)).member_integer("m", strings.index(all[i]->method));
    json.member_integer("n", all[i]->steps).member_integer("t", kept[i].first);
    append_series_column(json, "position", series.position_m, kept[i].second);
    append_series_column(json, "velocity", series.velocity_m_per_s, kept[i].second);
    append_series_column(json, "attitude", series.attitude_rad, kept[i].second);
    append_series_column(json, "body-rate", series.body_rate_rad_per_s, kept[i].second);
    append_series_column(json, "energy", series.energy, kept[i].second);
    json.end_object();
  }
  json.end_array().end_object();
}

// Whole numbers from 0 to `most` between the least and the largest value, which stand before them. `logs`: of decimal
// logarithms, zeros at the least.
void append_levels(JsonText& json, const char* name, const std::vector<float>& values,
                   const std::vector<std::size_t>& kept, double low, double high, int most, bool logs) {
  if (values.empty()) return;
  json.key(name).begin_object().key("low").number(low, 6).key("high").number(high, 6).key("at").begin_array();
  for (const std::size_t i : kept) {
    const double value = logs ? std::log10(std::max(static_cast<double>(values[i]), 1e-300)) : values[i];
    const double share = high > low ? std::clamp((value - low) / (high - low), 0.0, 1.0) : 0.5;
    json.number(std::round(share * most), 5);
  }
  json.end_array().end_object();
}

std::pair<double, double> range_of(const std::vector<float>& values, bool logs) {
  constexpr double decades = 6;  // of errors that are drawn
  double low = INFINITY, high = -INFINITY;
  for (const float value : values) {
    const double v = logs ? std::log10(static_cast<double>(value)) : static_cast<double>(value);
    if (std::isfinite(v)) low = std::min(low, v), high = std::max(high, v);
  }
  if (!(low <= high)) return {0, 0};
  return {logs ? std::max(low, high - decades) : low, high};
}

// Fields of fluids as pictures: positions in 4096ths of the frame, values in 250ths of their range.
void append_pictures(JsonText& json, const std::vector<StoredPicture>& pictures, StringTable& strings,
                     const Detail& detail) {
  json.begin_array();
  for (const StoredPicture& stored : pictures) {
    const FluidPicture& picture = stored.picture;
    const std::vector<std::size_t> kept = spread(picture.x_m.size(), detail.drawn_particles);
    if (kept.empty()) continue;
    json.begin_object();
    json.member_integer("s", strings.index(stored.scenario)).member_integer("m", strings.index(stored.method));
    json.member_integer("n", stored.steps).key("dx").number(stored.at.first.value_or(0), 6);
    json.key("c").number(stored.at.second.value_or(0), 6).key("t").number(picture.t_s, 6);
    json.member_integer("particles", picture.particles).member("error_of", picture.error_of);
    // Fewer particles stand for larger squares.
    json.key("side").number(
        picture.side_m * std::sqrt(static_cast<double>(picture.x_m.size()) / static_cast<double>(kept.size())), 5);
    append_levels(json, "x", picture.x_m, kept, picture.low_m[0], picture.high_m[0], 4096, false);
    append_levels(json, "y", picture.y_m, kept, picture.low_m[1], picture.high_m[1], 4096, false);
    for (const auto& [name, values, logs] : {std::tuple{"speed", &picture.speed_m_per_s, false},
                                             {"pressure", &picture.pressure_Pa, false},
                                             {"temperature", &picture.temperature_K, false},
                                             {"error", &picture.error, true}}) {
      const auto [low, high] = range_of(*values, logs);
      append_levels(json, name, *values, kept, low, high, 250, logs);
    }
    json.end_object();
  }
  json.end_array();
}

std::string left_out_words(const ReportData& data, std::size_t rows, std::size_t series, const Detail& detail) {
  std::string text =
      fmt::format("Figures on this page carry {} significant digits, curves over time 3.", detail.value_digits);
  if (rows > 0) text += fmt::format(" {} of {} rows (rms, single instants) are left out here.", rows, data.rows.size());
  if (series > 0)
    text += fmt::format(" Curves over time: {} of {} runs.", data.series.size() - series, data.series.size());
  return text + " The CSV and JSON reports hold every digit of every row.";
}

}  // namespace

std::string embedded_json(const ReportData& data, const Detail& detail) {
  StringTable strings;
  std::size_t rows_left_out = 0;
  const std::vector<const Row*> rows = sorted_rows(data.rows, detail, rows_left_out);
  const std::vector<const StoredSeries*> series = chosen_series(data.series, detail.series_rungs);
  JsonText json(false);
  json.begin_object().member("title", data.title).member("command", data.command).member("program", data.program);
  json.member("left_out", left_out_words(data, rows_left_out, data.series.size() - series.size(), detail));
  append_provenance(json.key("provenance"), data.provenance);
  append_verdicts(json.key("verdicts"), data.verdicts);
  const bool judged = !data.baseline_path.empty();
  if (judged || !data.last_run.empty()) {
    const std::vector<BaselineChange>& changes = judged ? data.baseline : data.since_last_run;
    json.member("changes_against", judged ? data.baseline_path : data.last_run);
    append_change_counts(json.key("change_counts"), changes);
    append_baseline(json.key("changes"), chosen_changes(changes));
  }
  if (!judged && data.first_run) json.key("first_run").boolean(true);
  append_laws(json.key("laws"), data.laws);
  append_scenarios(json.key("scenarios"), data.scenarios);
  json.key("own_files").begin_object();
  for (const auto& [scenario, file] : data.own_files) json.member(scenario, file);
  json.end_object();
  const std::vector<RanMethod> ran = ran_methods(data.engines, data.rows);
  append_engines(json.key("engines"), engines_that_ran(data.engines, ran));
  append_ran(json.key("ran"), ran);
  append_missing(json.key("missing_engines"), data.missing_engines);
  append_metrics(json.key("metrics"), data.metrics);
  append_bench(json.key("bench"), data.bench);
  append_dominance(json.key("dominance"), data.dominance, detail.ranks);
  append_goals(json.key("goals"), data.goals);
  if (!data.tables.empty()) append_tables(json.key("tables"), data.tables);
  if (!data.audit.empty()) append_audit(json.key("audit"), data.audit);
  json.key("notes").begin_array();
  for (const std::string& note : data.notes) json.text(note);
  json.end_array();
  append_rows(json.key("rows"), rows, strings, detail);
  append_series(json.key("series"), series, strings, detail);
  if (!data.pictures.empty()) append_pictures(json.key("pictures"), data.pictures, strings, detail);
  if (!data.paths.empty()) append_drawn_scenes(json.key("scenes"), data.scenarios, data.paths);
  json.key("strings").begin_array();
  for (const std::string& text : strings.strings()) json.text(text);
  json.end_array().end_object();
  return json.str();
}

std::string embedded_data(const ReportData& data, std::size_t limit) {
  constexpr std::array<Detail, 7> details{{{6, 3, 129, true, 8, 2500},
                                           {6, 2, 97, true, 8, 2500},
                                           {6, 1, 97, true, 6, 1600},
                                           {5, 1, 65, true, 4, 1600},
                                           {5, 1, 49, false, 3, 900},
                                           {4, 1, 25, false, 3, 400},
                                           {4, 0, 0, false, 2, 0}}};
  std::string coded;
  for (const Detail& detail : details) {
    coded = base64(deflated(embedded_json(data, detail)));
    if (coded.size() <= limit) break;
  }
  return coded;
}

}  // namespace atwood
