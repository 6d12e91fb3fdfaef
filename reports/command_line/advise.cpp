// advise: runs the ladders of every method that may compete, as `compare` does, and recommends a method and its step
// (or tolerance) for a scene by the judgement that `compare` prints.
#include "reports/command_line/advise.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <set>

#include "reports/command_line/contest.hpp"
#include "reports/command_line/fluid_question.hpp"
#include "reports/command_line/joint_question.hpp"
#include "reports/command_line/same_rate.hpp"
#include "reports/command_line/units.hpp"
#include "reports/render/text.hpp"
#include "scene/files.hpp"
#include "validation/study/check_fluids.hpp"
#include "validation/study/process.hpp"

namespace atwood {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kMinLimit_s = 0.05;  // of a run, however short the search
// Whether the metric compares with a truth. Others are measured without one: a truth that is computed on the way may
// give the energy a scale, and its figures another name.
bool needs_truth(const std::string& metric) {
  for (const char* family : {"error-", "impact-", "transition-", "apex-", "landing-", "size-", "condition"})
    if (metric.starts_with(family)) return true;
  return false;
}

constexpr const char* kMoreTime = " (--time SECONDS gives the search more)";
constexpr int kMaxAtOnce = 4;  // methods between two checks of the time

class AdviceSearch {
 public:
  AdviceSearch(const Place& place, const Options& options, const std::vector<Worker>& workers, Scenario scenario,
               Clock::time_point start, Advice& advice)
      : place_(place), options_(options), workers_(workers), scenario_(std::move(scenario)), start_(start),
        advice_(advice) {}

  bool run(const Candidates& candidates);  // false: interrupted
  bool decide();                           // the same
  bool truth_failed() const { return truth_failed_; }
  bool has_figure() const;  // some run has the metric
  std::string why_no_figure() const;

 private:
  bool run_round(const Candidates& candidates);
  bool run_some(const std::vector<std::string>& ids);
  bool run_cells(const std::vector<std::string>& ids);
  bool of_fluids() const { return !scenario_.scene.fluids.empty(); }
  bool over() const;  // no time is left to begin another method
  bool had_turn(const std::string& engine) const;
  std::string refusal(const std::string& engine) const;
  void report_losers(const std::vector<WorkCurve>& all, const Contest& contest);

