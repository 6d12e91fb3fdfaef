// Can what touches hold up a scene at rest? In double: it is a check, not a solution.
#pragma once

#include <string>

#include "scene/scene.hpp"

namespace atwood::closed_form {

struct Equilibrium {
  std::string misfit;  // which body nothing holds, what overlaps, what is not covered; empty: forces were found
  double open_m = 0;   // the widest gap or overlap that was taken for a touch: round-off of the scene's doubles
  double least_m = 0;  // the smallest extent of a body
};

// Boxes, spheres, fixed planes and rectangles under uniform gravity. Looks for contact forces within Coulomb's cones
// that balance every body to 1e-7 of its weight, by sweeps over the contacts (Moreau 1988). That some exist is what
// statics of rigid bodies can say: which ones act, and whether others could move the scene, it cannot.
Equilibrium find_equilibrium(const Scene& scene);

}  // namespace atwood::closed_form
