// advise: runs what it must, coarse before fine, and recommends a method and its step (or tolerance) for a scene.
#include "reports/command_line/advise.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "reports/command_line/goals.hpp"
#include "reports/command_line/stopwatch.hpp"

#include "reports/render/text.hpp"
#include "scene/files.hpp"
#include "validation/study/process.hpp"

namespace atwood {
namespace {

// The measured error must be this much under the asked one: another start, another end and the fit between rungs all
// cost some of it. A run must be this much under the budget: machines are not always quiet.
constexpr double kErrorSafety = 3, kTimeSafety = 1.25;
constexpr std::size_t kRefined = 5;     // families that are looked at closely
constexpr int kPairs = 9;
constexpr double kRunLimit_s = 3;       // what takes longer than this is not advised: the advice is to come soon

class Search {
 public:
  Search(const Place& place, const Options& options, const std::vector<Worker>& workers, Scenario scenario,
         Advice& advice)
      : place_(place), options_(options), workers_(workers), scenario_(std::move(scenario)), advice_(advice) {}

  bool coarse(const std::vector<std::string>& ids);     // false: interrupted; each of these too
  bool refine();
  bool decide();
  bool truth_failed() const;
  std::string truth_source() const { return truth_source_; }
  const std::vector<Row>& rows() const { return rows_; }

 private:
  using Rungs = std::map<std::string, std::set<std::int64_t>>;  // method: step counts
  bool run(const Rungs& rungs);
  std::vector<WorkCurve> curves() const { return work_curves(rows_, scenario_.id, advice_.metric); }
  std::int64_t whole(double steps) const;               // the nearest count that the samples divide
  Rungs between(const WorkPoint& a, const WorkPoint& b) const;
  std::vector<std::pair<double, const WorkCurve*>> ranked(const std::vector<WorkCurve>& all) const;
  const WorkPoint* pick(const WorkCurve& curve) const;
  std::optional<AdviceRung> neighbour(const AdviceRung& rung, double factor) const;
  void add_neighbours(Rungs& rungs, const AdviceRung& rung) const;
  const Cell* cell_of(const AdviceRung& rung) const;
  bool time_in_turns();
  void tell_losers(const std::vector<WorkCurve>& all);

  double allowed_error() const { return advice_.wanted_error / advice_.safety; }
  double allowed_time() const { return advice_.budget_s / advice_.safety; }

