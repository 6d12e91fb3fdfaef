// The worker's loop: a line in, lines out, until standard input closes.
//
// A request that cannot be read is answered by one line {"cell":c,"error":"...","done":{"status":"crashed","reason":
// "bad request: ..."}} (c = -1 when it has none), and the loop goes on. What an engine throws ends the cell, not the
// worker: std::invalid_argument (a method id it does not know) is `unsupported`, anything else `crashed`.
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <new>

#include "protocol/descriptors.hpp"
#include "protocol/fluid_field.hpp"
#include "protocol/wire.hpp"
#include "protocol/worker.hpp"
#include "scene/files.hpp"
#include "scene/pair_sweep.hpp"

namespace atwood {
namespace {

// The protocol's own end of the pipe. Standard output itself then points to standard error, where chatter does no harm.
class Pipe {
 public:
  Pipe() : file_(nullptr) {
    std::fflush(stdout);
    const int descriptor = dup(STDOUT_FILENO);
    if (descriptor < 0 || dup2(STDERR_FILENO, STDOUT_FILENO) < 0) return;
    file_ = fdopen(descriptor, "w");
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
  ~Pipe() {
    if (file_) std::fclose(file_);
  }

  bool good() const { return file_ && !std::ferror(file_); }
  void put(const std::string& line) {
    std::fwrite(line.data(), 1, line.size(), file_);
    std::fputc('\n', file_);
  }
  void flush() { std::fflush(file_); }

 private:
  FILE* file_;
};

enum class Read { line, too_long, end };

// One line without its end. A longer one than the protocol allows is skipped to its end.
Read read_line(FILE* input, std::string& line) {
  line.clear();
  bool too_long = false;
  for (int c = std::getc(input); c != '\n'; c = std::getc(input)) {
    if (c == EOF) {
      if (line.empty() && !too_long) return Read::end;
      break;
    }
    if (line.size() < wire::kLongestLine) line.push_back(static_cast<char>(c));
    else too_long = true;
  }
  return too_long ? Read::too_long : Read::line;
}

Outcome failure(Status status, const std::string& reason) {
  Outcome outcome;
  outcome.status = status;
  outcome.reason = reason;
  return outcome;
}

// Whatever `work` throws becomes an outcome.
template <class Work> Outcome guarded(Work work) {
  try {
    return work();
  } catch (const std::invalid_argument& error) {
    return failure(Status::unsupported, error.what());
  } catch (const std::bad_alloc&) {
    return failure(Status::crashed, "out of memory");
  } catch (const std::exception& error) {
    return failure(Status::crashed, error.what());
  } catch (...) {
    return failure(Status::crashed, "an exception of unknown type");
  }
}

void answer_run(const Engine& engine, const wire::Request& request, Pipe& pipe) {
  const Scene scene = scene_from_json(request.json);
  std::vector<Event> events;  // since the last sample
  const wire::Put put = [&](const std::string& line) { pipe.put(line); };
  Observer observer;
  Profile profile;
  if (request.profile) {
    observer.profile = &profile;
  } else if (request.repeats == 0) {
    observer.event = [&](const Event& event) { events.push_back(event); };
    observer.sample = [&](const Sample& sample) {
      wire::event_lines(request.cell, events, nullptr, put);
      wire::sample_lines(request.cell, sample, nullptr, events, put, wire::kLongestPart, &scene.joints);
      events.clear();
    };
  }
  const Outcome outcome = guarded(
      [&] { return engine.run(parse_method_id(request.method), scene, request.plan, observer, request.repeats); });
  wire::event_lines(request.cell, events, nullptr, put);
  pipe.put(wire::done_line(request.cell, outcome, events, profile));
}

void answer_truth(TruthSolver solve, const wire::Request& request, Pipe& pipe) {
  Scenario scenario = scenario_from_json(request.json);
  scenario.truth.response = request.response;
  Truth truth;
  const Outcome outcome = guarded([&] {
    truth = solve(scenario, request.plan.samples);
    return truth.outcome;
  });
  truth.outcome = outcome;
  if (truth.values.size() != truth.bars.size()) {
    truth.outcome = failure(Status::crashed, "the solver gave values without bars");
    truth.values.clear();
  }
  const wire::Put put = [&](const std::string& line) { pipe.put(line); };
  for (std::size_t i = 0; i < truth.values.size(); ++i) {
    const SampleView bar = truth.bars[i];
    wire::sample_lines(request.cell, truth.values[i], &bar, {}, put, wire::kLongestPart, &scenario.scene.joints);
  }
  wire::event_lines(request.cell, truth.events, &truth.event_bar_s, put);
  pipe.put(wire::truth_done_line(request.cell, truth));
}

// The field that was asked for last. Its solver may have work to keep (the coefficients of a spectral solution), so
// that the next times of the same scenario are answered sooner.
struct LastField {
  std::string scenario, response;
  FluidField field;
};

void answer_field(const FluidFieldSolver& solve, const wire::Request& asked, LastField& last, Pipe& pipe) {
  const wire::FieldRequest request = wire::read_field_request(asked.json);
  if (!solve) throw wire::Garbage("this worker has no fields");
  if (!last.field.at || last.scenario != request.scenario || last.response != request.response) {
    last = {request.scenario, request.response, {}};
    const Scenario scenario = scenario_from_json(request.scenario);
    last.field.outcome = guarded([&] {
      last.field = solve(scenario, request.response);
      return last.field.outcome;
    });
  }
  FluidField ended = {last.field.outcome, last.field.source, last.field.note, last.field.known, {}};
  if (ended.outcome.status == Status::ok)
    ended.outcome = guarded([&] {
      for (std::size_t k = 0; k < request.t_s.size(); ++k)
        wire::field_lines(request.cell, last.field.at(request.t_s[k], request.positions[k]),
                          [&](const std::string& line) { pipe.put(line); });
      return last.field.outcome;
    });
  pipe.put(wire::field_done_line(request.cell, ended));
}

// ---- contacts -----------------------------------------------------------------------------------------------------
// The function that answers a request for contacts; empty: the engine has none.
struct ContactTest {
  const Engine& engine;
  const PairQueries& queries;

