// Points that stand for walls in the particles' equations (docs/fluids.md, "Walls"). Their places are data of the
// scene.
#pragma once

#include <optional>
#include <vector>

#include "fluid_truth/number.hpp"
#include "scene/scene.hpp"

namespace atwood::fluid_truth {

template <class S> struct FixedPoint {
  Vec<S> x{}, velocity{};  // velocity: of the wall's surface there
  int boundary = 0;        // index into Scene::fluid_boundaries
  bool no_slip = true;
  std::optional<S> temperature, heat_flux;
  S area{};  // of the surface that the point stands for
};

// Empty where the scene has no boundary. Throws Refused where a boundary moves or cannot be filled.
template <class S> std::vector<FixedPoint<S>> fixed_points(const Scene& scene, double max_depth_m);

}  // namespace atwood::fluid_truth
