// Lines of the worker protocol: what is written reads back without loss, and other lines are refused.
#include <catch2/catch.hpp>

#include <cmath>
#include <limits>

#include "protocol/printed_setting.hpp"
#include "protocol/wire.hpp"
#include "wide_sample.hpp"

using namespace atwood;

namespace {

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

TEST_CASE("the time of a call into WebAssembly travels beside the repeats") {
  const auto read = [](const std::string& done) {
    return wire::read_answer(R"({"cell":1,"done":{"status":"ok",)" + done + "}}").outcome;
  };
  const Outcome wasm = read(R"("busy_ns":[5,6],"call_ns":70)"), native = read(R"("busy_ns":[5,6])");
  CHECK(wasm.busy_ns == std::vector<std::int64_t>{5, 6});
  CHECK(wasm.call_ns == 70);
  CHECK(native.busy_ns == wasm.busy_ns);
  CHECK(native.call_ns == 0);
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
                                       {"law", std::string("a"), {one_of({"a", "b"}), "A law."}},
                                       {"speed", std::numeric_limits<double>::infinity(), {at_least(0), "A bound."}},
                                       printed("sleeping", false),
                                       printed("step", std::string("whole, one")),
                                       printed("damping", 0.0)});
  const MethodInfo back = wire::read_hello(wire::hello_line(engine)).methods.at(0);
  REQUIRE(back.rules.size() == 7);
  CHECK(back.settings == engine.methods[0].settings);  // JSON has no infinity: it crosses as a text
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
           R"(,"settings":{"n":1,"x":0.5,"law":"a","flag":true}}]})";
  };
  CHECK(wire::read_hello(hello(R"({"n":{"least":1,"most":1}})")).methods.at(0).rules.size() == 1);
  CHECK(wire::read_hello(hello(R"({"n":{"choices":[1,3]}})")).methods.at(0).rules.at("n").range.choices ==
        std::vector<std::string>{"1", "3"});
  const std::pair<const char*, const char*> faults[] = {
      {"1", "not an object"},
      {R"({"n":1})", "expected an object"},
      {R"({"m":{"least":0}})", "no such setting"},
      {R"({"n":{"least":"0"}})", "expected a number"},
      {R"({"n":{"minimum":0}})", "unknown key \"minimum\""},
      {R"({"n":{"least":2,"most":0}})", "no number lies in it"},
      {R"({"x":{"least":0.5,"most":0.5,"most_excluded":true}})", "no number lies in it"},
      {R"({"n":{"least":2}})", "`n` is `1`; expected a whole number of at least 2"},
      {R"({"x":{"least":0.5,"least_excluded":true}})", "the default is outside the range"},
      {R"({"x":{"least":0,"least_excluded":1}})", "expected true or false"},
      {R"({"x":{"least_excluded":true}})", "excluded and not given"},
      {R"({"n":{"choices":"a"}})", "expected a list of values"},
      {R"({"law":{"choices":[]}})", "expected a list of values"},
      {R"({"n":{"choices":["a"]}})", "found the choice \"a\"; expected a whole number"},
      {R"({"n":{"choices":[2,4]}})", "`n` is `1`; expected 2 or 4"},
      {R"({"x":{"choices":[0.5]}})", "found the choice 0.5"},
      {R"({"law":{"choices":[1]}})", "found the choice 1"},
      {R"({"law":{"choices":[true]}})", "found the choice true; expected a word"},
      {R"({"flag":{"choices":["a"]}})", "expected true or false"},
      {R"({"law":{"choices":["b","c"]}})", "`law` is `a`; expected b or c"},
      {R"({"law":{"least":0}})", "found bounds of a word"},
      {R"({"flag":{"most":1}})", "found bounds of true or false"}};
  for (const auto& [rules, told] : faults) {
    INFO(rules);
    CHECK_THROWS_WITH(wire::read_hello(hello(rules)), Catch::Contains(told) && Catch::Contains("demo/a"));
    CHECK_THROWS_AS(wire::read_hello(hello(rules)), wire::Garbage);
  }
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
