// report --against: the store's figures beside those of an earlier run or of a baseline.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>
#include <sstream>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "reports/command_line/history.hpp"
#include "reports/render/baseline_table.hpp"
#include "reports/render/palette.hpp"
#include "scene/files.hpp"
#include "validation/study/machine.hpp"

namespace atwood {
namespace fs = std::filesystem;

namespace {

using Kind = BaselineChange::Kind;
constexpr std::int64_t kAllRuns = 1'000'000;
constexpr std::size_t kMaxLines = 30;  // of worse and of better figures each

bool all_of_word(const std::string& word, const char* letters) {
  return !word.empty() && word.find_first_not_of(letters) == std::string::npos;
}

bool has_ended(const HistoryRun& run) {
  return run.ended_ns != 0 && run.verdict != "interrupted" && run.verdict != "error" && run.verdict != kMerged;
}

// Of a commit's runs the newest of this study and selection, else of this study.
HistoryRun run_of_commit(const std::vector<HistoryRun>& runs, const std::string& study, const std::string& part,
                         const std::string& word) {
  const HistoryRun* of_study = nullptr;
  std::set<std::string> studies;
  for (const HistoryRun& run : runs) {
    studies.insert("`" + one_line(run.study) + "`");
    if (run.study != study) continue;
    if (run.selection == part) return run;
    if (of_study == nullptr) of_study = &run;
  }
  if (of_study != nullptr) return *of_study;
  throw InputError(fmt::format("--against {}: no run of the study `{}` is of this commit; found runs of {}", word,
                               one_line(study), fmt::join(studies, ", ")));
}

// The run that the word means; InputError with what there is.
HistoryRun named_run(const RunHistory& history, const Options& options, const Selection& selection,
                     const std::string& word) {
  const std::vector<HistoryRun> runs = history.runs("", kAllRuns);
  if (runs.empty())
    throw InputError(fmt::format("--against {}: {} has no run yet; `{}` records one", word, history_path(options),
                                 same_call(options, "run")));
  if (all_of_word(word, "0123456789") && word.size() < 10)
    if (const auto found = history.run(std::stoll(word))) return *found;
  std::vector<HistoryRun> fitting;
  const std::string part = selection_words(options);
  const bool by_place = word == "last" || word == "previous";
  for (const HistoryRun& run : runs) {
    if (!has_ended(run)) continue;
    if (by_place ? run.study == selection.study && run.selection == part
                 : word.size() >= 4 && run.commit.starts_with(word))
      fitting.push_back(run);
  }
  if (!by_place && !fitting.empty()) return run_of_commit(fitting, selection.study, part, word);
  const std::size_t wanted = word == "previous" ? 1 : 0;
  if (fitting.size() > wanted) return fitting[wanted];
  if (by_place)
    throw InputError(fmt::format("--against {}: {} finished run{} of this study and selection in {}; expected {}", word,
                                 fitting.size(), fitting.size() == 1 ? " is" : "s are", history_path(options),
                                 wanted == 1 ? "two or more" : "one or more"));
  throw InputError(fmt::format(
      "--against {}: found no such run; expected a number from 1 to {}, the first letters of a commit, last, previous, "
      "or a baseline's file (`atwood history` lists the runs)",
      word, runs.front().id));
}

Baseline baseline_of(const RunHistory& history, const HistoryRun& run) {
  Baseline baseline;
  for (HistoryFigure& f : history.figures(run.id))
    baseline.entries.push_back({std::move(f.scenario), std::move(f.method), std::move(f.metric), f.steps, f.value,
                                f.bar, std::move(f.unit), f.definition});
  std::istringstream lines(history.environment(run.id));
  for (std::string line; std::getline(lines, line);) {
    const std::size_t tab = line.starts_with("engine\t") ? line.find('\t', 7) : line.find('\t');
    if (tab != std::string::npos) baseline.environment[line.substr(0, tab)].insert(line.substr(tab + 1));
  }
  return baseline;
}

}  // namespace

bool names_baseline_file(const std::string& word) {
  std::error_code ignored;
  return word.find('/') != std::string::npos || word.ends_with(".tsv") || fs::is_regular_file(word, ignored);
}

namespace {

// Of a part of a study only that part is compared.
int leave_out_others(const Options& options, const Selection& selection, Baseline& baseline) {
  if (selection_words(options).empty()) return 0;
  const bool rungs = !options.steps.empty() || !options.hz.empty();
  const bool resolutions = !options.spacings.empty() || !options.sound_speeds.empty();
  const FigureNames planned(names_of(selection.cells));
  return static_cast<int>(std::erase_if(
      baseline.entries, [&](const BaselineEntry& entry) { return !planned.has(entry, !rungs, !resolutions); }));
}

std::string change_line(const BaselineChange& change) {
  const std::string steps = change.steps > 0 ? fmt::format(" at {} steps", change.steps) : "";
  const std::string unit = change.unit.empty() || change.unit == "1" ? "" : " " + change.unit;
  const std::string bar = change.bar > 0 ? fmt::format(" (+- {})", figure(change.bar, 2)) : "";
  return fmt::format("{}  {}  {}{}: {} -> {}{}{}", one_line(change.scenario), one_line(change.method),
                     one_line(change.metric), steps, figure(change.before), figure(change.now), unit, bar);
}

// The factor by which the figure changed, either way; infinite where one of the two is zero.
double factor_of(const BaselineChange& change) {
  if (std::isnan(change.now) || std::isnan(change.ratio)) return HUGE_VAL;
  return change.kind == Kind::improvement ? 1 / change.ratio : change.ratio;
}

}  // namespace

Against hold_against(const Place& place, const Options& options, const Selection& selection, const std::string& named,
                     const std::vector<Row>& rows) {
  Against against;
  Baseline baseline;
  if (names_baseline_file(named)) {
    baseline = read_baseline(named);
    require_units(baseline);
    against.words = named;
  } else {
    const RunHistory history(history_path(options), RunHistory::Mode::read);
    const HistoryRun run = named_run(history, options, selection, named);
    against.words = fmt::format("run {} ({}{}{}, {} UTC, commit {}, {})", run.id, one_line(run.study),
                                run.selection.empty() ? "" : " ", one_line(run.selection), moment_words(run.begun_ns),
                                run.commit, one_line(run.host));
    if (run.verdict == kMerged)
      throw InputError(
          fmt::format("--against {}: {} is of joined stores that are not judged yet; `{}` gives it figures", named,
                      against.words, same_call(options, "report")));
    if (!has_ended(run))
      throw InputError(fmt::format("--against {}: {} did not finish: it has no figures", named, against.words));
    baseline = baseline_of(history, run);
    if (baseline.entries.empty())
      throw InputError(
          fmt::format("--against {}: {} has no figures: none of its cells gave one", named, against.words));
    if (baseline.entries.front().method == kAllMethods)
      throw InputError(
          fmt::format("--against {}: {} has no figures: of runs of 20 000 cells or more the history keeps only counts",
                      named, against.words));
    baseline.path = against.words;
    if (run.host != host_name()) {
      baseline.environment.erase("cpu");
      against.notes.push_back("Times are not compared: they are of another machine.");
    }
  }
  if (const int left_out = leave_out_others(options, selection, baseline); left_out > 0)
    against.notes.push_back(
        fmt::format("{} figure{} of other cells left out by the filter.", left_out, left_out == 1 ? " is" : "s are"));
  Judged judged;
  judge_baseline(place, options, selection, std::move(baseline), rows, judged);
  against.changes = std::move(judged.changes);
  against.notes.insert(against.notes.end(), judged.notes.begin(), judged.notes.end());
  return against;
}

void add_last_run(const Place& place, const Options& options, const Selection& selection, int skip, ReportData& data) {
  try {
    const RunHistory history(history_path(options), RunHistory::Mode::read);
    const std::string part = selection_words(options);
    for (const HistoryRun& run : history.runs(selection.study, kAllRuns)) {
      if (!has_ended(run) || run.selection != part || skip-- > 0) continue;
      const std::vector<HistoryFigure> figures = history.figures(run.id);
      if (figures.empty() || figures.front().method == kAllMethods) continue;
      Against against = hold_against(place, options, selection, std::to_string(run.id), data.rows);
      data.last_run = std::move(against.words);
      data.since_last_run = std::move(against.changes);
      data.notes.insert(data.notes.end(), against.notes.begin(), against.notes.end());
      return;
    }
    data.first_run = skip == 0;
  } catch (const std::exception& error) {
    data.notes.push_back(std::string("What changed since the last run is not known: ") + error.what());
  }
}

std::string against_text(const Against& against, bool colour) {
  const Palette& palette = colour ? kColours : kPlain;
  std::string out = fmt::format("Against {}:\n", one_line(against.words));
  std::map<Kind, int> counts;
  for (const BaselineChange& change : against.changes) ++counts[change.kind];
  const auto list = [&](Kind kind, const char* word, const char* shade) {
    std::vector<const BaselineChange*> changed;
    for (const BaselineChange& change : against.changes)
      if (change.kind == kind) changed.push_back(&change);
    std::stable_sort(changed.begin(), changed.end(),
                     [](const auto* a, const auto* b) { return factor_of(*a) > factor_of(*b); });
    for (std::size_t i = 0; i < changed.size() && i < kMaxLines; ++i) {
      const double factor = factor_of(*changed[i]);
      out += fmt::format("{}{:<9}{} {}{}\n", shade, word, palette.off, change_line(*changed[i]),
                         std::isfinite(factor) ? fmt::format(", {:.3g} x", factor) : "");
    }
    if (changed.size() > kMaxLines)
      out += fmt::format("{:<9} and {} more figures: -o json:FILE has them all\n", word, changed.size() - kMaxLines);
  };
  list(Kind::regression, "worse", palette.red);
  list(Kind::improvement, "better", palette.green);
  for (const auto& [kind, word] : {std::pair(Kind::missing, "vanished"), std::pair(Kind::added, "appeared")})
    for (const std::string& line : counted_by_scenario(against.changes, kind))
      out += fmt::format("{:<9} {}\n", word, line);
  out += fmt::format("{} worse, {} better, {} vanished, {} appeared, {} unchanged\n", counts[Kind::regression],
                     counts[Kind::improvement], counts[Kind::missing], counts[Kind::added], counts[Kind::unchanged]);
  for (const std::string& note : against.notes) out += one_line(note) + "\n";
  return out;
}

}  // namespace atwood
