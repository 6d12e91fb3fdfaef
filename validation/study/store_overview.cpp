#include "validation/study/store_overview.hpp"

#include <SQLiteCpp/SQLiteCpp.h>

#include "validation/study/content_hash.hpp"
#include "validation/study/store_database.hpp"

namespace atwood {

StoreOverview::Key StoreOverview::key_of(const std::string& text) { return {checksum(text), checksum("\n" + text)}; }

const StoreOverview::Run* StoreOverview::run(const std::string& cell_hash) const {
  const auto found = runs_.find(key_of(cell_hash));
  return found == runs_.end() ? nullptr : &found->second;
}

bool StoreOverview::measured_from(const std::string& key, const std::string& basis) const {
  const auto found = measured_.find(key_of(key));
  return found != measured_.end() && found->second == checksum(basis);
}

void StoreOverview::add_run(const std::string& cell_hash, Run run) { runs_[key_of(cell_hash)] = run; }

void StoreOverview::add_measured(const std::string& key, const std::string& basis) {
  measured_[key_of(key)] = checksum(basis);
}

namespace {

// Calls `each` with every entry. False: a checksum is wrong, or an entry is not found by its key. A table with rows
// numbered by SQLite is gone through twice: as it lies in the file, and by the index of its keys.
template <class Each> bool all_right(StoreDatabase& database, const StoreTable& table, bool numbered, Each each) {
  const std::string columns = table.columns, key = columns.substr(0, columns.find(','));
  SQLite::Statement entries(*database.sql, "SELECT " + columns + ", checksum FROM " + table.name);
  std::size_t count = 0;
  std::string before;
  while (entries.executeStep()) {
    ValueChecksum sum;
    for (int i = 0; i < table.count; ++i) sum.add(entries.getColumn(i));
    if (entries.getColumn(table.count).getInt64() != sum.value()) return false;
    if (!numbered) {
      std::string now = entries.getColumn(0).getString();
      if (count > 0 && !(before < now)) return false;
      before = std::move(now);
    }
    ++count;
    each(entries);
  }
  if (!numbered) return true;
  SQLite::Statement by_key(*database.sql, "SELECT " + key + ", checksum FROM " + table.name +
                                              " INDEXED BY sqlite_autoindex_" + table.name + "_1 WHERE " + key +
                                              ">='' ORDER BY " + key);
  std::size_t found = 0;
  while (by_key.executeStep()) {
    std::string now = by_key.getColumn(0).getString();
    if (found > 0 && !(before < now)) return false;
    before = std::move(now);
    ++found;
  }
  return found == count;
}

}  // namespace

bool Store::has(const CellKeys& cell) {
  return database_->guarded([&] {
    return database_->keys[&kCells].keys.contains(cell.accuracy) &&
           database_->keys[&kMeasured].keys.contains(cell.measured);
  });
}

std::unordered_set<std::string> Store::not_ok() {
  return database_->guarded([&] {
    std::unordered_set<std::string> keys;
    for (const char* table : {"cells", "timings"}) {
      SQLite::Statement some(*database_->sql, std::string("SELECT hash FROM ") + table + " WHERE status<>'ok'");
      while (some.executeStep()) keys.insert(some.getColumn(0).getString());
    }
    return keys;
  });
}

StoreOverview Store::overview() {
  StoreOverview all;
  const auto text = [](const SQLite::Statement& entry, int i) { return entry.getColumn(i).getString(); };
  const auto nothing = [](const SQLite::Statement&) {};
  try {
    database_->guarded([&] {
      all.whole = all_right(*database_, kCells, false,
                            [&](const SQLite::Statement& entry) {
                              all.add_run(text(entry, 0),
                                          {status_from_string(text(entry, 4)), entry.getColumn(10).getInt64() != 0,
                                           entry.getColumn(9).getDouble()});
                            }) &&
                  all_right(*database_, kTimings, false, nothing) && all_right(*database_, kSeries, true, nothing) &&
                  all_right(*database_, kMeasured, true,
                            [&](const SQLite::Statement& entry) { all.add_measured(text(entry, 0), text(entry, 2)); });
      for (const char* lost :
           {"SELECT 1 FROM cells WHERE NOT EXISTS (SELECT 1 FROM series WHERE series.hash=cells.hash) LIMIT 1",
            "SELECT 1 FROM cells WHERE provenance NOT IN (SELECT hash FROM provenances) LIMIT 1",
            "SELECT 1 FROM timings WHERE provenance NOT IN (SELECT hash FROM provenances) LIMIT 1"}) {
        if (all.whole && SQLite::Statement(*database_->sql, lost).executeStep()) all.whole = false;
      }
    });
  } catch (const std::runtime_error&) {  // the cells one by one say what cannot be read
    all.whole = false;
  }
  return all;
}

}  // namespace atwood
