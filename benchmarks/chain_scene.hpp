// Mechanisms of any number of links: a chain of equal links on hinges that hangs from the world under gravity, bent a
// little at every joint and moving; four-bars in a row.
#pragma once

#include <string>

#include "scene/scene.hpp"

namespace atwood {

// Links of 0.25 m and 1 kg. `planar`: all axes parallel, gravity across them; else axes alternate between x and z, and
// the motion fills space. Poses of the bodies are left at the origin: methods in joint coordinates place them.
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

// Four-bars in a row: loops + 1 rods of 1 m and 1 kg stand side by side on hinges, and `loops` couplers join their
// tips, each closed by a hinge. All rods lean by 0.4 rad and turn at 1 rad/s. 2 loops + 1 links, one degree of freedom.
inline Scene four_bar_scene(int loops) {
  Scene scene = chain_scene(0, true);
  const auto rod = [&](const std::string& name, Real3 moments) {
    Body body;
    body.name = name;
    body.mass_kg = 1;
    body.inertia_kg_m2 = {moments[0], 0, 0, 0, moments[1], 0, 0, 0, moments[2]};
    scene.bodies.push_back(body);
  };
  const auto hinge = [&](const std::string& name, int parent, int child, Real3 on_parent, Real3 on_child, double side) {
    Joint joint;
    joint.name = name;
    joint.parent = parent;
    joint.child = child;
    joint.anchors_body_m = {on_parent, on_child};
    joint.axis_body = {0, 0, 1};
    joint.coordinates[0] = 0.4 * side;
    joint.rates[0] = side;
    scene.joints.push_back(joint);
  };
  const double moment = 1.0 / 12, thin = 1.0 / 1024;
  for (int i = 0; i <= loops; ++i) rod("bar-" + std::to_string(i), {moment, thin, moment});
  for (int i = 0; i < loops; ++i) rod("coupler-" + std::to_string(i), {thin, moment, moment});
  for (int i = 0; i <= loops; ++i)
    hinge("foot-" + std::to_string(i), -1, i, {static_cast<double>(i), 0, 0}, {0, -0.5, 0}, -1);
  for (int i = 0; i < loops; ++i) hinge("left-" + std::to_string(i), i, loops + 1 + i, {0, 0.5, 0}, {-0.5, 0, 0}, 1);
  for (int i = 0; i < loops; ++i) {
    hinge("right-" + std::to_string(i), loops + 1 + i, i + 1, {0.5, 0, 0}, {0, 0.5, 0}, -1);
    scene.joints.back().closes_loop = true;
  }
  return scene;
}

}  // namespace atwood
