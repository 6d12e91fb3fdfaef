#include "reports/command_line/same_rate.hpp"

#include <algorithm>
#include <map>
#include <set>

#include <fmt/format.h>

#include "reports/render/text.hpp"
#include "scene/files.hpp"
#include "validation/metrics/work_precision.hpp"

namespace atwood {
namespace {

bool offers(const std::vector<Worker>& workers, const std::string& engine, const std::string& base) {
  return std::any_of(workers.begin(), workers.end(), [&](const Worker& worker) {
    return worker.status == Status::ok && worker.engine.name == engine &&
           std::any_of(worker.engine.methods.begin(), worker.engine.methods.end(),
                       [&](const MethodInfo& info) { return info.id == base; });
  });
}

std::string joined(const std::set<std::string>& words) { return fmt::format("{}", fmt::join(words, ", ")); }

}  // namespace

std::string same_rate_twin(const std::string& method, const std::vector<Worker>& workers) {
  if (engine_of(method) != "atwood" || method.find('+') != std::string::npos) return "";
  const std::string twin = kSameRateEngine + method.substr(method.find('/'));
  if (!offers(workers, kSameRateEngine, base_of(twin))) return "";
  const std::size_t scalar = method.find('@');
  if (scalar == std::string::npos) return twin;
  const std::string name = method.substr(scalar + 1, method.find('{', scalar) - scalar - 1);
  return name == "double" || name == "long-double" ? twin : "";
}

std::string native_twin(const std::string& method) {
  return engine_of(method) == kSameRateEngine ? "atwood" + method.substr(method.find('/')) : method;
}

std::vector<Worker> without_same_rate(std::vector<Worker> workers) {
  std::erase_if(workers,
                [](const Worker& worker) { return worker.path.ends_with(std::string("/") + kSameRateEngine); });
  return workers;
}

RankedRates choose_rates(const Options& options, const std::vector<std::string>& methods,
                         const std::vector<Worker>& workers) {
  RankedRates rates;
  std::set<std::string> libraries, ours, others;
  for (const std::string& method : methods) {
    const std::string twin = same_rate_twin(method, workers);
    if (is_library(engine_of(method))) libraries.insert(engine_of(method));
    else if (!twin.empty()) rates.twins.push_back(twin), ours.insert(base_of(method));
    else others.insert(base_of(method));
  }
  if (options.same_rate && rates.twins.empty()) {
    const bool built = std::any_of(workers.begin(), workers.end(), [](const Worker& worker) {
      return worker.status == Status::ok && worker.engine.name == kSameRateEngine;
    });
    throw InputError(built ? fmt::format("--same-rate: found no method of ours that runs on a given rate among {}; "
                                         "expected one, as atwood/rk4 or atwood/dop853",
                                         fmt::join(methods, ", "))
                           : fmt::format("--same-rate: its worker `{}` is not built", kSameRateEngine));
  }
  const bool beside = !libraries.empty() && !ours.empty();
  rates.same = options.same_rate || (beside && others.empty() && !options.native_rate && !options.no_timing);
  if (rates.same) {
    rates.words = fmt::format(
        "The same rate: ours ({}) and {} call the reference's right-hand side, and are ranked so; native times stand "
        "beside, unranked.",
        kSameRateEngine, libraries.empty() ? "libraries" : joined(libraries));
    return rates;
  }
  rates.twins.clear();
  if (!libraries.empty() && (beside || !others.empty()))
    rates.words = fmt::format(
        "Native rates: {} call the reference's right-hand side, the others one of their own; ratios of times compare "
        "these as well as the methods{}.",
        joined(libraries), ours.empty() ? "" : " (--same-rate ranks by one for all)");
  return rates;
}

std::vector<Row> ranked_rows(const std::vector<Row>& rows, std::vector<std::string>& notes) {
  std::set<std::pair<std::string, std::string>> ran;  // scenario, native id of a twin with a good run
  for (const Row& row : rows) {
    if (row.steps > 0 && row.status == Status::ok && engine_of(row.method) == kSameRateEngine)
      ran.emplace(row.scenario, native_twin(row.method));
  }
  std::vector<Row> ranked;
  std::set<std::string> out;
  std::map<std::string, std::set<std::string>> kept;
  for (const Row& row : rows) {
    if (row.method.empty() || runs_at_reference_rate(row.method)) {
      ranked.push_back(row);
      continue;
    }
    const bool replaced = ran.contains({row.scenario, row.method}) ||
                          (row.steps == 0 && std::any_of(ran.begin(), ran.end(), [&](const auto& one) {
                             return one.first == row.scenario && method_family(one.second) == row.method;
                           }));
    const bool ours = engine_of(row.method) == "atwood" && row.method.find('+') == std::string::npos;
    const bool scene_has_twins =
        std::any_of(ran.begin(), ran.end(), [&](const auto& one) { return one.first == row.scenario; });
    if (replaced) continue;
    if (ours && !scene_has_twins) {
      kept[row.scenario].insert(base_of(row.method));
      ranked.push_back(row);
    } else {
      out.insert(base_of(row.method));
    }
  }
  for (const auto& [scenario, methods] : kept)
    notes.push_back(fmt::format(
        "{}: methods of ours cannot evaluate the reference's right-hand side there; {} ranked at native rates.",
        scenario, joined(methods)));
  if (!out.empty())
    notes.push_back(fmt::format("not ranked, because they evaluate a right-hand side of their own: {}.", joined(out)));
  return ranked;
}

std::string overhead_text(const std::vector<MethodOverhead>& overheads, const std::string& scenario) {
  std::string text;
  for (const MethodOverhead& one : overheads) {
    if (one.scenario != scenario) continue;
    if (text.empty())
      text =
          "\n  beside the rate, an evaluation costs (rates made 1, 2, 4, 8 times over,\n"
          "  extrapolated to none; [ ] 95 %, medians of turns)\n";
    const auto estimate = [](const Estimate& e) {
      return fmt::format("{:.3g} ns [{:.3g}, {:.3g}]", e.value, e.low, e.high);
    };
    text += fmt::format("    {}, {}:\n      ", one.family.substr(0, 50), rung_words(one.method, one.steps));
    if (!one.fit.possible) {
      text += "not measured: longer runs were slowed down more (measure on an idle machine)\n";
      continue;
    }
    text += fmt::format("{}; the rate {}{}{}\n", estimate(one.fit.overhead_ns), estimate(one.fit.rate_ns),
                        one.fit.straight ? "" : "\n      (the times lie on no line: no constant overhead)",
                        one.busy ? "\n      (the machine was busy)" : "");
  }
  return text;
}

}  // namespace atwood
