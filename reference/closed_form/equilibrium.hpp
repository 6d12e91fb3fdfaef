// Can contact forces hold a scene at rest? A check in double, not a solution.
#pragma once

#include <string>

#include "scene/scene.hpp"

namespace atwood::closed_form {

struct Equilibrium {
  std::string refusal;  // why no equilibrium was found: a body that is not held, an overlap, a case that is not covered
  double largest_gap_m = 0;      // largest |gap| that was treated as a contact: round-off of the scene's doubles
  double smallest_extent_m = 0;  // smallest half extent or radius of a body
};

// Boxes, spheres, fixed planes and rectangles under uniform gravity. Searches contact forces within Coulomb's cones
// that balance every body to 1e-7 of its weight, by projected Gauss-Seidel sweeps over the contacts (J. J. Moreau,
// 1988). The statics of rigid bodies decides whether such forces exist, and neither which of them act nor whether the
// scene could also move. After 20000 sweeps without balance `refusal` names the body that moves fastest.
Equilibrium find_equilibrium(const Scene& scene);

}  // namespace atwood::closed_form
