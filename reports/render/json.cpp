// The whole report as one JSON document: what other programs read. Nothing is left out and no digit is dropped.
#include "bench_table.hpp"
#include "json_parts.hpp"
#include "text.hpp"

namespace atwood {
namespace {

void append_row(JsonText& json, const Row& row) {
  json.begin_object().inline_from_here();
  json.member("scenario", row.scenario).member("method", row.method).member_integer("steps", row.steps);
  json.member_number("h_s", row.h_s).member("body", row.body).key("t_s");
  if (row.t_s) {
    json.number(*row.t_s);
  } else {
    json.null();
  }
  if (row.spacing_m) json.member_number("spacing_m", *row.spacing_m);
  if (row.sound_speed_m_per_s) json.member_number("sound_speed_m_per_s", *row.sound_speed_m_per_s);
  json.member("metric", row.metric).member("unit", row.unit).member_number("value", row.value);
  json.member_number("truth_bar", row.truth_bar).member("status", to_string(row.status)).member("reason", row.reason);
  const Provenance& from = *row.provenance;
  json.member("settings_hash", row.settings_hash).member("engine_version", from.engine_version);
  json.member("commit", from.commit).member("compiler", from.compiler).member("flags", from.flags);
  json.member("cpu", from.cpu).member("run_id", from.run_id).end_object();
}

void append_column(JsonText& json, const char* name, const std::vector<double>& values) {
  if (values.empty()) return;
  json.key(name).begin_array().inline_from_here();
  for (const double value : values) json.number(value);
  json.end_array();
}

void append_series(JsonText& json, const StoredSeries& stored) {
  json.begin_object().member("scenario", stored.scenario).member("method", stored.method);
  json.member_integer("steps", stored.steps);
  if (stored.spacing_m) json.member_number("spacing_m", *stored.spacing_m);
  if (stored.sound_speed_m_per_s) json.member_number("sound_speed_m_per_s", *stored.sound_speed_m_per_s);
  const Series& series = stored.series;
  append_column(json, "t_s", series.t_s);
  append_column(json, "position_m", series.position_m);
  append_column(json, "velocity_m_per_s", series.velocity_m_per_s);
  append_column(json, "attitude_rad", series.attitude_rad);
  append_column(json, "body_rate_rad_per_s", series.body_rate_rad_per_s);
  append_column(json, "energy", series.energy);
  json.end_object();
}

}  // namespace

std::string render_json(const ReportData& data) {
  JsonText json(true);
  const JudgementCounts counts = count(data.verdicts);
  json.begin_object().member("title", data.title).member("command", data.command);
  json.key("verdict").begin_object().inline_from_here();
  json.member_integer("pass", counts.pass).member_integer("fail", counts.fail);
  json.member_integer("unverifiable", counts.unverifiable).member_integer("not_run", counts.not_run).end_object();
  append_provenance(json.key("provenance"), data.provenance);
  append_verdicts(json.key("verdicts"), data.verdicts);
  if (!data.refused_truths.empty()) append_refused_truths(json.key("refused_truths"), data.refused_truths);
  if (!data.claimed_orders.empty()) append_claimed_orders(json.key("claimed_orders"), data.claimed_orders);
  if (!data.baseline_path.empty()) {
    json.member("baseline_path", data.baseline_path);
    append_baseline(json.key("baseline"), data.baseline);
  }
  append_laws(json.key("laws"), data.laws);
  append_scenarios(json.key("scenarios"), data.scenarios);
  append_engines(json.key("engines"), data.engines);
  append_ran(json.key("ran"), ran_methods(data.engines, data.rows));
  append_missing(json.key("missing_engines"), data.missing_engines);
  append_metrics(json.key("metrics"), data.metrics);
  append_bench(json.key("bench"), data.bench);
  append_dominance(json.key("dominance"), data.dominance, static_cast<std::size_t>(-1));
  if (!data.rates.empty()) {
    json.member("rates", data.same_rate ? "same" : "native").member("rates_words", data.rates);
    append_overheads(json.key("overheads"), data.overheads);
  }
  append_goals(json.key("goals"), data.goals);
  if (!data.tables.empty()) append_tables(json.key("tables"), data.tables);
  if (!data.audit.empty()) append_audit(json.key("audit"), data.audit);
  json.key("notes").begin_array();
  for (const std::string& note : data.notes) json.text(note);
  json.end_array();
  json.key("rows").begin_array();
  for (const Row& row : data.rows) append_row(json, row);
  json.end_array().key("series").begin_array();
  for (const StoredSeries& stored : data.series) append_series(json, stored);
  json.end_array().end_object();
  return json.str();
}

}  // namespace atwood
