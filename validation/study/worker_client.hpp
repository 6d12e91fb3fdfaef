// The client side of the worker protocol: sends requests, receives recordings and truths.
//
// Every failure becomes an Outcome: `timeout` (no answer within the limit), `crashed` (the process ended, violated the
// protocol, or sent an answer that cannot be true, see check_answer.hpp; the reason says which and ends with its
// standard error), `not built` (it cannot be started). Each of these ends the process, and the next request starts a
// new one. A request that is longer than the longest line is `unsupported`.
#pragma once

#include <chrono>
#include <concepts>
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

// Thrown where SIGINT or SIGTERM ends a request.
struct Interrupted {};

class WorkerClient {
 public:
  // `foreign`: the engine was not built with this program; more of its answers is checked.
  explicit WorkerClient(std::vector<std::string> command, bool pinned = false, bool foreign = false,
                        Confinement confinement = {})
      : command_(std::move(command)), pinned_(pinned), foreign_(foreign), confinement_(std::move(confinement)) {}
  template <std::same_as<Worker> Known>  // a template, so that a list of words is a command
  explicit WorkerClient(const Known& worker, bool pinned = false)
      : WorkerClient(worker.command, pinned, worker.foreign, worker.confinement) {}

  // All throw Interrupted. `limit_s` counts from the request; the start has its own limit.
  Engine hello(Outcome& outcome);
  Recording run(const std::string& method, const std::string& scene_json, const SampledBodies& bodies, const Plan& plan,
                int repeats, double limit_s);
  // The time of every step; empty where the worker does not report it.
  Outcome profile(const std::string& method, const std::string& scene_json, const Plan& plan, double limit_s,
                  Profile& profile);
  ContactAnswer contacts(const std::string& scene_json, std::size_t bodies, const ContactQuery& query, double limit_s,
                         const std::string& test = "");
  // Poses from..from + count of a pair; `outcome` says how it ended. `test`: a variant of the engine's contact test, or
  // empty.
  std::vector<PoseAnswer> sweep(const std::string& test, const std::string& pair, std::uint64_t seed,
                                std::int64_t count, bool swept, double limit_s, Outcome& outcome);
  // A truth that is `unsupported` from some time on has the samples before it; `outcome` has the reason.
  // `response`: of the particles' own equations.
  Truth truth(const std::string& scenario_json, const SampledBodies& bodies, double t_end_s, std::int64_t samples,
              double limit_s, const std::string& response = "");

  // An exact field at these positions, one list a time; `response`: the method's, without the plus sign.
  FieldAtParticles field(const std::string& scenario_json, const std::string& response, const std::vector<Wide>& t_s,
                         const std::vector<std::vector<FieldPosition>>& positions, double limit_s);

  // From sending the last request to the end of its answer, without the start of the process.
  std::int64_t wall_ns() const { return wall_ns_; }
  // The process id of the running worker; 0: none runs.
  pid_t process_id() const { return process_ ? process_->id() : 0; }
  // Whether the last failure was a kill from outside (out of memory, an administrator), not a fault of the engine; or
  // at the limit of memory, which may be another one in the next run.
  bool killed_from_outside() const { return killed_from_outside_; }

 private:
  // Passes each answer to `take` until the last one; a sample in parts is passed as a whole. `take` throws
  // wire::Garbage for an invalid answer. If the outcome is ok, everything that `take` received is valid. wall_ns() is
  // set before the last call of `take`.
  Outcome ask(wire::Request request, double limit_s, const wire::Limits& most,
              const std::function<void(const wire::Answer&)>& take);
  // Sends the line and feeds each line of the answer to `take` until it gives an outcome.
  Outcome exchange(std::string text, double limit_s,
                   const std::function<std::optional<Outcome>(const std::string& line)>& take);
  // Starts the process if none runs and makes the next cell's number.
  Outcome prepare();
  std::int64_t next_cell();
  Outcome start();
  // Sends a request; returns when its answer is due.
  std::chrono::steady_clock::time_point send(const std::string& text, double limit_s);
  Outcome give_up(Status status, const std::string& reason);
  Outcome explain(Wait wait, double limit_s);

  std::vector<std::string> command_;
  bool pinned_, foreign_;
  Confinement confinement_;
  std::unique_ptr<Process> process_;
  Engine engine_;
  std::int64_t cell_ = 0, wall_ns_ = 0;
  bool has_answered_ = false;   // the present process, at least one request
  bool may_ask_again_ = false;  // what fails now may be of the request before
  std::chrono::steady_clock::time_point asked_at_;
  bool killed_from_outside_ = false;
};

// One question for a field, in a process of its own.
FieldAtParticles field_once(const std::string& truth_worker, const Scenario& scenario, const std::vector<Wide>& t_s,
                            const std::vector<std::vector<FieldPosition>>& positions, double limit_s,
                            const std::string& response = "");

// The bodies that a sample of this scene has, and their initial state.
inline SampledBodies sampled_bodies(const Scene& scene) { return SampledBodies(scene); }

}  // namespace atwood
