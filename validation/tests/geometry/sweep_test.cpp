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
