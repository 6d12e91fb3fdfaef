// Whatever a worker does, its cell ends with a status and a reason, and the next cell is asked of a fresh process.
#include <catch2/catch.hpp>
#include <signal.h>

#include <chrono>
#include <cmath>
#include <fstream>
#include <thread>

#include "scene/files.hpp"
#include "validation/study/worker_client.hpp"
#include "validation/tests/study/free_flight.hpp"

using namespace atwood;

namespace {

const std::string workers = ATWOOD_FAKE_WORKERS;
const Scenario scenario = free_flight("straight");

struct Asked {
  BrokenPipeGuard guard;
  WorkerClient client{{workers + "/faulty.py"}};
  Recording operator()(const std::string& fault, double limit_s = 20, int repeats = 0) {
    return client.run("faulty/" + fault, scene_to_json(scenario.scene), 1, {scenario.t_end_s, 16, 8}, repeats, limit_s);
  }
};

// A process that is neither gone nor waiting to be buried.
bool runs(int pid) {
  std::ifstream file("/proc/" + std::to_string(pid) + "/stat");
  std::string text;
  std::getline(file, text);
  const auto end = text.rfind(')');
  return end != std::string::npos && text.compare(end, 3, ") Z") != 0;
}

struct Fault { const char* method; Status status; const char* reason; };

}  // namespace

TEST_CASE("each fault is named, and the worker answers again after it") {
  const Fault fault = GENERATE(
      Fault{"dies", Status::crashed, "killed by signal 11 (Segmentation fault): before the end: red  words"},
      Fault{"exits", Status::crashed, "exited with code 3"},
      Fault{"garbage", Status::crashed, "garbage: not a JSON object: Segmentation fault is what I would say"},
      Fault{"half_a_line", Status::crashed, "exited with code 0 in the middle of a line"},
      Fault{"endless_line", Status::crashed, "garbage: a line of more than 64 MiB"},
      Fault{"wrong_cell", Status::crashed, "garbage: an answer to cell"},
      Fault{"wrong_time", Status::crashed, "garbage: sample 0 is at t_s = 0.5; asked for 0"},
      Fault{"too_many_samples", Status::crashed, "garbage: more samples than the 9 asked for"},
      Fault{"too_few_samples", Status::crashed, "garbage: ended as ok with 2 of 9 samples"},
      Fault{"body_missing", Status::crashed, "garbage: sample 0 has 0 bodies; the scene has 1"},
      Fault{"bare_nan", Status::crashed, "garbage: not a JSON object"},
      Fault{"not_utf8", Status::crashed, "exited with code 5: caf\xEF\xBF\xBD"},
      Fault{"refuses", Status::unsupported, "faulty has no springs"});
  CAPTURE(fault.method);
  Asked ask;
  const Recording recording = ask(fault.method);
  CHECK(to_string(recording.outcome.status) == to_string(fault.status));
  CHECK_THAT(recording.outcome.reason, Catch::StartsWith(fault.reason));
  const Recording after = ask("well");
  CHECK(after.outcome.status == Status::ok);
  CHECK(after.values.size() == 9);
}

TEST_CASE("a worker that hangs is stopped at the limit, its children with it") {
  const Folder folder;
  setenv("CHILD_LOG", (folder / "child").c_str(), 1);
  Asked ask;
  CHECK(ask("well").outcome.status == Status::ok);
  const auto start = std::chrono::steady_clock::now();
  const Recording recording = ask("hangs", 0.5);
  unsetenv("CHILD_LOG");  // the folder goes with this test
  const double took_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  CHECK(recording.outcome.status == Status::timeout);
  CHECK(recording.outcome.reason == "no answer within 0.5 s");
  CHECK(took_s >= 0.5);
  CHECK(took_s < 60);  // it sleeps for 1000 s
  int child = 0;
  std::ifstream(folder / "child") >> child;
  REQUIRE(child > 0);
  bool gone = false;
  for (int i = 0; i < 500 && !gone; ++i) {
    gone = !runs(child);
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  CHECK(gone);
  CHECK(ask("well").outcome.status == Status::ok);
}

TEST_CASE("a number that is not finite is an answer, not garbage") {
  Asked ask;
  const Recording recording = ask("nan_late");
  CHECK(recording.outcome.status == Status::ok);
  REQUIRE(recording.values.size() == 9);
  CHECK(std::isnan(static_cast<double>(recording.values.back().bodies[0].p_m[0])));
}

TEST_CASE("a megabyte on standard error neither blocks a worker nor outgrows the reason") {
  Asked ask;
  CHECK(ask("chatter").outcome.status == Status::ok);
  const Recording recording = ask("chatter_then_exit");
  CHECK(recording.outcome.status == Status::crashed);
  CHECK(recording.outcome.reason.size() < 200'000);
  CHECK_THAT(recording.outcome.reason, Catch::StartsWith("exited with code 4: "));
  CHECK_THAT(recording.outcome.reason, Catch::EndsWith("the last words"));
}

TEST_CASE("the timed pass gives one time a repeat and no samples") {
  Asked ask;
  const Recording recording = ask("well", 20, 3);
  CHECK(recording.values.empty());
  CHECK(recording.outcome.busy_ns == std::vector<std::int64_t>{16000, 16000, 16000});
}

TEST_CASE("who answers hello is at the table, who does not says why") {
  Folder folder;
  std::ofstream(folder / "not_executable.py") << "#!/usr/bin/env python3\n";
  const auto found = find_workers({workers + "/sound.py", workers + "/exits_at_hello.py", workers + "/garbage_at_hello.py",
                                   folder / "missing", folder / "not_executable.py"});
  REQUIRE(found.size() == 5);
  CHECK(found[0].status == Status::ok);
  CHECK(found[0].engine.name == "sound");
  CHECK(found[0].engine.methods.size() == 2);
  CHECK(found[0].build_id.size() == 32);
  CHECK(found[1].status == Status::crashed);
  CHECK(found[1].reason == "at hello: exited with code 1: no licence file");
  CHECK(found[2].status == Status::crashed);
  CHECK_THAT(found[2].reason, Catch::StartsWith("at hello: garbage: not a JSON object: hello to you too"));
  CHECK(found[3].status == Status::not_built);
  CHECK_THAT(found[3].reason, Catch::Contains("No such file"));
  CHECK(found[4].status == Status::not_built);
  CHECK_THAT(found[4].reason, Catch::Contains("Permission denied"));
}

TEST_CASE("one request in a process of its own") {
  const auto found = find_workers({workers + "/sound.py"});
  const Recording run = run_once(found[0], "sound/straight", scenario.scene, {2, 16, 8}, 20);
  CHECK(run.outcome.status == Status::ok);
  REQUIRE(run.values.size() == 9);
  CHECK(run.values.back().bodies[0].p_m[1] == static_cast<Wide>(0.2 - 2));
  const Truth truth = truth_once(workers + "/exact_truth.py", scenario, 8, 20);
  CHECK(truth.outcome.status == Status::ok);
  CHECK(truth.source == "closed form: straight flight");
  CHECK(truth.values.size() == 9);
  CHECK(truth.bars.size() == 9);
}
