// What bodies lie on, slide on and roll on: one fixed plane, or a mesh that is flat.
#pragma once

#include <string>
#include <vector>

#include "closed_form/solution.hpp"

namespace atwood::closed_form {

template <class S> struct Floor {
  std::string misfit;
  int body = -1;
  Vec<S> n{};                                   // unit, upwards: against gravity
  S offset{};                                   // n . x on the floor
  S g_n{};                                      // gravity into the floor
  S dropped{};                                  // gravity along a floor that is taken for level
  Vec<S> g_t{};                                 // gravity along it
  S flat{};                                     // how far from flat a mesh is
  std::vector<std::array<Vec<double>, 2>> rim;  // edges of one triangle only; none: the floor has no end
};

// The one fixed body with a shape, under a gravity that presses onto it.
template <class S> Floor<S> find_floor(const Scene& scene);

// How a body lies on the floor: its centre's height over it, and what its doubles leave open.
template <class S> struct Stance {
  std::string misfit;
  S height{};        // of the centre of mass over the contact
  Vec<S> side[2]{};  // of a box: its edges along the floor, world axes
  S half[2]{};
  Vec<S> axis{};                // of a cylinder, world axes
  S slack_m{}, tilt{}, rise{};  // rise: speed off the floor
  double reach_m = 0;           // no point of it is farther from its centre
};
// Boxes on a face, spheres, cylinders on their side; in touch with the floor, moving along it.
template <class S> Stance<S> stand_on(const Floor<S>& floor, const Scene& scene, int body);

// Empty, or that the way from `from` to `to` with `reach_m` around it leaves the floor.
template <class S>
std::string leaves(const Floor<S>& floor, const Scene& scene, const Vec<double>& from, const Vec<double>& to,
                   double reach_m);

}  // namespace atwood::closed_form
