// The split of a study, and the merge of stores: times of two hosts, runs that ended early, truths.
#include <SQLiteCpp/SQLiteCpp.h>
#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>
#include <catch2/catch.hpp>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>

#include "validation/study/campaigns.hpp"
#include "validation/study/lease.hpp"
#include "validation/study/merge.hpp"
#include "validation/study/shares.hpp"
#include "validation/study/store.hpp"
#include "validation/tests/study/free_flight.hpp"

using namespace atwood;

namespace {

struct Made {
  std::string host = "node-1";
  double x = 1;
  Status status = Status::ok;
  bool killed = false, whole = true;
  double busy_ns = 1000;
  double middle = 0;
  Status timed = Status::ok, truth = Status::ok;
};

// A store with one cell.
void make(const std::string& path, const Made& made) {
  Store store(path, Store::Mode::write);
  RunRecord run;
  run.provenance = {"1", "commit", "g++", "-O3", "cpu", "run of " + path, "avx2", "glibc"};
  run.scenario = "one", run.method = "demo/a", run.steps = 64;
  run.outcome.status = made.status;
  run.killed_from_outside = made.killed;
  run.wall_ns = static_cast<std::int64_t>(made.busy_ns);
  Recording recording;
  if (made.status == Status::ok) recording.values = std::vector(3, Sample{0, std::vector<BodySample>(1)});
  if (made.status == Status::ok) recording.values.back().bodies[0].p_m[0] = made.x;
  if (made.status == Status::ok) recording.values[1].bodies[0].p_m[0] = made.middle;
  MeasuredRecord measured;
  measured.basis = "basis";
  measured.rows.resize(1);
  measured.rows[0].metric = "error-position-end", measured.rows[0].unit = "m", measured.rows[0].value = made.x;
  measured.rows[0].status = made.status;
  measured.series.t_s = {0, 1, 2};
  if (made.truth != Status::ok) {
    measured.basis = "basis failed";
    measured.rows[0] = Row();
    measured.rows[0].metric = "truth", measured.rows[0].status = made.truth, measured.rows[0].reason = path;
  }
  store.put_run("cell", run, recording, "key", measured, made.whole);
  TimingRecord timing;
  timing.host = made.host;
  timing.outcome.busy_ns = {static_cast<std::int64_t>(made.busy_ns)};
  timing.outcome.call_ns = 7;
  timing.outcome.status = made.timed;
  store.put_timing("timing", "cell", timing);
}

}  // namespace

TEST_CASE("times of a cell are those of one host") {
  const Folder folder;
  make(folder / "a.db", {.host = "node-1", .busy_ns = 1000});
  make(folder / "b.db", {.host = "node-2", .busy_ns = 3000});
  const Merged merged = merge_stores({folder / "a.db", folder / "b.db"}, folder / "all.db");
  CHECK(merged.cells == 1);
  CHECK(merged.twice == 1);
  CHECK(merged.other_host == 1);
  CHECK(merged.conflicts.empty());
  Store store(folder / "all.db", Store::Mode::read);
  CHECK(store.timing("timing")->host == "node-1");
  CHECK(store.timing("timing")->outcome.busy_ns == std::vector<std::int64_t>{1000});
  CHECK(store.timing("timing")->outcome.call_ns == 7);
  CHECK(store.check().empty());
}

TEST_CASE("a timed pass that failed gives way to one that succeeded") {
  const Folder folder;
  make(folder / "a.db", {.host = "node-1", .busy_ns = 1000, .timed = Status::timeout});
  make(folder / "b.db", {.host = "node-2", .busy_ns = 3000});
  CHECK(merge_stores({folder / "a.db", folder / "b.db"}, folder / "all.db").other_host == 1);
  CHECK(Store(folder / "all.db", Store::Mode::read).timing("timing")->host == "node-2");
}

