// The forces that a general-purpose engine lacks, for adapters to apply once a step at the step's beginning.
//
// Bullet and ODE know uniform gravity and contacts. Everything else of a scene is evaluated here from the engine's own
// state (its precision widened to double) and handed over as one force through the centre of mass and one torque.
#pragma once

#include <string>
#include <vector>

#include "scene/scene.hpp"

namespace atwood::rivals {

struct Motion {
  Real3 p_WB{};
  Real4 q_WB{1, 0, 0, 0};
  Real3 v_WB{};
  Real3 w_WB_B{};
};

struct Wrench {
  Real3 force_N{};     // world axes
  Real3 torque_N_m{};  // about the centre of mass, world axes
};

// Sets `wrenches` (one a body) to the sum of all forces but uniform gravity, at time t_s; thrusters and point forces
// are on or off as they are at t_switch_s, the middle of the step.
void applied_wrenches(const Scene& scene, double t_s, double t_switch_s, const std::vector<Motion>& motions,
                      std::vector<Wrench>& wrenches);

// Why these forces don't cover the scene; empty when they do.
std::string uncovered_force(const Scene& scene);

// "drag, spring": which kinds of force the adapter evaluates in this scene; empty when there are none.
std::string names_of_forces(const Scene& scene);

}  // namespace atwood::rivals
