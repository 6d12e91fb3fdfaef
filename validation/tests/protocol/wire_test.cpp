// Lines out and in again: nothing is lost, and what is not the protocol is called so.
#include <catch2/catch.hpp>

#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include "protocol/wire.hpp"

using namespace atwood;

namespace {

const Wide third = static_cast<Wide>(1) / 3;

Sample wide_sample() {
  Sample sample;
  sample.t_s = 0.1;
  sample.bodies.resize(2);
  sample.bodies[0].p_m = {0.1, third, static_cast<Wide>(0.1L)};
  sample.bodies[0].v_m_per_s = {std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity(),
                                -0.0};
  sample.bodies[1].q_wxyz = {0.5, 0.5, -0.5, 0.5};
  sample.bodies[1].w_rad_per_s = {1e-320, 1e300, 3};
  return sample;
}

void check_equal(const Sample& a, const Sample& b) {
  CHECK(a.t_s == b.t_s);
  REQUIRE(a.bodies.size() == b.bodies.size());
  for (std::size_t i = 0; i < a.bodies.size(); ++i) {
    CHECK(a.bodies[i].p_m == b.bodies[i].p_m);
    CHECK(a.bodies[i].q_wxyz == b.bodies[i].q_wxyz);
    CHECK(a.bodies[i].v_m_per_s == b.bodies[i].v_m_per_s);
    CHECK(a.bodies[i].w_rad_per_s == b.bodies[i].w_rad_per_s);
  }
}

}  // namespace

TEST_CASE("a sample crosses the pipe to the last bit, events with it") {
  Event event;
  event.t_s = third;
  event.kind = EventKind::rest;
  event.body_b = 1;
  event.normal = {0, 0, -1};
  event.impulse_n_N_s = third * 2;
  const wire::Answer answer = wire::read_answer(wire::sample_line(7, wide_sample(), {event}));
  CHECK(answer.cell == 7);
  CHECK_FALSE(answer.done);
  check_equal(answer.sample, wide_sample());
  REQUIRE(answer.events.size() == 1);
  CHECK(answer.events[0].t_s == third);
  CHECK(answer.events[0].kind == EventKind::rest);
  CHECK(answer.events[0].impulse_n_N_s == third * 2);
  CHECK(answer.events[0].normal == event.normal);
}

TEST_CASE("contacts cross with their sample, and a sample without any says nothing of them") {
  Sample sample = wide_sample();
  CHECK(wire::sample_line(7, sample, {}).find("contacts") == std::string::npos);
  sample.contacts = {{0, 1, {0.1, 2, 3}, {0, 0, 1}, -1e-9, 9.8, {0.5, -0.25, 0}}, {1, 2, {}, {1, 0, 0}, 0, 3, {}}};
  CHECK(wire::read_answer(wire::sample_line(7, sample, {})).sample.contacts == sample.contacts);
  CHECK_THROWS_AS(wire::read_answer(R"({"cell":7,"t_s":0,"bodies":[],"contacts":[[0,1,2]]})"), wire::Garbage);
}

TEST_CASE("doubles are numbers, wider and non-finite values strings") {
  Sample sample;
  sample.bodies.resize(1);
  sample.bodies[0].p_m = {0.1, third, std::nan("")};
  const std::string line = wire::sample_line(0, sample, {});
  CHECK(line.find("[[0.1,\"") != std::string::npos);
  CHECK(line.find("\"nan\"") != std::string::npos);
  CHECK(std::isnan(static_cast<double>(wire::read_answer(line).sample.bodies[0].p_m[2])));
}

TEST_CASE("a truth crosses with its bars, source and condition") {
  Truth truth;
  truth.source = "closed form: \"quoted\"";
  truth.note = "note";
  truth.condition = std::numeric_limits<double>::infinity();
  truth.events.resize(2);
  truth.event_bar_s = {1e-20, 2e-20};
  const wire::Answer sample = wire::read_answer(wire::truth_line(3, wide_sample(), wide_sample()));
  CHECK(sample.has_bar);
  check_equal({wide_sample().t_s, sample.bar.bodies}, wide_sample());
  const wire::Answer done = wire::read_answer(wire::truth_done_line(3, truth));
  CHECK(done.done);
  CHECK(done.source == truth.source);
  CHECK(done.note == "note");
  CHECK(std::isinf(done.condition));
  CHECK(done.event_bar_s == truth.event_bar_s);
}

TEST_CASE("an outcome crosses whole, whatever bytes its reason has") {
  Outcome outcome;
  outcome.status = Status::diverged;
  outcome.reason = "line\nbreak \"quote\" \xff not UTF-8";
  outcome.steps_taken = 12;
  outcome.rate_evaluations = 48;
  outcome.busy_ns = {5, 6, 7};
  const std::string line = wire::done_line(1, outcome, {});
  CHECK(line.find('\n') == std::string::npos);
  const Outcome back = wire::read_answer(line).outcome;
  CHECK(back.status == Status::diverged);
  CHECK(back.reason.rfind("line\nbreak \"quote\"", 0) == 0);
  CHECK(back.steps_taken == 12);
  CHECK(back.rate_evaluations == 48);
  CHECK(back.busy_ns == outcome.busy_ns);
}

