// Study files and what becomes of them: cells and their hashes.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <set>
#include <tuple>

#include "scene/files.hpp"
#include "validation/tests/study/free_flight.hpp"

using namespace atwood;

namespace {

Worker worker(const std::string& name, std::vector<MethodInfo> methods) {
  Worker worker;
  worker.path = "bin/atwood-" + name;
  worker.command = {worker.path};
  worker.engine.name = name;
  worker.engine.version = "1";
  worker.engine.scalar = "double";
  worker.engine.methods = std::move(methods);
  worker.build_id = "build of " + name;
  return worker;
}

std::vector<Worker> table() {
  return {worker("demo", {{"demo/a", "", "", {}, false, {{"erp", 0.2}}}, {"demo/b", "", "", {}, true, {{"tol", 1.0}}}}),
          worker("other", {{"other/a", "", "", {}, false, {}}})};
}

std::vector<Cell> plan(StudyCells cells, std::vector<Worker> workers = table()) {
  return plan_cells({"test", {std::move(cells)}}, {free_flight("one"), free_flight("two", 4)}, workers, "cpu");
}

std::vector<std::string> ids(const std::vector<Cell>& cells) {
  std::vector<std::string> ids;
  for (const Cell& cell : cells)
    ids.push_back(cell.scenario->id + " " + cell.method + " " + std::to_string(cell.plan.steps));
  return ids;
}

Study read(const std::string& text) {
  Folder folder;
  std::ofstream(folder / "study.toml") << text;
  return read_study(folder / "study.toml");
}

}  // namespace

TEST_CASE("cells are scenarios x methods x rungs; globs go over what the engines list") {
  CHECK(ids(plan({{"one"}, {"demo/a"}, {}, 5, {}})) ==
        std::vector<std::string>{"one demo/a 8", "one demo/a 16", "one demo/a 32", "one demo/a 64"});
  CHECK(plan({{"tag:smooth"}, {"demo/*"}, {8}, 5, {}}).size() == 4);
  CHECK(ids(plan({{"t*"}, {"*/a+event@float"}, {16}, 5, {}})) ==
        std::vector<std::string>{"two demo/a+event@float 16", "two other/a+event@float 16"});
  CHECK(plan({{"tag:rough", "three"}, {"demo/*"}, {}, 5, {}}).empty());
}

TEST_CASE("endings that a block allows go with its cells, and with those that another block names as well") {
  StudyCells allowed{{"one"}, {"demo/a"}, {8}, 5, {}}, plain = allowed;
  allowed.allow = {Status::diverged};
  allowed.allow_reason = "it grows";
  for (const auto& [first, second] : {std::pair{allowed, plain}, {plain, allowed}}) {
    const auto cells =
        plan_cells({"test", {first, second}}, {free_flight("one"), free_flight("two", 4)}, table(), "cpu");
    REQUIRE(cells.size() == 1);
    CHECK(cells[0].allow == std::vector<Status>{Status::diverged});
  }
  CHECK(plan(plain)[0].allow.empty());
}

