#include "dart/shapes.hpp"

#include <assimp/scene.h>

#include <dart/dynamics/BoxShape.hpp>
#include <dart/dynamics/CapsuleShape.hpp>
#include <dart/dynamics/CylinderShape.hpp>
#include <dart/dynamics/MeshShape.hpp>
#include <dart/dynamics/PlaneShape.hpp>
#include <dart/dynamics/SphereShape.hpp>
#include <limits>

#include "rivals/vector.hpp"
#include "rivals/world.hpp"

namespace atwood::dartsim {
namespace {

namespace dynamics = dart::dynamics;

std::shared_ptr<dynamics::Shape> box(const Real3& half_extents_m) {
  return std::make_shared<dynamics::BoxShape>(2 *
                                              Eigen::Vector3d(half_extents_m[0], half_extents_m[1], half_extents_m[2]));
}

// The MeshShape deletes the aiScene, which deletes what it points to.
std::shared_ptr<dynamics::Shape> mesh_shape(const Mesh& mesh) {
  auto* triangles = new aiMesh;
  triangles->mPrimitiveTypes = aiPrimitiveType_TRIANGLE;
  triangles->mNumVertices = static_cast<unsigned>(mesh.points_m.size());
  triangles->mVertices = new aiVector3D[mesh.points_m.size()];
  triangles->mNormals =
      new aiVector3D[mesh.points_m.size()];  // DART always copies them; only contacts of two meshes would use them
  for (std::size_t i = 0; i < mesh.points_m.size(); ++i) {
    const Real3& p = mesh.points_m[i];
    triangles->mVertices[i] =
        aiVector3D(static_cast<ai_real>(p[0]), static_cast<ai_real>(p[1]), static_cast<ai_real>(p[2]));
  }
  triangles->mNumFaces = static_cast<unsigned>(mesh.triangles.size());
  triangles->mFaces = new aiFace[mesh.triangles.size()];
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    triangles->mFaces[i].mNumIndices = 3;
    triangles->mFaces[i].mIndices = new unsigned[3];
    for (int k = 0; k < 3; ++k) triangles->mFaces[i].mIndices[k] = static_cast<unsigned>(mesh.triangles[i][k]);
  }
  auto* scene = new aiScene;
  scene->mNumMeshes = 1;
  scene->mMeshes = new aiMesh* [1] { triangles };
  scene->mRootNode = new aiNode;
  return std::make_shared<dynamics::MeshShape>(Eigen::Vector3d::Ones(), scene);
}

std::string quoted(const Body& body) {
  return std::string("a ") + rivals::shape_name(body.shape) + " (`" + body.name + "`)";
}

}  // namespace

std::vector<PlacedShape> shapes_of(const Body& body) {
  if (const auto* sphere = std::get_if<Sphere>(&body.shape)) {
    return {{std::make_shared<dynamics::SphereShape>(sphere->radius_m)}};
  }
  if (const auto* plane = std::get_if<Plane>(&body.shape)) {
    const double norm = rivals::length(plane->normal);
    const Eigen::Vector3d normal(plane->normal[0] / norm, plane->normal[1] / norm, plane->normal[2] / norm);
    return {{std::make_shared<dynamics::PlaneShape>(normal, plane->offset_m / norm)}};
  }
  if (const auto* r = std::get_if<Rectangle>(&body.shape)) {
    return {{box({r->half_extents_m[0], r->half_extents_m[1], std::numeric_limits<double>::min()})}};
  }
  if (const auto* cuboid = std::get_if<Box>(&body.shape)) return {{box(cuboid->half_extents_m)}};
  if (const auto* capsule = std::get_if<Capsule>(&body.shape)) {
    return {{std::make_shared<dynamics::CapsuleShape>(capsule->radius_m, 2 * capsule->half_length_m)}};
  }
  if (const auto* cylinder = std::get_if<Cylinder>(&body.shape)) {
    return {{std::make_shared<dynamics::CylinderShape>(cylinder->radius_m, 2 * cylinder->half_length_m)}};
  }
  if (const auto* mesh = std::get_if<Mesh>(&body.shape)) return {{mesh_shape(*mesh)}};
  std::vector<PlacedShape> parts;
  if (const auto* compound = std::get_if<Compound>(&body.shape)) {
    for (const auto& part : compound->boxes) {
      parts.push_back({box(part.half_extents_m), part.position_body_m, part.orientation_wxyz});
    }
  }
  return parts;
}

std::optional<Fault> refused_shape(const Body& body, const std::string& detector) {
  const Shape& shape = body.shape;
  if (std::holds_alternative<Convex>(shape))
    return Fault{"DART 6.12 has no convex hull shape; found one on `" + body.name + "`"};
  const auto* mesh = std::get_if<Mesh>(&shape);
  if (mesh && mesh->triangles.empty())
    return Fault{"DART requires meshes with triangles; found none in `" + body.name + "`"};
  const bool ball_or_boxes = std::holds_alternative<std::monostate>(shape) || std::holds_alternative<Sphere>(shape) ||
                             std::holds_alternative<Box>(shape) || std::holds_alternative<Compound>(shape);
  if (detector == "dart" && !ball_or_boxes)
    return Fault{"DART's own detector supports boxes and spheres only; found " + quoted(body)};
  if (detector == "fcl" && !ball_or_boxes && !mesh)
    return Fault{"DART does not convert this shape correctly for FCL: " + quoted(body)};
  return {};
}

}  // namespace atwood::dartsim
