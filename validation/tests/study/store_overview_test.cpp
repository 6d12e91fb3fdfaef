// What a run decides by one pass over the store must be what it would find cell by cell, also where the file is
// damaged.
#include <catch2/catch.hpp>

#include <SQLiteCpp/SQLiteCpp.h>

#include <fstream>
#include <iterator>
#include <random>
#include <set>
#include <unordered_map>

#include "validation/study/content_hash.hpp"
#include "validation/study/key_table.hpp"
#include "validation/study/store.hpp"
#include "validation/study/store_overview.hpp"
#include "validation/tests/study/free_flight.hpp"

using namespace atwood;

namespace {

constexpr int kStored = 300;
constexpr std::size_t kPage = 4096;

CellKeys keys_of(int i) {
  const std::string n = std::to_string(i);
  return {content_hash({"run", n}), content_hash({"times", n}), content_hash({"rows", n})};
}

void fill(const std::string& path) {
  Store store(path, Store::Mode::write);
  for (int i = 0; i < kStored; ++i) {
    const CellKeys keys = keys_of(i);
    RunRecord run;
    run.limit_s = i;
    run.scenario = "scene", run.method = "demo/a", run.steps = i;
    run.outcome.status = i % 7 == 0 ? Status::diverged : Status::ok;
    MeasuredRecord measured;
    measured.basis = "basis " + std::to_string(i % 3);
    measured.rows.resize(1);
    measured.rows[0].metric = "error-position-end";
    store.put_run(keys.accuracy, run, {}, keys.measured, measured, false);
    TimingRecord timing;
    timing.outcome.busy_ns = {1000 + i};
    store.put_timing(keys.timing, keys.accuracy, timing);
  }
  store.checkpoint();
}

std::string bytes_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void write(const std::string& path, const std::string& bytes) {
  for (const char* suffix : {"-wal", "-shm"}) std::filesystem::remove(path + suffix);
  std::ofstream(path, std::ios::binary) << bytes;
}

// The overview of a file with these bytes. Where it is whole, every cell is found as it was stored.
bool whole(const std::string& path, const std::string& bytes) {
  write(path, bytes);
  try {
    Store store(path, Store::Mode::read);
    if (store.empty()) return false;
    const StoreOverview all = store.overview();
    if (!all.whole) return false;
    for (int i = 0; i < kStored; ++i) {
      const CellKeys keys = keys_of(i);
      const StoreOverview::Run* run = all.run(keys.accuracy);
      REQUIRE(run != nullptr);
      CHECK(run->status == (i % 7 == 0 ? Status::diverged : Status::ok));
      CHECK(run->limit_s == i);
      CHECK(all.measured_from(keys.measured, "basis " + std::to_string(i % 3)));
      CHECK_FALSE(all.measured_from(keys.measured, "basis 3"));
      CHECK(store.damage(keys).empty());
      CHECK(store.run(keys.accuracy));
      CHECK(store.timing(keys.timing));
      CHECK(store.measured_basis(keys.measured) == "basis " + std::to_string(i % 3));
    }
    return true;
  } catch (const std::runtime_error&) {
    return false;
  }
}

std::size_t number_at(const std::string& bytes, std::size_t at) {  // two bytes, the higher one first
  return static_cast<std::size_t>(static_cast<unsigned char>(bytes[at])) << 8 |
         static_cast<unsigned char>(bytes[at + 1]);
}

// Where the numbers of rows lie that part a table into its pages: the last byte of each (sqlite.org/fileformat.html,
// 1.6).
std::vector<std::size_t> partings(const std::string& bytes) {
  std::vector<std::size_t> places;
  for (std::size_t page = kPage; page + kPage <= bytes.size(); page += kPage) {
    if (bytes[page] != 5) continue;  // an interior page of a table
    for (std::size_t cell = 0; cell < number_at(bytes, page + 3); ++cell) {
      std::size_t at = page + number_at(bytes, page + 12 + 2 * cell) + 4;
      while ((bytes[at] & 0x80) != 0) ++at;
      places.push_back(at);
    }
  }
  return places;
}

// Where the leaves of indices say that a key is text: the type of the first entry of each (sqlite.org/fileformat.html,
// 1.6 and 2.1). The same bytes as a blob have the type below.
std::vector<std::size_t> types_of_keys(const std::string& bytes) {
  std::vector<std::size_t> places;
  for (std::size_t page = kPage; page + kPage <= bytes.size(); page += kPage) {
    if (bytes[page] != 10 || number_at(bytes, page + 3) == 0) continue;  // a leaf of an index
    std::size_t at = page + number_at(bytes, page + 8);
    while ((bytes[at] & 0x80) != 0) ++at;  // the length of the entry
    places.push_back(at + 2);              // after that of its header
  }
  return places;
}

}  // namespace

