// Which bodies a joint ties together.
#pragma once

#include <algorithm>

#include "scene/scene.hpp"

namespace atwood {

// Bodies that a joint ties together do not collide with each other: their shapes may overlap where it is.
inline bool joined(const Scene& scene, int body_a, int body_b) {
  return std::ranges::any_of(scene.joints, [&](const Joint& joint) {
    return (joint.parent == body_a && joint.child == body_b) || (joint.parent == body_b && joint.child == body_a);
  });
}

}  // namespace atwood
