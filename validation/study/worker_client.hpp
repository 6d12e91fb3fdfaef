// Asking a worker: requests out, recordings and truths in, whatever it does in between.
//
// Every way to fail becomes an Outcome: `timeout` (it hung), `crashed` (it died, or sent what is not the protocol, or
// what cannot be true: check_answer.hpp; the reason says which and ends with its standard error), `not built` (it cannot
// be started). After any of these the process is gone, and the next request starts a new one. A request that would not
// fit into a line is `unsupported`.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "protocol/fluid_field.hpp"
#include "protocol/wire.hpp"
#include "validation/metrics/fluid.hpp"
#include "validation/study/check_answer.hpp"
#include "validation/study/process.hpp"
#include "validation/study/study.hpp"

namespace atwood {

// The request was given up because of SIGINT or SIGTERM.
struct Interrupted {};

class WorkerClient {
 public:
  // `foreign`: the engine was not built with this program, so that more of what it sends is checked.
  explicit WorkerClient(std::vector<std::string> command, bool pinned = false, bool foreign = false)
      : command_(std::move(command)), pinned_(pinned), foreign_(foreign) {}

  // All throw Interrupted. `limit_s` counts from the request; starting has a limit of its own.
  Engine hello(Outcome& outcome);
  Recording run(const std::string& method, const std::string& scene_json, const SampledBodies& bodies, const Plan& plan,
                int repeats, double limit_s);
  // The time of every step; a worker that does not tell leaves it empty.
  Outcome profile(const std::string& method, const std::string& scene_json, const Plan& plan, double limit_s,
                  Profile& profile);
  ContactAnswer contacts(const std::string& scene_json, std::size_t bodies, const ContactQuery& query, double limit_s,
                         const std::string& test = "");
  // Poses from..from + count of a pair; `outcome` says how it ended. `test`: one beside the engine's own, or empty.
  std::vector<PoseAnswer> sweep(const std::string& test, const std::string& pair, std::uint64_t seed,
                                std::int64_t count, bool swept, double limit_s, Outcome& outcome);
  // Unsupported from some instant on: the samples before it are there, and `outcome` says why they end.
  // `response`: of the particles' own equations.
  Truth truth(const std::string& scenario_json, const SampledBodies& bodies, double t_end_s, std::int64_t samples,
              double limit_s, const std::string& response = "");

  // An exact field at these positions, one list a time; `response`: the method's, without the plus sign.
  FieldAtParticles field(const std::string& scenario_json, const std::string& response, const std::vector<Wide>& t_s,
                         const std::vector<std::vector<FieldPosition>>& positions, double limit_s);

  // From sending the last request to the end of its answer, without the start of the process.
  std::int64_t wall_ns() const { return wall_ns_; }
  // Of the running worker; 0: none runs.
  pid_t process_id() const { return process_ ? process_->id() : 0; }
  // The last failure was a kill from outside: the machine's doing, not the engine's.
  bool killed_from_outside() const { return killed_from_outside_; }

 private:
  // Feeds each answer to `take` until it says done, a sample in parts as a whole; `take` throws wire::Garbage. ok: what
  // `take` read stands. wall_ns() is set when `take` gets the end.
  Outcome ask(wire::Request request, double limit_s, const wire::Limits& most,
              const std::function<void(const wire::Answer&)>& take);
  // Sends the line and feeds each line of the answer to `take` until it gives an outcome.
  Outcome exchange(std::string text, double limit_s,
                   const std::function<std::optional<Outcome>(const std::string& line)>& take);
  // Starts the process if none runs and makes the next cell's number.
  Outcome prepare();
  std::int64_t next_cell();
  Outcome start();
  Outcome give_up(Status status, const std::string& reason);
  Outcome explain(Wait wait, double limit_s);

  std::vector<std::string> command_;
  bool pinned_, foreign_;
  std::unique_ptr<Process> process_;
  Engine engine_;
  std::int64_t cell_ = 0, wall_ns_ = 0;
  std::chrono::steady_clock::time_point asked_at_;
  bool killed_from_outside_ = false;
};

// One question for a field, in a process of its own.
FieldAtParticles field_once(const std::string& truth_worker, const Scenario& scenario, const std::vector<Wide>& t_s,
                            const std::vector<std::vector<FieldPosition>>& positions, double limit_s,
                            const std::string& response = "");

// Bodies that a sample of this scene has, and where they start.
inline SampledBodies sampled_bodies(const Scene& scene) { return SampledBodies(scene); }

}  // namespace atwood
