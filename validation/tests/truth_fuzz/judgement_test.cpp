// What a campaign says of an answer that has no error in bars.
#include "judgement.hpp"

#include <catch2/catch.hpp>
#include <limits>

using namespace atwood;
using namespace atwood::fuzz;

namespace {

constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();

// One body and one joint at rest, at two samples, with bars of 1e-30 and a checker that agrees.
struct Answer {
  Truth truth;
  Checked exact;
};
Answer agreeing() {
  Answer made;
  Sample value, bar;
  value.bodies.resize(1);
  value.joints.resize(1);
  bar.bodies.resize(1);
  bar.joints.resize(1);
  BodySample& of = bar.bodies[0];
  of.p_m.fill(1e-30), of.v_m_per_s.fill(1e-30), of.w_rad_per_s.fill(1e-30), of.q_wxyz.fill(1e-30);
  JointSample& joint = bar.joints[0];
  joint.q.fill(1e-30), joint.u.fill(1e-30), joint.force_N.fill(1e-30), joint.torque_N_m.fill(1e-30);
  value.joints[0].force_N.fill(0), value.joints[0].torque_N_m.fill(0);
  made.truth.values = std::vector(2, value);
  made.truth.bars = std::vector(2, bar);
  LongBody still;
  for (std::size_t c = 0; c < 4; ++c) still.q[c] = widened(value.bodies[0].q_wxyz[c]);
  LongBody own;
  own.q = {};
  made.exact.values.assign(2, {still});
  made.exact.own.assign(2, {own});
  made.exact.joints.assign(2, std::vector<LongJoint>(1));
  made.exact.joints_own.assign(2, std::vector<LongJoint>(1));
  made.exact.reactions = true;
  return made;
}
Judged judged(const Answer& answer) { return judge(answer.truth, answer.exact, 1); }

}  // namespace

TEST_CASE("an answer within its bars is held, and one outside says by how much") {
  Answer answer = agreeing();
  CHECK(judged(answer).result == Result::held);
  answer.truth.values[1].bodies[0].v_m_per_s[2] = 3e-30;
  CHECK(judged(answer).result == Result::breach);
  CHECK(judged(answer).reason == "velocity of body 0 at sample 1 is off by 3.00e-30 with a bar of 1.00e-30");
}

TEST_CASE("an answer without an error in bars is a breach, in words and never as `nan`") {
  const auto reason = [](const Answer& answer) {
    const Judged made = judged(answer);
    CHECK(made.result == Result::breach);
    CHECK(made.reason.find("nan") == std::string::npos);
    return made.reason;
  };
  Answer answer = agreeing();
  answer.exact.contradicts = "`box0` slides";
  CHECK(reason(answer) == "an answer, although `box0` slides");
  answer = agreeing();
  answer.truth.values[1].bodies[0].p_m[0] = kNotANumber;
  CHECK(reason(answer) == "position of body 0 at sample 1 is not a number");
  answer = agreeing();
  answer.truth.values[1].joints[0].force_N[1] = 2;
  answer.exact.joints[1][0].force[1] = kNotANumber;
  CHECK(reason(answer) == "force of joint 0 at sample 1 is 2, and the checker has no value");
  answer = agreeing();
  answer.truth.bars[1].bodies[0].w_rad_per_s[1] = kNotANumber;
  CHECK(reason(answer) == "body rate of body 0 at sample 1 has no bar");
  answer = agreeing();  // components of a reaction that neither reports
  answer.truth.values[1].joints[0].force_N[2] = kNotANumber;
  answer.exact.joints[1][0].force[2] = kNotANumber;
  CHECK(judged(answer).result == Result::held);
}
