// Every table of every store is read once in the order of its keys, all stores side by side, so that the new store is
// written in order too: N log N in the number of entries. Of the entries, memory holds the keys of the new store's
// counted tables and the names of cells that several stores have.
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <map>
#include <optional>
#include <set>
#include <unordered_map>

#include "scene/files.hpp"
#include "validation/study/merge.hpp"
#include "validation/study/process.hpp"
#include "validation/study/row_blob.hpp"
#include "validation/study/store_database.hpp"

namespace atwood {
namespace {

constexpr std::size_t kMaxConflicts = 20;

// A copy of an entry.
using Entry = std::vector<std::variant<std::nullptr_t, std::int64_t, double, std::string>>;

std::string text_of(const Entry& entry, int i) { return std::get<std::string>(entry[static_cast<std::size_t>(i)]); }
std::int64_t whole_of(const Entry& entry, int i) { return std::get<std::int64_t>(entry[static_cast<std::size_t>(i)]); }

// Reads an input; its failures name it. Those of the output name the output.
template <class Work> void of_input(const StoreDatabase& database, Work work) {
  try {
    work();
  } catch (const SQLite::Exception& error) {
    database.fail(error);
  } catch (const BadBlob& error) {
    throw StoreDamage("store " + database.path + ": " + error.what());
  } catch (const std::invalid_argument& error) {
    throw StoreDamage("store " + database.path + ": " + error.what());
  }
}

// One table of one store, entry by entry in the order of keys.
class Entries {
 public:
  Entries(StoreDatabase& database, const StoreTable& table) : database_(database), table_(table) {
    const std::string columns = table.columns;
    of_input(database, [&] {
      select_.emplace(*database.sql, "SELECT " + columns + ", checksum FROM " + table.name + " ORDER BY " +
                                         columns.substr(0, columns.find(',')));
    });
    next();
  }
  bool ended() const { return ended_; }
  const std::string& key() const { return key_; }
  const Entry& entry() const { return entry_; }

  void next() {
    try {
      ended_ = !select_->executeStep();
    } catch (const SQLite::Exception& error) {
      if (error.getErrorCode() != SQLITE_CORRUPT) database_.fail(error);
      damaged("cannot be read after " + (key_.empty() ? "its beginning" : "the entry " + key_));
    }
    if (ended_) return;
    const std::string before = std::move(key_);
    ValueChecksum sum;
    entry_.clear();
    for (int i = 0; i < table_.count; ++i) {
      const SQLite::Column column = select_->getColumn(i);
      sum.add(column);
      if (column.isInteger()) entry_.emplace_back(std::int64_t{column.getInt64()});
      else if (column.isFloat()) entry_.emplace_back(column.getDouble());
      else if (column.isNull()) entry_.emplace_back(nullptr);
      else entry_.emplace_back(column.isBlob() ? blob_of(column) : column.getString());
    }
    const auto* key = std::get_if<std::string>(&entry_.front());
    key_ = key ? *key : "";
    if (select_->getColumn(table_.count).getInt64() != sum.value() || !key)
      throw StoreDamage("store " + database_.path + ": the entry " + printable(key_) + " of `" + table_.name +
                        "` differs from its checksum; the next run of its shard measures it again");
    if (key_ <= before && !before.empty())
      damaged("is out of order: the entry " + key_ + " follows the entry " + before);
  }

 private:
  [[noreturn]] void damaged(const std::string& what) const {
    throw StoreDamage("store " + database_.path + ": its table `" + table_.name + "` " + printable(what) +
                      "; the next run of its shard mends it, or says to move the file away");
  }

  StoreDatabase& database_;
  const StoreTable& table_;
  std::optional<SQLite::Statement> select_;
  Entry entry_;
  std::string key_;
  bool ended_ = false;
};

struct Found {
  std::size_t store;
  Entry entry;
};

bool is_blob(const StoreTable& table, int i) {
  if (&table == &kSeries) return i == 1 || i == 2;
  if (&table == &kMeasured) return i == 3 || i == 4;
  if (&table == &kTimings) return i == 6;
  if (&table == &kTruths) return i >= 7;
  return &table == &kPlans && i == 2;
}

class Merge {
 public:
  Merge(const std::vector<std::string>& paths, StoreDatabase& out) : out_(out) {
    for (const std::string& path : paths) {
      { const Store upgraded(path, Store::Mode::read); }
      stores_.push_back(std::make_unique<StoreDatabase>());
      StoreDatabase& store = *stores_.back();
      store.path = path;
      of_input(store, [&] {
        store.open_for_reading(true);  // an entry that has gone is noticed
        store.keys.clear();
        store.sql->exec("PRAGMA cache_size=-16384");
      });
    }
  }

