// The protocol's contract: one line of every kind, with every member that it may have. Their hash belongs to a version.
#include <catch2/catch.hpp>

#include <cstdint>

#include "protocol/fluid_field.hpp"
#include "protocol/wire.hpp"
#include "scene/files.hpp"
#include "wide_sample.hpp"

using namespace atwood;

namespace {

constexpr std::uint64_t fnv_1a(std::string_view text) {
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  return hash;
}

// Every kind of shape, force, joint, contact law and fluid once.
Scene every_kind() {
  Scene scene;
  scene.materials = {{"wood", 0.5, 0.25, 0.125}, {"felt", 0, 0, 0}};
  scene.pairs = {{0, 0, 0.5, 0.25, 0.125, ContactLaw::rigid, 0, 0, false, 0, 0},
                 {0, 1, 0, 0, 0, ContactLaw::linear, 100, 2, true, 0, 0},
                 {1, 1, 0, 0, 0, ContactLaw::hertz, 0, 0, false, 1e6, 0.5}};
  const Shape shapes[] = {std::monostate{},
                          Sphere{1},
                          Plane{{0, 0, 1}, -1},
                          Rectangle{{1, 2}},
                          Box{{1, 2, 3}},
                          Capsule{1, 2},
                          Cylinder{1, 2},
                          Convex{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}},
                          Mesh{"t.obj", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}},
                          Compound{{{{1, 1, 1}, {0, 0, 1}, {1, 0, 0, 0}}}}};
  for (const Shape& shape : shapes) {
    Body& body = scene.bodies.emplace_back();
    body.name = "body." + std::to_string(shape.index());
    body.mass_kg = 2;
    body.inertia_kg_m2 = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    body.shape = shape;
  }
  scene.forces = {MutualGravity{{0, 1}},
                  Attractor{{0}, {1, 0, 0}, 2},
                  LinearDrag{{0}, 1, {}, 2},
                  QuadraticDrag{{0}, 1, 2, 3, {}, 4},
                  Spring{{0}, {}, 1, 2, 3, {{}}},
                  Drive{{0}, {1, 0, 0}, 2, 3},
                  Lorentz{{0}, {1, 0, 0}, {0, 0, 1}},
                  Coulomb{{0, 1}, 1},
                  Thruster{0, {}, {1, 0, 0}, 1, {{0, 2}}},
                  PointForce{0, {}, {1, 0, 0}, {{0, 2}}},
                  RotatingFrame{{0, 0, 1}},
                  Potential{{0}, "henon-heiles", {{"lambda", 1}}}};
  for (const JointKind kind : {JointKind::fixed, JointKind::hinge, JointKind::slider, JointKind::cylindrical,
                               JointKind::universal, JointKind::ball}) {
    Joint& joint = scene.joints.emplace_back();
    joint.name = "joint." + std::to_string(static_cast<int>(kind));
    joint.kind = kind;
    joint.child = static_cast<int>(kind);
    if (kind == JointKind::hinge) joint.limits = JointLimits{-1, 1, 0.5};
    if (kind == JointKind::slider) joint.driven_rate = 1;
  }
  scene.ropes = {{"rope", {0, 1}, {}, {{{0, 0, 1}, {0, 1, 0}, 0.5, 0.25, 0.125}}}};
  scene.joint_forces = {JointSpring{1, 0, 1, 2, 3}, JointTorque{1, 0, 1, 2, 3, {{0, 1}}}};
  return scene;
}

Scene a_fluid() {
  Scene scene;
  scene.materials = {{"", 0, 0, 0}};
  scene.pairs = {{0, 0}};
  scene.domain = {2, {1, 1, 0}};
  Fluid& fluid = scene.fluids.emplace_back();
  fluid.name = "water";
  fluid.spacing_m = 0.5, fluid.density_kg_per_m3 = 1000, fluid.sound_speed_m_per_s = 10;
  fluid.particles = {{{0.25, 0.25, 0}}, {{1, 0, 0}}, {250}, {1000}, {293}};
  return scene;
}

using Lines = std::vector<std::string>;

void requests(Lines& lines) {
  using Kind = wire::Request::Kind;
  wire::Request request;
  lines.push_back(wire::to_line(request));
  request.kind = Kind::run;
  request.cell = 7;
  request.method = "mine/rk4{substeps=2}";
  request.plan = {2, 8, 4, {}};
  request.json = scene_to_json(every_kind());
  lines.push_back(wire::to_line(request));
  request.json = scene_to_json(a_fluid());
  request.repeats = 5;
  lines.push_back(wire::to_line(request));
  request.json = "{}";
  request.repeats = 0;
  request.profile = true;
  request.plan = {2, 8, 1, {0.5, 2}};
  lines.push_back(wire::to_line(request));
  request.kind = Kind::truth;
  request.response = "sph{viscosity=morris}";
  lines.push_back(wire::to_line(request));
  request.test = "unit-size";
  request.pair = "box-box";
  request.contacts = {true, 1};
  request.count = 10;
  for (const Kind kind : {Kind::contacts, Kind::sweep}) {
    request.kind = kind;
    lines.push_back(wire::to_line(request));
  }
  lines.push_back(wire::to_line(wire::FieldRequest{7, "sph{}", "{}", {0, 0.5}, {{{0, 0, 0}}, {{1, third, 0}}}}));
}