TEST_CASE("how solvers ended crosses with the outcome, and an outcome without any says nothing of it") {
  Outcome outcome;
  outcome.solvers["implicit-stages"] = {7, 2, 1, 80, 0.1};
  outcome.solvers["contact-sweeps"] = {0, 0, 3, 2, std::numeric_limits<double>::infinity()};
  CHECK(wire::read_answer(wire::done_line(1, outcome, {})).outcome.solvers == outcome.solvers);
  CHECK(wire::done_line(1, {}, {}).find("solvers") == std::string::npos);
  CHECK(wire::read_answer(R"({"cell":1,"done":{"status":"ok"}})").outcome.solvers.empty());
  const auto told = wire::read_answer(R"({"cell":1,"done":{"status":"ok","solvers":{"pgs":{"capped":4}}}})");
  CHECK(told.outcome.solvers.at("pgs").capped == 4);
  CHECK(told.outcome.solvers.at("pgs").converged == 0);
}

TEST_CASE("a profile crosses with the end of its run; others say nothing of it") {
  Profile profile;
  profile.step_ns = {1000, 2000, 1500};
  profile.phase_ns = {{"broad", 700}, {"solve", 3000}};
  const wire::Answer back = wire::read_answer(wire::done_line(1, {}, {}, profile));
  CHECK(back.done);
  CHECK(back.profile.step_ns == profile.step_ns);
  CHECK(back.profile.phase_ns == profile.phase_ns);
  CHECK(wire::done_line(1, {}, {}).find("_ns\":") == std::string::npos);
  CHECK_THROWS_AS(wire::read_answer(R"({"cell":1,"done":{"status":"ok","phase_ns":[1]}})"), wire::Garbage);

  wire::Request request;
  request.kind = wire::Request::Kind::run;
  request.plan = {1, 4, 2};
  request.json = "{}";
  std::int64_t cell = -1;
  CHECK_FALSE(wire::read_request(wire::to_line(request), cell).profile);
  request.profile = true;
  const wire::Request asked = wire::read_request(wire::to_line(request), cell);
  CHECK(asked.profile);
  CHECK(asked.repeats == 0);
}

TEST_CASE("hello carries every setting with its type") {
  Engine engine;
  engine.name = "demo";
  engine.version = "1.2";
  engine.scalar = "float";
  engine.methods.push_back({"demo/a",
                            "doc",
                            "source",
                            {{"rotation", 4.0}},
                            true,
                            {{"flag", true}, {"n", std::int64_t{3}}, {"x", 1.0}, {"name", std::string("v")}}});
  engine.responses.push_back(
      {"+bounce", "what contacts do", "who says so", {}, false, {{"restitution", std::string("newton")}}});
  const Engine back = wire::read_hello(wire::hello_line(engine));
  CHECK(back.name == "demo");
  REQUIRE(back.responses.size() == 1);
  CHECK(back.responses[0].id == "+bounce");
  CHECK(back.responses[0].doc == "what contacts do");
  CHECK(back.responses[0].source == "who says so");
  CHECK(back.responses[0].settings == engine.responses[0].settings);
  CHECK(back.version == "1.2");
  CHECK(back.scalar == "float");
  REQUIRE(back.methods.size() == 1);
  CHECK(back.methods[0].adaptive);
  CHECK(back.methods[0].source == "source");
  CHECK(back.methods[0].claimed_order == engine.methods[0].claimed_order);
  CHECK(back.methods[0].settings == engine.methods[0].settings);
}

TEST_CASE("hello carries range and meaning of each setting; a rule of another form is refused") {
  Engine engine;
  engine.name = "demo";
  engine.methods.push_back({"demo/a", "doc", "source", {}, false, {}});
  declare_settings(engine.methods[0], {{"n", std::int64_t(1), {between(0, 9), "A count."}},
                                       {"x", 0.5, {strictly_between(0, 1), "A share.", "m"}},
                                       {"law", std::string("a"), {one_of({"a", "b"}), "A law."}}});
  const MethodInfo back = wire::read_hello(wire::hello_line(engine)).methods.at(0);
  REQUIRE(back.rules.size() == 3);
  for (const auto& [name, rule] : engine.methods[0].rules) {
    const SettingRule& read = back.rules.at(name);
    CHECK(read.doc == rule.doc);
    CHECK(read.unit == rule.unit);
    CHECK(read.range.choices == rule.range.choices);
    CHECK(read.range.least == rule.range.least);
    CHECK(read.range.most == rule.range.most);
    CHECK(read.range.least_excluded == rule.range.least_excluded);
    CHECK(read.range.most_excluded == rule.range.most_excluded);
  }
  const auto hello = [](const std::string& rules) {
    return R"({"engine":"demo","version":"1","scalar":"double","methods":[{"id":"demo/a","setting_rules":)" + rules +
           "}]}";
  };
  for (const char* wrong : {"1", R"({"n":1})", R"({"n":{"least":"0"}})", R"({"n":{"choices":"a"}})"})
    CHECK_THROWS_AS(wire::read_hello(hello(wrong)), wire::Garbage);
}

