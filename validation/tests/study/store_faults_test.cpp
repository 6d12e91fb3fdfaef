// Every call that SQLite makes on the store's files fails in turn, and allocations of SQLite's: the store says so in
// words, loses no cell that it has acknowledged, is sound afterwards, and the next run goes on with it.
#include <catch2/catch.hpp>

#include "validation/study/store.hpp"
#include "validation/tests/study/faulty_file_system.hpp"
#include "validation/tests/study/free_flight.hpp"

using namespace atwood;

namespace {

constexpr int kCells = 4;

std::string key(const char* part, int cell) { return part + std::to_string(cell); }

RunRecord run_of(int cell) {
  RunRecord run;
  run.provenance = {"1", "commit", "g++", "-O3", "cpu", "run", "avx2", "glibc"};
  run.outcome.steps_taken = 8 + cell;
  run.scenario = "one", run.method = "demo/a", run.steps = 8 + cell;
  return run;
}

Recording recording_of(int cell) {
  Recording recording;
  recording.values = std::vector(40, Sample{0, std::vector<BodySample>(3)});  // several pages
  for (std::size_t k = 0; k < recording.values.size(); ++k) {
    recording.values[k].t_s = static_cast<Wide>(k);
    for (std::size_t i = 0; i < 3; ++i)
      recording.values[k].bodies[i].p_m = {1.0 / (cell + 3), 1.0 / (k + 7.0), 1.0 * i};
  }
  return recording;
}

MeasuredRecord measured_of(int cell) {
  MeasuredRecord measured;
  measured.basis = "basis";
  Row& row = measured.rows.emplace_back();
  row.metric = "error-position-end", row.unit = "m", row.value = 0.5 + cell;
  return measured;
}

bool is_whole(Store& store, int cell) {
  const auto run = store.run(key("run", cell));
  const auto measured = store.measured(key("measured", cell), true, false);
  if (!run || !measured) return false;
  return run->outcome.steps_taken == 8 + cell && measured->rows.size() == 1 && measured->rows[0].value == 0.5 + cell &&
         store.recording(key("run", cell), run->outcome).values.size() == recording_of(cell).values.size();
}

// What a run of the program does with its store: those cells that it lacks. `stored`: the cells that are acknowledged.
void go_on(const std::string& path, int& stored) {
  Store store(path, Store::Mode::write);
  store.put_program_run("run", 1, 0);
  if (!store.has_truth("truth")) store.put_truth("truth", "one", Truth{});
  stored = 0;
  for (int cell = 0; cell < kCells; ++cell, ++stored)
    if (!store.has({key("run", cell), "", key("measured", cell)}))
      store.put_run(key("run", cell), run_of(cell), recording_of(cell), key("measured", cell), measured_of(cell));
  store.put_program_run("run", 1, 2);
  store.checkpoint();
}

// One run in which a call fails, and what must hold after it. False: the run made fewer calls.
bool survives(const FileFaults& faults) {
  const Folder folder;
  const std::string path = folder / "store.db";
  int stored = 0;
  std::string told;
  g_file_faults = faults;
  try {
    go_on(path, stored);
  } catch (const std::exception& error) {
    told = error.what();
  }
  const bool reached = g_file_faults.count >= faults.at;
  g_file_faults = {};
  CAPTURE(faults.kinds, faults.at, faults.and_later, faults.disk_full, told, stored);
  if (!reached) CHECK(told.empty());
  // Its own words of what failed, and not SQLite's "unknown error"; never that sound entries are damaged.
  if (!told.empty()) CHECK(told.rfind("store " + path + ": ", 0) == 0);
  CHECK(told.find("not an error") == std::string::npos);
  CHECK(told.find("damaged") == std::string::npos);
  if (told.empty()) CHECK(stored == kCells);
  if (std::filesystem::exists(path)) {
    CHECK(check_store(path).empty());
    Store store(path, Store::Mode::check);
    for (int cell = 0; cell < stored; ++cell) CHECK(is_whole(store, cell));
  } else {
    CHECK(stored == 0);
  }
  go_on(path, stored);
  CHECK(stored == kCells);
  CHECK(check_store(path).empty());
  Store store(path, Store::Mode::read);
  for (int cell = 0; cell < kCells; ++cell) CHECK(is_whole(store, cell));
  return reached;
}

// How many calls of these kinds a run makes, each of which has failed (of many, every `every`-th).
long all_of(int kinds, bool and_later, bool disk_full, long every = 1) {
  long at = 1;
  while (survives({kinds, at, and_later, disk_full, 0})) at += every;
  return at - 1;
}

}  // namespace

TEST_CASE("each call of SQLite on the files of the store fails in turn") {
  const FaultyFileSystem faulty;
  for (const bool and_later : {false, true}) {
    CHECK(all_of(FileFaults::writing, and_later, false) > 20);
    CHECK(all_of(FileFaults::writing, and_later, true) > 20);
    CHECK(all_of(FileFaults::syncing, and_later, false) >= 2);
    CHECK(all_of(FileFaults::opening, and_later, false) > 4);
    CHECK(all_of(FileFaults::removing | FileFaults::mapping, and_later, false) >= 2);
    CHECK(all_of(FileFaults::reading, and_later, false) > 10);
    CHECK(all_of(FileFaults::locking, and_later, false) > 20);
  }
}

TEST_CASE("allocations that SQLite makes fail") {
  const FaultyFileSystem faulty;
  CHECK(all_of(FileFaults::memory, false, false, 17) > 500);
  CHECK(all_of(FileFaults::memory, true, false, 101) > 500);
}

TEST_CASE("a store with a rollback journal survives the same faults") {
  const FaultyFileSystem faulty;
  setenv("ATWOOD_STORE_JOURNAL", "rollback", 1);
  for (const bool disk_full : {false, true}) CHECK(all_of(FileFaults::writing, true, disk_full, 3) > 20);
  CHECK(all_of(FileFaults::syncing, false, false) > 10);
  CHECK(all_of(FileFaults::opening | FileFaults::removing, false, false) > 3);
  CHECK(all_of(FileFaults::reading | FileFaults::locking, false, false, 3) > 10);
  unsetenv("ATWOOD_STORE_JOURNAL");
}
