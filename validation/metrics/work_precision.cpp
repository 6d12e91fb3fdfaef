#include "validation/metrics/work_precision.hpp"
#include "validation/metrics/fluid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <tuple>

#include "protocol/method.hpp"
#include "validation/metrics/metrics.hpp"

namespace atwood {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

bool ends_with(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

bool of_whole_run(const Row& row) { return row.body.empty() && !row.t_s; }

// The tolerance of an id, 0 where it has none.
double tolerance_of(const std::string& method) {
  if (method_family(method) == method) return 0;
  return parse_method_id(method).rtol.value_or(0);
}

// Order of rungs: wide before narrow spacings, low before high sound speeds, loose before tight tolerances, few before
// many steps.
template <class Rung> bool coarser(const Rung& a, const Rung& b) {
  if (a.at != b.at) {
    const double da = a.at.first.value_or(0), db = b.at.first.value_or(0);
    return da != db ? da > db : a.at.second.value_or(0) < b.at.second.value_or(0);
  }
  const double ta = tolerance_of(a.method), tb = tolerance_of(b.method);
  return ta != tb ? ta > tb : a.steps < b.steps;
}

// Finer in one respect and coarser in none. Rungs of one resolution always compare.
template <class A, class B> bool refines(const A& fine, const B& coarse) {
  if (fine.at == coarse.at)
    return coarser(WorkPoint{coarse.method, coarse.steps, 0, 0, 0, 0, 0},
                   WorkPoint{fine.method, fine.steps, 0, 0, 0, 0, 0});
  return fine.at.first.value_or(0) <= coarse.at.first.value_or(0) &&
         fine.at.second.value_or(0) >= coarse.at.second.value_or(0) && fine.steps >= coarse.steps &&
         tolerance_of(fine.method) <= tolerance_of(coarse.method);
}

// The figures of a rung, collected from its rows.
struct Gathered {
  std::optional<Row> error;
  double seconds = kNan, evaluations = kNan;
  bool under_wasm = false;
  Status status = Status::ok;
  std::string reason;
};
using Key = std::tuple<std::string, std::int64_t, Resolution>;  // method, steps

struct Ladders {
  std::vector<std::string> families;  // in the order of the rows
  std::map<std::string, std::vector<Key>> rungs;
  std::map<Key, Gathered> gathered;
};

Ladders gather(std::span<const Row> rows, const std::string& scenario, const std::string& metric) {
  Ladders out;
  std::set<std::string> hosts;
  for (const Row& row : rows) {
    if (row.scenario != scenario || row.steps == 0 || !of_whole_run(row)) continue;
    const Key key{row.method, row.steps, resolution_of(row)};
    const auto [place, fresh] = out.gathered.try_emplace(key);
    if (fresh) {
      const std::string family = method_family(row.method);
      if (!out.rungs.contains(family)) out.families.push_back(family);
      out.rungs[family].push_back(key);
    }
    Gathered& g = place->second;
    if (row.metric == "status" && row.status != Status::ok) {
      g.status = row.status;
      g.reason = row.reason;
      continue;
    }
    if (row.metric == metric) g.error = row;  // which may be the cost itself
    if (row.metric == "run-time" && row.status == Status::ok) {
      g.seconds = row.value;
      if (const std::string& host = (*row.provenance).host; !host.empty()) hosts.insert(host);
    } else if (row.metric == "run-time-wasm" && row.status == Status::ok) {
      g.under_wasm = true;
    } else if (row.metric == "rate-evaluations") {
      g.evaluations = row.value;
    }
  }
  if (hosts.size() > 1) {
    for (auto& [key, g] : out.gathered) g.seconds = kNan;
  }
  return out;
}

bool usable(const WorkPoint& point, Cost cost) {
  return cost_of(point, cost) > 0 && std::isfinite(cost_of(point, cost));
}

// The largest error on the rungs finer than this one.
double worst_finer(const WorkCurve& curve, const WorkPoint& point) {
  double worst = 0;
  for (const WorkPoint& other : curve.points) {
    if (refines(other, point)) worst = std::max(worst, known_error(other));
  }
  for (const FailedRung& rung : curve.failed) {
    const bool bad = rung.status == Status::diverged || rung.status == Status::not_finite;
    if (bad && refines(rung, point)) worst = std::numeric_limits<double>::infinity();
  }
  return worst;
}

Reached at_rung(const WorkCurve& curve, const WorkPoint& point, Cost cost) {
  Reached reached;
  reached.family = curve.family;
  reached.method = point.method;
  reached.steps = point.steps;
  reached.error = known_error(point);
  reached.cost = cost_of(point, cost);
  reached.at_bar = at_bar(point);
  reached.coarsest = &point == &curve.points.front();
  reached.worst_finer = worst_finer(curve, point);
  reached.at = point.at;
  return reached;
}

// Long runs are not timed where a coarser rung was: they get the time of a step of that rung.
void tell_untimed(WorkCurve& curve) {
  std::map<Resolution, WorkPoint> finest;  // that was timed
  for (const WorkPoint& point : curve.points) {
    if (std::isfinite(point.seconds) && curve.family == point.method) finest.insert_or_assign(point.at, point);
  }
  for (WorkPoint& point : curve.points) {
    const auto timed = finest.find(point.at);
    if (timed != finest.end() && point.steps > timed->second.steps)
      point.seconds =
          timed->second.seconds * static_cast<double>(point.steps) / static_cast<double>(timed->second.steps);
  }
}

bool of_fluids(std::span<const WorkCurve> curves) {
  return std::any_of(curves.begin(), curves.end(), [](const WorkCurve& curve) {
    return (!curve.points.empty() && curve.points.front().at.first) ||
           (!curve.failed.empty() && curve.failed.front().at.first);
  });
}

}  // namespace

std::string method_family(const std::string& method) {
  const std::size_t slash = method.find('/'), colon = method.find(':');
  if (colon == std::string::npos || slash == std::string::npos || colon < slash) return method;
  const std::size_t brace = method.find('{');
  if (brace != std::string::npos && brace < colon) return method;
  const std::size_t end = std::min(method.find_first_of("+@{", colon), method.size());
  // "1e+4": the sign of an exponent is part of the tolerance.
  std::size_t stop = end;
  while (stop < method.size() && method[stop] == '+' && stop > 0 &&
         (method[stop - 1] == 'e' || method[stop - 1] == 'E')) {
    stop = std::min(method.find_first_of("+@{", stop + 1), method.size());
  }
  return method.substr(0, colon) + ":tol" + method.substr(stop);
}

std::string engine_of(const std::string& method) { return method.substr(0, method.find('/')); }
std::string base_of(const std::string& method) { return method.substr(0, method.find_first_of(":+@{")); }

bool at_bar(const WorkPoint& point) { return point.bar > 0 && point.error < 3 * point.bar; }
double known_error(const WorkPoint& point) { return at_bar(point) ? point.error + point.bar : point.error; }
double cost_of(const WorkPoint& point, Cost cost) { return cost == Cost::seconds ? point.seconds : point.evaluations; }

double motion_size(std::span<const Row> rows, const std::string& scenario, const std::string& metric) {
  for (const char* quantity : {"position", "velocity", "body-rate"}) {
    if (metric.rfind(std::string("error-") + quantity, 0) != 0) continue;
    for (const Row& row : rows) {
      if (row.scenario == scenario && row.metric == std::string("size-") + quantity && row.value > 0) return row.value;
    }
  }
  const bool relative = metric == "energy-max" || metric == "energy-oscillation" || metric == "jacobi-constant-error" ||
                        ends_with(metric, "-relative");
  return relative || metric.starts_with("error-") ? 1 : std::numeric_limits<double>::infinity();
}

bool is_of_ladder(const std::string& metric) {
  for (const char* family : {"order-", "gci-", "richardson-", "round-off-best-", "tolerance-exponent"})
    if (metric.starts_with(family)) return true;
  return false;
}

std::vector<WorkCurve> work_curves(std::span<const Row> rows, const std::string& scenario, const std::string& metric) {
  const Ladders ladders = gather(rows, scenario, metric);
  const double motion = motion_size(rows, scenario, metric);
  std::vector<WorkCurve> curves;
  for (const std::string& family : ladders.families) {
    WorkCurve curve{family, {}, {}};
    for (const Key& key : ladders.rungs.at(family)) {
      const Gathered& g = ladders.gathered.at(key);
      const auto& [method, steps, at] = key;
      curve.under_wasm = curve.under_wasm || g.under_wasm;
      if (g.status != Status::ok) {
        curve.failed.push_back({method, steps, 0, g.status, g.reason, at});
        continue;
      }
      if (!g.error) continue;  // measured, but without this error
      // A fluid's figures are ratios, but for a few that are compared with no size.
      const double size = at.first && g.error->unit != "1" ? std::numeric_limits<double>::infinity() : motion;
      const WorkPoint point{method,
                            steps,
                            family == method ? g.error->h_s : 0,
                            std::fabs(g.error->value),
                            g.error->truth_bar,
                            g.seconds,
                            g.evaluations,
                            at};
      if (!std::isfinite(point.error))
        curve.failed.push_back({method, steps, point.h_s, Status::not_finite, "the error is not a number", at});
      else if (known_error(point) >= size)
        curve.failed.push_back({method, steps, point.h_s, Status::diverged, "its error is as large as the motion", at});
      else curve.points.push_back(point);
    }
    std::stable_sort(curve.points.begin(), curve.points.end(), coarser<WorkPoint>);
    tell_untimed(curve);
    std::stable_sort(curve.failed.begin(), curve.failed.end(), coarser<FailedRung>);
    curves.push_back(std::move(curve));
  }
  return curves;
}

std::optional<Reached> cheapest(const WorkCurve& curve, double wanted, Cost cost) {
  const WorkPoint* best = nullptr;
  for (const WorkPoint& point : curve.points) {
    if (!usable(point, cost) || !(known_error(point) <= wanted)) continue;
    if (best == nullptr || cost_of(point, cost) < cost_of(*best, cost)) best = &point;
  }
  return best ? std::optional(at_rung(curve, *best, cost)) : std::nullopt;
}

std::optional<Reached> most_accurate(const WorkCurve& curve, double budget, Cost cost) {
  const WorkPoint* best = nullptr;
  for (const WorkPoint& point : curve.points) {
    if (!usable(point, cost) || cost_of(point, cost) > budget) continue;
    if (best == nullptr || known_error(point) < known_error(*best)) best = &point;
  }
  return best ? std::optional(at_rung(curve, *best, cost)) : std::nullopt;
}

Contest contest_of_error(std::span<const WorkCurve> curves, double wanted, Cost cost) {
  Contest contest{wanted, {}, {}};
  for (const WorkCurve& curve : curves) {
    if (const auto reached = cheapest(curve, wanted, cost)) contest.ranked.push_back(*reached);
  }
  std::stable_sort(contest.ranked.begin(), contest.ranked.end(),
                   [](const Reached& a, const Reached& b) { return a.cost < b.cost; });
  return contest;
}

Contest contest_of_budget(std::span<const WorkCurve> curves, double budget, Cost cost) {
  Contest contest{budget, {}, {}};
  for (const WorkCurve& curve : curves) {
    if (const auto reached = most_accurate(curve, budget, cost)) contest.ranked.push_back(*reached);
  }
  std::stable_sort(contest.ranked.begin(), contest.ranked.end(), [](const Reached& a, const Reached& b) {
    return a.error != b.error ? a.error < b.error : a.cost < b.cost;
  });
  return contest;
}

StableRange stable_range(const WorkCurve& curve) {
  StableRange range{curve.family, false, {}, curve.failed};
  for (auto point = curve.points.rbegin(); point != curve.points.rend(); ++point) {
    const bool finer_fails = std::any_of(curve.failed.begin(), curve.failed.end(), [&](const FailedRung& rung) {
      return (rung.status == Status::diverged || rung.status == Status::not_finite) && refines(rung, *point);
    });
    if (finer_fails) break;
    range.stable = true;
    range.first = *point;
  }
  return range;
}

const std::vector<double>& error_levels(bool fluids) {
  static const std::vector<double> levels{1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13},
      of_fluid{0.1, 0.03, 0.01, 3e-3, 1e-3, 3e-4, 1e-4, 1e-5, 1e-6};
  return fluids ? of_fluid : levels;
}

const std::vector<double>& budgets(Cost cost, bool fluids) {
  static const std::vector<double> seconds{1e-6, 1e-5, 1e-4, 1e-3, 16.7e-3, 40e-3},
      evaluations{1e2, 1e3, 1e4, 1e5, 1e6}, of_fluid{0.01, 0.1, 1, 10, 100};
  return cost == Cost::evaluations ? evaluations : fluids ? of_fluid : seconds;
}

namespace {

// The cheapest rung at this resolution with an error within 1 % of the least one there.
std::optional<Reached> at_resolution(const WorkCurve& curve, const Resolution& at) {
  const WorkPoint *least = nullptr, *chosen = nullptr;
  for (const WorkPoint& point : curve.points)
    if (point.at == at && (least == nullptr || known_error(point) < known_error(*least))) least = &point;
  if (least == nullptr) return std::nullopt;
  for (const WorkPoint& point : curve.points)
    if (point.at == at && known_error(point) <= 1.01 * known_error(*least) &&
        (chosen == nullptr || point.seconds < chosen->seconds || !std::isfinite(chosen->seconds)))
      chosen = &point;
  return at_rung(curve, *chosen, Cost::seconds);
}

std::vector<EqualSpacing> equal_spacings(std::span<const WorkCurve> curves) {
  std::vector<WorkPoint> places;  // one of each resolution
  for (const WorkCurve& curve : curves)
    for (const WorkPoint& point : curve.points)
      if (std::none_of(places.begin(), places.end(), [&](const WorkPoint& known) { return known.at == point.at; }))
        places.push_back(point);
  std::stable_sort(places.begin(), places.end(), coarser<WorkPoint>);
  std::vector<EqualSpacing> all;
  for (const WorkPoint& place : places) {
    EqualSpacing one{place.at, {}};
    for (const WorkCurve& curve : curves)
      if (const auto reached = at_resolution(curve, place.at)) one.ranked.push_back(*reached);
    std::stable_sort(one.ranked.begin(), one.ranked.end(),
                     [](const Reached& a, const Reached& b) { return a.error < b.error; });
    all.push_back(std::move(one));
  }
  return all;
}

}  // namespace

Dominance dominance(std::span<const WorkCurve> curves, const std::string& scenario, const std::string& metric,
                    const std::string& unit, Cost cost, const Question& question) {
  Dominance table{scenario, metric, unit, cost, {}, {}, {}};
  const bool one = question.error > 0 || question.budget_s > 0, fluids = of_fluids(curves);
  if (fluids && cost == Cost::evaluations) return table;
  for (const double level : one ? std::vector<double>{question.error} : error_levels(fluids)) {
    Contest contest = contest_of_error(curves, level, cost);
    if (level > 0 && !contest.ranked.empty()) table.by_error.push_back(std::move(contest));
  }
  for (const double budget : one ? std::vector<double>{question.budget_s} : budgets(cost, fluids)) {
    if (one && cost != Cost::seconds) continue;  // a budget that the user names is a time
    Contest contest = contest_of_budget(curves, budget, cost);
    if (budget > 0 && !contest.ranked.empty()) table.by_budget.push_back(std::move(contest));
  }
  for (const WorkCurve& curve : curves) {
    if (!curve.points.empty() || !curve.failed.empty()) table.stable.push_back(stable_range(curve));
  }
  if (fluids) table.by_spacing = equal_spacings(curves);
  return table;
}

namespace {

// The first quantity whose exact field is not 0 everywhere: its norm is the scale of the row.
std::string telling_metric_of_fluid(std::span<const Row> rows, const std::string& scenario) {
  for (const char* metric : {"velocity-l1", "temperature-l1", "pressure-l1", "density-l1", "front-error"}) {
    for (const Row& row : rows)
      if (row.scenario == scenario && row.metric == metric && row.spacing_m && of_whole_run(row) &&
          row.reason.find(kOfOwnScale) == std::string::npos)
        return metric;
  }
  return "";
}

}  // namespace

std::string telling_metric(std::span<const Row> rows, const std::string& scenario) {
  if (const std::string of_fluid = telling_metric_of_fluid(rows, scenario); !of_fluid.empty()) return of_fluid;
  // In scenes with contacts attitudes depend strongly on the contact points, so positions are compared.
  const auto has = [&](const char* metric) {
    return std::any_of(rows.begin(), rows.end(),
                       [&](const Row& row) { return row.scenario == scenario && row.metric == metric; });
  };
  if (has("penetration-max") && has("error-position-max")) return "error-position-max";
  std::string best;
  double best_share = -1;
  for (const char* metric : {"error-attitude-max", "error-position-max"}) {
    const double size = motion_size(rows, scenario, metric);
    double share = -1;
    for (const Row& row : rows) {
      if (row.scenario != scenario || row.metric != metric || !of_whole_run(row) || std::isnan(row.value)) continue;
      share = std::max(share, std::min(1.0, std::fabs(row.value) / size));
    }
    if (share > best_share) {
      best = metric;
      best_share = share;
    }
  }
  return best;
}

std::vector<Dominance> find_dominance(std::span<const Row> rows, const Question& question) {
  std::vector<std::string> scenarios;
  std::map<std::string, std::vector<Row>> of;
  for (const Row& row : rows) {
    if (!of.contains(row.scenario)) scenarios.push_back(row.scenario);
    std::vector<Row>& own = of[row.scenario];
    const bool wanted = row.metric == "status" || row.metric == "run-time" || row.metric == "rate-evaluations" ||
                        row.metric.rfind("size-", 0) == 0 || ends_with(row.metric, "-max") ||
                        row.metric == question.metric || (row.spacing_m && of_whole_run(row));
    if (wanted) own.push_back(row);
  }
  std::vector<Dominance> tables;
  for (const std::string& scenario : scenarios) {
    const std::vector<Row>& own = of.at(scenario);
    const std::string metric = question.metric.empty() ? telling_metric(own, scenario) : question.metric;
    if (metric.empty()) continue;
    const std::vector<WorkCurve> curves = work_curves(own, scenario, metric);
    const auto info = std::find_if(all_metrics().begin(), all_metrics().end(),
                                   [&](const MetricInfo& known) { return known.name == metric; });
    // The rows' own unit: the same metric is an angle of hinges, a length of sliders, and both where they are together.
    const auto measured =
        std::find_if(own.begin(), own.end(), [&](const Row& row) { return row.metric == metric && row.body.empty(); });
    const std::string unit = measured != own.end() ? measured->unit : info == all_metrics().end() ? "" : info->unit;
    for (const Cost cost : {Cost::seconds, Cost::evaluations}) {
      Dominance table = dominance(curves, scenario, metric, unit, cost, question);
      if (!table.by_error.empty() || !table.by_budget.empty() || !table.by_spacing.empty())
        tables.push_back(std::move(table));
    }
  }
  return tables;
}

const Reached* best_of(const Contest& contest, const std::string& engine) {
  for (const Reached& reached : contest.ranked) {
    if (engine_of(reached.family) == engine) return &reached;
  }
  return nullptr;
}

const Reached* best_rival(const Contest& contest, const std::string& engine) {
  for (const Reached& reached : contest.ranked) {
    if (engine_of(reached.family) != engine) return &reached;
  }
  return nullptr;
}

}  // namespace atwood
