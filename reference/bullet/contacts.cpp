#include "bullet/contacts.hpp"

#include <BulletCollision/CollisionShapes/btShapeHull.h>
#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <BulletCollision/NarrowPhaseCollision/btContinuousConvexCollision.h>
#include <BulletCollision/NarrowPhaseCollision/btGjkEpaPenetrationDepthSolver.h>
#include <BulletCollision/NarrowPhaseCollision/btVoronoiSimplexSolver.h>
#include <btBulletCollisionCommon.h>

#include <memory>
#include <stdexcept>
#include <type_traits>
#include <vector>

#include "rivals/pairs.hpp"
#include "rivals/vector.hpp"

namespace atwood::bullet {
namespace {

using rivals::operator+;
using rivals::operator*;

constexpr const char* kName = sizeof(btScalar) == 8 ? "bullet64" : "bullet32";

btScalar narrow(double x) { return static_cast<btScalar>(x); }
btVector3 narrow(const Real3& v) { return {narrow(v[0]), narrow(v[1]), narrow(v[2])}; }
Real3 wide(const btVector3& v) { return {v.x(), v.y(), v.z()}; }

// A body's shapes with where they are in it, and what they refer to.
struct Made {
  struct Part {
    std::unique_ptr<btCollisionShape> shape;
    btTransform in_body = btTransform::getIdentity();
  };
  std::vector<Part> parts;
  std::unique_ptr<btTriangleMesh> triangles;
};

struct Maker {
  bool against_surface;  // a mesh meets a mesh or a plane: GImpact; Bullet's other meshes meet only convex shapes

  Made one(std::unique_ptr<btCollisionShape> shape) const {
    Made made;
    made.parts.push_back({std::move(shape)});
    return made;
  }
  Made operator()(const std::monostate&) const { throw std::invalid_argument("a body without a shape"); }
  Made operator()(const Sphere& s) const { return one(std::make_unique<btSphereShape>(narrow(s.radius_m))); }
  Made operator()(const Plane& s) const {
    const double n = rivals::length(s.normal);
    auto shape = std::make_unique<btStaticPlaneShape>(narrow((1 / n) * s.normal), narrow(s.offset_m / n));
    shape->setMargin(0);
    return one(std::move(shape));
  }
  static std::unique_ptr<btBoxShape> box(const Real3& half) {
    auto shape = std::make_unique<btBoxShape>(narrow(half));
    shape->setMargin(0);
    return shape;
  }
  Made operator()(const Rectangle& s) const { return one(box({s.half_extents_m[0], s.half_extents_m[1], 0})); }
  Made operator()(const Box& s) const { return one(box(s.half_extents_m)); }
  Made operator()(const Capsule& s) const {
    return one(std::make_unique<btCapsuleShapeZ>(narrow(s.radius_m), narrow(2 * s.half_length_m)));
  }
  Made operator()(const Cylinder& s) const {
    auto shape = std::make_unique<btCylinderShapeZ>(narrow({s.radius_m, s.radius_m, s.half_length_m}));
    shape->setMargin(0);
    return one(std::move(shape));
  }
  Made operator()(const Convex& s) const {
    auto shape = std::make_unique<btConvexHullShape>();
    for (const Real3& p : s.points_m) shape->addPoint(narrow(p), false);
    shape->recalcLocalAabb();
    shape->setMargin(0);
    return one(std::move(shape));
  }
  Made operator()(const Mesh& s) const {
    Made made;
    made.triangles = std::make_unique<btTriangleMesh>();
    const auto at = [&](int i) { return narrow(s.points_m[static_cast<std::size_t>(i)]); };
    for (const auto& t : s.triangles) made.triangles->addTriangle(at(t[0]), at(t[1]), at(t[2]));
    if (against_surface) {
      auto shape = std::make_unique<btGImpactMeshShape>(made.triangles.get());
      shape->setMargin(0);
      shape->updateBound();
      made.parts.push_back({std::move(shape)});
    } else {
      auto shape = std::make_unique<btBvhTriangleMeshShape>(made.triangles.get(), false);
      shape->setMargin(0);
      made.parts.push_back({std::move(shape)});
    }
    return made;
  }
  Made operator()(const Compound& s) const {
    Made made;
    for (const Compound::Part& part : s.boxes) {
      const Real4& q = part.orientation_wxyz;
      const btTransform at(btQuaternion(narrow(q[1]), narrow(q[2]), narrow(q[3]), narrow(q[0])),
                           narrow(part.position_body_m));
      made.parts.push_back({box(part.half_extents_m), at});
    }
    return made;
  }
};

Made make(const Body& body, const Body& other) {
  const bool surface = std::holds_alternative<Mesh>(other.shape) || std::holds_alternative<Plane>(other.shape);
  return std::visit(Maker{surface}, body.shape);
}

btTransform place(const Body& body) {
  if (std::holds_alternative<Plane>(body.shape)) return btTransform::getIdentity();
  const Real4& q = body.orientation_wxyz;
  return btTransform(btQuaternion(narrow(q[1]), narrow(q[2]), narrow(q[3]), narrow(q[0])), narrow(body.position_m));
}

// ---- overlap ------------------------------------------------------------------------------------------------------
struct Collector : btCollisionWorld::ContactResultCallback {
  const btCollisionObject* first;
  std::vector<FoundContact>& found;
  int body_a, body_b;

