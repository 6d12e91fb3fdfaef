// Our engine's contacts over 2000 seeded poses a pair, through the gates of the study geometry-sweep.
#include <catch2/catch.hpp>

#include <cstdlib>
#include <filesystem>

#include "scene/files.hpp"
#include "validation/gates/gates.hpp"
#include "validation/study/study.hpp"

using namespace atwood;
namespace fs = std::filesystem;

TEST_CASE("a sweep of seeded poses passes its gates, and its worst poses are kept as scenes that read back") {
  char folder[] = "/tmp/atwood-sweep-XXXXXX";
  REQUIRE(mkdtemp(folder) != nullptr);
  const auto workers = find_workers({ATWOOD_BIN_DIR "/atwood-engine"});
  Study study = read_study(ATWOOD_SOURCE_DIR "/validation/study/geometry-sweep.toml");
  std::erase_if(study.cells, [](const StudyCells& cells) { return cells.methods.front() != "atwood/contacts"; });
  REQUIRE(study.cells.size() == 2);  // overlaps, and sweeps in time
  for (StudyCells& cells : study.cells) cells.methods = {"atwood/contacts"}, cells.steps = {2000};
  const Scenario scenario = read_scenario(ATWOOD_SOURCE_DIR "/validation/scenarios/geometry-sweep.toml");
  StudyOptions options;
  options.store_path = std::string(folder) + "/store.db";
  options.truth_worker = ATWOOD_BIN_DIR "/atwood-truth";
  const StudyResult result = run_study(plan_cells(study, {scenario}, workers, "cpu"), workers, options);
  CHECK(result.failed_cells == 0);

  const auto gates = read_gates(ATWOOD_SOURCE_DIR "/validation/gates/geometry.toml");
  const auto verdicts = judge(gates, result.rows);
  CHECK(verdicts.size() >= gates.size());
  for (const Verdict& verdict : verdicts) {
    INFO(verdict.text);
    CHECK(verdict.judgement == Judgement::pass);
  }
  std::size_t kept = 0;
  for (const auto& entry : fs::recursive_directory_iterator(fs::path(folder) / "poses")) {
    if (entry.path().extension() != ".toml") continue;
    CHECK(read_scenario(entry.path().string()).scene.bodies.size() == 2);
    ++kept;
  }
  CHECK(kept > 10);
  fs::remove_all(folder);
}

TEST_CASE("an engine that generates no poses is asked for the contacts of one after another") {
  char folder[] = "/tmp/atwood-poses-XXXXXX";
  REQUIRE(mkdtemp(folder) != nullptr);
  const auto workers = find_workers({ATWOOD_SOURCE_DIR "/validation/tests/study/workers/spheres.py"});
  Study study = read_study(ATWOOD_SOURCE_DIR "/validation/study/geometry-sweep.toml");
  study.cells.resize(1);
  study.cells.front().methods = {"spheres/contacts"};
  study.cells.front().steps = {300};
  const Scenario scenario = read_scenario(ATWOOD_SOURCE_DIR "/validation/scenarios/geometry-sweep.toml");
  StudyOptions options;
  options.store_path = std::string(folder) + "/store.db";
  options.truth_worker = ATWOOD_BIN_DIR "/atwood-truth";
  const StudyResult result = run_study(plan_cells(study, {scenario}, workers, "cpu"), workers, options);
  CHECK(result.failed_cells == 0);
  const auto row_of = [&](const std::string& pair, const std::string& metric) {
    for (const Row& row : result.rows)
      if (row.body == pair && row.metric == metric) return row;
    FAIL(pair << " has no row of " << metric);
    return Row{};
  };
  CHECK(row_of("sphere-sphere", "contact-misses").reason == "of 300 poses");
  CHECK(row_of("sphere-sphere", "contact-misses").value == 0);
  CHECK(row_of("sphere-sphere", "contact-false-hits").value == 0);
  CHECK(row_of("sphere-sphere", "contact-depth-error-max").value < 1e-12);
  CHECK(row_of("sphere-sphere", "contact-normal-error-max").value < 1e-12);
  CHECK(row_of("box-box", "contact-misses").status == Status::unsupported);
  CHECK(row_of("box-box", "contact-misses").reason == "spheres has no other shape");
  fs::remove_all(folder);
}

TEST_CASE("the tables ask the test of contacts that a method names") {
  char folder[] = "/tmp/atwood-tables-XXXXXX";
  REQUIRE(mkdtemp(folder) != nullptr);
  const auto workers = find_workers({ATWOOD_BIN_DIR "/atwood-engine", ATWOOD_BIN_DIR "/atwood-ode"});
  Study study = read_study(ATWOOD_SOURCE_DIR "/validation/study/geometry-tables.toml");
  study.cells.front().methods = {"atwood/contacts", "atwood/box-edges", "atwood/nonsense", "ode/unit-size"};
  const Scenario scenario = read_scenario(ATWOOD_SOURCE_DIR "/validation/scenarios/geometry-tables.toml");
  StudyOptions options;
  options.store_path = std::string(folder) + "/store.db";
  options.truth_worker = ATWOOD_BIN_DIR "/atwood-truth";
  const StudyResult result = run_study(plan_cells(study, {scenario}, workers, "cpu"), workers, options);
  const auto misses = [&](const std::string& method, const std::string& pair) {
    for (const Row& row : result.rows)
      if (row.method == method && row.body == pair && row.metric == "contact-misses") return row;
    FAIL(method << " has no row of " << pair);
    return Row{};
  };
  CHECK(misses("atwood/contacts", "box-box").value == 0);
  CHECK(misses("atwood/box-edges", "box-box").value > 0);  // one within the other: no edge meets a face
  CHECK(misses("atwood/box-edges", "sphere-box").status == Status::unsupported);
  CHECK(misses("atwood/nonsense", "box-box").status == Status::unsupported);
  CHECK(misses("ode/unit-size", "box-box").status == Status::ok);
  fs::remove_all(folder);
}

TEST_CASE("the tables of cases by hand pass their gates, and the truth agrees with every one") {
  char folder[] = "/tmp/atwood-tables-XXXXXX";
  REQUIRE(mkdtemp(folder) != nullptr);
  const auto workers = find_workers({ATWOOD_BIN_DIR "/atwood-engine", ATWOOD_BIN_DIR "/atwood-truth"});
  Study study = read_study(ATWOOD_SOURCE_DIR "/validation/study/geometry-tables.toml");
  study.cells.front().methods = {"atwood/contacts", "truth/contacts"};
  const Scenario scenario = read_scenario(ATWOOD_SOURCE_DIR "/validation/scenarios/geometry-tables.toml");
  StudyOptions options;
  options.store_path = std::string(folder) + "/store.db";
  options.truth_worker = ATWOOD_BIN_DIR "/atwood-truth";
  const StudyResult result = run_study(plan_cells(study, {scenario}, workers, "cpu"), workers, options);
  CHECK(result.failed_cells == 0);
  for (const char* method : {"atwood/contacts", "truth/contacts"}) {
    auto gates = read_gates(ATWOOD_SOURCE_DIR "/validation/gates/geometry_tables.toml");
    for (Gate& gate : gates) gate.method = method;
    for (const Verdict& verdict : judge(gates, result.rows)) {
      INFO(method << ": " << verdict.text);
      CHECK(verdict.judgement == Judgement::pass);
    }
  }
  fs::remove_all(folder);
}
