// The engine that this executable was built with, and what its presets claim on mechanisms.
#pragma once

#include <string>
#include <vector>

#include "protocol/method.hpp"

namespace atwood::test {

struct Scheme {
  std::string name;
  bool accurate = false;       // of order 2 or more: errors of small steps are below 1e-9
  bool semi_implicit = false;  // u += h q''(q, u), q += h u, in the joints' coordinates
  bool reactions = true;
  double error = 1e-10;  // of an accurate scheme on the pendulum [rad, 10 rad/s]
  bool steps_chosen = false;
  double gap = 1e-3;          // of a closing joint after 0.1 s [m, rad]
  double kinematics = 1e-12;  // poses against coordinates [m, rad, m/s, rad/s]
  double reordered = 1e-9;    // relative change when bodies and joints stand in another order
  bool forces_held = false;   // springs and motors keep their values through a step
};

Engine engine_under_test();
std::vector<Scheme> schemes_under_test();
int chains_taken();  // of the five chains of kinds, how many the engine takes
std::vector<JointKind> closings_taken();
bool reacts_in_loops();  // and of prescribed rates
bool drives();           // hinges and sliders of a prescribed rate
bool stops();            // limits without restitution
bool hangs();            // ropes over points

}  // namespace atwood::test
