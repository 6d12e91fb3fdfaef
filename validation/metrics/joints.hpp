// Scenes with joints and ropes: what their metrics share.
#pragma once

#include <vector>

#include "protocol/truth.hpp"
#include "scene/scene.hpp"
#include "validation/metrics/metrics.hpp"

namespace atwood {

// Joints or ropes hold some of the scene's bodies.
bool has_mechanism(const Scene& scene);

// How many bodies joints or ropes hold, fixed ones left out.
int linked_bodies(const Scene& scene);

// The joint at whose stop this event happened, by its parent and child; null: none has limits.
const Joint* stop_of(const Scene& scene, const Event& event);

// The run with joint coordinates and rates in every sample: computed from the poses where they are not reported, whole
// turns counted from the start on (less than half a turn between two samples).
Recording with_joints(const Scene& scene, const Recording& run);

std::vector<MetricInfo> joint_metrics();

}  // namespace atwood
