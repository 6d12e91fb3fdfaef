// A pair's law out of what DART lets a shape say: its restitution is the product of the two shapes', its friction the
// lesser of the two. Where all pairs of a scene have one law, every shape says the same. Where they differ, a body has
// its shape once for each material that it can meet, and a shape meets only those that were made for its own material:
// then the two together say the pair's law and nothing else.
#pragma once

#include <string>
#include <vector>

#include "scene/scene.hpp"

namespace atwood::dartsim {

struct Surface {
  int partner = -1;  // the material that it is for; -1: all
  double restitution = 0, friction = 0;
};

// Of a body of this material; empty where it can meet nothing.
std::vector<Surface> surfaces_of(int material, const std::vector<PairLaw>& laws);

// DART takes a coefficient of 0.001 or less for none, and has no rolling friction; empty when it can hold these laws.
std::string refused_law(const std::vector<PairLaw>& laws);

}  // namespace atwood::dartsim
