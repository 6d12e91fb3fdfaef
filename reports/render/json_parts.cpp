#include "json_parts.hpp"

#include <cmath>

#include "scene/named_metric.hpp"
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

void append_settings(JsonText& json, const Settings& settings) {
  json.begin_object();
  for (const auto& [name, value] : settings) json.key(name).setting(value);
  json.end_object();
}

void append_method(JsonText& json, const MethodInfo& method) {
  json.begin_object().member("id", method.id).member("doc", method.doc).member("source", method.source);
  json.key("claimed_order").begin_object().inline_from_here();
  for (const auto& [motion, order] : method.claimed_order) json.member_number(motion, order);
  json.end_object().key("adaptive").boolean(method.adaptive);
  append_settings(json.key("settings"), method.settings);
  json.end_object();
}

void append_reached(JsonText& json, const Reached& reached) {
  json.begin_object().inline_from_here().member("family", reached.family).member("method", reached.method);
  json.member_integer("steps", reached.steps).key("error").number(reached.error, 6).key("cost").number(reached.cost, 6);
  if (reached.at_bar) json.key("at_bar").boolean(true);
  if (reached.coarsest) json.key("coarsest").boolean(true);
  if (reached.at.first) json.member_number("spacing_m", *reached.at.first);
  if (reached.at.second) json.member_number("sound_speed_m_per_s", *reached.at.second);
  json.end_object();
}

void append_contests(JsonText& json, const std::vector<Contest>& contests, std::size_t ranks) {
  json.begin_array();
  for (const Contest& contest : contests) {
    json.begin_object()
        .member_number("asked", contest.asked)
        .member_integer("contenders", static_cast<std::int64_t>(contest.ranked.size()));
    // The best of our engine and of the others stay, however far down.
    const Reached *ours = best_of(contest, "atwood"), *rival = best_rival(contest, "atwood");
    json.key("ranked").begin_array();
    for (std::size_t i = 0; i < contest.ranked.size(); ++i) {
      const Reached* reached = &contest.ranked[i];
      if (i < ranks || reached == ours || reached == rival) append_reached(json, *reached);
    }
    json.end_array();
    if (contest.to_next) {
      json.key("to_next").begin_object().inline_from_here().key("value").number(contest.to_next->value, 6);
      json.key("low").number(contest.to_next->low, 6).key("high").number(contest.to_next->high, 6);
      json.member_integer("pairs", contest.to_next->pairs).end_object();
    }
    json.end_object();
  }
  json.end_array();
}

void append_spacings(JsonText& json, const std::vector<EqualSpacing>& places) {
  json.begin_array();
  for (const EqualSpacing& place : places) {
    json.begin_object().member_number("spacing_m", place.at.first.value_or(0));
    json.member_number("sound_speed_m_per_s", place.at.second.value_or(0)).key("ranked").begin_array();
    for (const Reached& reached : place.ranked) append_reached(json, reached);
    json.end_array().end_object();
  }
  json.end_array();
}

void append_stable(JsonText& json, const std::vector<StableRange>& ranges) {
  json.begin_array();
  for (const StableRange& range : ranges) {
    json.begin_object().inline_from_here().member("family", range.family).key("stable").boolean(range.stable);
    if (range.stable) {
      json.member("method", range.first.method)
          .member_integer("steps", range.first.steps)
          .key("h_s")
          .number(range.first.h_s, 6);
      json.key("error").number(known_error(range.first), 6);
    }
    json.key("failed").begin_array();
    for (const FailedRung& rung : range.failed) {
      json.begin_object().member("method", rung.method).member_integer("steps", rung.steps);
      if (rung.at.first) json.member_number("spacing_m", *rung.at.first);
      if (rung.at.second) json.member_number("sound_speed_m_per_s", *rung.at.second);
      json.member("status", to_string(rung.status)).member("reason", rung.reason).end_object();
    }
    json.end_array().end_object();
  }
  json.end_array();
}