TEST_CASE("recorded frames cross the pipe; a step is its share of its frame, never a sum") {
  wire::Request request;
  request.kind = wire::Request::Kind::run;
  request.cell = 3;
  request.method = "demo/a";
  request.json = "{}";
  request.plan = {1.0, 4, 1, {0.3, 1.0}};
  std::int64_t cell = -1;
  const Plan plan = wire::read_request(wire::to_line(request), cell).plan;
  REQUIRE(plan.frame_ends_s == std::vector<double>{0.3, 1.0});
  CHECK(step_begin_s<double>(plan, 0) == 0.0);
  CHECK(step_begin_s<double>(plan, 1) == 0.3 / 2);
  CHECK(step_begin_s<double>(plan, 2) == 0.3);
  CHECK(step_begin_s<double>(plan, 3) == 0.3 + (1.0 - 0.3) / 2);
  CHECK(step_begin_s<double>(plan, 4) == 1.0);
  CHECK(step_begin_s<double>(Plan{1.0, 4, 1}, 3) == 0.75);
  const std::string head =
      R"({"request":"run","cell":3,"method":"d","t_end_s":1,"samples":1,"scene":{},"steps":4,"frame_ends_s":)";
  for (const char* bad : {"[]}", "[0.5]}", "[0.5,0.5,1]}", "[-1,1]}", "[0.1,0.2,1]}", "[\"nan\",1]}"})
    CHECK_THROWS_AS(wire::read_request(head + bad, cell), wire::Garbage);
  Engine engine;
  engine.frames = true;
  CHECK(wire::read_hello(wire::hello_line(engine)).frames);
  CHECK_FALSE(wire::read_hello(R"({"engine":"x","methods":[]})").frames);
}

TEST_CASE("requests read back, and bad ones are refused with their cell") {
  wire::Request request;
  request.kind = wire::Request::Kind::run;
  request.cell = 9;
  request.method = "atwood/rk4";
  request.plan = {0.1, 64, 16};
  request.repeats = 3;
  request.json = "{\"bodies\":[]}";
  std::int64_t cell = -1;
  const wire::Request back = wire::read_request(wire::to_line(request), cell);
  CHECK(cell == 9);
  CHECK(back.method == request.method);
  CHECK(back.plan.t_end_s == 0.1);
  CHECK(back.plan.steps == 64);
  CHECK(back.repeats == 3);
  CHECK(back.json == request.json);
  for (const char* line :
       {"", "{", "[]", "7", "{}", R"({"request":"dance","cell":5})", R"({"request":"run","cell":5})",
        R"({"request":"run","cell":5,"method":"a/b","t_end_s":1,"steps":10,"samples":3,"scene":{}})",
        R"({"request":"run","cell":5,"method":"a/b","t_end_s":-1,"steps":10,"samples":5,"scene":{}})",
        R"({"request":"run","cell":5,"method":"a/b","t_end_s":"nan","steps":10,"samples":5,"scene":{}})",
        R"({"request":"run","cell":5,"method":"a/b","t_end_s":1,"steps":0,"samples":5,"scene":{}})",
        R"({"protocol":2,"request":"hello"})"}) {
    CAPTURE(line);
    CHECK_THROWS_AS(wire::read_request(line, cell), wire::Garbage);
  }
}

TEST_CASE("answers that violate the protocol are refused, without a crash") {
  for (const char* line :
       {"", "hello", "{\"cell\":1", "null", R"({"cell":"x"})", R"({"cell":1})", R"({"cell":1,"t_s":0})",
        R"({"cell":1,"t_s":0,"bodies":[[1,2,3]]})", R"({"cell":1,"t_s":0,"bodies":[[0,0,0,1,0,0,0,0,0,0,0,0,null]]})",
        R"({"cell":1,"t_s":0,"bodies":[[0,0,0,1,0,0,0,0,0,0,0,0,"x"]]})", R"({"cell":1,"done":{"status":"fine"}})",
        R"({"cell":1,"done":7})", R"({"cell":1,"done":{"status":"ok","busy_ns":"x"}})",
        R"({"cell":1.5,"done":{"status":"ok"}})", R"({"cell":1,"t_s":0,"bodies":[],"events":[7]})",
        R"({"cell":1,"t_s":0,"bodies":[],"events":[{"t_s":0,"kind":"boom","body_a":0,"body_b":1}]})"}) {
    CAPTURE(line);
    CHECK_THROWS_AS(wire::read_answer(line), wire::Garbage);
  }
  for (const char* line :
       {"{}", R"({"engine":"x"})", R"({"engine":"x","methods":[1]})", R"({"engine":1,"methods":[]})"}) {
    CAPTURE(line);
    CHECK_THROWS_AS(wire::read_hello(line), wire::Garbage);
  }
}

// ---- hostile lines ------------------------------------------------------------------------------------------------
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
  for (const Sample* bars : {static_cast<const Sample*>(nullptr), static_cast<const Sample*>(&bar)}) {
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