  const Place& place_;
  const Options& options_;
  const std::vector<Worker>& workers_;
  Scenario scenario_;
  Clock::time_point start_;
  Advice& advice_;
  std::vector<Cell> cells_;
  std::vector<Row> rows_;
  std::set<std::string> engines_run_;
  double run_limit_s_ = 0;  // what one run may take
  bool truth_failed_ = false;
  bool first_round_ = true;
  Resolution at_ = {};  // of fluids: what this round runs at
};

// The ladders that `compare` runs: the scenario's own steps and their halves, and tolerances where a method takes them.
// Every tolerance is a ladder of its own to a study, so that the loosest is run first: where it takes long, the tighter
// ones would take the time of the others.
bool AdviceSearch::run_some(const std::vector<std::string>& ids) {
  std::vector<std::string> notes, tight;
  std::set<std::string> families;
  std::vector<std::string> loose = with_tolerances(ids, workers_, notes);
  std::erase_if(loose, [&](const std::string& id) {
    const std::string family = method_family(id);
    if (family == id || families.insert(family).second) return false;
    tight.push_back(id);
    return true;
  });
  if (!run_cells(loose)) return false;
  std::map<std::string, std::string> slow;  // families, and the methods of them that are not run
  for (const Row& row : rows_) {
    const std::string family = method_family(row.method);
    if (family == row.method) continue;
    if ((row.metric == "status" && row.status == Status::timeout) ||
        (row.metric == "run-time" && row.value > run_limit_s_ / 8))
      slow.try_emplace(family);
  }
  std::erase_if(tight, [&](const std::string& id) { return slow.contains(method_family(id)); });
  return tight.empty() || truth_failed_ || run_cells(tight);
}

bool AdviceSearch::run_cells(const std::vector<std::string>& ids) {
  StudyCells block;
  block.scenarios = {"*"};
  block.methods = ids;
  block.whole_ladder = true;
  block.repeats = 5;
  if (at_.first) block.spacings_m = {*at_.first}, block.sound_speeds_m_per_s = {at_.second.value_or(0)};
  std::vector<Cell> cells = plan_cells({"advise", {block}}, {scenario_}, workers_, place_.provenance.cpu);
  StudyOptions how = study_options(place_, options_);
  how.purpose = "advise";
  how.cell_limit_s = run_limit_s_;
  if (of_fluids()) {
    how.until = start_ + std::chrono::duration_cast<Clock::duration>(
                             std::chrono::duration<double>(std::max(options_.search_s, kMinLimit_s)));
    how.parts = advice_.metric == "space-error" || advice_.metric == "time-error";
  }
  how.progress = progress_printer(options_);
  const StudyResult result = run_study(cells, workers_, how);
  end_progress();
  rows_.insert(rows_.end(), result.rows.begin(), result.rows.end());
  cells_.insert(cells_.end(), cells.begin(), cells.end());
  advice_.runs = static_cast<int>(cells_.size());
  for (const std::string& id : ids) engines_run_.insert(engine_of(id));
  const bool failed = std::any_of(result.rows.begin(), result.rows.end(),
                                  [](const Row& row) { return row.metric == "truth" && row.status != Status::ok; });
  truth_failed_ = truth_failed_ || (failed && (of_fluids() || needs_truth(advice_.metric)));
  return !result.interrupted;
}

bool AdviceSearch::over() const {
  return !cells_.empty() && std::chrono::duration<double>(Clock::now() - start_).count() >= options_.search_s;
}

// The reasons of runs that were refused or failed, else that of the truth; the first of each kind.
std::string AdviceSearch::why_no_figure() const {
  for (const char* metric : {"status", "truth"})
    for (const Row& row : rows_)
      if (row.metric == metric && row.status != Status::ok)
        return to_string(row.status) + ": " + row.reason + (of_fluids() && over() ? kMoreTime : "");
  if (over())
    return fmt::format("the {:g} s of the search were over (--time SECONDS gives it more)", options_.search_s);
  return "no run gave " + (advice_.metric.empty() ? std::string("an error of a field") : advice_.metric);
}

// Why an engine cannot compete: one of its methods is asked, because all refuse where the engine steps no contacts.
// Empty: it can.
std::string AdviceSearch::refusal(const std::string& engine) const {
  if (!advice_.motion.contacts || !engines_run_.contains(engine)) return "";
  std::string reason;
  for (const Row& row : rows_) {
    if (engine_of(row.method) != engine || row.metric != "status") continue;
    if (row.status != Status::unsupported) return "";
    reason = to_string(row.status) + ": " + row.reason;
  }
  return reason;
}

// Some method of the engine has run, well or badly. That one is unsupported takes no time.
bool AdviceSearch::had_turn(const std::string& engine) const {
  return std::any_of(rows_.begin(), rows_.end(), [&](const Row& row) {
    return row.metric == "status" && row.status != Status::unsupported && engine_of(row.method) == engine;
  });
}

// Of fluids a round for each spacing and sound speed, the cheapest first; else one round.
std::vector<Resolution> rounds_of(const Options& options, const Scenario& scenario) {
  if (scenario.scene.fluids.empty()) return {Resolution{}};
  const Fluid& first = scenario.scene.fluids.front();
  const auto entries = [](const std::vector<double>& asked, const std::vector<double>& ladder, double own) {
    return !asked.empty() ? asked : !ladder.empty() ? ladder : std::vector<double>{own};
  };
  std::vector<Resolution> rounds;
  for (const double spacing : entries(options.spacings, scenario.spacings_m, first.spacing_m))
    for (const double speed : entries(options.sound_speeds, scenario.sound_speeds_m_per_s, first.sound_speed_m_per_s))
      rounds.emplace_back(spacing, speed);
  const double dimensions = scenario.scene.domain.dimensions;
  const auto work = [&](const Resolution& at) { return *at.second / std::pow(*at.first, dimensions + 1); };
  std::stable_sort(rounds.begin(), rounds.end(),
                   [&](const Resolution& a, const Resolution& b) { return work(a) < work(b); });
  return rounds;
}

bool AdviceSearch::run(const Candidates& candidates) {
  run_limit_s_ = std::min(options_.cell_limit_s,
                          std::max(kMinLimit_s, options_.search_s / static_cast<double>(candidates.firsts)));
  std::string late;  // rounds that the search had no time for
  for (const Resolution& at : rounds_of(options_, scenario_)) {
    if (!first_round_ && over()) {
      late += (late.empty() ? "" : "; ") + spacing_words(at);
      continue;
    }
    at_ = at;
    if (!run_round(candidates)) return false;
    first_round_ = false;
  }
  if (!late.empty())
    advice_.left_out.emplace_back(
        fmt::format("not tried: the {:g} s of the search were over (--time SECONDS gives it more): every method at {}",
                    options_.search_s, late),
        fmt::format("{}", fmt::join(candidates.ids, ", ")));
  const bool measured =
      scenario_.scene.fluids.empty()
          ? std::any_of(rows_.begin(), rows_.end(), [](const Row& row) { return row.metric.rfind("error-", 0) == 0; })
          : !(advice_.metric.empty() ? telling_metric(rows_, scenario_.id) : advice_.metric).empty();
  truth_failed_ = truth_failed_ || !(measured || has_figure());
  return true;
}

bool AdviceSearch::has_figure() const {
  return !of_fluids() && std::any_of(rows_.begin(), rows_.end(), [&](const Row& row) {
    return row.metric == advice_.metric && row.status == Status::ok && row.steps > 0 && row.body.empty();
  });
}

// Every engine's first method that it supports is tried, whatever the time; of fluids, whose runs and truths take
// seconds, the very first method alone, and the time ends runs that go on. A ladder takes at most about three limits
// (its rungs double, and the first that hangs ends it), so that with a limit of an engine's share of the time they end
// within twice of it.
bool AdviceSearch::run_round(const Candidates& candidates) {
  const std::vector<std::string>& ids = candidates.ids;
  const std::size_t jobs = static_cast<std::size_t>(std::clamp(study_options(place_, options_).jobs, 1, kMaxAtOnce));
  std::map<std::string, std::string> out;
  const auto leave = [&](const std::string& reason, const std::string& id) {
    out[reason] += (out[reason].empty() ? "" : ", ") + id;
  };
  std::vector<std::string> some;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const bool solver = engine_of(ids[i]) == "arkode" || engine_of(ids[i]) == "odeint";
    if (truth_failed_) break;
    const bool owed = first_round_ && !of_fluids() &&
                      (i < candidates.firsts || (i < candidates.short_list && !had_turn(engine_of(ids[i]))));
    if (!owed && over()) {
      const std::string at = spacing_words(at_);
      leave(fmt::format("not tried{}: the {:g} s of the search were over (--time SECONDS gives it more)",
                        at.empty() ? "" : " at " + at, options_.search_s),
            ids[i]);
    } else if (const std::string reason = solver ? refusal(engine_of(ids[i])) : ""; !reason.empty()) {
      leave(reason, ids[i]);
    } else {
      some.push_back(ids[i]);
    }
    // One method of each large library first: if the scene is unsupported, the others are not run.
    const bool alone = solver && advice_.motion.contacts && !engines_run_.contains(engine_of(ids[i]));
    if (!some.empty() && (some.size() >= jobs || alone || i + 1 == ids.size())) {
      if (!run_some(some)) return false;
      some.clear();
    }
  }
  if (!some.empty() && !truth_failed_ && !run_some(some)) return false;
  for (const auto& [reason, methods] : out) advice_.left_out.emplace_back(reason, methods);
  return true;
}

