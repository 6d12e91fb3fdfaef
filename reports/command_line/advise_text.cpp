// Advice as text and as JSON.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>

#include "reports/command_line/advise.hpp"
#include "reports/command_line/manual.hpp"
#include "reports/render/text.hpp"

namespace atwood {
namespace {

using json = nlohmann::ordered_json;

std::string with_unit(double value, const std::string& unit) {
  return fmt::format("{:.3g}{}", value, unit.empty() ? "" : " " + unit);
}

std::string step_words(const AdviceRung& rung, double t_end_s) {
  if (method_family(rung.method) != rung.method) return rung_words(rung.method, rung.steps, rung.at);
  if (rung.at.first) return rung_words(rung.method, rung.steps, rung.at);
  return fmt::format("{} steps (h = {:.4g} s)", rung.steps, t_end_s / static_cast<double>(rung.steps));
}

std::string evidence(const char* name, const AdviceRung& rung, const Advice& advice) {
  return fmt::format("    {:<10} {:<28} {:>14} {:>9}{}\n", name, step_words(rung, advice.scenario.t_end_s),
                     format_measure(rung.error, rung.bar, 3), time_words(rung.seconds),
                     std::isfinite(rung.evaluations) ? fmt::format(" {:>9.0f}", rung.evaluations) : "");
}

std::string asked_words(const Advice& advice) {
  if (advice.wanted_error > 0)
    return fmt::format("an error of at most {} ({})", with_unit(advice.wanted_error, advice.unit),
                       norm_words(advice.metric));
  return fmt::format("the least error ({}) within {} for the whole run", norm_words(advice.metric),
                     time_words(advice.budget_s));
}

// Of each engine the first few ids of a list; JSON has all.
std::string shortened(const std::string& methods) {
  constexpr int max_shown = 6;
  std::vector<std::pair<std::string, int>> engines;  // and how many ids of it there were
  std::string text;
  for (std::size_t at = 0; at < methods.size();) {
    const std::size_t end = std::min(methods.find(", ", at), methods.size());
    const std::string id = methods.substr(at, end - at), engine = engine_of(id);
    at = end + 2;
    auto known = std::find_if(engines.begin(), engines.end(), [&](const auto& one) { return one.first == engine; });
    if (known == engines.end()) known = engines.insert(engines.end(), {engine, 0});
    if (++known->second <= max_shown) text += (text.empty() ? "" : ", ") + id;
  }
  for (const auto& [engine, count] : engines)
    if (count > max_shown) text += fmt::format(", and {} more of {}", count - max_shown, engine);
  return text;
}

json to_json(const AdviceRung& rung, const Advice& advice) {
  if (rung.method.empty()) return nullptr;
  json out{{"method", rung.method}, {"steps", rung.steps},     {"error", rung.error},
           {"bar", rung.bar},       {"seconds", rung.seconds}, {"evaluations", rung.evaluations}};
  if (method_family(rung.method) == rung.method) out["h_s"] = advice.scenario.t_end_s / static_cast<double>(rung.steps);
  else out["rtol"] = *parse_method_id(rung.method).rtol;
  if (rung.at.first) out["spacing_m"] = *rung.at.first;
  if (rung.at.second) out["sound_speed_m_per_s"] = *rung.at.second;
  return out;
}

}  // namespace

std::string advice_text(const Advice& advice) {
  std::string text = fmt::format("{}: {}, {:.4g} s\n  asked      {}\n", advice.scenario.id, class_words(advice.motion),
                                 advice.scenario.t_end_s, asked_words(advice));
  if (advice.found) {
    const AdviceRung& best = advice.best;
    text += fmt::format("  use        {}, {}: {} in {}\n\n", best.method, step_words(best, advice.scenario.t_end_s),
                        format_measure(best.error, best.bar, 3), time_words(best.seconds));
    text += fmt::format("    {:<10} {:<28} {:>14} {:>9} {:>9}\n", "evidence", "",
                        "error" + (advice.unit.empty() ? "" : " [" + advice.unit + "]"), "time", "evals");
    const bool tolerance = method_family(best.method) != best.method;
    if (advice.coarser) text += evidence(tolerance ? "looser" : "coarser", *advice.coarser, advice);
    else if (!tolerance) text += fmt::format("    coarser    {}\n", advice.no_coarser);
    text += evidence("advised", best, advice);
    if (advice.finer) text += evidence(tolerance ? "tighter" : "finer", *advice.finer, advice);
    const double known = best.bar > 0 && best.error < 3 * best.bar ? best.error + best.bar : best.error;
    const std::string margin =
        advice.wanted_error > 0
            ? fmt::format("the measured error is {:.3g} times under the asked one", advice.wanted_error / known)
            : fmt::format("the run takes {:.3g} of the budget", best.seconds / advice.budget_s);
    text += fmt::format("\n  margin     {}\n", margin);
    if (!advice.not_judged.empty()) text += fmt::format("  not judged {}\n", advice.not_judged);
    if (!advice.caution.empty()) text += fmt::format("  caution    {}\n", advice.caution);
    if (advice.next.method.empty()) {
      text += "  runner-up  none\n";
    } else {
      text += fmt::format("  runner-up  {}, {}: {} in {}", advice.next.method,
                          step_words(advice.next, advice.scenario.t_end_s),
                          format_measure(advice.next.error, advice.next.bar, 3), time_words(advice.next.seconds));
      const auto& ratio = advice.next_over_best;
      text += ratio ? fmt::format("; it takes {:.2f} [{:.2f}, {:.2f}] times as long\n", ratio->value, ratio->low,
                                  ratio->high)
                    : "\n";
    }
  } else {
    text += fmt::format("  use        nothing that was tried: {}\n",
                        advice.under_wasm         ? "no method with times that can be ranked, see below"
                        : advice.wanted_error > 0 ? "no rung has that error"
                                                  : "every run with an error smaller than the motion takes longer");
  }
  if (!advice.rates.empty()) text += fmt::format("  rates      {}\n", advice.rates);
  text += fmt::format("  truth      {}; the evidence's bar {:.2g}\n  runs       {}\n", advice.truth, advice.best.bar,
                      advice.runs);
  if (advice.found) text += fmt::format("  rerun      {}\n", shell_line(advice.rerun));
  text += "\n  left out\n";
  for (const auto& [reason, methods] : advice.left_out)
    text += wrapped(reason, 4, 80) + wrapped(shortened(methods), 6, 80);
  return text;
}

std::string advice_json(const Advice& advice) {
  json out{{"scenario", advice.scenario.id},
           {"motion", class_words(advice.motion)},
           {"t_end_s", advice.scenario.t_end_s},
           {"metric", advice.metric},
           {"unit", advice.unit}};
  if (advice.wanted_error > 0) out["wanted_error"] = advice.wanted_error;
  else out["budget_s"] = advice.budget_s;
  out["safety"] = 1;  // the asked error over the largest one that counts as reached
  out["found"] = advice.found;
  out["advice"] = to_json(advice.best, advice);
  out["coarser"] = advice.coarser ? to_json(*advice.coarser, advice) : json(nullptr);
  out["no_coarser"] = advice.no_coarser;
  out["finer"] = advice.finer ? to_json(*advice.finer, advice) : json(nullptr);
  out["runner_up"] = to_json(advice.next, advice);
  const auto& ratio = advice.next_over_best;
  out["runner_up_over_advice"] =
      ratio ? json{{"ratio", ratio->value}, {"low", ratio->low}, {"high", ratio->high}, {"pairs", ratio->pairs}}
            : json(nullptr);
  out["not_judged"] = advice.not_judged;
  out["caution"] = advice.caution;
  out["truth"] = advice.truth;
  out["rates"] = advice.rates;
  out["runs"] = advice.runs;
  out["left_out"] = json::array();
  for (const auto& [reason, methods] : advice.left_out)
    out["left_out"].push_back({{"reason", reason}, {"methods", methods}});
  if (advice.found) out["rerun"] = shell_line(advice.rerun);
  return out.dump(2) + "\n";
}

}  // namespace atwood
