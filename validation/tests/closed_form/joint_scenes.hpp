// Scenes with joints, and a check of their closed forms against the laws of motion that shares no code with them:
// samples differentiated by a central formula of 13 points satisfy Newton's and Euler's equations with the reactions
// that the samples report.
#pragma once

#include <string>
#include <vector>

#include "scenes.hpp"

namespace atwood::testing {

using V3 = std::array<Wide, 3>;
using Q4 = std::array<Wide, 4>;

inline V3 plus(const V3& a, const V3& b, Wide s = 1) { return {a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]}; }
inline V3 times(const V3& a, const V3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline Wide size(const V3& a) { return sqrtq(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]); }
inline V3 wide(const Real3& a) { return {a[0], a[1], a[2]}; }
// The rotation matrix's product, so that the check does not share the closed forms' quaternion arithmetic.
inline V3 turned(const Q4& q, const V3& v, bool back = false) {
  const Wide w = q[0], x = q[1], y = q[2], z = q[3];
  const Wide m[3][3] = {{w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)},
                        {2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)},
                        {2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z}};
  V3 made{};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) made[i] += (back ? m[j][i] : m[i][j]) * v[j];
  return made;
}

inline Scenario mechanism(const std::string& solution, double t_end_s, std::vector<Body> bodies,
                          std::vector<Joint> joints, Real3 gravity = down) {
  Scenario given = scenario(solution, t_end_s);
  given.scene.gravity_m_per_s2 = gravity;
  given.scene.bodies = std::move(bodies);
  given.scene.joints = std::move(joints);
  return given;
}

inline Joint with_start(Joint given, double coordinate, double rate) {
  given.coordinates[0] = coordinate;
  given.rates[0] = rate;
  return given;
}

// d/dt of a value of samples k - 6 .. k + 6 that are h apart.
template <std::size_t n, class Value>
std::array<Wide, n> derivative(const SampleSeries& samples, std::size_t k, Wide h, const Value& value) {
  std::array<Wide, n> made{};
  Wide weight = -1;
  for (int j = 1; j <= 6; ++j) {  // c_j = (-1)^(j+1) (6!)^2 / (j (6 - j)! (6 + j)!)
    weight *= -Wide(6 - j + 1) / (6 + j);
    const std::array<Wide, n> ahead = value(samples[k + static_cast<std::size_t>(j)]),
                              behind = value(samples[k - static_cast<std::size_t>(j)]);
    for (std::size_t i = 0; i < n; ++i) made[i] += weight / j * (ahead[i] - behind[i]) / h;
  }
  return made;
}

// The largest deviations from each law, relative to the largest terms of its kind, and what they are.
struct Deviations {
  double velocity = 0, attitude = 0, force = 0, torque = 0, gap = 0, rate = 0;
  double worst() const {
    return std::fmax(std::fmax(std::fmax(velocity, attitude), std::fmax(force, torque)), std::fmax(gap, rate));
  }
};

// A joint's anchor on its child, and the wrench of reaction, spring and motor on it (applied: along n for a first
// coordinate).
struct Pull {
  V3 at{}, force{}, torque{};
};
inline Pull pull(const Scene& scene, const SampleView& sample, std::size_t j) {
  const Joint& joint = scene.joints[j];
  const BodySample& child = sample.bodies[static_cast<std::size_t>(joint.child)];
  const JointSample& now = sample.joints[j];
  Pull made{plus(child.p_m, turned(child.q_wxyz, wide(joint.anchors_body_m[1]))), now.force_N, now.torque_N_m};
  if (joint.kind == JointKind::ball || joint.kind == JointKind::fixed) return made;
  V3& along = joint.kind == JointKind::slider ? made.force : made.torque;
  along = plus(along, turned(child.q_wxyz, wide(joint.axis_body)), now.applied[0] / size(wide(joint.axis_body)));
  return made;
}

inline V3 angular_momentum(const Body& body, const BodySample& at) {
  V3 L{};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) L[i] += Wide(body.inertia_kg_m2[3 * i + j]) * at.w_rad_per_s[j];
  return turned(at.q_wxyz, L);
}

