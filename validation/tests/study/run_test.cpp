// A study from its cells to its rows: reused cells, failed cells, truths, progress.
#include <map>
#include <set>

#include "lab.hpp"
#include "validation/study/progress.hpp"

using namespace atwood;

TEST_CASE("a study gives rows of every cell, and a second run of it does no work") {
  const Lab lab;
  const auto cells = lab.cells({"sound/straight", "faulty/well"}, {free_flight("one"), free_flight("two", 4)});
  REQUIRE(cells.size() == 16);
  const StudyResult first = lab.run(cells);
  CHECK(first.cells == 16);
  CHECK(first.skipped == 0);
  CHECK(first.failed_cells == 0);
  CHECK_FALSE(first.interrupted);
  for (const Cell& cell : cells) {
    for (const char* metric : {"error-position-max", "step-time", "run-time"}) {
      const auto has = [&](const Row& row) {
        return row.scenario == cell.scenario->id && row.method == cell.method && row.steps == cell.plan.steps &&
               row.metric == metric;
      };
      CHECK(std::count_if(first.rows.begin(), first.rows.end(), has) == 1);
    }
  }
  const Row* time = find_row(first, "sound/straight", 64, "step-time");
  REQUIRE(time);
  CHECK(time->value == Approx(1e-6));  // the fake says 1000 ns a step
  CHECK(time->h_s == 2.0 / 64);
  CHECK(time->provenance->engine_version == "1");
  CHECK(find_row(first, "sound/straight", 64, "error-position-max")->value < 1e-14);
  CHECK(lab.lines("sound.log") == 16);  // 8 cells, each once for accuracy and once for time
  CHECK(lab.lines("truth.log") == 2);   // one a scenario

  const StudyResult second = lab.run(cells);
  CHECK(second.skipped == 16);
  CHECK(texts(second) == texts(first));
  CHECK(lab.lines("sound.log") == 16);
  CHECK(lab.lines("truth.log") == 2);
  CHECK(texts(load_rows(lab.options.store_path, cells)) == texts(first));
  const auto series = load_series(lab.options.store_path, cells);
  REQUIRE(series.size() == 16);
  CHECK(series[0].series.t_s.size() == 9);
  CHECK(lab.file_list() == "store.db ");
}

TEST_CASE("every metric of a study's rows is in the list of metrics, with its unit") {
  const Lab lab;
  std::vector<Cell> cells =
      lab.cells({"sound/straight", "faulty/refuses", "faulty/dies"}, {free_flight("one"), free_flight("no-truth", 4)});
  for (Cell& cell : cells)
    if (cell.method == "sound/straight" && cell.plan.steps == 8) cell.method = "sound/straight:1e-6";
  Cell absent = cells.front();
  absent.method = "other/method";
  absent.worker = -1;
  cells.push_back(absent);
  std::map<std::string, std::string> units;
  for (const MetricInfo& metric : all_metrics()) units[metric.name] = metric.unit;
  std::set<std::string> emitted;
  for (const Row& row : lab.run(cells).rows) {
    emitted.insert(row.metric);
    INFO(row.metric);
    REQUIRE(units.count(row.metric) == 1);
    if (row.status == Status::ok) CHECK(row.unit == units[row.metric]);
  }
  for (const char* metric : {"status", "truth", "run-time", "step-time", "steps-taken", "error-position-max"}) {
    INFO(metric);
    CHECK(emitted.count(metric) == 1);
  }
}

TEST_CASE("a new rung runs alone, and a changed engine runs its cells again and no others") {
  Lab lab;
  Scenario scenario = free_flight("one");
  scenario.steps = {8, 16};
  const std::string copy = lab.folder / "sound.py";
  std::filesystem::copy_file(fakes + "/sound.py", copy);
  std::filesystem::copy_file(fakes + "/speak.py", lab.folder / "speak.py");
  lab.workers = lab.found({copy, fakes + "/faulty.py"});
  lab.run(lab.cells({"sound/straight", "faulty/well"}, {scenario}));
  CHECK(lab.lines("sound.log") == 4);
  scenario.steps = {8, 16, 32};
  CHECK(lab.run(lab.cells({"sound/straight", "faulty/well"}, {scenario})).skipped == 4);
  CHECK(lab.lines("sound.log") == 6);
  std::ofstream(copy, std::ios::app) << "# changed\n";
  lab.workers = lab.found({copy, fakes + "/faulty.py"});
  const StudyResult after = lab.run(lab.cells({"sound/straight", "faulty/well"}, {scenario}));
  CHECK(after.skipped == 3);  // faulty's
  CHECK(lab.lines("sound.log") == 12);
}