TEST_CASE(
    "the rungs of a ladder share samples, whatever blocks and the command line make of it; probes have their own") {
  Scenario scene = free_flight("one");
  scene.samples = 20;
  scene.steps = {320, 640, 1280};
  scene.truth.kind = TruthKind::closed_form;
  const auto samples = [&](std::vector<StudyCells> blocks) {
    std::map<std::string, std::int64_t> found;
    for (const Cell& cell : plan_cells({"test", std::move(blocks)}, {scene}, table(), "cpu")) {
      CHECK(cell.plan.steps % cell.plan.samples == 0);
      CHECK(own_plan(cell).samples == 20);
      found[cell.method + " " + std::to_string(cell.plan.steps)] = cell.plan.samples;
    }
    return found;
  };
  const StudyCells own{{"one"}, {"demo/a"}, {}, 5, {}}, beside{{"one"}, {"demo/a"}, {200}, 5, {}};
  for (const auto& [cell, shared] : samples({own})) CHECK(shared == 160);
  for (const auto& [cell, shared] : samples({own, beside})) CHECK(shared == 40);
  StudyCells filtered = beside, one = own;
  filtered.only_steps = {640};
  one.only_steps = {640};
  CHECK(samples({own, filtered}).at("demo/a 640") == 40);
  CHECK(samples({one}).at("demo/a 640") == 160);
  StudyCells coarse = own, tolerance{{"one"}, {"demo/b:1e-6"}, {}, 5, {}};
  coarse.whole_ladder = true, tolerance.whole_ladder = true;
  const auto whole = samples({coarse});
  CHECK(whole.at("demo/a 320") == 160);
  CHECK(whole.at("demo/a 80") == 80);
  CHECK(whole.at("demo/a 20") == 20);
  CHECK(samples({tolerance}) == std::map<std::string, std::int64_t>{{"demo/b:1e-6 160", 160}});
  StudyCells probe = own;
  probe.probe = Probe::reversal;
  for (const auto& [cell, shared] : samples({probe})) CHECK(shared == 20);
  // More samples are another run, and the same times.
  const Cell more = plan_cells({"test", {own}}, {scene}, table(), "cpu")[0],
             fewer = plan_cells({"test", {own, beside}}, {scene}, table(), "cpu")[0];
  REQUIRE(more.plan.steps == 320);
  REQUIRE(fewer.plan.steps == 320);
  CHECK(more.timing_hash == fewer.timing_hash);
  CHECK_FALSE(more.accuracy_hash == fewer.accuracy_hash);
}

TEST_CASE("a study's own scenes, engines and files start at its folder") {
  Folder folder;
  std::ofstream(folder / "engine.sh") << "";
  std::filesystem::permissions(folder / "engine.sh", std::filesystem::perms::owner_all);
  std::ofstream(folder / "data.txt") << "";
  std::ofstream(folder / "mine.toml") << "";
  std::ofstream(folder / "study.toml")
      << "id = \"s\"\nscenarios = [\"mine.toml\", \"tag:smooth\"]\ntolerances = \"gates.toml\"\n"
         "baseline = \"../b.tsv\"\nengines = [[\"./engine.sh\", \"data.txt\", \"--a/b\", \"other\"], "
         "\"engine.sh\", { command = [\"sh\", \"x/y\"], sandbox = false }]\n";
  const Study study = read_study(folder / "study.toml");
  const auto in = [&](const char* name) { return std::filesystem::path(folder / name).lexically_normal().string(); };
  REQUIRE(study.engines.size() == 3);
  CHECK(study.engines[0] == std::vector<std::string>{in("engine.sh"), in("data.txt"), "--a/b", "other"});
  CHECK(study.engines[1] == std::vector<std::string>{in("engine.sh")});
  CHECK(study.engines[2][0].ends_with("/sh"));
  CHECK(study.engines[2][0].front() == '/');
  CHECK(study.engines[2][1] == in("x/y"));
  CHECK(study.unconfined == std::set<std::vector<std::string>>{study.engines[2]});
  CHECK(study.tolerances == in("gates.toml"));
  CHECK(study.baseline == in("../b.tsv"));
  REQUIRE(study.cells.size() == 1);
  CHECK(study.cells[0].scenarios == std::vector<std::string>{in("mine.toml"), "tag:smooth"});
  CHECK(study.cells[0].methods.empty());  // all of the study's engines
}

TEST_CASE("with a tolerance the ladder is the tolerance: one rung") {
  CHECK(ids(plan({{"one"}, {"demo/b:1e-6", "demo/b:1e-9"}, {}, 5, {}})) ==
        std::vector<std::string>{"one demo/b:1e-6 8", "one demo/b:1e-9 8"});
}

