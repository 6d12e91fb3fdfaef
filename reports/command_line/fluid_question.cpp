#include "reports/command_line/fluid_question.hpp"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "scene/files.hpp"

namespace atwood {
namespace {

using Names = std::vector<std::string>;

bool is_among(const Names& names, const std::string& metric) {
  return std::find(names.begin(), names.end(), metric) != names.end();
}

// Figures that are small for a good method and need the exact field.
bool needs_field(const std::string& metric) {
  static const Names others{"space-error", "time-error",          "kinetic-energy-error",
                            "front-error", "front-delayed-error", "front-speed-error"};
  for (const char* quantity : {"velocity-l", "pressure-l", "density-l", "temperature-l", "velocity-grid-l",
                               "pressure-grid-l", "density-grid-l", "temperature-grid-l"})
    if (metric.starts_with(quantity)) return true;
  return is_among(others, metric);
}

// ... and that need none.
const Names& conserved() {
  static const Names names{"energy-budget", "fluid-momentum-error", "fluid-angular-momentum-error", "volume-error",
                           "speed-max"};
  return names;
}

// A metric that only fluids have.
bool of_fluids_alone(const std::string& metric) {
  static const Names others{"work-by-diffusion",  "work-by-shift", "work-by-viscosity",
                            "work-by-bodies",     "work-by-walls", "work-by-sources",
                            "energy-unaccounted", "model-error",   "particle-order",
                            "spacing-min",        "probe-error",   "closing-residual",
                            "order-space",        "order-model",   "order-time",
                            "neighbours",         "front-delay",   "ns-per-particle-evaluation"};
  return needs_field(metric) || is_among(conserved(), metric) || is_among(others, metric);
}

constexpr const char* kInstead =
    "expected velocity-l1, pressure-l1, temperature-l1 (or -l2, -linf), space-error, time-error, energy-budget, "
    "fluid-momentum-error, fluid-angular-momentum-error, volume-error or front-error";

// The fluid's metric that a word for bodies stands for.
std::string of_fluid(const std::string& metric) {
  if (metric == "error-velocity-max" || metric == "error-state-end") return "velocity-l1";
  return metric == "energy-max" ? "energy-budget" : metric;
}

void require_ranking(const std::string& who, const std::string& metric) {
  if (metric.empty() || needs_field(metric) || is_among(conserved(), metric)) return;
  const std::string refused = fmt::format("{}: --metric {}", who, metric);
  if (metric == "model-error")
    throw InputError(refused +
                     ": the Mach number's share is the scene's, the same for every method; expected "
                     "space-error or velocity-l1, at several --sound-speed");
  if (metric.starts_with("order-") || metric.starts_with("growth-"))
    throw InputError(refused + ": an order is of a whole ladder, and `atwood run` measures it; " + kInstead);
  throw InputError(refused + ": methods of fluids are not ranked by it; " + kInstead);
}

void require_field(const std::string& who, const std::string& metric, const Scenario& scenario) {
  if (scenario.truth.kind != TruthKind::none) return;
  if (!metric.empty() && !needs_field(metric)) return;
  throw InputError(fmt::format(
      "{}: `{}` names no truth: there is no exact field, and no error of {}. Without a truth methods can be ranked by "
      "what they should keep: --metric energy-budget, fluid-momentum-error, fluid-angular-momentum-error or "
      "volume-error",
      who, scenario.id, metric.empty() ? "the velocity" : metric));
}

}  // namespace

Question fluid_question(const std::string& who, const Options& options, const Question& asked,
                        const std::vector<const Scenario*>& scenarios) {
  Question question = asked;
  const auto has_fluid = [](const Scenario* scenario) { return !scenario->scene.fluids.empty(); };
  const auto fluids = std::count_if(scenarios.begin(), scenarios.end(), has_fluid);
  if (fluids == 0) {
    if (of_fluids_alone(asked.metric) && !asked.metric.starts_with("order-"))
      throw InputError(fmt::format("{}: --metric {}: no scene here has a fluid", who, asked.metric));
    return question;
  }
  if (fluids < std::ssize(scenarios)) {
    if (asked.metric.empty() && asked.error == 0) return question;
    const Scenario* other = *std::find_if_not(scenarios.begin(), scenarios.end(), has_fluid);
    throw InputError(fmt::format(
        "{}: `{}` has no fluid but other scenes do; expected scenes all with fluids, or all without, for {}", who,
        other->id, asked.metric.empty() ? "--error" : "--metric"));
  }
  // Of --error with a unit the metric is that of bodies; of per cent it is a ratio, as the fluids' errors are.
  const bool by_unit = options.metric.empty() && !asked.metric.empty();
  if (by_unit && asked.metric != "energy-max")
    throw InputError(
        fmt::format("{}: --error {}: errors of fluids are ratios to the exact field's norm; expected a "
                    "number without a unit, or per cent, as in 1e-2 or 1%",
                    who, options.wanted_error));
  question.metric = by_unit ? "" : of_fluid(asked.metric);
  require_ranking(who, question.metric);
  for (const Scenario* scenario : scenarios) require_field(who, question.metric, *scenario);
  return question;
}

}  // namespace atwood
