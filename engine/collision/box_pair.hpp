// Two rounded boxes. A box's core is the box, a rectangle's has no thickness, a capsule's is its segment (length only).
// Gaps are computed between the cores; the radii are subtracted at the end, which is exact whether the cores overlap or
// not.
//
// Coordinates are relative to a's centre, so accuracy does not depend on the distance from the world's origin.
#pragma once

#include <array>

#include "collision/contacts.hpp"

namespace atwood {

// Axes in cyclic order.
constexpr int next_axis(int i) { return i == 2 ? 0 : i + 1; }

template <class S> struct BoxPair {
  const Transform<S>* pose_a = nullptr;
  const Transform<S>* pose_b = nullptr;
  std::array<S, 3> h_a{}, h_b{};  // half extents of the cores
  S radius_a{}, radius_b{};
  std::array<S, 3> t_a{}, t_b{};        // from a's centre to b's, in the axes of a and of b
  std::array<std::array<S, 3>, 3> R{};  // R[i][j] = A_i . B_j
  S size{};                             // sum of the half extents: round-off is a few eps of it
};
// Of two boxes, rectangles or capsules at their poses.
template <class S>
BoxPair<S> box_pair(const Geometry<S>& a, const Transform<S>& pose_a, const Geometry<S>& b, const Transform<S>& pose_b);

// ---- the fifteen axes (box_axes.cpp) ------------------------------------------------------------------------------
enum class BoxAxisKind : unsigned char { face_a, face_b, edges };
template <class S> struct BoxAxis {
  S gap{};  // of the cores along the axis
  BoxAxisKind kind = BoxAxisKind::face_a;
  int i = 0, j = 0;  // A_i (face_a, edges), B_j (face_b, edges)
  Vec3<S> normal_W;  // unit, from a to b
};
// The separating-axis test: the axis of the greatest gap, which is that of least penetration when the cores overlap.
// False, with `best` unset, as soon as the gap along some axis is above `limit`.
template <class S> bool greatest_gap(const BoxPair<S>& pair, S limit, BoxAxis<S>& best);

// ---- features: sign s_k of each axis, 0 where it varies: a corner, an edge or a face ------------------------------
constexpr std::array<int, 3> kFeatureWeight{9, 3, 1};
constexpr int kFeatureNone = 13;  // all signs 0; add sign * weight
// A canonical order of two boxes in contact, whichever is called a: by the sign of the normal's component along a fixed
// direction, which is not an axis or diagonal of common scenes, so that the order rarely changes while they touch.
template <class S> bool a_lies_first(const Vec3<S>& normal_W) {
  return dot(normal_W, Vec3<S>{S(0.4391), S(0.5573), S(0.7047)}) > S(0);
}
// The identity of a pair of features in contact, the same for either order of the boxes.
template <class S> std::uint32_t feature_id(const Vec3<S>& normal_W, int feature_a, int feature_b) {
  return static_cast<std::uint32_t>(a_lies_first(normal_W) ? 32 * feature_a + feature_b : 32 * feature_b + feature_a);
}

// ---- where two faces lie over each other (box_faces.cpp) ----------------------------------------------------------
// The reference face (of the reference box, across its axis `k`, on the side of the normal) and the incident face (the
// other's face most opposed to the normal) projected onto each other along the normal; the points within `margin` are
// kept, at most four. `normal_W` need not be the reference face's normal. `deepest` is the least gap between the cores,
// infinite when the faces do not overlap (the manifold is then the other's lowest corner, moved onto the face).
template <class S>
Manifold<S> face_manifold(const BoxPair<S>& pair, bool reference_is_a, int k, const Vec3<S>& normal_W, S margin,
                          S& deepest);

// ---- cores apart (box_closest.cpp) --------------------------------------------------------------------------------
template <class S> struct BoxClosest {
  S distance{};
  Vec3<S> normal_W;         // unit, from a to b
  std::array<S, 3> on_a{};  // in a's axes
  int feature_a = kFeatureNone, feature_b = kFeatureNone;
};
// The nearest points of two cores of which `greatest_gap` found a positive gap. Corners against boxes, edges against
// edges.
template <class S> BoxClosest<S> closest_of_boxes(const BoxPair<S>& pair);

// ---- the manifold (box_pairs.cpp) ---------------------------------------------------------------------------------
// False: the surfaces are more than `margin` apart.
template <class S> bool box_manifold(const BoxPair<S>& pair, S margin, Manifold<S>& out);

}  // namespace atwood