TEST_CASE("a method that no engine provides is a cell without a worker, with the reason of the engine that failed") {
  std::vector<Worker> workers = table();
  Worker broken = worker("absent", {});
  broken.engine = {};
  broken.status = Status::not_built;
  broken.reason = "cannot be started";
  workers.push_back(broken);
  const auto cells = plan({{"one"}, {"absent/*", "unknown/x", "demo/missing"}, {8}, 5, {}}, workers);
  REQUIRE(cells.size() == 3);
  for (const Cell& cell : cells) CHECK(cell.worker == -1);
  CHECK(cells[0].absent_reason == "cannot be started");
  CHECK(cells[1].absent_reason == "no available engine provides unknown/x");
  CHECK(cells[2].absent == Status::not_built);
}

TEST_CASE("a sweep makes a cell of each value, where the method has the setting") {
  const auto cells = plan({{"one"}, {"demo/a", "demo/b"}, {8}, 5, {{"erp", {0.0, 0.1}}}});
  CHECK(ids(cells) == std::vector<std::string>{"one demo/a{erp=0.0} 8", "one demo/a{erp=0.1} 8", "one demo/b 8"});
}

TEST_CASE("a sweep includes settings of a response; a setting that no method has is an error of input") {
  std::vector<Worker> workers = table();
  workers[0].engine.responses = {{"+event", "", "", {}, false, {{"restitution", std::string("newton")}}}};
  const std::map<std::string, std::vector<SettingValue>> laws{
      {"restitution", {std::string("newton"), std::string("poisson")}}};
  CHECK(ids(plan({{"one"}, {"demo/a", "demo/a+event", "demo/b+event"}, {8}, 5, laws}, workers)) ==
        std::vector<std::string>{"one demo/a 8", "one demo/a+event{restitution=newton} 8",
                                 "one demo/a+event{restitution=poisson} 8", "one demo/b+event{restitution=newton} 8",
                                 "one demo/b+event{restitution=poisson} 8"});
  CHECK_THROWS_WITH(plan({{"one"}, {"demo/a", "demo/b"}, {8}, 5, laws}, workers),
                    Catch::Contains("`restitution`") && Catch::Contains("demo/a, demo/b"));
  CHECK(plan({{"one"}, {"demo/a", "unknown/x"}, {8}, 5, laws}, workers).size() == 3);  // an absent engine may have it
}

TEST_CASE("a block's limit goes with its cells") {
  const Study study = read("id = 'x'\n[[cells]]\nscenarios = ['one']\nmethods = ['demo/a']\nlimit = 120\n");
  CHECK(study.cells[0].limit_s == 120);
  CHECK(plan(study.cells[0]).at(0).limit_s == 120);
  CHECK(plan({{"one"}, {"demo/a"}, {8}, 5, {}}).at(0).limit_s == 0);
  CHECK_THROWS_WITH(read("id = 'x'\n[[cells]]\nscenarios = ['one']\nmethods = ['demo/a']\nlimit = 'long'\n"),
                    Catch::Contains("study.toml:5:9:") && Catch::Contains("seconds"));
}

TEST_CASE("a cell named twice is planned once") {
  const Study study{"test", {{{"one"}, {"demo/a"}, {8}, 3, {}}, {{"*"}, {"demo/*"}, {8}, 5, {}}}};
  const auto cells = plan_cells(study, {free_flight("one")}, table(), "cpu");
  REQUIRE(cells.size() == 2);
  CHECK(cells[0].repeats == 5);
}

TEST_CASE("a response's claim for the value of a setting bounds the order that a method claims") {
  std::vector<Worker> workers = table();
  workers[0].engine.methods[0].claimed_order = {{"fluid", 4}};
  workers[0].engine.methods[1].claimed_order = {{"point-mass", 8}};
  MethodInfo pairs{"+sph", "", "", {{"fluid{kernel=cubic}", 3}, {"fluid{kernel=smooth}", 6}}, false, {}};
  pairs.settings["kernel"] = std::string("smooth");
  workers[0].engine.responses = {pairs};
  StudyCells cells{{"one"}, {"demo/a+sph", "demo/a+sph{kernel=cubic}", "demo/a", "demo/b+sph"}, {8}, 0};
  cells.claim = "fluid";
  const std::vector<Cell> planned = plan(cells, workers);
  REQUIRE(planned.size() == 3);
  CHECK(planned[0].claimed_order == 4);
  CHECK(planned[1].claimed_order == 3);
  CHECK(planned[2].claimed_order == 4);
  cells.sweep["kernel"] = {std::string("cubic"), std::string("smooth")};
  cells.methods = {"demo/a+sph"};
  const std::vector<Cell> swept = plan(cells, workers);
  REQUIRE(swept.size() == 2);
  CHECK(swept[0].claimed_order == 3);
  CHECK(swept[1].claimed_order == 4);
}

