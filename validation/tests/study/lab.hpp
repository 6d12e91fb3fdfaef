// Studies of fake workers in a folder of their own, for the tests of run_study.
#pragma once

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>
#include <catch2/catch.hpp>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <functional>
#include <thread>

#include "validation/tests/study/free_flight.hpp"

namespace atwood {

inline const std::string fakes = ATWOOD_FAKE_WORKERS;

inline std::vector<Cell> cells_of(const std::vector<Worker>& workers, const std::vector<std::string>& methods,
                                  const std::vector<Scenario>& scenarios) {
  return plan_cells({"test", {{{"*"}, methods, {}, 3, {}}}}, scenarios, workers, "cpu");
}

// A store, the workers of Python scripts and a truth in a folder of their own.
struct Lab {
  Folder folder;
  std::vector<Worker> workers = found({fakes + "/sound.py", fakes + "/faulty.py"});
  StudyOptions options;

  // They write their logs in the folder of the laboratory.
  std::vector<Worker> found(const std::vector<std::string>& paths) const {
    std::vector<Worker> all = find_workers(paths);
    for (Worker& worker : all) worker.confinement.writable = {folder.path};
    return all;
  }
  Lab() {
    options.truth_confinement.writable = {folder.path};
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

inline std::string text(const Row& row) {
  return row.scenario + "|" + row.method + "|" + std::to_string(row.steps) + "|" + format_double(row.h_s) + "|" +
         row.body + "|" + (row.t_s ? format_double(*row.t_s) : "") + "|" + row.metric + "|" + row.unit + "|" +
         format_double(row.value) + "|" + format_double(row.truth_bar) + "|" + to_string(row.status) + "|" +
         row.reason + "|" + row.settings_hash + "|" + row.provenance->run_id + "|" + row.provenance->engine_version;
}

// How often a time was repeated, and with it its interval, depends on the machine's load: left out.
inline std::vector<std::string> texts(const StudyResult& result) {
  std::vector<std::string> all;
  for (Row row : result.rows) {
    if (row.status == Status::ok && (row.metric == "step-time" || row.metric == "run-time"))
      row.truth_bar = 0, row.reason.clear();
    all.push_back(text(row));
  }
  return all;
}

inline const Row* find_row(const StudyResult& result, const std::string& method, std::int64_t steps,
                           const std::string& metric) {
  for (const Row& row : result.rows) {
    if (row.method == method && row.steps == steps && row.metric == metric) return &row;
  }
  return nullptr;
}

// Runs `work` in a child process, which the test may kill.
inline pid_t apart(const std::function<int()>& work) {
  const pid_t child = fork();
  if (child == 0) _exit(work());
  return child;
}

// Waits for the child: its exit code, or minus the signal that ended it.
inline int ending(pid_t child) {
  int status = 0;
  waitpid(child, &status, 0);
  return WIFSIGNALED(status) ? -WTERMSIG(status) : WEXITSTATUS(status);
}

inline void wait_for(const std::function<bool()>& condition) {
  for (int i = 0; i < 6000 && !condition(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  REQUIRE(condition());
}

}  // namespace atwood
