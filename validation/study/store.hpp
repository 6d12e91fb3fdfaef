// The store of everything that was run: one SQLite file with one writer (a write-ahead log; on network file systems a
// rollback journal). Each cell is committed in one transaction when it is done, so that a program killed at any moment
// leaves complete cells only.
//
// Every entry carries a checksum, which is verified when it is read, and the keys of each table are counted and summed:
// an entry that has changed or is missing is reported, never silently left out. Keys are hashes of content, the same in
// every store.
//
// Every failure is a std::runtime_error whose message names the cause: disk full, read-only, damaged, in use, not a
// store.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <unordered_set>
#include <vector>

#include "protocol/truth.hpp"
#include "validation/metrics/fluid_picture.hpp"
#include "validation/metrics/metrics.hpp"
#include "validation/row.hpp"

namespace atwood {

// How a cell's accuracy run ended. A kill from outside is stored as a row, and the next run repeats the cell; so it
// does with a timeout when its limit is longer, and with a run of code that was loaded after `hello`.
struct RunRecord {
  Outcome outcome;
  std::int64_t wall_ns = 0;  // of the whole request; decides how often the timed pass repeats it
  double limit_s = 0;
  bool killed_from_outside = false;
  Provenance provenance;
  std::string scenario, method;  // the cell's name in messages about damage
  std::int64_t steps = 0;
};

struct TimingRecord {
  Outcome outcome;
  Provenance provenance;
  std::string host = {};  // that measured them; empty: of a store that did not record it
};

struct MeasuredRecord {
  std::string basis;      // what the rows were measured from, besides the run: truth and metrics
  std::vector<Row> rows;  // body, t_s, metric, unit, value, truth_bar, status, reason, spacing, sound speed
  Series series;
  FluidPicture picture = {};  // of a run with fluids
};

// Runs of one foreign worker whose code is not fully known. Only the runs of a campaign reuse its cells; later runs
// measure them again.
struct Campaign {
  std::string id;              // unique in all stores
  std::string series;          // of which worker, for what purpose: its campaigns follow each other
  std::string engine, run_id;  // run_id: of the run that touched it last
  std::int64_t touched = 0;    // the latest campaign of a series has the largest; nanoseconds since 1970
  bool complete = false;
};

// The keys of a cell's parts.
struct CellKeys {
  std::string accuracy, timing, measured;
};

// An entry whose checksum is wrong, or that is missing.
struct StoreDamage : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// The file is a whole store or database, but of another program or of another schema: it was not read, and nothing is
// known of damage.
struct StoreOfAnother : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// A cell of a plan: its run's key, and its name in messages.
struct PlannedCell {
  std::string hash, name;
};
struct StoredPlan {
  std::string hash, study;
  std::vector<PlannedCell> cells;
};
// A process that ran a share of a plan (shares.hpp).
struct ShardRecord {
  std::string id, plan;                // plan: its hash
  std::int64_t number = 1, count = 1;  // share `number` of `count`; with leases the process alone
  std::string costs;                   // hash of the file of costs; empty: there was none
  std::string source, host;            // source: "--shard", "lease", a variable of the launcher
  bool complete = false;
};

struct StoreDatabase;
class StoreOverview;

class Store {
 public:
  enum class Mode { write, read, check };
  // write: creates the file if it does not exist, excludes other writers, upgrades an older schema. read: one snapshot,
  // also while another program writes. check: as read, and allowed where entries are missing.
  Store(const std::string& path, Mode mode);
  ~Store();
  Store(const Store&) = delete;
  Store& operator=(const Store&) = delete;

  // "NFS", ... of a store that is open for writing: its journal is then a rollback journal. Empty: a local file system.
  const std::string& network_file_system() const;
  bool empty() const;  // a run was killed before it had made the tables: nothing can be read

  // All throw StoreDamage where a checksum is wrong.
  std::optional<RunRecord> run(const std::string& cell_hash);
  Recording recording(const std::string& cell_hash, const Outcome& outcome);
  std::string measured_basis(const std::string& key);                                      // empty: not measured
  std::optional<MeasuredRecord> measured(const std::string& key, bool rows, bool series);  // series: and the picture
  std::optional<TimingRecord> timing(const std::string& timing_hash);
  std::optional<Truth> truth(const std::string& truth_hash);
  bool has_truth(const std::string& truth_hash);

  // Of a store that is open for writing: whether it has a cell's run and rows; the keys of all runs and timed passes
  // that did not end ok.
  bool has(const CellKeys& cell);
  std::unordered_set<std::string> not_ok();
  StoreOverview overview();  // of cells, recordings, rows and times

  // Reads all entries of a cell and returns which of them are damaged; empty: none.
  std::string damage(const CellKeys& cell);
  std::string truth_damage(const std::string& truth_hash);
  // Makes all tables again from the entries that can be read, so that damaged ones can be deleted. Only once; later
  // calls do nothing.
  void rebuild();
  void forget(const std::vector<CellKeys>& cells);  // in one transaction
  // Deletes damaged entries that several cells share (provenances, campaigns, runs): the cells that need one are then
  // damaged, and a deleted campaign is started again. Returns a line for each.
  std::vector<std::string> forget_shared_damage();
  void forget_truth(const std::string& truth_hash);

  // Stores a run with its samples and the rows measured from it, in one transaction.
  // `whole_recording` false: of samples only the last, no events and no series of errors are kept. The recording is
  // let go as soon as it is packed.
  void put_run(const std::string& cell_hash, const RunRecord& run, Recording recording, const std::string& key,
               const MeasuredRecord& measured, bool whole_recording = true);
  bool keeps_recording(const std::string& cell_hash);  // false also where there is none
  void drop_recording(const CellKeys& cell);           // keeps its end
  void put_measured(const std::string& key, const std::string& cell_hash, const MeasuredRecord& measured);
  void put_timing(const std::string& timing_hash, const std::string& cell_hash, const TimingRecord& timing);
  void put_truth(const std::string& truth_hash, const std::string& scenario, const Truth& truth);

  // The latest campaign of a series.
  std::optional<Campaign> latest_campaign(const std::string& series, bool complete_only);
  void put_campaign(const Campaign& campaign);
  // Records a run of the program that wrote to the store. ended_ns 0: it is running, or was killed.
  void put_program_run(const std::string& run_id, std::int64_t begun_ns, std::int64_t ended_ns);

  // Moves the write-ahead log into the file and syncs both. Closing the store does so too, but cannot fail.
  void checkpoint();
  // Gives the space of what was dropped back to the file system at the next checkpoint, where that is a tenth of the
  // store. The store is copied for it: it stays as it is where there is no space for the copy, or another process uses
  // it.
  void compact();

  bool has_plan(const std::string& hash);
  void put_plan(const std::string& hash, const std::string& study, std::string_view cells);  // pack_plan
  std::vector<StoredPlan> plans();
  void put_shard(const ShardRecord& shard);  // replaces the one with its id
  std::vector<ShardRecord> shards();

  // Verifies every checksum and runs the database's own check; returns a line for each damaged entry.
  std::vector<std::string> check();

 private:
  std::unique_ptr<StoreDatabase> database_;
};

bool store_exists(const std::string& path);
// The network file system that a file lies on, or would; empty: a local one. ATWOOD_STORE_JOURNAL=rollback makes any of
// them one.
std::string network_file_system_of(const std::string& path);
std::string network_file_system_name(std::uint32_t magic);  // of statfs; empty: no network file system is known by it

}  // namespace atwood
