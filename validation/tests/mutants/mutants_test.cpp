// A gate must be able to fail: every planted fault is caught by the gate that names it, and the engine without the
// fault passes that same gate. Faults of truths, metrics and judging are caught by a test case in the same way.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>

#include "scene/files.hpp"
#include "scene/pair_sweep.hpp"
#include "validation/gates/gates.hpp"
#include "validation/metrics/fluid.hpp"
#include "validation/metrics/metrics.hpp"
#include "validation/metrics/pose_metrics.hpp"
#include "validation/study/pose_sweep.hpp"
#include "validation/study/study.hpp"
#include "validation/study/worker_client.hpp"

using namespace atwood;
namespace fs = std::filesystem;

namespace {

// `motion`: the class of motion whose claimed order the gate is about (claims.toml); empty: the gate has its own
// numbers. `pair`: the shapes whose poses are swept, where the gate is about contacts; empty: the scenario moves.
// `test`, `test_case`: the program and the case that must catch the fault; empty: a gate must.
struct Mutant {
  std::string name, fault, scenario, method, metric, motion, pair, test, test_case;
};

// The head of a patch: lines "# key: value" before the difference itself.
Mutant read_head(const fs::path& path) {
  std::map<std::string, std::string> head;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line) && line.rfind("# ", 0) == 0;) {
    const auto colon = line.find(": ");
    if (colon != std::string::npos) head[line.substr(2, colon - 2)] = line.substr(colon + 2);
  }
  const char* needed[] = {"scenario", "method", "metric"};
  for (const char* key : needed)
    if (!head.contains("test") && !head.contains(key)) FAIL(path << ": no line `# " << key << ": `");
  return {path.stem().string(), head.at("fault"), head["scenario"], head["method"], head["metric"],
          head["motion"],       head["pair"],     head["test"],     head["case"]};
}

std::vector<Mutant> all_mutants() {
  std::vector<fs::path> paths;
  for (const auto& entry : fs::directory_iterator(ATWOOD_PATCH_DIR)) {
    if (entry.path().extension() == ".patch") paths.push_back(entry.path());
  }
  std::sort(paths.begin(), paths.end());
  std::vector<Mutant> mutants;
  for (const auto& path : paths) mutants.push_back(read_head(path));
  return mutants;
}

// What the sound engine's method claims.
std::vector<Claim> claims_of(const Mutant& mutant) {
  if (mutant.motion.empty()) return {};
  const auto workers = find_workers({ATWOOD_BIN_DIR "/atwood-engine"});
  const std::string base = mutant.method.substr(0, mutant.method.find('@'));
  for (const auto& info : workers.at(0).engine.methods) {
    if (info.id == base) return {{mutant.scenario, mutant.method, mutant.motion, info.claimed_order.at(mutant.motion)}};
  }
  FAIL("no method " << base);
  return {};
}

std::vector<Gate> gates_naming(const Mutant& mutant) {
  std::vector<Gate> named;
  for (const auto& entry : fs::directory_iterator(ATWOOD_SOURCE_DIR "/validation/gates")) {
    if (entry.path().extension() != ".toml") continue;
    for (const auto& gate : read_gates(entry.path().string())) {
      if (gate.metric == mutant.metric && glob_match(gate.scenario, mutant.scenario) &&
          glob_match(gate.method, mutant.method) && gate.kind != Gate::Kind::max_ratio) {
        named.push_back(gate);
      }
    }
  }
  return gates_of_claims(named, claims_of(mutant));
}

const Truth& truth_of(const Scenario& scenario) {
  static std::map<std::string, Truth> solved;
  auto found = solved.find(scenario.id);
  if (found == solved.end()) {
    found =
        solved.emplace(scenario.id, truth_once(ATWOOD_BIN_DIR "/atwood-truth", scenario, scenario.samples, 60)).first;
  }
  // Without a truth a scenario still has its invariants.
  REQUIRE(found->second.outcome.status == (scenario.truth.kind == TruthKind::none ? Status::unsupported : Status::ok));
  return found->second;
}

// The rows of a small sweep of seeded poses.
std::vector<Row> rows_of_poses(const std::string& path, const Mutant& mutant) {
  constexpr std::int64_t kPoses = 2000;  // a skipped axis parts one pose in a thousand alone
  const auto poses_of = [&](const std::string& worker) {
    WorkerClient client({worker});
    Outcome outcome;
    auto poses = client.sweep("contacts", mutant.pair, kPoseSeed, kPoses, false, 60, outcome);
    INFO(outcome.reason);
    REQUIRE(outcome.status == Status::ok);
    return poses;
  };
  const auto scene_of = [&](std::int64_t k) { return sweep_scene(mutant.pair, kPoseSeed, k, false); };
  const auto measured =
      measure_poses(mutant.pair, false, scene_of, poses_of(path), poses_of(ATWOOD_BIN_DIR "/atwood-truth"));
  std::vector<Row> rows = over_all_pairs(measured.rows);
  for (Row& row : rows) row.scenario = mutant.scenario, row.method = mutant.method, row.steps = kPoses;
  return rows;
}

Scenario scenario_of(const std::string& id) {
  for (const auto& entry : fs::recursive_directory_iterator(ATWOOD_SOURCE_DIR "/validation/scenarios"))
    if (entry.path().filename() == id + ".toml") return read_scenario(entry.path().string());
  FAIL("no scenario " << id);
  return {};
}

