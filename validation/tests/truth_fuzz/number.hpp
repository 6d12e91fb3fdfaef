// The arithmetic of the checkers: 60 decimal digits, which nothing in reference/ uses.
#pragma once

#include <array>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <string>
#include <vector>

#include "protocol/sample.hpp"
#include "scene/scene.hpp"

namespace atwood::fuzz {

using Long = boost::multiprecision::number<boost::multiprecision::cpp_bin_float<60>, boost::multiprecision::et_off>;
using Long3 = std::array<Long, 3>;
using Long4 = std::array<Long, 4>;

// Exact: three doubles represent the 113 bits of a quad.
inline Long widened(Wide x) {
  Long sum = 0;
  for (int k = 0; k < 4; ++k) {
    const double part = static_cast<double>(x);
    if (!(part - part == 0)) return part;  // infinite or not a number
    sum += part;
    x -= part;
  }
  return sum;
}

inline Long3 widened(const Real3& v) { return {v[0], v[1], v[2]}; }
inline Long3 operator+(const Long3& a, const Long3& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
inline Long3 operator-(const Long3& a, const Long3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
inline Long3 operator*(const Long& s, const Long3& a) { return {s * a[0], s * a[1], s * a[2]}; }
inline Long dot(const Long3& a, const Long3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline Long3 cross(const Long3& a, const Long3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

// R(q) v of a unit quaternion (w, x, y, z).
inline Long3 turned(const Long4& q, const Long3& v) {
  const Long3 u{q[1], q[2], q[3]};
  const Long3 t = Long(2) * cross(u, v);
  return v + q[0] * t + cross(u, t);
}
inline Long3 turned_back(const Long4& q, const Long3& v) { return turned({q[0], -q[1], -q[2], -q[3]}, v); }

inline Long4 product(const Long4& a, const Long4& b) {
  const Long3 u{a[1], a[2], a[3]}, v{b[1], b[2], b[3]};
  const Long3 w = a[0] * v + b[0] * u + cross(u, v);
  return {a[0] * b[0] - dot(u, v), w[0], w[1], w[2]};
}
inline Long4 normalised(const Real4& given) {
  Long square = 0;
  for (const double part : given) square += Long(part) * part;
  const Long length = sqrt(square);
  return {given[0] / length, given[1] / length, given[2] / length, given[3] / length};
}
inline Long3 normalised(const Long3& v) { return Long(1) / sqrt(dot(v, v)) * v; }
// By `angle` about the unit vector n.
inline Long4 quaternion_about(const Long3& n, const Long& angle) {
  const Long s = sin(angle / 2);
  return {cos(angle / 2), s * n[0], s * n[1], s * n[2]};
}
// Matrices row by row.
template <class T> Long3 times(const std::array<T, 9>& m, const Long3& v) {
  return {m[0] * v[0] + m[1] * v[1] + m[2] * v[2], m[3] * v[0] + m[4] * v[1] + m[5] * v[2],
          m[6] * v[0] + m[7] * v[1] + m[8] * v[2]};
}
template <class T> std::array<Long, 9> inverse(const std::array<T, 9>& m) {
  const Long3 a{m[0], m[3], m[6]}, b{m[1], m[4], m[7]}, c{m[2], m[5], m[8]};  // columns
  const Long3 bc = cross(b, c), ca = cross(c, a), ab = cross(a, b);
  const Long det = dot(a, bc);
  std::array<Long, 9> made;
  for (std::size_t j = 0; j < 3; ++j) {
    made[j] = bc[j] / det;
    made[3 + j] = ca[j] / det;
    made[6 + j] = ab[j] / det;
  }
  return made;
}

// As BodySample
struct LongBody {
  Long3 p{};
  Long4 q{1, 0, 0, 0};
  Long3 v{}, w{};
};

inline LongBody start_of(const Body& body) {
  return {widened(body.position_m), normalised(body.orientation_wxyz), widened(body.velocity_m_per_s),
          widened(body.angular_velocity_body_rad_per_s)};
}

// Of a joint: on its parent (0) or on its child (1), body axes.
inline Long3 at_anchor(const Joint& joint, std::size_t end) { return widened(joint.anchors_body_m[end]); }

// As JointSample, without what is applied
struct LongJoint {
  Long4 q{};
  Long3 u{}, force{}, torque{};
};
// As RopeSample
struct LongRope {
  Long tension = 0;
  std::vector<Long> angles;
};

// The result of a checker: values[k][i] of body i at t_end_s k / samples, and their half-width `own`.
struct Checked {
  std::string refused;  // not empty: the checker does not cover the scene, or did not converge
  // Not empty: why the scene does not move as the truth's solution assumes, so that any answer is wrong.
  std::string contradicts = {};
  std::vector<std::vector<LongBody>> values = {}, own = {};
  // As values and own; empty: the checker has none. `reactions`: force and torque are known.
  std::vector<std::vector<LongJoint>> joints = {}, joints_own = {};
  bool reactions = false;
  std::vector<std::vector<LongRope>> ropes = {}, ropes_own = {};
  // Times of the events, ascending; not `has_events`: the checker does not know them.
  std::vector<Long> event_s = {}, event_own_s = {};
  bool has_events = false;
};

// Every body at its start at all samples, for checkers to fill in.
inline Checked of_starts(const Scenario& scenario, std::int64_t samples) {
  Checked made;
  std::vector<LongBody> bodies;
  for (const Body& body : scenario.scene.bodies) bodies.push_back(start_of(body));
  made.values.assign(static_cast<std::size_t>(samples + 1), bodies);
  return made;
}

// A result and the same with other step lengths or shifted events: their difference is the half-width of the first.
// Both have the same samples. Refused where they have not the same number of events.
inline void set_own(Checked& made, const Checked& other, const Long& relative) {
  const auto apart = [&](const Long& a, const Long& b) { return Long(abs(a - b) + abs(a) * relative); };
  const auto each = [&](const auto& a, const auto& b, auto& own) {
    for (std::size_t c = 0; c < a.size(); ++c) own[c] = apart(a[c], b[c]);
  };
  for (std::size_t k = 0; k < made.values.size(); ++k) {
    auto& own = made.own.emplace_back(made.values[k].size());
    for (std::size_t i = 0; i < own.size(); ++i) {
      const LongBody &x = made.values[k][i], &y = other.values[k][i];
      each(x.p, y.p, own[i].p);
      each(x.v, y.v, own[i].v);
      each(x.w, y.w, own[i].w);
      each(x.q, y.q, own[i].q);
    }
    if (!made.joints.empty()) {
      auto& of = made.joints_own.emplace_back(made.joints[k].size());
      for (std::size_t j = 0; j < of.size(); ++j) {
        const LongJoint &x = made.joints[k][j], &y = other.joints[k][j];
        each(x.q, y.q, of[j].q);
        each(x.u, y.u, of[j].u);
        each(x.force, y.force, of[j].force);
        each(x.torque, y.torque, of[j].torque);
      }
    }
    if (made.ropes.empty()) continue;
    auto& of = made.ropes_own.emplace_back(made.ropes[k].size());
    for (std::size_t j = 0; j < of.size(); ++j) {
      of[j].tension = apart(made.ropes[k][j].tension, other.ropes[k][j].tension);
      of[j].angles.resize(made.ropes[k][j].angles.size());
      each(made.ropes[k][j].angles, other.ropes[k][j].angles, of[j].angles);
    }
  }
  made.event_own_s.resize(made.event_s.size());
  if (made.event_s.size() == other.event_s.size()) each(made.event_s, other.event_s, made.event_own_s);
  else made.refused = "the checker's number of events depends on its steps";
}

// Of a checker with a tolerance: the result, with the difference from that of another tolerance as the half-width.
// Refused where either is.
inline Checked of_two(Checked made, Checked other, const Long& relative) {
  if (!made.refused.empty()) return made;
  if (!other.refused.empty()) return other;
  set_own(made, other, relative);
  return made;
}

// Wider half-widths for components that are small because their terms cancel.
inline void widen_bodies(Checked& made, const Long& by) {
  for (auto& row : made.own)
    for (LongBody& own : row)
      for (std::size_t c = 0; c < 3; ++c) {
        own.p[c] += by;
        own.v[c] += by;
        own.w[c] += by;
        own.q[c + 1] += by;
      }
}
inline void widen_reactions(Checked& made, const Long& by) {
  for (auto& row : made.joints_own)
    for (LongJoint& own : row)
      for (std::size_t c = 0; c < 3; ++c) {
        own.force[c] += by;
        own.torque[c] += by;
      }
}

}  // namespace atwood::fuzz
