// Verifies the checksum of every entry of a store, and names the damaged entries as far as their names can be read.
#include <algorithm>

#include "validation/study/process.hpp"
#include "validation/study/row_blob.hpp"
#include "validation/study/store_database.hpp"
#include "validation/study/study.hpp"

namespace atwood {
namespace {

// The name of an entry in messages: "cell kepler-e0.6, atwood/rk4, 960 steps".
std::string name_of(StoreDatabase& database, const StoreTable& table, const SQLite::Statement& entry) {
  const auto text = [&](int i) { return entry.getColumn(i).getString(); };
  std::string cell;
  if (&table == &kCells || &table == &kSeries) cell = text(0);
  else if (&table == &kMeasured || &table == &kTimings) cell = text(1);
  else if (&table == &kTruths) return "the truth of `" + text(1) + "`";
  else return "an entry of `" + std::string(table.name) + "`";
  const char* part = &table == &kCells      ? "the outcome"
                     : &table == &kSeries   ? "the recording"
                     : &table == &kMeasured ? "what was measured"
                                            : "the times";
  std::string name = "hash " + cell;
  SQLite::Statement& select = database.prepared("SELECT scenario, method, steps FROM cells WHERE hash=?");
  select.bind(1, cell);
  if (select.executeStep() && !select.getColumn(0).getString().empty())
    name = select.getColumn(0).getString() + ", " + select.getColumn(1).getString() + ", " +
           std::to_string(select.getColumn(2).getInt64()) + " steps";
  return std::string(part) + " of the cell " + name;
}

void check_table(StoreDatabase& database, const StoreTable& table, std::vector<std::string>& found) {
  SQLite::Statement entries(*database.sql, std::string("SELECT ") + table.columns + ", checksum FROM " + table.name);
  while (entries.executeStep()) {
    ValueChecksum checksum;
    for (int i = 0; i < table.count; ++i) checksum.add(entries.getColumn(i));
    if (entries.getColumn(table.count).getInt64() != checksum.value()) {
      found.push_back(name_of(database, table, entries) + " differs from its checksum");
      continue;
    }
    try {
      if (&table == &kMeasured) unpack_rows(expanded(blob_of(entries.getColumn(3))));
      if (&table == &kCells) {
        database.provenance(entries.getColumn(11).getString());
        if (!database.find(kSeries, entries.getColumn(0).getString())) throw StoreDamage("");
      }
      if (&table == &kTimings) database.provenance(entries.getColumn(7).getString());
    } catch (const StoreDamage&) {
      found.push_back(name_of(database, table, entries) + ": what belongs to it is damaged or has gone");
    } catch (const BadBlob&) {
      found.push_back(name_of(database, table, entries) + ": its rows are damaged");
    } catch (const std::invalid_argument&) {
      found.push_back(name_of(database, table, entries) + ": its rows are damaged");
    }
  }
}

}  // namespace

std::vector<std::string> Store::check() {
  std::vector<std::string> found;
  if (empty()) return found;
  const auto attempt = [&](const auto& work) {
    try {
      database_->guarded(work);
    } catch (const std::runtime_error& error) {
      // A damaged file fails every table with the same message.
      if (std::find(found.begin(), found.end(), error.what()) == found.end()) found.emplace_back(error.what());
    }
  };
  attempt([&] {
    SQLite::Statement check(*database_->sql, "PRAGMA integrity_check(20)");
    while (check.executeStep()) {
      const std::string line = check.getColumn(0).getString();
      if (line != "ok") found.push_back("SQLite's check: " + line);
    }
  });
  for (const StoreTable* table : kStoreTables) {
    attempt([&] {
      if (const std::string wrong = table->counted ? database_->read_keys(*table) : ""; !wrong.empty())
        found.push_back(wrong);
    });
    attempt([&] { check_table(*database_, *table, found); });
  }
  return found;
}

std::vector<std::string> check_store(const std::string& store_path) {
  try {
    Store store(store_path, Store::Mode::check);
    std::vector<std::string> found = store.check();
    for (std::string& line : found) line = printable(line);  // it may repeat bytes of a damaged file
    return found;
  } catch (const StoreOfAnother&) {
    throw;
  } catch (const std::runtime_error& error) {
    return {error.what()};
  }
}

}  // namespace atwood
