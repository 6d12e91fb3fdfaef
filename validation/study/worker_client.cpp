#include "validation/study/worker_client.hpp"

#include <cmath>

#include "scene/files.hpp"
#include "validation/study/worker_identity.hpp"

namespace atwood {
namespace {

constexpr double kHelloLimitS = 10;
constexpr std::size_t kMostEvents = 1000000;

Clock::time_point in_seconds(double seconds) {
  return Clock::now() + std::chrono::microseconds(static_cast<std::int64_t>(std::min(seconds, 1e9) * 1e6));
}

std::string short_number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

void check_sample(const wire::Answer& answer, std::size_t k, double t_end_s, std::int64_t samples, std::size_t bodies) {
  if (k > static_cast<std::size_t>(samples)) {
    throw wire::Garbage("more samples than the " + std::to_string(samples + 1) + " asked for");
  }
  if (answer.sample.bodies.size() != bodies) {
    throw wire::Garbage("sample " + std::to_string(k) + " has " + std::to_string(answer.sample.bodies.size()) +
                        " bodies; the scene has " + std::to_string(bodies));
  }
  const double due = t_end_s * static_cast<double>(k) / static_cast<double>(samples);
  const double t = static_cast<double>(answer.sample.t_s);
  if (!(std::fabs(t - due) <= 1e-6 * t_end_s)) {
    throw wire::Garbage("sample " + std::to_string(k) + " is at t_s = " + format_double(t) + "; asked for " +
                        format_double(due));
  }
}

void append_events(const wire::Answer& answer, std::size_t bodies, std::vector<Event>& events) {
  for (const Event& event : answer.events) {
    const auto known = [&](int body) { return body >= 0 && static_cast<std::size_t>(body) < bodies; };
    if (!known(event.body_a) || !known(event.body_b))
      throw wire::Garbage("an event names a body that the scene has not");
    if (events.size() >= kMostEvents) throw wire::Garbage("more than a million events");
    events.push_back(event);
  }
}

}  // namespace

std::size_t sampled_bodies(const Scene& scene) { return scene.problem.empty() ? scene.bodies.size() : 1; }

Outcome WorkerClient::give_up(Status status, const std::string& reason) {
  Outcome outcome;
  outcome.status = status;
  outcome.reason = reason;
  if (process_) {
    killed_from_outside_ = process_->killed_from_outside();
    process_->kill();
    const std::string errors = process_->error_text();
    if (!errors.empty()) outcome.reason += ": " + errors;
    process_.reset();
  }
  return outcome;
}

Outcome WorkerClient::explain(Wait wait, double limit_s) {
  switch (wait) {
    case Wait::timeout: return give_up(Status::timeout, "no answer within " + short_number(limit_s) + " s");
    case Wait::too_long: return give_up(Status::crashed, "garbage: a line of more than 64 MiB");
    case Wait::interrupted: give_up(Status::crashed, "interrupted"); throw Interrupted{};
    default: break;
  }
  const std::string half = process_->half_a_line() ? " in the middle of a line" : "";
  return give_up(Status::crashed, process_->ending() + half);
}

Outcome WorkerClient::start() {
  try {
    process_ = std::make_unique<Process>(command_, pinned_);
  } catch (const std::runtime_error& error) {
    return give_up(Status::not_built, error.what());
  }
  process_->send(wire::to_line({}));
  std::string line;
  const Wait wait = process_->next_line(line, in_seconds(kHelloLimitS));
  if (wait != Wait::line) {
    Outcome outcome = explain(wait, kHelloLimitS);
    outcome.reason = "at hello: " + outcome.reason;
    return outcome;
  }
  try {
    engine_ = wire::read_hello(line);
  } catch (const std::exception& error) {
    return give_up(Status::crashed, std::string("at hello: garbage: ") + printable(error.what()));
  }
  return {};
}

Engine WorkerClient::hello(Outcome& outcome) {
  outcome = start();
  return engine_;
}

Outcome WorkerClient::ask(wire::Request request, double limit_s, const std::function<void(const wire::Answer&)>& take) {
  killed_from_outside_ = false;
  if (!process_) {
    const Outcome outcome = start();
    if (outcome.status != Status::ok) return outcome;
  }
  request.cell = ++cell_;
  process_->forget_errors();
  process_->send(wire::to_line(request));
  const auto start_time = Clock::now();
  const auto deadline = in_seconds(limit_s);
  std::string line;
  for (;;) {
    const Wait wait = process_->next_line(line, deadline);
    if (wait != Wait::line) return explain(wait, limit_s);
    try {
      const wire::Answer answer = wire::read_answer(line);
      if (answer.cell != cell_) {
        throw wire::Garbage("an answer to cell " + std::to_string(answer.cell) + "; asked was " +
                            std::to_string(cell_));
      }
      take(answer);
      if (!answer.done) continue;
      wall_ns_ = std::chrono::duration_cast<std::chrono::nanoseconds>(Clock::now() - start_time).count();
      return answer.outcome;
    } catch (const std::exception& error) {
      return give_up(Status::crashed, std::string("garbage: ") + printable(error.what()));
    }
  }
}

Recording WorkerClient::run(const std::string& method, const std::string& scene_json, std::size_t bodies,
                            const Plan& plan, int repeats, double limit_s) {
  wire::Request request;
  request.kind = wire::Request::Kind::run;
  request.method = method;
  request.plan = plan;
  request.repeats = repeats;
  request.json = scene_json;
  Recording recording;
  recording.outcome = ask(std::move(request), limit_s, [&](const wire::Answer& answer) {
    append_events(answer, bodies, recording.events);
    if (!answer.done && repeats == 0) {
      check_sample(answer, recording.values.size(), plan.t_end_s, plan.samples, bodies);
      recording.values.push_back(answer.sample);
    }
    if (!answer.done || answer.outcome.status != Status::ok) return;
    if (repeats == 0 && recording.values.size() != static_cast<std::size_t>(plan.samples) + 1) {
      throw wire::Garbage("ended as ok with " + std::to_string(recording.values.size()) + " of " +
                          std::to_string(plan.samples + 1) + " samples");
    }
    if (repeats > 0 && answer.outcome.busy_ns.empty()) throw wire::Garbage("a timed pass without busy_ns");
  });
  recording.outcome.reason = printable(recording.outcome.reason);
  return recording;
}

Outcome WorkerClient::profile(const std::string& method, const std::string& scene_json, const Plan& plan,
                              double limit_s, Profile& profile) {
  wire::Request request;
  request.kind = wire::Request::Kind::run;
  request.method = method;
  request.plan = plan;
  request.profile = true;
  request.json = scene_json;
  profile = {};
  Outcome outcome = ask(std::move(request), limit_s, [&](const wire::Answer& answer) {
    if (!answer.done) return;  // a worker that knows no such pass sends samples
    profile = answer.profile;
    const bool whole = profile.step_ns.empty() || profile.step_ns.size() == static_cast<std::size_t>(plan.steps);
    if (answer.outcome.status == Status::ok && !whole)
      throw wire::Garbage("step_ns of " + std::to_string(profile.step_ns.size()) + " of " + std::to_string(plan.steps) +
                          " steps");
  });
  outcome.reason = printable(outcome.reason);
  return outcome;
}

Truth WorkerClient::truth(const std::string& scenario_json, std::size_t bodies, double t_end_s, std::int64_t samples,
                          double limit_s) {
  wire::Request request;
  request.kind = wire::Request::Kind::truth;
  request.plan.samples = samples;
  request.json = scenario_json;
  Truth truth;
  truth.outcome = ask(std::move(request), limit_s, [&](const wire::Answer& answer) {
    append_events(answer, bodies, truth.events);
    truth.event_bar_s.insert(truth.event_bar_s.end(), answer.event_bar_s.begin(), answer.event_bar_s.end());
    if (answer.done) {
      truth.source = answer.source;
      truth.note = answer.note;
      truth.condition = answer.condition;
      if (answer.outcome.status == Status::ok && truth.values.size() != static_cast<std::size_t>(samples) + 1) {
        throw wire::Garbage("a truth of " + std::to_string(truth.values.size()) + " samples");
      }
      return;
    }
    check_sample(answer, truth.values.size(), t_end_s, samples, bodies);
    if (!answer.has_bar) throw wire::Garbage("a truth without bars");
    truth.values.push_back(answer.sample);
    truth.bars.push_back(answer.bar);
    truth.bars.back().t_s = answer.sample.t_s;
  });
  if (truth.outcome.status != Status::ok) truth.values.clear(), truth.bars.clear();
  truth.outcome.reason = printable(truth.outcome.reason);
  return truth;
}

// ---- contacts -----------------------------------------------------------------------------------------------------
ContactAnswer WorkerClient::contacts(const std::string& scene_json, std::size_t bodies, const ContactQuery& query,
                                     double limit_s, const std::string& test) {
  wire::Request request;
  request.kind = wire::Request::Kind::contacts;
  request.contacts = query;
  request.test = test;
  request.json = scene_json;
  ContactAnswer found;
  const auto known = [&](int a, int b) {
    if (a < 0 || b <= a || static_cast<std::size_t>(b) >= bodies)
      throw wire::Garbage("contacts of bodies that the scene has not, or of a body before another");
  };
  found.outcome = ask(std::move(request), limit_s, [&](const wire::Answer& answer) {
    for (const FoundContact& each : answer.contacts) known(each.body_a, each.body_b), found.contacts.push_back(each);
    for (const FoundTouch& each : answer.touches) known(each.body_a, each.body_b), found.touches.push_back(each);
  });
  found.outcome.reason = printable(found.outcome.reason);
  return found;
}

std::vector<PoseAnswer> WorkerClient::sweep(const std::string& test, const std::string& pair, std::uint64_t seed,
                                            std::int64_t count, bool swept, double limit_s, Outcome& outcome) {
  wire::Request request;
  request.kind = wire::Request::Kind::sweep;
  request.contacts.swept = swept;
  request.test = test;
  request.pair = pair;
  request.seed = seed;
  request.count = count;
  std::vector<PoseAnswer> poses;
  outcome = ask(std::move(request), limit_s, [&](const wire::Answer& answer) {
    poses.insert(poses.end(), answer.poses.begin(), answer.poses.end());
    if (poses.size() > static_cast<std::size_t>(count))
      throw wire::Garbage("more poses than the " + std::to_string(count) + " asked for");
    if (answer.done && answer.outcome.status == Status::ok && poses.size() != static_cast<std::size_t>(count))
      throw wire::Garbage("ended as ok with " + std::to_string(poses.size()) + " of " + std::to_string(count) +
                          " poses");
  });
  outcome.reason = printable(outcome.reason);
  return poses;
}

namespace {

void identify(Worker& worker, pid_t process, FileHashes& hashes, Outcome& outcome) {
  const WorkerIdentity identity = identify_worker(worker.command, worker.engine, process, hashes);
  worker.build_id = identity.hash;
  worker.unknown_code = printable(identity.unknown_code);
  if (identity.error.empty()) return;
  outcome.status = Status::crashed;
  outcome.reason = printable(identity.error);
}

}  // namespace

// ---- one-off requests ---------------------------------------------------------------------------------------------
std::vector<Worker> find_workers(const std::vector<std::string>& paths) {
  std::vector<std::vector<std::string>> commands;
  for (const std::string& path : paths) commands.push_back({path});
  return find_workers_by_argv(commands);
}

std::vector<Worker> find_workers_by_argv(const std::vector<std::vector<std::string>>& commands) {
  const BrokenPipeGuard guard;
  FileHashes hashes;
  std::vector<Worker> workers;
  for (const std::vector<std::string>& command : commands) {
    Worker& worker = workers.emplace_back();
    worker.path = command.at(0);
    worker.command = command;
    worker.build_id = hashes.of(worker.path);  // a script is an executable too
    Outcome outcome;
    WorkerClient client(worker.command);
    try {
      worker.engine = client.hello(outcome);
      if (outcome.status == Status::ok) identify(worker, client.process_id(), hashes, outcome);
    } catch (const Interrupted&) {
      outcome.status = Status::crashed;
      outcome.reason = "interrupted";
    }
    worker.status = outcome.status;
    worker.reason = outcome.reason;
  }
  return workers;
}

Recording run_once(const Worker& worker, const std::string& method, const Scene& scene, const Plan& plan,
                   double limit_s) {
  const BrokenPipeGuard guard;
  WorkerClient client(worker.command);
  return client.run(method, scene_to_json(scene), sampled_bodies(scene), plan, 0, limit_s);
}

ContactAnswer contacts_once(const Worker& worker, const Scene& scene, const ContactQuery& query, double limit_s,
                            const std::string& test) {
  const BrokenPipeGuard guard;
  WorkerClient client(worker.command);
  return client.contacts(scene_to_json(scene), scene.bodies.size(), query, limit_s, test);
}

Truth truth_once(const std::string& truth_worker, const Scenario& scenario, std::int64_t samples, double limit_s) {
  const BrokenPipeGuard guard;
  WorkerClient client({truth_worker});
  return client.truth(scenario_to_json(scenario), sampled_bodies(scenario.scene), scenario.t_end_s, samples, limit_s);
}

}  // namespace atwood
