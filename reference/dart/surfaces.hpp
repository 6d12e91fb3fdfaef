// Laws of pairs from DART's coefficients of shapes: the restitution of a contact is the product of the two shapes', its
// friction the lesser of the two. When all pairs of a scene have the same law, all shapes have the same coefficients.
// Otherwise a body has its shape once for each material that it can touch, and a shape collides only with the shapes
// made for its material; the two coefficients then give exactly the law of the pair.
#pragma once

#include <string>
#include <vector>

#include "scene/scene.hpp"

namespace atwood::dartsim {

struct Surface {
  int partner = -1;  // the material of the other body; -1: all
  double restitution = 0, friction = 0;
};

// The surfaces of a body of this material; empty when it can touch no body.
std::vector<Surface> surfaces_of(int material, const std::vector<PairLaw>& laws);

// Why DART cannot represent these laws (coefficients of 0.001 or less are zero, there is no rolling friction); empty
// when it can.
std::string refused_law(const std::vector<PairLaw>& laws);

}  // namespace atwood::dartsim
