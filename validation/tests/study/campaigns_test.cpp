// Campaigns of foreign workers, and damaged entries of the store, which are measured again.
#include <set>

#include "lab.hpp"

using namespace atwood;

// A script whose code is not all known, as an --engine is.
struct ForeignLab : Lab {
  ForeignLab() {
    workers[0].foreign = true;
    REQUIRE_FALSE(workers[0].unknown_code.empty());
    options.timing = false;
  }
};

TEST_CASE("a script is measured anew by each run, its rows are read from the latest, and --reuse takes the last ones") {
  ForeignLab lab;
  const auto cells = lab.cells({"sound/straight", "faulty/well"}, {free_flight("one")});
  const auto run = [&](const std::string& run_id) {
    lab.options.provenance.run_id = run_id;
    return lab.run(cells);
  };
  const auto reused = [](const StudyResult& result) {
    std::string text;
    for (const Reused& each : result.reused)
      text += each.engine + " " + std::to_string(each.reused) + " of " + std::to_string(each.cells) + "; ";
    return text;
  };
  CHECK(reused(run("first")) == "sound 0 of 4; faulty 0 of 4; truth 0 of 1; ");
  const StudyResult second = run("second");
  CHECK(reused(second) == "sound 0 of 4; faulty 4 of 4; truth 1 of 1; ");
  CHECK_THAT(
      reused_text(second.reused),
      Catch::StartsWith(
          "reused from the store: sound 0 of 4 cells, faulty 4 of 4 cells, truth 1 of 1 scenes\nsound: a new campaign") &&
          Catch::Contains("python3") && Catch::Contains("fingerprint"));
  CHECK(lab.lines("sound.log") == 8);
  CHECK(find_row(second, "sound/straight", 64, "energy-max")->provenance->run_id == "second");
  CHECK(find_row(second, "faulty/well", 64, "energy-max")->provenance->run_id == "first");
  CHECK(texts(load_rows(lab.options.store_path, cells)) == texts(second));
  CHECK(load_series(lab.options.store_path, cells).size() == 8);
  lab.options.reuse = true;
  CHECK(reused(run("third")) == "sound 4 of 4; faulty 4 of 4; truth 1 of 1; ");
  lab.options.reuse = false;
  CHECK(texts(load_rows(lab.options.store_path, cells)) == texts(second));
  CHECK(lab.lines("sound.log") == 8);
  lab.run(cells);  // the same program again, as a search does
  CHECK(lab.lines("sound.log") == 8);
  lab.options.purpose = "compare";
  CHECK(reused(run("fourth")) == "sound 0 of 4; faulty 4 of 4; truth 1 of 1; ");
  CHECK(texts(load_rows(lab.options.store_path, cells)) == texts(second));
  lab.options.purpose = "run";
  lab.options.fresh = true;
  CHECK(reused(run("fifth")) == "sound 0 of 4; faulty 0 of 4; truth 0 of 1; ");
  CHECK(lab.lines("truth.log") == 2);
  CHECK(find_row(load_rows(lab.options.store_path, cells), "faulty/well", 8, "energy-max")->provenance->run_id ==
        "fifth");
  CHECK(check_store(lab.options.store_path).empty());
}

TEST_CASE("an interrupted run of a script resumes its campaign") {
  ForeignLab lab;
  const auto cells = lab.cells({"sound/slow"}, {free_flight("one"), free_flight("two", 4)});
  lab.options.jobs = 1;
  const int signal = GENERATE(SIGINT, SIGKILL);
  const pid_t child = apart([&] { return lab.run(cells).interrupted ? 42 : 1; });
  wait_for([&] { return lab.lines("sound.log") >= 4; });
  kill(child, signal);
  CHECK(ending(child) == (signal == SIGKILL ? -SIGKILL : 42));
  const int before = lab.lines("sound.log");
  REQUIRE(before < 8);
  const auto partial = load_rows(lab.options.store_path, cells);
  CHECK_FALSE(partial.rows.empty());
  lab.options.provenance.run_id = "resumed";
  const StudyResult resumed = lab.run(cells);
  CHECK(resumed.reused.at(0).reused >= 2);
  CHECK(lab.lines("sound.log") < before + 8);
  CHECK(find_row(resumed, "sound/slow", 8, "energy-max")->provenance->run_id == "run");
  lab.options.provenance.run_id = "next";
  CHECK(lab.run(cells).reused.at(0).reused == 0);
}

