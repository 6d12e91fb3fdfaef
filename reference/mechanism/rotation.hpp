// Unit quaternions (w, x, y, z) and rotations about an axis, in double, long double and quad.
#pragma once

#include <cmath>

#include "dynamics/arithmetic.hpp"

namespace atwood::mechanism {

using dynamics::cross;
using dynamics::dot;
using dynamics::Matrix;
using dynamics::multiply;
using dynamics::rotate;
using dynamics::rotate_back;
using dynamics::Triple;
using dynamics::operator+;
using dynamics::operator-;
using dynamics::operator*;
using dynamics::operator+=;
using dynamics::operator-=;

template <class S> using Quaternion = std::array<S, 4>;

template <class S> Quaternion<S> product(const Quaternion<S>& a, const Quaternion<S>& b) {
  return {a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3], a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
          a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1], a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]};
}
template <class S> Quaternion<S> conjugate(const Quaternion<S>& q) { return {q[0], -q[1], -q[2], -q[3]}; }

template <class S> Quaternion<S> normalised(const Quaternion<S>& q) {
  const S length = dynamics::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  return {q[0] / length, q[1] / length, q[2] / length, q[3] / length};
}
template <class S> Triple<S> unit(const Triple<S>& v) { return (S(1) / dynamics::sqrt(dot(v, v))) * v; }

template <class S> S full_turn() {
  static const S made = 2 * dynamics::atan2(S(0), S(-1));
  return made;
}

// The value nearest to `reference` of an angle that is known up to full turns [rad].
template <class S> S nearest_branch(const S& angle, double reference) {
  const double turns = std::round((reference - static_cast<double>(angle)) / static_cast<double>(full_turn<S>()));
  return angle + S(turns) * full_turn<S>();
}

// The rotation by `angle` about a unit axis.
template <class S> Quaternion<S> turn_about(const Triple<S>& axis, const S& angle) {
  const S c = dynamics::cos(angle / 2), s = dynamics::sin(angle / 2);
  return {c, s * axis[0], s * axis[1], s * axis[2]};
}

// exp(v): the rotation by |v| about v.
template <class S> Quaternion<S> turn_by(const Triple<S>& v) {
  const S angle = dynamics::sqrt(dot(v, v));
  if (!(angle > 0)) return {S(1), S(0), S(0), S(0)};
  return turn_about<S>((S(1) / angle) * v, angle);
}

// Two unit vectors orthogonal to the unit vector n and to each other.
template <class S> std::array<Triple<S>, 2> orthogonal_pair(const Triple<S>& n) {
  int least = 0;
  for (int k = 1; k < 3; ++k)
    if (dynamics::magnitude(n[k]) < dynamics::magnitude(n[least])) least = k;
  Triple<S> e{};
  e[least] = 1;
  const Triple<S> first = unit<S>(cross(n, e));
  return {first, cross(n, first)};
}

template <class To, class From> Triple<To> converted(const Triple<From>& v) {
  return {static_cast<To>(v[0]), static_cast<To>(v[1]), static_cast<To>(v[2])};
}

}  // namespace atwood::mechanism
