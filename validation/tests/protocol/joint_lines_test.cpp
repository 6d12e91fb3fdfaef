// Joints and ropes on the wire: compact and padded rows, reactions left out, bars, parts; and what is not the protocol.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "protocol/wire.hpp"

using namespace atwood;
using Catch::Contains;

namespace {

const std::vector<JointKind> kKinds = {JointKind::fixed,       JointKind::hinge,     JointKind::slider,
                                       JointKind::cylindrical, JointKind::universal, JointKind::ball};

std::vector<Joint> joints_of_all_kinds() {
  std::vector<Joint> joints;
  for (const JointKind kind : kKinds) joints.emplace_back().kind = kind;
  joints[1].limits = JointLimits{-1, 1, 0};
  return joints;
}

// Thirds, which no double holds.
Sample sample_of_all_kinds() {
  Sample sample;
  sample.t_s = 0.5;
  sample.bodies.resize(2);
  Wide next = Wide(1) / 3;
  for (const JointKind kind : kKinds) {
    JointSample& joint = sample.joints.emplace_back();
    for (std::size_t i = 0; i < static_cast<std::size_t>(coordinate_count(kind)); ++i) joint.q[i] = next += 1;
    for (std::size_t i = 0; i < static_cast<std::size_t>(rate_count(kind)); ++i)
      joint.u[i] = next += 1, joint.applied[i] = -next;
    for (std::size_t i = 0; i < 3; ++i) joint.force_N[i] = next += 1, joint.torque_N_m[i] = next += 1;
  }
  for (JointSample& joint : sample.joints) joint.stop = {};
  sample.joints[1].stop[0] = next += 1;
  sample.joints[1].not_unique = 9;
  sample.ropes = {{Wide(1) / 7, {Wide(2) / 7, 0.5}}, {3, {}}};
  return sample;
}

void check_equal(const std::vector<JointSample>& a, const std::vector<JointSample>& b) {
  REQUIRE(a.size() == b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    CHECK(a[i].q == b[i].q);
    CHECK(a[i].u == b[i].u);
    CHECK(a[i].force_N == b[i].force_N);
    CHECK(a[i].torque_N_m == b[i].torque_N_m);
    CHECK(a[i].applied == b[i].applied);
    for (std::size_t k = 0; k < 3; ++k)
      CHECK((a[i].stop[k] == b[i].stop[k] || (a[i].stop[k] != a[i].stop[k] && b[i].stop[k] != b[i].stop[k])));
    CHECK(a[i].not_unique == b[i].not_unique);
  }
}

std::string line_of(const Sample& sample, const Sample* bar, const std::vector<Joint>* joints) {
  std::string only;
  const SampleView bars = bar ? *bar : sample;
  wire::sample_lines(
      7, sample, bar ? &bars : nullptr, {}, [&](const std::string& line) { only = line; }, std::string::npos, joints);
  return only;
}

std::string refusal(const std::string& members, const wire::Limits& most = {}) {
  try {
    wire::read_answer(R"({"cell":7,"t_s":0,"bodies":[],)" + members + "}", most);
  } catch (const wire::Garbage& garbage) {
    return garbage.what();
  }
  return "no error";
}

}  // namespace

TEST_CASE("joints and ropes cross with their sample to the bit, in rows as long as the joint's kind, or padded") {
  const Sample sample = sample_of_all_kinds();
  const std::vector<Joint> joints = joints_of_all_kinds();
  for (const std::vector<Joint>* kinds : {&joints, static_cast<const std::vector<Joint>*>(nullptr)}) {
    const wire::Answer answer = wire::read_answer(line_of(sample, nullptr, kinds));
    check_equal(answer.sample.joints, sample.joints);
    REQUIRE(answer.sample.ropes.size() == 2);
    CHECK(answer.sample.ropes[0].tension_N == sample.ropes[0].tension_N);
    CHECK(answer.sample.ropes[0].pulley_angle_rad == sample.ropes[0].pulley_angle_rad);
    CHECK(answer.sample.ropes[1].pulley_angle_rad.empty());
    CHECK(answer.joint_coordinates == (kinds ? std::vector<int>{0, 1, 1, 2, 2, 4} : std::vector<int>(6, 4)));
  }
  Sample without = sample;
  without.joints.clear(), without.ropes.clear();
  CHECK(line_of(without, nullptr, &joints).find("joint") == std::string::npos);
  CHECK(line_of(without, nullptr, &joints).find("rope") == std::string::npos);
}

TEST_CASE("a reaction that is not reported is left out and comes back as no number") {
  Sample sample = sample_of_all_kinds();
  for (JointSample& joint : sample.joints)
    for (std::size_t i = 0; i < 3; ++i)
      joint.force_N[i] = joint.torque_N_m[i] = std::numeric_limits<double>::quiet_NaN();
  const std::vector<Joint> joints = joints_of_all_kinds();
  const std::string line = line_of(sample, nullptr, &joints);
  CHECK(line.find("nan") == std::string::npos);
  const wire::Answer answer = wire::read_answer(line);
  for (std::size_t i = 0; i < sample.joints.size(); ++i) {
    CHECK(answer.sample.joints[i].q == sample.joints[i].q);
    CHECK(std::isnan(static_cast<double>(answer.sample.joints[i].force_N[0])));
    CHECK(std::isnan(static_cast<double>(answer.sample.joints[i].torque_N_m[2])));
  }
}

