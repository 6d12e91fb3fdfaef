// A study from its cells to its rows: skipped, resumed, interrupted, out of space.
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <catch2/catch.hpp>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <functional>
#include <map>
#include <set>
#include <thread>

#include "validation/study/progress.hpp"
#include "validation/tests/study/free_flight.hpp"

using namespace atwood;

namespace {

const std::string fakes = ATWOOD_FAKE_WORKERS;

std::vector<Cell> cells_of(const std::vector<Worker>& workers, const std::vector<std::string>& methods,
                           const std::vector<Scenario>& scenarios) {
  return plan_cells({"test", {{{"*"}, methods, {}, 3, {}}}}, scenarios, workers, "cpu");
}

struct Lab {
  Folder folder;
  std::vector<Worker> workers = find_workers({fakes + "/sound.py", fakes + "/faulty.py"});
  StudyOptions options;

  Lab() {
    options.store_path = folder / "store.db";
    options.truth_worker = fakes + "/exact_truth.py";
    options.provenance.run_id = "run";
    setenv("SOUND_LOG", (folder / "sound.log").c_str(), 1);
    setenv("TRUTH_LOG", (folder / "truth.log").c_str(), 1);
  }
  std::vector<Cell> cells(const std::vector<std::string>& methods, const std::vector<Scenario>& scenarios) const {
    return cells_of(workers, methods, scenarios);
  }
  StudyResult run(const std::vector<Cell>& cells) const { return run_study(cells, workers, options); }
  int lines(const std::string& log) const {
    std::ifstream file(folder / log);
    return static_cast<int>(std::count(std::istreambuf_iterator<char>(file), {}, '\n'));
  }
  std::string file_list() const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder.path)) names.push_back(entry.path().filename());
    std::sort(names.begin(), names.end());
    std::string all;
    for (const auto& name : names) {
      if (name.find(".log") == std::string::npos) all += name + " ";
    }
    return all;
  }
};

std::string text(const Row& row) {
  return row.scenario + "|" + row.method + "|" + std::to_string(row.steps) + "|" + format_double(row.h_s) + "|" +
         row.body + "|" + (row.t_s ? format_double(*row.t_s) : "") + "|" + row.metric + "|" + row.unit + "|" +
         format_double(row.value) + "|" + format_double(row.truth_bar) + "|" + to_string(row.status) + "|" +
         row.reason + "|" + row.settings_hash + "|" + row.provenance.run_id + "|" + row.provenance.engine_version;
}

std::vector<std::string> texts(const StudyResult& result) {
  std::vector<std::string> all;
  for (const Row& row : result.rows) all.push_back(text(row));
  return all;
}

const Row* find_row(const StudyResult& result, const std::string& method, std::int64_t steps,
                    const std::string& metric) {
  for (const Row& row : result.rows) {
    if (row.method == method && row.steps == steps && row.metric == metric) return &row;
  }
  return nullptr;
}

// `work` in a process of its own, which may be killed; its exit code, or minus the signal.
pid_t apart(const std::function<int()>& work) {
  const pid_t child = fork();
  if (child == 0) _exit(work());
  return child;
}

int ending(pid_t child) {
  int status = 0;
  waitpid(child, &status, 0);
  return WIFSIGNALED(status) ? -WTERMSIG(status) : WEXITSTATUS(status);
}

