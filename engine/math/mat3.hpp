// 3x3 matrices by rows: general ones (rotations among them) and symmetric ones.
#pragma once

#include "math/quat.hpp"

namespace atwood {

template <class S> struct Mat3 {
  Vec3<S> x, y, z;  // rows
};
template <class S> struct Sym3 { S xx{}, xy{}, xz{}, yy{}, yz{}, zz{}; };

#define ATWOOD_MAT3 template <class S> [[gnu::always_inline]] inline
ATWOOD_MAT3 Vec3<S> operator*(const Mat3<S>& a, const Vec3<S>& v) { return {dot(a.x, v), dot(a.y, v), dot(a.z, v)}; }
ATWOOD_MAT3 Vec3<S> operator*(const Sym3<S>& a, const Vec3<S>& v) {
  return {a.xx * v.x + a.xy * v.y + a.xz * v.z, a.xy * v.x + a.yy * v.y + a.yz * v.z,
          a.xz * v.x + a.yz * v.y + a.zz * v.z};
}
// a^T v
ATWOOD_MAT3 Vec3<S> transposed_times(const Mat3<S>& a, const Vec3<S>& v) {
  return {a.x.x * v.x + a.y.x * v.y + a.z.x * v.z, a.x.y * v.x + a.y.y * v.y + a.z.y * v.z,
          a.x.z * v.x + a.y.z * v.y + a.z.z * v.z};
}
ATWOOD_MAT3 Vec3<S> column(const Mat3<S>& a, int k) {
  return k == 0 ? Vec3<S>{a.x.x, a.y.x, a.z.x} : k == 1 ? Vec3<S>{a.x.y, a.y.y, a.z.y} : Vec3<S>{a.x.z, a.y.z, a.z.z};
}
// a a^T with a factor: a symmetric matrix of rank one.
ATWOOD_MAT3 void add_outer(Sym3<S>& to, S factor, const Vec3<S>& a) {
  const Vec3<S> b = factor * a;
  to.xx += b.x * a.x;
  to.xy += b.x * a.y;
  to.xz += b.x * a.z;
  to.yy += b.y * a.y;
  to.yz += b.y * a.z;
  to.zz += b.z * a.z;
}
ATWOOD_MAT3 void add_outer(Mat3<S>& to, S factor, const Vec3<S>& a, const Vec3<S>& b) {
  const Vec3<S> c = factor * a;
  to.x += c.x * b;
  to.y += c.y * b;
  to.z += c.z * b;
}
ATWOOD_MAT3 Sym3<S>& operator+=(Sym3<S>& a, const Sym3<S>& b) {
  a.xx += b.xx;
  a.xy += b.xy;
  a.xz += b.xz;
  a.yy += b.yy;
  a.yz += b.yz;
  a.zz += b.zz;
  return a;
}
ATWOOD_MAT3 Mat3<S>& operator+=(Mat3<S>& a, const Mat3<S>& b) {
  a.x += b.x;
  a.y += b.y;
  a.z += b.z;
  return a;
}
// The matrix of r x: cross_matrix(r) v = r x v.
ATWOOD_MAT3 Mat3<S> cross_matrix(const Vec3<S>& r) { return {{S(0), -r.z, r.y}, {r.z, S(0), -r.x}, {-r.y, r.x, S(0)}}; }

// The rotation of a unit quaternion.
ATWOOD_MAT3 Mat3<S> rotation_matrix(const Quat<S>& q) {
  const S x2 = q.x + q.x, y2 = q.y + q.y, z2 = q.z + q.z;
  const S wx = q.w * x2, wy = q.w * y2, wz = q.w * z2;
  const S xx = q.x * x2, xy = q.x * y2, xz = q.x * z2, yy = q.y * y2, yz = q.y * z2, zz = q.z * z2;
  return {
      {S(1) - (yy + zz), xy - wz, xz + wy}, {xy + wz, S(1) - (xx + zz), yz - wx}, {xz - wy, yz + wx, S(1) - (xx + yy)}};
}
// R a R^T: the symmetric matrix a of body axes in world axes.
ATWOOD_MAT3 Sym3<S> rotated(const Mat3<S>& R, const Sym3<S>& a) {
  const Vec3<S> tx = a * R.x, ty = a * R.y, tz = a * R.z;
  return {dot(R.x, tx), dot(R.x, ty), dot(R.x, tz), dot(R.y, ty), dot(R.y, tz), dot(R.z, tz)};
}
#undef ATWOOD_MAT3

}  // namespace atwood
