// Which engines are available: each worker is started once and answers `hello`.
#include <algorithm>
#include <filesystem>
#include <map>

#include "scene/files.hpp"
#include "validation/study/content_hash.hpp"
#include "validation/study/worker_client.hpp"
#include "validation/study/worker_identity.hpp"

namespace atwood {
namespace {

constexpr int kMaxStarts = 3;  // of a worker that ends after `hello`, before that is taken for its habit

// False: the worker's process ended before its libraries were read.
bool identify(Worker& worker, pid_t process, FileHashes& hashes, Outcome& outcome) {
  const WorkerIdentity identity = identify_worker(worker.command, worker.engine, process, hashes);
  worker.build_id = identity.hash;
  worker.unknown_code = printable(identity.unknown_code);
  worker.code = identity.code;
  if (!identity.error.empty()) {
    outcome.status = Status::crashed;
    outcome.reason = printable(identity.error);
  }
  return !identity.process_ended;
}

// Asks `hello`. A worker that is killed right after its answer is started again: without its libraries its identity
// would be another one, and all its cells would be run again.
Outcome ask_hello(Worker& worker, FileHashes& hashes) {
  Outcome outcome;
  for (int start = 0; start < kMaxStarts; ++start) {
    outcome = {};
    WorkerClient client(worker);
    try {
      worker.engine = client.hello(outcome);
      if (outcome.status != Status::ok || identify(worker, client.process_id(), hashes, outcome)) break;
    } catch (const Interrupted&) {
      outcome.status = Status::crashed;
      outcome.reason = "interrupted";
      break;
    }
  }
  return outcome;
}

}  // namespace

std::vector<Worker> find_workers(const std::vector<std::string>& paths) {
  std::vector<std::vector<std::string>> commands;
  for (const std::string& path : paths) commands.push_back({path});
  return find_workers_by_argv(commands);
}

namespace {

// The engine of an executable of this project, built or not: .../atwood-dart is `dart`.
std::string name_by_file(const std::string& path) {
  const std::string file = std::filesystem::path(path).filename().string();
  if (file == "atwood-engine") return "atwood";
  return file.rfind("atwood-", 0) == 0 ? file.substr(7) : "";
}

}  // namespace

const Worker* unanswered(const std::vector<Worker>& workers, const std::string& engine) {
  for (const Worker& worker : workers) {
    if (worker.status == Status::ok) continue;
    if (name_by_file(worker.path) == engine || std::filesystem::path(worker.path).filename() == engine) return &worker;
  }
  return nullptr;
}

namespace {

// Rows of two engines with one name could not be distinguished: the first worker keeps the name, another one is
// refused. The same command twice is one engine. No engine may be called `truth`.
void refuse_taken_names(std::vector<Worker>& workers) {
  std::map<std::string, const Worker*> holders;
  for (Worker& worker : workers) {
    const std::string& name = worker.engine.name;
    if (worker.status != Status::ok) {
      if (const std::string ours = name_by_file(worker.path); !ours.empty()) holders.try_emplace(ours, &worker);
      continue;
    }
    const auto refuse = [&](const std::string& whose) {
      worker.status = Status::crashed;
      worker.reason = "answering `hello`: invalid answer: its name is `" + name + "`, which is already the name of " +
                      whose + "; expected a name that no other engine has";
    };
    if (name == "truth" && name_by_file(worker.path) != name) {
      refuse("the truth");
      continue;
    }
    const auto [holder, fresh] = holders.try_emplace(name, &worker);
    if (!fresh && holder->second->command != worker.command) refuse(holder->second->path);
  }
}

}  // namespace

std::vector<Worker> find_workers_by_argv(const std::vector<std::vector<std::string>>& commands,
                                         const std::vector<Confinement>& confinements) {
  const BrokenPipeGuard guard;
  FileHashes hashes;
  std::vector<Worker> workers;
  for (const std::vector<std::string>& command : commands) {
    Worker& worker = workers.emplace_back();
    worker.path = command.at(0);
    worker.command = command;
    if (!confinements.empty()) worker.confinement = confinements.at(workers.size() - 1);
    worker.build_id = hashes.of(worker.path);  // a script is an executable too
    const Outcome outcome = ask_hello(worker, hashes);
    worker.status = outcome.status;
    worker.reason = outcome.reason;
  }
  refuse_taken_names(workers);
  return workers;
}

Recording run_once(const Worker& worker, const std::string& method, const Scene& scene, const Plan& plan,
                   double limit_s) {
  const BrokenPipeGuard guard;
  WorkerClient client(worker);
  return client.run(method, scene_to_json(scene), sampled_bodies(scene), plan, 0, limit_s);
}

ContactAnswer contacts_once(const Worker& worker, const Scene& scene, const ContactQuery& query, double limit_s,
                            const std::string& test) {
  const BrokenPipeGuard guard;
  WorkerClient client(worker);
  return client.contacts(scene_to_json(scene), scene.bodies.size(), query, limit_s, test);
}

Settings response_settings(const Worker& worker, const MethodId& id) {
  Settings settings;
  for (const MethodInfo& info : worker.engine.responses)
    if (info.id == "+" + id.response) settings = info.settings;
  for (const auto& [key, value] : id.overrides)
    if (settings.contains(key)) settings[key] = value;
  return settings;
}

}  // namespace atwood
