// The history of runs: one SQLite file beside the store with what each run measured. It outlives recordings that are
// not kept (`--keep`), cells that are measured again, and the store itself.
//
// The figures of a scenario and method are stored once for all runs that measured the same, under the hash of their
// text; times apart from the others, because they differ in every run, and times that a run took from the store apart
// from those that it measured. Queries read the figures of one run, or of one scenario and method, at a time.
//
// Every failure is a std::runtime_error that names the file and the cause.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace atwood {

struct HistoryRun {
  std::int64_t id = 0;                      // 1, 2, ... in the order in which runs began
  std::int64_t begun_ns = 0, ended_ns = 0;  // since 1970; ended 0: it is running, or was killed
  std::string study, selection;             // selection: the filters of its call; empty: the whole study
  std::int64_t cells = 0;
  std::string command, commit, host, cpu;
  // "pass", "fail", "no gates", "interrupted", "error", "merged" (stores were joined, and nothing is judged yet); empty
  // until it ended.
  std::string verdict;
  std::int64_t passed = 0, failed = 0, unverifiable = 0, not_run = 0;
};

struct HistoryFigure {
  std::string scenario, method, metric, unit;
  std::int64_t steps = 0;  // 0: of a ladder
  double value = 0, bar = 0;
  int definition = 1;  // the version of the metric's definition
};

// A report that a run or `atwood report` wrote.
struct HistoryReport {
  std::string file, study, selection, title, verdict;
  std::int64_t cells = 0, written_ns = 0;
  bool shown = false;  // report.html is this report
};

struct HistoryFile;

class RunHistory {
 public:
  enum class Mode { write, read };
  // write: creates the file if it does not exist. read: where there is none, no run is known.
  RunHistory(const std::string& path, Mode mode);
  ~RunHistory();
  RunHistory(const RunHistory&) = delete;
  RunHistory& operator=(const RunHistory&) = delete;

  std::int64_t begin(const HistoryRun& run);  // its id
  // Figures and environment as a baseline holds them (validation/gates): stored with the run's ending, or not at all.
  // `old_times`: those that an earlier run measured. The run's selection is renewed too.
  void finish(const HistoryRun& run, const std::string& figures, const std::string& old_times,
              const std::string& environment);
  // Removes runs that have ended or began a day ago, and what only they had. `keep` > 0: those that at least `keep`
  // later runs of the same study and selection follow that have a verdict; `before_ns` > 0: those that began before.
  // How many were removed; `dry`: would be.
  std::int64_t prune(const std::string& study, std::int64_t keep, std::int64_t before_ns, bool dry);

  // The newest first; `study` empty: of every study.
  std::vector<HistoryRun> runs(const std::string& study, std::int64_t most) const;
  std::optional<HistoryRun> run(std::int64_t id) const;
  std::vector<HistoryFigure> figures(std::int64_t run) const;  // sorted by scenario, method, steps, metric
  std::string environment(std::int64_t run) const;
  // Scenarios and methods that any run measured.
  std::vector<std::pair<std::string, std::string>> measured() const;
  // Calls `each` with every run from `from` on that measured this scenario and method, the oldest first, and with its
  // figures without times that it did not measure.
  void each_run(const std::string& scenario, const std::string& method, std::int64_t from,
                const std::function<void(const HistoryRun&, const std::vector<HistoryFigure>&)>& each) const;

  std::vector<HistoryReport> reports() const;    // the newest first
  void put_report(const HistoryReport& report);  // replaces the one with its file; `shown` leaves the others

 private:
  std::unique_ptr<HistoryFile> file_;
};

}  // namespace atwood