void append_entrant(JsonText& json, const GoalEntrant& entrant) {
  if (entrant.method.empty()) {
    json.null();
    return;
  }
  json.begin_object().inline_from_here().member("method", entrant.method).member_integer("steps", entrant.steps);
  json.key("error")
      .number(entrant.error, 6)
      .key("bar")
      .number(entrant.bar, 3)
      .key("seconds")
      .number(entrant.seconds, 6);
  json.member_number("evaluations", entrant.evaluations).key("ns_per_step").number(entrant.ns_per_step, 6);
  json.key("accurate").boolean(entrant.accurate);
  if (!std::isnan(entrant.last_quarter)) json.key("last_quarter").number(entrant.last_quarter, 6);
  if (std::isfinite(entrant.floor)) json.key("floor").number(entrant.floor, 3);
  json.end_object();
}

void append_machine(JsonText& json, const MachineState& machine) {
  json.begin_object().inline_from_here().member_integer("timings", machine.timings);
  json.member_integer("interrupted", machine.interrupted).member_integer("repeated", machine.repeated);
  json.key("ghz_low").number(machine.ghz_low, 4).key("ghz_high").number(machine.ghz_high, 4);
  json.member_integer("again", machine.again).key("busy").boolean(busy(machine)).end_object();
}

}  // namespace

void append_dominance(JsonText& json, const std::vector<Dominance>& tables, std::size_t ranks) {
  json.begin_array();
  for (const Dominance& table : tables) {
    json.begin_object().member("scenario", table.scenario).member("metric", table.metric).member("unit", table.unit);
    json.member("cost", table.cost == Cost::seconds ? "seconds" : "evaluations");
    append_contests(json.key("by_error"), table.by_error, ranks);
    append_contests(json.key("by_budget"), table.by_budget, ranks);
    append_stable(json.key("stable"), table.stable);
    if (!table.by_spacing.empty()) append_spacings(json.key("by_spacing"), table.by_spacing);
    json.end_object();
  }
  json.end_array();
}

void append_overheads(JsonText& json, const std::vector<MethodOverhead>& overheads) {
  const auto estimate = [&](const char* name, const Estimate& e) {
    json.key(name).begin_object().inline_from_here();
    json.key("value").number(e.value, 6).key("low").number(e.low, 6).key("high").number(e.high, 6).end_object();
  };
  json.begin_array();
  for (const MethodOverhead& one : overheads) {
    json.begin_object().member("scenario", one.scenario).member("family", one.family).member("method", one.method);
    json.member_integer("steps", one.steps).member_number("evaluations", one.evaluations);
    json.member_integer("rounds", one.fit.rounds).key("straight").boolean(one.fit.straight);
    json.key("possible").boolean(one.fit.possible).key("busy").boolean(one.busy);
    estimate("overhead_ns", one.fit.overhead_ns);
    estimate("rate_ns", one.fit.rate_ns);
    json.end_object();
  }
  json.end_array();
}

void append_goals(JsonText& json, const std::vector<GoalResult>& goals) {
  json.begin_array();
  for (const GoalResult& goal : goals) {
    json.begin_object().member("id", goal.id).member("title", goal.title).member("scenario", goal.scenario);
    json.member("metric", goal.metric).member("unit", goal.unit).member_number("wanted_error", goal.wanted_error);
    if (goal.wanted_ratio > 0) json.member_number("wanted_ratio", goal.wanted_ratio);
    if (std::isfinite(goal.low)) json.member_number("low", goal.low).member_number("high", goal.high);
    json.member("budget_kind", goal.budget_kind)
        .member_number("budget", goal.budget)
        .key("reached")
        .boolean(goal.reached);
    append_entrant(json.key("ours"), goal.ours);
    append_entrant(json.key("rival"), goal.rival);
    append_entrant(json.key("uncounted"), goal.uncounted);
    json.key("ratio")
        .number(goal.ratio, 6)
        .key("ratio_low")
        .number(goal.ratio_low, 6)
        .key("ratio_high")
        .number(goal.ratio_high, 6);
    if (!goal.library.method.empty()) {
      append_entrant(json.key("same_rate"), goal.same_rate);
      append_entrant(json.key("library"), goal.library);
      json.key("same_rate_ratio")
          .number(goal.same_rate_ratio, 6)
          .key("same_rate_low")
          .number(goal.same_rate_low, 6)
          .key("same_rate_high")
          .number(goal.same_rate_high, 6);
    }
    if (!goal.close.empty()) {
      json.key("close").begin_array();
      for (const GoalEntrant& entrant : goal.close) append_entrant(json, entrant);
      json.end_array();
    }
    if (!goal.left_out.empty()) {
      json.key("left_out").begin_array().inline_from_here();
      for (const std::string& method : goal.left_out) json.text(method);
      json.end_array();
    }
    if (goal.machine.timings > 0) append_machine(json.key("machine"), goal.machine);
    json.member("why", goal.why).end_object();
  }
  json.end_array();
}

