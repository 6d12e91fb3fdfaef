// A scene's shapes as DART's, for the detectors that really collide them:
//   - ode: ODE 0.16 in double. A rectangle is a box of the least thickness; a mesh has corners in float (assimp's), and
//   one
//     side; two meshes don't meet: DART hands ODE normals of corners where it wants those of faces;
//   - fcl: FCL 0.7 over triangles, whatever the shape was: a ball is a polyhedron. A plane would be an upright box:
//   refused;
//   - dart: boxes and balls only.
// DART 6.12 has no convex hull for any of them.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "scene/scene.hpp"

namespace dart::dynamics {
class Shape;
}

namespace atwood::dartsim {

// At a pose in body axes. A plane's is in world axes: its body stands at the origin.
struct PlacedShape {
  std::shared_ptr<dart::dynamics::Shape> shape;
  Real3 p_B{};
  Real4 q_B{1, 0, 0, 0};
};

std::vector<PlacedShape> shapes_of(const Body& body);  // none for no shape

// Why this detector doesn't collide the body's shape; empty when it does.
std::string refused_shape(const Body& body, const std::string& detector);

}  // namespace atwood::dartsim
