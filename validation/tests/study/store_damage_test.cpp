// Stores that a disk, a kill or another program has changed: damage is reported or repaired, never ignored; and
// stores of an older program.
#include <catch2/catch.hpp>

#include <SQLiteCpp/SQLiteCpp.h>
#include <fcntl.h>
#include <sqlite3.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <random>

#include "scene/files.hpp"
#include "validation/study/campaigns.hpp"
#include "validation/study/content_hash.hpp"
#include "validation/study/process.hpp"
#include "validation/study/recording_blob.hpp"
#include "validation/study/store.hpp"
#include "validation/study/store_database.hpp"
#include "validation/tests/study/free_flight.hpp"

using namespace atwood;

namespace {

std::vector<Cell> some_cells() {
  Worker worker;
  worker.path = "bin/atwood-demo";
  worker.command = {worker.path};
  worker.engine.name = "demo";
  worker.engine.version = "1";
  worker.engine.methods = {{"demo/a", "", "", {}, false, {}}, {"demo/b", "", "", {}, false, {}}};
  worker.build_id = "build";
  return plan_cells({"test", {{{"*"}, {"demo/*"}, {}, 3, {}}}}, {free_flight("one"), free_flight("two", 4)}, {worker},
                    "cpu");
}

// A store in which these cells have run.
void fill(const std::string& path, const std::vector<Cell>& cells) {
  Store store(path, Store::Mode::write);
  for (const Cell& cell : cells) {
    const double n = static_cast<double>(cell.plan.steps);
    RunRecord run;
    run.provenance = {"1", "commit", "g++", "-O3", "cpu", "run", "avx2", "glibc"};
    run.outcome.steps_taken = cell.plan.steps;
    run.scenario = cell.scenario->id;
    run.method = cell.method;
    run.steps = cell.plan.steps;
    Recording recording;
    Sample sample;
    sample.bodies.resize(1);
    sample.bodies[0].p_m = {1 / n, 2, 3};
    recording.values = std::vector(2, sample);
    recording.values[1].t_s = 2;
    MeasuredRecord measured;
    measured.basis = "basis";
    measured.series.t_s = {0, 2};
    measured.rows.resize(3);
    for (std::size_t i = 0; i < 3; ++i) {
      measured.rows[i].metric = i == 0 ? "error-position-end" : i == 1 ? "error-position-max" : "energy-max";
      measured.rows[i].unit = "m";
      measured.rows[i].value = static_cast<double>(i + 1) / (n * n);
    }
    const CellKeys keys = Campaigns().keys(cell);
    store.put_run(keys.accuracy, run, recording, keys.measured, measured);
    TimingRecord timing;
    timing.provenance = run.provenance;
    timing.outcome.busy_ns = {1000 * cell.plan.steps, 1100 * cell.plan.steps};
    store.put_timing(keys.timing, keys.accuracy, timing);
  }
}

// Everything that is exported, to the last digit.
std::string exported(const std::string& path, const std::vector<Cell>& cells) {
  std::string text;
  for (const Row& row : load_rows(path, cells).rows) {
    const Provenance& p = *row.provenance;
    for (const std::string& part :
         {row.scenario, row.method, row.body, row.metric, row.unit, format_double(row.value),
          format_double(row.truth_bar), to_string(row.status), row.reason, row.settings_hash, p.engine_version,
          p.commit, p.compiler, p.flags, p.cpu, p.cpu_features, p.libm, p.run_id})
      text += part + "|";
    text += std::to_string(row.steps) + "\n";
  }
  for (const StoredSeries& series : load_series(path, cells)) {
    text += series.scenario + series.method + std::to_string(series.steps);
    for (const double t : series.series.t_s) text += " " + format_double(t);
    text += "\n";
  }
  return text;
}

void flip(const std::string& path, std::uintmax_t byte, int bit) {
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  file.seekg(static_cast<std::streamoff>(byte));
  const char changed = static_cast<char>(file.get() ^ (1 << bit));
  file.seekp(static_cast<std::streamoff>(byte));
  file.put(changed);
}

void execute(const std::string& path, const std::string& statements) {
  SQLite::Database sql(path, SQLite::OPEN_READWRITE);
  sql.exec(statements);
}

// What an SQLite call gives, in a process whose end is reported.
int ending_of(const std::function<int()>& work) {
  const pid_t child = fork();
  if (child == 0) _exit(work());
  int status = 0;
  waitpid(child, &status, 0);
  return WIFSIGNALED(status) ? -WTERMSIG(status) : WEXITSTATUS(status);
}

}  // namespace

