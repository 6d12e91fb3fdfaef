// Entries of the store's tables: found and verified, inserted with their checksums, counted.
#include <sqlite3.h>

#include <set>

#include "validation/study/content_hash.hpp"
#include "validation/study/row_blob.hpp"
#include "validation/study/store_database.hpp"

namespace atwood {
namespace {

std::string key_column(const StoreTable& table) {
  const std::string columns = table.columns;
  return columns.substr(0, columns.find(','));
}

void bind(SQLite::Statement& statement, int index, const StoreValue& value) {
  if (const auto* whole = std::get_if<std::int64_t>(&value)) statement.bind(index, *whole);
  else if (const auto* real = std::get_if<double>(&value)) statement.bind(index, *real);
  else if (const auto* text = std::get_if<std::string>(&value)) statement.bind(index, *text);
  else if (const auto* blob = std::get_if<Blob>(&value)) {
    if (blob->bytes.size() > 1'000'000'000) throw SQLite::Exception("", SQLITE_TOOBIG);
    statement.bindNoCopy(index, blob->bytes.empty() ? "" : blob->bytes.data(), static_cast<int>(blob->bytes.size()));
  } else {
    statement.bind(index);
  }
}

std::string placeholders(int count) {
  std::string text = "?";
  for (int i = 1; i < count; ++i) text += ",?";
  return text;
}

}  // namespace

SQLite::Statement& StoreDatabase::prepared(const std::string& text) {
  auto found = statements.find(text);
  if (found == statements.end())  // stored only after it was made: that may throw
    found = statements.emplace(text, std::make_unique<SQLite::Statement>(*sql, text)).first;
  found->second->reset();
  found->second->clearBindings();
  in_use.push_back(found->second.get());
  return *found->second;
}

SQLite::Statement* StoreDatabase::find(const StoreTable& table, const std::string& key) {
  SQLite::Statement& select = prepared(std::string("SELECT ") + table.columns + ", checksum FROM " + table.name +
                                       " WHERE " + key_column(table) + "=?");
  select.bind(1, key);
  if (!select.executeStep()) {
    if (table.counted && !keys.contains(&table)) read_keys(table);
    if (table.counted && keys[&table].contains(key))
      throw StoreDamage("store " + path + ": an entry of `" + table.name + "` cannot be found again");
    return nullptr;
  }
  ValueChecksum checksum;
  for (int i = 0; i < table.count; ++i) checksum.add(select.getColumn(i));
  if (select.getColumn(0).getString() != key || select.getColumn(table.count).getInt64() != checksum.value())
    throw StoreDamage("store " + path + ": an entry of `" + table.name + "` differs from its checksum");
  return &select;
}

void StoreDatabase::insert(const StoreTable& table, std::span<const StoreValue> values) {
  SQLite::Statement& statement = prepared(std::string("INSERT OR REPLACE INTO ") + table.name + "(" + table.columns +
                                          ", checksum) VALUES(" + placeholders(table.count + 1) + ")");
  ValueChecksum checksum;
  int index = 0;
  for (const StoreValue& value : values) {
    checksum.add(value);
    bind(statement, ++index, value);
  }
  statement.bind(++index, checksum.value());
  statement.exec();
  count_key(table, std::get<std::string>(values.front()), true);
}

void StoreDatabase::erase(const StoreTable& table, const std::string& key) {
  SQLite::Statement& statement =
      prepared(std::string("DELETE FROM ") + table.name + " WHERE " + key_column(table) + "=?");
  statement.bind(1, key);
  statement.exec();
  count_key(table, key, false);
}

std::vector<std::string> StoreDatabase::damaged_keys(const StoreTable& table) {
  std::vector<std::string> found;
  SQLite::Statement entries(*sql, std::string("SELECT ") + table.columns + ", checksum FROM " + table.name);
  ValueChecksum sum;
  while (entries.executeStep()) {
    sum.restart();
    for (int i = 0; i < table.count; ++i) sum.add(entries.getColumn(i));
    if (entries.getColumn(table.count).getInt64() != sum.value()) found.push_back(entries.getColumn(0).getString());
  }
  return found;
}

// ---- the keys of a table ------------------------------------------------------------------------------------------
void StoreDatabase::set_key(const StoreTable& table, const KeySum& key, bool there) {
  KeySet& set = keys[&table];
  if (there && set.keys.insert(key).second) set.sum += key.first;
  else if (!there && set.keys.erase(key)) set.sum -= key.first;
}

void StoreDatabase::count_key(const StoreTable& table, const std::string& key, bool added) {
  if (!table.counted || keys[&table].contains(key) == added) return;
  set_key(table, key_sum(key), added);
  changes.push_back({&table, key_sum(key), added});
}

void StoreDatabase::write_total(const StoreTable& table) {
  SQLite::Statement& total = prepared("INSERT OR REPLACE INTO totals(name, entries, key_sum) VALUES(?,?,?)");
  total.bind(1, table.name);
  total.bind(2, static_cast<std::int64_t>(keys[&table].keys.size()));
  total.bind(3, static_cast<std::int64_t>(keys[&table].sum));
  total.exec();
}

void StoreDatabase::write_totals() {
  std::set<const StoreTable*> changed;
  for (const Change& change : changes) changed.insert(change.table);
  for (const StoreTable* table : changed) write_total(*table);
}

void StoreDatabase::undo_changes() {
  for (auto change = changes.rbegin(); change != changes.rend(); ++change)
    set_key(*change->table, change->key, !change->added);
  changes.clear();
}

std::string StoreDatabase::read_keys(const StoreTable& table, bool keep) {
  KeySet set;
  std::int64_t found = 0;
  SQLite::Statement select(*sql, "SELECT " + key_column(table) + " FROM " + table.name);
  while (select.executeStep()) {
    const KeySum key = key_sum(select.getColumn(0).getString());
    if (keep && !set.keys.insert(key).second) continue;
    set.sum += key.first;
    ++found;
  }
  SQLite::Statement total(*sql, "SELECT entries, key_sum FROM totals WHERE name=?");
  total.bind(1, table.name);
  const bool counted = total.executeStep();
  const std::int64_t expected = counted ? total.getColumn(0).getInt64() : 0;
  const auto sum = static_cast<std::uint64_t>(counted ? total.getColumn(1).getInt64() : 0);
  const bool same_sum = set.sum == sum;
  if (keep) keys[&table] = std::move(set);
  if (found != expected)
    return std::to_string(found) + " entries of `" + table.name + "`, where " + std::to_string(expected) +
           " were written";
  return same_sum ? "" : std::string("the key of an entry of `") + table.name + "` has changed";
}

// A scan finds every entry also where the order is damaged. Without LIMIT, SQLite would copy a table page by page, with
// its damaged order.
void StoreDatabase::rebuild() {
  if (rebuilt) return;
  rebuilt = true;
  forget_statements();
  std::vector<std::string> names{"totals"};
  for (const StoreTable* table : kStoreTables) names.emplace_back(table->name);
  for (const std::string& name : names) sql->exec("ALTER TABLE " + name + " RENAME TO old_" + name);
  sql->exec(kStoreTablesSql);
  for (const std::string& name : names) {
    sql->exec("INSERT OR IGNORE INTO " + name + " SELECT * FROM old_" + name + " LIMIT -1");
    sql->exec("DROP TABLE old_" + name);
  }
  for (const StoreTable* table : kStoreTables) {
    if (!table->counted || read_keys(*table).empty()) continue;  // else ignored entries are no longer counted
    write_total(*table);
  }
}

// ---- provenances and rows -----------------------------------------------------------------------------------------
namespace {

std::string hash_of(const Provenance& p) {
  return content_hash(
      {"provenance", p.engine_version, p.commit, p.compiler, p.flags, p.cpu, p.cpu_features, p.libm, p.run_id});
}

}  // namespace

std::string StoreDatabase::provenance_hash(const Provenance& p) {
  const std::string hash = hash_of(p);
  if (provenances.contains(hash)) return hash;
  insert(kProvenances,
         {hash, p.engine_version, p.commit, p.compiler, p.flags, p.cpu, p.cpu_features, p.libm, p.run_id});
  return hash;
}

Provenance StoreDatabase::provenance(const std::string& hash) {
  if (const auto known = provenances.find(hash); known != provenances.end()) return known->second;
  SQLite::Statement* found = find(kProvenances, hash);
  if (!found) throw StoreDamage("store " + path + ": an entry of `provenances` cannot be found again");
  const auto text = [&](int i) { return found->getColumn(i).getString(); };
  Provenance p{text(1), text(2), text(3), text(4), text(5), text(8), text(6), text(7)};
  return provenances[hash] = p;
}

void StoreDatabase::insert_measured(const std::string& key, const std::string& cell_hash,
                                    const MeasuredRecord& record) {
  const std::string rows = compressed(pack_rows(record.rows)),
                    errors = compressed(pack_series_and_picture(record.series, record.picture));
  insert(kMeasured, {key, cell_hash, record.basis, Blob{rows}, Blob{errors}});
}

}  // namespace atwood
