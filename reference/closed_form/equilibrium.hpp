// Can contact forces hold a scene at rest? A check in double, not a solution.
#pragma once

#include <string>

#include "scene/scene.hpp"

namespace atwood::closed_form {

constexpr double kBalanced = 1e-7;  // of gravity: what the search leaves of a weight

struct Equilibrium {
  std::string refusal;  // why no equilibrium was found: a body that is not held, an overlap, a case that is not covered
  double largest_gap_m = 0;      // largest distance that was treated as a contact: round-off of the scene's doubles
  double smallest_extent_m = 0;  // smallest half extent or radius of a body
  double unheld_m_per_s2 = 0;    // along slopes within round-off that friction does not hold, and of balls
};

// Boxes, spheres, fixed planes and rectangles under uniform gravity. Searches contact forces within Coulomb's cones
// that balance every body to 1e-7 of its weight, by projected Gauss-Seidel sweeps over the contacts (J. J. Moreau,
// 1988). The search reduces each coefficient of friction by a margin above its accuracy. Where friction exceeds the
// slope by less than that margin, forces along gravity alone are tried, for which slope and friction are compared in
// quad. The statics
// of rigid bodies decides whether such forces exist, and neither which of them act nor whether the scene could also
// move. After 20000 sweeps without balance `refusal` names the body that moves fastest.
Equilibrium find_equilibrium(const Scene& scene);

}  // namespace atwood::closed_form
