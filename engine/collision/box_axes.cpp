// The fifteen axes of two boxes: Gottschalk, Lin, Manocha, OBBTree (1996), made exact for edges that are nearly
// parallel.
#include "collision/box_pair.hpp"

namespace atwood {

namespace {

template <class S> std::array<S, 3> core_extents(const Geometry<S>& g) {
  if (g.kind == ShapeKind::capsule) return {S(0), S(0), g.half_length};
  return {g.half_extents.x, g.half_extents.y, g.half_extents.z};
}

// The product c = A_i x B_j of two edges, by a's axes: component 0 along A_i, -R[i2][j] along A_i1, R[i1][j] along
// A_i2, s = |c| the sine of their angle. The entries of R are off by an ulp of 1, so c / s may be turned about A_i by
// eps / s: much when the edges are nearly parallel. Any unit vector n bounds the penetration from above, and the one we
// have is exactly normal to A_i and to B_j = (.., R[i1][j], R[i2][j]): the parallelogram of edges that it must face
// stays flat against it, and the bound is sharp to a few eps of the extents. That holds if every projection is made
// with this n, not by identities for the true one (A_i x B_j . B_k = R[i][l] is off by eps / s).
template <class S> struct EdgeAxis {
  S along_1, along_2, gap, offset;  // n = along_1 A_i1 + along_2 A_i2; offset = t . n
};
template <class S> EdgeAxis<S> edge_axis(const BoxPair<S>& pair, int i, int j, S sine) {
  const auto& R = pair.R;
  const int i1 = next_axis(i), i2 = next_axis(i1), j1 = next_axis(j), j2 = next_axis(j1);
  const S inverse = S(1) / sine, c1 = -R[i2][j] * inverse, c2 = R[i1][j] * inverse;
  const S offset = pair.t_a[i1] * c1 + pair.t_a[i2] * c2;
  const S extent_a = pair.h_a[i1] * real::abs(c1) + pair.h_a[i2] * real::abs(c2);
  const S extent_b = pair.h_b[j1] * real::abs(c1 * R[i1][j1] + c2 * R[i2][j1]) +
                     pair.h_b[j2] * real::abs(c1 * R[i1][j2] + c2 * R[i2][j2]);
  return {c1, c2, real::abs(offset) - extent_a - extent_b, offset};
}

// False: some face shows more than `limit`.
template <class S>
bool faces(const BoxPair<S>& pair, const std::array<std::array<S, 3>, 3>& Q, S limit, BoxAxis<S>& best) {
  const auto &h_a = pair.h_a, &h_b = pair.h_b;
  for (int i = 0; i < 3; ++i) {
    const S gap = real::abs(pair.t_a[i]) - h_a[i] - (Q[i][0] * h_b[0] + Q[i][1] * h_b[1] + Q[i][2] * h_b[2]);
    if (gap > limit) return false;
    if (i == 0 || gap > best.gap) best.gap = gap, best.i = i;
  }
  for (int j = 0; j < 3; ++j) {
    const S gap = real::abs(pair.t_b[j]) - h_b[j] - (Q[0][j] * h_a[0] + Q[1][j] * h_a[1] + Q[2][j] * h_a[2]);
    if (gap > limit) return false;
    if (gap > best.gap) best.gap = gap, best.kind = BoxAxisKind::face_b, best.j = j;
  }
  return true;
}

}  // namespace

template <class S>
BoxPair<S> box_pair(const Geometry<S>& a, const Transform<S>& pose_a, const Geometry<S>& b,
                    const Transform<S>& pose_b) {
  BoxPair<S> pair;
  pair.pose_a = &pose_a, pair.pose_b = &pose_b;
  pair.h_a = core_extents(a), pair.h_b = core_extents(b);
  pair.radius_a = a.kind == ShapeKind::capsule ? a.radius : S(0);
  pair.radius_b = b.kind == ShapeKind::capsule ? b.radius : S(0);
  const Vec3<S> t = pose_b.p_W - pose_a.p_W;
  for (int i = 0; i < 3; ++i) {
    pair.t_a[i] = dot(t, pose_a.axis_W[i]);
    pair.t_b[i] = dot(t, pose_b.axis_W[i]);
    for (int j = 0; j < 3; ++j) pair.R[i][j] = dot(pose_a.axis_W[i], pose_b.axis_W[j]);
  }
  pair.size = pair.h_a[0] + pair.h_a[1] + pair.h_a[2] + pair.h_b[0] + pair.h_b[1] + pair.h_b[2];
  return pair;
}

template <class S> bool greatest_gap(const BoxPair<S>& pair, S limit, BoxAxis<S>& best) {
  std::array<std::array<S, 3>, 3> Q;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) Q[i][j] = real::abs(pair.R[i][j]);
  best = {};
  if (!faces(pair, Q, limit, best)) return false;