TEST_CASE("cells of a claim: only methods that claim an order in that class of motion, within the orders asked for") {
  std::vector<Worker> workers = table();
  workers[0].engine.methods[0].claimed_order = {{"point-mass", 4}, {"rotation", 2}};
  workers[0].engine.methods[1].claimed_order = {{"point-mass", 8}};
  StudyCells cells{{"one"}, {"demo/*@quad", "other/*"}, {8}, 0};
  cells.claim = "point-mass";
  cells.least_order = 3;
  cells.most_order = 6;
  const std::vector<Cell> planned = plan(cells, workers);
  REQUIRE(ids(planned) == std::vector<std::string>{"one demo/a@quad 8"});
  CHECK(planned[0].claim == "point-mass");
  CHECK(planned[0].claimed_order == 4);
  CHECK(planned[0].repeats == 0);
  cells.except = {"demo/?"};
  CHECK(plan(cells, workers).empty());
  cells.except = {"demo/b"};
  CHECK(plan(cells, workers).size() == 1);
  cells.claim = "rotation";
  CHECK(plan(cells, workers).empty());

  const Study study = read(
      "id = 'x'\n[[cells]]\nscenarios = ['a']\nmethods = ['b/*']\nexcept = ['b/d*']\nclaim = 'rotation'\norders = [2, 3]\ntiming = false\n");
  CHECK(study.cells[0].except == std::vector<std::string>{"b/d*"});
  CHECK(study.cells[0].claim == "rotation");
  CHECK(study.cells[0].most_order == 3);
  CHECK(study.cells[0].repeats == 0);
  CHECK_THROWS_WITH(read("id = 'x'\n[[cells]]\nscenarios = ['a']\nmethods = ['b/c']\nclaim = 'flight'\n"),
                    Catch::Contains(":5:") && Catch::Contains("class of motion"));
  CHECK_THROWS_WITH(read("id = 'x'\n[[cells]]\nscenarios = ['a']\nmethods = ['b/c']\norders = [1, 2]\n"),
                    Catch::Contains("found `orders` without `claim`"));
  CHECK_THROWS_WITH(
      read("id = 'x'\n[[cells]]\nscenarios = ['a']\nmethods = ['b/c']\nclaim = 'rotation'\norders = [6, 4]\n"),
      Catch::Contains(":6:10: `orders` is ") && Catch::Contains("; expected the lower order first"));
}

