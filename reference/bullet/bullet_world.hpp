// One scene in one btDiscreteDynamicsWorld. Conventions of Bullet:
//   - angular velocity is in world axes, and the attitude is a matrix; samples convert both;
//   - inertia is diagonal: a body frame that is not principal is rotated into one (q_BP), and back in samples;
//   - shapes: see shapes.hpp; joints: see joints.hpp;
//   - Bullet multiplies the bodies' coefficients of restitution and friction; callbacks replace them by the pair's law;
//   - stepSimulation(h, 0) is one step of exactly h: symplectic Euler, v += h F/m, then x += h v.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "protocol/method.hpp"
#include "rivals/world.hpp"

struct btContactSolverInfo;

namespace atwood::bullet {

std::vector<Setting> settings();

// What Bullet can't hold beyond what every adapter refuses; none when it can.
std::optional<Fault> refusal(const Scene& scene, const Settings& settings);

void set_solver(btContactSolverInfo& info, const Settings& settings);

std::unique_ptr<rivals::World> make_world(const Scene& scene, const Settings& settings, bool observe);

}  // namespace atwood::bullet
