// Many boxes in free flight, the same for every engine.
#pragma once

#include <string>

#include "scene/scene.hpp"
#include "scene/split_mix.hpp"

// Alternating boxes of three kinds, each with three different moments of inertia; velocities within 1 m/s and body
// rates within 3 rad/s in each axis; uniform gravity. Without shapes, so that no engine searches for contacts.
inline atwood::Scene free_flight_scene(int bodies) {
  atwood::Scene scene;
  scene.materials.push_back({"default", 0, 0, 0});
  scene.gravity_m_per_s2 = {0, 0, -9.8};
  const atwood::Real3 moments[] = {{0.1, 0.2, 0.25}, {0.3, 0.15, 0.2}, {0.12, 0.1, 0.17}};
  atwood::SplitMix64 random{2026};
  const auto within = [&](double half) { return half * (2 * random.next_unit() - 1); };
  for (int i = 0; i < bodies; ++i) {
    atwood::Body body;
    body.name = "box." + std::to_string(i);
    body.mass_kg = 1;
    const auto& I = moments[i % 3];
    body.inertia_kg_m2 = {I[0], 0, 0, 0, I[1], 0, 0, 0, I[2]};
    for (double& x : body.position_m) x = within(50);
    for (double& v : body.velocity_m_per_s) v = within(1);
    for (double& w : body.angular_velocity_body_rad_per_s) w = within(3);
    scene.bodies.push_back(body);
  }
  return scene;
}
