// Three numbers of one frame.
#pragma once

#include <array>

#include "math/scalar.hpp"

namespace atwood {

template <class S> struct Vec3 {
  S x{}, y{}, z{};

  Vec3& operator+=(const Vec3& b) { x += b.x; y += b.y; z += b.z; return *this; }
  Vec3& operator-=(const Vec3& b) { x -= b.x; y -= b.y; z -= b.z; return *this; }
};

template <class S> Vec3<S> operator+(const Vec3<S>& a, const Vec3<S>& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
template <class S> Vec3<S> operator-(const Vec3<S>& a, const Vec3<S>& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
template <class S> Vec3<S> operator-(const Vec3<S>& a) { return {-a.x, -a.y, -a.z}; }
template <class S> Vec3<S> operator*(S s, const Vec3<S>& a) { return {s * a.x, s * a.y, s * a.z}; }
template <class S> S dot(const Vec3<S>& a, const Vec3<S>& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
template <class S> S norm(const Vec3<S>& a) { return real::sqrt(dot(a, a)); }
template <class S> Vec3<S> cross(const Vec3<S>& a, const Vec3<S>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

// States are spans of scalars; these read and write three of them.
template <class S> Vec3<S> load3(const S* from) { return {from[0], from[1], from[2]}; }
template <class S> void store3(const Vec3<S>& a, S* to) { to[0] = a.x; to[1] = a.y; to[2] = a.z; }
template <class S> Vec3<S> narrow3(const std::array<double, 3>& a) { return {S(a[0]), S(a[1]), S(a[2])}; }

}  // namespace atwood