TEST_CASE("rows whose truth crashed or timed out give way to rows that have it, in either order") {
  const Folder folder;
  const Made without{.truth = GENERATE(Status::crashed, Status::timeout)};
  const bool first = GENERATE(true, false);
  make(folder / "a.db", first ? without : Made{});
  make(folder / "b.db", first ? Made{} : without);
  CHECK(merge_stores({folder / "a.db", folder / "b.db"}, folder / "all.db").conflicts.empty());
  CHECK(Store(folder / "all.db", Store::Mode::read).measured("key", true, false)->basis == "basis");
  make(folder / "c.db", without);
  make(folder / "d.db", without);  // for another reason
  CHECK(merge_stores({folder / "c.db", folder / "d.db"}, folder / "none.db").conflicts.empty());
}

TEST_CASE("a merge that finds another one at work leaves its file alone") {
  const Folder folder;
  make(folder / "a.db", {});
  const std::string file = folder / "all.db.merging";
  const int other = open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  const bool network = GENERATE(false, true);
  if (network) setenv("ATWOOD_STORE_JOURNAL", "rollback", 1);
  struct flock first_byte {};
  first_byte.l_type = F_WRLCK, first_byte.l_whence = SEEK_SET, first_byte.l_len = 1;
  REQUIRE((network ? fcntl(other, F_OFD_SETLK, &first_byte) : flock(other, LOCK_EX | LOCK_NB)) == 0);
  CHECK_THROWS_WITH(merge_stores({folder / "a.db"}, folder / "all.db"), Catch::Contains("is in use"));
  CHECK(std::filesystem::exists(file));
  close(other);
  CHECK(merge_stores({folder / "a.db"}, folder / "all.db").cells == 1);
  CHECK_FALSE(std::filesystem::exists(file));
  unsetenv("ATWOOD_STORE_JOURNAL");
}

TEST_CASE("a merge names the damaged input and its entry") {
  const Folder folder;
  make(folder / "a.db", {});
  make(folder / "b.db", {});
  {
    SQLite::Database database(folder / "b.db", SQLite::OPEN_READWRITE);
    database.exec("UPDATE cells SET steps = 65");
  }
  CHECK_THROWS_WITH(merge_stores({folder / "a.db", folder / "b.db"}, folder / "all.db"),
                    Catch::StartsWith("store " + (folder / "b.db") + ": the entry cell of `cells` differs"));
  // Every bit of every page but the first: wherever the damage is, no message blames the output.
  std::ifstream file(folder / "a.db", std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(file)), {});
  int named = 0;
  for (std::size_t at = 4096; at < bytes.size(); at += 97) {
    std::string flipped = bytes;
    for (std::size_t i = at; i < std::min(at + 97, bytes.size()); ++i)
      flipped[i] = static_cast<char>(flipped[i] ^ 0x55);
    std::ofstream(folder / "c.db", std::ios::binary | std::ios::trunc) << flipped;
    try {
      merge_stores({folder / "a.db", folder / "c.db"}, folder / "all.db");
    } catch (const std::runtime_error& error) {
      CHECK_THAT(error.what(), Catch::Contains("c.db"));
      CHECK_THAT(error.what(), !Catch::Contains("all.db"));
      ++named;
    }
    std::filesystem::remove(folder / "all.db");
  }
  CHECK(named > 10);
}

TEST_CASE("an empty store is refused: it may have been copied without its write-ahead log") {
  const Folder folder;
  make(folder / "a.db", {});
  std::ofstream(folder / "b.db").flush();
  CHECK_THROWS_WITH(merge_stores({folder / "a.db", folder / "b.db"}, folder / "all.db"), Catch::Contains("b.db-wal"));
  CHECK_FALSE(std::filesystem::exists(folder / "all.db"));
  CHECK_FALSE(std::filesystem::exists(folder / "all.db.merging"));
}