AdviceRung rung_of(const WorkPoint& point) {
  return {point.method, point.steps, point.h_s, point.error, point.bar, point.seconds, point.evaluations, point.at};
}

// The rung that a contest names, and those beside it on its ladder.
struct Neighbours {
  AdviceRung self;
  std::optional<AdviceRung> coarser, finer;
};
Neighbours neighbours(const std::vector<WorkCurve>& all, const Reached& reached) {
  Neighbours found;
  for (const WorkCurve& curve : all) {
    if (curve.family != reached.family) continue;
    for (std::size_t i = 0; i < curve.points.size(); ++i) {
      const WorkPoint& point = curve.points[i];
      if (point.method != reached.method || point.steps != reached.steps || point.at != reached.at) continue;
      found.self = rung_of(point);
      found.self.seconds = reached.cost;
      if (i > 0) found.coarser = rung_of(curve.points[i - 1]);
      if (i + 1 < curve.points.size()) found.finer = rung_of(curve.points[i + 1]);
    }
  }
  return found;
}

// Why there is no coarser rung to compare the advised one with.
std::string no_coarser_words(const std::vector<WorkCurve>& all, const AdviceRung& best, const Scenario& scenario) {
  std::string ran;
  for (const WorkCurve& curve : all) {
    for (const FailedRung& rung : curve.failed) {
      if (rung.method != best.method || rung.steps >= best.steps || rung.at != best.at) continue;
      ran += fmt::format("{}{} steps ({})", ran.empty() ? "" : ", ", rung.steps,
                         rung.status == Status::diverged ? rung.reason : to_string(rung.status) + ": " + rung.reason);
    }
  }
  if (!ran.empty()) return "was run and does not count: " + ran;
  if (best.steps % 2 != 0) return fmt::format("none was run: the ladder begins at {} steps, which is odd", best.steps);
  if (best.steps / 2 % scenario.samples != 0)
    return fmt::format("none was run: the ladder begins at {} steps, and {} steps are not a multiple of the {} samples",
                       best.steps, best.steps / 2, scenario.samples);
  return fmt::format("none was run: the ladder begins at {} steps", best.steps);
}

