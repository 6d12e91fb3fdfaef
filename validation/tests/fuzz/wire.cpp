// The worker protocol, both sides of it.
#include <optional>
#include <stdexcept>

#include "protocol/fluid_field.hpp"
#include "protocol/wire.hpp"
#include "scene/files.hpp"
#include "validation/study/check_answer.hpp"
#include "validation/tests/fuzz/target.hpp"

namespace atwood::fuzz {
namespace {

// Calls `read` with each line, without its end.
template <class Read> void each_line(std::string_view bytes, Read read) {
  while (!bytes.empty()) {
    const std::size_t end = std::min(bytes.find('\n'), bytes.size());
    read(bytes.substr(0, end));
    bytes.remove_prefix(std::min(end + 1, bytes.size()));
  }
}

// What a worker reads of a request before its engine takes over.
void read_request_parts(const wire::Request& request) {
  using Kind = wire::Request::Kind;
  if (request.kind == Kind::field) {
    const auto field = read_or_refuse<wire::Garbage>([&] { return wire::read_field_request(request.json); });
    if (!field) return;
    const std::string line = wire::to_line(*field);
    require(wire::to_line(wire::read_field_request(line)) == line, "a request for a field reads back the same");
    read_or_refuse<InputError>([&] { return scenario_from_json(field->scenario); });
    return;
  }
  if (request.kind == Kind::run) {
    read_or_refuse<std::invalid_argument>([&] { return parse_method_id(request.method); });
    for (std::int64_t n : {std::int64_t{0}, request.plan.steps / 2, request.plan.steps})
      step_begin_s<double>(request.plan, n);
  }
  if (request.kind == Kind::run || request.kind == Kind::contacts)
    read_or_refuse<InputError>([&] { return scene_from_json(request.json); });
  if (request.kind == Kind::truth) read_or_refuse<InputError>([&] { return scenario_from_json(request.json); });
}

const Scene& asked_scene() {
  static const Scene scene =
      read_scenario_text(
          "id = \"t\"\n[run]\nt_end_s = 1\nsteps = [4]\nsamples = 2\n[[body]]\nname = \"a\"\nmass_kg = 1\n"
          "inertia_kg_m2 = [1, 2, 2.5]\n[[body]]\nname = \"b\"\nmass_kg = 1\ninertia_kg_m2 = [1, 1, 1]\n"
          "[[joint]]\nname = \"j\"\nkind = \"hinge\"\nbodies = [\"world\", \"a\"]\naxis_body = [0, 0, 1]\n",
          "scene.toml", folder())
          .scene;
  return scene;
}

// Neither a part of a sample nor an answer to another question.
bool is_whole_sample(const wire::Answer& answer) {
  const bool part = answer.more || answer.from > 0 || answer.from_particle > 0;
  const bool other = !answer.contacts.empty() || !answer.touches.empty() || !answer.poses.empty();
  return !answer.done && !answer.events_alone && !part && !other && !answer.sample.bodies.empty();
}

std::string written(const wire::Answer& answer) {
  std::string lines;
  const SampleView bar = answer.bar;
  wire::sample_lines(answer.cell, answer.sample, answer.has_bar ? &bar : nullptr, answer.events,
                     [&](const std::string& line) { lines += line; });
  return lines;
}

}  // namespace

void read_request_line(std::string_view bytes) {
  each_line(bytes, [](std::string_view line) {
    std::int64_t cell = -1;
    const auto request = read_or_refuse<wire::Garbage>([&] { return wire::read_request(line, cell); });
    if (!request) {
      wire::error_line(cell, "refused");
      return;
    }
    read_request_parts(*request);
    if (request->kind == wire::Request::Kind::field) return;
    const std::string again = wire::to_line(*request);
    require(wire::to_line(wire::read_request(again, cell)) == again, "a request reads back the same");
  });
}

void read_hello_line(std::string_view bytes) {
  const auto engine = read_or_refuse<wire::Garbage>([&] { return wire::read_hello(bytes); });
  if (!engine) return;
  const std::string line = wire::hello_line(*engine);
  require(wire::hello_line(wire::read_hello(line)) == line, "hello reads back the same");
}

// Each line as the answer to a run of a scene of two bodies: read, then checked as the client does.
void read_answer_lines(std::string_view bytes) {
  static const SampledBodies bodies(asked_scene());
  SampleSeries values;
  each_line(bytes, [&](std::string_view line) {
    const auto answer = read_or_refuse<wire::Garbage>([&] { return wire::read_answer(line); });
    if (!answer) return;
    if (is_whole_sample(*answer)) {
      const std::string again = written(*answer);
      require(written(wire::read_answer(again)) == again, "a sample reads back the same");
    }
    try {
      if (answer->done) check_busy(answer->outcome.busy_ns, 1, 4, 1000000, true);
      if (answer->done || answer->events_alone) return;
      check_layout(answer->sample, values.size(), 1, 2, bodies);
      check_joints(*answer, bodies);
      check_states(answer->sample, values.size(), 1, bodies, true);
      values.push_back(answer->sample);
    } catch (const wire::Garbage&) {}
  });
  blow_up(values, 1, bodies);
}

void read_field_lines(std::string_view bytes) {
  each_line(bytes, [](std::string_view line) {
    const auto answer = read_or_refuse<wire::Garbage>([&] { return wire::read_field_answer(line); });
    if (answer && answer->done) wire::field_done_line(answer->cell, answer->ended);
  });
}

void read_method_id(std::string_view bytes) {
  const auto id = read_or_refuse<std::invalid_argument>([&] { return parse_method_id(std::string(bytes)); });
  if (!id) return;
  const std::string text = to_string(*id);
  const MethodId again = parse_method_id(text);
  require(to_string(again) == text && again.overrides.size() == id->overrides.size(),
          "a method's id reads back the same");
}

}  // namespace atwood::fuzz