TEST_CASE("a bit flipped anywhere in a store is told, or changes nothing that is exported") {
  const Folder folder;
  const auto cells = some_cells();
  fill(folder / "sound.db", cells);
  const std::string expected = exported(folder / "sound.db", cells);
  REQUIRE(expected.size() > 5000);
  CHECK(check_store(folder / "sound.db").empty());
  const std::uintmax_t size = std::filesystem::file_size(folder / "sound.db");
  std::mt19937_64 random(42);
  int told = 0;
  for (int i = 0; i < 400; ++i) {
    // A quarter of them in the file's header and the tables' definitions.
    const std::uintmax_t byte = random() % (i % 4 == 0 ? std::uintmax_t{4096} : size);
    const int bit = static_cast<int>(random() % 8);
    CAPTURE(byte, bit);
    const std::string path = folder / "flipped.db";
    for (const char* suffix : {"", "-wal", "-shm"}) std::filesystem::remove(path + suffix);
    std::filesystem::copy_file(folder / "sound.db", path);
    flip(path, byte, bit);
    std::string now, error;
    try {
      now = exported(path, cells);
    } catch (const std::runtime_error& thrown) {
      error = thrown.what();
    }
    if (error.empty()) {
      CHECK(now == expected);
      continue;
    }
    ++told;
    CHECK_THAT(error, Catch::Contains("flipped.db: "));
    std::vector<std::string> damage;
    try {
      damage = check_store(path);
    } catch (const StoreOfAnother& thrown) {  // a bit of the application's number or the schema's
      damage = {thrown.what()};
    }
    CHECK_FALSE(damage.empty());
    for (const std::string& line : damage) CHECK(line == printable(line));
    CHECK(error == printable(error));
  }
  CHECK(told > 50);
}

TEST_CASE("damage is told by the cell's name, in reading and in the check of the whole store") {
  const Folder folder;
  const auto cells = some_cells();
  const std::string path = folder / "store.db";
  const std::string hash = cells[3].accuracy_hash;
  REQUIRE(cells[3].plan.steps == 64);
  const auto damaged_by = [&](const std::string& statement) {
    for (const char* suffix : {"", "-wal", "-shm"}) std::filesystem::remove(path + suffix);
    fill(path, cells);
    execute(path, statement);
    CHECK_THROWS_WITH(load_rows(path, cells),
                      Catch::Contains("one, demo/a, 64 steps") && Catch::Contains("atwood run"));
    CHECK_THAT(check_store(path).at(0), Catch::Contains("one, demo/a, 64 steps"));
  };
  damaged_by("UPDATE cells SET steps_taken=63 WHERE hash='" + hash + "'");
  damaged_by("UPDATE series SET samples=zeroblob(length(samples)) WHERE hash='" + hash + "'");
  damaged_by("UPDATE timings SET busy_ns=zeroblob(length(busy_ns)) WHERE cell='" + hash + "'");
  damaged_by("UPDATE measured SET rows=zeroblob(length(rows)) WHERE cell='" + hash + "'");
  damaged_by("UPDATE measured SET rows=x'' WHERE cell='" + hash + "'");
}

TEST_CASE("a damaged index is built again from its table when the store is written") {
  const Folder folder;
  const auto cells = some_cells();
  const std::string path = folder / "store.db";
  fill(path, cells);
  const std::string expected = exported(path, cells);
  std::uintmax_t end = 0;  // of the index's root page, where its first entry lies
  {
    SQLite::Database sql(path, SQLite::OPEN_READONLY);
    end = static_cast<std::uintmax_t>(
        sql.execAndGet("SELECT rootpage FROM sqlite_master WHERE name='sqlite_autoindex_measured_1'").getInt() *
        sql.execAndGet("PRAGMA page_size").getInt());
  }
  flip(path, end - 6, 5);
  CHECK_FALSE(check_store(path).empty());
  { Store store(path, Store::Mode::write); }
  CHECK(check_store(path).empty());
  CHECK(exported(path, cells) == expected);
}

TEST_CASE("an entry that has gone is missed") {
  const Folder folder;
  const auto cells = some_cells();
  for (const char* table : {"cells", "measured", "timings"}) {
    const std::string path = folder / (std::string(table) + ".db");
    fill(path, cells);
    const std::string column = std::string(table) == "cells" ? "hash" : "cell";
    execute(path, std::string("DELETE FROM ") + table + " WHERE " + column + "='" +
                      std::string(cells[0].accuracy_hash) + "'");
    CHECK_THROWS_WITH(load_rows(path, cells), Catch::Contains("15 entries of `" + std::string(table) + "`, where 16"));
    CHECK_THROWS_WITH(Store(path, Store::Mode::write), Catch::Contains("is damaged"));
    CHECK_FALSE(check_store(path).empty());
  }
}

