// The search for a tuned preset: trials on training scenes, the best of them against the default on scenes held out.
#include "reports/command_line/tune.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>

#include <fmt/format.h>

#include "reports/render/text.hpp"
#include "scene/files.hpp"
#include "scene/named_metric.hpp"
#include "scene/split_mix.hpp"
#include "validation/metrics/order_statistics.hpp"
#include "validation/study/process.hpp"
#include "validation/study/worker_client.hpp"

namespace atwood {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kMaxScenes = 6;  // of each kind, training and held out
constexpr double kLongestRun_s = 1;    // of the default at the coarsest rung: a search makes many
constexpr std::int64_t kSamples = 16;  // few, so that step counts may differ by little
constexpr double kRate_hz = 240;       // the coarsest rung, of at most so many steps:
constexpr double kMaxSteps = 3600;
constexpr double kClearlyBetter = -0.05;  // a mean gain of 5 %; a smaller one keeps the default
// Of any figure, in its unit (m, rad, shares of the energy), in scenes of about a metre: what is under it is no
// difference. Also above a float's round-off.
constexpr double kMinDifference = 1e-6;
constexpr int kMaxTries = 5;    // on the scenes held out
constexpr double kSame = 0.01;  // a setting whose removal costs less is not kept

using Runs =
    std::map<std::pair<std::string, std::int64_t>, std::map<std::string, Row>>;  // method and steps: metric, row

class SettingSearch {
 public:
  SettingSearch(const Place& place, const Options& options, const std::vector<Worker>& workers, TuneRanges ranges,
                rivals::SceneClass scene_class)
      : place_(place), options_(options), workers_(workers), ranges_(std::move(ranges)), class_(scene_class) {}

  void choose_scenes(std::vector<Scenario> catalogue);
  TuneResult run();

 private:
  struct Trial {
    Settings changes;
    double score = 0;
    std::string trouble;
  };

  std::string id_of(const Settings& changes) const;
  bool suits(const Scenario& scenario, const std::map<std::string, Runs>& all) const;
  std::vector<Row> measure(const std::vector<Scenario>& scenes, const std::vector<std::string>& methods,
                           const std::vector<std::int64_t>& factors, bool near) const;
  Trial judged(const Settings& changes, const std::map<std::string, Runs>& runs) const;
  Trial pruned(Trial trial, const std::vector<Row>& known) const;
  std::vector<TuneEvidence> beside_default(const std::vector<Scenario>& scenes, const Settings& changes,
                                           bool held_out) const;
  std::string lost_in_class(const Settings& changes, int& figures) const;