TEST_CASE("a hash changes with all that decides a run, and with nothing else") {
  const auto hash = [](const std::function<void(Scenario&, std::vector<Worker>&, StudyCells&, std::string&)>& change) {
    Scenario scenario = free_flight("one");
    std::vector<Worker> workers = table();
    StudyCells cells{{"*"}, {"demo/a"}, {8}, 5, {}};
    std::string cpu = "cpu";
    change(scenario, workers, cells, cpu);
    return plan_cells({"test", {cells}}, {scenario}, workers, cpu).at(0);
  };
  const Cell plain = hash([](auto&, auto&, auto&, auto&) {});
  std::set<std::string> hashes{plain.accuracy_hash};
  const auto changed = [&](const Cell& cell) { return hashes.insert(cell.accuracy_hash).second; };
  CHECK(changed(hash([](auto& s, auto&, auto&, auto&) { s.scene.bodies[0].mass_kg = 2; })));
  CHECK(changed(hash([](auto& s, auto&, auto&, auto&) { s.t_end_s = 3; })));
  CHECK(changed(hash([](auto& s, auto&, auto&, auto&) { s.samples = 4; })));
  CHECK(changed(hash([](auto&, auto&, auto& c, auto&) { c.steps = {16}; })));
  CHECK(changed(hash([](auto&, auto&, auto& c, auto&) { c.methods = {"demo/b"}; })));
  CHECK(changed(hash([](auto&, auto&, auto& c, auto&) { c.methods = {"demo/a@float"}; })));
  CHECK(changed(hash([](auto&, auto& w, auto&, auto&) { w[0].build_id = "another build"; })));
  CHECK(changed(hash([](auto&, auto& w, auto&, auto&) { w[0].engine.version = "2"; })));
  CHECK(changed(hash([](auto&, auto& w, auto&, auto&) { w[0].engine.methods[0].settings["erp"] = 0.3; })));
  CHECK_FALSE(changed(hash([](auto& s, auto&, auto&, auto&) { s.claim = "said otherwise"; })));
  CHECK_FALSE(changed(hash([](auto&, auto& w, auto&, auto&) { w[1].build_id = "another build"; })));
  const Cell elsewhere = hash([](auto&, auto&, auto&, auto& cpu) { cpu = "another cpu"; });
  CHECK(elsewhere.accuracy_hash == plain.accuracy_hash);
  CHECK(elsewhere.timing_hash != plain.timing_hash);
}

TEST_CASE("a hash changes with the processor's features and the mathematical library") {
  const StudyCells cells{{"one"}, {"demo/a"}, {8}, 5, {}};
  const auto hash = [&](const std::string& arithmetic) {
    return plan_cells({"test", {cells}}, {free_flight("one")}, table(), "cpu", kMaxCells, arithmetic)
        .at(0)
        .accuracy_hash;
  };
  CHECK(hash("avx2 fma; glibc 2.36") == hash("avx2 fma; glibc 2.36"));
  CHECK(hash("avx2 fma; glibc 2.36") != hash("avx2; glibc 2.36"));
  CHECK(hash("avx2 fma; glibc 2.36") != hash("avx2 fma; glibc 2.37"));
  CHECK(plan(cells).at(0).accuracy_hash == hash(machine_arithmetic()));
}

TEST_CASE("the processor's features tell what glibc was told of them, and nothing else of its tunables") {
  unsetenv("GLIBC_TUNABLES");
  const std::string plain = processor_features();
  CHECK(plain.find("glibc") == std::string::npos);
  setenv("GLIBC_TUNABLES", "glibc.malloc.check=1:glibc.cpu.hwcaps=-AVX2_Usable,-FMA_Usable", 1);
  CHECK(processor_features() == plain + " glibc.cpu.hwcaps=-AVX2_Usable,-FMA_Usable");
  setenv("GLIBC_TUNABLES", "glibc.malloc.check=1", 1);
  CHECK(processor_features() == plain);
  unsetenv("GLIBC_TUNABLES");
  CHECK(libm_version().rfind("glibc 2.", 0) == 0);
}

TEST_CASE("only a foreign worker whose code is not all known is measured in campaigns") {
  const StudyCells cells{{"one"}, {"demo/a"}, {8}, 5, {}};
  std::vector<Worker> workers = table();
  workers[0].unknown_code = "it is run by python3";
  CHECK(plan(cells, workers).at(0).campaign.empty());
  workers[0].foreign = true;
  const Cell cell = plan(cells, workers).at(0);
  CHECK_FALSE(cell.campaign.empty());
  workers[0].build_id = "another build";
  CHECK(plan(cells, workers).at(0).campaign != cell.campaign);
  workers[0].unknown_code.clear();
  CHECK(plan(cells, workers).at(0).campaign.empty());
}