TEST_CASE("cells that fail are rows with a reason, counted, and found again") {
  Lab lab;
  lab.options.cell_limit_s = 1;
  const auto cells = lab.cells({"faulty/dies", "faulty/refuses", "faulty/nan_late", "faulty/hangs", "unknown/x"},
                               {free_flight("one")});
  const StudyResult result = lab.run(cells);
  const auto status = [&](const std::string& method, std::int64_t steps) {
    const Row* row = find_row(result, method, steps, "status");
    REQUIRE(row);
    return to_string(row->status) + ": " + row->reason;
  };
  CHECK_THAT(status("faulty/dies", 8), Catch::StartsWith("crashed: killed by signal 11"));
  CHECK(status("faulty/refuses", 64) == "unsupported: faulty has no springs");
  CHECK_THAT(status("faulty/nan_late", 16), Catch::StartsWith("not finite"));
  CHECK(status("faulty/hangs", 8) == "timeout: no answer within 1 s");
  CHECK_THAT(status("faulty/hangs", 16), Catch::StartsWith("timeout: not tried: 8 steps"));
  CHECK(status("unknown/x", 8) == "not built: no available engine provides unknown/x");
  CHECK(result.failed_cells == 8);  // dies and hangs, four rungs each
  CHECK_FALSE(find_row(result, "faulty/dies", 8, "step-time"));
  const StudyResult again = lab.run(cells);
  CHECK(again.skipped == again.cells);
  CHECK(texts(again) == texts(result));
  CHECK(again.failed_cells == 8);
}

TEST_CASE("a truth has a limit of its own") {
  Lab lab;
  lab.options.truth_limit_s = 0.3;
  const StudyResult result = lab.run(lab.cells({"sound/straight"}, {free_flight("slow-truth")}));
  const Row* truth = find_row(result, "sound/straight", 8, "truth");
  REQUIRE(truth);
  CHECK(to_string(truth->status) + ": " + truth->reason == "timeout: no answer within 0.3 s");
}

TEST_CASE("a truth that fails leaves the rest measured, and is asked again") {
  const Lab lab;
  const auto cells = lab.cells({"sound/straight"}, {free_flight("no-truth")});
  const StudyResult result = lab.run(cells);
  CHECK(result.failed_cells >= 1);
  CHECK_FALSE(find_row(result, "sound/straight", 8, "error-position-max"));
  CHECK(find_row(result, "sound/straight", 8, "energy-max"));
  const Row* truth = find_row(result, "sound/straight", 8, "truth");
  REQUIRE(truth);
  CHECK(truth->status == Status::crashed);
  CHECK(truth->reason == "exited with code 9");
  CHECK(lab.lines("truth.log") == 1);
  lab.run(cells);
  CHECK(lab.lines("truth.log") == 2);
  CHECK(lab.lines("sound.log") == 8);  // the runs themselves are not
}

TEST_CASE("progress is told, with an estimate, no more than twice a second by its clock") {
  Progress::Clock::time_point now{};
  std::vector<std::string> said;
  Progress progress(
      0, [&](const std::string& line) { said.push_back(line); }, [&] { return now; });
  progress.expect(12, 2);
  const auto after = [&](int milliseconds, const char* what) {
    now += std::chrono::milliseconds(milliseconds);
    progress.done(what);
  };
  after(10'000, "truth");
  after(10'000, "truth");
  after(400, "accuracy");  // too soon after the last line
  after(600, "accuracy");
  for (int i = 0; i < 8; ++i) after(1, "accuracy");
  REQUIRE(said.size() == 3);
  CHECK(said[0] == "truth: 1 of 12, 10 s, about 10 s left for the truths");
  CHECK(said[1] == "truth: 2 of 12, 20 s, about 0 s left for the truths");
  CHECK(said[2] == "accuracy: 4 of 12, 21 s, about 4 s left");  // 8 cells at half a second each
}

TEST_CASE("a study tells its progress") {
  Lab lab;
  lab.options.timing = false;
  std::vector<std::string> said;
  lab.options.progress = [&](const std::string& line) { said.push_back(line); };
  lab.run(lab.cells({"sound/slow"},
                    {free_flight("one"), free_flight("two", 4), free_flight("three", 5), free_flight("four", 6),
                     free_flight("five", 7), free_flight("six", 8), free_flight("seven", 9)}));
  for (const std::string& line : said) CHECK_THAT(line, Catch::Contains(" of 35, ") && Catch::Contains(" s left"));
  CHECK_FALSE(said.empty());  // each of its cells sleeps
}

TEST_CASE("hostile cells leave the rows of the others as they are") {
  std::vector<Scenario> scenarios{free_flight("one")};
  scenarios.front().steps = {8, 16};
  const auto rows_of_others = [](const StudyResult& result) {
    std::vector<std::string> rows;
    for (const Row& row : result.rows)
      if (row.method == "sound/straight" || row.method == "faulty/well") rows.push_back(text(row));
    return rows;
  };
  std::vector<std::string> expected;
  {
    Lab lab;
    lab.options.timing = false;
    expected = rows_of_others(lab.run(lab.cells({"sound/straight", "faulty/well"}, scenarios)));
  }
  Lab lab;
  lab.options.timing = false;
  lab.workers = lab.found({fakes + "/sound.py", fakes + "/faulty.py", fakes + "/hostile.py"});
  for (Worker& worker : lab.workers) worker.confinement.memory_bytes = std::int64_t{256} << 20;
  lab.options.cell_limit_s = 1;
  const StudyResult result = lab.run(
      lab.cells({"hostile/takes_memory", "sound/straight", "hostile/drips", "faulty/well", "hostile/ignores_signals"},
                scenarios));
  CHECK(expected.size() > 8);
  CHECK(rows_of_others(result) == expected);
  CHECK(result.failed_cells > 0);
}
