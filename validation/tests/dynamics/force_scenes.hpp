// One scene per force, without symmetries that hide errors, for the tests of rates and invariants.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "scene/scene.hpp"

namespace atwood::force_scenes {

struct Case {
  std::string name;
  Scene scene;
  bool conservative = false;
  double t_s = 0.75;  // when its forces are looked at
};

inline Body body(int k, bool rotating) {
  Body made;
  made.name = "body" + std::to_string(k);
  made.mass_kg = 1.5 + 0.75 * k;
  made.charge_C = k % 2 == 0 ? 0.5 : -0.7;
  made.position_m = {0.3 + k, -0.4 * k, 0.2 + 0.5 * k};
  made.velocity_m_per_s = {0.5, 0.25 * k, -0.3};
  if (rotating) {
    made.inertia_kg_m2 = {0.6, 0.05, -0.02, 0.05, 0.8, 0.03, -0.02, 0.03, 1.0};
    if (k == 0) made.inertia_kg_m2 = {0.6, 0, 0, 0, 0.8, 0, 0, 0, 1.0};
    made.angular_velocity_body_rad_per_s = {0.3, -0.5, 0.7};
  }
  return made;
}

inline Scene bodies(int count, bool rotating) {
  Scene scene;
  scene.materials.push_back({"plain", 0, 0, 0});
  scene.pairs.push_back({0, 0, 0, 0, 0});
  for (int k = 0; k < count; ++k) scene.bodies.push_back(body(k, rotating));
  return scene;
}

inline std::vector<Case> all() {
  std::vector<Case> cases;
  const auto add = [&](std::string name, int count, bool rotating, bool conservative, Force force) {
    Scene scene = bodies(count, rotating);
    scene.forces.push_back(std::move(force));
    cases.push_back({std::move(name), std::move(scene), conservative});
  };
  Scene falling = bodies(2, true);
  falling.gravity_m_per_s2 = {0.3, -0.2, -9.8};
  cases.push_back({"uniform gravity", falling, true});
  cases.push_back({"free rotation", bodies(2, true), true});
  add("mutual gravity", 3, false, true, MutualGravity{{0, 1, 2}, 1.3, 0});
  add("softened gravity", 3, false, true, MutualGravity{{2, 0, 1}, 1.3, 0.4});
  add("attractor", 2, false, true, Attractor{{0, 1}, {0.1, 0.9, -1}, 2.5});
  add("linear drag", 2, true, false, LinearDrag{{0, 1}, 0.7, {1, -2, 0.5}, 0.3});
  add("quadratic drag", 2, true, false, QuadraticDrag{{1, 0}, 1.2, 0.47, 0.3, {1, -2, 0.5}, 0.2});
  add("anchored spring", 1, true, true, Spring{{0}, {2, 1, -1}, 7, 0, 0.8, {{0.2, -0.3, 0.4}}});
  add("spring without rest length", 1, true, true, Spring{{0}, {2, 1, -1}, 7, 0, 0, {}});
  add("damped spring", 1, true, false, Spring{{0}, {2, 1, -1}, 7, 0.6, 0.8, {{0.2, -0.3, 0.4}}});
  add("spring of two", 2, true, true, Spring{{0, 1}, {0, 0, 0}, 7, 0, 4, {{0.2, -0.3, 0.4}, {-0.5, 0.1, 0.3}}});
  add("damped spring of two", 2, true, false,
      Spring{{1, 0}, {0, 0, 0}, 7, 0.9, 0, {{0.2, -0.3, 0.4}, {-0.5, 0.1, 0.3}}});
  add("drive", 2, true, false, Drive{{0, 1}, {1, -2, 3}, 1.7, 0.4});
  add("lorentz", 2, true, true, Lorentz{{0, 1}, {0.3, -0.1, 0.5}, {0.2, 1.5, -0.4}});
  add("coulomb", 3, false, true, Coulomb{{0, 1, 2}, 2.1});
  add("thruster on", 1, true, false, Thruster{0, {0.1, -0.7, 0.3}, {0.6, 0, 0.8}, 12, {{0.5, 1}}});
  add("thruster off", 1, true, false, Thruster{0, {0.1, -0.7, 0.3}, {0.6, 0, 0.8}, 12, {{0, 0.5}, {1, 2}}});
  add("thruster always", 1, true, false, Thruster{0, {0.1, -0.7, 0.3}, {0.6, 0, 0.8}, 12, {}});
  add("point force", 2, true, true, PointForce{1, {0.1, -0.7, 0.3}, {3, -1, 2}, {}});
  add("point force in its time", 1, true, false, PointForce{0, {0.1, -0.7, 0.3}, {3, -1, 2}, {{0.25, 1.5}}});
  add("rotating frame", 2, false, true, RotatingFrame{{0.2, -0.3, 1}});
  add("henon-heiles", 1, false, true, Potential{{0}, "henon-heiles", {}});
  add("henon-heiles with lambda", 1, false, true, Potential{{0}, "henon-heiles", {{"lambda", 0.6}}});

  Scene pinned = bodies(3, false);  // a fixed and a held body pull, and are not pulled
  pinned.bodies[1].fixed = true;
  pinned.bodies[2].release_s = 1;
  pinned.forces = {MutualGravity{{0, 1, 2}, 1.3, 0}, Spring{{0, 2}, {0, 0, 0}, 3, 0.5, 0.2, {}}};
  cases.push_back({"fixed and held", pinned, false});
  return cases;
}

}  // namespace atwood::force_scenes