  Merged merge() {
    for (const auto& store : stores_)
      if (store->empty)
        throw InputError(store->path + ": an empty store; was it copied without its write-ahead log, " + store->path +
                         "-wal? Leave it out where no run has written to it");
    require_same_costs();
    for (const StoreTable* table : kStoreTables) copy(*table);
    find_absent();
    merged_.cells = out_.keys[&kCells].keys.size();
    return std::move(merged_);
  }

 private:
  void copy(const StoreTable& table) {
    std::vector<std::unique_ptr<Entries>> all;
    for (const auto& store : stores_) all.push_back(std::make_unique<Entries>(*store, table));
    std::set<std::pair<std::string, std::size_t>> heads;  // of the stores that have more entries
    for (std::size_t i = 0; i < all.size(); ++i)
      if (!all[i]->ended()) heads.emplace(all[i]->key(), i);
    while (!heads.empty()) {
      const std::string key = heads.begin()->first;
      std::vector<Found> same;
      while (!heads.empty() && heads.begin()->first == key) {
        const std::size_t store = heads.begin()->second;
        heads.erase(heads.begin());
        same.push_back({store, all[store]->entry()});
        all[store]->next();
        if (!all[store]->ended()) heads.emplace(all[store]->key(), store);
      }
      insert(table, joined(table, same));
    }
  }

  void insert(const StoreTable& table, const Entry& entry) {
    std::vector<StoreValue> values;
    for (int i = 0; i < table.count; ++i) {
      const auto& value = entry[static_cast<std::size_t>(i)];
      if (is_blob(table, i)) values.emplace_back(Blob{std::get<std::string>(value)});
      else std::visit([&](const auto& one) { values.emplace_back(one); }, value);
    }
    out_.insert(table, values);
  }

  // One entry for those of several stores; differences that must not be are added to the conflicts.
  Entry joined(const StoreTable& table, std::vector<Found>& same) {
    if (same.size() == 1) return std::move(same.front().entry);
    if (&table == &kCells) return joined_cells(same);
    if (&table == &kSeries) return joined_series(same);
    if (&table == &kMeasured) return joined_measured(same);
    if (&table == &kTimings) return joined_timings(same);
    if (&table == &kTruths) return joined_truths(same);
    if (&table == &kCampaigns || &table == &kShards) return joined_campaigns(table, same);
    return std::move(same.front().entry);
  }

  void conflict(const std::string& what, std::size_t a, const std::string& of_a, std::size_t b,
                const std::string& of_b) {
    if (merged_.conflicts.size() == kMaxConflicts) merged_.conflicts.push_back("... and more");
    if (merged_.conflicts.size() > kMaxConflicts) return;
    merged_.conflicts.push_back(
        printable(what + ": " + stores_[a]->path + " has " + of_a + "; " + stores_[b]->path + " has " + of_b));
  }

  // ---- cells ----
  // How a run ended does not tell what its code computes where time ran out or something killed it.
  static bool settled(const Entry& cell) { return whole_of(cell, 10) == 0 && text_of(cell, 4) != "timeout"; }

  static std::string outcome(const Entry& cell) {
    return text_of(cell, 4) + (text_of(cell, 5).empty() ? "" : " (" + text_of(cell, 5) + ")") + ", " +
           std::to_string(whole_of(cell, 6)) + " steps taken, " + std::to_string(whole_of(cell, 7)) + " evaluations";
  }

