// The worker's loop in a process of its own: requests from a file, answers to a file.
#include <catch2/catch.hpp>
#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>

#include "protocol/wire.hpp"
#include "protocol/worker.hpp"
#include "scene/files.hpp"

using namespace atwood;

namespace {

// One body that stands still; what its methods do besides is in their names.
Outcome demo(const MethodId& id, const Scene& scene, const Plan& plan, const Observer& observer, int repeats) {
  std::printf("chatter of the engine on standard output\n");
  if (id.scheme == "throws") throw std::runtime_error("the engine gave up");
  if (id.scheme == "unknown") throw std::invalid_argument("demo has no scheme `unknown`");
  Outcome outcome;
  outcome.steps_taken = plan.steps;
  if (repeats > 0) {
    outcome.busy_ns.assign(static_cast<std::size_t>(repeats), 5);
    return outcome;
  }
  Event event;
  event.body_b = 0;
  for (std::int64_t k = 0; k <= plan.samples; ++k) {
    Sample sample;
    sample.t_s = static_cast<Wide>(plan.t_end_s) * k / plan.samples;
    sample.bodies.resize(scene.bodies.size());
    observer.sample(sample);
    event.t_s = sample.t_s;
    observer.event(event);
  }
  return outcome;
}

Engine demo_engine() {
  Engine engine;
  engine.name = "demo";
  engine.methods.push_back({"demo/still", "Stands still.", "", {}, false, {}});
  engine.run = demo;
  return engine;
}

std::vector<std::string> answers(const std::string& requests, const std::function<int()>& worker) {
  char folder[] = "/tmp/atwood-serve-XXXXXX";
  REQUIRE(mkdtemp(folder) != nullptr);
  const std::string in = std::string(folder) + "/in", out = std::string(folder) + "/out";
  std::ofstream(in) << requests;
  std::fflush(stdout);
  const pid_t child = fork();
  if (child == 0) {
    const int from = open(in.c_str(), O_RDONLY), to = open(out.c_str(), O_WRONLY | O_CREAT, 0600);
    const int nowhere = open("/dev/null", O_WRONLY);
    dup2(from, STDIN_FILENO);
    dup2(to, STDOUT_FILENO);
    dup2(nowhere, STDERR_FILENO);
    _exit(worker());
  }
  int status = 0;
  waitpid(child, &status, 0);
  CHECK(WIFEXITED(status));
  CHECK(WEXITSTATUS(status) == 0);
  std::vector<std::string> lines;
  std::ifstream file(out);
  for (std::string line; std::getline(file, line);) lines.push_back(line);
  std::filesystem::remove_all(folder);
  return lines;
}

std::string run_request(std::int64_t cell, const std::string& method, int repeats) {
  Scene scene;
  scene.materials.push_back({"default", 0, 0, 0});
  scene.pairs.push_back({});
  Body body;
  body.name = "ball";
  body.mass_kg = 1;
  scene.bodies.push_back(body);
  wire::Request request;
  request.kind = wire::Request::Kind::run;
  request.cell = cell;
  request.method = method;
  request.plan = {1, 8, 4};
  request.repeats = repeats;
  request.json = scene_to_json(scene);
  return wire::to_line(request) + "\n";
}

}  // namespace

TEST_CASE("hello, accuracy and timing are answered, the engine's chatter kept off the pipe") {
  const auto lines = answers(wire::to_line({}) + "\n" + run_request(3, "demo/still", 0) + run_request(4, "demo/still", 2),
                             [] { return serve(demo_engine()); });
  REQUIRE(lines.size() == 1 + 6 + 1);
  CHECK(wire::read_hello(lines[0]).name == "demo");
  std::size_t events = 0;
  for (std::size_t i = 1; i <= 6; ++i) {
    const wire::Answer answer = wire::read_answer(lines[i]);
    CHECK(answer.cell == 3);
    CHECK(answer.done == (i == 6));
    events += answer.events.size();
  }
  CHECK(events == 5);  // the last one comes after the last sample, with `done`
  CHECK(wire::read_answer(lines[7]).outcome.busy_ns == std::vector<std::int64_t>{5, 5});
}

TEST_CASE("what an engine throws ends the cell, what a request lacks is said, and the loop goes on") {
  const auto lines = answers("not json\n{\"request\":\"run\",\"cell\":8}\n" + run_request(1, "demo/throws", 0) +
                                 run_request(2, "demo/unknown", 0) + run_request(3, "nonsense", 0) +
                                 "{\"request\":\"truth\",\"cell\":6,\"samples\":4,\"scenario\":{}}\n" +
                                 R"({"request":"run","cell":7,"method":"demo/still","t_end_s":1,"steps":4,"samples":4,"scene":7})" +
                                 "\n\n" + wire::to_line({}),
                             [] { return serve(demo_engine()); });
  REQUIRE(lines.size() == 8);
  const auto outcome = [&](std::size_t i) { return wire::read_answer(lines[i]); };
  CHECK(outcome(0).cell == -1);
  CHECK(outcome(1).cell == 8);
  for (const std::size_t i : {0, 1, 5, 6}) {
    CHECK(outcome(i).outcome.status == Status::crashed);
    CHECK(outcome(i).outcome.reason.rfind("bad request: ", 0) == 0);
    CHECK(lines[i].find("\"error\":") != std::string::npos);
  }
  CHECK(outcome(2).outcome.status == Status::crashed);
  CHECK(outcome(2).outcome.reason == "the engine gave up");
  CHECK(outcome(3).outcome.status == Status::unsupported);
  CHECK(outcome(4).outcome.status == Status::unsupported);
  CHECK(wire::read_hello(lines[7]).name == "demo");
}

TEST_CASE("a truth is answered with bars, and its solver's failures as outcomes") {
  const TruthSolver solve = [](const Scenario& scenario, std::int64_t samples) {
    if (scenario.id == "hopeless") throw std::runtime_error("no truth here");
    Truth truth;
    truth.source = "demo";
    truth.values.resize(static_cast<std::size_t>(samples) + 1, Sample{0, std::vector<BodySample>(1)});
    truth.bars = truth.values;
    return truth;
  };
  Scenario scenario;
  scenario.id = "easy";
  scenario.t_end_s = 1;
  scenario.samples = 2;
  scenario.steps = {2};
  scenario.scene.materials.push_back({"default", 0, 0, 0});
  scenario.scene.pairs.push_back({});
  wire::Request request;
  request.kind = wire::Request::Kind::truth;
  request.cell = 1;
  request.plan.samples = 2;
  request.json = scenario_to_json(scenario);
  std::string requests = wire::to_line(request) + "\n";
  scenario.id = "hopeless";
  request.json = scenario_to_json(scenario);
  requests += wire::to_line(request) + "\n";
  const auto lines = answers(requests, [&] { return serve_truth(solve, "1"); });
  REQUIRE(lines.size() == 3 + 1 + 1);
  CHECK(wire::read_answer(lines[0]).has_bar);
  CHECK(wire::read_answer(lines[3]).source == "demo");
  CHECK(wire::read_answer(lines[4]).outcome.status == Status::crashed);
  CHECK(wire::read_answer(lines[4]).outcome.reason == "no truth here");
}
