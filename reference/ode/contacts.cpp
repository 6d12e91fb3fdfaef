#include "ode/contacts.hpp"

#include <ode/ode.h>

#include <array>
#include <memory>
#include <stdexcept>
#include <vector>

#include "rivals/pairs.hpp"
#include "rivals/vector.hpp"

namespace atwood::ode {
namespace {

using rivals::operator+;
using rivals::operator-;
using rivals::operator*;

// dInitODE2 counts its calls; the world's adapter has one of its own.
void start_library() {
  static const bool started = dInitODE2(0) != 0 && dAllocateODEDataForThread(dAllocateMaskAll) != 0;
  if (!started) throw std::invalid_argument("ODE did not start");
}

// A body's geoms, and what they refer to: ODE keeps pointers.
struct Made {
  std::vector<dGeomID> geoms;
  dTriMeshDataID mesh = nullptr;
  std::vector<dReal> points, planes;
  std::vector<dTriIndex> triangles;
  std::vector<unsigned int> polygons;

  Made() = default;
  Made(const Made&) = delete;
  Made& operator=(const Made&) = delete;
  ~Made() {
    for (const dGeomID geom : geoms) dGeomDestroy(geom);
    if (mesh) dGeomTriMeshDataDestroy(mesh);
  }
};

void put(dGeomID geom, const Real3& p, const Real4& q) {
  const dQuaternion turned = {q[0], q[1], q[2], q[3]};
  dGeomSetPosition(geom, p[0], p[1], p[2]);
  dGeomSetQuaternion(geom, turned);
}

struct Maker {
  const Body& body;
  Made& made;

  void keep(dGeomID geom) const {
    made.geoms.push_back(geom);
    put(geom, body.position_m, body.orientation_wxyz);
  }
  static dGeomID box(const Real3& h) { return dCreateBox(nullptr, 2 * h[0], 2 * h[1], 2 * h[2]); }
  void points(const std::vector<Real3>& given) const {
    for (const Real3& p : given) made.points.insert(made.points.end(), p.begin(), p.end());
  }
  void operator()(const std::monostate&) const { throw std::invalid_argument("a body without a shape"); }
  void operator()(const Sphere& s) const { keep(dCreateSphere(nullptr, s.radius_m)); }
  void operator()(const Plane& s) const {
    const double n = rivals::length(s.normal);
    made.geoms.push_back(dCreatePlane(nullptr, s.normal[0] / n, s.normal[1] / n, s.normal[2] / n, s.offset_m / n));
  }
  void operator()(const Rectangle& s) const { keep(box({s.half_extents_m[0], s.half_extents_m[1], 0})); }
  void operator()(const Box& s) const { keep(box(s.half_extents_m)); }
  void operator()(const Capsule& s) const { keep(dCreateCapsule(nullptr, s.radius_m, 2 * s.half_length_m)); }
  void operator()(const Cylinder& s) const { keep(dCreateCylinder(nullptr, s.radius_m, 2 * s.half_length_m)); }
  void operator()(const Convex& s) const {
    points(s.points_m);
    for (const auto& t : rivals::hull_of(s)) {
      const auto at = [&](int i) { return s.points_m[static_cast<std::size_t>(i)]; };
      const Real3 n = rivals::cross(at(t[1]) - at(t[0]), at(t[2]) - at(t[0]));
      const Real3 unit = (1 / rivals::length(n)) * n;
      made.planes.insert(made.planes.end(), {unit[0], unit[1], unit[2], rivals::dot(unit, at(t[0]))});
      made.polygons.push_back(3);
      for (const int corner : t) made.polygons.push_back(static_cast<unsigned int>(corner));
    }
    keep(dCreateConvex(nullptr, made.planes.data(), static_cast<unsigned>(made.planes.size() / 4), made.points.data(),
                       static_cast<unsigned>(s.points_m.size()), made.polygons.data()));
  }
  void operator()(const Mesh& s) const {
    points(s.points_m);
    // Of a single triangle its library makes no tree, and dies of that when asked about two meshes: given twice it is
    // one.
    for (int times = s.triangles.size() == 1 ? 2 : 1; times > 0; --times)
      for (const auto& t : s.triangles)
        for (const int corner : t) made.triangles.push_back(static_cast<dTriIndex>(corner));
    made.mesh = dGeomTriMeshDataCreate();
    dGeomTriMeshDataBuildDouble(made.mesh, made.points.data(), 3 * sizeof(dReal), static_cast<int>(s.points_m.size()),
                                made.triangles.data(), static_cast<int>(made.triangles.size()), 3 * sizeof(dTriIndex));
    keep(dCreateTriMesh(nullptr, made.mesh, nullptr, nullptr, nullptr));
  }
  void operator()(const Compound& s) const {
    for (const Compound::Part& part : s.boxes) {
      made.geoms.push_back(box(part.half_extents_m));
      const Real4 &q = body.orientation_wxyz, &r = part.orientation_wxyz;
      const dQuaternion outer = {q[0], q[1], q[2], q[3]}, inner = {r[0], r[1], r[2], r[3]};
      dQuaternion both;
      dQMultiply0(both, outer, inner);
      put(made.geoms.back(), body.position_m + rivals::to_world(q, part.position_body_m),
          {both[0], both[1], both[2], both[3]});
    }
  }
};

void ask(const Scene& scene, int i, int j, ContactAnswer& answer) {
  const Body &a = scene.bodies[static_cast<std::size_t>(i)], &b = scene.bodies[static_cast<std::size_t>(j)];
  Made of_a, of_b;
  std::visit(Maker{a, of_a}, a.shape);
  std::visit(Maker{b, of_b}, b.shape);
  constexpr int max_points = 64;
  std::array<dContactGeom, max_points> points;
  for (const dGeomID p : of_a.geoms)
    for (const dGeomID q : of_b.geoms) {
      const int count = dCollide(p, q, max_points, points.data(), sizeof(dContactGeom));
      for (int k = 0; k < count; ++k) {
        const dContactGeom& c = points[static_cast<std::size_t>(k)];
        // ODE's normal points into the first geom.
        answer.contacts.push_back(
            {i, j, {c.pos[0], c.pos[1], c.pos[2]}, {-c.normal[0], -c.normal[1], -c.normal[2]}, c.depth});
      }
    }
}

}  // namespace

ContactAnswer find_contacts(const Scene& scene, const ContactQuery& query) {
  return rivals::ask_pairs("ode", scene, [&](int a, int b, ContactAnswer& answer) {
    start_library();
    if (query.swept) throw std::invalid_argument("ODE has no sweeps in time");
    ask(scene, a, b, answer);
  });
}

}  // namespace atwood::ode
