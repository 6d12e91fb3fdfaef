// What was run, kept: one SQLite file (WAL, one writer), each cell committed in one transaction as it comes. A program
// killed at any moment leaves whole cells.
//
// Every entry carries a checksum, which is verified when it is read, and the keys of each table are counted and summed:
// an entry that has changed or gone is told, never silently left out. Keys are hashes of content, the same in every
// store, so that stores can be joined.
//
// Every failure is a std::runtime_error in clear words: disk full, read-only, damaged, in use, not a store.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "protocol/truth.hpp"
#include "validation/metrics/metrics.hpp"
#include "validation/row.hpp"

namespace atwood {

// How a cell's accuracy run ended. A kill from outside is kept as a row but tried again next time, and so are a timeout
// under a longer limit and a run of code that was loaded after hello.
struct RunRecord {
  Outcome outcome;
  std::int64_t wall_ns = 0;  // of the whole request; decides how often the timed pass repeats it
  double limit_s = 0;
  bool killed_from_outside = false;
  Provenance provenance;
  std::string scenario, method;  // what it is called where damage is told
  std::int64_t steps = 0;
};

struct TimingRecord {
  Outcome outcome;
  Provenance provenance;
};

struct MeasuredRecord {
  std::string basis;      // what the rows were measured from, besides the run: truth and metrics
  std::vector<Row> rows;  // body, t_s, metric, unit, value, truth_bar, status, reason, spacing, sound speed
  Series series;
};

// Runs of one foreign worker whose code is not all known. Cells of a campaign are only taken by the runs that it goes
// through; the next one measures again.
struct Campaign {
  std::string id;              // unique in all stores
  std::string series;          // of which worker, for what purpose: its campaigns follow each other
  std::string engine, run_id;  // run_id: of the run that touched it last
  std::int64_t touched = 0;    // the latest campaign of a series has the largest; nanoseconds since 1970
  bool complete = false;
};

// Where a cell's parts stand.
struct CellKeys {
  std::string accuracy, timing, measured;
};

// An entry whose checksum is wrong, or that has gone.
struct StoreDamage : std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct StoreDatabase;

class Store {
 public:
  enum class Mode { write, read, check };
  // write: made if it is not there, held against other writers; an older schema is brought up to date. read: one
  // snapshot, may be used beside a writer. check: as read, and opened though entries have gone.
  Store(const std::string& path, Mode mode);
  ~Store();
  Store(const Store&) = delete;
  Store& operator=(const Store&) = delete;

  bool empty() const;  // a run was killed before it had made the tables; nothing can be asked

  // All throw StoreDamage where what they read is not what was written.
  std::optional<RunRecord> run(const std::string& cell_hash);
  Recording recording(const std::string& cell_hash, const Outcome& outcome);
  std::string measured_basis(const std::string& key);  // empty: not measured
  std::optional<MeasuredRecord> measured(const std::string& key, bool rows, bool series);
  std::optional<TimingRecord> timing(const std::string& timing_hash);
  std::optional<Truth> truth(const std::string& truth_hash);
  bool has_truth(const std::string& truth_hash);

  // What of a cell is damaged, all of it read against its checksums; empty: nothing.
  std::string damage(const CellKeys& cell);
  std::string truth_damage(const std::string& truth_hash);
  // All tables made anew from what can be read of them, so that what is damaged can be taken out. Once; later calls do
  // nothing.
  void rebuild();
  void forget(const std::vector<CellKeys>& cells);  // in one transaction
  // Damaged entries that belong to no one cell (provenances, campaigns, runs) are taken out: the cells that need one
  // are then damaged, a campaign that has gone is begun anew. A line for each.
  std::vector<std::string> forget_shared_damage();
  void forget_truth(const std::string& truth_hash);

  // A run with its samples and what was measured of it; one transaction.
  void put_run(const std::string& cell_hash, const RunRecord& run, const Recording& recording, const std::string& key,
               const MeasuredRecord& measured);
  void put_measured(const std::string& key, const std::string& cell_hash, const MeasuredRecord& measured);
  void put_timing(const std::string& timing_hash, const std::string& cell_hash, const TimingRecord& timing);
  void put_truth(const std::string& truth_hash, const std::string& scenario, const Truth& truth);

  // The latest campaign of a series.
  std::optional<Campaign> latest_campaign(const std::string& series, bool complete_only);
  void put_campaign(const Campaign& campaign);
  // Every run that wrote here. ended_ns 0: it is running, or was killed.
  void put_program_run(const std::string& run_id, std::int64_t begun_ns, std::int64_t ended_ns);

  // Everything against its checksums and the database's own check; a line for each thing that is damaged.
  std::vector<std::string> check();

 private:
  std::unique_ptr<StoreDatabase> database_;
};

bool store_exists(const std::string& path);

}  // namespace atwood
