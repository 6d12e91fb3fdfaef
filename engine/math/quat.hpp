// Unit quaternions (w, x, y, z); q_WB turns body axes into world axes: v_W = q_WB v_B q_WB*.
#pragma once

#include "math/vec3.hpp"

namespace atwood {

template <class S> struct Quat { S w{1}, x{}, y{}, z{}; };

template <class S> Quat<S> operator*(const Quat<S>& a, const Quat<S>& b) {
  return {a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z, a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
          a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x, a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
}
template <class S> Quat<S> conjugate(const Quat<S>& q) { return {q.w, -q.x, -q.y, -q.z}; }
template <class S> Quat<S> normalised(const Quat<S>& q) {
  const S scale = S(1) / real::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  return {scale * q.w, scale * q.x, scale * q.y, scale * q.z};
}

// v + 2 w (u x v) + 2 u x (u x v), with q = (w, u): the rotation for a unit q, without forming its matrix.
template <class S> Vec3<S> rotate(const Quat<S>& q, const Vec3<S>& v) {
  const Vec3<S> u{q.x, q.y, q.z};
  const Vec3<S> uv = cross(u, v);
  const Vec3<S> t = uv + uv;
  return v + q.w * t + cross(u, t);
}
template <class S> Vec3<S> rotate_back(const Quat<S>& q, const Vec3<S>& v) { return rotate(conjugate(q), v); }

// q' = 1/2 q (0, w) for a body rate w in body axes.
template <class S, class H>
[[gnu::always_inline]] inline Quat<S> quaternion_rate(const Quat<S>& q, const Vec3<S>& w_WB_B, H half_of_one) {
  const Vec3<S> half = half_of_one * w_WB_B;
  return {-(q.x * half.x + q.y * half.y + q.z * half.z), q.w * half.x + q.y * half.z - q.z * half.y,
          q.w * half.y + q.z * half.x - q.x * half.z, q.w * half.z + q.x * half.y - q.y * half.x};
}
template <class S> Quat<S> quaternion_rate(const Quat<S>& q, const Vec3<S>& w_WB_B) {
  return quaternion_rate(q, w_WB_B, S(0.5));
}

template <class S> Quat<S> load4(const S* from) { return {from[0], from[1], from[2], from[3]}; }
template <class S> void store4(const Quat<S>& q, S* to) {
  to[0] = q.w;
  to[1] = q.x;
  to[2] = q.y;
  to[3] = q.z;
}

}  // namespace atwood
