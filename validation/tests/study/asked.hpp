// Requests to fake workers, for the tests of WorkerClient.
#pragma once

#include <fstream>

#include "scene/files.hpp"
#include "validation/study/worker_client.hpp"
#include "validation/tests/study/free_flight.hpp"

namespace atwood {

inline const std::string workers = ATWOOD_FAKE_WORKERS;
inline const Scenario scenario = free_flight("straight");

// A request to the worker faulty.py, which has the named fault.
struct Asked {
  BrokenPipeGuard guard;
  WorkerClient client;
  explicit Asked(Confinement confinement = {})
      : client({workers + "/faulty.py"}, false, false, std::move(confinement)) {}
  Recording operator()(const std::string& fault, double limit_s = 20, int repeats = 0) {
    return client.run("faulty/" + fault, scene_to_json(scenario.scene), sampled_bodies(scenario.scene),
                      {scenario.t_end_s, 16, 8}, repeats, limit_s);
  }
};

// Whether the process exists and is not a zombie.
inline bool runs(int pid) {
  std::ifstream file("/proc/" + std::to_string(pid) + "/stat");
  std::string text;
  std::getline(file, text);
  const auto end = text.rfind(')');
  return end != std::string::npos && text.compare(end, 3, ") Z") != 0;
}

}  // namespace atwood