// The methods that ran and are not recommended, with reasons.
void AdviceSearch::report_losers(const std::vector<WorkCurve>& all, const Contest& contest) {
  std::map<std::string, std::string> reasons;
  const auto add_reason = [&](const std::string& reason, const std::string& family) {
    reasons[reason] += (reasons[reason].empty() ? "" : ", ") + family;
  };
  const bool by_error = advice_.wanted_error > 0;
  for (std::size_t i = 2; i < contest.ranked.size(); ++i) {
    const Reached& reached = contest.ranked[i];
    add_reason(by_error ? "more expensive" : "less accurate within the budget",
               fmt::format("{} ({})", reached.family,
                           by_error ? time_words(reached.cost) : fmt::format("{:.2g}", reached.error)));
  }
  for (const WorkCurve& curve : all) {
    if (std::any_of(contest.ranked.begin(), contest.ranked.end(),
                    [&](const Reached& reached) { return reached.family == curve.family; }))
      continue;
    const bool reached =
        !curve.points.empty() &&
        (!by_error || std::any_of(curve.points.begin(), curve.points.end(),
                                  [&](const WorkPoint& point) { return known_error(point) <= advice_.wanted_error; }));
    if (reached && curve.under_wasm) {
      add_reason(kUnrankedUnderWasm, curve.family);
      advice_.under_wasm = true;
    } else if (curve.points.empty()) {
      add_reason(curve.failed.empty() ? "no figure of this kind"
                                      : to_string(curve.failed.back().status) + ": " + curve.failed.back().reason,
                 curve.family);
    } else if (by_error) {
      const auto least =
          std::min_element(curve.points.begin(), curve.points.end(),
                           [](const WorkPoint& a, const WorkPoint& b) { return known_error(a) < known_error(b); });
      add_reason(reached ? "reached the error, in runs too long to be timed"
                         : "did not reach the error on the rungs that were run",
                 fmt::format("{} (best {:.2g})", curve.family, known_error(*least)));
    } else {
      add_reason("no rung within the budget", curve.family);
    }
  }
  std::vector<std::pair<std::string, std::string>> told(reasons.begin(),
                                                        reasons.end());  // before those that were never run
  advice_.left_out.insert(advice_.left_out.begin(), told.begin(), told.end());
}

