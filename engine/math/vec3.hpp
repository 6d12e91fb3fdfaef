// Three numbers of one frame.
#pragma once

#include <array>

#include "math/scalar.hpp"

namespace atwood {

template <class S> struct Vec3 {
  S x{}, y{}, z{};

  Vec3& operator+=(const Vec3& b) {
    x += b.x;
    y += b.y;
    z += b.z;
    return *this;
  }
  Vec3& operator-=(const Vec3& b) {
    x -= b.x;
    y -= b.y;
    z -= b.z;
    return *this;
  }
};

// Mixed kinds: a number of a vector lane's kind with one that is the same in all lanes (math/pack.hpp).
#define ATWOOD_VEC3 template <class A, class B> [[gnu::always_inline]] inline auto
ATWOOD_VEC3 operator+(const Vec3<A>& a, const Vec3<B>& b) {
  return Vec3<decltype(a.x + b.x)>{a.x + b.x, a.y + b.y, a.z + b.z};
}
ATWOOD_VEC3 operator-(const Vec3<A>& a, const Vec3<B>& b) {
  return Vec3<decltype(a.x - b.x)>{a.x - b.x, a.y - b.y, a.z - b.z};
}
ATWOOD_VEC3 operator*(const A& s, const Vec3<B>& a) { return Vec3<decltype(s * a.x)>{s * a.x, s * a.y, s * a.z}; }
ATWOOD_VEC3 dot(const Vec3<A>& a, const Vec3<B>& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
ATWOOD_VEC3 cross(const Vec3<A>& a, const Vec3<B>& b) {
  return Vec3<decltype(a.y * b.z)>{a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
#undef ATWOOD_VEC3
template <class S> Vec3<S> operator-(const Vec3<S>& a) { return {-a.x, -a.y, -a.z}; }
template <class S> [[gnu::always_inline]] inline S norm(const Vec3<S>& a) { return real::sqrt(dot(a, a)); }

template <class S> S& component(Vec3<S>& v, int i) { return i == 0 ? v.x : i == 1 ? v.y : v.z; }
template <class S> S component(const Vec3<S>& v, int i) { return i == 0 ? v.x : i == 1 ? v.y : v.z; }

// The part of v perpendicular to the unit vector n.
template <class S> Vec3<S> perpendicular_part(const Vec3<S>& v, const Vec3<S>& n) { return v - dot(v, n) * n; }

// A unit vector perpendicular to the unit vector n.
template <class S> Vec3<S> any_tangent(const Vec3<S>& n) {
  const Vec3<S> axis = real::abs(n.x) < S(0.6) ? Vec3<S>{S(1), S(0), S(0)} : Vec3<S>{S(0), S(1), S(0)};
  const Vec3<S> t = axis - dot(axis, n) * n;
  return (S(1) / norm(t)) * t;
}
// v, scaled down to the length `limit` if it is longer.
template <class S> Vec3<S> shortened(const Vec3<S>& v, S limit) {
  const S length = norm(v);
  return length > limit ? (limit / length) * v : v;
}
// The product of a matrix, given by its rows, and v.
template <class S> Vec3<S> times(const Vec3<S> (&row)[3], const Vec3<S>& v) {
  return {dot(row[0], v), dot(row[1], v), dot(row[2], v)};
}

template <class S> S largest_component(const Vec3<S>& v) {
  return real::max(real::abs(v.x), real::max(real::abs(v.y), real::abs(v.z)));
}

// States are spans of scalars; these read and write three of them.
template <class S> Vec3<S> load3(const S* from) { return {from[0], from[1], from[2]}; }
template <class S> void store3(const Vec3<S>& a, S* to) {
  to[0] = a.x;
  to[1] = a.y;
  to[2] = a.z;
}
template <class S> Vec3<S> narrow3(const std::array<double, 3>& a) { return {S(a[0]), S(a[1]), S(a[2])}; }

}  // namespace atwood
