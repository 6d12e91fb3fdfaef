// Contacts of boxes, rectangles and capsules among each other.
#include "collision/box_pair.hpp"

#include <limits>

#include "collision/capsule_surface.hpp"
#include "collision/pair_tests.hpp"

namespace atwood {

namespace {

// Faces, or edges, within 1.1 degrees of parallel (its sine and cosine) have a manifold of more than one point,
// although the direction of least penetration need not be a face's normal.
template <class S> constexpr S kFlatSine = S(0.02);
template <class S> constexpr S kFlatCosine = S(0.9998);

template <class S> int most_along(const Transform<S>& pose, const Vec3<S>& n_W, S& cosine) {
  int best = 0;
  cosine = S(-1);
  for (int i = 0; i < 3; ++i) {
    const S along = real::abs(dot(n_W, pose.axis_W[i]));
    if (along > cosine) cosine = along, best = i;
  }
  return best;
}

// A contact that is not on a face: the normal, the gap of the cores along it, and the point of a's core.
template <class S> struct EdgeContact {
  Vec3<S> normal_W;
  S gap{};
  std::array<S, 3> on_a{};  // in a's axes
  int feature_a = kFeatureNone, feature_b = kFeatureNone;
};

// Both boxes have a face perpendicular to the normal: the reference is then chosen canonically, not by the axis that
// won by round-off, so that the ids of the points are stable.
template <class S>
bool flat_faces(const BoxPair<S>& pair, const Vec3<S>& normal_W, S margin, Manifold<S>& out, S& deepest) {
  S along_a, along_b;
  const int k_a = most_along(*pair.pose_a, normal_W, along_a), k_b = most_along(*pair.pose_b, normal_W, along_b);
  if (!(along_a > kFlatCosine<S> && along_b > kFlatCosine<S>)) return false;
  const bool by_a = a_lies_first(normal_W);
  out = face_manifold(pair, by_a, by_a ? k_a : k_b, normal_W, margin, deepest);
  return true;
}

// One of two parallel edges, relative to a's centre, in world axes.
template <class S> struct ParallelEdge {
  Vec3<S> center_W, at_W, along_W;    // centre of the core; its nearest point; the edge's direction
  S coordinate, half_length, radius;  // coordinate: of the nearest point along the edge
};

// The gap at a distance `way` along the base's edge from the nearest point, and the base's thickness there.
template <class S>
bool gap_beside(const ParallelEdge<S>& base, const ParallelEdge<S>& other, const Vec3<S>& n_W, S core_gap, S way,
                S& gap, S& thickness) {
  const Vec3<S> from_W = base.at_W + way * base.along_W;
  thickness = core_to_surface(base.radius, base.half_length, base.coordinate + way, dot(n_W, base.along_W));
  bool found = true;
  if (other.radius > S(0)) {
    gap = raycast_capsule(from_W - other.center_W, n_W, other.along_W, other.radius, other.half_length, found) -
          thickness;
  } else {
    gap = core_gap + way * (dot(n_W, other.along_W) / dot(base.along_W, other.along_W) - dot(n_W, base.along_W)) -
          thickness;
  }
  return found;
}

// Two parallel edges: the nearest point, and both ends of their common stretch. Two sharp edges must be parallel to
// round-off; otherwise they touch in one point.
template <class S> bool parallel_edges(const BoxPair<S>& pair, const EdgeContact<S>& at, S margin, Manifold<S>& out) {
  int i = -1, j = -1;
  for (int p = 0; p < 3; ++p)
    for (int q = 0; q < 3; ++q)
      if (real::abs(pair.R[p][q]) > kFlatCosine<S> && pair.h_a[p] > S(0) && pair.h_b[q] > S(0)) i = p, j = q;
  if (i < 0) return false;
  const Vec3<S>&A = pair.pose_a->axis_W[i], &B = pair.pose_b->axis_W[j];
  const bool sharp = !(pair.radius_a > S(0)) && !(pair.radius_b > S(0));
  const S askew = sharp ? S(16) * real::epsilon<S>() : kFlatSine<S>;
  if (!(real::abs(dot(at.normal_W, A)) < askew && real::abs(dot(at.normal_W, B)) < askew)) return false;
  if (sharp && !(norm(cross(A, B)) < askew)) return false;

  const Vec3<S> t_W = pair.pose_b->p_W - pair.pose_a->p_W;
  const Vec3<S> on_a_W = to_world(*pair.pose_a, Vec3<S>{at.on_a[0], at.on_a[1], at.on_a[2]});
  const Vec3<S> on_b_W = on_a_W + at.gap * at.normal_W;
  const ParallelEdge<S> a{{}, on_a_W, A, at.on_a[i], pair.h_a[i], pair.radius_a};
  const ParallelEdge<S> b{t_W, on_b_W, B, dot(on_b_W - t_W, B), pair.h_b[j], pair.radius_b};
  const bool like = (a.radius > S(0)) == (b.radius > S(0)), from_a = like ? a_lies_first(at.normal_W) : b.radius > S(0);
  const ParallelEdge<S>&base = from_a ? a : b, &other = from_a ? b : a;
  const Vec3<S> n_W = from_a ? at.normal_W : -at.normal_W;
  const S cosine = pair.R[i][j], half_extent = other.half_length * real::abs(cosine),
          middle = base.coordinate - cosine * other.coordinate;
  const S from = real::max(-base.half_length, middle - half_extent),
          to = real::min(base.half_length, middle + half_extent);

  out = {};
  out.normal_W = at.normal_W;
  out.type = ManifoldType::edge;
  const std::uint32_t name = 1024u + 4u * static_cast<std::uint32_t>(3 * i + j);
  const S tolerance = S(1e-3) * (base.half_length + other.half_length);
  const auto point_id = [&](S coordinate) {
    return name + (real::abs(coordinate - from) <= tolerance ? 1u : real::abs(coordinate - to) <= tolerance ? 2u : 0u);
  };
  const auto add = [&](S way, S gap, S thickness, std::uint32_t id) {
    out.points[static_cast<std::size_t>(out.count++)] = {
        pair.pose_a->p_W + (base.at_W + way * base.along_W + (thickness + gap / S(2)) * n_W), gap, id};
  };
  add(S(0), at.gap - pair.radius_a - pair.radius_b, base.radius, point_id(base.coordinate));
  for (const S end : {from, to}) {
    S gap, thickness;
    const S way = end - base.coordinate;
    if (point_id(end) == out.points[0].id || !gap_beside(base, other, n_W, at.gap, way, gap, thickness)) continue;
    if (gap <= margin) add(way, gap, thickness, point_id(end));
  }
  return out.count > 1;
}

template <class S>
void edge_manifold(const BoxPair<S>& pair, const EdgeContact<S>& at, ManifoldType type, S margin, Manifold<S>& out) {
  S deepest;
  const S round_off = S(64) * real::epsilon<S>() * pair.size;
  if (flat_faces(pair, at.normal_W, margin, out, deepest) && real::abs(deepest - at.gap) <= round_off) return;
  if (parallel_edges(pair, at, margin, out)) return;
  const S gap = at.gap - pair.radius_a - pair.radius_b;
  out = {};
  out.normal_W = at.normal_W;
  out.type = type;
  out.count = 1;
  const Vec3<S> on_a_W = to_world(*pair.pose_a, Vec3<S>{at.on_a[0], at.on_a[1], at.on_a[2]});
  out.points[0] = {pair.pose_a->p_W + (on_a_W + (pair.radius_a + gap / S(2)) * at.normal_W), gap,
                   feature_id(at.normal_W, at.feature_a, at.feature_b)};
}

bool is_edge(int feature) {  // two signs of three
  int signs = 0;
  for (const int weight : kFeatureWeight) signs += (feature / weight) % 3 != 1;
  return signs == 2;
}

// Two crossing edges in overlap: of each box the edge that is farthest along the normal.
template <class S> EdgeContact<S> edge_contact(const BoxPair<S>& pair, const BoxAxis<S>& axis) {
  const int i = axis.i, j = axis.j;
  EdgeContact<S> at{axis.normal_W, axis.gap, {}, kFeatureNone, kFeatureNone};
  std::array<S, 3> w = pair.t_a;  // from a's edge's middle to b's, in a's axes
  for (int k = next_axis(i); k != i; k = next_axis(k)) {
    const int sign = dot(axis.normal_W, pair.pose_a->axis_W[k]) < S(0) ? -1 : 1;
    at.on_a[k] = S(sign) * pair.h_a[k];
    at.feature_a += sign * kFeatureWeight[k];
    w[k] -= at.on_a[k];
  }
  for (int k = next_axis(j); k != j; k = next_axis(k)) {
    const int sign = dot(axis.normal_W, pair.pose_b->axis_W[k]) < S(0) ? 1 : -1;
    at.feature_b += sign * kFeatureWeight[k];
    for (int row = 0; row < 3; ++row) w[row] += S(sign) * pair.h_b[k] * pair.R[row][k];
  }
  // Nearest points of the two lines, as in box_closest.cpp; kept within the edge for round-off's sake.
  const S r1 = pair.R[next_axis(i)][j], r2 = pair.R[next_axis(next_axis(i))][j];
  const S b = -(w[next_axis(i)] * r1 + w[next_axis(next_axis(i))] * r2) / (r1 * r1 + r2 * r2);
  const S along = w[i] + real::max(-pair.h_b[j], real::min(pair.h_b[j], b)) * pair.R[i][j];
  at.on_a[i] = real::max(-pair.h_a[i], real::min(pair.h_a[i], along));
  return at;
}

}  // namespace

template <class S> bool box_manifold(const BoxPair<S>& pair, S margin, Manifold<S>& out) {
  const S limit = margin + pair.radius_a + pair.radius_b;
  BoxAxis<S> axis;
  if (!greatest_gap(pair, limit, axis)) return false;
  if (axis.kind != BoxAxisKind::edges) {
    const bool by_a = axis.kind == BoxAxisKind::face_a;
    S deepest;
    if (!flat_faces(pair, axis.normal_W, margin, out, deepest))
      out = face_manifold(pair, by_a, by_a ? axis.i : axis.j, axis.normal_W, margin, deepest);
    // Apart, a face's axis shows the distance only where the faces lie over each other.
    if (!(axis.gap > S(0)) || deepest <= axis.gap + S(8) * real::epsilon<S>() * pair.size) return true;
  }
  if (axis.kind == BoxAxisKind::edges && !(axis.gap > S(0))) {
    edge_manifold(pair, edge_contact(pair, axis), ManifoldType::edge_edge, margin, out);
    return true;
  }
  const BoxClosest<S> closest = closest_of_boxes(pair);
  if (!(closest.distance <= limit)) return false;
  const ManifoldType type =
      is_edge(closest.feature_a) && is_edge(closest.feature_b) ? ManifoldType::edge_edge : ManifoldType::point;
  const EdgeContact<S> at{closest.normal_W, closest.distance, closest.on_a, closest.feature_a, closest.feature_b};
  edge_manifold(pair, at, type, margin, out);
  return true;
}

template <class S>
void box_box_contacts(const Posed<S>& a, const Posed<S>& b, S margin, std::vector<Manifold<S>>& out) {
  Manifold<S> manifold;
  if (box_manifold(box_pair(a.shape, a.pose, b.shape, b.pose), margin, manifold)) out.push_back(manifold);
}

template <class S> Separation<S> box_box_separation(const Posed<S>& a, const Posed<S>& b) {
  Manifold<S> m;
  box_manifold(box_pair(a.shape, a.pose, b.shape, b.pose), std::numeric_limits<S>::infinity(), m);
  const ContactPoint<S>* deepest = &m.points[0];
  for (int i = 1; i < m.count; ++i)
    if (m.points[static_cast<std::size_t>(i)].gap < deepest->gap) deepest = &m.points[static_cast<std::size_t>(i)];
  const Vec3<S> half = (deepest->gap / S(2)) * m.normal_W;
  return {deepest->gap, m.normal_W, deepest->x_W - half, deepest->x_W + half};
}

#define ATWOOD_BOX_PAIRS(S)                                                                          \
  template bool box_manifold<S>(const BoxPair<S>&, S, Manifold<S>&);                                 \
  template void box_box_contacts<S>(const Posed<S>&, const Posed<S>&, S, std::vector<Manifold<S>>&); \
  template Separation<S> box_box_separation<S>(const Posed<S>&, const Posed<S>&);
ATWOOD_BOX_PAIRS(float)
ATWOOD_BOX_PAIRS(double)
ATWOOD_BOX_PAIRS(long double)
#undef ATWOOD_BOX_PAIRS

}  // namespace atwood
