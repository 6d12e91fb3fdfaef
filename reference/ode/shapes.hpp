// A scene's shapes as ODE's geoms:
//   - a rectangle is a box of the least thickness in double (ODE ignores a box of zero thickness). A trimesh, the
//     alternative, computes in float and is one-sided;
//   - a convex shape is a dConvex with the triangles of its hull; its contact with a box has one point, and the box
//     sinks;
//   - a mesh is a trimesh, whose code computes in float at every precision of ODE;
//   - a compound is several box geoms at offsets on one body.
#pragma once

#include <ode/ode.h>

#include <memory>
#include <string>
#include <vector>

#include "scene/scene.hpp"

namespace atwood::ode {

// Creates geoms in a space (which destroys them) and owns the arrays that they refer to.
class Shapes {
 public:
  Shapes();
  ~Shapes();
  // The body's geoms, at the body's pose in the scene, or at their offsets on `on`; empty for a body without a shape.
  std::vector<dGeomID> make(dSpaceID space, const Body& body, dBodyID on);

 private:
  struct Hull;
  struct Triangles;
  std::vector<std::unique_ptr<Hull>> hulls_;
  std::vector<std::unique_ptr<Triangles>> meshes_;
};

// Why ODE does not have this shape; empty when it does.
std::string refused_shape(const Body& body);

}  // namespace atwood::ode