TEST_CASE("a file that a killed merge left as a second name of a store is not emptied") {
  const Folder folder;
  make(folder / "a.db", {});
  merge_stores({folder / "a.db"}, folder / "kept.db");
  std::filesystem::create_hard_link(folder / "kept.db", folder / "all.db.merging");
  make(folder / "b.db", {.x = 2});
  CHECK(merge_stores({folder / "b.db"}, folder / "all.db").cells == 1);
  CHECK(Store(folder / "kept.db", Store::Mode::read).measured("key", true, false)->rows.at(0).value == 1);
  std::filesystem::create_hard_link(folder / "a.db", folder / "c.db");
  CHECK_THROWS_WITH(merge_stores({folder / "a.db", folder / "c.db"}, folder / "both.db"), Catch::Contains("same file"));
}

TEST_CASE("a run that time or a kill ended gives way to one that ended by itself, in either order") {
  const Folder folder;
  const Made whole{.x = 2};
  const Made cut = GENERATE(Made{.status = Status::timeout}, Made{.status = Status::crashed, .killed = true});
  const bool first = GENERATE(true, false);
  make(folder / "a.db", first ? cut : whole);
  make(folder / "b.db", first ? whole : cut);
  const Merged merged = merge_stores({folder / "a.db", folder / "b.db"}, folder / "all.db");
  CHECK(merged.conflicts.empty());
  CHECK(merged.twice == 0);
  CHECK(merged.ended_differently == 1);
  Store store(folder / "all.db", Store::Mode::read);
  CHECK(store.run("cell")->outcome.status == Status::ok);
  CHECK(store.recording("cell", {}).values.size() == 3);
  CHECK(store.measured("key", true, true)->rows.at(0).value == 2);
  CHECK(store.check().empty());
}

TEST_CASE("two runs that were cut are no conflict, two that ended differently are") {
  const Folder folder;
  make(folder / "a.db", {.x = 1, .status = Status::timeout});
  make(folder / "b.db", {.x = 2, .status = Status::timeout});
  CHECK(merge_stores({folder / "a.db", folder / "b.db"}, folder / "all.db").conflicts.empty());
  make(folder / "c.db", {.status = Status::diverged});
  make(folder / "d.db", {});
  const Merged merged = merge_stores({folder / "c.db", folder / "d.db"}, folder / "none.db");
  REQUIRE_FALSE(merged.conflicts.empty());
  CHECK_THAT(merged.conflicts.front(), Catch::Contains("one, demo/a, 64 steps") && Catch::Contains("diverged") &&
                                           Catch::Contains("c.db") && Catch::Contains("d.db"));
  CHECK_FALSE(store_exists(folder / "none.db"));
  CHECK_FALSE(store_exists(folder / "none.db.merging"));
}

TEST_CASE("a difference in the last place of a sample is a conflict, also where only the end is kept") {
  const Folder folder;
  const bool whole = GENERATE(true, false);
  make(folder / "a.db", {.x = 1});
  make(folder / "b.db", {.x = std::nextafter(1.0, 2.0), .whole = whole});
  const Merged merged = merge_stores({folder / "a.db", folder / "b.db"}, folder / "all.db");
  REQUIRE(merged.conflicts.size() == 2);  // samples and rows
  CHECK_THAT(merged.conflicts[0], Catch::Contains(" 1 ") && Catch::Contains("1.0000000000000002"));
  CHECK_THAT(merged.conflicts[1], Catch::Contains("error-position-end = 1 m") && Catch::Contains("1.0000000000000002"));
}

TEST_CASE("whole recordings are compared with each other, also where the first store kept only the end") {
  const Folder folder;
  make(folder / "a.db", {.whole = false});
  make(folder / "b.db", {});
  make(folder / "c.db", {.middle = 0.5});
  const Merged merged = merge_stores({folder / "a.db", folder / "b.db", folder / "c.db"}, folder / "all.db");
  REQUIRE(merged.conflicts.size() == 1);
  CHECK_THAT(merged.conflicts[0], Catch::Contains("b.db") && Catch::Contains("c.db"));
}