TEST_CASE("too many cells are refused by their number, before they are made") {
  StudyCells cells{{"one"}, {"demo/a"}, {8}, 5, {}};
  const auto planned = [&](std::int64_t most, std::vector<StudyCells> blocks) {
    return plan_cells({"test", std::move(blocks)}, {free_flight("one")}, table(), "cpu", most).size();
  };
  CHECK(planned(1, {cells}) == 1);
  CHECK(planned(1, {cells, cells, cells}) == 1);  // the same cell three times
  cells.steps = {8, 16};
  CHECK_THROWS_WITH(planned(1, {cells}),
                    Catch::Contains("up to 2 cells") && Catch::Contains("at most 1") && Catch::Contains("--max-cells"));
  cells.methods = {"demo/b:1e-6"};
  cells.steps = {8, 16, 32, 64, 8, 16, 32, 64};
  CHECK(planned(1, {cells}) == 1);  // with a tolerance: one rung
  std::vector<Worker> workers = table();
  workers[0].engine.methods[0].settings = {{"a", 0.0}, {"b", 0.0}, {"c", 0.0}, {"d", 0.0}, {"e", 0.0}};
  cells.methods = {"demo/a"};
  for (const char* key : {"a", "b", "c"})
    for (int i = 0; i < 300; ++i) cells.sweep[key].emplace_back(static_cast<double>(i));
  CHECK_THROWS_WITH(plan(cells, workers), Catch::Contains("216000000 cells"));  // 300^3 x 8 steps
  cells.sweep["d"] = cells.sweep["e"] = std::vector<SettingValue>(1'000'000, 1.0);
  CHECK_THROWS_WITH(plan(cells, workers), Catch::Contains("more than 10^18 cells"));
}

