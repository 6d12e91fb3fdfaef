// Small mechanisms for tests.
#pragma once

#include <string>

#include "scene/scene.hpp"

namespace atwood {

inline Scenario mechanism_scenario(double t_end_s) {
  Scenario made;
  made.t_end_s = t_end_s;
  made.scene.materials.emplace_back();
  made.scene.pairs.emplace_back();
  made.scene.gravity_m_per_s2 = {0, 0, -9.81};
  return made;
}

inline Body solid(const std::string& name, double mass_kg, double inertia_kg_m2) {
  Body body;
  body.name = name;
  body.mass_kg = mass_kg;
  body.inertia_kg_m2 = {inertia_kg_m2, 0, 0, 0, inertia_kg_m2, 0, 0, 0, inertia_kg_m2};
  return body;
}

// About y; angle 0: both bodies' axes alike.
inline Joint hinge(int parent, int child, const Real3& at_parent, const Real3& at_child, double angle, double rate) {
  Joint joint;
  joint.name = "hinge-" + std::to_string(parent) + "-" + std::to_string(child);
  joint.kind = JointKind::hinge;
  joint.parent = parent;
  joint.child = child;
  joint.anchors_body_m = {at_parent, at_child};
  joint.axis_body = {0, 1, 0};
  joint.coordinates[0] = angle;
  joint.rates[0] = rate;
  return joint;
}

inline Body point_mass(const std::string& name, double mass_kg, const Real3& at) {
  Body body;
  body.name = name;
  body.mass_kg = mass_kg;
  body.position_m = at;
  return body;
}

// Two rods of length 1 m that hang from the origin.
inline Scenario double_pendulum(double t_end_s, double first, double second) {
  Scenario made = mechanism_scenario(t_end_s);
  made.scene.bodies = {solid("upper", 1, 0.1), solid("lower", 1.5, 0.125)};
  made.scene.joints = {hinge(-1, 0, {}, {0, 0, 0.5}, first, 0), hinge(0, 1, {0, 0, -0.5}, {0, 0, 0.5}, second, 0)};
  return made;
}

// Four bars: a crank, a coupler and a rocker of unequal lengths, the ground 1 m long; `cut`: which of the hinges closes
// the loop: 0 between coupler and rocker, 1 the rocker's on the ground, 2 between crank and coupler. Assembled by the
// projection of the start.
inline Scenario four_bar(double t_end_s, int cut) {
  Scenario made = mechanism_scenario(t_end_s);
  made.scene.bodies = {solid("crank", 1, 0.02), solid("coupler", 2, 0.2), solid("rocker", 1.5, 0.1)};
  // Crank of 0.4 m at x = 0, rocker of 0.9 m at x = 1; bodies' z axes along the bars, the coupler's x axis.
  Joint ground_crank = hinge(-1, 0, {0, 0, 0}, {0, 0, -0.2}, 0.3, 2);
  Joint crank_coupler = hinge(0, 1, {0, 0, 0.2}, {-0.5, 0, 0}, -0.5, 0);
  Joint ground_rocker = hinge(-1, 2, {1, 0, 0}, {0, 0, -0.45}, 0.2, 0);
  Joint coupler_rocker = hinge(1, 2, {0.5, 0, 0}, {0, 0, 0.45}, 0.4, 0);
  if (cut == 2) {
    crank_coupler.closes_loop = crank_coupler.assemble = true;
    const Joint rocker_coupler = hinge(2, 1, {0, 0, 0.45}, {0.5, 0, 0}, -0.4, 0);
    made.scene.joints = {ground_crank, ground_rocker, rocker_coupler, crank_coupler};
  } else if (cut == 0) {
    coupler_rocker.closes_loop = coupler_rocker.assemble = true;
    made.scene.joints = {ground_crank, crank_coupler, ground_rocker, coupler_rocker};
  } else {
    ground_rocker.closes_loop = ground_rocker.assemble = true;
    made.scene.joints = {ground_crank, crank_coupler, coupler_rocker, ground_rocker};
  }
  return made;
}

}  // namespace atwood
