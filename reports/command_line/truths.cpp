// Scenes whose truth is unsupported, with the kinds of truth that cover them; claimed and observed orders of methods.
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include <fmt/format.h>

#include "reports/command_line/advise.hpp"
#include "reports/command_line/verdicts.hpp"

namespace atwood {
namespace {

std::string kind_words(const TruthSpec& truth) {
  switch (truth.kind) {
    case TruthKind::closed_form: return "closed form `" + truth.solution + "`";
    case TruthKind::extended: return "`extended`";
    case TruthKind::cvode: return "`cvode`";
    case TruthKind::values: return "`values`";
    case TruthKind::none: return "`none`";
    case TruthKind::weakly_compressible: return "`weakly-compressible`";
    case TruthKind::semi_discrete: return "`semi-discrete`";
    case TruthKind::literature: return "literature `" + truth.solution + "`";
  }
  return "";
}

// Of a fluid's field against an exact one, or of the steps against the particles' own equations.
bool is_error_of_a_fluid(const std::string& metric) {
  return metric == "time-error" || metric == "velocity-l1" || metric == "pressure-l1" || metric == "density-l1" ||
         metric == "temperature-l1";
}

// The class of motion whose claimed order this metric shows on this scene; empty: none is claimed there.
std::string claimed_class(const std::string& metric, const MotionClass& motion) {
  if (motion.mechanism) {
    if (metric != "order-position" && metric != "order-joint-coordinate") return "";
    return motion.loop ? "loop" : "mechanism";
  }
  if (metric == "order-attitude" || metric == "order-body-rate") return motion.rotates ? "rotation" : "";
  if (metric != "order-position" && metric != "order-velocity") return "";
  if (motion.contacts) return "contact";
  return motion.velocity_dependent ? "velocity-dependent" : "point-mass";
}

}  // namespace

std::string other_truths(const Place& place, const Scenario& scenario, double limit_s) {
  std::vector<TruthSpec> others(3);
  others[0].kind = TruthKind::closed_form;
  others[0].solution = "rest";
  others[1].kind = TruthKind::extended;
  others[2].kind = TruthKind::cvode;
  const bool mechanism = !scenario.scene.joints.empty() || !scenario.scene.ropes.empty();
  if (mechanism) others.erase(others.begin());  // of bodies at rest
  std::string covers, reasons;
  for (const TruthSpec& other : others) {
    if (other.kind == scenario.truth.kind && other.solution == scenario.truth.solution) continue;
    Scenario tried = scenario;
    tried.truth = other;
    std::string reason;
    try {
      const Outcome outcome = truth_once(place.truth_worker, tried, 1, limit_s).outcome;
      if (outcome.status != Status::ok) reason = outcome.reason.empty() ? "no answer" : outcome.reason;
    } catch (const std::exception& error) {
      reason = error.what();
    }
    if (!reason.empty()) {
      reasons += fmt::format("{}{} answers \"{}\"", reasons.empty() ? "" : ", and ", kind_words(other), reason);
      continue;
    }
    covers += (covers.empty() ? "" : ", or ") +
              (other.kind == TruthKind::closed_form
                   ? std::string("`kind = \"closed-form\"`, `solution = \"rest\"`")
                   : fmt::format("`kind = \"{}\"`", other.kind == TruthKind::cvode ? "cvode" : "extended"));
  }
  const std::string none =
      "`kind = \"none\"` says that there is none: energy, momentum and contacts are still measured";
  if (covers.empty() && mechanism && !reasons.empty())
    return fmt::format("No other truth of mechanisms covers this scene within {:g} s: {}. {}.", limit_s, reasons, none);
  return covers.empty()
             ? fmt::format("Neither `rest`, `extended` nor `cvode` covers this scene within {:g} s; {}.", limit_s, none)
             : fmt::format("What covers it: {}; {}.", covers, none);
}

std::vector<RefusedTruth> refused_truths(const Place& place, const std::vector<Scenario>& scenarios,
                                         const std::vector<Row>& rows, bool try_truths) {
  std::vector<RefusedTruth> refused;
  for (const Row& row : rows) {
    if (row.metric != "truth" || row.status == Status::ok) continue;
    if (std::any_of(refused.begin(), refused.end(), [&](const auto& one) { return one.scenario == row.scenario; }))
      continue;
    RefusedTruth one{row.scenario, "", row.status, row.reason, ""};
    std::set<std::string> without;
    for (const Row& other : rows)
      if (other.scenario == row.scenario && other.metric == "truth" && other.status != Status::ok)
        without.insert(other.method);
    for (const Row& other : rows) {
      if (other.scenario != row.scenario || other.status != Status::ok || !is_error_of_a_fluid(other.metric)) continue;
      if (!without.contains(other.method)) one.method = row.method;
      one.has_errors = one.has_errors || other.method == row.method;
    }
    const auto found =
        std::find_if(scenarios.begin(), scenarios.end(), [&](const auto& s) { return s.id == row.scenario; });
    if (found != scenarios.end()) {
      one.truth = kind_words(found->truth);
      if (row.status == Status::unsupported && one.method.empty() && !one.has_errors)
        one.remedy = try_truths && refused.size() < 3
                         ? other_truths(place, *found, 5)
                         : "`atwood trace SCENE --method truth` shows which truths cover it.";
    }
    refused.push_back(one);
  }
  return refused;
}

std::vector<ClaimedOrder> claimed_orders(const Selection& selection, const std::vector<Row>& rows) {
  std::map<std::string, MotionClass> motions;
  for (const Scenario& scenario : selection.scenarios) motions[scenario.id] = classify(scenario.scene);
  struct Found {
    const MethodInfo* info;
    bool foreign;
  };
  std::map<std::string, Found> methods;
  for (const Worker& worker : selection.workers)
    for (const MethodInfo& info : worker.engine.methods)
      if (worker.status == Status::ok) methods.try_emplace(info.id, Found{&info, worker.foreign});
  std::vector<ClaimedOrder> orders;
  for (const Row& row : rows) {
    if (row.steps != 0 || !row.body.empty() || row.status != Status::ok || !row.metric.starts_with("order-")) continue;
    const auto motion = motions.find(row.scenario);
    const auto method = methods.find(row.method.substr(0, row.method.find_first_of(":+@{")));
    if (motion == motions.end() || method == methods.end() || motion->second.bare) continue;
    const auto& claims = method->second.info->claimed_order;
    const auto claim = claims.find(claimed_class(row.metric, motion->second));
    if (claim == claims.end()) continue;
    orders.push_back(
        {row.scenario, row.method, row.metric, claim->second, row.value, row.truth_bar, method->second.foreign});
  }
  return orders;
}

}  // namespace atwood