  ContactAnswer operator()(const std::string& test, const Scene& scene, const ContactQuery& query) const {
    if (test.empty() || test == "contacts") {
      if (!engine.contacts) throw std::invalid_argument(engine.name + " answers no questions about contacts");
      return engine.contacts(scene, query);
    }
    const auto found = queries.tests.find(test);
    if (found == queries.tests.end())
      throw std::invalid_argument(engine.name + " has no test `" + test + "` of contacts");
    return found->second(scene, query);
  }
};

void answer_contacts(const ContactTest& test, const wire::Request& request, Pipe& pipe) {
  ContactAnswer answer;
  answer.outcome = guarded([&] {
    answer = test(request.test, scene_from_json(request.json), request.contacts);
    return answer.outcome;
  });
  if (answer.outcome.status == Status::ok) pipe.put(wire::contacts_line(request.cell, answer, request.contacts.swept));
  pipe.put(wire::done_line(request.cell, answer.outcome, {}));
}

template <std::size_t n> std::array<double, n> narrowed(const std::array<Wide, n>& wide) {
  std::array<double, n> narrow{};
  for (std::size_t i = 0; i < n; ++i) narrow[i] = static_cast<double>(wide[i]);
  return narrow;
}

// The deepest contact of a pose, or its first touch; where they are apart, how far, from those who can tell.
PoseAnswer pose_answer(const ContactTest& test, const wire::Request& request, const Scene& scene, Outcome& outcome) {
  PoseAnswer pose;
  const bool own = request.test.empty() || request.test == "contacts";
  ContactQuery query = request.contacts;
  query.t_end_s = kSweepEndS;
  const bool by_gap = own && !query.swept && test.queries.gap;
  const bool by_gap_alone = by_gap && test.queries.gap_decides;
  if (!by_gap_alone) {
    const ContactAnswer found = test(request.test, scene, query);
    outcome = found.outcome;
    pose.hit = query.swept ? !found.touches.empty() : !found.contacts.empty();
    pose.points = static_cast<int>(found.contacts.size());
    const FoundContact* deepest = nullptr;
    for (const FoundContact& each : found.contacts)
      if (!deepest || each.depth_m > deepest->depth_m) deepest = &each;
    if (deepest) pose.gap_m = -static_cast<double>(deepest->depth_m);
    if (deepest) pose.normal = narrowed(deepest->normal), pose.x_m = narrowed(deepest->x_m);
    if (query.swept && pose.hit) {
      const FoundTouch& first = found.touches.front();
      pose.toi_s = static_cast<double>(first.toi_s);
      pose.normal = narrowed(first.normal), pose.x_m = narrowed(first.x_m);
    }
    if (!by_gap || pose.hit || outcome.status != Status::ok) return pose;
  }
  const PairGap gap = test.queries.gap(scene, 0, 1);
  pose.gap_m = static_cast<double>(gap.gap_m);
  pose.normal = narrowed(gap.normal), pose.x_m = narrowed(gap.x_m);
  pose.bar = gap.bar_m, pose.margin_m = gap.margin_m;
  if (by_gap_alone) pose.hit = gap.gap_m <= 0;
  return pose;
}

void answer_sweep(const ContactTest& test, const wire::Request& request, Pipe& pipe) {
  constexpr std::size_t poses_per_line = 500;
  std::vector<PoseAnswer> poses;
  std::map<std::string, SolveTally> solvers;
  Outcome ended = guarded([&] {
    Outcome outcome;
    for (std::int64_t k = request.from; k < request.from + request.count && outcome.status == Status::ok; ++k) {
      const Scene scene = sweep_scene(request.pair, request.seed, k, request.contacts.swept);
      poses.push_back(pose_answer(test, request, scene, outcome));
      for (const auto& [solver, tally] : outcome.solvers) solvers[solver].add(tally);
      outcome.solvers.clear();
      if (poses.size() < poses_per_line) continue;
      pipe.put(wire::poses_line(request.cell, poses));
      poses.clear();
    }
    return outcome;
  });
  ended.solvers = solvers;
  if (ended.status == Status::ok && !poses.empty()) pipe.put(wire::poses_line(request.cell, poses));
  pipe.put(wire::done_line(request.cell, ended, {}));
}

// True when the request was one about contacts.
bool answered_contacts(const ContactTest& test, const wire::Request& request, Pipe& pipe) {
  if (request.kind == wire::Request::Kind::contacts) answer_contacts(test, request, pipe);
  else if (request.kind == wire::Request::Kind::sweep) answer_sweep(test, request, pipe);
  else return false;
  return true;
}

// `answer(request, pipe)` answers everything but hello.
template <class AnswerRequest> int serve_lines(const Engine& hello, AnswerRequest answer) {
  open_standard_descriptors();
  Pipe pipe;
  std::string line;
  for (;;) {
    if (!pipe.good()) return 1;
    const Read read = read_line(stdin, line);
    if (read == Read::end) return 0;
    if (read == Read::line && line.empty()) continue;
    std::int64_t cell = -1;
    try {
      if (read == Read::too_long) throw wire::Garbage("a line of more than 64 MiB");
      const wire::Request request = wire::read_request(line, cell);
      if (request.kind == wire::Request::Kind::hello) pipe.put(wire::hello_line(hello));
      else answer(request, pipe);
    } catch (const std::exception& error) {
      pipe.put(wire::error_line(cell, error.what()));
    }
    pipe.flush();
  }
}

}  // namespace

int serve(const Engine& engine, const PairQueries& queries) {
  const ContactTest test{engine, queries};
  return serve_lines(engine, [&](const wire::Request& request, Pipe& pipe) {
    if (answered_contacts(test, request, pipe)) return;
    if (request.kind != wire::Request::Kind::run) throw wire::Garbage(engine.name + " answers hello, run and contacts");
    answer_run(engine, request, pipe);
  });
}

int serve_truth(TruthSolver solve, const std::string& version, const ContactsOf& contacts, const PairQueries& queries,
                const FluidFieldSolver& field) {
  Engine hello;
  hello.name = "truth";
  hello.version = version;
  hello.scalar = "quad";
  MethodInfo& method = hello.methods.emplace_back();
  method.id = "truth";
  method.doc = "The tightest certified truth of a scene: closed form, quad extrapolation and collocation, or CVODE.";
  hello.contacts = contacts;
  const ContactTest test{hello, queries};
  LastField last;
  return serve_lines(hello, [&](const wire::Request& request, Pipe& pipe) {
    if (answered_contacts(test, request, pipe)) return;
    if (request.kind == wire::Request::Kind::field) {
      answer_field(field, request, last, pipe);
      return;
    }
    if (request.kind != wire::Request::Kind::truth)
      throw wire::Garbage("this worker answers hello, truth, fluid-field and contacts");
    answer_truth(solve, request, pipe);
  });
}

}  // namespace atwood