TEST_CASE("chunks of one run share a campaign, also when it starts anew") {
  ForeignLab lab;
  const auto cells = lab.cells({"sound/straight"}, {free_flight("one"), free_flight("two", 4)});
  REQUIRE(cells.size() == 8);
  lab.options.fresh = true;
  for (const char* run_id : {"first", "second"}) {
    lab.options.provenance.run_id = run_id;
    lab.options.shard = ShardOfPlan{"test", &cells, 1, 1, "", "--lease", false};
    lab.options.fresh = true;
    lab.options.shard->plan = lab.run({cells.begin(), cells.begin() + 4}).plan;
    CHECK_FALSE(lab.options.shard->plan.empty());
    CHECK(lab.run({cells.begin() + 4, cells.end()}).ran == 4);
    lab.options.fresh = false;  // the process takes a chunk again: its cells are looked up in the store
    CHECK(lab.run({cells.begin() + 2, cells.end()}).ran == 0);
    lab.options.shard->last = true;
    lab.run({});
    const StudyResult loaded = load_rows(lab.options.store_path, cells);
    std::set<std::string> measured;
    for (const Row& row : loaded.rows)
      if (row.metric == "energy-max" && row.provenance->run_id == run_id)
        measured.insert(row.scenario + std::to_string(row.steps));
    CHECK(measured.size() == 8);
  }
}

void execute(const std::string& store, const std::string& statement) {
  const std::string words =
      "import sqlite3; d = sqlite3.connect('" + store + "'); d.execute(\"" + statement + "\"); d.commit()";
  REQUIRE(ending(apart([&] { return execlp("python3", "python3", "-c", words.c_str(), nullptr); })) == 0);
}

TEST_CASE("a campaign or a provenance that is damaged is taken out, and what needs it runs again") {
  ForeignLab lab;
  std::vector<std::string> told;
  lab.options.notice = [&](const std::string& text) { told.push_back(text); };
  const auto cells = lab.cells({"sound/straight", "faulty/well"}, {free_flight("one")});
  const auto expected = texts(lab.run(cells));
  execute(lab.options.store_path, "UPDATE campaigns SET complete = 0");
  CHECK_THROWS_WITH(load_rows(lab.options.store_path, cells), Catch::Contains("new campaign"));
  CHECK(texts(lab.run(cells)) == expected);
  CHECK(told.size() == 1);
  CHECK(lab.lines("sound.log") == 8);
  execute(lab.options.store_path, "UPDATE provenances SET cpu = 'another'");
  CHECK_THROWS_WITH(load_rows(lab.options.store_path, cells), Catch::Contains("provenances"));
  CHECK(texts(lab.run(cells)) == expected);
  CHECK(told.size() == 1 + 1 + 8);  // the provenance that they share, and all cells
  CHECK(check_store(lab.options.store_path).empty());
}

TEST_CASE("cells and truths that are damaged are told by name and run again; the rest is not") {
  Lab lab;
  std::vector<std::string> told;
  lab.options.notice = [&](const std::string& text) { told.push_back(text); };
  const auto cells = lab.cells({"sound/straight"}, {free_flight("one")});
  const auto expected = texts(lab.run(cells));
  CHECK(told.empty());
  const std::string hash = cells[1].accuracy_hash;
  const auto damage = [&](const std::string& statement) { execute(lab.options.store_path, statement); };
  const auto again = [&] {
    told.clear();
    const StudyResult result = lab.run(cells);
    CHECK(texts(result) == expected);
    CHECK(check_store(lab.options.store_path).empty());
    return result.reused.at(0).reused;
  };
  damage("UPDATE series SET samples=zeroblob(length(samples)) WHERE hash='" + hash + "'");
  CHECK_FALSE(check_store(lab.options.store_path).empty());
  CHECK_THROWS_WITH(load_rows(lab.options.store_path, cells), Catch::Contains("one, sound/straight, 16 steps"));
  CHECK(again() == 3);
  REQUIRE(told.size() == 1);
  CHECK_THAT(told[0], Catch::Contains("the recording of the cell one, sound/straight, 16 steps is damaged"));
  damage("UPDATE measured SET rows=zeroblob(length(rows))");
  CHECK(again() == 0);
  CHECK(told.size() == 4);
  damage("UPDATE timings SET steps_taken=steps_taken+1 WHERE cell='" + hash + "'");
  CHECK(again() == 3);
  damage("UPDATE truths SET bars=zeroblob(length(bars))");
  damage("UPDATE cells SET reason='x' WHERE hash='" + hash + "'");
  CHECK(again() == 3);
  CHECK(told.size() == 2);
  CHECK(lab.lines("truth.log") == 2);
}
