// MuJoCo's own derivatives of its discrete step, mjd_transitionFD, of a scene's mechanisms.
//
// It differentiates the step (q, v) -> (q', v') by differences with a step that the caller chooses, `flg_centered` one-
// or two-sided; a row and a column is a displacement or a rate, of an attitude in the body's axes. MuJoCo 2.2 offers it
// for its semi-implicit Euler and its implicit integrator; here it is Euler, with every option at its default.
#pragma once

#include <string>
#include <vector>

#include "scene/scene.hpp"

namespace atwood::mujoco {

struct Transition {
  double step = 0;  // of the difference
  bool centred = false;
  // Square: displacements, then rates; of bodies that float, then of joints, in the scene's order.
  std::vector<double> matrix;
};
struct Transitions {
  std::string refusal;  // why there are none; empty: there are
  std::vector<Transition> all;
};

// At the scene's start, of a step of h_s, for each step of the differences, forward and centred.
Transitions transitions(const Scene& scene, double h_s, const std::vector<double>& steps);

}  // namespace atwood::mujoco