  Collector(const btCollisionObject* a, std::vector<FoundContact>& out, int i, int j)
      : first(a), found(out), body_a(i), body_b(j) {}
  btScalar addSingleResult(btManifoldPoint& point, const btCollisionObjectWrapper* one, int, int,
                           const btCollisionObjectWrapper*, int, int) override {
    if (point.getDistance() > 0) return 0;
    // Bullet's normal points from its second object to its first.
    const double sign = one->getCollisionObject() == first ? -1 : 1;
    const Real3 middle = 0.5 * (wide(point.getPositionWorldOnA()) + wide(point.getPositionWorldOnB()));
    found.push_back({body_a, body_b, rivals::widened(middle), rivals::widened(sign * wide(point.m_normalWorldOnB)),
                     -static_cast<Wide>(point.getDistance())});
    return 0;
  }
};

// A pair's coefficients are asked for by plain function pointers, which a stepped world of this process may have set to
// its own: they would look for its scene on these objects. Nothing here depends on them.
struct NoCoefficients {
  static btScalar none(const btCollisionObject*, const btCollisionObject*) { return 0; }
  CalculateCombinedCallback restitution = gCalculateCombinedRestitutionCallback,
                            friction = gCalculateCombinedFrictionCallback,
                            rolling = gCalculateCombinedRollingFrictionCallback;
  NoCoefficients() {
    gCalculateCombinedRestitutionCallback = gCalculateCombinedFrictionCallback = none;
    gCalculateCombinedRollingFrictionCallback = none;
  }
  ~NoCoefficients() {
    gCalculateCombinedRestitutionCallback = restitution;
    gCalculateCombinedFrictionCallback = friction;
    gCalculateCombinedRollingFrictionCallback = rolling;
  }
  NoCoefficients(const NoCoefficients&) = delete;
  NoCoefficients& operator=(const NoCoefficients&) = delete;
};

struct Room {
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher;
  btDbvtBroadphase broad;
  btCollisionWorld world;