void wait_for(const std::function<bool()>& condition) {
  for (int i = 0; i < 6000 && !condition(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  REQUIRE(condition());
}

}  // namespace

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
        return row.scenario == cell.scenario.id && row.method == cell.method && row.steps == cell.plan.steps &&
               row.metric == metric;
      };
      CHECK(std::count_if(first.rows.begin(), first.rows.end(), has) == 1);
    }
  }
  const Row* time = find_row(first, "sound/straight", 64, "step-time");
  REQUIRE(time);
  CHECK(time->value == Approx(1e-6));  // the fake says 1000 ns a step
  CHECK(time->h_s == 2.0 / 64);
  CHECK(time->provenance.engine_version == "1");
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
  lab.workers = find_workers({copy, fakes + "/faulty.py"});
  lab.run(lab.cells({"sound/straight", "faulty/well"}, {scenario}));
  CHECK(lab.lines("sound.log") == 4);
  scenario.steps = {8, 16, 32};
  CHECK(lab.run(lab.cells({"sound/straight", "faulty/well"}, {scenario})).skipped == 4);
  CHECK(lab.lines("sound.log") == 6);
  std::ofstream(copy, std::ios::app) << "# changed\n";
  lab.workers = find_workers({copy, fakes + "/faulty.py"});
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
  CHECK(find_row(second, "sound/straight", 64, "energy-max")->provenance.run_id == "second");
  CHECK(find_row(second, "faulty/well", 64, "energy-max")->provenance.run_id == "first");
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
  CHECK(find_row(load_rows(lab.options.store_path, cells), "faulty/well", 8, "energy-max")->provenance.run_id ==
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
  CHECK(find_row(resumed, "sound/slow", 8, "energy-max")->provenance.run_id == "run");
  lab.options.provenance.run_id = "next";
  CHECK(lab.run(cells).reused.at(0).reused == 0);
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
  damage("UPDATE rows SET value=value+1 WHERE key IN (SELECT key FROM measured)");
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

TEST_CASE("a study killed at any moment goes on where it was and ends with the same rows") {
  const Lab whole;
  const auto cells = whole.cells({"sound/slow", "sound/straight"}, {free_flight("one"), free_flight("two", 4)});
  StudyOptions untimed = whole.options;
  untimed.timing = false;
  const auto expected = texts(run_study(cells, whole.workers, untimed));
  for (const int after : {1, 4, 9}) {
    CAPTURE(after);
    const Lab lab;
    StudyOptions options = lab.options;
    options.timing = false;
    const pid_t child = apart([&] {
      run_study(cells, lab.workers, options);
      return 0;
    });
    wait_for([&] { return lab.lines("sound.log") >= after; });
    kill(child, SIGKILL);
    CHECK(ending(child) == -SIGKILL);
    const StudyResult resumed = run_study(cells, lab.workers, options);
    CHECK(texts(resumed) == expected);
    if (after > 4) CHECK(resumed.skipped > 0);
    CHECK(lab.lines("sound.log") < 2 * 16);
  }
}

TEST_CASE("an interrupt ends a study soon, and keeps what was done") {
  const int signal = GENERATE(SIGINT, SIGTERM);
  Lab lab;
  lab.options.timing = false;
  const auto cells = lab.cells({"sound/slow", "faulty/hangs"}, {free_flight("one"), free_flight("two", 4)});
  const pid_t child = apart([&] {
    const StudyResult result = lab.run(cells);
    return result.interrupted && result.signal == signal && !result.rows.empty() ? 42 : 1;
  });
  wait_for([&] { return lab.lines("sound.log") >= 5; });
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  const auto start = std::chrono::steady_clock::now();
  kill(child, signal);
  CHECK(ending(child) == 42);
  CHECK(std::chrono::steady_clock::now() - start < std::chrono::seconds(10));  // a hung cell had 20 s
  CHECK_FALSE(load_rows(lab.options.store_path, cells).rows.empty());
}

TEST_CASE("out of space: clear words, what was stored stays, and the run goes on when there is room") {
  Lab lab;
  lab.options.timing = false;
  Scenario scenario = free_flight("one");
  for (int i = 0; i < 40; ++i) {
    scenario.scene.bodies.push_back(scenario.scene.bodies[0]);
    scenario.scene.bodies.back().name = "ball " + std::to_string(i);
  }
  const auto cells = lab.cells({"sound/straight", "faulty/well"}, {scenario});
  const int size = GENERATE(2'000, 20'000, 400'000);
  CAPTURE(size);
  const std::string message = lab.folder / "message.log";
  const pid_t child = apart([&] {
    const rlimit limit{static_cast<rlim_t>(size), static_cast<rlim_t>(size)};
    setrlimit(RLIMIT_FSIZE, &limit);
    try {
      lab.run(cells);
    } catch (const std::runtime_error& error) {
      std::ofstream(message) << error.what();
      return 5;
    }
    return 0;
  });
  CHECK(ending(child) == 5);
  std::ifstream file(message);
  const std::string said{std::istreambuf_iterator<char>(file), {}};
  CHECK_THAT(said, Catch::Contains("store.db: ") && Catch::Contains("file size limit"));
  const StudyResult resumed = lab.run(cells);
  CHECK(resumed.rows.size() > 0);
  CHECK(find_row(resumed, "faulty/well", 64, "error-position-max"));
  CHECK(lab.file_list() == "store.db ");
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
