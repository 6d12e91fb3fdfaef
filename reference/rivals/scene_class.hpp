// The class of a scene, by features of its initial state. Settings that suit one class are bad for another, therefore
// the `tuned` presets have one set for each.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "scene/scene.hpp"

namespace atwood::rivals {

enum class SceneClass { free_flight, bounce, friction, stack, heap, mechanism };

// Tried in this order:
//   mechanism    joints or ropes connect bodies
//   free-flight  there are no two bodies with shapes, one of them movable
//   stack        2 to 128 movable bodies, all at rest at the start and no pair's law with restitution, of which two
//                touch
//   heap         gravity acts, and 16 movable bodies or more, under half of which touch a fixed body at the start; or
//                more than 128
//   friction     some pair's law has friction or rolling friction, and half of the movable bodies or more touch a fixed
//                one at the start
//   bounce       all others
// Touching: a gap of at most a thousandth of the smaller body's radius, by exact geometry where it covers the pair,
// else by bounding spheres. The class does not depend on the order of the bodies or on units.
SceneClass scene_class(const Scene& scene);

std::string to_string(SceneClass scene_class);                      // "free-flight", ...
std::optional<SceneClass> scene_class_of(const std::string& name);  // nothing: no such class
const std::vector<SceneClass>& all_scene_classes();

}  // namespace atwood::rivals
