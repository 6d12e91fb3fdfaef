// Which laws of contact a scene can come to use.
#pragma once

#include <vector>

#include "scene/scene.hpp"

namespace atwood {

// Those of materials that two bodies with shapes have, at least one of them not fixed.
std::vector<PairLaw> laws_in_play(const Scene& scene);

}  // namespace atwood
