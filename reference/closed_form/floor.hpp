// The floor on which bodies lie, slide and roll: one fixed plane, or a flat mesh.
#pragma once

#include <string>
#include <vector>

#include "closed_form/solution.hpp"

namespace atwood::closed_form {

template <class S> struct Floor {
  std::string refusal;
  int body = -1;
  Vec<S> n{};                                        // unit, upwards: against gravity
  S offset{};                                        // n . x on the floor
  S g_n{};                                           // [m/s^2] gravity component into the floor
  S neglected{};                                     // [m/s^2] gravity component along a floor that is treated as level
  Vec<S> g_t{};                                      // gravity component along the floor
  S unevenness{};                                    // [m] largest distance of a mesh vertex from the plane
  std::vector<std::array<Vec<double>, 2>> boundary;  // edges of one triangle only; empty: the floor is infinite
};

// The only fixed body with a shape; gravity must press onto it, otherwise `refusal` says what was found.
template <class S> Floor<S> find_floor(const Scene& scene);

// How a body lies on the floor. The scene's doubles satisfy this to round-off only; the errors are included.
template <class S> struct FloorContact {
  std::string refusal;
  S height{};        // [m] of the centre of mass over the contact
  Vec<S> side[2]{};  // of a box: its axes along the floor, world axes
  S half[2]{};
  Vec<S> axis{};                            // of a cylinder, world axes
  S gap_error_m{}, tilt{}, normal_speed{};  // round-off: gap, angle, speed along the normal
  double extent_m = 0;                      // bound of the distance of its points from its centre
};
// Boxes on a face, spheres, cylinders on their side, in contact with the floor and moving along it. Anything else is
// refused.
template <class S> FloorContact<S> floor_contact(const Floor<S>& floor, const Scene& scene, int body);

// The refusal of a path from `from` to `to` that comes within `extent_m` of the boundary of the floor; empty: it does
// not.
template <class S>
std::string leaves_floor(const Floor<S>& floor, const Scene& scene, const Vec<double>& from, const Vec<double>& to,
                         double extent_m);

}  // namespace atwood::closed_form
