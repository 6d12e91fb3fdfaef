// Everything that a scene holds, named: what a closed form does not take is refused before it solves anything.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "scene/scene.hpp"

namespace atwood::closed_form {

// Bits. What acts on a body, what a free body is, what may touch, how the run is made.
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
  spin = 1ull << 15,             // of a free body at the start
  moving_wall = 1ull << 16,      // a fixed body with a velocity
  touching_shapes = 1ull << 17,  // two bodies have shapes, and one of them is free
  friction = 1ull << 18,         // of such a pair
  rolling_friction = 1ull << 19,
  linear_contact = 1ull << 20,
  hertz_contact = 1ull << 21,
  softening = 1ull << 22,      // of mutual gravity
  offset_spring = 1ull << 23,  // fastened beside a body's centre
  two_body_spring = 1ull << 24,
  angular_drag = 1ull << 25,
  convention = 1ull << 27,  // for simultaneous impacts, where two pairs could have them
  impossible = 1ull << 26,  // what no file can hold: a free plane, a restitution above 1, a mass of 0
};

// Those of translation and turning alone.
constexpr std::uint64_t kFlying = uniform_gravity | late_release | spin;
// One contact each at a time, or none that is struck: no convention decides anything. `ball-flights` follows it.
constexpr std::uint64_t kTouching = touching_shapes | friction | convention;
}  // namespace feature
using feature::Feature;
using Features = std::uint64_t;

// what: "the force `drag` on `ball`"
struct Present {
  Feature feature;
  std::string what;
};

// Reads every key of the scenario, each once: a key that is added to the scene does not compile until it is read here.
// Forces on fixed bodies alone, laws of pairs of which none has a shape, frames and charges without a field have no
// effect and are no feature.
std::vector<Present> features_of(const Scenario& scenario);

// Empty, or the first feature that is not among `taken`, in words.
std::string not_taken(const Scenario& scenario, Features taken);

}  // namespace atwood::closed_form