inline Deviations deviations(const Scenario& given, const Truth& truth) {
  const Scene& scene = given.scene;
  const SampleSeries& samples = truth.values;
  const Wide h = Wide(given.t_end_s) / static_cast<Wide>(samples.size() - 1);
  Deviations most;
  Wide forces = 0, torques = 0, speeds = 0, rates = 0, lengths = 1;
  std::vector<Wide> worst(6, 0);
  for (std::size_t k = 6; k + 6 < samples.size(); ++k) {
    const SampleView& now = samples[k];
    std::vector<V3> force(scene.bodies.size()), torque(scene.bodies.size());
    for (std::size_t j = 0; j < scene.joints.size(); ++j) {
      const Joint& joint = scene.joints[j];
      const Pull at = pull(scene, now, j);
      forces = fmaxq(forces, size(at.force));
      torques = fmaxq(torques, size(at.torque));
      for (const int body : {joint.child, joint.parent}) {
        if (body < 0) continue;
        const Wide sign = body == joint.child ? 1 : -1;
        const V3 arm = plus(at.at, now.bodies[static_cast<std::size_t>(body)].p_m, -1);
        lengths = fmaxq(lengths, size(arm));
        auto i = static_cast<std::size_t>(body);
        force[i] = plus(force[i], at.force, sign);
        torque[i] = plus(torque[i], plus(at.torque, times(arm, at.force)), sign);
      }
      V3 other = wide(joint.anchors_body_m[0]);
      if (joint.parent >= 0) {
        const BodySample& parent = now.bodies[static_cast<std::size_t>(joint.parent)];
        other = plus(parent.p_m, turned(parent.q_wxyz, other));
      }
      if (joint.kind == JointKind::slider) {
        const BodySample& child = now.bodies[static_cast<std::size_t>(joint.child)];
        other =
            plus(other, turned(child.q_wxyz, wide(joint.axis_body)), now.joints[j].q[0] / size(wide(joint.axis_body)));
      }
      worst[4] = fmaxq(worst[4], size(plus(at.at, other, -1)));
      if (joint.kind == JointKind::ball) continue;
      const Wide slope =
          derivative<1>(samples, k, h, [&](const SampleView& s) { return std::array<Wide, 1>{s.joints[j].q[0]}; })[0];
      rates = fmaxq(rates, fabsq(slope));
      worst[5] = fmaxq(worst[5], fabsq(slope - now.joints[j].u[0]));
    }
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
      const Body& body = scene.bodies[i];
      if (body.fixed) continue;
      const BodySample& at = now.bodies[i];
      const V3 v = derivative<3>(samples, k, h, [&](const SampleView& s) { return s.bodies[i].p_m; });
      const V3 a = derivative<3>(samples, k, h, [&](const SampleView& s) { return s.bodies[i].v_m_per_s; });
      const V3 dL =
          derivative<3>(samples, k, h, [&](const SampleView& s) { return angular_momentum(body, s.bodies[i]); });
      const Q4 dq = derivative<4>(samples, k, h, [&](const SampleView& s) { return s.bodies[i].q_wxyz; });
      const Q4& q = at.q_wxyz;
      const V3& w = at.w_rad_per_s;
      const Q4 turn{-q[1] * w[0] - q[2] * w[1] - q[3] * w[2], q[0] * w[0] + q[2] * w[2] - q[3] * w[1],
                    q[0] * w[1] + q[3] * w[0] - q[1] * w[2], q[0] * w[2] + q[1] * w[1] - q[2] * w[0]};
      for (int c = 0; c < 4; ++c) worst[1] = fmaxq(worst[1], fabsq(dq[c] - turn[c] / 2));
      speeds = fmaxq(speeds, size(v));
      rates = fmaxq(rates, size(w));
      forces = fmaxq(forces, Wide(body.mass_kg) * size(a));
      torques = fmaxq(torques, size(dL));
      worst[0] = fmaxq(worst[0], size(plus(v, at.v_m_per_s, -1)));
      const V3 needed = plus({Wide(body.mass_kg) * a[0], Wide(body.mass_kg) * a[1], Wide(body.mass_kg) * a[2]},
                             wide(scene.gravity_m_per_s2), -Wide(body.mass_kg));
      for (int c = 0; c < 3; ++c) {  // components that the constraints leave open are not numbers
        if (isnanq(force[i][c]) == 0) worst[2] = fmaxq(worst[2], fabsq(force[i][c] - needed[c]));
        if (isnanq(torque[i][c]) == 0) worst[3] = fmaxq(worst[3], fabsq(torque[i][c] - dL[c]));
      }
    }
  }
  const auto over = [](Wide value, Wide scale) { return static_cast<double>(scale > 0 ? value / scale : value); };
  most.velocity = over(worst[0], speeds);
  most.attitude = over(worst[1], rates);
  most.force = over(worst[2], forces);
  most.torque = over(worst[3], torques + forces * lengths);
  most.gap = over(worst[4], lengths);
  most.rate = over(worst[5], rates + speeds);
  return most;
}

}  // namespace atwood::testing
