// Hostile lines of the worker protocol: deep nesting, long lines, impossible numbers, random mutations.
#include <catch2/catch.hpp>

#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include "protocol/printed_setting.hpp"
#include "protocol/wire.hpp"
#include "wide_sample.hpp"

using namespace atwood;

namespace {

std::string refusal(const std::function<void()>& read) {
  try {
    read();
  } catch (const wire::Garbage& error) {
    return error.what();
  }
  return "";
}

std::string nested(int depth) {
  return std::string(static_cast<std::size_t>(depth), '[') + std::string(static_cast<std::size_t>(depth), ']');
}

}  // namespace

TEST_CASE("a line that nests deeply is refused in few words, by both sides") {
  std::int64_t cell = -1;
  for (const int depth : {100, 100000}) {
    const std::string deep = nested(depth);
    const std::string words[] = {
        refusal([&] { wire::read_answer(R"({"cell":1,"t_s":0,"bodies":)" + deep + "}"); }),
        refusal([&] { wire::read_answer(R"({"cell":1,"unknown":)" + deep + "}"); }),
        refusal([&] { wire::read_hello(R"({"engine":"x","methods":[{"id":"x/a","settings":{"s":)" + deep + "}}]}"); }),
        refusal([&] { wire::read_request(R"({"request":"run","cell":1,"scene":)" + deep + "}", cell); })};
    for (const std::string& text : words) {
      CHECK_THAT(text, Catch::StartsWith("nested deeper than 64 levels"));
      CHECK(text.size() < 200);
    }
  }
  CHECK(wire::read_answer(R"({"cell":1,"t_s":0,"bodies":[],"more_of_ours":)" + nested(60) + "}").cell == 1);
  CHECK(wire::read_answer(R"({"cell":1,"t_s":0,"bodies":[],"note":")" + std::string(1000, '[') + "\"}").cell == 1);
}

