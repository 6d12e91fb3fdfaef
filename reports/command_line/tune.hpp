// tune: a search for the settings of an engine that suit a class of scenes, with its evidence.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "reports/command_line/command_line.hpp"
#include "rivals/scene_class.hpp"

namespace atwood {

// ---- what may be tried (tune_ranges.cpp) ---------------------------------------------------------------------------
struct TuneRange {
  std::string setting;
  std::vector<SettingValue> values;  // the default's among them
  std::string why;                   // what it does, and why these values
};
struct TuneRanges {
  std::string engine, base;  // "bullet64", "bullet64/default"
  std::vector<TuneRange> ranges;
  std::vector<Settings>
      starts;  // recommended sets, among them the former presets: tried after the default, before random ones
};
// InputError: there are none for this engine; the engines that have some are named.
TuneRanges tune_ranges(const std::string& engine, rivals::SceneClass scene_class);
// The trials, each another set: the default (no changes), the starts, then half of what is left single changes, the
// other half sets in which every setting keeps the default's value with probability one half. SplitMix64 with `seed`:
// the same trials each time.
std::vector<Settings> tune_trials(const TuneRanges& ranges, int count, std::uint64_t seed);

// The figures by which a class is judged; of those, a scene counts the ones that its runs have. Not the penetration of
// a bounce: how deep a body reaches within the step of its impact is the step's, and 0 for an engine that stops it
// above.
const std::vector<std::string>& primary_metrics(rivals::SceneClass scene_class);

// ---- the judgement (tune_judge.cpp) --------------------------------------------------------------------------------
// One figure of one scene: the default's at the step counts N, 2 N, 4 N, a trial's at N, and what the trial's run
// costs, as a multiple of the default's at N.
struct TuneFigure {
  std::string scenario, metric;
  std::int64_t steps = 0;
  std::vector<double> of_default;  // one a rung, N first; where a rung failed the list ends
  double bar = 0;                  // the truth's, and round-off: figures under it are alike
  double of_trial = 0;             // NaN: its run failed
  double time_ratio = 1;
};
// The default's figure at the step count whose run takes as long as the trial's, between rungs by log-log
// interpolation, beyond the last rung that rung's. Ratios of time are rounded to powers of 2^(1/4), and 1 below
// 2^(1/4): noise of the clock decides nothing.
double default_at_equal_time(const TuneFigure& figure);
// Mean over scenes of the mean over figures of log(trial / default at equal time), each within [-7, 7]; infinite where
// a run failed. Below 0: better than the default.
double tune_score(std::span<const TuneFigure> figures);

// A figure of the winner and of the default beside each other: medians over four runs at 240 steps a second and a
// little more, `interval` the default's half range (what a figure varies by for no reason of the settings), the
// truth's bar and the least difference that counts (1e-6 in the figure's unit).
struct TuneEvidence {
  std::string scenario, metric;
  std::int64_t steps = 0;
  bool held_out = false;
  double of_default = 0, of_tuned = 0, interval = 0, time_ratio = 1;
  bool worse() const;   // beyond the interval, or not finite
  bool better() const;  // beyond the interval
};

// Whether a set's main figure of a scene loses to the default's: beyond 1.5 times it, the truth's bars and the least
// difference that counts; or its run failed.
bool loses_to_default(double of_default, double of_tuned, double bar);

// What is kept in tuned.json.
struct TuneResult {
  std::string engine, scene_class, verdict;
  Settings settings;  // empty: the default
  int trials = 0, failed = 0, tried_held_out = 0;
  std::uint64_t seed = 0;
  std::vector<std::string> training, held_out;
  int class_figures = 0;  // main figures of scenes of the whole class, in none of which the settings lose
  std::vector<TuneEvidence> evidence;
};
// Throws Interrupted; InputError where the catalogue has too few scenes of the class.
TuneResult tune(const Place& place, const Options& options, const std::vector<Worker>& workers,
                const TuneRanges& ranges, rivals::SceneClass scene_class, std::vector<Scenario> catalogue);
std::string tuned_file_with(const std::string& text, const TuneResult& result);  // of the file's whole text; InputError

int command_tune(const Place&, const Options&);

}  // namespace atwood