  // Most edges are rejected by R alone: with v = s gap and s <= 1, an axis can only win if v > min(best, 0).
  const auto& R = pair.R;
  const auto &h_a = pair.h_a, &h_b = pair.h_b, &t = pair.t_a;
  const S eps = real::epsilon<S>();
  const S slack = S(16) * eps * (pair.size + real::abs(t[0]) + real::abs(t[1]) + real::abs(t[2]));
  S edge_gap = best.gap, won = best.gap + S(8) * eps * pair.size;  // a face is preferred within round-off
  bool edge_wins = false;
  EdgeAxis<S> edge{};
  for (int i = 0, i1 = 1, i2 = 2; i < 3; ++i, i1 = next_axis(i1), i2 = next_axis(i2)) {
    for (int j = 0, j1 = 1, j2 = 2; j < 3; ++j, j1 = next_axis(j1), j2 = next_axis(j2)) {
      const S v = real::abs(t[i2] * R[i1][j] - t[i1] * R[i2][j]) - h_a[i1] * Q[i2][j] - h_a[i2] * Q[i1][j] -
                  h_b[j1] * Q[i][j2] - h_b[j2] * Q[i][j1] + slack;
      if (v <= real::min(edge_gap, S(0))) continue;
      const S sine = real::sqrt(R[i1][j] * R[i1][j] + R[i2][j] * R[i2][j]);
      if (v <= edge_gap * sine || sine <= S(4) * eps)
        continue;  // parallel within the round-off of the axes: the faces decide
      const EdgeAxis<S> axis = edge_axis(pair, i, j, sine);
      if (axis.gap > limit) return false;
      if (!(axis.gap > (edge_wins ? edge_gap : won))) continue;
      edge_wins = true;
      edge_gap = axis.gap;
      edge = axis;
      best.i = i, best.j = j;
    }
  }

  const Vec3<S>*A = pair.pose_a->axis_W, *B = pair.pose_b->axis_W;
  if (edge_wins) {
    best.kind = BoxAxisKind::edges;
    best.gap = edge_gap;
    best.normal_W = edge.along_1 * A[next_axis(best.i)] + edge.along_2 * A[next_axis(next_axis(best.i))];
    if (edge.offset < S(0)) best.normal_W = -best.normal_W;
  } else if (best.kind == BoxAxisKind::face_a) {
    best.normal_W = t[best.i] < S(0) ? -A[best.i] : A[best.i];
  } else {
    best.normal_W = pair.t_b[best.j] < S(0) ? -B[best.j] : B[best.j];
  }
  return true;
}

#define ATWOOD_BOX_AXES(S)                                                                                           \
  template BoxPair<S> box_pair<S>(const Geometry<S>&, const Transform<S>&, const Geometry<S>&, const Transform<S>&); \
  template bool greatest_gap<S>(const BoxPair<S>&, S, BoxAxis<S>&);
ATWOOD_BOX_AXES(float)
ATWOOD_BOX_AXES(double)
ATWOOD_BOX_AXES(long double)
#undef ATWOOD_BOX_AXES

}  // namespace atwood