TEST_CASE("a table by keys finds what was put in, through growth and erasing") {
  KeyTable<int> table;
  std::unordered_map<std::string, int> expected;
  std::mt19937_64 random(7);
  CHECK_FALSE(table.contains(key_sum("")));
  for (int i = 0; i < 20'000; ++i) {
    const std::string key = std::to_string(random() % 3000);
    if (random() % 3 == 0) {
      CHECK(table.erase(key_sum(key)) == (expected.erase(key) > 0));
    } else {
      const auto [place, fresh] = table.insert(key_sum(key), i);
      CHECK(fresh == expected.emplace(key, i).second);
      CHECK(*place == expected[key]);
    }
    CHECK(table.size() == expected.size());
  }
  for (int i = 0; i < 3000; ++i) {
    const std::string key = std::to_string(i);
    const int* found = table.find(key_sum(key));
    const auto wanted = expected.find(key);
    REQUIRE((found != nullptr) == (wanted != expected.end()));
    if (found != nullptr) CHECK(*found == wanted->second);
  }
}

TEST_CASE("the overview of a store is whole only where every cell is found by its keys") {
  const Folder folder;
  fill(folder / "sound.db");
  const std::string sound = bytes_of(folder / "sound.db"), path = folder / "changed.db";
  REQUIRE(whole(path, sound));
  std::mt19937_64 random(11);
  int seen = 0;
  for (int i = 0; i < 300; ++i) {
    std::string changed = sound;
    const std::size_t byte = random() % changed.size();
    changed[byte] = static_cast<char>(changed[byte] ^ (1 << random() % 8));
    CAPTURE(byte);
    seen += whole(path, changed) ? 0 : 1;
  }
  CHECK(seen > 150);
  CHECK(seen < 300);  // some bytes belong to nothing

  const std::vector<std::size_t> places = partings(sound);
  REQUIRE(places.size() > 10);
  for (const std::size_t place : places) {  // then one row is looked for in the page beside its own
    std::string changed = sound;
    changed[place] = static_cast<char>(changed[place] ^ 1);
    CAPTURE(place);
    CHECK_FALSE(whole(path, changed));
  }

  const std::vector<std::size_t> types = types_of_keys(sound);
  REQUIRE(types.size() > 10);
  for (const std::size_t place : types) {
    if ((sound[place] & 1) == 0) continue;  // a table's name or a number
    std::string changed = sound;
    changed[place] = static_cast<char>(changed[place] ^ 1);
    CAPTURE(place);
    CHECK_FALSE(whole(path, changed));
  }
}

TEST_CASE("a recording that has gone, or a key in the place of another, makes the overview not whole") {
  const Folder folder;
  fill(folder / "sound.db");
  const std::string sound = bytes_of(folder / "sound.db"), path = folder / "changed.db";
  for (const std::string& statement : {
           "DELETE FROM series WHERE hash='" + keys_of(5).accuracy + "'",
           "UPDATE measured SET key='" + content_hash({"another"}) + "' WHERE key='" + keys_of(5).measured + "'",
           std::string("DELETE FROM provenances"),
       }) {
    write(path, sound);
    {
      SQLite::Database sql(path, SQLite::OPEN_READWRITE);
      CHECK(sql.exec(statement) == 1);
    }
    CAPTURE(statement);
    CHECK_FALSE(whole(path, bytes_of(path)));
  }
}
