// Answers of workers: for every fault the cell ends with a status and a reason, and a fresh process answers the next
// request.
#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <catch2/catch.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <thread>

#include "asked.hpp"
#include "scene/files.hpp"

using namespace atwood;

namespace {

struct FaultyAnswer {
  const char* method;
  Status status;
  const char* reason;
};

}  // namespace

TEST_CASE("each fault is named, and the worker answers again after it") {
  const FaultyAnswer fault = GENERATE(
      FaultyAnswer{"dies", Status::crashed, "killed by signal 11 (Segmentation fault): before the end: red  words"},
      FaultyAnswer{"exits", Status::crashed, "exited with code 3"},
      FaultyAnswer{"garbage", Status::crashed,
                   "invalid answer: not a JSON object: Segmentation fault is what I would say"},
      FaultyAnswer{"half_a_line", Status::crashed, "exited with code 0 in the middle of a line"},
      FaultyAnswer{"endless_line", Status::crashed, "invalid answer: a line of more than 64 MiB"},
      FaultyAnswer{"wrong_cell", Status::crashed, "invalid answer: an answer to cell"},
      FaultyAnswer{"wrong_time", Status::crashed, "invalid answer: sample 0 is at t_s = 0.5; asked for 0"},
      FaultyAnswer{"too_many_samples", Status::crashed, "invalid answer: more samples than the 9 asked for"},
      FaultyAnswer{"too_few_samples", Status::crashed, "invalid answer: ended as ok with 2 of 9 samples"},
      FaultyAnswer{"body_missing", Status::crashed, "invalid answer: sample 0 has 0 bodies; the scene has 1"},
      FaultyAnswer{
          "bare_nan", Status::crashed,
          "invalid answer: not a JSON object: it holds a bare NaN, which is not JSON; write non-finite numbers as the "
          "strings"},
      FaultyAnswer{"steps_negative", Status::crashed, "invalid answer: \"steps_taken\" is negative: -3"},
      FaultyAnswer{"norm_two", Status::crashed,
                   "invalid answer: sample 0: the quaternion of body 0, [2, 0, 0, 0], has norm 2; a unit quaternion"},
      FaultyAnswer{"norm_two_later", Status::crashed,
                   "invalid answer: sample 3: the quaternion of body 0, [2, 0, 0, 0], has norm 2"},
      FaultyAnswer{
          "other_scene", Status::crashed,
          "invalid answer: sample 0 is not the scene's initial state: body 0 has position_m [1.1, 0.2, 0.3] where the "
          "scene has [0.1, 0.2, 0.3]"},
      FaultyAnswer{
          "other_velocity", Status::crashed,
          "invalid answer: sample 0 is not the scene's initial state: body 0 has velocity_m_per_s [3, 0, 0.5] where"},
      FaultyAnswer{"milliseconds", Status::crashed,
                   "invalid answer: sample 1 is at t_s = 250; asked for 0.25: is it in milliseconds?"},
      FaultyAnswer{"sample_indices", Status::crashed,
                   "invalid answer: sample 1 is at t_s = 1; asked for 0.25: is it the index of the sample?"},
      FaultyAnswer{"deep", Status::crashed, "invalid answer: nested deeper than 64 levels: {\"cell\":"},
      FaultyAnswer{"many_bodies", Status::crashed, "invalid answer: more than 65 bodies in a line"},
      FaultyAnswer{"many_unknown", Status::crashed, "invalid answer: sample 0 has 0 bodies; the scene has 1"},
      FaultyAnswer{"part_missing", Status::crashed,
                   "invalid answer: a part of a sample is from body 1 on; expected was body 0"},
      FaultyAnswer{"part_unfinished", Status::crashed, "invalid answer: ended in the middle of a sample"},
      FaultyAnswer{"not_utf8", Status::crashed, "exited with code 5: caf\xEF\xBF\xBD"},
      FaultyAnswer{"refuses", Status::unsupported, "faulty has no springs"});
  CAPTURE(fault.method);
  Asked ask;
  const Recording recording = ask(fault.method);
  CHECK(to_string(recording.outcome.status) == to_string(fault.status));
  CHECK_THAT(recording.outcome.reason, Catch::StartsWith(fault.reason));
  const Recording after = ask("well");
  CHECK(after.outcome.status == Status::ok);
  CHECK(after.values.size() == 9);
}