  Entry joined_cells(std::vector<Found>& same) {
    std::size_t taken = 0;
    while (taken + 1 < same.size() && !settled(same[taken].entry)) ++taken;
    if (!settled(same[taken].entry)) taken = 0;
    const bool same_ending = std::all_of(same.begin(), same.end(), [&](const Found& one) {
      return settled(one.entry) == settled(same[taken].entry) && outcome(one.entry) == outcome(same[taken].entry);
    });
    ++(same_ending ? merged_.twice : merged_.ended_differently);
    std::set<std::size_t>& from = sources_[text_of(same[taken].entry, 0)];
    const std::string name = text_of(same[taken].entry, 1) + ", " + text_of(same[taken].entry, 2) + ", " +
                             std::to_string(whole_of(same[taken].entry, 3)) + " steps";
    for (const Found& one : same) {
      if (settled(one.entry) != settled(same[taken].entry)) continue;
      if (!settled(one.entry) && &one != &same[taken]) continue;
      from.insert(one.store);
      if (outcome(one.entry) != outcome(same[taken].entry))
        conflict(name, same[taken].store, outcome(same[taken].entry), one.store, outcome(one.entry));
    }
    return std::move(same[taken].entry);
  }

  // Whether this store's run of the cell is one that counts.
  bool counts(const std::string& cell, std::size_t store) const {
    const auto known = sources_.find(cell);
    return known == sources_.end() || known->second.contains(store);
  }

  std::vector<Found*> counting(std::vector<Found>& same, int cell_column) {
    std::vector<Found*> some;
    for (Found& one : same)
      if (counts(text_of(one.entry, cell_column), one.store)) some.push_back(&one);
    if (some.empty()) some.push_back(&same.front());
    return some;
  }

  std::string name_of(const std::string& cell) {
    SQLite::Statement& select = out_.prepared("SELECT scenario, method, steps FROM cells WHERE hash=?");
    select.bind(1, cell);
    if (!select.executeStep()) return "cell " + cell;
    return select.getColumn(0).getString() + ", " + select.getColumn(1).getString() + ", " +
           std::to_string(select.getColumn(2).getInt64()) + " steps";
  }

  // ---- recordings ----
  static std::string end_of(const Entry& series) {
    const SampleSeries samples = unpack_samples(expanded(text_of(series, 1)));
    return pack_samples(samples, samples.empty() ? 0 : samples.size() - 1, samples.size());
  }

  static std::string sample_text(const SampleSeries& samples, std::size_t i) {
    if (i >= samples.size()) return "no sample " + std::to_string(i);
    std::string text = "at t = " + format_double(static_cast<double>(samples[i].t_s)) + " s";
    if (!samples[i].bodies.empty()) {
      text += " its first body at";
      for (const Wide x : samples[i].bodies.front().p_m) text += " " + format_double(static_cast<double>(x));
    }
    return text;
  }

  void compare_series(const Found& a, const Found& b) {
    const bool whole = text_of(a.entry, 3) == "all" && text_of(b.entry, 3) == "all";
    if (whole && text_of(a.entry, 1) == text_of(b.entry, 1) && text_of(a.entry, 2) == text_of(b.entry, 2)) return;
    const auto of_a = expanded(text_of(a.entry, 1)), of_b = expanded(text_of(b.entry, 1));
    const bool same_samples = whole ? of_a == of_b : end_of(a.entry) == end_of(b.entry);
    const std::string what = "recording of " + name_of(text_of(a.entry, 0));
    if (!same_samples) {
      const auto samples_a = unpack_samples(of_a), samples_b = unpack_samples(of_b);
      std::size_t i = 0;
      while (whole && i < std::min(samples_a.size(), samples_b.size()) &&
             pack_samples(samples_a, i, i + 1) == pack_samples(samples_b, i, i + 1))
        ++i;
      const auto last = [](const SampleSeries& samples) { return samples.empty() ? 0 : samples.size() - 1; };
      conflict(what, a.store, sample_text(samples_a, whole ? i : last(samples_a)), b.store,
               sample_text(samples_b, whole ? i : last(samples_b)));
    } else if (whole && expanded(text_of(a.entry, 2)) != expanded(text_of(b.entry, 2))) {
      conflict(what, a.store, "some events", b.store, "others");
    }
  }

  Entry joined_series(std::vector<Found>& same) {
    const std::vector<Found*> some = counting(same, 0);
    Found* taken = some.front();
    for (Found* one : some) {
      if (one != some.front()) compare_series(*taken, *one);
      if (text_of(taken->entry, 3) != "all") taken = one;
    }
    return std::move(taken->entry);
  }

  // ---- rows ----
  static std::string row_text(const Row& row) {
    std::string text = row.metric + (row.body.empty() ? "" : " of " + row.body);
    if (row.t_s) text += " at " + format_double(*row.t_s) + " s";
    return text + " = " + format_double(row.value) + " " + row.unit + " +- " + format_double(row.truth_bar) + " (" +
           to_string(row.status) + (row.reason.empty() ? "" : ", " + row.reason) + ")";
  }

