// Driven joints that close loops. A prescribed motion takes no multiplier where its joint is one of the tree, so such a
// joint changes places with the one that places its child:
//   a driven joint with closes_loop = true places its child, and the joint that placed the child closes the loop.
#pragma once

#include <string>
#include <vector>

#include "scene/scene.hpp"

namespace atwood {

// Why the driven joint `joint`, which closes a loop, cannot place its child ("": it can). Throws MechanismError.
std::string obstacle_to_placing(const Scene& scene, int joint);

struct ExchangedJoints {
  int driven = -1, closing = -1;  // indices into Scene::joints; closing = -1: nothing placed the child
};
// Changes the places of all driven joints that close a loop and have no obstacle, in the scene's order. Coordinates
// stay as they are. Throws MechanismError.
std::vector<ExchangedJoints> let_driven_joints_place(Scene& scene);

}  // namespace atwood