Sample whole_sample() {
  Sample sample = wide_sample();
  sample.contacts = {{0, 1, {0.1, 2, 3}, {0, 0, 1}, -1e-9, 9.8, {0.5, -0.25, 0}}};
  sample.particles = {{{0, third, 0}, {1, 0, 0}, 1000, 5, 293}, {}};
  sample.joints = {{{0.5, 0, 0, 0}, {1, 0, 0}, {0, 0, 1}, {0, 1, 0}, 9, {2, 0, 0}, {-1, 0, 0}}};
  sample.ropes = {{3, {0.25}}};
  return sample;
}

void answers(Lines& lines) {
  const wire::Put put = [&](const std::string& line) { lines.push_back(line); };
  Engine engine;
  engine.name = "mine", engine.version = "1", engine.scalar = "double", engine.fingerprint = "abc";
  engine.frames = engine.fluids = engine.joints = true;
  engine.files = {"model.bin"};
  MethodInfo& method = engine.methods.emplace_back();
  method.id = "mine/rk4", method.doc = "Doc.", method.source = "Paper.", method.claimed_order = {{"point-mass", 4}};
  method.formula = "y_new = y + h k\nk = f(t, y)";
  declare_settings(method, {{"substeps", std::int64_t{1}, {between(0, 9), "Of a step.", "s"}},
                            {"law", "newton", {one_of({"newton", "poisson"}), "", ""}},
                            {"erp", 0.5, {strictly_between(0, 1), "", ""}},
                            {"sleep", false, {}}});
  engine.responses = {method};
  lines.push_back(wire::hello_line(engine));

  const Event event{third, EventKind::impact, 0, 1, {}, {0, 0, 1}, 1, 2, -3, 4};
  const Sample sample = whole_sample();
  wire::sample_lines(7, sample, nullptr, {event}, put);
  const SampleView bar = sample;
  wire::sample_lines(7, sample, &bar, {}, put, 200);
  for (const EventKind kind :
       {EventKind::rest, EventKind::slip, EventKind::stick, EventKind::roll, EventKind::separate})
    lines.push_back(to_string(kind));
  std::vector<Event> events = {event, event};
  std::vector<double> bars = {1e-9, 1e-9};
  wire::event_lines(7, events, &bars, put, 1);

  for (const Status status : {Status::ok, Status::unsupported, Status::diverged, Status::not_finite, Status::timeout,
                              Status::crashed, Status::not_built}) {
    Outcome outcome{status, "why", 8, 32, {100, 200}, {{"sweeps", {1, 2, 3, 4, 0.5}}}, 50};
    lines.push_back(wire::done_line(7, outcome, events, {{1, 2}, {{"broad", 3}}}));
  }
  Truth truth;
  truth.source = "closed form: a paper", truth.note = "a note", truth.condition = 2;
  lines.push_back(wire::truth_done_line(7, truth));
  ContactAnswer contacts;
  contacts.contacts = {{0, 1, {}, {0, 0, 1}, 0.5}};
  contacts.touches = {{0, 1, 0.5, {}, {0, 0, 1}}};
  lines.push_back(wire::contacts_line(7, contacts, false));
  lines.push_back(wire::contacts_line(7, contacts, true));
  lines.push_back(wire::poses_line(7, {{true, -0.5, 0, {0, 0, 1}, {}, 4, 1e-20, 0.1}, {}}));
  lines.push_back(wire::error_line(7, "what"));
  const ParticleSample value{{}, {1, 0, 0}, 1000, 5, 293};
  wire::field_lines(7, {0.5, {value}, {value}, {ProbeValue{1, 0.5}, std::nullopt}}, put);
  lines.push_back(wire::field_done_line(7, {{}, "a paper", "a note", {true, true, false, false}, {}}));
}

struct Contract {
  int version;
  std::uint64_t hash;
};
constexpr Contract kContract = {1, 0x193dd067f973402c};

}  // namespace

TEST_CASE("the version of the protocol belongs to its lines") {
  Lines lines;
  requests(lines);
  answers(lines);
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  INFO(text);
  INFO(
      "The lines of the protocol are not those of its version. Where a worker would misread them, or a worker's old "
      "answer would be misread: raise wire::kProtocol. Where members were only added that others may ignore: keep it. "
      "In both cases write the new version and hash here and the change into CHANGELOG.md.");
  CHECK(kContract.version == wire::kProtocol);
  CHECK(kContract.hash == fnv_1a(text));
}
