// A scene's shapes as Bullet's:
//   - a rectangle is a box without thickness (Bullet's btBox2dShape is for two-dimensional worlds);
//   - the collision margin of a box and a cylinder is inside of the shape; Bullet uses the requested margin, or a tenth
//     of the least half extent if that is smaller;
//   - Bullet adds the margin of a hull outside of its points, which would enlarge it. It is 0: points moved inwards by
//     a margin would rest as steadily, but on a smaller base (a triangle of 1 m with 25 mm: yaw 7 % too large as it
//     stops);
//   - a mesh is a btBvhTriangleMeshShape, which must be fixed; without smoothing, its inner edges stop sliding bodies;
//   - a compound is a btCompoundShape of boxes.
#pragma once

#include <btBulletDynamicsCommon.h>

#include <memory>
#include <string>
#include <vector>

#include "scene/scene.hpp"

class btTriangleInfoMap;

namespace atwood::bullet {

// Makes shapes and owns them, with the numbers that they refer to.
class Shapes {
 public:
  Shapes(double margin_m, bool smooth_inner_edges);
  ~Shapes();
  // `q_PB`: body axes from the principal axes that Bullet's body frame is. Null for no shape, and for a plane when it
  // moves.
  btCollisionShape* make(const Shape& shape, const Real4& q_PB);
  btCollisionShape* speck();  // of a body that nothing touches

 private:
  template <class T, class... Args> T* keep(Args&&... args);
  btCollisionShape* mesh(const Mesh& mesh);
  btCollisionShape* box(const Real3& half_extents_m);

  struct Triangles;
  double margin_m_ = 0;  // of boxes and cylinders
  bool smooth_ = false;
  std::vector<std::unique_ptr<Triangles>> triangles_;  // outlive the shapes
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
};

// Why Bullet has no such shape; empty when it has.
std::string refused_shape(const Body& body);

}  // namespace atwood::bullet