TEST_CASE("times that cannot be are named") {
  const FaultyAnswer fault = GENERATE(
      FaultyAnswer{"busy_negative", Status::crashed,
                   "invalid answer: busy_ns has -5; the nanoseconds of a run are positive"},
      FaultyAnswer{"busy_zero", Status::crashed,
                   "invalid answer: busy_ns has 0; the nanoseconds of a run are positive: is it in seconds"},
      FaultyAnswer{"busy_missing", Status::crashed, "invalid answer: busy_ns has 2 entries; asked for 3 repeats"},
      FaultyAnswer{"busy_too_long", Status::crashed,
                   "invalid answer: busy_ns of all repeats is 3e+10 ns, longer than the whole answer"},
      FaultyAnswer{"busy_seconds", Status::crashed,
                   "invalid answer: \"busy_ns\" is not an integer: 0.25; whole nanoseconds were expected"});
  CAPTURE(fault.method);
  Asked ask;
  const Recording recording = ask(fault.method, 20, 3);
  CHECK(to_string(recording.outcome.status) == to_string(fault.status));
  CHECK_THAT(recording.outcome.reason, Catch::StartsWith(fault.reason));
  CHECK(ask("well", 20, 3).outcome.status == Status::ok);
}

TEST_CASE("a unit is guessed where a step would have taken no time") {
  CHECK_THROWS_WITH(check_busy({100, 100}, 2, 100000, 250'000'000), Catch::Contains("is it in milliseconds?"));
  CHECK_THROWS_WITH(check_busy({2}, 1, 100000, 2'500'000'000), Catch::Contains("is it in seconds?"));
  CHECK_NOTHROW(check_busy({100, 100}, 2, 100, 250'000'000));
  CHECK_NOTHROW(check_busy({50}, 1, 1, 200'000));
  CHECK_NOTHROW(check_busy({1'000'000'000}, 1, 100, 1'000'500'000));
}

TEST_CASE("the quaternion of a turning body: foreign engines keep its norm within 10 %, our own are not bounded") {
  Scenario spinning = free_flight("spinning");
  Body& ball = spinning.scene.bodies[0];
  ball.shape = Sphere{0.1};
  ball.inertia_kg_m2 = {0.1, 0, 0, 0, 0.1, 0, 0, 0, 0.1};
  ball.angular_velocity_body_rad_per_s = {0, 0, 1};
  const SampledBodies bodies(spinning.scene);
  REQUIRE(bodies.start[0].turns);
  const auto sample_of_norm = [](double norm) {
    Sample sample;
    sample.bodies.resize(1);
    sample.bodies[0].q_wxyz = {0.6 * norm, 0, 0, 0.8 * norm};
    return sample;
  };
  for (const double norm : {2.0, 50.0, 0.001, 0.0, 1.2, 0.89, 1e200}) {
    CAPTURE(norm);
    CHECK_THROWS_WITH(
        check_states(sample_of_norm(norm), 3, 2, bodies, true),
        Catch::StartsWith("sample 3: the quaternion of body 0, [") && Catch::Contains("within 10 % of 1"));
    CHECK_NOTHROW(check_states(sample_of_norm(norm), 3, 2, bodies, false));
  }
  for (const double norm : {1.0, 1.01, 1.09, 0.91, std::nan("")})
    CHECK_NOTHROW(check_states(sample_of_norm(norm), 3, 2, bodies, true));
}

TEST_CASE("finite values of an absurd size are a motion that has diverged") {
  const SampledBodies bodies(scenario.scene);  // 3.2 m/s over 2 s: 6.4 m
  std::vector<Sample> samples(9);
  for (Sample& sample : samples) {
    sample.bodies.resize(1);
    sample.bodies[0].p_m = {1e12, 0, 0};
    sample.bodies[0].v_m_per_s = {0, 1e12, 0};
  }
  CHECK(blow_up(samples, 2, bodies) == "");
  samples[4].bodies[0].p_m = {1e300, 0, 0};
  CHECK_THAT(blow_up(samples, 2, bodies),
             Catch::StartsWith("body 0 moves 1e+300 m from sample 3 to 4; the scene's size is 6.4"));
  samples[4].bodies[0].p_m = {1e12, 0, 0};
  samples[5].bodies[0].v_m_per_s = {0, -1e308, 1e308};
  CHECK_THAT(blow_up(samples, 2, bodies),
             Catch::StartsWith("body 0 has a speed of 1.4") && Catch::Contains("at sample 5"));
  for (Wide& x : samples[5].bodies[0].v_m_per_s) x = static_cast<Wide>(std::nan(""));  // `not finite` is another ending
  CHECK(blow_up(samples, 2, bodies) == "");
  samples[6].bodies[0].w_rad_per_s = {1e300, 0, 0};  // a point does not turn
  CHECK(blow_up(samples, 2, bodies) == "");
}

TEST_CASE("a foreign engine's step takes some time") {
  CHECK_THROWS_WITH(check_busy({1, 1}, 2, 60, 20'000'000, true),
                    Catch::Contains("ns a step; at least 0.3 ns were expected: is busy_ns in another unit?"));
  CHECK_NOTHROW(check_busy({18, 18}, 2, 60, 20'000'000, true));
  CHECK_THROWS_WITH(check_busy({106, 106}, 2, 60, 220'000, true), Catch::Contains("is it in microseconds?"));
  CHECK_NOTHROW(check_busy({106, 106}, 2, 60, 20'000'000, true));
  CHECK_NOTHROW(check_busy({1, 1}, 2, 60, 20'000'000));
}

TEST_CASE("a sample given twice is told as that") {
  Sample sample;
  sample.bodies.resize(1);
  sample.t_s = 0.75;
  CHECK_NOTHROW(check_layout(sample, 3, 2, 8, SampledBodies(1)));
  CHECK_THROWS_WITH(check_layout(sample, 4, 2, 8, SampledBodies(1)),
                    "sample 3, at t_s = 0.75, came twice; the next one is due at 1");
}

TEST_CASE("the times of a million samples are distinguished") {
  Sample sample;
  sample.bodies.resize(1);
  sample.t_s = 3e-5;
  CHECK_NOTHROW(check_layout(sample, 3, 10, 1'000'000, SampledBodies(1)));
  CHECK_THROWS_WITH(check_layout(sample, 4, 10, 1'000'000, SampledBodies(1)), Catch::Contains("came twice"));
  sample.t_s = 3.4e-5;
  CHECK_THROWS_WITH(check_layout(sample, 3, 10, 1'000'000, SampledBodies(1)), Catch::Contains("asked for 3e-05"));
}

TEST_CASE("what a worker does after the end of its answer is no fault of the next cell") {
  const Folder folder;
  setenv("EARLY_LOG", (folder / "early").c_str(), 1);
  Asked ask({.writable = {folder.path}});
  CHECK(ask("early").outcome.status == Status::ok);
  for (int i = 0; i < 1000 && !std::filesystem::exists(folder / "early"); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  unsetenv("EARLY_LOG");
  for (const char* method : {"late", "dies_later", "well"}) {
    INFO(method);
    const Recording next = ask(method);
    CHECK(next.outcome.reason == "");
    CHECK(next.outcome.status == Status::ok);
    CHECK(next.values.size() == 9);
    if (method == std::string("dies_later")) std::this_thread::sleep_for(std::chrono::milliseconds(200));
  }
}

TEST_CASE("a fault of the cell itself is found in a new process too") {
  Asked ask;
  for (const char* method : {"wrong_cell", "garbage", "dies", "norm_two", "wrong_time", "too_many_samples"}) {
    INFO(method);
    CHECK(ask("well").outcome.status == Status::ok);
    const Outcome outcome = ask(method).outcome;
    CHECK(outcome.status == Status::crashed);
    CHECK(outcome.reason.substr(0, 30) == Asked()(method).outcome.reason.substr(0, 30));  // numbers of cells follow
  }
}

TEST_CASE("a sample may come in parts") {
  Asked ask;
  const Recording recording = ask("in_parts");
  CHECK(recording.outcome.reason == "");
  CHECK(recording.outcome.status == Status::ok);
  CHECK(recording.values.size() == 9);
}

TEST_CASE("two engines of one name, and names that are taken, are refused") {
  const Folder folder;
  const auto engine = [&](const std::string& file, const std::string& hello) {
    const std::string path = folder / file;
    std::ofstream(path) << "#!/bin/sh\nread line\necho '" << hello << "'\n";
    std::filesystem::permissions(path, std::filesystem::perms::owner_all);
    return path;
  };
  const std::string good = engine("good", R"({"engine":"mine","methods":[{"id":"mine/a"}]})");
  for (const std::string name : {"ATWOOD", " atwood", "-mine", "min\xC3\xA9"}) {
    CAPTURE(name);
    const auto refused = find_workers({engine("named", R"({"engine":")" + name + R"(","methods":[]})")});
    CHECK(refused[0].status == Status::crashed);
    CHECK_THAT(refused[0].reason, Catch::StartsWith("answering `hello`: invalid answer: the name of the engine is `") &&
                                      Catch::Contains("lower-case"));
  }
  for (const std::string order : {"\"nan\"", "\"inf\"", "0", "-2"}) {
    CAPTURE(order);
    const auto refused = find_workers(
        {engine("claims", R"({"engine":"c","methods":[{"id":"c/a","claims":{"rotation":)" + order + "}}]}")});
    CHECK(refused[0].status == Status::crashed);
    CHECK_THAT(refused[0].reason, Catch::Contains("method `c/a` claims the order") &&
                                      Catch::Contains("for \"rotation\"; expected a finite, positive"));
  }
  const auto found = find_workers({folder / "atwood-engine", good, engine("again", R"({"engine":"mine","methods":[]})"),
                                   good, engine("ours", R"({"engine":"atwood","methods":[]})"),
                                   engine("t", R"({"engine":"truth","methods":[]})"),
                                   engine("next", R"({"protocol":2,"engine":"next","methods":[]})"),
                                   engine("other", R"({"engine":"other","methods":[{"id":"mine/a"}]})")});
  REQUIRE(found.size() == 8);
  CHECK(found[1].status == Status::ok);
  CHECK(found[3].status == Status::ok);
  const auto refused = [&](std::size_t i, const std::string& words) {
    CAPTURE(i, found[i].reason);
    CHECK(found[i].status == Status::crashed);
    CHECK_THAT(found[i].reason, Catch::Contains(words));
  };
  refused(2, "its name is `mine`, which is already the name of " + good);
  refused(4, "its name is `atwood`, which is already the name of");
  refused(5, "its name is `truth`, which is already the name of the truth");
  refused(6, "protocol 2; this program speaks protocol 1");
  refused(7, "method `mine/a` of engine `other`; expected an id that begins with `other/`");
}

TEST_CASE("a scene that no line can hold is refused in words") {
  Asked ask;
  const std::string huge = "{\"x\":\"" + std::string(wire::kLongestLine, 'x') + "\"}";
  const Recording recording = ask.client.run("faulty/well", huge, 1, {scenario.t_end_s, 16, 8}, 0, 20);
  CHECK(recording.outcome.status == Status::unsupported);
  CHECK(recording.outcome.reason ==
        "the scene takes 64.0001 MiB as a line of the worker protocol, which allows 64 MiB");
  CHECK(ask("well").outcome.status == Status::ok);
}

TEST_CASE("a number that is not finite is an answer, not garbage") {
  Asked ask;
  const Recording recording = ask("nan_late");
  CHECK(recording.outcome.status == Status::ok);
  REQUIRE(recording.values.size() == 9);
  CHECK(std::isnan(static_cast<double>(recording.values.back().bodies[0].p_m[0])));
  const Recording at_once = ask("nan_at_once");
  CHECK(at_once.outcome.status == Status::ok);
  REQUIRE_FALSE(at_once.values.empty());
  CHECK(std::isnan(static_cast<double>(at_once.values.front().bodies[0].q_wxyz[0])));
}

TEST_CASE("the timed pass gives one time a repeat and no samples") {
  Asked ask;
  const Recording recording = ask("well", 20, 3);
  CHECK(recording.values.empty());
  CHECK(recording.outcome.busy_ns == std::vector<std::int64_t>{16000, 16000, 16000});
}

TEST_CASE("a worker that answers hello is available, one that does not gives a reason") {
  Folder folder;
  std::ofstream(folder / "not_executable.py") << "#!/usr/bin/env python3\n";
  const auto found = find_workers({workers + "/sound.py", workers + "/exits_at_hello.py",
                                   workers + "/garbage_at_hello.py", folder / "missing", folder / "not_executable.py"});
  REQUIRE(found.size() == 5);
  CHECK(found[0].status == Status::ok);
  CHECK(found[0].engine.name == "sound");
  CHECK(found[0].engine.methods.size() == 2);
  CHECK(found[0].build_id.size() == 32);
  CHECK(found[1].status == Status::crashed);
  CHECK(found[1].reason == "answering `hello`: exited with code 1: no licence file");
  CHECK(found[2].status == Status::crashed);
  CHECK_THAT(found[2].reason,
             Catch::StartsWith("answering `hello`: invalid answer: not a JSON object: hello to you too"));
  CHECK(found[3].status == Status::not_built);
  CHECK_THAT(found[3].reason, Catch::Contains("No such file"));
  CHECK(found[4].status == Status::not_built);
  CHECK_THAT(found[4].reason, Catch::Contains("Permission denied"));
}

TEST_CASE("one request in a process of its own") {
  const auto found = find_workers({workers + "/sound.py"});
  const Recording run = run_once(found[0], "sound/straight", scenario.scene, {2, 16, 8}, 20);
  CHECK(run.outcome.status == Status::ok);
  REQUIRE(run.values.size() == 9);
  CHECK(run.values.back().bodies[0].p_m[1] == static_cast<Wide>(0.2 - 2));
  const Truth truth = truth_once(workers + "/exact_truth.py", scenario, 8, 20);
  CHECK(truth.outcome.status == Status::ok);
  CHECK(truth.source == "closed form: straight flight");
  CHECK(truth.values.size() == 9);
  CHECK(truth.bars.size() == 9);
}
