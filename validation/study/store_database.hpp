// Internals of the store: the SQLite file, its lock, statements and checksums. Included by store*.cpp only.
#pragma once

#include <SQLiteCpp/SQLiteCpp.h>

#include <cstdint>
#include <initializer_list>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "validation/study/key_table.hpp"
#include "validation/study/recording_blob.hpp"
#include "validation/study/store.hpp"
#include "validation/study/store_schema.hpp"

namespace atwood {

struct Blob {
  std::string_view bytes;
};
// A value as SQLite stores it; NaN as NULL.
using StoreValue = std::variant<std::nullptr_t, std::int64_t, double, std::string, Blob>;

// A checksum of values in order, the same whether they are written or read.
class ValueChecksum {
 public:
  ValueChecksum();
  ~ValueChecksum();
  ValueChecksum(const ValueChecksum&) = delete;
  ValueChecksum& operator=(const ValueChecksum&) = delete;
  void add(const StoreValue& value);
  void add(const SQLite::Column& column);
  std::int64_t value() const;
  void restart();  // as new, for the next entry

 private:
  void add(char kind, std::string_view bytes);
  void add_real(double value);
  struct State;
  std::string few_;               // what was added, as long as it is short
  std::unique_ptr<State> state_;  // of more; null: all is in few_
};

struct KeySet {
  KeyTable<> keys;
  std::uint64_t sum = 0;  // of their checksums
  bool contains(const std::string& key) const { return keys.contains(key_sum(key)); }
};

struct StoreDatabase {
  std::string path;
  std::string network_file_system = {};  // "NFS"; set by open_for_writing
  int lock = -1;  // held as long as the database is open, and closed after it: closing any descriptor of a file
                  // drops the locks that SQLite holds on it
  bool made = false;
  bool empty = false;  // no tables yet, and opened for reading
  std::unique_ptr<SQLite::Database> sql;
  std::mutex mutex;
  std::map<std::string, std::unique_ptr<SQLite::Statement>> statements;
  std::vector<SQLite::Statement*> in_use;  // statements that the guarded work has prepared
  std::map<const StoreTable*, KeySet>
      keys;  // of counted tables; where the store is only read, of those that were asked
  struct Change {
    const StoreTable* table;
    KeySum key;
    bool added;
  };
  std::vector<Change> changes;  // changes of keys by the present transaction
  std::map<std::string, Provenance> provenances;

  ~StoreDatabase();

  // ---- opening (store_database.cpp) ----
  void open_for_writing();
  void open_for_reading(bool count_keys);
  void open_new();  // for `merge`: without a journal, over what a killed program left
  void remove_new_store();
  bool is_current() { return version() == kStoreSchema; }

  std::uint64_t bytes();  // of the database's pages

  // ---- failures ----
  [[noreturn]] void fail(const std::string& what) const;
  [[noreturn]] void fail(const SQLite::Exception& error) const;
  [[noreturn]] void damaged(const std::string& what) const;  // the whole store
  std::string why_not_written(int system, const std::string& otherwise) const;

  // ---- entries; the caller holds the lock ----
  SQLite::Statement& prepared(const std::string& text);  // ready to bind
  void forget_statements() {
    in_use.clear();
    statements.clear();
  }
  // The entry with this key, its checksum verified, its columns in the table's order; null: there is none.
  SQLite::Statement* find(const StoreTable& table, const std::string& key);
  void insert(const StoreTable& table, std::span<const StoreValue> values);
  void insert(const StoreTable& table, std::initializer_list<StoreValue> values) {
    insert(table, std::span(values.begin(), values.size()));
  }
  void erase(const StoreTable& table, const std::string& key);
  std::vector<std::string> damaged_keys(const StoreTable& table);  // of entries whose checksum is wrong
  std::string provenance_hash(const Provenance& provenance);       // stores it if it is new
  Provenance provenance(const std::string& hash);
  void insert_measured(const std::string& key, const std::string& cell_hash, const MeasuredRecord& record);
  // Compares number and sum of the keys with those in `totals`, and keeps the keys. Empty, or what is wrong.
  std::string read_keys(const StoreTable& table, bool keep = true);
  void write_total(const StoreTable& table);
  void write_totals();  // of tables whose keys the present transaction has changed
  // Makes all tables again from a scan: where the order of a table or an index is damaged, entries cannot be found or
  // deleted by key. Inside a transaction; once per opening.
  void rebuild();
  bool rebuilt = false;

  // Runs `work` under the lock; its failures become messages.
  template <class Work> auto guarded(Work work) {
    const std::lock_guard<std::mutex> held(mutex);
    // Resets statements: one that is stepped halfway keeps its snapshot, and the log could not shrink.
    struct Resetter {
      StoreDatabase& database;
      ~Resetter() {
        for (SQLite::Statement* statement : database.in_use) statement->tryReset();
        database.in_use.clear();
      }
    } resetter{*this};
    try {
      return work();
    } catch (const SQLite::Exception& error) {
      fail(error);
    } catch (const BadBlob& error) {
      throw StoreDamage("store " + path + ": " + error.what());
    } catch (const std::invalid_argument& error) {
      throw StoreDamage("store " + path + ": " + error.what());
    }
  }
  // The same in one transaction.
  template <class Work> void written(Work work) {
    guarded([&] {
      changes.clear();
      try {
        SQLite::Transaction transaction(*sql);
        work();
        write_totals();
        transaction.commit();
      } catch (...) {
        undo_changes();
        throw;
      }
    });
  }

 private:
  void take_lock();
  int version();
  void check_identity();
  void check_tables();
  void count_key(const StoreTable& table, const std::string& key, bool added);
  void set_key(const StoreTable& table, const KeySum& key, bool there);
  void undo_changes();
};

// store_schema.cpp: from schema 3, inside a transaction of the caller's.
void migrate_store(StoreDatabase& database);

std::string blob_of(const SQLite::Column& column);
double real_or_nan(const SQLite::Column& column);

}  // namespace atwood
