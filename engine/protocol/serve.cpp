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

#include "protocol/wire.hpp"
#include "protocol/worker.hpp"
#include "scene/files.hpp"

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
template <class Work>
Outcome guarded(Work work) {
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
  Observer observer;
  if (request.repeats == 0) {
    observer.event = [&](const Event& event) { events.push_back(event); };
    observer.sample = [&](const Sample& sample) {
      pipe.put(wire::sample_line(request.cell, sample, events));
      events.clear();
    };
  }
  const Outcome outcome = guarded([&] {
    return engine.run(parse_method_id(request.method), scene, request.plan, observer, request.repeats);
  });
  pipe.put(wire::done_line(request.cell, outcome, events));
}

void answer_truth(TruthSolver solve, const wire::Request& request, Pipe& pipe) {
  const Scenario scenario = scenario_from_json(request.json);
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
  for (std::size_t i = 0; i < truth.values.size(); ++i) {
    pipe.put(wire::truth_line(request.cell, truth.values[i], truth.bars[i]));
  }
  pipe.put(wire::truth_done_line(request.cell, truth));
}

// `answer(request, pipe)` answers everything but hello.
template <class AnswerRequest>
int serve_lines(const Engine& hello, AnswerRequest answer) {
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

int serve(const Engine& engine) {
  return serve_lines(engine, [&](const wire::Request& request, Pipe& pipe) {
    if (request.kind != wire::Request::Kind::run) throw wire::Garbage(engine.name + " answers hello and run");
    answer_run(engine, request, pipe);
  });
}

int serve_truth(TruthSolver solve, const std::string& version) {
  Engine hello;
  hello.name = "truth";
  hello.version = version;
  hello.scalar = "quad";
  MethodInfo& method = hello.methods.emplace_back();
  method.id = "truth";
  method.doc = "The tightest certified truth of a scene: closed form, quad extrapolation and collocation, or CVODE.";
  return serve_lines(hello, [&](const wire::Request& request, Pipe& pipe) {
    if (request.kind != wire::Request::Kind::truth) throw wire::Garbage("this worker answers hello and truth");
    answer_truth(solve, request, pipe);
  });
}

}  // namespace atwood