  const Place& place_;
  const Options& options_;
  const std::vector<Worker>& workers_;
  TuneRanges ranges_;
  rivals::SceneClass class_;
  std::vector<Scenario> training_, held_out_;
  std::vector<Scenario> whole_;  // all scenes of the class, with their own step counts
};

std::map<std::string, Runs> by_scene(const std::vector<Row>& rows) {
  std::map<std::string, Runs> runs;
  for (const Row& row : rows)
    if (row.steps > 0 && row.body.empty() && !row.t_s) runs[row.scenario][{row.method, row.steps}][row.metric] = row;
  return runs;
}

const Row* row_of(const Runs& runs, const std::string& method, std::int64_t steps, const std::string& metric) {
  const auto run = runs.find({method, steps});
  if (run == runs.end()) return nullptr;
  const auto row = run->second.find(metric);
  return row == run->second.end() || row->second.status != Status::ok ? nullptr : &row->second;
}

double value_of(const Runs& runs, const std::string& method, std::int64_t steps, const std::string& metric) {
  const Row* row = row_of(runs, method, steps, metric);
  return row == nullptr ? kNone : row->value;
}

// Of the run [s]; of an engine that runs as WebAssembly, which is compared with itself alone, too.
double time_of(const Runs& runs, const std::string& method, std::int64_t steps) {
  const double native_s = value_of(runs, method, steps, "run-time");
  return std::isfinite(native_s) ? native_s : value_of(runs, method, steps, "run-time-wasm");
}

std::string trouble_of(const Runs& runs, const std::string& method, std::int64_t steps) {
  const auto run = runs.find({method, steps});
  if (run == runs.end()) return "not run";
  const auto row = run->second.find("status");
  if (row == run->second.end() || row->second.status == Status::ok) return "";
  return to_string(row->second.status) + ": " + row->second.reason;
}

std::string words_of(const Settings& changes) {
  if (changes.empty()) return "the default";
  MethodId id{"x", "x", {}, {}, "", "", changes};
  const std::string text = to_string(id);
  return text.substr(text.find('{') + 1, text.size() - text.find('{') - 2);
}

std::string SettingSearch::id_of(const Settings& changes) const {
  MethodId id = parse_method_id(ranges_.base);
  id.overrides = changes;
  return to_string(id);
}

// Each method at each multiple of the coarsest rung (`near`: at it and at the next counts that the samples allow).
std::vector<Row> SettingSearch::measure(const std::vector<Scenario>& scenes, const std::vector<std::string>& methods,
                                        const std::vector<std::int64_t>& factors, bool near) const {
  std::vector<Cell> cells;
  for (const Scenario& scenario : scenes) {
    StudyCells block;
    block.scenarios = {scenario.id};
    block.methods = methods;
    block.repeats = 5;
    for (const std::int64_t f : factors)
      block.steps.push_back(near ? scenario.steps.front() + f * scenario.samples : scenario.steps.front() * f);
    for (Cell& cell : plan_cells({"tune", {block}}, {scenario}, workers_, place_.provenance.cpu))
      cells.push_back(std::move(cell));
  }
  StudyOptions how = study_options(place_, options_);
  how.purpose = "tune";
  how.timing = !options_.no_timing;
  how.progress = progress_printer(options_);
  const StudyResult result = run_study(cells, workers_, how);
  end_progress();
  if (result.interrupted) throw Interrupted{};
  return result.rows;
}

// Scenes of the class in an order that the seed shuffles, those that the default runs, quickly and with a figure, until
// there are enough; every other one is held out.
void SettingSearch::choose_scenes(std::vector<Scenario> catalogue) {
  std::erase_if(catalogue, [&](const Scenario& s) {
    const bool geometry = std::find(s.tags.begin(), s.tags.end(), "geometry") != s.tags.end();
    return geometry || !s.scene.problem.empty() || s.scene.bodies.size() > 1100 ||
           rivals::scene_class(s.scene) != class_;
  });
  whole_ = catalogue;
  SplitMix64 random{options_.seed};
  for (std::size_t i = catalogue.size(); i > 1; --i)
    std::swap(catalogue[i - 1], catalogue[static_cast<std::size_t>(random.next_unit() * static_cast<double>(i))]);
  std::size_t chosen = 0;
  for (std::size_t from = 0; from < catalogue.size() && held_out_.size() < kMaxScenes; from += kMaxScenes) {
    std::vector<Scenario> some(
        catalogue.begin() + static_cast<std::ptrdiff_t>(from),
        catalogue.begin() + static_cast<std::ptrdiff_t>(std::min(from + kMaxScenes, catalogue.size())));
    for (Scenario& scenario : some) {
      const double steps = std::clamp(kRate_hz * scenario.t_end_s, 64.0, kMaxSteps);
      scenario.samples = kSamples;
      scenario.steps = {kSamples * static_cast<std::int64_t>(std::llround(steps / static_cast<double>(kSamples)))};
    }
    const auto runs = by_scene(measure(some, {id_of({})}, {1}, false));
    for (Scenario& scenario : some) {
      if (!suits(scenario, runs)) continue;
      std::vector<Scenario>& side = chosen++ % 2 == 0 ? training_ : held_out_;
      if (side.size() < kMaxScenes) side.push_back(std::move(scenario));
    }
  }
}

bool SettingSearch::suits(const Scenario& scenario, const std::map<std::string, Runs>& all) const {
  const auto runs = all.find(scenario.id);
  const std::int64_t n = scenario.steps.front();
  if (runs == all.end() || !trouble_of(runs->second, id_of({}), n).empty()) return false;
  if (time_of(runs->second, id_of({}), n) > kLongestRun_s) return false;
  return std::any_of(primary_metrics(class_).begin(), primary_metrics(class_).end(),
                     [&](const std::string& metric) { return row_of(runs->second, id_of({}), n, metric) != nullptr; });
}

SettingSearch::Trial SettingSearch::judged(const Settings& changes, const std::map<std::string, Runs>& all) const {
  Trial trial{changes, 0, ""};
  const std::string base = id_of({}), method = id_of(changes);
  std::vector<TuneFigure> figures;
  for (const Scenario& scenario : training_) {
    const Runs& runs = all.at(scenario.id);
    const std::int64_t n = scenario.steps.front();
    if (const std::string why = trouble_of(runs, method, n); !why.empty()) {
      trial.trouble = scenario.id + ": " + why;
      trial.score = std::numeric_limits<double>::infinity();
      return trial;
    }
    const double ratio = options_.no_timing ? 1 : time_of(runs, method, n) / time_of(runs, base, n);
    for (const std::string& metric : primary_metrics(class_)) {
      const Row* of_default = row_of(runs, base, n, metric);
      if (of_default == nullptr || !std::isfinite(of_default->value)) continue;
      TuneFigure figure{scenario.id,
                        metric,
                        n,
                        {},
                        kMinDifference + (std::isfinite(of_default->truth_bar) ? of_default->truth_bar : 0),
                        value_of(runs, method, n, metric),
                        ratio};
      for (const std::int64_t f : {1, 2, 4}) {
        const double value = value_of(runs, base, n * f, metric);
        if (!std::isfinite(value)) break;
        figure.of_default.push_back(value);
      }
      figures.push_back(std::move(figure));
    }
  }
  trial.score = tune_score(figures);
  return trial;
}

// Of the four runs at nearly the same step.
double median_ratio(const Runs& runs, const std::string& method, const std::string& base, const Scenario& scenario) {
  std::vector<double> ratios;
  for (int k = 0; k < 4; ++k) {
    const std::int64_t n = scenario.steps.front() + k * scenario.samples;
    const double ratio = time_of(runs, method, n) / time_of(runs, base, n);
    if (std::isfinite(ratio)) ratios.push_back(ratio);
  }
  if (ratios.empty()) return 1;
  std::sort(ratios.begin(), ratios.end());
  return ratios[ratios.size() / 2];
}

// Medians over four runs at nearly the same step, and at equal time (without timing: equal steps): the default's figure
// is what its ladder gives there.
std::vector<TuneEvidence> SettingSearch::beside_default(const std::vector<Scenario>& scenes, const Settings& changes,
                                                        bool held_out) const {
  const std::string base = id_of({}), method = id_of(changes);
  const auto near = by_scene(measure(scenes, {base, method}, {0, 1, 2, 3}, true));
  const auto ladder = by_scene(measure(scenes, {base}, {1, 2, 4}, false));
  std::vector<TuneEvidence> evidence;
  for (const Scenario& scenario : scenes) {
    const Runs &runs = near.at(scenario.id), &rungs = ladder.at(scenario.id);
    const std::int64_t n = scenario.steps.front();
    const double ratio = options_.no_timing ? 1 : median_ratio(runs, method, base, scenario);
    for (const std::string& metric : primary_metrics(class_)) {
      std::vector<double> of_default, of_tuned;
      double bar = 0;
      for (int k = 0; k < 4; ++k) {
        const Row* row = row_of(runs, base, n + k * scenario.samples, metric);
        if (row != nullptr && std::isfinite(row->value))
          of_default.push_back(std::fabs(row->value)),
              bar = std::max(bar, std::isfinite(row->truth_bar) ? row->truth_bar : 0);
        of_tuned.push_back(std::fabs(value_of(runs, method, n + k * scenario.samples, metric)));
      }
      if (of_default.empty()) continue;
      const bool failed = std::any_of(of_tuned.begin(), of_tuned.end(), [](double v) { return !std::isfinite(v); });
      const auto [least, most] = std::minmax_element(of_default.begin(), of_default.end());
      const double half_range = (*most - *least) / 2;
      TuneFigure figure{scenario.id, metric, n, {}, bar, 0, ratio};
      for (const std::int64_t f : {1, 2, 4}) {
        const double value = value_of(rungs, base, n * f, metric);
        if (!std::isfinite(value)) break;
        figure.of_default.push_back(value);
      }
      double at_equal_time = metrics::median_in_place(of_default);
      if (!figure.of_default.empty() && figure.of_default[0] != 0)
        at_equal_time *= std::min(1.0, default_at_equal_time(figure) / std::fabs(figure.of_default[0]));
      evidence.push_back({scenario.id, metric, n, held_out, at_equal_time,
                          failed ? kNone : metrics::median_in_place(of_tuned), half_range + bar + kMinDifference,
                          ratio});
    }
  }
  return evidence;
}

// Without the changes that do nothing for it: each is taken back alone, in the order of names, where the score stays.
SettingSearch::Trial SettingSearch::pruned(Trial trial, const std::vector<Row>& known) const {
  const Settings all = trial.changes;
  for (const auto& [name, value] : all) {
    if (trial.changes.size() == 1) break;
    Settings fewer = trial.changes;
    fewer.erase(name);
    std::vector<Row> rows = measure(training_, {id_of(fewer)}, {1}, false);
    rows.insert(rows.end(), known.begin(), known.end());
    const Trial without = judged(fewer, by_scene(rows));
    if (without.score <= trial.score + kSame) trial = without;
  }
  return trial;
}

const TuneEvidence* first_worse(const std::vector<TuneEvidence>& evidence) {
  const auto found = std::find_if(evidence.begin(), evidence.end(), [](const TuneEvidence& e) { return e.worse(); });
  return found == evidence.end() ? nullptr : &*found;
}

std::string worse_words(const TuneEvidence& e) {
  return std::isfinite(e.of_tuned) ? fmt::format("{} of {} is {:.3g}, the default's {:.3g} +/- {:.1g}", e.metric,
                                                 e.scenario, e.of_tuned, e.of_default, e.interval)
                                   : fmt::format("a run of {} failed", e.scenario);
}

// The first scene of the whole class on whose main figure the settings lose to the default, at any of its own step
// counts; empty: none. The scenes of the search are few, and the interval of a bounce's figure is nearly as large as
// the figure itself: a set may pass there and lose on most of the class.
std::string SettingSearch::lost_in_class(const Settings& changes, int& figures) const {
  const std::string base = id_of({}), method = id_of(changes);
  std::vector<Row> rows;
  for (const Scenario& scenario : whole_) {
    StudyCells block;
    block.scenarios = {scenario.id};
    block.methods = {base, method};
    const auto cells = plan_cells({"tune", {block}}, {scenario}, workers_, place_.provenance.cpu);
    StudyOptions how = study_options(place_, options_);
    how.purpose = "tune";
    how.timing = false;
    how.progress = progress_printer(options_);
    StudyResult result = run_study(cells, workers_, how);
    end_progress();
    if (result.interrupted) throw Interrupted{};
    const auto all = by_scene(result.rows);
    const auto runs = all.find(scenario.id);
    if (runs == all.end()) continue;
    for (const std::int64_t n : scenario.steps) {
      for (const std::string& metric : {named_metric(scenario), std::string("error-position-max")}) {
        const Row* of_default = row_of(runs->second, base, n, metric);
        if (of_default == nullptr || !std::isfinite(of_default->value)) continue;
        const double of_tuned = value_of(runs->second, method, n, metric);
        const double bar = std::isfinite(of_default->truth_bar) ? of_default->truth_bar : 0;
        if (loses_to_default(of_default->value, of_tuned, bar))
          return fmt::format("{} of {} at {} steps is {:.3g}, the default's {:.3g}", metric, scenario.id, n, of_tuned,
                             of_default->value);
        ++figures;
        break;
      }
    }
  }
  return "";
}

TuneResult SettingSearch::run() {
  TuneResult result;
  result.engine = ranges_.engine;
  result.scene_class = rivals::to_string(class_);
  result.seed = options_.seed;
  for (const Scenario& scenario : training_) result.training.push_back(scenario.id);
  for (const Scenario& scenario : held_out_) result.held_out.push_back(scenario.id);
  if (training_.empty() || held_out_.empty()) {
    result.verdict = fmt::format(
        "the default is kept: found {} scenes of that class that it runs; expected two at least, for one is held out",
        training_.size() + held_out_.size());
    return result;
  }
  const std::vector<Settings> sets = tune_trials(ranges_, static_cast<int>(options_.trials), options_.seed);
  std::vector<std::string> methods;
  for (const Settings& changes : sets) methods.push_back(id_of(changes));
  std::vector<Row> rows = measure(training_, methods, {1}, false);
  const std::vector<Row> finer = measure(training_, {methods.front()}, {2, 4}, false);
  rows.insert(rows.end(), finer.begin(), finer.end());
  const auto runs = by_scene(rows);
  std::vector<Trial> trials;
  for (const Settings& changes : sets) trials.push_back(judged(changes, runs));
  result.trials = static_cast<int>(trials.size());
  std::stable_sort(trials.begin(), trials.end(), [](const Trial& a, const Trial& b) { return a.score < b.score; });
  for (const Trial& trial : trials) {
    if (!trial.trouble.empty()) ++result.failed;
    fmt::print(stderr, "  {:>8}  {}{}\n", std::isfinite(trial.score) ? fmt::format("{:.3f}", trial.score) : "-",
               words_of(trial.changes), trial.trouble.empty() ? "" : "  (" + trial.trouble + ")");
  }
  // The best that worsens no figure of the training scenes goes to the held-out ones; where it worsens one there, the
  // next, a few times.
  std::string refused;
  bool lost_somewhere = false;
  for (const Trial& found : trials) {
    if (!(found.score < kClearlyBetter)) break;
    const Trial trial = pruned(found, rows);
    std::vector<TuneEvidence> evidence = beside_default(training_, trial.changes, false);
    if (const TuneEvidence* worse = first_worse(evidence)) {
      fmt::print(stderr, "  refused   {}: {}\n", words_of(trial.changes), worse_words(*worse));
      if (refused.empty()) refused = fmt::format("; {} was refused: {}", words_of(trial.changes), worse_words(*worse));
      continue;
    }
    const std::vector<TuneEvidence> outside = beside_default(held_out_, trial.changes, true);
    evidence.insert(evidence.end(), outside.begin(), outside.end());
    ++result.tried_held_out;
    if (const TuneEvidence* worse = first_worse(outside)) {
      refused = fmt::format("; {} was worse on a scene held out: {}", words_of(trial.changes), worse_words(*worse));
      fmt::print(stderr, "  held out {}\n", refused);
      if (result.tried_held_out < kMaxTries) continue;
      break;
    }
    if (std::none_of(outside.begin(), outside.end(), [](const TuneEvidence& e) { return e.better(); })) {
      refused =
          fmt::format("; {} was better than its interval in no figure of the scenes held out", words_of(trial.changes));
      fmt::print(stderr, "  held out {}\n", refused);
      if (result.tried_held_out < kMaxTries) continue;
      break;
    }
    result.class_figures = 0;
    if (const std::string lost = lost_in_class(trial.changes, result.class_figures); !lost.empty()) {
      refused = fmt::format("; {} loses in the whole class: {}", words_of(trial.changes), lost);
      fmt::print(stderr, "  in class  {}\n", refused);
      --result.tried_held_out;  // that it passed there told nothing new about the scenes held out
      lost_somewhere = true;
      continue;
    }
    result.evidence = evidence;
    result.settings = trial.changes;
    result.verdict = fmt::format(
        "kept: {}; on the training scenes its figures are {:.3g} of the default's at equal {} (geometric mean), "
        "none is worse there or on the scenes held out, and some of the latter is better, beyond intervals; none of the "
        "whole class is more than 1.5 times the default's",
        words_of(trial.changes), std::exp(trial.score), options_.no_timing ? "steps" : "time");
    return result;
  }
  result.class_figures = 0;
  result.verdict =
      (lost_somewhere ? "the default is kept: what was better in training and on the scenes held out lost elsewhere"
       : result.tried_held_out == 0
           ? "the default is kept: no trial was better and worsened nothing in training"
           : "the default is kept: what was better in training was not so on the scenes held out") +
      refused;
  return result;
}

}  // namespace

TuneResult tune(const Place& place, const Options& options, const std::vector<Worker>& workers,
                const TuneRanges& ranges, rivals::SceneClass scene_class, std::vector<Scenario> catalogue) {
  SettingSearch search(place, options, workers, ranges, scene_class);
  search.choose_scenes(std::move(catalogue));
  return search.run();
}

}  // namespace atwood