TEST_CASE("a recording that one store dropped is taken from the other") {
  const Folder folder;
  const bool first = GENERATE(true, false);
  make(folder / "a.db", {.whole = first});
  make(folder / "b.db", {.whole = !first});
  CHECK(merge_stores({folder / "a.db", folder / "b.db"}, folder / "all.db").conflicts.empty());
  Store store(folder / "all.db", Store::Mode::read);
  CHECK(store.keeps_recording("cell"));
  CHECK(store.recording("cell", {}).values.size() == 3);
  CHECK(store.measured("key", true, true)->series.t_s.size() == 3);
}

TEST_CASE("shares are dealt in snake order, and chunks hold ladders of about the same cost") {
  CHECK(deal(8, 3) == std::vector<int>{0, 1, 2, 2, 1, 0, 0, 1});
  CHECK(deal(3, 1) == std::vector<int>{0, 0, 0});
  CHECK(deal(2, 5) == std::vector<int>{0, 1});
  Ladders ladders;
  for (std::size_t i = 0; i < 10; ++i) {
    ladders.cells.push_back({2 * i, 2 * i + 1});
    ladders.cost_ns.push_back(i == 0 ? 100 : 10);
  }
  const auto made = chunks(ladders, 4);
  REQUIRE(made.size() <= 4);
  CHECK(made.front() == std::vector<std::size_t>{0, 1});  // the dearest ladder alone
  std::set<std::size_t> all;
  for (const auto& chunk : made) all.insert(chunk.begin(), chunk.end());
  CHECK(all.size() == 20);
  CHECK(chunks(ladders, 1).size() == 1);
  CHECK(chunks({}, 4).empty());
}

TEST_CASE("a chunk is taken by one process, and again where it was given back") {
  const Folder folder;
  {
    Lease a(folder / "chunks", "0123456789abcdef", 3, "a", 30), b(folder / "chunks", "0123456789abcdef", 3, "b", 30);
    CHECK(a.take() == 0);
    CHECK(b.take() == 1);
    a.done();
    CHECK(a.take() == 2);
    a.done();
  }  // b gives its chunk back
  Lease c(folder / "chunks", "0123456789abcdef", 3, "c", 30);
  CHECK(c.take() == 1);
  c.done();
  CHECK_FALSE(c.take());
  CHECK_THROWS_WITH(Lease(folder / "chunks", "another plan's hash", 3, "d", 30),
                    Catch::Contains("chunks of another study"));
}

TEST_CASE("a chunk of a process that died is taken again after its expiry, and one that cannot be ended is an error") {
  const Folder folder;
  const std::string place = folder / "chunks/0123456789abcdef";
  { const Lease maker(folder / "chunks", "0123456789abcdef", 1, "maker", 30); }
  const auto take_as_dead = [&](const std::string& from) {
    std::filesystem::rename(place + from, place + "/taken/000000000.dead");
    std::filesystem::last_write_time(place + "/taken/000000000.dead",
                                     std::filesystem::file_time_type::clock::now() - std::chrono::seconds(60));
  };
  take_as_dead("/todo/000000000");
  {
    Lease next(folder / "chunks", "0123456789abcdef", 1, "next", 30);
    CHECK(next.take() == 0);
    CHECK(std::filesystem::exists(place + "/taken/000000000.next"));
    CHECK_FALSE(std::filesystem::exists(place + "/taken/000000000.dead"));
    next.done();
    CHECK_FALSE(next.take());
  }
  take_as_dead("/done/000000000");
  Lease last(folder / "chunks", "0123456789abcdef", 1, "last", 30);
  CHECK(last.take() == 0);
  std::filesystem::remove(place + "/done");
  std::ofstream(place + "/done") << "no directory";
  CHECK_THROWS_WITH(last.done(), Catch::Contains("--lease"));
}

TEST_CASE("file systems that cannot hold a write-ahead log are known by their numbers") {
  CHECK(network_file_system_name(0x6969) == "NFS");
  CHECK(network_file_system_name(0x0BD00BD0) == "Lustre");
  CHECK(network_file_system_name(0xEF53).empty());  // ext4
  const Folder folder;
  CHECK(network_file_system_of(folder / "store.db").empty());
}
