#include "validation/study/store_schema.hpp"

#include <sqlite3.h>

#include "validation/study/row_blob.hpp"
#include "validation/study/store_database.hpp"

namespace atwood {

// commit is a keyword of SQL.
const char* const kStoreTablesSql = R"(
CREATE TABLE provenances(hash TEXT PRIMARY KEY, engine_version TEXT, commit_id TEXT, compiler TEXT, flags TEXT, cpu TEXT,
  cpu_features TEXT, libm TEXT, run_id TEXT, checksum INTEGER NOT NULL) WITHOUT ROWID;
CREATE TABLE runs(id TEXT PRIMARY KEY, begun_ns INTEGER, ended_ns INTEGER, checksum INTEGER NOT NULL) WITHOUT ROWID;
CREATE TABLE campaigns(id TEXT PRIMARY KEY, series TEXT NOT NULL, engine TEXT NOT NULL, run_id TEXT NOT NULL,
  touched INTEGER NOT NULL, complete INTEGER NOT NULL, checksum INTEGER NOT NULL) WITHOUT ROWID;
CREATE TABLE cells(hash TEXT PRIMARY KEY, scenario TEXT NOT NULL, method TEXT NOT NULL, steps INTEGER NOT NULL,
  status TEXT NOT NULL, reason TEXT NOT NULL, steps_taken INTEGER, rate_evaluations INTEGER, wall_ns INTEGER,
  limit_s REAL, killed_from_outside INTEGER, provenance TEXT NOT NULL, checksum INTEGER NOT NULL) WITHOUT ROWID;
CREATE TABLE series(hash TEXT PRIMARY KEY, samples BLOB NOT NULL, events BLOB NOT NULL, kept TEXT NOT NULL,
  checksum INTEGER NOT NULL);
CREATE TABLE measured(key TEXT PRIMARY KEY, cell TEXT NOT NULL, basis TEXT NOT NULL, rows BLOB NOT NULL,
  errors BLOB NOT NULL, checksum INTEGER NOT NULL);
CREATE TABLE timings(hash TEXT PRIMARY KEY, cell TEXT NOT NULL, status TEXT NOT NULL, reason TEXT NOT NULL,
  steps_taken INTEGER, rate_evaluations INTEGER, busy_ns BLOB NOT NULL, provenance TEXT NOT NULL, host TEXT NOT NULL,
  call_ns INTEGER NOT NULL, checksum INTEGER NOT NULL) WITHOUT ROWID;
CREATE TABLE truths(hash TEXT PRIMARY KEY, scenario TEXT NOT NULL, status TEXT NOT NULL, reason TEXT NOT NULL,
  source TEXT, note TEXT, condition REAL, samples BLOB NOT NULL, bars BLOB NOT NULL, events BLOB NOT NULL,
  event_bars BLOB NOT NULL, checksum INTEGER NOT NULL);
CREATE TABLE plans(hash TEXT PRIMARY KEY, study TEXT NOT NULL, cells BLOB NOT NULL, checksum INTEGER NOT NULL);
CREATE TABLE shards(id TEXT PRIMARY KEY, plan TEXT NOT NULL, number INTEGER NOT NULL, count INTEGER NOT NULL,
  costs TEXT NOT NULL, source TEXT NOT NULL, host TEXT NOT NULL, complete INTEGER NOT NULL,
  checksum INTEGER NOT NULL) WITHOUT ROWID;
CREATE TABLE totals(name TEXT PRIMARY KEY, entries INTEGER NOT NULL, key_sum INTEGER NOT NULL) WITHOUT ROWID;
)";