TEST_CASE("the force of a stop that is not reported, or that no joint has, takes no room") {
  Sample sample = sample_of_all_kinds();
  std::vector<Joint> joints = joints_of_all_kinds();
  CHECK(line_of(sample, nullptr, &joints).find("\"joint_stops\":[[],[") != std::string::npos);
  joints[1].limits.reset();
  CHECK(line_of(sample, nullptr, &joints).find("joint_stops") == std::string::npos);
  joints[1].limits = JointLimits{-1, 1, 0};
  for (JointSample& joint : sample.joints) joint.stop = JointSample{}.stop;
  const std::string line = line_of(sample, nullptr, &joints);
  CHECK(line.find("joint_stops") == std::string::npos);
  CHECK(std::isnan(static_cast<double>(wire::read_answer(line).sample.joints[1].stop[0])));
}

TEST_CASE("a truth's joints come with their bars") {
  const Sample sample = sample_of_all_kinds();
  Sample bar = sample;
  for (JointSample& joint : bar.joints) joint.applied = {}, joint.stop = JointSample{}.stop, joint.not_unique = 0;
  const std::vector<Joint> joints = joints_of_all_kinds();
  const wire::Answer answer = wire::read_answer(line_of(sample, &bar, &joints));
  check_equal(answer.bar.joints, bar.joints);
  REQUIRE(answer.bar.ropes.size() == 2);
  CHECK(answer.bar.ropes[0].pulley_angle_rad == bar.ropes[0].pulley_angle_rad);
}

TEST_CASE("of a sample in parts the joints come once, with the last body") {
  Sample sample = sample_of_all_kinds();
  sample.bodies.resize(100);
  sample.contacts.resize(300);
  std::size_t lines = 0, with_joints = 0, bodies = 0;
  wire::sample_lines(
      7, sample, nullptr, {},
      [&](const std::string& line) {
        const wire::Answer part = wire::read_answer(line);
        ++lines, bodies += part.sample.bodies.size();
        if (part.sample.joints.empty()) return;
        ++with_joints;
        CHECK(bodies == 100);
        check_equal(part.sample.joints, sample.joints);
      },
      2000, nullptr);
  CHECK(lines > 3);
  CHECK(with_joints == 1);
}

TEST_CASE("rows of joints that are none are refused by name") {
  CHECK(refusal(R"("joints":[[1,2],[],[1,2,3,4,5,6]])") == "no error");
  CHECK_THAT(refusal(R"("joints":[[1,2,3]])"), Contains("\"joint\" is not an array of 6, 8, 10 or 13"));
  CHECK_THAT(refusal(R"("joints":[7])"), Contains("\"joint\" is not an array"));
  CHECK_THAT(refusal(R"("joints":7)"), Contains("\"joints\" is not an array"));
  CHECK_THAT(refusal(R"("joints":[[1,"x"]])"), Contains("not a number"));
  CHECK_THAT(refusal(R"("joints":[[1,2]],"not_unique":[64])"), Contains("expected six bits"));
  CHECK_THAT(refusal(R"("joints":[[1,2]],"not_unique":[0,0])"), Contains("differ in size"));
  CHECK_THAT(refusal(R"("joint_applied":[[1],[2]],"joints":[[1,2]])"), Contains("differ in size"));
  CHECK_THAT(refusal(R"("joints":[[1,2]],"joint_applied":[[1,2,3,4]])"), Contains("at most 3"));
  CHECK_THAT(refusal(R"("joints":[[1,2]],"joint_stops":[[1],[2]])"), Contains("\"joint_stops\" and \"joints\" differ"));
  CHECK_THAT(refusal(R"("joints":[[1,2]],"joint_stops":[7])"),
             Contains("\"joint_stops\" is not an array of at most 3"));
  CHECK_THAT(refusal(R"("joints":[[1,2]],"joint_bars":[[1,2],[1,2]])"), Contains("differ in size"));
  CHECK_THAT(refusal(R"("ropes":[[]])"), Contains("\"rope\" is not an array of a tension"));
  wire::Limits one;
  one.joints = 1;
  CHECK_THAT(refusal(R"("joints":[[1,2],[1,2]])", one), Contains("more than 1 joints in a line"));
}

TEST_CASE("an engine that simulates joints says so in hello") {
  Engine engine;
  engine.name = "e", engine.version = "1", engine.scalar = "double";
  engine.methods.emplace_back().id = "e/default";
  CHECK_FALSE(wire::read_hello(wire::hello_line(engine)).joints);
  engine.joints = true;
  CHECK(wire::read_hello(wire::hello_line(engine)).joints);
}
