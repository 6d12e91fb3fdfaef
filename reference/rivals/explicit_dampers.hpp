// Dampers that an adapter evaluates once a step, at its start: c u acts on a rate u with the inertia I for the whole
// step h, so that u becomes (1 - c h / I) u, which grows beyond c h = 2 I.
#pragma once

#include <optional>
#include <string>

#include "scene/scene.hpp"

namespace atwood::rivals {

struct ExplicitDampers {
  std::string stiffest;       // as "the damper of the joint `hinge`"
  double largest_step_s = 0;  // 2 I / c; of several, what they allow together
};

// Of the scene's start, where joints hold the bodies together: joint dampers (if the adapter evaluates `joint_forces`),
// linear drag and the dashpots of springs (`body_forces`). None: there is no damper.
std::optional<ExplicitDampers> explicit_dampers(const Scene& scene, bool joint_forces, bool body_forces);

// What a row says of a run with steps beyond that; empty: its steps are within it.
std::string beyond_explicit_dampers(const std::optional<ExplicitDampers>& dampers, double h_s);

}  // namespace atwood::rivals
