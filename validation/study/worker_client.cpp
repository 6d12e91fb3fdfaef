#include "validation/study/worker_client.hpp"

#include <algorithm>
#include <filesystem>
#include <map>
#include <new>
#include <random>
#include <utility>

#include "protocol/refusal.hpp"
#include "scene/files.hpp"
#include "validation/study/worker_identity.hpp"

namespace atwood {
namespace {

constexpr double kHelloLimitS = 10;
constexpr std::size_t kMaxEvents = 1000000;

// A process that ends this soon after a request has not worked on it: it was ending when the request was sent.
constexpr std::chrono::milliseconds kLate{50};

Clock::time_point in_seconds(double seconds) {
  return Clock::now() + std::chrono::microseconds(static_cast<std::int64_t>(std::min(seconds, 1e9) * 1e6));
}

std::string short_number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

void append_events(const wire::Answer& answer, std::size_t bodies, std::vector<Event>& events) {
  for (const Event& event : answer.events) {
    const auto known = [&](int body) { return body >= 0 && static_cast<std::size_t>(body) < bodies; };
    const bool of_world = event.body_a == -1;  // the stop of a joint to the world
    if ((!known(event.body_a) && !of_world) || !known(event.body_b))
      throw wire::Garbage("an event names a body that the scene has not");
    if (events.size() >= kMaxEvents) throw wire::Garbage("more than a million events");
    events.push_back(event);
  }
}

std::string megabytes(std::size_t bytes) { return short_number(static_cast<double>(bytes) / (1 << 20)) + " MiB"; }

// A few bodies more than the scene has, so that the message about too many bodies can give their number; and contacts
// of a dense heap, several points each.
wire::Limits limits_of(const SampledBodies& bodies) {
  return {.bodies = bodies.count + 64,
          .contacts = 1024 + 32 * bodies.count,
          .poses = 0,
          .particles = bodies.particles + 64,
          .joints = bodies.joints.size() + bodies.rope_pulleys.size() + 64};
}

// Checks and appends the next sample of a run or a truth.
void add_sample(const wire::Answer& answer, double t_end_s, std::int64_t samples, const SampledBodies& bodies,
                SampleSeries& values) {
  const std::size_t k = values.size();
  if (k > static_cast<std::size_t>(samples))
    throw wire::Garbage("more samples than the " + std::to_string(samples + 1) + " asked for");
  check_layout(answer.sample, k, t_end_s, samples, bodies);
  check_joints(answer, bodies);
  if (k == 0) values.reserve(static_cast<std::size_t>(samples) + 1, bodies.count);
  values.push_back(answer.sample);
}

// Appends a part of a sample to the earlier parts.
void append_part(wire::Answer part, wire::Answer& whole, const wire::Limits& most) {
  if (part.from != whole.sample.bodies.size())
    throw wire::Garbage("a part of a sample is from body " + std::to_string(part.from) + " on; expected was body " +
                        std::to_string(whole.sample.bodies.size()));
  if (part.from_particle != whole.sample.particles.size())
    throw wire::Garbage("a part of a sample is from particle " + std::to_string(part.from_particle) +
                        " on; expected was particle " + std::to_string(whole.sample.particles.size()));
  if (!(whole.sample.bodies.empty() && whole.sample.particles.empty()) && part.sample.t_s != whole.sample.t_s)
    throw wire::Garbage("parts of a sample at different times");
  const auto append = [](auto& to, auto& from) {
    if (to.empty()) to = std::move(from);
    else to.insert(to.end(), from.begin(), from.end());
  };
  append(whole.sample.bodies, part.sample.bodies);
  append(whole.sample.particles, part.sample.particles);
  append(whole.sample.contacts, part.sample.contacts);
  append(whole.sample.joints, part.sample.joints);
  append(whole.sample.ropes, part.sample.ropes);
  append(whole.joint_coordinates, part.joint_coordinates);
  append(whole.bar.joints, part.bar.joints);
  append(whole.bar.ropes, part.bar.ropes);
  append(whole.bar.bodies, part.bar.bodies);
  append(whole.bar.particles, part.bar.particles);
  append(whole.events, part.events);
  append(whole.event_bar_s, part.event_bar_s);
  whole.sample.t_s = part.sample.t_s;
  whole.has_bar = whole.has_bar || part.has_bar;
  if (whole.sample.bodies.size() > most.bodies) throw wire::Garbage("a sample of more bodies than the scene has");
  if (whole.sample.particles.size() > most.particles)
    throw wire::Garbage("a sample of more particles than the scene has");
  if (whole.sample.contacts.size() > most.contacts)
    throw wire::Garbage("more than " + std::to_string(most.contacts) + " contacts in a sample");
}

}  // namespace

Outcome WorkerClient::give_up(Status status, const std::string& reason) {
  Outcome outcome;
  outcome.status = status;
  outcome.reason = reason;
  if (process_) {
    killed_from_outside_ = process_->killed_from_outside() || process_->took_too_much_memory();
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
    case Wait::too_long:
      return give_up(Status::crashed, "invalid answer: a line of more than " +
                                          megabytes(cell_ == 0 ? wire::kLongestHello : wire::kLongestLine));
    case Wait::interrupted: give_up(Status::crashed, "interrupted"); throw Interrupted{};
    default: break;
  }
  const std::string ending = process_->ending();
  if (process_->took_too_much_memory())
    return give_up(Status::crashed, "took more than " + memory_text(confinement_.memory_bytes) + " of memory");
  const char* when = process_->half_a_line()          ? " in the middle of a line"
                     : ending == "exited with code 0" ? " before the end of its answer"
                                                      : "";
  return give_up(Status::crashed, ending + when);
}

Outcome WorkerClient::start() {
  has_answered_ = false;
  const std::int64_t cell = std::exchange(cell_, 0);  // 0: a failure is one of `hello`
  try {
    process_ = std::make_unique<Process>(command_, pinned_, confinement_);
  } catch (const SystemFault&) {
    throw;
  } catch (const std::runtime_error& error) {
    return give_up(Status::not_built, error.what());
  }
  process_->send(wire::to_line(wire::Request{}));
  std::string line;
  const Wait wait = process_->next_line(line, in_seconds(kHelloLimitS), wire::kLongestHello);
  if (wait != Wait::line) {
    Outcome outcome = explain(wait, kHelloLimitS);
    outcome.reason = "answering `hello`: " + outcome.reason;
    return outcome;
  }
  try {
    engine_ = wire::read_hello(line);
  } catch (const std::bad_alloc&) {  // of this program, not of the worker
    throw;
  } catch (const std::exception& error) {
    return give_up(Status::crashed, std::string("answering `hello`: invalid answer: ") + printable(error.what()));
  }
  cell_ = cell;
  return {};
}

Engine WorkerClient::hello(Outcome& outcome) {
  outcome = start();
  return engine_;
}

// A random number, so that an answer sent before its request does not match the request.
std::int64_t WorkerClient::next_cell() {
  static thread_local std::mt19937 random{std::random_device{}()};
  return std::uniform_int_distribution<std::int64_t>(1, (std::int64_t{1} << 31) - 1)(random);
}

Outcome WorkerClient::prepare() {
  killed_from_outside_ = false;
  if (!process_) {
    cell_ = 0;
    const Outcome outcome = start();
    if (outcome.status != Status::ok) return outcome;
  }
  cell_ = next_cell();
  return {};
}

Outcome WorkerClient::exchange(std::string text, double limit_s,
                               const std::function<std::optional<Outcome>(const std::string& line)>& take) {
  if (text.size() > wire::kLongestLine) {
    return refused("the scene takes " + megabytes(text.size()) + " as a line of the worker protocol, which allows " +
                   megabytes(wire::kLongestLine));
  }
  // What a process does after the end of an answer is not the next cell's fault, whether it is noticed before the next
  // request is sent or shortly after it: then a new process is asked, once.
  may_ask_again_ = has_answered_;
  if (const std::string early = process_->unasked(); !early.empty()) {
    if (!may_ask_again_)
      return give_up(Status::crashed, "invalid answer: it came before the request was sent: " + printable(early));
    process_.reset();
    if (const Outcome started = start(); started.status != Status::ok) return started;
    may_ask_again_ = false;
  }
  auto deadline = send(text, limit_s);
  std::string line;
  for (;;) {
    const Wait wait = process_->next_line(line, deadline, wire::kLongestLine);
    Outcome failure;
    try {
      if (wait != Wait::line) {
        may_ask_again_ = may_ask_again_ && wait == Wait::end_of_output && Clock::now() - asked_at_ < kLate;
        failure = explain(wait, limit_s);
        may_ask_again_ = may_ask_again_ && !killed_from_outside_;
      } else if (const std::optional<Outcome> outcome = take(line)) {
        has_answered_ = true;
        return *outcome;
      } else {
        continue;
      }
    } catch (const std::bad_alloc&) {
      throw;
    } catch (const Interrupted&) {
      throw;
    } catch (const std::exception& error) {
      failure = give_up(Status::crashed, std::string("invalid answer: ") + printable(error.what()));
    }
    if (!may_ask_again_) return failure;
    may_ask_again_ = false;
    if (const Outcome started = start(); started.status != Status::ok) return started;
    deadline = send(text, limit_s);
  }
}

Clock::time_point WorkerClient::send(const std::string& text, double limit_s) {
  process_->forget_errors();
  process_->send(text);
  asked_at_ = Clock::now();
  return in_seconds(limit_s);
}

Outcome WorkerClient::ask(wire::Request request, double limit_s, const wire::Limits& most,
                          const std::function<void(const wire::Answer&)>& take) {
  if (const Outcome outcome = prepare(); outcome.status != Status::ok) return outcome;
  request.cell = cell_;
  wire::Answer whole;  // of a sample in parts: those that came
  bool in_parts = false;
  return exchange(wire::to_line(request), limit_s, [&](const std::string& line) -> std::optional<Outcome> {
    wire::Answer answer = wire::read_answer(line, most);
    if (answer.cell != cell_)
      throw wire::Garbage("an answer to cell " + std::to_string(answer.cell) + ", which was not asked for");
    may_ask_again_ = false;  // the line is of this cell
    if (answer.done) {
      wall_ns_ = std::chrono::duration_cast<std::chrono::nanoseconds>(Clock::now() - asked_at_).count();
      if (in_parts) throw wire::Garbage("ended in the middle of a sample");
      take(answer);
      return answer.outcome;
    }
    const bool whole_line = !answer.more && answer.from == 0 && answer.from_particle == 0;
    if (answer.events_alone || (!in_parts && whole_line)) {
      take(answer);
      return std::nullopt;
    }
    in_parts = answer.more;
    append_part(std::move(answer), whole, most);
    if (in_parts) return std::nullopt;
    take(whole);
    whole = {};
    return std::nullopt;
  });
}

FieldAtParticles WorkerClient::field(const std::string& scenario_json, const std::string& response,
                                     const std::vector<Wide>& t_s,
                                     const std::vector<std::vector<FieldPosition>>& positions, double limit_s) {
  FieldAtParticles field;
  field.outcome = prepare();
  if (field.outcome.status != Status::ok) return field;
  const std::string text = wire::to_line(wire::FieldRequest{cell_, response, scenario_json, t_s, positions});
  bool in_parts = false;
  field.outcome = exchange(text, limit_s, [&](const std::string& line) -> std::optional<Outcome> {
    const std::size_t k = field.samples.size() - (in_parts ? 1 : 0);
    const std::size_t due = k < positions.size() ? positions[k].size() : 0;
    wire::FieldAnswer answer = wire::read_field_answer(line, due + 64);
    if (answer.cell != cell_)
      throw wire::Garbage("an answer to cell " + std::to_string(answer.cell) + ", which was not asked for");
    may_ask_again_ = false;  // the line is of this cell
    if (answer.done) {
      field.source = answer.ended.source, field.note = printable(answer.ended.note), field.known = answer.ended.known;
      if (answer.ended.outcome.status == Status::ok && (in_parts || field.samples.size() != t_s.size()))
        throw wire::Garbage("a field at " + std::to_string(field.samples.size()) + " of " + std::to_string(t_s.size()) +
                            " times");
      return answer.ended.outcome;
    }
    if (k >= t_s.size()) throw wire::Garbage("a field at more times than were asked for");
    if (!in_parts) field.samples.emplace_back().t_s = answer.sample.t_s;
    FieldSample& sample = field.samples.back();
    if (answer.sample.t_s != t_s[k]) throw wire::Garbage("a field at another time than was asked for");
    if (answer.from != sample.values.size()) throw wire::Garbage("a part of a field that does not continue");
    const auto append = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
    append(sample.values, answer.sample.values);
    append(sample.bars, answer.sample.bars);
    append(sample.probes, answer.sample.probes);
    in_parts = answer.more;
    if (!in_parts && sample.values.size() != due)
      throw wire::Garbage("a field at " + std::to_string(sample.values.size()) + " of " + std::to_string(due) +
                          " positions");
    return std::nullopt;
  });
  if (field.outcome.status != Status::ok) field.samples.clear();
  field.outcome.reason = printable(field.outcome.reason);
  return field;
}

Recording WorkerClient::run(const std::string& method, const std::string& scene_json, const SampledBodies& bodies,
                            const Plan& plan, int repeats, double limit_s) {
  wire::Request request;
  request.kind = wire::Request::Kind::run;
  request.method = method;
  request.plan = plan;
  request.repeats = repeats;
  request.json = scene_json;
  Recording recording;
  recording.outcome = ask(std::move(request), limit_s, limits_of(bodies), [&](const wire::Answer& answer) {
    append_events(answer, bodies.count, recording.events);
    if (!answer.done && !answer.events_alone && repeats == 0) {
      add_sample(answer, plan.t_end_s, plan.samples, bodies, recording.values);
      check_states(answer.sample, recording.values.size() - 1, plan.t_end_s, bodies, foreign_);
    }
    if (!answer.done || answer.outcome.status != Status::ok) return;
    if (repeats == 0 && recording.values.size() != static_cast<std::size_t>(plan.samples) + 1) {
      throw wire::Garbage("ended as ok with " + std::to_string(recording.values.size()) + " of " +
                          std::to_string(plan.samples + 1) + " samples");
    }
    // With a tolerance the engine chooses its steps.
    const bool adaptive = method.find(':') != std::string::npos && answer.outcome.steps_taken > 0;
    const std::int64_t steps = adaptive ? std::min(plan.steps, answer.outcome.steps_taken) : plan.steps;
    if (repeats > 0) check_busy(answer.outcome.busy_ns, repeats, steps, wall_ns_, foreign_);
  });
  if (foreign_ && repeats == 0 && recording.outcome.status == Status::ok) {
    const std::string why = blow_up(recording.values, plan.t_end_s, bodies);
    if (!why.empty()) recording.outcome.status = Status::diverged, recording.outcome.reason = "the host: " + why;
  }
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
  Outcome outcome = ask(std::move(request), limit_s, {}, [&](const wire::Answer& answer) {
    if (!answer.done) return;  // a worker without this pass sends samples
    profile = answer.profile;
    const bool whole = profile.step_ns.empty() || profile.step_ns.size() == static_cast<std::size_t>(plan.steps);
    if (answer.outcome.status == Status::ok && !whole)
      throw wire::Garbage("step_ns of " + std::to_string(profile.step_ns.size()) + " of " + std::to_string(plan.steps) +
                          " steps");
  });
  outcome.reason = printable(outcome.reason);
  return outcome;
}

Truth WorkerClient::truth(const std::string& scenario_json, const SampledBodies& bodies, double t_end_s,
                          std::int64_t samples, double limit_s, const std::string& response) {
  wire::Request request;
  request.kind = wire::Request::Kind::truth;
  request.plan.samples = samples;
  request.response = response;
  request.json = scenario_json;
  Truth truth;
  truth.outcome = ask(std::move(request), limit_s, limits_of(bodies), [&](const wire::Answer& answer) {
    append_events(answer, bodies.count, truth.events);
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
    if (answer.events_alone) return;
    if (!answer.has_bar) throw wire::Garbage("a truth without bars");
    add_sample(answer, t_end_s, samples, bodies, truth.values);
    if (truth.bars.empty()) truth.bars.reserve(static_cast<std::size_t>(samples) + 1, bodies.count);
    truth.bars.push_back(answer.bar);
    truth.bars.back().t_s = answer.sample.t_s;
  });
  if (truth.outcome.status != Status::ok && truth.outcome.status != Status::unsupported)
    truth.values.clear(), truth.bars.clear();
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
  found.outcome = ask(std::move(request), limit_s, {}, [&](const wire::Answer& answer) {
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
  wire::Limits most;
  most.poses = static_cast<std::size_t>(std::max<std::int64_t>(count, 0)) + 1;
  outcome = ask(std::move(request), limit_s, most, [&](const wire::Answer& answer) {
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

// ---- one-off requests ---------------------------------------------------------------------------------------------
FieldAtParticles field_once(const std::string& truth_worker, const Scenario& scenario, const std::vector<Wide>& t_s,
                            const std::vector<std::vector<FieldPosition>>& positions, double limit_s,
                            const std::string& response) {
  const BrokenPipeGuard guard;
  WorkerClient client({truth_worker});
  return client.field(scenario_to_json(scenario), response, t_s, positions, limit_s);
}

Truth truth_once(const std::string& truth_worker, const Scenario& scenario, std::int64_t samples, double limit_s) {
  const BrokenPipeGuard guard;
  WorkerClient client({truth_worker});
  return client.truth(scenario_to_json(scenario), sampled_bodies(scenario.scene), scenario.t_end_s, samples, limit_s);
}

}  // namespace atwood
