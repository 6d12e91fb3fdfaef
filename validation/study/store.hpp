// What was run, kept: one SQLite file (WAL, one writer), each cell committed in one transaction as it comes. A program
// killed at any moment leaves whole cells.
//
// Every failure is a std::runtime_error in clear words: disk full, read-only, damaged, in use, not a store.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "protocol/truth.hpp"
#include "validation/metrics/metrics.hpp"
#include "validation/row.hpp"

namespace atwood {

// How a cell's accuracy run ended. A kill from outside is kept as a row but tried again next time, and so is a timeout
// under a longer limit.
struct RunRecord {
  Outcome outcome;
  std::int64_t wall_ns = 0;     // of the whole request; decides how often the timed pass repeats it
  double limit_s = 0;
  bool killed_from_outside = false;
  Provenance provenance;
};

struct TimingRecord {
  Outcome outcome;
  Provenance provenance;
};

struct MeasuredRecord {
  std::string basis;            // what the rows were measured from, besides the run: truth and metrics
  std::vector<Row> rows;        // body, t_s, metric, unit, value, truth_bar, status, reason
  Series series;
};

class Store {
 public:
  enum class Mode { write, read };
  // write: made if it is not there, held against other writers. read: may be used beside a writer.
  Store(const std::string& path, Mode mode);
  ~Store();
  Store(const Store&) = delete;
  Store& operator=(const Store&) = delete;

  std::optional<RunRecord> run(const std::string& cell_hash);
  Recording recording(const std::string& cell_hash, const Outcome& outcome);
  std::string measured_basis(const std::string& key);  // empty: not measured
  std::optional<MeasuredRecord> measured(const std::string& key, bool rows, bool series);
  std::optional<TimingRecord> timing(const std::string& timing_hash);
  std::optional<Truth> truth(const std::string& truth_hash);
  bool has_truth(const std::string& truth_hash);

  // A run with its samples and what was measured of it; one transaction.
  void put_run(const std::string& cell_hash, const RunRecord& run, const Recording& recording, const std::string& key,
               const MeasuredRecord& measured);
  void put_measured(const std::string& key, const MeasuredRecord& measured);
  void put_timing(const std::string& timing_hash, const TimingRecord& timing);
  void put_truth(const std::string& truth_hash, const Truth& truth);

 private:
  struct Database;
  std::unique_ptr<Database> database_;
};

bool store_exists(const std::string& path);

}  // namespace atwood
