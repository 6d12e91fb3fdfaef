// Studies that end early: killed, interrupted, out of disk space. The next run continues them.
#include <sys/resource.h>

#include "lab.hpp"

using namespace atwood;

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
