// A scene's shapes as DART's, for the collision detectors that support them:
//   - ode: ODE 0.16 in double. A rectangle is a box of the least thickness. A mesh has vertices in float (assimp's) and
//     is one-sided; two meshes do not collide, because DART gives ODE vertex normals where it expects face normals;
//   - fcl: FCL 0.7 on triangles for every shape: a sphere is a polyhedron. A plane would be an upright box and is
//     refused;
//   - dart: boxes and spheres only.
// DART 6.12 has no convex hull for any of them.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "protocol/fault.hpp"
#include "scene/scene.hpp"

namespace dart::dynamics {
class Shape;
}

namespace atwood::dartsim {

// A shape with its pose in body axes. A plane's pose is in world axes; its body is at the origin.
struct PlacedShape {
  std::shared_ptr<dart::dynamics::Shape> shape;
  Real3 p_B{};
  Real4 q_B{1, 0, 0, 0};
};

std::vector<PlacedShape> shapes_of(const Body& body);  // empty for a body without a shape

// Why this detector does not support the body's shape; none when it does.
std::optional<Fault> refused_shape(const Body& body, const std::string& detector);

}  // namespace atwood::dartsim