std::string truth_words(const TruthSpec& truth) {
  switch (truth.kind) {
    case TruthKind::closed_form: return "closed form: " + truth.solution;
    case TruthKind::extended: return "extended precision, two methods";
    case TruthKind::cvode: return "CVODE, two methods and two tolerances";
    case TruthKind::values: return "reference values";
    case TruthKind::none: return "none";
    case TruthKind::weakly_compressible:
      return "weakly compressible equations" + (truth.solution.empty() ? "" : ": " + truth.solution);
    case TruthKind::semi_discrete: return "the particles' own equations";
    case TruthKind::literature: return "literature: " + truth.solution;
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
    if (const std::string metric = named_metric(scenario); !metric.empty()) json.member("metric", metric);
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
    json.end_array();
    if (!engine.responses.empty()) {
      json.key("responses").begin_array();
      for (const MethodInfo& response : engine.responses) append_method(json, response);
      json.end_array();
    }
    json.end_object();
  }
  json.end_array();
}

void append_ran(JsonText& json, const std::vector<RanMethod>& ran) {
  json.begin_array();
  for (const RanMethod& method : ran) {
    json.begin_object().member("id", method.id).member("engine", method.engine->name);
    append_settings(json.key("settings"), method.settings);
    if (method.response != nullptr) {
      json.member("response", method.response->id);
      append_settings(json.key("response_settings"), method.response_settings);
    }
    json.end_object();
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
        .member("rerun", shell_line(verdict.rerun))
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
        .member_number("ns_per_step_median", figure.ns_per_step.value)
        .member_number("ns_per_step_p95", figure.ns_per_step_p95)
        .end_object();
  }
  json.end_array();
}

void append_refused_truths(JsonText& json, const std::vector<RefusedTruth>& truths) {
  json.begin_array();
  for (const RefusedTruth& refused : truths) {
    json.begin_object().member("scenario", refused.scenario).member("truth", refused.truth);
    json.member("status", to_string(refused.status)).member("reason", refused.reason);
    json.member("remedy", refused.remedy).end_object();
  }
  json.end_array();
}

void append_claimed_orders(JsonText& json, const std::vector<ClaimedOrder>& orders) {
  json.begin_array();
  for (const ClaimedOrder& order : orders) {
    json.begin_object().inline_from_here().member("scenario", order.scenario).member("method", order.method);
    json.member("metric", order.metric)
        .member_number("claimed", order.claimed)
        .member_number("observed", order.observed);
    json.member_number("half_width_95", order.half_width_95).member("words", claim_words(order)).end_object();
  }
  json.end_array();
}

std::string kind_word(BaselineChange::Kind kind) {
  switch (kind) {
    case BaselineChange::Kind::regression: return "regression";
    case BaselineChange::Kind::improvement: return "improvement";
    case BaselineChange::Kind::unchanged: return "unchanged";
    case BaselineChange::Kind::missing: return "missing";
    case BaselineChange::Kind::added: return "added";
  }
  return "";
}

void append_baseline(JsonText& json, const std::vector<BaselineChange>& changes) {
  json.begin_array();
  for (const BaselineChange& change : changes) {
    if (change.kind == BaselineChange::Kind::unchanged) continue;
    json.begin_object().member("kind", kind_word(change.kind)).member("scenario", change.scenario);
    json.member("method", change.method).member("metric", change.metric).member_integer("steps", change.steps);
    json.member_number("before", change.before).member_number("now", change.now).member_number("bar", change.bar);
    json.member_number("allowed", change.allowed).member_number("ratio", change.ratio).member("unit", change.unit);
    json.member("text", change.text).member("rerun", shell_line(change.rerun)).end_object();
  }
  json.end_array();
}

std::string render_baseline_json(const std::vector<BaselineChange>& changes) {
  JsonText json(true);
  append_baseline(json, changes);
  return json.str();
}

}  // namespace atwood
