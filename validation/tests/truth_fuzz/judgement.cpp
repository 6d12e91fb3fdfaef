#include "judgement.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace atwood::fuzz {
namespace {

// Why a value has no error in bars: it, its bar or the checker's value is no number. "": it has one.
std::string unjudged(Wide value, Wide bar, const Long& is) {
  if (!(value == value)) return " is not a number";
  if (!(is == is))
    return fmt::format(" is {}, and the checker has no value", format_double(static_cast<double>(value)));
  return bar >= 0 ? "" : " has no bar";
}

struct Comparison {
  Judged made;
  double unsharp = 0;

  void hold(Wide value, Wide bar, const Long& is, const Long& own, const std::string& what) {
    if (const std::string fault = unjudged(value, bar, is); !fault.empty()) {
      made = {Result::breach, HUGE_VAL, what + fault};
      return;
    }
    const Long off = abs(widened(value) - is), allowed = widened(bar);
    if (!(off <= allowed + own)) {
      const double ratio = allowed > 0 ? static_cast<double>(off / allowed) : HUGE_VAL;
      if (made.result != Result::breach || ratio > made.worst)
        made = {Result::breach, ratio,
                fmt::format("{} is off by {:.2e} with a bar of {:.2e}", what, static_cast<double>(off),
                            static_cast<double>(allowed))};
      return;
    }
    if (allowed == 0 && own < Long(1e-36) * (1 + abs(is))) return;  // both are exact, as for a body that never moves
    if (own > allowed / 10) unsharp = std::max(unsharp, allowed > 0 ? static_cast<double>(own / allowed) : HUGE_VAL);
    if (made.result != Result::breach && allowed > 0)
      made.worst = std::max(made.worst, static_cast<double>(off / allowed));
  }
  void hold_body(const BodySample& value, const BodySample& bar, const LongBody& is, const LongBody& own,
                 const std::string& at) {
    for (int c = 0; c < 3; ++c) {
      hold(value.p_m[c], bar.p_m[c], is.p[c], own.p[c], "position" + at);
      hold(value.v_m_per_s[c], bar.v_m_per_s[c], is.v[c], own.v[c], "velocity" + at);
      hold(value.w_rad_per_s[c], bar.w_rad_per_s[c], is.w[c], own.w[c], "body rate" + at);
    }
    for (int c = 0; c < 4; ++c) hold(value.q_wxyz[c], bar.q_wxyz[c], is.q[c], own.q[c], "orientation" + at);
  }
  // A component of a reaction is judged unless both the truth and the checker report none.
  void hold_reaction(const std::array<Wide, 3>& value, const std::array<Wide, 3>& bar, const Long3& is,
                     const Long3& own, const std::string& what) {
    for (int c = 0; c < 3; ++c)
      if (value[c] == value[c] || is[c] == is[c]) hold(value[c], bar[c], is[c], own[c], what);
  }
  void hold_joint(const JointSample& value, const JointSample& bar, const LongJoint& is, const LongJoint& own,
                  bool reactions, const std::string& at) {
    for (int c = 0; c < 4; ++c) hold(value.q[c], bar.q[c], is.q[c], own.q[c], "coordinate" + at);
    for (int c = 0; c < 3; ++c) hold(value.u[c], bar.u[c], is.u[c], own.u[c], "rate" + at);
    if (!reactions) return;
    hold_reaction(value.force_N, bar.force_N, is.force, own.force, "force" + at);
    hold_reaction(value.torque_N_m, bar.torque_N_m, is.torque, own.torque, "torque" + at);
  }
  void hold_rope(const RopeSample& value, const RopeSample& bar, const LongRope& is, const LongRope& own,
                 const std::string& at) {
    if (value.pulley_angle_rad.size() != is.angles.size()) {
      made = {Result::breach, HUGE_VAL, "another number of pulleys" + at};
      return;
    }
    hold(value.tension_N, bar.tension_N, is.tension, own.tension, "tension" + at);
    for (std::size_t p = 0; p < is.angles.size(); ++p)
      hold(value.pulley_angle_rad[p], bar.pulley_angle_rad[p], is.angles[p], own.angles[p], "pulley" + at);
  }
};

void hold_events(const Truth& truth, const Checked& exact, const Long& t_end_s, Comparison& compared) {
  // An event whose bar holds the end may be there or not.
  const std::size_t count = truth.events.size();
  for (std::size_t e = 0; e < std::min(count, exact.event_s.size()); ++e)
    compared.hold(truth.events[e].t_s, truth.event_bar_s[e], exact.event_s[e], exact.event_own_s[e],
                  fmt::format("time of event {}", e));
  const auto inside = [&](const Long& t) { return t < t_end_s * (1 - Long(1e-15)); };
  if ((count < exact.event_s.size() && inside(exact.event_s[count])) ||
      (count > exact.event_s.size() && inside(widened(truth.events[exact.event_s.size()].t_s))))
    compared.made = {Result::breach, HUGE_VAL, fmt::format("{} events instead of {}", count, exact.event_s.size())};
}

}  // namespace

Judged judge(const Truth& truth, const Checked& exact, double t_end_s) {
  if (!exact.contradicts.empty()) return {Result::breach, HUGE_VAL, "an answer, although " + exact.contradicts};
  Comparison compared;
  if (truth.values.size() != exact.values.size()) return {Result::unchecked, 0, "another number of samples"};
  for (std::size_t k = 1; k < truth.values.size(); ++k) {
    const SampleView value = truth.values[k], bar = truth.bars[k];
    const auto at = [&](const char* what, std::size_t i) { return fmt::format(" of {} {} at sample {}", what, i, k); };
    for (std::size_t i = 0; i < value.bodies.size(); ++i)
      compared.hold_body(value.bodies[i], bar.bodies[i], exact.values[k][i], exact.own[k][i], at("body", i));
    if ((!exact.joints.empty() && value.joints.size() != exact.joints[k].size()) ||
        (!exact.ropes.empty() && value.ropes.size() != exact.ropes[k].size()))
      return {Result::breach, HUGE_VAL, fmt::format("another number of joints or ropes at sample {}", k)};
    if (!exact.joints.empty())
      for (std::size_t j = 0; j < value.joints.size(); ++j)
        compared.hold_joint(value.joints[j], bar.joints[j], exact.joints[k][j], exact.joints_own[k][j], exact.reactions,
                            at("joint", j));
    if (!exact.ropes.empty())
      for (std::size_t r = 0; r < value.ropes.size(); ++r)
        compared.hold_rope(value.ropes[r], bar.ropes[r], exact.ropes[k][r], exact.ropes_own[k][r], at("rope", r));
  }
  if (exact.has_events) hold_events(truth, exact, t_end_s, compared);
  if (compared.made.result == Result::held && compared.unsharp > 0)
    return {Result::unchecked, compared.made.worst,
            fmt::format("the checker's own bar is {:.1e} of the truth's", compared.unsharp)};
  return compared.made;
}

}  // namespace atwood::fuzz
