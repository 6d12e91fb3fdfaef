#include "reports/command_line/same_rate.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include <fmt/format.h>

#include "reports/render/text.hpp"
#include "scene/files.hpp"

namespace atwood {
namespace {

constexpr const char* kTwins = "atwood-same-rate";
constexpr std::array kRepeats{1, 2, 4, 8};
constexpr int kRounds = 15;
constexpr double kBestRun_s = 1e-3;  // long enough for the clock, short enough for many turns
constexpr std::size_t kMostFamilies = 8;

std::string base_of(const std::string& method) { return method.substr(0, method.find_first_of(":+@{")); }

bool offers(const std::vector<Worker>& workers, const std::string& engine, const std::string& base) {
  return std::any_of(workers.begin(), workers.end(), [&](const Worker& worker) {
    return worker.status == Status::ok && worker.engine.name == engine &&
           std::any_of(worker.engine.methods.begin(), worker.engine.methods.end(),
                       [&](const MethodInfo& info) { return info.id == base; });
  });
}

bool runs_at_reference_rate(const std::string& method) {
  const std::string engine = engine_of(method);
  return engine == kTwins || is_library(engine);
}

std::string joined(const std::set<std::string>& words) { return fmt::format("{}", fmt::join(words, ", ")); }

}  // namespace

bool is_library(const std::string& engine) {
  return engine == "odeint" || engine == "arkode" || engine == "cvode" || engine == "ida";
}

std::string same_rate_twin(const std::string& method, const std::vector<Worker>& workers) {
  if (engine_of(method) != "atwood" || method.find('+') != std::string::npos) return "";
  const std::string twin = kTwins + method.substr(method.find('/'));
  if (!offers(workers, kTwins, base_of(twin))) return "";
  const std::size_t scalar = method.find('@');
  if (scalar == std::string::npos) return twin;
  const std::string name = method.substr(scalar + 1, method.find('{', scalar) - scalar - 1);
  return name == "double" || name == "long-double" ? twin : "";
}

std::string native_twin(const std::string& method) {
  return engine_of(method) == kTwins ? "atwood" + method.substr(method.find('/')) : method;
}

std::vector<Worker> without_same_rate(std::vector<Worker> workers) {
  std::erase_if(workers, [](const Worker& worker) {
    return worker.path.size() >= 16 && worker.path.ends_with(std::string("/") + kTwins);
  });
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
      return worker.status == Status::ok && worker.engine.name == kTwins;
    });
    throw InputError(built ? fmt::format("--same-rate: found no method of ours that runs on a given rate among {}; "
                                         "expected one, as atwood/rk4 or atwood/dop853",
                                         fmt::join(methods, ", "))
                           : fmt::format("--same-rate: its worker `{}` is not built", kTwins));
  }
  const bool beside = !libraries.empty() && !ours.empty();
  rates.same = options.same_rate || (beside && others.empty() && !options.native_rate && !options.no_timing);
  if (rates.same) {
    rates.words = fmt::format(
        "The same rate: ours ({}) and {} call the reference's right-hand side, and are ranked so; native times stand "
        "beside, unranked.",
        kTwins, libraries.empty() ? "libraries" : joined(libraries));
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
    if (row.steps > 0 && row.status == Status::ok && engine_of(row.method) == kTwins)
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
    notes.push_back(fmt::format("{}: the reference's rate cannot be given there; {} ranked at native rates.", scenario,
                                joined(methods)));
  if (!out.empty()) notes.push_back(fmt::format("not ranked, for their rates are their own: {}.", joined(out)));
  return ranked;
}

std::vector<MethodOverhead> measure_overheads(const std::vector<Cell>& cells, const std::vector<Worker>& workers,
                                              const std::vector<Row>& rows, double limit_s) {
  struct Chosen {
    const Cell* cell = nullptr;
    double seconds = 0, evaluations = 0;
  };
  std::map<std::pair<std::string, std::string>, Chosen> best;  // scenario, family
  std::vector<std::pair<std::string, std::string>> order;
  for (const Cell& cell : cells) {
    if (cell.worker < 0 || !runs_at_reference_rate(cell.method) || engine_of(cell.method) == "ida") continue;
    double seconds = 0, evaluations = 0;
    for (const Row& row : rows) {
      if (row.scenario != cell.scenario.id || row.method != cell.method || row.steps != cell.plan.steps) continue;
      if (row.metric == "run-time") seconds = row.value;
      if (row.metric == "rate-evaluations") evaluations = row.value;
    }
    if (!(seconds > 0) || !(evaluations > 0)) continue;
    const std::pair key{cell.scenario.id, method_family(cell.method)};
    Chosen& chosen = best[key];
    if (chosen.cell == nullptr) order.push_back(key);
    const auto distance = [](double s) { return std::fabs(std::log(s / kBestRun_s)); };
    if (chosen.cell == nullptr || distance(seconds) < distance(chosen.seconds)) chosen = {&cell, seconds, evaluations};
  }
  if (order.size() > kMostFamilies) order.resize(kMostFamilies);
  std::vector<MethodOverhead> overheads;
  std::vector<Contender> contenders;
  for (const auto& key : order) {
    const Chosen& chosen = best.at(key);
    overheads.push_back({key.first, key.second, chosen.cell->method, chosen.cell->plan.steps, chosen.evaluations, {}});
    for (const int repeats : kRepeats) {
      MethodId id = parse_method_id(chosen.cell->method);
      id.overrides["rate_repeats"] = std::int64_t(repeats);
      contenders.push_back({&workers[static_cast<std::size_t>(chosen.cell->worker)], to_string(id),
                            &chosen.cell->scenario.scene, chosen.cell->plan, chosen.seconds * repeats,
                            chosen.evaluations});
    }
  }
  Stopwatch stopwatch(limit_s);
  const auto rounds = stopwatch.in_turns(contenders, kRounds);
  for (std::size_t i = 0; i < overheads.size(); ++i) {
    std::vector<std::vector<double>> ns;
    for (const auto& round : rounds) {
      const auto from = round.begin() + static_cast<std::ptrdiff_t>(i * kRepeats.size());
      ns.emplace_back(from, from + kRepeats.size());
      for (double& t : ns.back()) t *= 1e9 / overheads[i].evaluations;
    }
    overheads[i].fit = fit_overhead(kRepeats, ns);
  }
  std::erase_if(overheads, [](const MethodOverhead& one) { return one.fit.rounds == 0; });
  return overheads;
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
    text += fmt::format("    {}, {}:\n      {}; the rate {}{}\n", one.family.substr(0, 50),
                        rung_words(one.method, one.steps), estimate(one.fit.overhead_ns), estimate(one.fit.rate_ns),
                        one.fit.straight ? "" : "\n      (the times lie on no line: no constant overhead)");
  }
  return text;
}

}  // namespace atwood
