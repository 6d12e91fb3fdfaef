// Between the adapters' doubles and Bullet's scalars.
#pragma once

#include <LinearMath/btTransform.h>

#include "scene/scene.hpp"

namespace atwood::bullet {

inline btScalar narrow(double x) { return static_cast<btScalar>(x); }
inline btVector3 narrow(const Real3& v) { return {narrow(v[0]), narrow(v[1]), narrow(v[2])}; }
inline btQuaternion narrow(const Real4& q) { return {narrow(q[1]), narrow(q[2]), narrow(q[3]), narrow(q[0])}; }
inline Real3 widen(const btVector3& v) { return {v.x(), v.y(), v.z()}; }
inline Real4 widen(const btQuaternion& q) { return {q.w(), q.x(), q.y(), q.z()}; }
inline Real33 widen(const btMatrix3x3& m) {
  return {m[0].x(), m[0].y(), m[0].z(), m[1].x(), m[1].y(), m[1].z(), m[2].x(), m[2].y(), m[2].z()};
}

}  // namespace atwood::bullet