TEST_CASE("a store without its tables, or that is no file, is an error in words and never the program's end") {
  const Folder folder;
  const auto cells = some_cells();
  const auto read_and_write = [&](const std::string& name) {
    return ending_of([&] {
      try {
        load_rows(folder / name, cells);
        load_series(folder / name, cells);
        Store store(folder / name, Store::Mode::write);
        store.run("a cell");
      } catch (const std::runtime_error&) {
        return 5;
      }
      return 0;
    });
  };
  std::ofstream(folder / "empty.db");
  CHECK(load_rows(folder / "empty.db", cells).rows.empty());
  CHECK(check_store(folder / "empty.db").empty());
  CHECK(read_and_write("empty.db") == 0);  // as a run that was killed at once leaves it: the next one goes on
  fill(folder / "empty.db", cells);
  CHECK(load_rows(folder / "empty.db", cells).rows.size() > 16);
  for (const char* table : {"measured", "cells", "totals", "provenances", "shards"}) {
    const std::string name = std::string("no-") + table + ".db";
    fill(folder / name, cells);
    execute(folder / name, std::string("DROP TABLE ") + table);
    CHECK(read_and_write(name) == 5);
    CHECK_THAT(check_store(folder / name).at(0), Catch::Contains("no table `" + std::string(table) + "`"));
  }
  fill(folder / "column.db", cells);
  execute(folder / "column.db", "ALTER TABLE timings RENAME COLUMN busy_ns TO idle_ns");
  CHECK(read_and_write("column.db") == 5);
  std::filesystem::create_directory(folder / "folder.db");
  CHECK(read_and_write("folder.db") == 5);
  CHECK_THROWS_WITH(Store(folder / "folder.db", Store::Mode::write), Catch::Contains("is a folder; expected a file"));
  REQUIRE(mkfifo((folder / "fifo.db").c_str(), 0644) == 0);
  CHECK(read_and_write("fifo.db") == 5);
  CHECK_THROWS_WITH(load_rows(folder / "fifo.db", cells), Catch::Contains("not a regular file"));
}

TEST_CASE("with the standard descriptors closed, nothing that is printed reaches the store") {
  const Folder folder;
  const auto cells = some_cells();
  const std::string path = folder / "store.db";
  CHECK(ending_of([&] {
          for (const int standard : {0, 1, 2}) close(standard);
          Store store(path, Store::Mode::write);
          for (const int standard : {0, 1, 2}) {
            struct stat of_standard {
            }, of_store{};
            if (stat(path.c_str(), &of_store) == 0 && fstat(standard, &of_standard) == 0 &&
                of_standard.st_ino == of_store.st_ino)
              return 10 + standard;
          }
          return 0;
        }) == 0);
}

namespace {

// The tables of the schema before this one, with one cell of two rows, its truth and its times.
class Schema3 {
 public:
  explicit Schema3(const std::string& path) : sql_(path, SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE) {
    sql_.exec(R"(
PRAGMA journal_mode=WAL;
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
PRAGMA application_id=1098151780;
PRAGMA user_version=3;
)");
    Sample sample;
    sample.bodies.resize(1);
    Series series;
    series.t_s = {0, 1};
    const std::string samples = pack_samples(std::vector{sample}), events = pack_events({}),
                      errors = pack_series(series), busy = pack_reals({3, 1, 2}), bars = pack_reals({1e-20});
    const std::int64_t no = 0, yes = 1;
    const auto whole = [](std::int64_t n) { return StoreValue(n); };
    put("provenances", {"old", "1", "commit", "g++", "-O3", "cpu", "avx2", "glibc 2.36", "old run"});
    put("cells", {"cell", "one", "demo/a", whole(64), "ok", "", whole(64), whole(256), whole(5), 20.0, no, "old"});
    put("series", {"cell", Blob{samples}, Blob{events}});
    ValueChecksum rows;
    row(rows, {no, "", nullptr, "error-position-max", "m", 0.25, 1e-12, "ok", "", nullptr, 0.5});
    row(rows, {yes, "ball", 0.5, "energy-max", "J", nullptr, 0.0, "not finite", "it's so", nullptr, nullptr});
    put("measured", {"key", "cell", "basis", Blob{errors}, whole(2), rows.value()});
    put("timings", {"timing", "cell", "ok", "", whole(64), whole(256), Blob{busy}, "old"});
    put("truths",
        {"truth", "one", "ok", "", "closed form", "", 1.0, Blob{samples}, Blob{samples}, Blob{events}, Blob{bars}});
    for (const auto& [table, key] :
         {std::pair{"cells", "cell"}, std::pair{"measured", "key"}, std::pair{"timings", "timing"}})
      insert("totals", {table, yes, static_cast<std::int64_t>(checksum(key))});
  }

