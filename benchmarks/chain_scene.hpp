// A chain of equal links on hinges that hangs from the world under gravity, bent a little at every joint and moving.
#pragma once

#include <string>

#include "scene/scene.hpp"

namespace atwood {

// Links of 0.25 m and 1 kg. `planar`: all axes parallel, gravity across them; else axes alternate between x and z, and the
// motion fills space. Poses of the bodies are left at the origin: methods in joint coordinates place them.
inline Scene chain_scene(int links, bool planar) {
  Scene scene;
  scene.gravity_m_per_s2 = {0, -9.81, 0};
  scene.materials.push_back({"default", 0, 0, 0});
  scene.pairs.push_back({0, 0, 0, 0, 0});
  for (int i = 0; i < links; ++i) {
    Body body;
    body.name = "link-" + std::to_string(i + 1);
    body.mass_kg = 1;
    body.inertia_kg_m2 = {0.00390625, 0, 0, 0, 0.0009765625, 0, 0, 0, 0.00390625};
    scene.bodies.push_back(body);
    Joint joint;
    joint.name = "joint-" + std::to_string(i + 1);
    joint.parent = i - 1;
    joint.child = i;
    if (i > 0) joint.anchors_body_m[0] = {0, -0.125, 0};
    joint.anchors_body_m[1] = {0, 0.125, 0};
    joint.axis_body = planar || i % 2 == 0 ? Real3{0, 0, 1} : Real3{1, 0, 0};
    joint.coordinates[0] = 0.5 / links;
    joint.rates[0] = 0.25 / links;
    scene.joints.push_back(joint);
  }
  return scene;
}

}  // namespace atwood
