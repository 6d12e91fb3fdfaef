// What the poses and velocities of a sample's bodies say about the joints and ropes between them: how far a joint is
// from its constraint, its coordinates and rates, lengths and speeds of ropes. No engine's own report is used, so that
// engines in reduced and in maximal coordinates are judged alike.
#pragma once

#include <array>
#include <vector>

#include "protocol/sample_series.hpp"
#include "scene/scene.hpp"

namespace atwood::dynamics {

// Of one joint, by the conventions of scene/joint.hpp.
struct JointPose {
  // Distance of the anchors [m]: of a slider or cylindrical joint, of their difference's part across the axis.
  Wide gap_m = 0;
  // The rotation that the joint does not allow [rad]: of a hinge or cylindrical joint the angle between its axis as the
  // parent and as the child carry it; of a universal joint by how much the angle of its two axes has changed; of a
  // fixed joint or slider the whole relative rotation; of a ball 0.
  Wide tilt_rad = 0;
  // Angles lie in (-pi, pi], offsets are in m, a ball's quaternion has w >= 0.
  std::array<Wide, 4> q{};
  std::array<Wide, 3> u{};
};
JointPose joint_pose(const Scene& scene, int joint, const SampleView& sample);

// Whether coordinate i of a joint of this kind is an angle [rad]; others are offsets [m].
bool is_angle(JointKind kind, int coordinate);

// The sample's joints with coordinates and rates from its poses where the sample has none of its own: each angle is the
// one nearest to `before`'s, each quaternion has the sign nearest to it; reactions stay not reported (NaN).
std::vector<JointSample> joints_of(const Scene& scene, const SampleView& sample,
                                   const std::vector<JointSample>& before);
// The joints at the start, as the scene states them; reactions not reported.
std::vector<JointSample> joints_at_start(const Scene& scene);

// Length of a rope [m]: its straight parts and the arcs on its pulleys, each arc in [0, 2 pi) times the radius.
Wide rope_length_m(const Scene& scene, const Rope& rope, const SampleView& sample);
// Speed of the rope at its first body, positive from the first body to the last [m/s].
Wide rope_speed_m_per_s(const Scene& scene, const Rope& rope, const SampleView& sample);

}  // namespace atwood::dynamics
