#include "ode/shapes.hpp"

#include <limits>

#include "rivals/vector.hpp"
#include "rivals/world.hpp"
#include "scene/inertia.hpp"

namespace atwood::ode {
namespace {

using rivals::operator*;
using rivals::operator+;
using rivals::operator-;

void place(dGeomID geom, const Real3& p_m, const Real4& q) {
  const dQuaternion turn{q[0], q[1], q[2], q[3]};
  dGeomSetPosition(geom, p_m[0], p_m[1], p_m[2]);
  dGeomSetQuaternion(geom, turn);
}

void place_on(dGeomID geom, dBodyID on, const Real3& p_m, const Real4& q) {
  const dQuaternion turn{q[0], q[1], q[2], q[3]};
  dGeomSetBody(geom, on);
  dGeomSetOffsetPosition(geom, p_m[0], p_m[1], p_m[2]);
  dGeomSetOffsetQuaternion(geom, turn);
}

dGeomID box(dSpaceID space, const Real3& half_extents_m) {
  const Real3 full = 2.0 * half_extents_m;
  return dCreateBox(space, full[0], full[1], full[2]);
}

}  // namespace

struct Shapes::Hull {
  std::vector<dReal> planes, points;
  std::vector<unsigned> polygons;  // a count, then that many corners
};

struct Shapes::Triangles {
  std::vector<double> points;
  std::vector<dTriIndex> corners;
  dTriMeshDataID data = dGeomTriMeshDataCreate();
  ~Triangles() { dGeomTriMeshDataDestroy(data); }
};

Shapes::Shapes() = default;
Shapes::~Shapes() = default;

std::vector<dGeomID> Shapes::make(dSpaceID space, const Body& body, dBodyID on) {
  dGeomID geom = nullptr;
  if (const auto* sphere = std::get_if<Sphere>(&body.shape)) {
    geom = dCreateSphere(space, sphere->radius_m);
  } else if (const auto* plane = std::get_if<Plane>(&body.shape)) {
    const double norm = rivals::length(plane->normal);
    const Real3 n = (1 / norm) * plane->normal;
    return {dCreatePlane(space, n[0], n[1], n[2], plane->offset_m / norm)};
  } else if (const auto* rectangle = std::get_if<Rectangle>(&body.shape)) {
    geom = box(space, {rectangle->half_extents_m[0], rectangle->half_extents_m[1], std::numeric_limits<double>::min()});
  } else if (const auto* cuboid = std::get_if<Box>(&body.shape)) {
    geom = box(space, cuboid->half_extents_m);
  } else if (const auto* capsule = std::get_if<Capsule>(&body.shape)) {
    geom = dCreateCapsule(space, capsule->radius_m, 2 * capsule->half_length_m);
  } else if (const auto* cylinder = std::get_if<Cylinder>(&body.shape)) {
    geom = dCreateCylinder(space, cylinder->radius_m, 2 * cylinder->half_length_m);
  } else if (const auto* convex = std::get_if<Convex>(&body.shape)) {
    hulls_.push_back(std::make_unique<Hull>());
    Hull& h = *hulls_.back();
    for (const auto& point : convex->points_m) h.points.insert(h.points.end(), point.begin(), point.end());
    for (const auto& t : convex_hull(convex->points_m)) {
      const Real3 &a = convex->points_m[t[0]], &b = convex->points_m[t[1]], &c = convex->points_m[t[2]];
      const Real3 across = rivals::cross(b - a, c - a), n = (1 / rivals::length(across)) * across;
      h.planes.insert(h.planes.end(), {n[0], n[1], n[2], rivals::dot(n, a)});
      h.polygons.insert(h.polygons.end(), {3u, unsigned(t[0]), unsigned(t[1]), unsigned(t[2])});
    }
    geom = dCreateConvex(space, h.planes.data(), static_cast<unsigned>(h.planes.size() / 4), h.points.data(),
                         static_cast<unsigned>(convex->points_m.size()), h.polygons.data());
  } else if (const auto* mesh = std::get_if<Mesh>(&body.shape)) {
    meshes_.push_back(std::make_unique<Triangles>());
    Triangles& t = *meshes_.back();
    for (const auto& point : mesh->points_m) t.points.insert(t.points.end(), point.begin(), point.end());
    for (const auto& corners : mesh->triangles) {
      for (const int corner : corners) t.corners.push_back(static_cast<dTriIndex>(corner));
    }
    dGeomTriMeshDataBuildDouble(t.data, t.points.data(), 3 * sizeof(double), static_cast<int>(mesh->points_m.size()),
                                t.corners.data(), static_cast<int>(t.corners.size()), 3 * sizeof(dTriIndex));
    geom = dCreateTriMesh(space, t.data, nullptr, nullptr, nullptr);
  } else if (const auto* compound = std::get_if<Compound>(&body.shape)) {
    std::vector<dGeomID> parts;
    for (const auto& part : compound->boxes) {
      parts.push_back(box(space, part.half_extents_m));
      if (on) {
        place_on(parts.back(), on, part.position_body_m, part.orientation_wxyz);
      } else {
        place(parts.back(), body.position_m + rivals::to_world(body.orientation_wxyz, part.position_body_m),
              rivals::product(body.orientation_wxyz, part.orientation_wxyz));
      }
    }
    return parts;
  }
  if (!geom) return {};
  if (on) {
    dGeomSetBody(geom, on);
  } else {
    place(geom, body.position_m, body.orientation_wxyz);
  }
  return {geom};
}

std::string refused_shape(const Body& body) {
  if (!dCheckConfiguration("ODE_EXT_trimesh") && std::holds_alternative<Mesh>(body.shape)) {
    return "this build of ODE has no meshes; found the mesh `" + body.name + "`";
  }
  const auto* convex = std::get_if<Convex>(&body.shape);
  if (convex && convex_hull(convex->points_m).empty()) return "ODE has no flat hull: `" + body.name + "`";
  return "";
}

}  // namespace atwood::ode
