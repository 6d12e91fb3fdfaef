// A scene's shapes as Bullet's:
//   - a rectangle is a box without thickness (Bullet's btBox2dShape is for two-dimensional worlds);
//   - the collision margin of a box and a cylinder is inside of the shape; Bullet uses the requested margin, or a tenth
//     of the least half extent if that is smaller. The margin of a hull is outside, so that the hull is enlarged by it;
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

struct Margins {
  double inside_m = 0.04, hull_m = 0.04;
};

// Makes shapes and owns them, with the numbers that they refer to.
class Shapes {
 public:
  Shapes(const Margins& margins, bool smooth_inner_edges);
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
  Margins margins_;
  bool smooth_ = false;
  std::vector<std::unique_ptr<Triangles>> triangles_;  // outlive the shapes
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
};

// Why Bullet has no such shape; empty when it has.
std::string refused_shape(const Body& body);

}  // namespace atwood::bullet
