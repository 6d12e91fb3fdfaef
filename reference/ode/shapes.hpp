// A scene's shapes as ODE's geoms. What differs from one engine to the next, said here:
//   - a rectangle is a box of the least thickness that a double holds (one of none ODE passes over): a trimesh, the
//   other
//     choice, computes in float and has one side;
//   - a convex shape is a dConvex over the triangles of its hull; with a box it meets in one point, and the box sinks;
//   - a mesh is a trimesh, whose insides are float whatever ODE's precision;
//   - a compound is several box geoms at offsets on one body.
#pragma once

#include <ode/ode.h>

#include <memory>
#include <string>
#include <vector>

#include "scene/scene.hpp"

namespace atwood::ode {

// Makes geoms in a space (which destroys them) and owns the numbers that they refer to.
class Shapes {
 public:
  Shapes();
  ~Shapes();
  // The body's geoms, at the body's pose in the scene, or at their offsets on `on`; none for no shape.
  std::vector<dGeomID> make(dSpaceID space, const Body& body, dBodyID on);

 private:
  struct Hull;
  struct Triangles;
  std::vector<std::unique_ptr<Hull>> hulls_;
  std::vector<std::unique_ptr<Triangles>> meshes_;
};

// Why ODE has no such shape; empty when it has.
std::string refused_shape(const Body& body);

}  // namespace atwood::ode
