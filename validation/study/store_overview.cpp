#include "validation/study/store_overview.hpp"

#include <SQLiteCpp/SQLiteCpp.h>

#include <algorithm>
#include <optional>
#include <vector>

#include "validation/study/content_hash.hpp"
#include "validation/study/store_database.hpp"

namespace atwood {

bool StoreOverview::measured_from(const std::string& key, const std::string& basis) const {
  const std::uint64_t* found = measured_.find(key_sum(key));
  return found != nullptr && *found == checksum(basis);
}

namespace {

// Whether the pages of a table's tree are in the order by which SQLite searches them.
bool index_order_ok(StoreDatabase& database, const StoreTable& table) {
  SQLite::Statement check(*database.sql, std::string("PRAGMA quick_check('") + table.name + "')");
  return check.executeStep() && check.getColumn(0).getString() == "ok";
}

// Sums over the keys of a table; those of a table and of its index are equal.
struct KeySums {
  std::size_t count = 0;
  std::uint64_t keys = 0, places = 0;  // places: of the keys with the numbers of their rows
  bool operator==(const KeySums&) const = default;
};

// The index of the keys of a table with rows numbered by SQLite; nullopt where it is not in order.
std::optional<KeySums> sums_of_index(StoreDatabase& database, const StoreTable& table, const std::string& key) {
  SQLite::Statement entries(*database.sql, "SELECT " + key + ", rowid FROM " + table.name +
                                               " INDEXED BY sqlite_autoindex_" + table.name + "_1 WHERE " + key +
                                               ">='' ORDER BY " + key);
  KeySums sums;
  std::string before;
  while (entries.executeStep()) {
    if (!entries.getColumn(0).isText()) return std::nullopt;  // the same bytes as a blob are not found as text
    std::string now = entries.getColumn(0).getString();
    if (sums.count > 0 && !(before < now)) return std::nullopt;
    ++sums.count;
    sums.keys += checksum(now);
    sums.places += checksum(now, static_cast<std::uint64_t>(entries.getColumn(1).getInt64()));
    before.swap(now);
  }
  return sums;
}

// Calls `each` with every entry. nullopt: a checksum is wrong, or an entry is not found by its key. Of a table with
// rows numbered by SQLite, the keys lie in an index, which must name the row of each.
template <class Each>
std::optional<KeySums> check_table(StoreDatabase& database, const StoreTable& table, bool numbered, Each each) {
  if (numbered && !index_order_ok(database, table)) return std::nullopt;
  const std::string columns = table.columns, key = columns.substr(0, columns.find(','));
  SQLite::Statement entries(*database.sql,
                            "SELECT " + columns + ", checksum" + (numbered ? ", rowid" : "") + " FROM " + table.name);
  KeySums sums;
  ValueChecksum sum;
  std::string before;
  while (entries.executeStep()) {
    sum.restart();
    for (int i = 0; i < table.count; ++i) sum.add(entries.getColumn(i));
    if (entries.getColumn(table.count).getInt64() != sum.value()) return std::nullopt;
    std::string now = entries.getColumn(0).getString();
    if (!numbered && sums.count > 0 && !(before < now)) return std::nullopt;
    ++sums.count;
    sums.keys += checksum(now);
    if (numbered)
      sums.places += checksum(now, static_cast<std::uint64_t>(entries.getColumn(table.count + 1).getInt64()));
    each(entries, now);
    before.swap(now);
  }
  if (numbered && sums_of_index(database, table, key) != sums) return std::nullopt;
  return sums;
}

// Whether the provenance of every cell and time is there, and, unless `recorded`, the recording of every cell.
bool has_all_parts(StoreDatabase& database, bool recorded) {
  std::vector<const char*> lost{"SELECT 1 FROM cells WHERE provenance NOT IN (SELECT hash FROM provenances) LIMIT 1",
                                "SELECT 1 FROM timings WHERE provenance NOT IN (SELECT hash FROM provenances) LIMIT 1"};
  if (!recorded)
    lost.push_back("SELECT 1 FROM cells WHERE NOT EXISTS (SELECT 1 FROM series WHERE series.hash=cells.hash) LIMIT 1");
  return std::none_of(lost.begin(), lost.end(),
                      [&](const char* text) { return SQLite::Statement(*database.sql, text).executeStep(); });
}

}  // namespace

bool Store::has(const CellKeys& cell) {
  return database_->guarded([&] {
    return database_->keys[&kCells].contains(cell.accuracy) && database_->keys[&kMeasured].contains(cell.measured);
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
  const auto ignore = [](const SQLite::Statement&, const std::string&) {};
  try {
    database_->guarded([&] {
      const auto cells =
          check_table(*database_, kCells, false, [&](const SQLite::Statement& entry, const std::string& key) {
            all.add_run(key, {status_from_string(text(entry, 4)), entry.getColumn(10).getInt64() != 0,
                              entry.getColumn(9).getDouble()});
          });
      const auto recordings = cells ? check_table(*database_, kSeries, true, ignore) : std::nullopt;
      all.whole = recordings && check_table(*database_, kTimings, false, ignore) &&
                  check_table(*database_, kMeasured, true,
                              [&](const SQLite::Statement& entry, const std::string& key) {
                                all.add_measured(key, text(entry, 2));
                              }) &&
                  has_all_parts(*database_, cells->count == recordings->count && cells->keys == recordings->keys);
    });
  } catch (const std::runtime_error&) {  // reading the cells one by one names what is damaged
    all.whole = false;
  }
  return all;
}

}  // namespace atwood
