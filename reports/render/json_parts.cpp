#include "json_parts.hpp"

#include "text.hpp"

namespace atwood {
namespace {

std::string kind_word(Gate::Kind kind) {
  switch (kind) {
    case Gate::Kind::within: return "within";
    case Gate::Kind::max: return "max";
    case Gate::Kind::min: return "min";
    case Gate::Kind::max_ratio: return "max_ratio";
    case Gate::Kind::within_claim: return "within_claim";
  }
  return "";
}

void append_method(JsonText& json, const MethodInfo& method) {
  json.begin_object().member("id", method.id).member("doc", method.doc).member("source", method.source);
  json.key("claimed_order").begin_object().inline_from_here();
  for (const auto& [motion, order] : method.claimed_order) json.member_number(motion, order);
  json.end_object().key("adaptive").boolean(method.adaptive).key("settings").begin_object();
  for (const auto& [name, value] : method.settings) json.key(name).setting(value);
  json.end_object().end_object();
}

}  // namespace

std::string truth_words(const TruthSpec& truth) {
  switch (truth.kind) {
    case TruthKind::closed_form: return "closed form: " + truth.solution;
    case TruthKind::extended: return "extended precision, two methods";
    case TruthKind::cvode: return "CVODE, two methods and two tolerances";
    case TruthKind::values: return "reference values";
    case TruthKind::none: return "none";
  }
  return "";
}

void append_provenance(JsonText& json, const Provenance& provenance) {
  json.begin_object()
      .member("engine_version", provenance.engine_version)
      .member("commit", provenance.commit)
      .member("compiler", provenance.compiler)
      .member("flags", provenance.flags)
      .member("cpu", provenance.cpu)
      .member("run_id", provenance.run_id)
      .end_object();
}

void append_scenarios(JsonText& json, const std::vector<Scenario>& scenarios) {
  json.begin_array();
  for (const Scenario& scenario : scenarios) {
    json.begin_object()
        .member("id", scenario.id)
        .member("title", scenario.title)
        .member("claim", scenario.claim)
        .member("source", scenario.source)
        .member("truth", truth_words(scenario.truth))
        .member_number("t_end_s", scenario.t_end_s)
        .member_integer("samples", scenario.samples);
    json.key("steps").begin_array().inline_from_here();
    for (const std::int64_t steps : scenario.steps) json.integer(steps);
    json.end_array().key("tags").begin_array().inline_from_here();
    for (const std::string& tag : scenario.tags) json.text(tag);
    json.end_array().key("invariants").begin_array().inline_from_here();
    for (const Invariant& invariant : scenario.invariants) json.text(invariant.quantity);
    json.end_array().end_object();
  }
  json.end_array();
}

void append_engines(JsonText& json, const std::vector<Engine>& engines) {
  json.begin_array();
  for (const Engine& engine : engines) {
    json.begin_object().member("name", engine.name).member("version", engine.version).member("scalar", engine.scalar);
    json.key("methods").begin_array();
    for (const MethodInfo& method : engine.methods) append_method(json, method);
    json.end_array().end_object();
  }
  json.end_array();
}

void append_missing(JsonText& json, const std::vector<std::pair<std::string, std::string>>& missing) {
  json.begin_array();
  for (const auto& [name, reason] : missing) {
    json.begin_object().inline_from_here().member("name", name).member("reason", reason).end_object();
  }
  json.end_array();
}

void append_metrics(JsonText& json, const std::vector<MetricInfo>& metrics) {
  json.begin_array();
  for (const MetricInfo& metric : metrics) {
    json.begin_object().inline_from_here();
    json.member("name", metric.name).member("unit", metric.unit).member("definition", metric.definition).end_object();
  }
  json.end_array();
}

void append_verdicts(JsonText& json, const std::vector<Verdict>& verdicts) {
  json.begin_array();
  for (const Verdict& verdict : verdicts) {
    json.begin_object()
        .member("judgement", to_string(verdict.judgement))
        .member("scenario", verdict.scenario)
        .member("method", verdict.method)
        .member_integer("steps", verdict.steps)
        .member("metric", verdict.metric)
        .member("unit", verdict.unit)
        .member_number("value", verdict.value)
        .member_number("bar", verdict.bar)
        .member("kind", kind_word(verdict.gate.kind))
        .member("allowed", allowed_words(verdict))
        .member_number("allowed_low", verdict.allowed_low)
        .member_number("allowed_high", verdict.allowed_high)
        .member_number("margin", verdict.margin)
        .member("text", verdict.text)
        .member("reason", verdict.gate.reason)
        .member("origin", origin_words(verdict.gate.origin))
        .member("rerun", verdict.rerun)
        .end_object();
  }
  json.end_array();
}

void append_laws(JsonText& json, const std::vector<Law>& laws) {
  json.begin_array();
  for (const Law& law : laws) {
    json.begin_object()
        .member("scenario", law.scenario)
        .member("method", law.method)
        .member_integer("steps", law.steps)
        .member("metric", law.metric)
        .member("statement", law.statement)
        .member_number("predicted", law.predicted)
        .member_number("measured", law.measured)
        .member("unit", law.unit)
        .end_object();
  }
  json.end_array();
}

void append_bench(JsonText& json, const std::vector<BenchFigure>& bench) {
  json.begin_array();
  for (const BenchFigure& figure : bench) {
    json.begin_object()
        .member("name", figure.name)
        .member("scenario", figure.scenario)
        .member("method", figure.method)
        .member_integer("steps", figure.steps)
        .member_number("ns_per_step_median", figure.ns_per_step_median)
        .member_number("ns_per_step_p95", figure.ns_per_step_p95)
        .end_object();
  }
  json.end_array();
}

}  // namespace atwood