  // Whether the rows were measured without the truth because its solution crashed, timed out or is not built.
  static bool truth_failed(const Entry& measured) {
    const std::vector<Row> rows = unpack_rows(expanded(text_of(measured, 3)));
    return std::any_of(rows.begin(), rows.end(), [](const Row& row) {
      return row.metric == "truth" &&
             (row.status == Status::crashed || row.status == Status::timeout || row.status == Status::not_built);
    });
  }

  // Those that have the truth, where some have it and others do not.
  static void prefer_with_truth(std::vector<Found*>& some) {
    const Entry& first = some.front()->entry;
    if (std::all_of(some.begin(), some.end(),
                    [&](const Found* one) { return one->entry[2] == first[2] && one->entry[3] == first[3]; }))
      return;
    std::vector<Found*> with;
    for (Found* one : some)
      if (!truth_failed(one->entry)) with.push_back(one);
    if (!with.empty()) some = std::move(with);
  }

  void compare_rows(const Found& a, const Found& b) {
    const std::string name = name_of(text_of(a.entry, 1));
    if (text_of(a.entry, 2) != text_of(b.entry, 2))
      throw InputError(name + ": " + stores_[a.store]->path + " and " + stores_[b.store]->path +
                       " measured it against different truths, or by different metrics; `atwood run` with one of the "
                       "programs brings the other store up to date");
    if (text_of(a.entry, 3) == text_of(b.entry, 3)) return;
    const std::string packed_a = expanded(text_of(a.entry, 3)), packed_b = expanded(text_of(b.entry, 3));
    if (packed_a == packed_b || truth_failed(a.entry)) return;
    const std::vector<Row> of_a = unpack_rows(packed_a), of_b = unpack_rows(packed_b);
    std::size_t i = 0;
    while (i < std::min(of_a.size(), of_b.size()) && pack_rows({of_a[i]}) == pack_rows({of_b[i]})) ++i;
    conflict("rows of " + name, a.store, i < of_a.size() ? row_text(of_a[i]) : "no more rows", b.store,
             i < of_b.size() ? row_text(of_b[i]) : "no more rows");
  }

  Entry joined_measured(std::vector<Found>& same) {
    std::vector<Found*> some = counting(same, 1);
    prefer_with_truth(some);
    Found* taken = some.front();
    for (Found* one : some) {
      if (one != some.front()) compare_rows(*some.front(), *one);
      if (text_of(one->entry, 4).size() > text_of(taken->entry, 4).size()) taken = one;  // with a series of errors
    }
    return std::move(taken->entry);
  }

  // ---- times: the whole entry of one host, the first whose pass succeeded ----
  Entry joined_timings(std::vector<Found>& same) {
    auto taken = std::find_if(same.begin(), same.end(), [](const Found& one) { return text_of(one.entry, 2) == "ok"; });
    if (taken == same.end()) taken = same.begin();
    for (const Found& one : same)
      if (text_of(one.entry, 8) != text_of(taken->entry, 8)) ++merged_.other_host;
    return std::move(taken->entry);
  }

  Entry joined_truths(std::vector<Found>& same) {
    for (const Found& one : same) {
      Entry a = same.front().entry, b = one.entry;
      if (a == b) continue;
      const auto text = [](const Entry& truth) {
        return text_of(truth, 2) + ", " + text_of(truth, 4) + ", " + text_of(truth, 5);
      };
      conflict("truth of " + text_of(a, 1), same.front().store, text(a), one.store, text(b));
    }
    return std::move(same.front().entry);
  }

  // Complete where all are: columns of this name are the last ones.
  Entry joined_campaigns(const StoreTable& table, std::vector<Found>& same) {
    Entry entry = same.front().entry;
    const auto complete = static_cast<std::size_t>(table.count - 1);
    bool all = true, any = false;
    for (const Found& one : same) {
      all = all && std::get<std::int64_t>(one.entry[complete]) != 0;
      any = any || std::get<std::int64_t>(one.entry[complete]) != 0;
      if (&table == &kCampaigns) entry[4] = std::max(whole_of(entry, 4), whole_of(one.entry, 4));
    }
    entry[complete] = std::int64_t{(&table == &kCampaigns ? all : any) ? 1 : 0};
    return entry;
  }