namespace {

// The value of a column for another statement; blobs are valid until the statement is stepped or reset.
StoreValue copied(const SQLite::Column& column) {
  switch (column.getType()) {
    case SQLITE_INTEGER: return column.getInt64();
    case SQLITE_FLOAT: return column.getDouble();
    case SQLITE_TEXT: return column.getString();
    case SQLITE_BLOB:
      return Blob{{static_cast<const char*>(column.getBlob()), static_cast<std::size_t>(column.getBytes())}};
    default: return nullptr;
  }
}

// Schema 3 kept each row as an entry of its own, and blobs as they are.
constexpr StoreTable kOldTables[] = {
    {"series", "hash, samples, events", 3, false},
    {"measured", "key, cell, basis, errors, row_count, rows_checksum", 6, true},
    {"timings", "hash, cell, status, reason, steps_taken, rate_evaluations, busy_ns, provenance", 8, true}};

void migrate_series(StoreDatabase& database) {
  SQLite::Statement select(*database.sql, "SELECT hash, samples, events FROM old_series");
  while (select.executeStep()) {
    const std::string samples = compressed(blob_of(select.getColumn(1))),
                      events = compressed(blob_of(select.getColumn(2)));
    database.insert(kSeries, {copied(select.getColumn(0)), Blob{samples}, Blob{events}, std::string("all")});
  }
}

void migrate_measured(StoreDatabase& database) {
  SQLite::Statement select(*database.sql,
                           "SELECT key, cell, basis, errors, row_count, rows_checksum FROM old_measured");
  SQLite::Statement rows(*database.sql,
                         "SELECT ordinal, body, t_s, metric, unit, value, truth_bar, status, reason, spacing_m, "
                         "sound_speed_m_per_s FROM old_rows WHERE key=? ORDER BY ordinal");
  while (select.executeStep()) {
    rows.reset();
    rows.bind(1, select.getColumn(0).getString());
    std::vector<Row> all;
    ValueChecksum checksum;
    while (rows.executeStep()) {
      for (int i = 0; i < rows.getColumnCount(); ++i) checksum.add(rows.getColumn(i));
      const auto text = [&](int i) { return rows.getColumn(i).getString(); };
      const auto optional = [&](int i) {
        return rows.getColumn(i).isNull() ? std::nullopt : std::optional(rows.getColumn(i).getDouble());
      };
      Row& row = all.emplace_back();
      row.body = text(1), row.t_s = optional(2), row.metric = text(3), row.unit = text(4);
      row.value = real_or_nan(rows.getColumn(5)), row.truth_bar = real_or_nan(rows.getColumn(6));
      row.status = status_from_string(text(7)), row.reason = text(8);
      row.spacing_m = optional(9), row.sound_speed_m_per_s = optional(10);
    }
    if (static_cast<std::int64_t>(all.size()) != select.getColumn(4).getInt64() ||
        checksum.value() != select.getColumn(5).getInt64())
      database.damaged("rows differ from their checksum");
    const std::string packed = compressed(pack_rows(all)), errors = compressed(blob_of(select.getColumn(3)));
    database.insert(kMeasured, {copied(select.getColumn(0)), copied(select.getColumn(1)), copied(select.getColumn(2)),
                                Blob{packed}, Blob{errors}});
  }
}

void migrate_timings(StoreDatabase& database) {
  SQLite::Statement select(*database.sql,
                           "SELECT hash, cell, status, reason, steps_taken, rate_evaluations, busy_ns, provenance "
                           "FROM old_timings");
  while (select.executeStep()) {
    std::vector<StoreValue> values;
    for (int i = 0; i < 8; ++i) values.push_back(copied(select.getColumn(i)));
    values.emplace_back(std::string());    // its host was not recorded
    values.emplace_back(std::int64_t{0});  // of native engines
    database.insert(kTimings, values);
  }
}

}  // namespace

// Keeps all entries under their old hashes. A damaged entry would get a new checksum, so all are verified first, and a
// damaged store is not brought up to date.
void migrate_store(StoreDatabase& database) {
  SQLite::Database& sql = *database.sql;
  for (const StoreTable& table : kOldTables) {
    if (const std::string wrong = table.counted ? database.read_keys(table) : ""; !wrong.empty())
      database.damaged(wrong);
    if (!database.damaged_keys(table).empty())
      database.damaged(std::string("an entry of `") + table.name + "` differs from its checksum");
  }
  for (const StoreTable* table : {&kMeasured, &kTimings})  // of the new tables, which have the same keys
    database.read_keys(*table);
  constexpr std::array same_direction{"provenances", "runs", "campaigns", "cells", "truths", "totals"};
  constexpr std::array changed{"series", "measured", "rows", "timings"};
  for (const char* name : same_direction) sql.exec(std::string("ALTER TABLE ") + name + " RENAME TO old_" + name);
  for (const char* name : changed) sql.exec(std::string("ALTER TABLE ") + name + " RENAME TO old_" + name);
  sql.exec(kStoreTablesSql);
  for (const char* name : same_direction) sql.exec(std::string("INSERT INTO ") + name + " SELECT * FROM old_" + name);
  migrate_series(database);
  migrate_measured(database);
  migrate_timings(database);
  for (const char* name : same_direction) sql.exec(std::string("DROP TABLE old_") + name);
  for (const char* name : changed) sql.exec(std::string("DROP TABLE old_") + name);
}

}  // namespace atwood
