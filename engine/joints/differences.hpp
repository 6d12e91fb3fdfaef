// Derivatives of a tree's accelerations, and of one step of semi-implicit Euler's method, by differences: what duals
// (joints/derivatives.hpp) and the derivative functions of other engines are compared with.
//
//   forward  (f(x + s) - f(x)) / s            error s/2 f'' + (round-off of f) / s
//   central  (f(x + s) - f(x - s)) / (2 s)    error s^2/6 f''' + (round-off of f) / s
//
// In quad at s = 1e-10 a central difference is exact to about 1e-20.
#pragma once

#include <vector>

#include "joints/derivatives.hpp"
#include "math/scalar.hpp"
#include "scene/scene.hpp"

namespace atwood {

enum class DifferenceRule { forward, central };

// A state as Tree lays it out. `t_s` is the time of the motors; joints whose motion is prescribed are where the scene
// starts them.
struct TreeState {
  std::vector<int> offsets;
  int first_free = 0;
  std::vector<double> y;
  double t_s = 0;
};

// A row for each acceleration, a column for each rate.
template <class S>
std::vector<S> difference_derivatives(const Scene& scene, const TreeState& at, Along along, S step,
                                      DifferenceRule rule);

// Of the step of length h
//   (I + h M^-1 D) a' = a(q, u),   u' = u + h a',   q' = q moved by h u'
// with the joints' dampers D (MuJoCo's Euler takes them so; without dampers it is the plain step): 2 n x 2 n, first
// displacements, then rates; the displacement of an attitude is a turn in the body's axes.
std::vector<Quad> euler_step_derivatives(const Scene& scene, const TreeState& at, double h_s);

}  // namespace atwood