  // ---- plans and shards ----
  void require_same_costs() {
    KnownCosts known;
    for (const auto& store : stores_) of_input(*store, [&] { require_same_costs(*store, known); });
  }

  using KnownCosts = std::map<std::string, std::pair<std::string, std::string>>;  // plan -> costs, store

  static void require_same_costs(const StoreDatabase& store, KnownCosts& known) {
    SQLite::Statement select(*store.sql, "SELECT plan, costs FROM shards");
    while (select.executeStep()) {
      const std::string plan = select.getColumn(0).getString(), costs = select.getColumn(1).getString();
      const auto [place, fresh] = known.emplace(plan, std::pair(costs, store.path));
      if (fresh || place->second.first == costs) continue;
      const auto text = [](const std::string& hash) {
        return hash.empty() ? std::string("no file") : "the file " + hash;
      };
      throw InputError(place->second.second + " and " + store.path + " are shards of one study with different costs (" +
                       text(place->second.first) + ", " + text(costs) +
                       "), so that their shares do not fit together; run all shards with the same --costs");
    }
  }

  void find_absent() {
    std::set<std::string> seen;
    for (const auto& store : stores_)
      of_input(*store, [&] {
        SQLite::Statement select(*store->sql, "SELECT hash, cells FROM plans");
        while (select.executeStep()) {
          if (!seen.insert(select.getColumn(0).getString()).second) continue;
          for (const PlannedCell& cell : unpack_plan(expanded(blob_of(select.getColumn(1)))))
            if (!out_.keys[&kCells].contains(cell.hash)) merged_.absent.push_back(printable(cell.name));
        }
      });
    std::sort(merged_.absent.begin(), merged_.absent.end());
    merged_.absent.erase(std::unique(merged_.absent.begin(), merged_.absent.end()), merged_.absent.end());
  }

  StoreDatabase& out_;
  std::vector<std::unique_ptr<StoreDatabase>> stores_;
  std::map<std::string, std::set<std::size_t>> sources_;  // of cells that several stores have: those whose run counts
  Merged merged_;
};

void sync(const std::string& path) {
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  const bool done = file >= 0 && fsync(file) == 0;
  const int error = errno;
  if (file >= 0) close(file);
  if (!done) throw std::runtime_error("store " + path + ": " + std::strerror(error));
}

// Unless `to` exists; errno tells why it failed. Where the file system cannot rename so, both names are there for a
// moment, and a program that is killed then leaves both.
bool renamed_to_new(const std::string& from, const std::string& to) {
  if (renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0) return true;
  if (errno != EINVAL && errno != ENOSYS) return false;
  if (link(from.c_str(), to.c_str()) == 0) return unlink(from.c_str()) == 0;
  return errno != EEXIST && rename(from.c_str(), to.c_str()) == 0;  // it has no hard links either
}

}  // namespace

Merged merge_stores(const std::vector<std::string>& stores, const std::string& out) {
  std::set<std::pair<dev_t, ino_t>> files;
  for (const std::string& store : stores) {
    if (!store_exists(store)) throw InputError(store + ": no such file; expected a store");
    struct stat about {};
    if (stat(store.c_str(), &about) == 0 && !files.emplace(about.st_dev, about.st_ino).second)
      throw InputError(store + ": named twice, or another name of the same file");
  }
  if (store_exists(out)) throw InputError(out + ": exists already; move it away, or choose another file");
  const std::string path = out + ".merging";
  Merged merged;
  StoreDatabase database;
  database.path = path;
  bool ours = false;  // the file; else another merge is writing it
  try {
    database.open_new();
    ours = true;
    database.written([&] { merged = Merge(stores, database).merge(); });
    database.forget_statements();
    database.sql.reset();
    if (!merged.conflicts.empty()) {
      unlink(path.c_str());
      return merged;
    }
    sync(path);
    if (!renamed_to_new(path, out)) throw std::runtime_error("store " + out + ": " + std::strerror(errno));
  } catch (const SQLite::Exception& error) {
    if (ours) unlink(path.c_str());
    database.fail(error);
  } catch (...) {
    if (ours) unlink(path.c_str());
    throw;
  }
  return merged;
}

}  // namespace atwood
