// One scene in one btMultiBodyDynamicsWorld, in reduced coordinates (Featherstone's articulated-body algorithm).
// Conventions:
//   - every tree of joints is one btMultiBody; its base is the world (for joints to fixed bodies too) or a free body;
//   - links have principal axes: joint axes and quaternions are turned from the body's axes (q_BP) and back;
//   - universal and cylindrical joints are two joints with a link without mass between them, which is exact;
//   - a link's quaternion turns its parent's vectors into its own; a ball's rates are along the link's axes;
//   - closing joints are multibody constraints: ball as one btMultiBodyPoint2Point, hinge as two of them on its axis,
//     fixed as btMultiBodyFixedConstraint. Constraints exist in the solver's islands of colliders alone: without a
//     collider on every link
//     they are dropped without a word, so that links get a small sphere that collides with nothing;
//   - stepSimulation(h, 0) is one step: semi-implicit Euler in the coordinates, or with useRK4Integration a Runge-Kutta
//     step during which applied forces keep their values.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "protocol/method.hpp"
#include "rivals/world.hpp"

namespace atwood::bullet {

// Values of the settings "formulation" and "multibody_integrator".
inline constexpr char kMaximal[] = "maximal coordinates", kReduced[] = "reduced coordinates";
inline constexpr char kSemiImplicit[] = "semi-implicit Euler", kRungeKutta[] = "useRK4Integration";

// The settings beyond those of rigid bodies.
std::vector<Setting> multibody_settings();

// Whether these settings ask for multibodies.
bool in_reduced_coordinates(const Settings& settings);

// What Bullet's multibodies can't hold beyond what every adapter refuses; none when they can.
std::optional<Fault> refused_by_multibodies(const Scene& scene, const Settings& settings);

std::unique_ptr<rivals::World> make_multibody_world(const Scene& scene, const Settings& settings, bool observe);

}  // namespace atwood::bullet