  static btDefaultCollisionConstructionInfo small() {
    btDefaultCollisionConstructionInfo info;
    info.m_defaultMaxPersistentManifoldPoolSize = 64;
    info.m_defaultMaxCollisionAlgorithmPoolSize = 64;
    return info;
  }
  Room() : configuration(small()), dispatcher(&configuration), world(&dispatcher, &broad, &configuration) {
    static btGImpactCollisionAlgorithm::CreateFunc gimpact;
    btGImpactCollisionAlgorithm::registerAlgorithm(&dispatcher);  // the stepped world's table
    for (int other = 0; other < MAX_BROADPHASE_COLLISION_TYPES; ++other) {
      dispatcher.registerClosestPointsCreateFunc(GIMPACT_SHAPE_PROXYTYPE, other, &gimpact);
      dispatcher.registerClosestPointsCreateFunc(other, GIMPACT_SHAPE_PROXYTYPE, &gimpact);
    }
  }
};

// What btCollisionDispatcher::defaultNearCallback does with a pair that its broad phase has found.
void overlap_as_stepped(Room& room, btCollisionObject& one, btCollisionObject& other, int i, int j,
                        ContactAnswer& answer) {
  const NoCoefficients guard;
  const btCollisionObjectWrapper first(nullptr, one.getCollisionShape(), &one, one.getWorldTransform(), -1, -1);
  const btCollisionObjectWrapper second(nullptr, other.getCollisionShape(), &other, other.getWorldTransform(), -1, -1);
  btCollisionAlgorithm* algorithm =
      room.dispatcher.findAlgorithm(&first, &second, nullptr, BT_CONTACT_POINT_ALGORITHMS);
  if (algorithm == nullptr) return;
  btManifoldResult result(&first, &second);
  algorithm->processCollision(&first, &second, room.world.getDispatchInfo(), &result);
  btManifoldArray manifolds;
  algorithm->getAllContactManifolds(manifolds);
  for (int m = 0; m < manifolds.size(); ++m) {
    // Its normal points from its second object to its first.
    const double sign = manifolds[m]->getBody0() == &one ? -1 : 1;
    for (int k = 0; k < manifolds[m]->getNumContacts(); ++k) {
      const btManifoldPoint& point = manifolds[m]->getContactPoint(k);
      if (point.getDistance() > 0) continue;
      const Real3 middle = 0.5 * (wide(point.getPositionWorldOnA()) + wide(point.getPositionWorldOnB()));
      answer.contacts.push_back({i, j, rivals::widened(middle), rivals::widened(sign * wide(point.m_normalWorldOnB)),
                                 -static_cast<Wide>(point.getDistance())});
    }
  }
  algorithm->~btCollisionAlgorithm();
  room.dispatcher.freeCollisionAlgorithm(algorithm);
}

enum class Table { stepped, closest_points };

void overlap(Room& room, Table table, const Scene& scene, int i, int j, ContactAnswer& answer) {
  const Body &a = scene.bodies[static_cast<std::size_t>(i)], &b = scene.bodies[static_cast<std::size_t>(j)];
  const Made of_a = make(a, b), of_b = make(b, a);
  for (const auto& p : of_a.parts)
    for (const auto& q : of_b.parts) {
      btCollisionObject one, other;
      one.setCollisionShape(p.shape.get());
      one.setWorldTransform(place(a) * p.in_body);
      other.setCollisionShape(q.shape.get());
      other.setWorldTransform(place(b) * q.in_body);
      if (table == Table::stepped) {
        overlap_as_stepped(room, one, other, i, j, answer);
        continue;
      }
      Collector collector(&one, answer.contacts, i, j);
      room.world.contactPairTest(&one, &other, collector);
    }
}

// ---- first touch --------------------------------------------------------------------------------------------------
btTransform moved(const Body& body, double t_s) {
  const Real3 w_W = rivals::to_world(body.orientation_wxyz, body.angular_velocity_body_rad_per_s);
  btTransform end;
  btTransformUtil::integrateTransform(place(body), narrow(body.velocity_m_per_s), narrow(w_W), narrow(t_s), end);
  return end;
}

void first_touch(const Scene& scene, const ContactQuery& query, int i, int j, ContactAnswer& answer) {
  const bool swap = std::holds_alternative<Plane>(scene.bodies[static_cast<std::size_t>(i)].shape);
  const Body& a = scene.bodies[static_cast<std::size_t>(swap ? j : i)];
  const Body& b = scene.bodies[static_cast<std::size_t>(swap ? i : j)];
  const Made of_a = make(a, b), of_b = make(b, a);
  if (of_a.parts.size() != 1 || of_b.parts.size() != 1)
    throw std::invalid_argument("it casts convex shapes, not compounds");
  const auto* convex = dynamic_cast<const btConvexShape*>(of_a.parts[0].shape.get());
  const auto* other = dynamic_cast<const btConvexShape*>(of_b.parts[0].shape.get());
  const auto* plane = dynamic_cast<const btStaticPlaneShape*>(of_b.parts[0].shape.get());
  if (!convex || (!other && !plane)) throw std::invalid_argument("it casts convex shapes, not meshes");
  btVoronoiSimplexSolver simplex;
  btGjkEpaPenetrationDepthSolver depth;
  btContinuousConvexCollision cast =
      plane ? btContinuousConvexCollision(convex, plane) : btContinuousConvexCollision(convex, other, &simplex, &depth);
  btConvexCast::CastResult result;
  result.m_fraction = 1;
  if (!cast.calcTimeOfImpact(place(a), moved(a, query.t_end_s), place(b), moved(b, query.t_end_s), result)) return;
  const double sign = swap ? 1 : -1;
  answer.touches.push_back({i, j, static_cast<Wide>(result.m_fraction) * query.t_end_s,
                            rivals::widened(wide(result.m_hitPoint)), rivals::widened(sign * wide(result.m_normal))});
}

ContactAnswer answer_from(Table table, const Scene& scene, const ContactQuery& query) {
  Room room;
  return rivals::ask_pairs(kName, scene, [&](int a, int b, ContactAnswer& answer) {
    if (query.swept) first_touch(scene, query, a, b, answer);
    else overlap(room, table, scene, a, b, answer);
  });
}

}  // namespace

ContactAnswer find_contacts(const Scene& scene, const ContactQuery& query) {
  return answer_from(Table::stepped, scene, query);
}

ContactAnswer closest_points(const Scene& scene, const ContactQuery& query) {
  return answer_from(Table::closest_points, scene, query);
}

}  // namespace atwood::bullet