  const Place& place_;
  const Options& options_;
  const std::vector<Worker>& workers_;
  Scenario scenario_;
  Advice& advice_;
  std::vector<Cell> cells_;
  std::set<std::string> planned_;
  std::vector<Row> rows_;
  std::string truth_source_;
};

std::int64_t Search::whole(double steps) const {
  const double n = std::max(1.0, std::round(steps / static_cast<double>(scenario_.samples)));
  return static_cast<std::int64_t>(n) * scenario_.samples;
}

// Plans what is new and runs all of it; the store knows the rest.
bool Search::run(const Rungs& rungs) {
  for (const auto& [method, steps] : rungs) {
    StudyCells cells;
    cells.scenarios = {"*"};
    cells.methods = {method};
    cells.repeats = 5;
    for (const std::int64_t n : steps) {
      if (planned_.insert(method + " " + std::to_string(n)).second) cells.steps.push_back(n);
    }
    if (cells.steps.empty()) continue;
    for (Cell& cell : plan_cells({"advise", {cells}}, {scenario_}, workers_, place_.provenance.cpu))
      cells_.push_back(std::move(cell));
  }
  StudyOptions how = study_options(place_, options_);
  how.purpose = "advise";
  how.cell_limit_s = std::min(how.cell_limit_s, kRunLimit_s);
  how.progress = progress_printer();
  StudyResult result = run_study(cells_, workers_, how);
  end_progress();
  rows_ = std::move(result.rows);
  advice_.runs = static_cast<int>(cells_.size());
  return !result.interrupted;
}

bool Search::truth_failed() const {
  return std::any_of(rows_.begin(), rows_.end(),
                     [](const Row& row) { return row.metric == "truth" && row.status != Status::ok; }) ||
         std::none_of(rows_.begin(), rows_.end(), [](const Row& row) { return row.metric.rfind("error-", 0) == 0; });
}

bool Search::coarse(const std::vector<std::string>& ids) {
  Rungs rungs;
  const std::int64_t finest = 4 * *std::max_element(scenario_.steps.begin(), scenario_.steps.end());
  for (const std::string& id : ids) {
    const std::size_t at = id.find(":tol");
    if (at != std::string::npos) {
      for (const char* rtol : {"1e-4", "1e-6", "1e-8", "1e-10", "1e-12", "1e-13"})
        rungs[id.substr(0, at) + ":" + rtol + id.substr(at + 4)] = {scenario_.steps.front()};
      continue;
    }
    for (std::int64_t n = scenario_.samples; n <= std::max(finest, 64 * scenario_.samples); n *= 4) rungs[id].insert(n);
  }
  return run(rungs);
}

// Three rungs that part the way from a to b evenly on the logs.
Search::Rungs Search::between(const WorkPoint& a, const WorkPoint& b) const {
  Rungs rungs;
  for (const double part : {0.25, 0.5, 0.75}) {
    if (method_family(a.method) == a.method) {
      rungs[a.method].insert(
          whole(std::pow(static_cast<double>(a.steps), 1 - part) * std::pow(static_cast<double>(b.steps), part)));
      continue;
    }
    MethodId id = parse_method_id(a.method);
    const double low = std::log10(*id.rtol), high = std::log10(*parse_method_id(b.method).rtol);
    // Two digits: a tolerance that a reader would type.
    id.rtol = std::strtod(fmt::format("{:.1e}", std::pow(10, low + part * (high - low))).c_str(), nullptr);
    rungs[to_string(id)] = {a.steps};
  }
  return rungs;
}

// Best first: by the cost of the allowed error, or the error that the allowed time buys.
std::vector<std::pair<double, const WorkCurve*>> Search::ranked(const std::vector<WorkCurve>& all) const {
  std::vector<std::pair<double, const WorkCurve*>> order;
  for (const WorkCurve& curve : all) {
    const auto reached = advice_.wanted_error > 0 ? cheapest(curve, allowed_error(), Cost::seconds)
                                                  : most_accurate(curve, allowed_time(), Cost::seconds);
    if (reached) order.emplace_back(advice_.wanted_error > 0 ? reached->cost : reached->error, &curve);
  }
  std::stable_sort(order.begin(), order.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  return order;
}

bool Search::refine() {
  for (int round = 0; round < 2; ++round) {
    const std::vector<WorkCurve> all = curves();
    const auto order = ranked(all);
    Rungs rungs;
    for (std::size_t i = 0; i < std::min(kRefined, order.size()); ++i) {
      const auto& points = order[i].second->points;
      for (std::size_t k = 0; k + 1 < points.size(); ++k) {
        const bool crossed =
            advice_.wanted_error > 0
                ? known_error(points[k]) > allowed_error() && known_error(points[k + 1]) <= allowed_error()
                : points[k].seconds <= allowed_time() && !(points[k + 1].seconds <= allowed_time());
        if (!crossed) continue;
        for (auto& [method, steps] : between(points[k], points[k + 1]))
          rungs[method].insert(steps.begin(), steps.end());
      }
    }
    if (!rungs.empty() && !run(rungs)) return false;
  }
  return true;
}

// The rung to recommend: measured, and no finer one is worse than what was asked. A lucky dip is none.
const WorkPoint* Search::pick(const WorkCurve& curve) const {
  const WorkPoint* best = nullptr;
  double worst_finer = 0;
  for (auto point = curve.points.rbegin(); point != curve.points.rend(); ++point) {
    const bool timed = point->seconds > 0;
    if (advice_.wanted_error > 0) {
      if (timed && known_error(*point) <= allowed_error() && worst_finer <= advice_.wanted_error &&
          (best == nullptr || point->seconds < best->seconds))
        best = &*point;
    } else if (timed && point->seconds <= allowed_time() &&
               (best == nullptr || known_error(*point) < known_error(*best))) {
      best = &*point;
    }
    worst_finer = std::max(worst_finer, known_error(*point));
  }
  return best;
}

AdviceRung rung_of(const WorkPoint& point) {
  return {point.method, point.steps, point.h_s, point.error, point.bar, point.seconds, point.evaluations};
}

// Where a rung of twice the step (factor 2) or half of it (1/2) stands; of tolerances, ten times and a tenth.
std::pair<std::string, std::int64_t> neighbour_key(const AdviceRung& rung, double factor, const Scenario& scenario) {
  if (method_family(rung.method) != rung.method) {
    MethodId id = parse_method_id(rung.method);
    id.rtol = std::strtod(fmt::format("{:.1e}", *id.rtol * (factor > 1 ? 10 : 0.1)).c_str(), nullptr);
    return {to_string(id), rung.steps};
  }
  const double n =
      std::max(1.0, std::round(static_cast<double>(rung.steps) / factor / static_cast<double>(scenario.samples)));
  return {rung.method, static_cast<std::int64_t>(n) * scenario.samples};
}

void Search::add_neighbours(Rungs& rungs, const AdviceRung& rung) const {
  for (const double factor : {2.0, 0.5}) {
    const auto [method, steps] = neighbour_key(rung, factor, scenario_);
    if (method == rung.method && steps == rung.steps) continue;  // the samples allow no coarser one
    rungs[method].insert(steps);
  }
}

std::optional<AdviceRung> Search::neighbour(const AdviceRung& rung, double factor) const {
  const auto [method, steps] = neighbour_key(rung, factor, scenario_);
  for (const WorkCurve& curve : curves()) {
    for (const WorkPoint& point : curve.points) {
      if (point.method == method && point.steps == steps && (method != rung.method || steps != rung.steps))
        return rung_of(point);
    }
  }
  return std::nullopt;
}

const Cell* Search::cell_of(const AdviceRung& rung) const {
  for (const Cell& cell : cells_) {
    if (cell.method == rung.method && cell.plan.steps == rung.steps && cell.worker >= 0) return &cell;
  }
  return nullptr;
}

bool Search::time_in_turns() {
  const Cell *a = cell_of(advice_.best), *b = cell_of(advice_.next);
  if (a == nullptr || b == nullptr || advice_.best.seconds + advice_.next.seconds > 1) return true;
  const InterruptGuard guard;
  try {
    Stopwatch stopwatch(options_.cell_limit_s);
    std::vector<double> first, second;
    for (const auto& round :
         stopwatch.in_turns({{&workers_[static_cast<std::size_t>(a->worker)], a->method, &scenario_.scene, a->plan,
                              advice_.best.seconds, advice_.best.evaluations},
                             {&workers_[static_cast<std::size_t>(b->worker)], b->method, &scenario_.scene, b->plan,
                              advice_.next.seconds, advice_.next.evaluations}},
                            kPairs)) {
      first.push_back(round[0]);
      second.push_back(round[1]);
    }
    advice_.next_over_best = paired_ratio(second, first);
    if (std::isfinite(median(first))) advice_.best.seconds = median(first);
    if (std::isfinite(median(second))) advice_.next.seconds = median(second);
    PairedRatio& ratio = advice_.next_over_best;
    if (advice_.wanted_error > 0 && ratio.high < 1) {  // in turns the second is the quicker one
      std::swap(advice_.best, advice_.next);
      ratio = paired_ratio(first, second);
    }
  } catch (const Interrupted&) {
    return false;
  }
  return true;
}

// Who ran and is not recommended, and why.
void Search::tell_losers(const std::vector<WorkCurve>& all) {
  std::map<std::string, std::string> reasons;
  const auto tell = [&](const std::string& reason, const std::string& family) {
    reasons[reason] += (reasons[reason].empty() ? "" : ", ") + family;
  };
  for (const WorkCurve& curve : all) {
    const bool named = (advice_.found && curve.family == method_family(advice_.best.method)) ||
                       (!advice_.next.method.empty() && curve.family == method_family(advice_.next.method));
    if (named) continue;
    if (curve.points.empty()) {
      tell(curve.failed.empty() ? "no figure of this kind"
                                : to_string(curve.failed.back().status) + ": " + curve.failed.back().reason,
           curve.family);
    } else if (const WorkPoint* rung = pick(curve); rung != nullptr) {
      tell(advice_.wanted_error > 0 ? "dearer" : "less accurate within the budget",
           fmt::format(
               "{} ({})", curve.family,
               advice_.wanted_error > 0 ? time_words(rung->seconds) : fmt::format("{:.2g}", known_error(*rung))));
    } else if (advice_.wanted_error > 0) {
      const auto least =
          std::min_element(curve.points.begin(), curve.points.end(),
                           [](const WorkPoint& a, const WorkPoint& b) { return known_error(a) < known_error(b); });
      const bool untimed = known_error(*least) <= allowed_error();
      tell(untimed ? "reached the error, in runs too long to be timed, or not on every finer rung"
                   : "did not reach the error with its margin on the rungs that were run",
           fmt::format("{} (best {:.2g})", curve.family, known_error(*least)));
    } else {
      tell("no rung within the budget", curve.family);
    }
  }
  std::vector<std::pair<std::string, std::string>> told(reasons.begin(),
                                                        reasons.end());  // before those that were never run
  advice_.left_out.insert(advice_.left_out.begin(), told.begin(), told.end());
}

bool Search::decide() {
  std::vector<WorkCurve> all = curves();
  const auto by_value = [&](const std::vector<WorkCurve>& from) {
    std::vector<const WorkPoint*> rungs;
    for (const WorkCurve& curve : from) {
      if (const WorkPoint* rung = pick(curve)) rungs.push_back(rung);
    }
    std::stable_sort(rungs.begin(), rungs.end(), [&](const WorkPoint* a, const WorkPoint* b) {
      return advice_.wanted_error > 0 ? a->seconds < b->seconds : known_error(*a) < known_error(*b);
    });
    return rungs;
  };
  // The neighbours of the best may unseat it (a finer rung that is worse): look again until they do not.
  for (int round = 0; round < 3; ++round) {
    const auto rungs = by_value(all);
    if (rungs.empty()) break;
    Rungs wanted;
    add_neighbours(wanted, rung_of(*rungs[0]));
    if (rungs.size() > 1) add_neighbours(wanted, rung_of(*rungs[1]));
    const std::string before = rungs[0]->method + " " + std::to_string(rungs[0]->steps);
    if (!run(wanted)) return false;
    all = curves();
    const auto again = by_value(all);
    if (!again.empty() && again[0]->method + " " + std::to_string(again[0]->steps) == before) break;
  }
  const auto rungs = by_value(all);
  if (!rungs.empty()) {
    advice_.found = true;
    advice_.best = rung_of(*rungs[0]);
    for (const WorkPoint* rung : rungs) {
      if (advice_.next.method.empty() && method_family(rung->method) != method_family(advice_.best.method))
        advice_.next = rung_of(*rung);
    }
  }
  if (!advice_.next.method.empty() && !time_in_turns()) return false;
  if (advice_.found) {
    advice_.coarser = neighbour(advice_.best, 2);
    advice_.finer = neighbour(advice_.best, 0.5);
  }
  tell_losers(all);
  return true;
}

std::string metric_of(const std::string& asked) {
  static const std::map<std::string, std::string> known{
      {"position", "error-position-max"},   {"velocity", "error-velocity-max"}, {"attitude", "error-attitude-max"},
      {"body-rate", "error-body-rate-max"}, {"state", "error-state-end"},       {"energy", "energy-max"}};
  if (asked.empty()) return "error-position-max";
  if (const auto found = known.find(asked); found != known.end()) return found->second;
  for (const MetricInfo& metric : all_metrics()) {
    if (metric.name == asked) return asked;
  }
  throw InputError(
      fmt::format("--metric {}: expected position, velocity, attitude, body-rate, state, energy, or a metric of "
                  "`atwood list metrics`",
                  asked));
}

void read_request(const Options& options, Advice& advice) {
  if (options.wanted_error.empty() == options.budget.empty())
    throw InputError("advise: expected either --error E or --budget TIME");
  advice.metric = metric_of(options.metric);
  for (const MetricInfo& metric : all_metrics()) {
    if (metric.name == advice.metric) advice.unit = metric.unit == "1" ? "" : metric.unit;
  }
  if (!options.budget.empty()) {
    advice.budget_s = parse_duration(options.budget, "--budget");
    advice.safety = kTimeSafety;
    return;
  }
  std::size_t end = 0;
  try {
    advice.wanted_error = std::stod(options.wanted_error, &end);
  } catch (const std::exception&) {
  }
  if (end != options.wanted_error.size() || !(advice.wanted_error > 0) || !std::isfinite(advice.wanted_error)) {
    throw InputError(fmt::format("--error {}: expected a number above 0, as in 1e-8", options.wanted_error));
  }
  advice.safety = kErrorSafety;
}

}  // namespace

int command_advise(const Place& place, const Options& options) {
  Advice advice;
  read_request(options, advice);
  advice.scenario = read_scene_argument(place, options.input);
  advice.motion = classify(advice.scenario.scene);
  if (advice.metric.find("attitude") != std::string::npos || advice.metric.find("body-rate") != std::string::npos) {
    if (!advice.motion.rotates)
      throw InputError(fmt::format("--metric {}: nothing rotates in `{}`", options.metric, advice.scenario.id));
  }
  const std::vector<Worker> workers = require_workers(place, options);
  const Candidates candidates = choose_candidates(advice.motion, workers, options.engines.size());
  if (candidates.ids.empty())
    throw InputError(fmt::format("advise: no method here claims an order for `{}` ({})", advice.scenario.id,
                                 class_words(advice.motion)));
  advice.left_out = candidates.left_out;
  make_out_dir(options.out_dir);
  const auto interrupted = [] { return 128 + std::max(interrupt_signal(), 2); };

  std::optional<Search> search;
  advice.truth = truth_words(advice.scenario.truth);
  if (advice.scenario.truth.kind != TruthKind::none) {
    search.emplace(place, options, workers, advice.scenario, advice);
    if (!search->coarse(candidates.ids)) return interrupted();
  }
  if (!search || search->truth_failed()) {
    fmt::print(stderr, "atwood: `{}` has no truth that can be had: looking for one\n", advice.scenario.id);
    const InterruptGuard guard;
    AdviceTruth truth;
    try {
      truth = find_truth(place, advice.scenario, workers, candidates, options.out_dir, 60);
    } catch (const Interrupted&) {
      return interrupted();
    }
    advice.truth = truth.words;
    search.emplace(place, options, workers, truth.scenario, advice);
    if (!search->coarse(candidates.ids)) return interrupted();
  }
  if (!search->refine() || !search->decide()) return interrupted();
  fmt::print("{}", options.json ? advice_json(advice) : advice_text(advice));
  return advice.found ? exit_pass : exit_gate;
}

}  // namespace atwood
