// Mechanisms of the engine's tests.
#pragma once

#include <random>
#include <string>
#include <vector>

#include "scene/mechanism.hpp"
#include "scenes.hpp"

namespace atwood::testing {

// Bodies on joints get the poses and velocities that follow from the coordinates, rounded to double.
inline Scene placed(Scene scene) {
  const MechanismStart start = mechanism_start(scene);
  const std::vector<int> placing = placing_joints(scene);
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    if (placing[i] < 0) continue;
    for (int k = 0; k < 3; ++k) {
      scene.bodies[i].position_m[k] = static_cast<double>(start.bodies[i].p_m[k]);
      scene.bodies[i].velocity_m_per_s[k] = static_cast<double>(start.bodies[i].v_m_per_s[k]);
      scene.bodies[i].angular_velocity_body_rad_per_s[k] = static_cast<double>(start.bodies[i].w_rad_per_s[k]);
    }
    for (int k = 0; k < 4; ++k) scene.bodies[i].orientation_wxyz[k] = static_cast<double>(start.bodies[i].q_wxyz[k]);
  }
  return scene;
}

inline Body link(const std::string& name, double mass_kg, Real3 moments) {
  Body body = point(name, mass_kg, {0, 0, 0}, {0, 0, 0});
  body.inertia_kg_m2 = {moments[0], 0, 0, 0, moments[1], 0, 0, 0, moments[2]};
  return body;
}

inline Joint joint(const std::string& name, JointKind kind, int parent, int child, Real3 on_parent, Real3 on_child) {
  Joint made;
  made.name = name;
  made.kind = kind;
  made.parent = parent;
  made.child = child;
  made.anchors_body_m = {on_parent, on_child};
  made.axis_body = {0, 0, 1};
  made.coordinates = {kind == JointKind::ball ? 1.0 : 0.0, 0, 0, 0};
  return made;
}

// Rods of length 1 and mass 1 in a row below each other, hinged about z, gravity along -y; angles relative.
inline Scene hinge_chain(const std::vector<double>& angles, const std::vector<double>& rates = {}) {
  Scene scene = empty_scene();
  scene.gravity_m_per_s2 = {0, -9.81, 0};
  for (std::size_t i = 0; i < angles.size(); ++i) {
    const int n = static_cast<int>(i);
    scene.bodies.push_back(link("link." + std::to_string(n), 1, {1.0 / 12, 0.01, 1.0 / 12}));
    Joint hinge =
        joint("hinge." + std::to_string(n), JointKind::hinge, n - 1, n, {0, n == 0 ? 0 : -0.5, 0}, {0, 0.5, 0});
    hinge.coordinates[0] = angles[i];
    if (i < rates.size()) hinge.rates[0] = rates[i];
    scene.joints.push_back(hinge);
  }
  return placed(scene);
}

// A tree of `links` bodies with joints of all kinds on `roots` roots (the world, fixed bodies and free ones in turn),
// frames, axes, inertias and starts at random, and the bodies' order shuffled.
inline Scene random_tree(unsigned seed, int links, bool free_roots = true) {
  std::mt19937 random(seed);
  const auto real = [&](double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); };
  const auto vector = [&](double size) { return Real3{real(-size, size), real(-size, size), real(-size, size)}; };
  const auto unit = [&] {
    Real3 v = vector(1);
    const double n = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    return Real3{v[0] / n, v[1] / n, v[2] / n};
  };
  const auto quaternion = [&] {
    Real4 q{real(-1, 1), real(-1, 1), real(-1, 1), real(-1, 1)};
    const double n = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    return Real4{q[0] / n, q[1] / n, q[2] / n, q[3] / n};
  };
  Scene scene = empty_scene();
  scene.gravity_m_per_s2 = vector(9);
  for (int i = 0; i < links; ++i) {
    Body body = link("body." + std::to_string(i), real(0.3, 3), {});
    // Moments of a cloud of points: any such matrix is an inertia.
    for (int p = 0; p < 5; ++p) {
      const Real3 x = vector(0.4);
      const double square = x[0] * x[0] + x[1] * x[1] + x[2] * x[2];
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c)
          body.inertia_kg_m2[3 * r + c] += body.mass_kg / 5 * ((r == c) * square - x[r] * x[c]);
    }
    for (int r = 0; r < 3; ++r)  // symmetric to the last bit
      for (int c = 0; c < r; ++c) body.inertia_kg_m2[3 * r + c] = body.inertia_kg_m2[3 * c + r];
    scene.bodies.push_back(body);
  }
  scene.bodies.push_back(link("anvil", 0, {}));
  Body& anvil = scene.bodies.back();
  anvil.fixed = true;
  anvil.position_m = vector(2);
  anvil.orientation_wxyz = quaternion();
  const JointKind kinds[] = {JointKind::hinge,     JointKind::slider, JointKind::cylindrical,
                             JointKind::universal, JointKind::ball,   JointKind::fixed};
  for (int i = 0; i < links; ++i) {
    const int choice = std::uniform_int_distribution<int>(-1, i - 1)(random);
    int parent = choice;
    if (choice < 0) {
      const int root = static_cast<int>(random() % (free_roots ? 3 : 2));
      parent = root == 0 ? -1 : links;
      if (root == 2) {
        Body& body = scene.bodies[i];
        body.position_m = vector(2);
        body.orientation_wxyz = quaternion();
        body.velocity_m_per_s = vector(1);
        body.angular_velocity_body_rad_per_s = vector(1);
        continue;
      }
    }
    const JointKind kind = kinds[i < 6 ? i : random() % 6];
    Joint made = joint("joint." + std::to_string(i), kind, parent, i, vector(0.5), vector(0.5));
    made.axis_body = unit();
    made.axes_body = {unit(), unit()};
    made.frame_wxyz = quaternion();
    for (int k = 0; k < coordinate_count(kind); ++k) made.coordinates[k] = real(-1.2, 1.2);
    if (kind == JointKind::ball) made.coordinates = quaternion();
    for (int k = 0; k < rate_count(kind); ++k) made.rates[k] = real(-1.5, 1.5);
    scene.joints.push_back(made);
  }
  std::shuffle(scene.joints.begin(), scene.joints.end(), random);
  return placed(scene);
}

}  // namespace atwood::testing