 private:
  void insert(const std::string& table, const std::vector<StoreValue>& values) {
    std::string places = "?";
    for (std::size_t i = 1; i < values.size(); ++i) places += ",?";
    SQLite::Statement statement(sql_, "INSERT INTO " + table + " VALUES(" + places + ")");
    for (std::size_t i = 0; i < values.size(); ++i) {
      const int index = static_cast<int>(i + 1);
      if (const auto* text = std::get_if<std::string>(&values[i])) statement.bind(index, *text);
      if (const auto* blob = std::get_if<Blob>(&values[i]))
        statement.bind(index, blob->bytes.data(), static_cast<int>(blob->bytes.size()));
      if (const auto* real = std::get_if<double>(&values[i])) statement.bind(index, *real);
      if (const auto* n = std::get_if<std::int64_t>(&values[i])) statement.bind(index, *n);
    }
    statement.exec();
  }
  void put(const std::string& table, std::vector<StoreValue> values) {
    ValueChecksum sum;
    for (const StoreValue& value : values) sum.add(value);
    values.emplace_back(sum.value());
    insert(table, values);
  }
  void row(ValueChecksum& sum, std::vector<StoreValue> values) {
    for (const StoreValue& value : values) sum.add(value);
    values.insert(values.begin(), std::string("key"));
    insert("rows", values);
  }
  SQLite::Database sql_;
};

}  // namespace

TEST_CASE("a store of the schema before is brought up to date where it lies, nothing of it lost") {
  const Folder folder;
  const bool by_reading = GENERATE(false, true);
  const std::string path = folder / "store.db";
  Schema3{path};
  if (by_reading) Store(path, Store::Mode::read);
  else Store(path, Store::Mode::write);
  {
    SQLite::Database sql(path, SQLite::OPEN_READWRITE);
    CHECK(sql.execAndGet("PRAGMA user_version").getInt() == 4);
    CHECK(sql.execAndGet("SELECT count(*) FROM sqlite_master WHERE name LIKE 'old_%'").getInt() == 0);
  }
  CHECK(check_store(path).empty());
  Store store(path, Store::Mode::read);
  const auto run = store.run("cell");
  REQUIRE(run);
  CHECK(run->outcome.rate_evaluations == 256);
  CHECK(run->limit_s == 20);
  CHECK(run->provenance.run_id == "old run");
  CHECK(run->provenance.libm == "glibc 2.36");
  CHECK(store.recording("cell", run->outcome).values.size() == 1);
  const auto measured = store.measured("key", true, true);
  REQUIRE(measured);
  REQUIRE(measured->rows.size() == 2);
  CHECK(measured->rows[0].value == 0.25);
  CHECK(std::isnan(measured->rows[1].value));
  CHECK(measured->rows[1].reason == "it's so");
  CHECK_FALSE(measured->rows[1].spacing_m);
  CHECK(measured->rows[0].sound_speed_m_per_s == 0.5);
  CHECK(measured->rows[1].t_s == 0.5);
  CHECK_FALSE(measured->rows[0].t_s);
  CHECK(store.keeps_recording("cell"));
  CHECK(measured->series.t_s == std::vector<double>{0, 1});
  CHECK(store.timing("timing")->outcome.busy_ns == std::vector<std::int64_t>{3, 1, 2});
  CHECK(store.truth("truth")->event_bar_s == std::vector<double>{1e-20});
}

TEST_CASE("a store of the schema before that cannot be brought up to date stays as it is") {
  const Folder folder;
  Schema3{folder / "store.db"};
  execute(folder / "store.db", "DROP TABLE timings");
  CHECK_THROWS_WITH(Store(folder / "store.db", Store::Mode::write), Catch::Contains("is damaged"));
  SQLite::Database sql(folder / "store.db", SQLite::OPEN_READWRITE);
  CHECK(sql.execAndGet("PRAGMA user_version").getInt() == 3);
  CHECK(sql.execAndGet("SELECT count(*) FROM cells").getInt() == 1);
  for (const char* damage : {"UPDATE rows SET value=0.5 WHERE ordinal=0", "UPDATE timings SET status='diverged'",
                             "DELETE FROM measured", "UPDATE series SET samples=events"}) {
    const std::string path = folder / (std::to_string(std::string_view(damage).size()) + ".db");
    Schema3{path};
    execute(path, damage);
    CHECK_THROWS_WITH(Store(path, Store::Mode::write), Catch::Contains("is damaged"));
  }
  execute(folder / "store.db", "PRAGMA user_version=2");
  CHECK_THROWS_WITH(Store(folder / "store.db", Store::Mode::write),
                    Catch::Contains("has schema 2; this program reads schemas 3 and 4"));
  execute(folder / "store.db", "PRAGMA user_version=9");
  CHECK_THROWS_WITH(Store(folder / "store.db", Store::Mode::write),
                    Catch::Contains("a newer atwood wrote it (schema 9;"));
  CHECK_THROWS_AS(check_store(folder / "store.db"), StoreOfAnother);
}
