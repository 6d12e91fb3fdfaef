// The worker's loop in a separate process: requests from a file, answers to a file.
#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>
#include <catch2/catch.hpp>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>

#include "protocol/wire.hpp"
#include "protocol/worker.hpp"
#include "scene/files.hpp"
#include "scene/pair_sweep.hpp"

using namespace atwood;

namespace {

// One body at rest; the names of the methods say what else they do.
Outcome demo(const MethodId& id, const Scene& scene, const Plan& plan, const Observer& observer, int repeats) {
  std::printf("chatter of the engine on standard output\n");
  if (id.scheme == "throws") throw std::runtime_error("the engine gave up");
  if (id.scheme == "unknown") throw std::invalid_argument("demo has no scheme `unknown`");
  Outcome outcome;
  outcome.steps_taken = plan.steps;
  if (observer.profile) {
    if (observer.sample || observer.event) throw std::runtime_error("a profile pass that is observed");
    observer.profile->step_ns.assign(static_cast<std::size_t>(plan.steps), 7);
    observer.profile->phase_ns["stand"] = 3;
    return outcome;
  }
  if (repeats > 0) {
    outcome.busy_ns.assign(static_cast<std::size_t>(repeats), 5);
    return outcome;
  }
  Event event;
  event.body_b = 0;
  for (std::int64_t k = 0; k <= plan.samples; ++k) {
    Sample sample;
    sample.t_s = static_cast<Wide>(plan.t_end_s) * k / plan.samples;
    sample.bodies.resize(id.scheme == "crowd" ? 120000 : scene.bodies.size());
    if (id.scheme == "crowd")
      for (BodySample& body : sample.bodies)
        body.p_m.fill(1.0 / 3), body.v_m_per_s.fill(0.1 / 3), body.q_wxyz.fill(1 / 7.0);
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

TEST_CASE("hello, accuracy and timing are answered, and output of the engine does not reach the pipe") {
  const auto lines =
      answers(wire::to_line(wire::Request{}) + "\n" + run_request(3, "demo/still", 0) + run_request(4, "demo/still", 2),
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

TEST_CASE("a sample of many bodies is sent in several lines of limited length") {
  const auto lines = answers(run_request(3, "demo/crowd", 0), [] { return serve(demo_engine()); });
  std::size_t bodies = 0, samples = 0, events = 0, longest = 0;
  for (const std::string& line : lines) {
    longest = std::max(longest, line.size());
    const wire::Answer answer = wire::read_answer(line);
    if (answer.done) continue;
    CHECK(answer.from == bodies % 120000);
    bodies += answer.sample.bodies.size();
    samples += answer.more ? 0 : 1;
    events += answer.events.size();
  }
  CHECK(longest < wire::kLongestPart + 1000);
  CHECK(lines.size() > 6);
  CHECK(bodies == 5 * 120000);
  CHECK(samples == 5);
  CHECK(events == 4);
}

TEST_CASE("a worker without standard output or input ends") {
  const auto code = [](bool input, bool output) {
    const pid_t child = fork();
    if (child == 0) {
      if (!input) close(STDIN_FILENO);
      if (!output) close(STDOUT_FILENO);
      close(STDERR_FILENO);
      _exit(serve(demo_engine()));
    }
    int status = 0;
    waitpid(child, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  };
  CHECK(code(false, true) == 0);
  CHECK(code(false, false) == 1);
}

TEST_CASE("a profile pass is not observed and tells the time of every step") {
  std::string request = run_request(5, "demo/still", 0);
  const std::string pass = "\"accuracy\"";
  request.replace(request.find(pass), pass.size(), "\"profile\"");
  const auto lines = answers(request, [] { return serve(demo_engine()); });
  REQUIRE(lines.size() == 1);
  const wire::Answer answer = wire::read_answer(lines[0]);
  CHECK(answer.outcome.status == Status::ok);
  CHECK(answer.profile.step_ns == std::vector<std::int64_t>(static_cast<std::size_t>(answer.outcome.steps_taken), 7));
  CHECK(answer.profile.phase_ns.at("stand") == 3);
}

TEST_CASE("what an engine throws ends the cell, what a request lacks is said, and the loop goes on") {
  const auto lines =
      answers("not json\n{\"request\":\"run\",\"cell\":8}\n" + run_request(1, "demo/throws", 0) +
                  run_request(2, "demo/unknown", 0) + run_request(3, "nonsense", 0) +
                  "{\"request\":\"truth\",\"cell\":6,\"samples\":4,\"scenario\":{}}\n" +
                  R"({"request":"run","cell":7,"method":"demo/still","t_end_s":1,"steps":4,"samples":4,"scene":7})" +
                  "\n\n" + wire::to_line(wire::Request{}),
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
    truth.values = std::vector(static_cast<std::size_t>(samples) + 1, Sample{0, std::vector<BodySample>(1)});
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

// ---- contacts -----------------------------------------------------------------------------------------------------
namespace {

// Says of every scene: one contact 0.1 deep, or one touch at half the time.
Engine touching_engine() {
  Engine engine = demo_engine();
  engine.contacts = [](const Scene& scene, const ContactQuery& query) {
    ContactAnswer answer;
    if (query.swept) answer.touches.push_back({0, 1, static_cast<Wide>(query.t_end_s) / 2, {1, 2, 3}, {0, 0, 1}});
    else answer.contacts.push_back({0, 1, {1, 2, 3}, {0, 0, 1}, static_cast<Wide>(1) / 3});
    if (scene.bodies.size() == 1) throw std::invalid_argument("demo needs two bodies");
    return answer;
  };
  return engine;
}

std::string contacts_request(std::int64_t cell, bool swept, std::size_t bodies) {
  Scene scene = sweep_scene("box-box", 1, 0, false);
  scene.bodies.resize(bodies);
  wire::Request request;
  request.kind = wire::Request::Kind::contacts;
  request.cell = cell;
  request.contacts = {swept, 8};
  request.json = scene_to_json(scene);
  return wire::to_line(request) + "\n";
}

std::string sweep_request(std::int64_t cell, const std::string& pair, std::int64_t count, const std::string& test) {
  wire::Request request;
  request.kind = wire::Request::Kind::sweep;
  request.cell = cell;
  request.test = test;
  request.pair = pair;
  request.seed = 42;
  request.count = count;
  return wire::to_line(request) + "\n";
}

}  // namespace

TEST_CASE("contacts and touches come back to the last bit; an engine without them says so") {
  const auto lines =
      answers(contacts_request(1, false, 2) + contacts_request(2, true, 2) + contacts_request(3, false, 1),
              [] { return serve(touching_engine()); });
  REQUIRE(lines.size() == 5);
  const wire::Answer still = wire::read_answer(lines[0]), moving = wire::read_answer(lines[2]);
  REQUIRE(still.contacts.size() == 1);
  CHECK(still.contacts[0].depth_m == static_cast<Wide>(1) / 3);
  CHECK(still.contacts[0].x_m[2] == 3);
  CHECK(still.contacts[0].normal[2] == 1);
  REQUIRE(moving.touches.size() == 1);
  CHECK(moving.touches[0].toi_s == 4);
  CHECK(wire::read_answer(lines[1]).done);
  CHECK(wire::read_answer(lines[4]).outcome.status == Status::unsupported);

  const auto none =
      answers(contacts_request(1, false, 2) + sweep_request(2, "box-box", 3, ""), [] { return serve(demo_engine()); });
  REQUIRE(none.size() == 2);
  for (const auto& line : none) CHECK(wire::read_answer(line).outcome.status == Status::unsupported);
}

TEST_CASE("a sweep of poses is answered pose by pose, by the test that is named") {
  PairQueries queries;
  queries.tests["blind"] = [](const Scene&, const ContactQuery&) { return ContactAnswer{}; };
  queries.gap = [](const Scene&, int, int) { return PairGap{7, {1, 0, 0}, {}, 0.5, 0.25}; };
  const auto lines = answers(sweep_request(1, "box-box", 1201, "") + sweep_request(2, "sphere-box", 2, "blind") +
                                 sweep_request(3, "no-pair", 2, "") + sweep_request(4, "box-box", 2, "unknown"),
                             [&] { return serve(touching_engine(), queries); });
  REQUIRE(lines.size() == 4 + 2 + 1 + 1);
  std::size_t poses = 0;
  for (std::size_t i = 0; i < 3; ++i) poses += wire::read_answer(lines[i]).poses.size();
  CHECK(poses == 1201);
  const PoseAnswer first = wire::read_answer(lines[0]).poses.front();
  CHECK(first.hit);
  CHECK(first.gap_m == -1.0 / 3);
  CHECK(first.points == 1);
  CHECK(first.x_m == std::array<double, 3>{1, 2, 3});
  const auto blind = wire::read_answer(lines[4]).poses;
  REQUIRE(blind.size() == 2);
  CHECK(!blind[1].hit);
  CHECK(std::isnan(blind[1].gap_m));  // the named test alone answers, not `gap`
  CHECK(wire::read_answer(lines[6]).outcome.status == Status::unsupported);
  CHECK(wire::read_answer(lines[6]).outcome.reason.find("box-box") != std::string::npos);
  CHECK(wire::read_answer(lines[7]).outcome.status == Status::unsupported);
}

TEST_CASE("seeded poses depend on seed, pair and index alone") {
  const auto text = [](const std::string& pair, std::uint64_t seed, std::int64_t k) {
    return scene_to_json(sweep_scene(pair, seed, k, false));
  };
  for (const std::string& pair : sweep_pairs()) {
    CHECK(text(pair, 42, 7) == text(pair, 42, 7));
    CHECK(text(pair, 42, 7) != text(pair, 43, 7));
    CHECK(text(pair, 42, 7) != text(pair, 42, 8));
    CHECK(pair_size_m(sweep_scene(pair, 42, 7, false)) > 0);
  }
  for (const std::string& pair : touch_pairs())
    CHECK(sweep_scene(pair, 42, 7, true).bodies[0].velocity_m_per_s != Real3{});
  CHECK_THROWS_AS(sweep_scene("box", 42, 7, false), std::invalid_argument);
}
