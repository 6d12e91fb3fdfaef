#include "validation/study/store_schema.hpp"

#include <sqlite3.h>

#include "validation/study/content_hash.hpp"
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
CREATE TABLE series(hash TEXT PRIMARY KEY, samples BLOB NOT NULL, events BLOB NOT NULL, checksum INTEGER NOT NULL);
CREATE TABLE measured(key TEXT PRIMARY KEY, cell TEXT NOT NULL, basis TEXT NOT NULL, errors BLOB NOT NULL,
  row_count INTEGER NOT NULL, rows_checksum INTEGER NOT NULL, checksum INTEGER NOT NULL);
CREATE TABLE rows(key TEXT, ordinal INTEGER, body TEXT, t_s REAL, metric TEXT, unit TEXT, value REAL, truth_bar REAL,
  status TEXT, reason TEXT, spacing_m REAL, sound_speed_m_per_s REAL, PRIMARY KEY(key, ordinal)) WITHOUT ROWID;
CREATE TABLE timings(hash TEXT PRIMARY KEY, cell TEXT NOT NULL, status TEXT NOT NULL, reason TEXT NOT NULL,
  steps_taken INTEGER, rate_evaluations INTEGER, busy_ns BLOB NOT NULL, provenance TEXT NOT NULL,
  checksum INTEGER NOT NULL) WITHOUT ROWID;
CREATE TABLE truths(hash TEXT PRIMARY KEY, scenario TEXT NOT NULL, status TEXT NOT NULL, reason TEXT NOT NULL,
  source TEXT, note TEXT, condition REAL, samples BLOB NOT NULL, bars BLOB NOT NULL, events BLOB NOT NULL,
  event_bars BLOB NOT NULL, checksum INTEGER NOT NULL);
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

// Schema 2 numbered its provenances.
std::map<std::int64_t, std::string> migrate_provenances(StoreDatabase& database) {
  std::map<std::int64_t, std::string> hashes;
  SQLite::Statement select(*database.sql,
                           "SELECT id, engine_version, commit_id, compiler, flags, cpu, run_id FROM old_provenances");
  while (select.executeStep()) {
    const auto text = [&](int i) { return select.getColumn(i).getString(); };
    hashes[select.getColumn(0).getInt64()] =
        database.provenance_hash({text(1), text(2), text(3), text(4), text(5), text(6)});
  }
  return hashes;
}

void migrate_measured(StoreDatabase& database) {
  database.sql->exec(
      "INSERT INTO rows SELECT key, ordinal, body, t_s, metric, unit, value, truth_bar, status, reason, NULL, NULL "
      "FROM old_rows");
  SQLite::Statement select(*database.sql, "SELECT key, basis, errors FROM old_measured");
  SQLite::Statement rows(*database.sql,
                         std::string("SELECT ") + kRowColumns + " FROM rows WHERE key=? ORDER BY ordinal");
  while (select.executeStep()) {
    rows.reset();
    rows.bind(1, select.getColumn(0).getString());
    ValueChecksum checksum;
    std::int64_t count = 0;
    for (; rows.executeStep(); ++count)
      for (int i = 0; i < kRowColumnCount; ++i) checksum.add(rows.getColumn(i));
    database.insert(kMeasured, {copied(select.getColumn(0)), std::string(), copied(select.getColumn(1)),
                                copied(select.getColumn(2)), count, checksum.value()});
  }
}

}  // namespace

// Keeps all entries under their old hashes, with checksums of their present content.
void migrate_store(StoreDatabase& database) {
  SQLite::Database& sql = *database.sql;
  for (const char* name : {"provenances", "cells", "series", "measured", "rows", "timings", "truths"})
    sql.exec(std::string("ALTER TABLE ") + name + " RENAME TO old_" + name);
  sql.exec(kStoreTablesSql);
  const std::map<std::int64_t, std::string> provenances = migrate_provenances(database);
  const auto provenance = [&](const SQLite::Column& column) {
    const auto found = provenances.find(column.getInt64());
    return found == provenances.end() ? database.provenance_hash({}) : found->second;
  };
  const std::string none;
  {
    SQLite::Statement cells(sql,
                            "SELECT hash, status, reason, steps_taken, rate_evaluations, wall_ns, limit_s, "
                            "killed_from_outside, provenance FROM old_cells");
    const auto at = [&](int i) { return copied(cells.getColumn(i)); };
    while (cells.executeStep())
      database.insert(kCells, {at(0), none, none, std::int64_t{0}, at(1), at(2), at(3), at(4), at(5), at(6), at(7),
                               provenance(cells.getColumn(8))});
    SQLite::Statement series(sql, "SELECT hash, samples, events FROM old_series");
    while (series.executeStep())
      database.insert(kSeries, {copied(series.getColumn(0)), copied(series.getColumn(1)), copied(series.getColumn(2))});
    migrate_measured(database);
    SQLite::Statement timings(
        sql, "SELECT hash, status, reason, steps_taken, rate_evaluations, busy_ns, provenance FROM old_timings");
    const auto of = [&](int i) { return copied(timings.getColumn(i)); };
    while (timings.executeStep())
      database.insert(kTimings, {of(0), none, of(1), of(2), of(3), of(4), of(5), provenance(timings.getColumn(6))});
    SQLite::Statement truths(sql,
                             "SELECT hash, status, reason, source, note, condition, samples, bars, events, event_bars "
                             "FROM old_truths");
    const auto value = [&](int i) { return copied(truths.getColumn(i)); };
    while (truths.executeStep())
      database.insert(kTruths, {value(0), none, value(1), value(2), value(3), value(4), value(5), value(6), value(7),
                                value(8), value(9)});
  }
  for (const char* name : {"provenances", "cells", "series", "measured", "rows", "timings", "truths"})
    sql.exec(std::string("DROP TABLE old_") + name);
}

}  // namespace atwood