TEST_CASE("a name of any length leaves a message short") {
  StudyCells cells{{"one"}, {"demo/a"}, {8}, 5, {{std::string(100'000, 'k'), {0.5}}}};
  try {
    plan(cells);
    FAIL("not refused");
  } catch (const InputError& error) {
    CHECK(std::string(error.what()).size() < 1000);
    CHECK_THAT(error.what(), Catch::Contains("kk [... 99800 bytes ...] kk"));
  }
}

TEST_CASE("endings that a block allows are allowed in its cells, also where another block names them") {
  StudyCells plain{{"one"}, {"demo/a"}, {8}, 5, {}}, allowing = plain;
  allowing.allow = {Status::diverged};
  for (const int repeats : {3, 5, 7}) {
    allowing.repeats = repeats;
    for (const auto& blocks : {std::vector{plain, allowing}, std::vector{allowing, plain}})
      CHECK(plan_cells({"test", blocks}, {free_flight("one")}, table(), "cpu").at(0).allow == allowing.allow);
  }
}

TEST_CASE("settings are checked against the engine's rules, and nothing is run for it") {
  std::vector<Worker> workers{worker("demo", {{"demo/a", "", "", {}, false, {}}})};  // its program does not exist
  declare_settings(workers[0].engine.methods[0], {{"n", std::int64_t(1), {between(0, 9), "A count."}}});
  workers[0].engine.responses.push_back({"+impulse", "", "", {}, false, {}});
  declare_settings(workers[0].engine.responses[0], {{"n", std::int64_t(1), {between(0, 5), "A count."}},
                                                    {"law", std::string("a"), {one_of({"a", "b"}), "A law."}}});
  const auto check = [&](const std::string& method) { check_settings("--method ", method, workers); };
  CHECK_NOTHROW(check("demo/a{n=9}"));
  CHECK_NOTHROW(check("demo/a+impulse{n=5,law=b}"));
  CHECK_THROWS_WITH(check("demo/a{n=10}"),
                    "--method demo/a{n=10}: demo/a: `n` is `10`; expected a whole number from 0 to 9");
  CHECK_THROWS_WITH(check("demo/a+impulse{n=6}"),
                    Catch::Contains("+impulse: `n` is `6`; expected a whole number from 0"));
  CHECK_THROWS_WITH(check("demo/a+impulse{law=c}"), Catch::Contains("+impulse: `law` is `c`; expected a or b"));
  CHECK_THROWS_WITH(check("demo/a{law=a}"), Catch::Contains("demo/a has no setting `law`; expected one of n"));
}

TEST_CASE("a probe is a cell of its own, beside the plain one; ladders of probes are plain cells") {
  const Scenario scenario = free_flight("one");
  std::vector<Worker> workers = table();
  workers[0].engine.methods[0].adaptive = true;
  workers[0].engine.methods[0].settings["compensated"] = false;
  StudyCells plain{{"*"}, {"demo/a"}, {8}, 5, {}}, probe = plain;
  probe.probe = Probe::reversal;
  const auto cells = plan_cells({"test", {plain, probe, probe}}, {scenario}, workers, "cpu");
  REQUIRE(cells.size() == 2);
  CHECK(cells[0].probe == Probe::none);
  CHECK(cells[1].probe == Probe::reversal);
  CHECK(cells[1].repeats == 0);
  CHECK(cells[0].accuracy_hash != cells[1].accuracy_hash);
  probe.probe = Probe::tolerance;
  const auto tolerances = plan_cells({"test", {probe}}, {scenario}, workers, "cpu");
  REQUIRE(tolerances.size() == 10);
  CHECK(tolerances[0].method == "demo/a:1e-3");
  CHECK(tolerances[0].probe == Probe::none);
  probe.probe = Probe::round_off_v;
  CHECK(plan_cells({"test", {probe}}, {scenario}, workers, "cpu").size() == 6);
}

TEST_CASE("a study file is read, and its errors have a place") {
  const Study study = read(
      "id = 'x'\n[[cells]]\nscenarios = ['a*']\nmethods = ['demo/*']\nsteps = [64]\nrepeats = 2\n"
      "sweep = { erp = [0.0, 0.1], n = [1], on = [true], kind = ['a'] }\n");
  CHECK(study.id == "x");
  REQUIRE(study.cells.size() == 1);
  CHECK(study.cells[0].repeats == 2);
  CHECK(study.cells[0].sweep.size() == 4);
  CHECK_THROWS_WITH(read("id = 'x'\n[[cells]]\nscenario = ['a']\nmethods = ['demo/*']\n"),
                    Catch::Contains("study.toml:3:1: unknown key `scenario`"));
  CHECK_THROWS_WITH(read("id = 'x'\n[[cells]]\nscenarios = ['a']\nmethods = ['rk4']\n"),
                    Catch::Contains("study.toml:4:") && Catch::Contains("expected <engine>/<scheme>"));
  CHECK_THROWS_WITH(read("id = 'x'\n[[cells]]\nscenarios = ['a']\nmethods = ['demo/a']\nsteps = [0]\n"),
                    Catch::Contains("study.toml:5:10:"));
  CHECK(read("id = 'x'\n[[cells]]\nprobe = 'reversal'\nscenarios = ['a']\nmethods = ['demo/a']\n").cells[0].probe ==
        Probe::reversal);
  CHECK_THROWS_WITH(
      read("id = 'x'\n[[cells]]\nprobe = 'astrology'\nscenarios = ['a']\nmethods = ['demo/a']\n"),
      Catch::Contains("study.toml:3:9:") && Catch::Contains("`probe` is \"astrology\"; expected one of ensemble"));
  CHECK_THROWS_WITH(read("id = 'x'\n[[cells]\n"), Catch::Contains("study.toml:2:"));
  for (const char* text :
       {"", "id = 'x'\n", "id = 7\n", "id = 'x'\ncells = 7\n", "id = 'x'\n[[cells]]\nscenarios = []\n"}) {
    CHECK_THROWS_AS(read(text), InputError);
  }
  CHECK_THROWS_AS(read_study("/nowhere/study.toml"), InputError);
  CHECK_THROWS_AS(plan({{"one"}, {"demo/a"}, {12}, 5, {}}), InputError);  // 8 samples do not divide 12 steps
}

namespace {

Scenario fluid() {
  return read_scenario_text(
      "id = \"flow\"\n[run]\nt_end_s = 1\nsteps = [8, 16]\nsamples = 4\nspacings_m = [0.5, 0.25, 0.2]\n"
      "sound_speeds_m_per_s = [10, 20]\n[domain]\ndimensions = 2\nperiodic_m = [1, 1]\n[[fluid]]\nname = \"w\"\n"
      "density_kg_per_m3 = 1\nregion.box = { min_m = [0, 0], max_m = [1, 1] }\n[truth]\nkind = \"none\"\n",
      "t.toml", ".");
}

std::vector<Worker> flowing() {
  std::vector<Worker> workers = table();
  workers[0].engine.fluids = true;
  return workers;
}

std::vector<Cell> plan_fluid(StudyCells cells) {
  return plan_cells({"test", {std::move(cells)}}, {fluid()}, flowing(), "cpu");
}

}  // namespace

TEST_CASE("a fluid's cells are spacings x sound speeds x rungs, with steps that keep the Courant number") {
  const std::vector<Cell> cells = plan_fluid({{"flow"}, {"demo/a"}, {}, 5, {}});
  std::set<std::tuple<double, double, std::int64_t>> found;
  std::set<std::string> hashes;
  for (const Cell& cell : cells) {
    found.insert({*cell.spacing_m, *cell.sound_speed_m_per_s, cell.plan.steps});
    hashes.insert(cell.accuracy_hash);
    const Fluid& fluid = cell.scenario->scene.fluids[0];
    CHECK(fluid.spacing_m == cell.spacing_m);
    CHECK(fluid.sound_speed_m_per_s == cell.sound_speed_m_per_s);
    CHECK(fluid.particles.position_m.size() ==
          static_cast<std::size_t>(std::llround(1 / (fluid.spacing_m * fluid.spacing_m))));
  }
  CHECK(cells.size() == 12);
  CHECK(hashes.size() == 12);
  // 8 x 0.5 / 0.2 = 20, 16 x 2.5 = 40; 0.25 at 20 m/s takes as many steps as 0.125 at 10 m/s would, and is another
  // cell.
  CHECK(found == std::set<std::tuple<double, double, std::int64_t>>{{0.5, 10, 8},
                                                                    {0.5, 10, 16},
                                                                    {0.5, 20, 16},
                                                                    {0.5, 20, 32},
                                                                    {0.25, 10, 16},
                                                                    {0.25, 10, 32},
                                                                    {0.25, 20, 32},
                                                                    {0.25, 20, 64},
                                                                    {0.2, 10, 20},
                                                                    {0.2, 10, 40},
                                                                    {0.2, 20, 40},
                                                                    {0.2, 20, 80}});
}

TEST_CASE("steps that are given with a spacing are that spacing's own; rounded up to whole samples") {
  StudyCells one{{"flow"}, {"demo/a"}, {24}, 5, {}};
  one.spacings_m = {0.25};
  const std::vector<Cell> cells = plan_fluid(one);
  REQUIRE(cells.size() == 2);
  CHECK(cells[0].plan.steps == 24);
  CHECK(cells[1].plan.steps == 24);
  StudyCells odd{{"flow"}, {"demo/a"}, {}, 5, {}};
  odd.spacings_m = {1.0 / 3};
  odd.sound_speeds_m_per_s = {10};
  const std::vector<Cell> thirds = plan_fluid(odd);
  REQUIRE(thirds.size() == 2);
  CHECK(thirds[0].plan.steps == 12);  // 8 x 1.5
  odd.spacings_m = {0.1};
  odd.sound_speeds_m_per_s = {11};
  CHECK(plan_fluid(odd)[0].plan.steps == 44);  // 8 x 5.5
  odd.spacings_m = {0.3};
  CHECK_THROWS_WITH(plan_fluid(odd), Catch::Contains("does not fill"));
}

TEST_CASE("an engine that knows no fluids refuses them by name") {
  const std::vector<Cell> cells = plan_fluid({{"flow"}, {"other/a"}, {}, 5, {}});
  REQUIRE(cells.size() == 12);
  CHECK(cells[0].worker == -1);
  CHECK(cells[0].absent == Status::unsupported);
  CHECK(cells[0].absent_reason == "other simulates no fluids");
}