TEST_CASE("an object of more members than the protocol has is refused before it is built") {
  std::string many;  // looked through for each new one: minutes
  for (int i = 0; i < 400'000; ++i) many += ",\"k" + std::to_string(i) + "\":1";
  std::int64_t cell = -1;
  const auto request = [&](const std::string& line) { return refusal([&] { wire::read_request(line, cell); }); };
  CHECK_THAT(request(R"({"request":"hello")" + many + "}"), Catch::StartsWith("more than 4096 members in an object"));
  CHECK_THAT(request(R"({"request":"run","cell":1,"scene":{)" + many.substr(1) + "}}"),
             Catch::StartsWith("more than 4096 members in an object"));
  CHECK(request(R"({"request":"hello","a":"::::","b":[{"c":1},{"c":1}]})").empty());
  CHECK(!request("}]}]").empty());
}

TEST_CASE("messages about long lines are short") {
  const std::string x(1 << 20, 'x');
  std::int64_t cell = -1;
  for (const std::string& text :
       {refusal([&] { wire::read_answer("{\"cell\":1,\"t_s\":0,\"bodies\":[\"" + x + "\"]}"); }),
        refusal([&] { wire::read_answer("{\"cell\":\"" + x + "\"}"); }),
        refusal([&] { wire::read_answer("{\"" + x + "\":1}"); }),
        refusal([&] { wire::read_answer("{\"cell\":1,\"t_s\":\"" + x + "\"}"); }),
        refusal([&] { wire::read_answer("{\"cell\":1,\"done\":{\"status\":\"" + x + "\"}}"); }),
        refusal([&] { wire::read_hello("{\"engine\":\"" + x + "\",\"methods\":[]}"); }),
        refusal([&] { wire::read_request("{\"cell\":1,\"request\":\"" + x + "\"}", cell); })}) {
    CHECK(!text.empty());
    CHECK(text.size() < 300);
  }
}

TEST_CASE("a line of more than was asked for is not held") {
  std::string line = R"({"cell":1,"t_s":0,"bodies":[)";
  for (int i = 0; i < 20; ++i) line += "[0,0,0,1,0,0,0,0,0,0,0,0,0],";
  line.back() = ']';
  const wire::Limits most{.bodies = 5};
  CHECK(refusal([&] { wire::read_answer(line + "}", most); }) == "more than 5 bodies in a line");
  CHECK(wire::read_answer(line + "}").sample.bodies.size() == 20);
  CHECK(refusal([&] { wire::read_answer(R"({"cell":1,"t_s":0,"bodies":[],"t_s":1})"); }) ==
        "the member \"t_s\" twice in a line");
  CHECK_THAT(refusal([&] { wire::read_answer(R"({"cell":1,"t_s":0,"bodies":[[1,2,[]]]})"); }),
             Catch::Contains("not an array of 13: an array of 3"));
}

TEST_CASE("a long sample crosses in parts, its bars, contacts and events with it") {
  Sample sample, bar;
  sample.t_s = bar.t_s = 0.25;
  sample.bodies.resize(50);
  bar.bodies.resize(50);
  for (std::size_t i = 0; i < 50; ++i) sample.bodies[i].p_m = {third * static_cast<Wide>(i), 0.5, 1};
  for (int i = 0; i < 40; ++i) sample.contacts.push_back({i, i + 1, {0.1 * i, 0, 0}, {0, 0, 1}, -1e-9, 9.8, {}});
  Event event;
  event.body_b = 1;
  const SampleView some_bars = bar;
  for (const SampleView* bars : {static_cast<const SampleView*>(nullptr), &some_bars}) {
    std::vector<wire::Answer> parts;
    wire::sample_lines(
        7, sample, bars, {event},
        [&](const std::string& line) {
          CHECK(line.size() < 1500);
          parts.push_back(wire::read_answer(line));
        },
        1000);
    REQUIRE(parts.size() > 3);
    Sample back;
    std::size_t bar_rows = 0;
    for (std::size_t i = 0; i < parts.size(); ++i) {
      CHECK(parts[i].more == (i + 1 < parts.size()));
      CHECK(parts[i].from == back.bodies.size());
      CHECK(parts[i].events.size() == (i + 1 < parts.size() ? 0 : 1));
      CHECK(parts[i].sample.t_s == sample.t_s);
      back.bodies.insert(back.bodies.end(), parts[i].sample.bodies.begin(), parts[i].sample.bodies.end());
      back.contacts.insert(back.contacts.end(), parts[i].sample.contacts.begin(), parts[i].sample.contacts.end());
      bar_rows += parts[i].bar.bodies.size();
    }
    REQUIRE(back.bodies.size() == 50);
    for (std::size_t i = 0; i < 50; ++i) CHECK(back.bodies[i].p_m == sample.bodies[i].p_m);
    CHECK(back.contacts == sample.contacts);
    CHECK(bar_rows == (bars ? 50 : 0));
  }
}

TEST_CASE("many events go ahead of the line that they belong to") {
  std::vector<Event> events(25), read;
  std::vector<double> bar_s(25, 1e-9);
  for (std::size_t i = 0; i < 25; ++i) events[i].t_s = static_cast<Wide>(i), events[i].body_b = 1;
  const auto put = [&](const std::string& line) {
    const wire::Answer answer = wire::read_answer(line);
    CHECK(answer.events_alone);
    CHECK_FALSE(answer.done);
    CHECK(answer.event_bar_s.back() == 1e-9);
    read.insert(read.end(), answer.events.begin(), answer.events.end());
  };
  wire::event_lines(3, events, &bar_s, put, 10);
  CHECK(events.size() == 5);
  CHECK(bar_s.size() == 5);
  read.insert(read.end(), events.begin(), events.end());
  REQUIRE(read.size() == 25);
  for (std::size_t i = 0; i < 25; ++i) CHECK(read[i].t_s == static_cast<Wide>(i));
}

TEST_CASE("counts and times that cannot be are refused") {
  for (const auto& [done, word] : std::vector<std::pair<const char*, const char*>>{
           {R"("steps_taken":-1)", "\"steps_taken\" is negative: -1"},
           {R"("rate_evaluations":-7)", "\"rate_evaluations\" is negative: -7"},
           {R"("steps_taken":18446744073709551615)", "\"steps_taken\" is not an integer"},
           {R"("solvers":[1])", "\"solvers\" is not an object"},
           {R"("solvers":{"pgs":3})", "solver `pgs` is not an object: 3"},
           {R"("solvers":{"PGS":{}})", "a solver is named `PGS`; expected 1 to 64 lower-case letters"},
           {R"("solvers":{"pgs":{"capped":-1}})", "\"capped\" is negative: -1"},
           {R"("solvers":{"pgs":{"residual_max":-0.5}})", "\"residual_max\" of solver `pgs` is negative: -0.5"},
           {R"("busy_ns":[0.0123])", "is it in seconds or milliseconds?"},
           {R"("busy_ns":[5,-5])", "busy_ns has -5; the nanoseconds of a run are positive"},
           {R"("busy_ns":[5],"call_ns":0)", "\"call_ns\" is 0"},
           {R"("busy_ns":[5],"call_ns":-3)", "\"call_ns\" is -3"},
           {R"("step_ns":[-5])", "\"step_ns\" is negative"},
           {R"("phase_ns":{"broad":-5})", "\"phase_ns\" is negative"}}) {
    CAPTURE(done);
    const std::string line = std::string(R"({"cell":1,"done":{"status":"ok",)") + done + "}}";
    CHECK_THAT(refusal([&] { wire::read_answer(line); }), Catch::Contains(word));
  }
  CHECK_THAT(
      refusal([&] {
        wire::read_answer(R"({"cell":1,"t_s":0,"bodies":[],"events":[{"t_s":0,"body_a":0,"body_b":4294967296}]})");
      }),
      Catch::Contains("out of range"));
}

TEST_CASE("hello is taken from engines that speak the protocol under a usable name") {
  for (const auto& [line, word] : std::vector<std::pair<std::string, const char*>>{
           {R"({"protocol":2,"engine":"x","methods":[]})", "protocol 2; this program speaks protocol 1"},
           {R"({"engine":"","methods":[{"id":"/a"}]})", "an engine without a name"},
           {R"({"engine":"a/b","methods":[]})", "the name of the engine is `a/b`"},
           {R"({"engine":"x","methods":[{"id":"y/a"}]})", "expected an id that begins with `x/`"},
           {R"({"engine":"x","methods":[{"id":"x"}]})", "expected an id that begins with `x/`"},
           {R"({"engine":"x","methods":[{"id":"x/"}]})", "expected an id that begins with `x/`"},
           {R"({"engine":"x","methods":[{"id":"x/a"},{"id":"x/a"}]})", "listed twice"},
           {R"({"engine":"x","methods":[],"fingerprint":7})", "\"fingerprint\" is not a string"},
           {R"({"engine":"x","methods":[],"fingerprint":")" + std::string(2000, 'f') + "\"}",
            "fingerprint of more than"},
           {R"({"engine":"x","methods":[],"files":"a"})", "\"files\" is not an array"},
           {R"({"engine":"x","methods":[],"files":[""]})", "\"files\" of 0 bytes"}}) {
    CAPTURE(line);
    CHECK_THAT(refusal([&] { wire::read_hello(line); }), Catch::Contains(word));
  }
  Engine engine;
  engine.name = "x";
  engine.fingerprint = "commit 7";
  engine.files = {"/lib/a.so", "b.py"};
  const std::string line = wire::hello_line(engine);
  CHECK_THAT(line, Catch::Contains("\"protocol\":1"));
  const Engine back = wire::read_hello(line);
  CHECK(back.fingerprint == engine.fingerprint);
  CHECK(back.files == engine.files);
  CHECK(wire::read_hello(R"({"engine":"x","methods":[]})").fingerprint.empty());
}

