// Processes of workers: descendants, signals, limits of time and memory, standard error.
#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <catch2/catch.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <thread>

#include "asked.hpp"
#include "scene/files.hpp"

using namespace atwood;

TEST_CASE("whatever a worker started ends with it and has none of our descriptors") {
  const Folder folder;
  setenv("CHILD_LOG", (folder / "children").c_str(), 1);
  const int ours = open("/dev/null", O_RDONLY);  // inheritable
  REQUIRE(fcntl(ours, F_DUPFD, 100) >= 100);
  {
    Asked ask({.writable = {folder.path}});
    const Outcome outcome = ask("leaves_children").outcome;
    CAPTURE(outcome.reason);
    REQUIRE(outcome.status == Status::ok);
    std::ifstream log(folder / "children");
    int pid = 0, seen = 0;
    for (std::string descriptors; log >> pid >> descriptors; ++seen) {
      CHECK(runs(pid));
      CHECK(descriptors.find("10") == std::string::npos);  // neither 10x nor any beyond the log and the listing
    }
    CHECK(seen == 3);
  }
  unsetenv("CHILD_LOG");
  close(ours);
  close_range(100, 200, 0);
  std::ifstream log(folder / "children");
  int pid = 0;
  for (std::string descriptors; log >> pid >> descriptors;) {
    CAPTURE(pid);
    CHECK_FALSE(runs(pid));
  }
}

TEST_CASE("nothing is signalled by the number of a worker that was buried") {
  // A worker that has ended keeps its number until all that it started is gone.
  Process process({workers + "/exits_at_hello.py"}, false);
  CHECK(process.ending() == "exited with code 1");
  CHECK(process.ending() == "exited with code 1");
  process.kill();  // it has ended: no signal, and no kill of ours
  CHECK_FALSE(process.killed_from_outside());
}

TEST_CASE("processes that start and end during the search for descendants disturb no worker") {
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t)
    threads.emplace_back([] {
      for (int i = 0; i < 100; ++i) {
        Process process({"/bin/sh", "-c", "for i in 1 2 3 4 5 6 7 8; do /bin/true; done"}, false);
        if (process.ending() != "exited with code 0") std::abort();
      }
    });
  for (std::thread& thread : threads) thread.join();
  CHECK(waitpid(-1, nullptr, WNOHANG) == -1);  // no zombie is left
}

TEST_CASE("a signal that was not read stays recorded after its guard; one that was read is cleared") {
  {
    const InterruptGuard guard;
    raise(SIGTERM);
  }
  CHECK(interrupt_signal() == SIGTERM);
  {
    const InterruptGuard guard;  // what was seen before belongs to the past
    CHECK(interrupt_signal() == 0);
    raise(SIGINT);
    CHECK(interrupt_signal() == SIGINT);
  }
  CHECK(interrupt_signal() == 0);
}

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr int kMaxPeakMib = 1000;  // most of it the sanitizer's own
#else
constexpr int kMaxPeakMib = 300;
#endif

TEST_CASE("a line of 60 MB costs the parent little more than itself") {
  const auto peak_mib = [](const std::string& fault) {
    const pid_t child = fork();
    if (child == 0) {
      Asked ask;
      ask(fault, 120);
      rusage used{};
      getrusage(RUSAGE_SELF, &used);  // without the worker's own
      _exit(static_cast<int>(std::min<long>(255, used.ru_maxrss >> 12)));
    }
    int status = 0;
    waitpid(child, &status, 0);
    CHECK(WIFEXITED(status));
    return 4 * WEXITSTATUS(status);
  };
  CHECK(peak_mib("many_bodies") < kMaxPeakMib);
  CHECK(peak_mib("many_unknown") < kMaxPeakMib);
}

TEST_CASE("a worker that hangs is stopped at the limit, its children with it") {
  const Folder folder;
  setenv("CHILD_LOG", (folder / "child").c_str(), 1);
  Asked ask({.writable = {folder.path}});
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

TEST_CASE("a megabyte on standard error neither blocks a worker nor outgrows the reason") {
  Asked ask;
  CHECK(ask("chatter").outcome.status == Status::ok);
  const Recording recording = ask("chatter_then_exit");
  CHECK(recording.outcome.status == Status::crashed);
  CHECK(recording.outcome.reason.size() < 200'000);
  CHECK_THAT(recording.outcome.reason, Catch::StartsWith("exited with code 4: "));
  CHECK_THAT(recording.outcome.reason, Catch::EndsWith("the last words"));
}
