#include "bullet/shapes.hpp"

#include <BulletCollision/CollisionDispatch/btInternalEdgeUtility.h>
#include <BulletCollision/CollisionShapes/btTriangleInfoMap.h>

#include <algorithm>

#include "rivals/vector.hpp"
#include "rivals/world.hpp"

namespace atwood::bullet {
namespace {

using rivals::operator*;

btScalar narrow(double x) { return static_cast<btScalar>(x); }
btVector3 narrow(const Real3& v) { return {narrow(v[0]), narrow(v[1]), narrow(v[2])}; }
btQuaternion narrow(const Real4& q) { return {narrow(q[1]), narrow(q[2]), narrow(q[3]), narrow(q[0])}; }

double safe_margin(const Real3& half_extents_m, double asked_m) {
  return std::min(asked_m, 0.1 * *std::min_element(half_extents_m.begin(), half_extents_m.end()));
}

}  // namespace

struct Shapes::Triangles {
  std::vector<btScalar> points;
  std::vector<int> corners;
  btTriangleIndexVertexArray array;
  btTriangleInfoMap edges;
};

Shapes::Shapes(double margin_m, bool smooth_inner_edges) : margin_m_(margin_m), smooth_(smooth_inner_edges) {}
Shapes::~Shapes() = default;

template <class T, class... Args> T* Shapes::keep(Args&&... args) {
  auto made = std::make_unique<T>(std::forward<Args>(args)...);
  T* shape = made.get();
  shapes_.push_back(std::move(made));
  return shape;
}

btCollisionShape* Shapes::speck() { return keep<btSphereShape>(narrow(1e-3)); }

btCollisionShape* Shapes::box(const Real3& half_extents_m) {
  auto* made = keep<btBoxShape>(narrow(half_extents_m));
  made->setMargin(narrow(safe_margin(half_extents_m, margin_m_)));
  return made;
}

btCollisionShape* Shapes::mesh(const Mesh& mesh) {
  triangles_.push_back(std::make_unique<Triangles>());
  Triangles& t = *triangles_.back();
  for (const auto& point : mesh.points_m) {
    for (const double x : point) t.points.push_back(narrow(x));
  }
  for (const auto& corners : mesh.triangles) t.corners.insert(t.corners.end(), corners.begin(), corners.end());
  btIndexedMesh part;
  part.m_numTriangles = static_cast<int>(mesh.triangles.size());
  part.m_triangleIndexBase = reinterpret_cast<const unsigned char*>(t.corners.data());
  part.m_triangleIndexStride = 3 * sizeof(int);
  part.m_numVertices = static_cast<int>(mesh.points_m.size());
  part.m_vertexBase = reinterpret_cast<const unsigned char*>(t.points.data());
  part.m_vertexStride = 3 * sizeof(btScalar);
  part.m_vertexType = sizeof(btScalar) == 8 ? PHY_DOUBLE : PHY_FLOAT;
  t.array.addIndexedMesh(part, PHY_INTEGER);
  auto* made = keep<btBvhTriangleMeshShape>(&t.array, true);
  if (smooth_) btGenerateInternalEdgeInfo(made, &t.edges);
  return made;
}

btCollisionShape* Shapes::make(const Shape& shape, const Real4& q_PB) {
  btCollisionShape* made = nullptr;
  if (const auto* sphere = std::get_if<Sphere>(&shape)) return keep<btSphereShape>(narrow(sphere->radius_m));
  if (const auto* plane = std::get_if<Plane>(&shape)) {
    const double norm = rivals::length(plane->normal);
    return keep<btStaticPlaneShape>(narrow((1 / norm) * plane->normal), narrow(plane->offset_m / norm));
  }
  if (const auto* compound = std::get_if<Compound>(&shape)) {
    auto* all = keep<btCompoundShape>();
    for (const auto& part : compound->boxes) {
      all->addChildShape(btTransform(narrow(rivals::product(q_PB, part.orientation_wxyz)).normalized(),
                                     narrow(rivals::to_world(q_PB, part.position_body_m))),
                         box(part.half_extents_m));
    }
    return all;
  }
  if (const auto* rectangle = std::get_if<Rectangle>(&shape)) {
    made = box({rectangle->half_extents_m[0], rectangle->half_extents_m[1], 0});
  } else if (const auto* cuboid = std::get_if<Box>(&shape)) {
    made = box(cuboid->half_extents_m);
  } else if (const auto* capsule = std::get_if<Capsule>(&shape)) {
    made = keep<btCapsuleShapeZ>(narrow(capsule->radius_m), narrow(2 * capsule->half_length_m));
  } else if (const auto* cylinder = std::get_if<Cylinder>(&shape)) {
    const Real3 half{cylinder->radius_m, cylinder->radius_m, cylinder->half_length_m};
    made = keep<btCylinderShapeZ>(narrow(half));
    made->setMargin(narrow(safe_margin(half, margin_m_)));
  } else if (const auto* convex = std::get_if<Convex>(&shape)) {
    auto* hull = keep<btConvexHullShape>();
    for (const auto& point : convex->points_m) hull->addPoint(narrow(point), false);
    hull->recalcLocalAabb();
    hull->setMargin(0);
    made = hull;
  } else if (const auto* triangles = std::get_if<Mesh>(&shape)) {
    made = mesh(*triangles);
  }
  if (!made || q_PB == Real4{1, 0, 0, 0}) return made;
  auto* turned = keep<btCompoundShape>();
  turned->addChildShape(btTransform(narrow(q_PB)), made);
  return turned;
}

std::string refused_shape(const Body& body) {
  if (!body.fixed && std::holds_alternative<Mesh>(body.shape)) {
    return "Bullet's mesh must be fixed (GImpact, its moving one, is left out): `" + body.name + "`";
  }
  return "";
}

}  // namespace atwood::bullet
