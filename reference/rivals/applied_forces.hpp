// The forces that a general-purpose engine lacks; adapters apply them once per step, at its start.
//
// Bullet and ODE have uniform gravity and contacts. All other forces of a scene are evaluated here from the engine's
// own state (converted to double) and applied as one force at the centre of mass and one torque.
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

// Sets `wrenches` (one per body) to the sum of all forces except uniform gravity, at time t_s; thrusters and point
// forces are on or off as they are at t_switch_s, the middle of the step.
void applied_wrenches(const Scene& scene, double t_s, double t_switch_s, const std::vector<Motion>& motions,
                      std::vector<Wrench>& wrenches);

// Which force of the scene is not covered; empty: all are.
std::string uncovered_force(const Scene& scene);

// The kinds of force that the adapter evaluates in this scene, as "drag, spring"; empty: none.
std::string names_of_forces(const Scene& scene);

}  // namespace atwood::rivals
