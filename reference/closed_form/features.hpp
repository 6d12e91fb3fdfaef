// The features of a scene, by name. A scene with a feature that a closed form does not cover is refused before it is
// evaluated.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "scene/scene.hpp"

namespace atwood::closed_form {

// Bits: forces, properties of free bodies, contacts.
namespace feature {
enum Feature : std::uint64_t {
  bare_problem = 1ull << 0,
  uniform_gravity = 1ull << 1,
  mutual_gravity = 1ull << 2,
  attractor = 1ull << 3,
  linear_drag_force = 1ull << 4,
  quadratic_drag_force = 1ull << 5,
  spring = 1ull << 6,
  drive = 1ull << 7,
  lorentz_force = 1ull << 8,
  coulomb = 1ull << 9,
  thruster = 1ull << 10,
  point_force = 1ull << 11,
  rotating_frame = 1ull << 12,
  potential = 1ull << 13,
  late_release = 1ull << 14,
  spin = 1ull << 15,               // of a free body at the start
  moving_fixed_body = 1ull << 16,  // a fixed body with a velocity
  touching_shapes = 1ull << 17,    // two bodies have shapes, and one of them is free
  friction = 1ull << 18,           // of such a pair
  rolling_friction = 1ull << 19,
  linear_contact = 1ull << 20,
  hertz_contact = 1ull << 21,
  softening = 1ull << 22,      // of mutual gravity
  offset_spring = 1ull << 23,  // attached to a point other than the body's centre
  two_body_spring = 1ull << 24,
  angular_drag = 1ull << 25,
  convention = 1ull << 27,  // for simultaneous impacts, where two pairs could have them
  invalid = 1ull << 26,     // no scenario file has it: a free plane, a restitution above 1, a mass of 0
  fixed_joint = 1ull << 28,
  hinge = 1ull << 29,
  slider = 1ull << 30,
  cylindrical_joint = 1ull << 31,
  universal_joint = 1ull << 32,
  ball_joint = 1ull << 33,
  loop = 1ull << 34,  // a joint that closes one
  joint_limits = 1ull << 35,
  driven_joint = 1ull << 36,  // prescribed motion
  joint_stiffness = 1ull << 37,
  joint_damping = 1ull << 38,
  joint_torque = 1ull << 39,
  oscillating_torque = 1ull << 40,  // of a joint
  switched_torque = 1ull << 41,     // of a joint
  rope = 1ull << 42,
  pulley = 1ull << 43,
  pulley_inertia = 1ull << 44,
};

// Features of free translation and rotation.
constexpr std::uint64_t kFreeMotion = uniform_gravity | late_release | spin;
// Contacts with one impact at a time, for which the convention has no effect. (`ball-flights` follows the convention.)
constexpr std::uint64_t kSimpleContact = touching_shapes | friction | convention;
}  // namespace feature
using feature::Feature;
using Features = std::uint64_t;

// what: "the force `drag` on `ball`"
struct Present {
  Feature feature;
  std::string what;
};

// Reads every key of the scenario once; code with a new key in the scene does not compile until it is read here. Forces
// on fixed bodies only, contact laws of pairs without shapes, frames, and charges without a field have no effect and
// are not features.
std::vector<Present> features_of(const Scenario& scenario);

// The first feature that is not among `covered`, as a sentence; empty: all are covered.
std::string first_uncovered(const Scenario& scenario, Features covered);

}  // namespace atwood::closed_form