void set_metric(const std::string& metric, Advice& advice) {
  advice.metric = metric;
  for (const MetricInfo& known : all_metrics()) {
    if (known.name == metric) advice.unit = known.unit == "1" ? "" : known.unit;
  }
}

bool AdviceSearch::decide() {
  std::vector<std::string> notes;
  const std::vector<Row> rows = without_idle_halves(rows_, options_.methods, notes);
  if (advice_.metric.empty()) set_metric(telling_metric(rows, scenario_.id), advice_);
  if (const std::string unit = joint_unit(rows, advice_.metric); !unit.empty()) advice_.unit = unit;
  const std::vector<WorkCurve> all = work_curves(rows, scenario_.id, advice_.metric);
  const bool by_error = advice_.wanted_error > 0;
  Contest contest = by_error ? contest_of_error(all, advice_.wanted_error, Cost::seconds)
                             : contest_of_budget(all, advice_.budget_s, Cost::seconds);
  const InterruptGuard guard;
  try {
    const double most_s =
        of_fluids() ? std::min(TurnTimes::kPair_s, options_.search_s / TurnTimes::kPairs) : TurnTimes::kPair_s;
    TurnTimes(cells_, workers_, rows, options_.cell_limit_s).settle(contest, scenario_.id, by_error, most_s);
  } catch (const Interrupted&) {
    return false;
  }
  if (!contest.ranked.empty()) {
    advice_.found = true;
    const Neighbours found = neighbours(all, contest.ranked[0]);
    advice_.best = found.self;
    advice_.not_judged = unjudged_coordinates(rows, advice_.metric, advice_.best.method, advice_.best.steps);
    advice_.coarser = found.coarser;
    advice_.finer = found.finer;
    if (!found.coarser) advice_.no_coarser = no_coarser_words(all, found.self, scenario_);
    if (by_error) advice_.caution = caution_words(contest.ranked[0], advice_.wanted_error);
  }
  if (contest.ranked.size() > 1) advice_.next = neighbours(all, contest.ranked[1]).self;
  advice_.next_over_best = contest.to_next;
  report_losers(all, contest);
  std::vector<std::pair<std::string, std::string>> merged;  // a reason once
  for (const auto& [reason, methods] : advice_.left_out) {
    const auto known =
        std::find_if(merged.begin(), merged.end(), [&, &why = reason](const auto& one) { return one.first == why; });
    if (known == merged.end()) merged.emplace_back(reason, methods);
    else known->second += ", " + methods;
  }
  advice_.left_out = merged;
  return true;
}

void read_request(const Options& options, const Scenario& scenario, Advice& advice) {
  const Question question = fluid_question("advise", options, read_question(options), {&scenario});
  const bool fluids = !scenario.scene.fluids.empty();  // without a metric: what their rows tell most by
  set_metric(question.metric.empty() && !fluids ? "error-position-max" : question.metric, advice);
  advice.wanted_error = question.error;
  advice.budget_s = question.budget_s;
}

// The methods that are named, at every spacing of the search: InputError where a kernel is too wide for the scene.
void require_fitting_kernels(const Place& place, const Options& options, const Scenario& scenario,
                             const std::vector<Worker>& workers) {
  if (scenario.scene.fluids.empty() || options.methods.empty()) return;
  StudyCells block;
  block.scenarios = {"*"};
  block.methods = options.methods;
  block.spacings_m = options.spacings;
  block.sound_speeds_m_per_s = options.sound_speeds;
  check_fluids("--method ", plan_cells({"advise", {block}}, {scenario}, workers, place.provenance.cpu), workers);
}

}  // namespace