// Bytes flipped, cut out, doubled and put in from a list of what JSON is made of.
TEST_CASE("mutated lines are read or refused, and nothing else happens") {
  Event event;
  event.body_b = 1;
  Engine engine;
  engine.name = "demo";
  engine.fingerprint = "f";
  engine.files = {"a"};
  engine.methods.push_back({"demo/a", "doc", "source", {{"rotation", 4.0}}, true, {{"flag", true}, {"x", 1.0}}});
  declare_settings(engine.methods[0], {{"x", 1.0, {between(0, 2), "A share."}}, printed("flag", true)});
  Sample sample = wide_sample();
  sample.contacts = {{0, 1, {0.1, 2, 3}, {0, 0, 1}, -1e-9, 9.8, {0.5, -0.25, 0}}};
  wire::Request request;
  request.kind = wire::Request::Kind::run;
  request.method = "demo/a";
  request.plan = {1, 4, 2, {0.5, 1}};
  request.json = R"({"bodies":[]})";
  Outcome outcome;
  outcome.busy_ns = {5, 6};
  Profile profile;
  profile.step_ns = {7}, profile.phase_ns = {{"broad", 1}};
  const std::vector<std::string> lines{wire::hello_line(engine),
                                       wire::to_line(request),
                                       wire::sample_line(7, sample, {event}),
                                       wire::truth_line(7, wide_sample(), wide_sample()),
                                       wire::done_line(7, outcome, {event}, profile),
                                       R"({"cell":7,"t_s":0.5,"from":1,"bodies":[],"more":true})",
                                       R"({"cell":7,"poses":[[1,0,0,0,0,1,0,0,0,1,0,0]]})",
                                       R"({"cell":7,"touches":[[0,1,0.5,0,0,0,0,0,1]]})"};
  const std::string pieces[] = {"[",       "]",        "{",           "}",    "\"",      ",",    ":",
                                "-",       "1e999",    "null",        "true", "\\u0000", "\xff", "18446744073709551616",
                                "\"nan\"", "[[[[[[[[", "\"cell\":7,", "\\"};
  std::mt19937 random(20240511);
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random() % n); };
  int read = 0, refused = 0;
  for (int i = 0; i < 6000; ++i) {
    std::string line = lines[below(lines.size())];
    for (std::size_t m = 1 + below(4); m > 0; --m) {
      const std::size_t at = below(line.size() + 1);
      switch (below(4)) {
        case 0:
          if (at < line.size()) line[at] = static_cast<char>(below(256));
          break;
        case 1: line.erase(at, below(20)); break;
        case 2: line.insert(at, pieces[below(std::size(pieces))]); break;
        default: line.insert(at, line.substr(below(line.size() + 1), below(40))); break;
      }
    }
    std::int64_t cell = -1;
    const std::function<void()> readers[] = {[&] { wire::read_hello(line); }, [&] { wire::read_answer(line); },
                                             [&] { wire::read_request(line, cell); }};
    for (const auto& reader : readers) {
      try {
        reader();
        ++read;
      } catch (const wire::Garbage& error) {
        ++refused;
        if (std::string(error.what()).size() > 400) FAIL("a long message: " << error.what());
      } catch (const std::exception& error) {
        FAIL("not called garbage: " << error.what() << " of " << line);
      }
    }
  }
  CHECK(read > 100);
  CHECK(refused > 10000);
}
