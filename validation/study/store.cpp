#include "validation/study/store.hpp"

#include <sqlite3.h>
#include <unistd.h>

#include <algorithm>
#include <utility>

#include "validation/study/blob_bytes.hpp"
#include "validation/study/row_blob.hpp"
#include "validation/study/store_database.hpp"

namespace atwood {
namespace {

std::int64_t whole(const SQLite::Statement& statement, int i) { return statement.getColumn(i).getInt64(); }
std::string text(const SQLite::Statement& statement, int i) { return statement.getColumn(i).getString(); }

// Valid until the statement is stepped or reset.
std::string_view bytes(const SQLite::Statement& statement, int i) {
  const SQLite::Column column = statement.getColumn(i);
  const void* begin = column.getBlob();
  return begin ? std::string_view(static_cast<const char*>(begin), static_cast<std::size_t>(column.getBytes()))
               : std::string_view();
}

// ---- truths of very many samples ----
// SQLite copies an entry as a whole. A large truth is stored as several: its own, which has this in place of samples,
// and its parts, whose columns other than samples and bars are empty.
struct TruthParts {
  std::uint64_t parts = 0, samples = 0, bodies = 0;
};
constexpr std::uint8_t kInParts = 128;  // no other packed samples begin with this byte
constexpr std::size_t kPartBytes = std::size_t{4} << 20;

std::string packed(const TruthParts& of) {
  BlobWriter writer;
  writer.put(kInParts);
  for (const std::uint64_t number : {of.parts, of.samples, of.bodies}) writer.put(number);
  return std::move(writer.bytes);
}

// Empty: the samples are in the entry itself.
std::optional<TruthParts> parts_of(std::string_view samples) {
  BlobReader reader{samples};
  if (reader.get<std::uint8_t>() != kInParts) return std::nullopt;
  TruthParts of;
  for (std::uint64_t* number : {&of.parts, &of.samples, &of.bodies}) *number = reader.get<std::uint64_t>();
  reader.end();
  return of;
}

std::string part_key(const std::string& truth_hash, std::uint64_t part) {
  return truth_hash + " part " + std::to_string(part);
}

const SQLite::Statement& find_part(StoreDatabase& database, const std::string& truth_hash, std::uint64_t part) {
  const SQLite::Statement* found = database.find(kTruths, part_key(truth_hash, part));
  if (!found) throw StoreDamage("store " + database.path + ": a part of a truth cannot be found again");
  return *found;
}

}  // namespace

Store::Store(const std::string& path, Mode mode) {
  const auto open = [&](Mode how) {
    database_ = std::make_unique<StoreDatabase>();
    database_->path = path;
    try {
      if (how == Mode::write) database_->open_for_writing();
      else database_->open_for_reading(how == Mode::read);
      return database_->empty || how == Mode::write || database_->is_current();
    } catch (const SQLite::Exception& error) {
      try {
        database_->fail(error);
      } catch (const std::runtime_error&) {
        database_->remove_new_store();
        throw;
      }
    }
  };
  if (open(mode)) return;
  try {
    open(Mode::write);  // upgrades the schema
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(std::string(error.what()) + " (it has schema " + std::to_string(kStoreSchema - 1) +
                             " and could not be brought up to date)");
  }
  open(mode);
}

Store::~Store() = default;

const std::string& Store::network_file_system() const { return database_->network_file_system; }

bool Store::empty() const { return database_->empty; }

void Store::checkpoint() {
  if (!network_file_system().empty()) return;  // each commit is synced
  database_->guarded([&] { database_->sql->exec("PRAGMA wal_checkpoint(PASSIVE)"); });
}

void Store::compact() {
  database_->guarded([&] {
    const auto pages = database_->sql->execAndGet("PRAGMA page_count").getInt64();
    if (10 * database_->sql->execAndGet("PRAGMA freelist_count").getInt64() < pages) return;
    database_->forget_statements();
    try {
      database_->sql->exec("VACUUM");
    } catch (const SQLite::Exception& error) {
      const int code = error.getErrorCode();
      if (code != SQLITE_BUSY && code != SQLITE_LOCKED && code != SQLITE_FULL) throw;
    }
  });
}

// ---- reading ------------------------------------------------------------------------------------------------------
std::optional<RunRecord> Store::run(const std::string& cell_hash) {
  return database_->guarded([&]() -> std::optional<RunRecord> {
    const SQLite::Statement* found = database_->find(kCells, cell_hash);
    if (!found) return std::nullopt;
    RunRecord record;
    record.scenario = text(*found, 1);
    record.method = text(*found, 2);
    record.steps = whole(*found, 3);
    record.outcome.status = status_from_string(text(*found, 4));
    record.outcome.reason = text(*found, 5);
    record.outcome.steps_taken = whole(*found, 6);
    record.outcome.rate_evaluations = whole(*found, 7);
    record.wall_ns = whole(*found, 8);
    record.limit_s = found->getColumn(9).getDouble();
    record.killed_from_outside = whole(*found, 10) != 0;
    record.provenance = database_->provenance(text(*found, 11));
    return record;
  });
}

Recording Store::recording(const std::string& cell_hash, const Outcome& outcome) {
  std::string samples, events;
  database_->guarded([&] {
    const SQLite::Statement* found = database_->find(kSeries, cell_hash);
    if (!found) throw StoreDamage("store " + database_->path + ": a recording cannot be found again");
    samples = expanded(bytes(*found, 1));
    events = expanded(bytes(*found, 2));
  });
  return database_->guarded([&] {  // when SQLite has let go of its copy
    Recording recording;
    recording.outcome = outcome;
    recording.values = unpack_samples(samples);
    unpack_beside_samples(events, recording);
    return recording;
  });
}

std::string Store::measured_basis(const std::string& key) {
  return database_->guarded([&]() -> std::string {
    const SQLite::Statement* found = database_->find(kMeasured, key);
    return found ? text(*found, 2) : "";
  });
}

std::optional<MeasuredRecord> Store::measured(const std::string& key, bool rows, bool series) {
  return database_->guarded([&]() -> std::optional<MeasuredRecord> {
    const SQLite::Statement* found = database_->find(kMeasured, key);
    if (!found) return std::nullopt;
    MeasuredRecord record;
    record.basis = text(*found, 2);
    if (rows) record.rows = unpack_rows(expanded(blob_of(found->getColumn(3))));
    const std::string errors = series ? expanded(blob_of(found->getColumn(4))) : "";
    if (!errors.empty()) record.series = unpack_series_and_picture(errors, record.picture);
    return record;
  });
}

std::optional<TimingRecord> Store::timing(const std::string& timing_hash) {
  return database_->guarded([&]() -> std::optional<TimingRecord> {
    const SQLite::Statement* found = database_->find(kTimings, timing_hash);
    if (!found) return std::nullopt;
    TimingRecord record;
    record.outcome.status = status_from_string(text(*found, 2));
    record.outcome.reason = text(*found, 3);
    record.outcome.steps_taken = whole(*found, 4);
    record.outcome.rate_evaluations = whole(*found, 5);
    for (const double ns : unpack_reals(blob_of(found->getColumn(6))))
      record.outcome.busy_ns.push_back(static_cast<std::int64_t>(ns));
    record.provenance = database_->provenance(text(*found, 7));
    record.host = text(*found, 8);
    record.outcome.call_ns = whole(*found, 9);
    return record;
  });
}

bool Store::has_truth(const std::string& truth_hash) {
  return database_->guarded([&] {
    const SQLite::Statement* found = database_->find(kTruths, truth_hash);
    if (!found) return false;
    if (const auto in_parts = parts_of(bytes(*found, 7)))
      for (std::uint64_t part = 0; part < in_parts->parts; ++part) find_part(*database_, truth_hash, part);
    return true;
  });
}

std::optional<Truth> Store::truth(const std::string& truth_hash) {
  return database_->guarded([&]() -> std::optional<Truth> {
    const SQLite::Statement* found = database_->find(kTruths, truth_hash);
    if (!found) return std::nullopt;
    Truth truth;
    truth.outcome.status = status_from_string(text(*found, 2));
    truth.outcome.reason = text(*found, 3);
    truth.source = text(*found, 4);
    truth.note = text(*found, 5);
    truth.condition = real_or_nan(found->getColumn(6));
    truth.events = unpack_events(bytes(*found, 9));
    truth.event_bar_s = unpack_reals(bytes(*found, 10));
    const auto in_parts = parts_of(bytes(*found, 7));
    if (!in_parts) {
      truth.values = unpack_samples(bytes(*found, 7));
      truth.bars = unpack_samples(bytes(*found, 8));
      return truth;
    }
    const std::uint64_t most = database_->bytes();  // what an entry says of its parts may be false
    if (in_parts->bodies <= most / (13 * 8)) {
      const std::uint64_t least_of_one = 24 + 13 * 8 * in_parts->bodies;
      const std::uint64_t samples = std::min(in_parts->samples, most / least_of_one);
      for (SampleSeries* series : {&truth.values, &truth.bars}) series->reserve(samples, in_parts->bodies);
    }
    for (std::uint64_t part = 0; part < in_parts->parts; ++part) {
      const SQLite::Statement& entry = find_part(*database_, truth_hash, part);
      append_samples(bytes(entry, 7), truth.values);
      append_samples(bytes(entry, 8), truth.bars);
    }
    return truth;
  });
}

std::string Store::damage(const CellKeys& cell) {
  const char* what = "the outcome";
  try {
    const auto record = run(cell.accuracy);
    if (record) {
      what = "the recording";
      const bool there = database_->guarded([&] { return database_->find(kSeries, cell.accuracy) != nullptr; });
      if (!there) return what;
    }
    what = "the rows";
    measured(cell.measured, true, true);
    what = "the times";
    timing(cell.timing);
  } catch (const StoreDamage&) {
    return what;
  }
  return "";
}

std::string Store::truth_damage(const std::string& truth_hash) {
  try {
    has_truth(truth_hash);
  } catch (const StoreDamage& error) {
    return error.what();
  }
  return "";
}

// ---- writing ------------------------------------------------------------------------------------------------------
void Store::rebuild() {
  database_->written([&] { database_->rebuild(); });
}

void Store::forget(const std::vector<CellKeys>& cells) {
  database_->written([&] {
    for (const CellKeys& cell : cells) {
      database_->erase(kCells, cell.accuracy);
      database_->erase(kSeries, cell.accuracy);
      database_->erase(kMeasured, cell.measured);
      database_->erase(kTimings, cell.timing);
    }
  });
}

std::vector<std::string> Store::forget_shared_damage() {
  std::vector<std::string> told;
  database_->written([&] {
    for (const StoreTable* table : {&kProvenances, &kRuns, &kCampaigns}) {
      if (!database_->damaged_keys(*table).empty()) database_->rebuild();
      for (const std::string& key : database_->damaged_keys(*table)) {
        database_->erase(*table, key);
        told.push_back("store " + database_->path + ": an entry of `" + table->name + "` is damaged and taken out");
      }
    }
  });
  return told;
}

void Store::forget_truth(const std::string& truth_hash) {
  database_->written([&] {
    SQLite::Statement& erase = database_->prepared("DELETE FROM truths WHERE hash=? OR (hash>? AND hash<?)");
    erase.bind(1, truth_hash);
    erase.bind(2, truth_hash + " part ");  // the keys of its parts lie between
    erase.bind(3, truth_hash + " part!");
    erase.exec();
  });
}

void Store::put_run(const std::string& cell_hash, const RunRecord& run, Recording recording, const std::string& key,
                    const MeasuredRecord& measured, bool whole_recording) {
  const std::size_t all = recording.values.size(), first = whole_recording || all == 0 ? 0 : all - 1;
  if (!whole_recording) recording.events.clear(), recording.between.clear();
  std::string samples = pack_samples(recording.values, first, all);
  recording.values.clear();
  samples = compressed(samples);
  const std::string events = compressed(pack_beside_samples(recording, run.outcome.solvers));
  MeasuredRecord without_series{measured.basis, {}, {}, {}};
  if (!whole_recording) without_series.rows = measured.rows;
  database_->written([&] {
    const Outcome& outcome = run.outcome;
    database_->insert(kCells,
                      {cell_hash, run.scenario, run.method, run.steps, to_string(outcome.status), outcome.reason,
                       outcome.steps_taken, outcome.rate_evaluations, run.wall_ns, run.limit_s,
                       std::int64_t{run.killed_from_outside ? 1 : 0}, database_->provenance_hash(run.provenance)});
    database_->insert(kSeries, {cell_hash, Blob{samples}, Blob{events}, std::string(whole_recording ? "all" : "end")});
    database_->insert_measured(key, cell_hash, whole_recording ? measured : without_series);
  });
}

bool Store::keeps_recording(const std::string& cell_hash) {
  return database_->guarded([&] {
    const SQLite::Statement* found = database_->find(kSeries, cell_hash);
    return found != nullptr && text(*found, 3) == "all";
  });
}

// The same as if put_run had kept the end alone.
void Store::drop_recording(const CellKeys& cell) {
  const auto record = run(cell.accuracy);
  if (!record || !keeps_recording(cell.accuracy)) return;
  const auto measured = this->measured(cell.measured, true, false);
  if (!measured) return;
  Recording whole = recording(cell.accuracy, record->outcome);
  RunRecord run = *record;
  run.outcome = whole.outcome;  // how its solvers ended is kept with the recording
  put_run(cell.accuracy, run, std::move(whole), cell.measured, *measured, false);
}

void Store::put_measured(const std::string& key, const std::string& cell_hash, const MeasuredRecord& measured) {
  database_->written([&] { database_->insert_measured(key, cell_hash, measured); });
}

void Store::put_timing(const std::string& timing_hash, const std::string& cell_hash, const TimingRecord& timing) {
  const Outcome& outcome = timing.outcome;
  const std::string busy_ns = pack_reals({outcome.busy_ns.begin(), outcome.busy_ns.end()});
  database_->written([&] {
    database_->insert(kTimings, {timing_hash, cell_hash, to_string(outcome.status), outcome.reason, outcome.steps_taken,
                                 outcome.rate_evaluations, Blob{busy_ns}, database_->provenance_hash(timing.provenance),
                                 timing.host, outcome.call_ns});
  });
}

void Store::put_truth(const std::string& truth_hash, const std::string& scenario, const Truth& truth) {
  const std::size_t count = truth.values.size();
  TruthParts in_parts{1, count, 0};
  std::size_t each = count;
  if (count > 0) {
    const SampleView first = truth.values.front();
    each = 1 + kPartBytes / (64 + first.bodies.size_bytes() + first.particles.size_bytes() + first.joints.size_bytes());
    in_parts = {(count + each - 1) / each, count, first.bodies.size()};
  }
  const bool whole = in_parts.parts <= 1;
  const std::string samples = whole ? pack_samples(truth.values) : packed(in_parts),
                    bars = whole ? pack_samples(truth.bars) : "", events = pack_events(truth.events),
                    event_bars = pack_reals(truth.event_bar_s);
  database_->written([&] {
    database_->insert(
        kTruths, {truth_hash, scenario, to_string(truth.outcome.status), truth.outcome.reason, truth.source, truth.note,
                  truth.condition, Blob{samples}, Blob{bars}, Blob{events}, Blob{event_bars}});
    for (std::uint64_t part = 0; !whole && part < in_parts.parts; ++part) {
      const std::size_t from = part * each, to = std::min(count, from + each);
      const std::string some = pack_samples(truth.values, from, to), some_bars = pack_samples(truth.bars, from, to);
      database_->insert(kTruths, {part_key(truth_hash, part), scenario, to_string(Status::ok), std::string(),
                                  std::string(), std::string(), 0.0, Blob{some}, Blob{some_bars}, Blob{}, Blob{}});
    }
  });
}

// ---- runs and campaigns -------------------------------------------------------------------------------------------
std::optional<Campaign> Store::latest_campaign(const std::string& series, bool complete_only) {
  return database_->guarded([&]() -> std::optional<Campaign> {
    std::optional<Campaign> latest;
    SQLite::Statement ids(*database_->sql, "SELECT id FROM campaigns");  // in any order: those that cannot be found too
    while (ids.executeStep()) {
      const std::string id = ids.getColumn(0).getString();
      const SQLite::Statement* found = database_->find(kCampaigns, id);
      if (!found) continue;
      Campaign campaign{id, text(*found, 1), text(*found, 2), text(*found, 3), whole(*found, 4), whole(*found, 5) != 0};
      if (campaign.series != series || (complete_only && !campaign.complete)) continue;
      if (!latest || campaign.touched > latest->touched) latest = std::move(campaign);
    }
    return latest;
  });
}

void Store::put_campaign(const Campaign& campaign) {
  database_->written([&] {
    database_->insert(kCampaigns, {campaign.id, campaign.series, campaign.engine, campaign.run_id, campaign.touched,
                                   std::int64_t{campaign.complete ? 1 : 0}});
  });
}

void Store::put_program_run(const std::string& run_id, std::int64_t begun_ns, std::int64_t ended_ns) {
  database_->written([&] { database_->insert(kRuns, {run_id, begun_ns, ended_ns}); });
}

void Store::put_plan(const std::string& hash, const std::string& study, std::string_view cells) {
  const std::string packed = compressed(cells);
  database_->written([&] { database_->insert(kPlans, {hash, study, Blob{packed}}); });
}

bool Store::has_plan(const std::string& hash) {
  return database_->guarded([&] { return database_->find(kPlans, hash) != nullptr; });
}

std::vector<StoredPlan> Store::plans() {
  return database_->guarded([&] {
    std::vector<StoredPlan> all;
    SQLite::Statement hashes(*database_->sql, "SELECT hash FROM plans ORDER BY hash");
    while (hashes.executeStep()) {
      const SQLite::Statement* found = database_->find(kPlans, hashes.getColumn(0).getString());
      if (found) all.push_back({text(*found, 0), text(*found, 1), unpack_plan(expanded(blob_of(found->getColumn(2))))});
    }
    return all;
  });
}

void Store::put_shard(const ShardRecord& shard) {
  database_->written([&] {
    database_->insert(kShards, {shard.id, shard.plan, shard.number, shard.count, shard.costs, shard.source, shard.host,
                                std::int64_t{shard.complete ? 1 : 0}});
  });
}

std::vector<ShardRecord> Store::shards() {
  return database_->guarded([&] {
    std::vector<ShardRecord> all;
    SQLite::Statement ids(*database_->sql, "SELECT id FROM shards ORDER BY id");
    while (ids.executeStep()) {
      const SQLite::Statement* found = database_->find(kShards, ids.getColumn(0).getString());
      if (found)
        all.push_back({text(*found, 0), text(*found, 1), whole(*found, 2), whole(*found, 3), text(*found, 4),
                       text(*found, 5), text(*found, 6), whole(*found, 7) != 0});
    }
    return all;
  });
}

bool store_exists(const std::string& path) { return access(path.c_str(), F_OK) == 0; }

}  // namespace atwood