int command_advise(const Place& place, const Options& options) {
  const Clock::time_point start = Clock::now();
  Advice advice;
  if (options.wanted_error.empty() == options.budget.empty())
    throw InputError("advise: expected either --error E or --budget TIME");
  advice.scenario = read_scene_argument(place, options.input);
  require_own_id(place, advice.scenario);
  read_request(options, advice.scenario, advice);
  if (advice.scenario.scene.fluids.empty() && (!options.spacings.empty() || !options.sound_speeds.empty()))
    throw InputError(fmt::format("{}: `{}` has no fluid", options.spacings.empty() ? "--sound-speed" : "--spacing",
                                 advice.scenario.id));
  require_coordinates(advice.scenario, advice.metric, options.metric);
  advice.motion = classify(advice.scenario.scene);
  if (advice.metric.find("attitude") != std::string::npos || advice.metric.find("body-rate") != std::string::npos) {
    if (!advice.motion.rotates)
      throw InputError(
          fmt::format("{}: nothing rotates in `{}`",
                      options.metric.empty() ? "--error " + options.wanted_error : "--metric " + options.metric,
                      advice.scenario.id));
  }
  Options with_twins = options;
  with_twins.with_same_rate = options.same_rate;
  const std::vector<Worker> workers = require_workers(place, with_twins), named = without_same_rate(workers);
  require_answers(workers);
  Candidates candidates = options.methods.empty()
                              ? choose_candidates(advice.scenario.scene, named, options.engines.size())
                              : named_candidates(options.methods, named);
  require_fitting_kernels(place, options, advice.scenario, workers);
  if (options.same_rate) candidates = at_same_rate(candidates, workers);
  advice.rates =
      options.same_rate ? "the same: ours and libraries' methods call the reference's right-hand side"
      : std::any_of(candidates.ids.begin(), candidates.ids.end(),
                    [](const std::string& id) { return is_library(engine_of(id)); })
          ? "native: libraries call the reference's right-hand side, others their own (--same-rate: one for all)"
          : "";
  if (candidates.ids.empty())
    throw InputError(fmt::format("advise: no method here claims an order for `{}` ({})", advice.scenario.id,
                                 class_words(advice.motion)));
  advice.left_out = candidates.left_out;
  make_out_dir(options.out_dir);
  const auto interrupted = [] { return 128 + std::max(interrupt_signal(), 2); };

  std::optional<AdviceSearch> search;
  advice.truth = truth_words(advice.scenario.truth);
  const bool fluids = advice.motion.fluids;  // their metrics decide whether a truth is needed
  if (fluids && advice.scenario.truth.kind == TruthKind::none)
    advice.truth = "none: " + advice.metric + " needs no truth";
  const bool without = advice.scenario.truth.kind == TruthKind::none && !needs_truth(advice.metric);
  if (advice.scenario.truth.kind != TruthKind::none || fluids || without) {
    search.emplace(place, options, workers, advice.scenario, fluids ? Clock::now() : start, advice);
    if (!search->run(candidates)) return interrupted();
  }
  if (fluids && search->truth_failed())
    throw InputError(
        fmt::format("advise: no run of `{}` has a figure to rank: {}", advice.scenario.id, search->why_no_figure()));
  if (without && search->has_figure()) advice.truth = "none: " + advice.metric + " needs no truth";
  if (!search || search->truth_failed()) {
    fmt::print(stderr, "atwood: `{}` has no truth: one is computed\n", advice.scenario.id);
    const InterruptGuard guard;
    AdviceTruth truth;
    try {
      truth = find_truth(place, advice.scenario, workers, candidates, options.out_dir, 60);
    } catch (const Interrupted&) {
      return interrupted();
    }
    advice.truth = truth.words;
    advice.left_out = candidates.left_out;
    search.emplace(place, options, workers, truth.scenario, Clock::now(), advice);
    if (!search->run(candidates)) return interrupted();
  }
  if (!search->decide()) return interrupted();
  const std::string own = own_file(place, advice.scenario);
  advice.rerun = rerun_words(own.empty() ? advice.scenario.id : own, native_twin(advice.best.method), advice.best.steps,
                             advice.best.at);
  advice.rerun.front() = options.words.front();
  for (const std::string& engine : options.engines) advice.rerun.insert(advice.rerun.end(), {"--engine", engine});
  fmt::print("{}", options.json ? advice_json(advice) : advice_text(advice));
  return advice.found ? exit_pass : exit_gate;
}

}  // namespace atwood