// Rows of a fluid: its truths are asked for at the particles of the run.
std::vector<Row> fluid_rows(const Scenario& scenario, const std::string& method, const Recording& run) {
  constexpr double kLimit_s = 60;
  static std::map<std::string, Truth> solved;  // the particles' own equations do not depend on the run
  const std::string worker = ATWOOD_BIN_DIR "/atwood-truth", response = method.substr(method.find('+') + 1);
  const auto field = [&](TruthKind kind, const std::vector<Wide>& t_s,
                         const std::vector<std::vector<FieldPosition>>& positions) {
    Scenario asked = scenario;
    asked.truth.kind = kind;
    return field_once(worker, asked, t_s, positions, kLimit_s, response);
  };
  const auto own_equations = [&] {
    auto [found, fresh] = solved.try_emplace(scenario.id + " " + response);
    if (fresh)
      found->second = WorkerClient({worker}).truth(scenario_to_json(scenario), sampled_bodies(scenario.scene),
                                                   scenario.t_end_s, scenario.samples, kLimit_s, response);
    return found->second;
  };
  return measure_fluid(scenario, fluid_truths(scenario, run, field, own_equations), run);
}

#if defined(__SANITIZE_ADDRESS__)
constexpr double kLimit_s = 600;
#else
constexpr double kLimit_s = 30;
#endif

// The rows of one scenario and method, whole ladder, by the engine at `path`.
std::vector<Row> rows_of(const std::string& path, const Mutant& mutant) {
  if (!mutant.pair.empty()) return rows_of_poses(path, mutant);
  const auto workers = find_workers({path});
  REQUIRE(workers.size() == 1);
  REQUIRE(workers[0].status == Status::ok);
  const Scenario scenario = scenario_of(mutant.scenario);
  const bool fluid = !scenario.scene.fluids.empty();
  std::vector<Row> rows;
  for (const auto steps : scenario.steps) {
    const Recording run =
        run_once(workers[0], mutant.method, scenario.scene, {scenario.t_end_s, steps, scenario.samples}, kLimit_s);
    for (auto row : fluid ? fluid_rows(scenario, mutant.method, run) : measure(scenario, truth_of(scenario), run)) {
      row.scenario = scenario.id;
      row.method = mutant.method;
      row.steps = steps;
      row.h_s = scenario.t_end_s / static_cast<double>(steps);
      rows.push_back(row);
    }
  }
  const auto ladder = fit_ladder(rows);
  rows.insert(rows.end(), ladder.begin(), ladder.end());
  return rows;
}

std::string words_of(const std::vector<Verdict>& verdicts) {
  std::string words;
  for (const auto& verdict : verdicts) words += "\n  " + to_string(verdict.judgement) + ": " + verdict.text;
  return words;
}

// Assertions of one test case.
struct Asserted {
  int passed = 0, failed = 0;
};

// Asks a test program for one of its cases, by its whole name. A program that ends without a summary has asserted
// nothing.
Asserted ask_case(const std::string& program, const std::string& test_case) {
  std::string pattern;
  for (const char c : test_case) {  // within '' of the shell, escaped from Catch2's syntax
    if (c == ',' || c == '[' || c == '\\') pattern += '\\';
    pattern += c == '\'' ? std::string("'\\''") : std::string(1, c);
  }
  FILE* pipe = popen(("'" + program + "' '" + pattern + "' --reporter xml").c_str(), "r");
  REQUIRE(pipe != nullptr);
  std::string text;
  char part[4096];
  for (std::size_t n; (n = fread(part, 1, sizeof part, pipe)) > 0;) text.append(part, n);
  pclose(pipe);
  Asserted asserted;
  const auto summary = text.rfind("<OverallResults successes=");
  if (summary != std::string::npos)
    std::sscanf(text.c_str() + summary, "<OverallResults successes=\"%d\" failures=\"%d\"", &asserted.passed,
                &asserted.failed);
  return asserted;
}

}  // namespace

// Sections, so that `mutants_test -c NAME` asks one mutant alone.
TEST_CASE("every mutant is caught by the gate that names its fault") {
  const auto mutants = all_mutants();
  REQUIRE(mutants.size() >= 12);
  static std::map<std::string, std::vector<Row>> sound;  // the unmutated engine's rows, by scenario and method
  for (const auto& mutant : mutants) {
    if (!mutant.test.empty()) continue;
    DYNAMIC_SECTION(mutant.name) {
      INFO(mutant.name << ": " << mutant.fault);
      const auto gates = gates_naming(mutant);
      REQUIRE(!gates.empty());

      auto [known, fresh] = sound.try_emplace(mutant.scenario + " " + mutant.method + " " + mutant.pair);
      if (fresh) known->second = rows_of(ATWOOD_BIN_DIR "/atwood-engine", mutant);
      const auto without = judge(gates, known->second);
      INFO("without the fault:" << words_of(without));
      CHECK(
          std::all_of(without.begin(), without.end(), [](const Verdict& v) { return v.judgement == Judgement::pass; }));

      const auto with = judge(gates, rows_of(std::string(ATWOOD_MUTANT_DIR) + "/mutant-" + mutant.name, mutant));
      INFO("with the fault:" << words_of(with));
      CHECK(std::any_of(with.begin(), with.end(), [](const Verdict& v) { return v.judgement == Judgement::fail; }));
    }
  }
}

TEST_CASE("every mutant of what judges an engine is caught by the test case that names its fault") {
  int asked = 0;
  for (const auto& mutant : all_mutants()) {
    if (mutant.test.empty()) continue;
    ++asked;
    DYNAMIC_SECTION(mutant.name) {
      INFO(mutant.name << ": " << mutant.fault);
      const Asserted without = ask_case(std::string(ATWOOD_TEST_PROGRAMS) + "/" + mutant.test, mutant.test_case);
      CHECK(without.passed > 0);
      CHECK(without.failed == 0);
      // Assertions that fail, not a program that ends without a summary.
      CHECK(ask_case(std::string(ATWOOD_MUTANT_DIR) + "/mutant-" + mutant.name, mutant.test_case).failed > 0);
    }
  }
  CHECK(asked > 0);
}
