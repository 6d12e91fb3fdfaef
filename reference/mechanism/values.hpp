// All numbers of a mechanism's samples in a fixed order, with their kinds and scales: what comparisons of runs share.
#pragma once

#include <initializer_list>
#include <vector>

#include "protocol/sample_series.hpp"
#include "scene/scene.hpp"

namespace atwood::mechanism {

enum ValueKind {
  position,
  attitude,
  velocity,
  angular_velocity,
  coordinate_angle,
  coordinate_length,
  coordinate_rate_angular,
  rate_speed,
  force,
  torque,
  applied_load,
  tension,
  pulley,
  kinds
};

// Calls value(number, kind) for every number of a sample, in a fixed order. The four of a quaternion follow each other.
template <class SampleType, class Value> void each_value(const Scene& scene, SampleType&& sample, Value value) {
  for (auto& body : sample.bodies) {
    for (auto& x : body.p_m) value(x, position);
    for (auto& x : body.q_wxyz) value(x, attitude);
    for (auto& x : body.v_m_per_s) value(x, velocity);
    for (auto& x : body.w_rad_per_s) value(x, angular_velocity);
  }
  for (std::size_t j = 0; j < sample.joints.size(); ++j) {
    const JointKind kind = scene.joints[j].kind;
    auto& joint = sample.joints[j];
    const auto slides = [&](int k) { return kind == JointKind::slider || (kind == JointKind::cylindrical && k == 1); };
    for (int k = 0; k < 4; ++k)
      value(joint.q[k], kind == JointKind::ball ? attitude : slides(k) ? coordinate_length : coordinate_angle);
    for (int k = 0; k < 3; ++k) value(joint.u[k], slides(k) ? rate_speed : coordinate_rate_angular);
    for (auto& x : joint.force_N) value(x, force);
    for (auto& x : joint.torque_N_m) value(x, torque);
    for (auto& x : joint.applied) value(x, applied_load);
    if (scene.joints[j].limits) value(joint.stop[0], applied_load);
  }
  for (auto& rope : sample.ropes) {
    value(rope.tension_N, tension);
    for (auto& x : rope.pulley_angle_rad) value(x, pulley);
  }
}

std::vector<Wide> values_of(const Scene& scene, const SampleView& sample);
// One flag for each number, in the same order; nonzero where Sample::not_unique says that the value is not determined.
std::vector<char> undetermined_values(const Scene& scene, const SampleView& sample);
// The largest value of each kind over the samples. Kinds of one unit share theirs. Forces and torques share a scale,
// converted by the mechanism's size, and so do speeds and angular velocities: a torque that is zero up to round-off is
// then judged against the moments of the forces.
std::vector<Wide> scales(const Scene& scene, const SampleSeries& samples);
// The largest distance of each number from those of the others; infinite when one is not a number. Quaternions of
// either sign are the same attitude.
std::vector<Wide> differences(const Scene& scene, const SampleView& sample, std::initializer_list<SampleView> others);

}  // namespace atwood::mechanism
