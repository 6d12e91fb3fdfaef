// Clipping one box's face by another's: Sutherland and Hodgman (1974), in the reference face's own coordinates.
#include <cassert>
#include <limits>
#include <utility>

#include "collision/box_pair.hpp"
#include "collision/capsule_surface.hpp"

namespace atwood {

namespace {

// The two boxes in the axes of the reference box.
template <class S> struct FacePair {
  std::array<S, 3> h, incident_h, t,
      n;                              // half extents; vector to the incident box's centre; the normal towards it (unit)
  std::array<std::array<S, 3>, 3> R;  // R[i][j] = reference axis i . incident axis j
  int k, l;                           // the faces' axes
  S sign, incident_sign;              // +1: the face at +h of that axis, -1: at -h
  S round_off;                        // of points on the face
};

template <class S> FacePair<S> face_pair(const BoxPair<S>& pair, bool reference_is_a, int k, const Vec3<S>& normal_W) {
  FacePair<S> f;
  f.k = k;
  const Vec3<S>* axis = reference_is_a ? pair.pose_a->axis_W : pair.pose_b->axis_W;
  const Vec3<S>* other = reference_is_a ? pair.pose_b->axis_W : pair.pose_a->axis_W;
  const S away = reference_is_a ? S(1) : S(-1);
  S largest = S(-1);
  for (int i = 0; i < 3; ++i) {
    f.n[i] = away * dot(normal_W, axis[i]);
    f.t[i] = reference_is_a ? pair.t_a[i] : -pair.t_b[i];
    for (int j = 0; j < 3; ++j) f.R[i][j] = reference_is_a ? pair.R[i][j] : pair.R[j][i];
    const S along = away * dot(normal_W, other[i]);
    if (real::abs(along) > largest) largest = real::abs(along), f.l = i, f.incident_sign = along > S(0) ? S(-1) : S(1);
  }
  f.h = reference_is_a ? pair.h_a : pair.h_b;
  f.incident_h = reference_is_a ? pair.h_b : pair.h_a;
  f.sign = f.n[k] < S(0) ? S(-1) : S(1);
  f.round_off = S(8) * real::epsilon<S>() * pair.size;
  return f;
}

// ---- the polygon --------------------------------------------------------------------------------------------------
// A corner of it: place on the reference face, gap along the normal, the features that meet there, and what the side to
// the next corner lies on: the incident face's side 0..3, or 4 + the reference's side.
template <class S> struct Corner {
  S u, v, gap;
  int feature, incident_feature, side;
  S thickness;  // from the reference's core to its surface, along the normal
};
template <class S> struct Polygon {
  static constexpr int kMaxCorners = 12;  // four corners, and one more for each side that cuts; round-off can add some
  std::array<Corner<S>, kMaxCorners> corners;
  int count = 0;
  void add(const Corner<S>& c) {
    assert(count < kMaxCorners);
    if (count < kMaxCorners) corners[static_cast<std::size_t>(count++)] = c;
  }
  Corner<S>& operator[](int i) { return corners[static_cast<std::size_t>(i)]; }
  const Corner<S>& operator[](int i) const { return corners[static_cast<std::size_t>(i)]; }
};

template <class S> void project_incident_face(const FacePair<S>& f, Polygon<S>& polygon) {
  const int u = next_axis(f.k), v = next_axis(u), l1 = next_axis(f.l), l2 = next_axis(l1);
  // Centre and half sides of the incident face, as (u, v, gap): moved along the normal onto the reference face.
  const auto projected = [&](S x_u, S x_v, S x_k) {
    const S gap = x_k / f.n[f.k];
    return std::array<S, 3>{x_u - gap * f.n[u], x_v - gap * f.n[v], gap};
  };
  const auto along = [&](int j, S s) { return projected(s * f.R[u][j], s * f.R[v][j], s * f.R[f.k][j]); };
  const auto depth = f.incident_sign * f.incident_h[f.l];
  const auto c = projected(f.t[u] + depth * f.R[u][f.l], f.t[v] + depth * f.R[v][f.l],
                           f.t[f.k] + depth * f.R[f.k][f.l] - f.sign * f.h[f.k]);
  const auto p = along(l1, f.incident_h[l1]), q = along(l2, f.incident_h[l2]);
  const int face = kFeatureNone + static_cast<int>(f.sign) * kFeatureWeight[f.k];
  const int incident_face = kFeatureNone + static_cast<int>(f.incident_sign) * kFeatureWeight[f.l];
  for (int side = 0; side < 4; ++side) {  // (+, +), (-, +), (-, -), (+, -)
    const int s1 = side == 0 || side == 3 ? 1 : -1, s2 = side < 2 ? 1 : -1;
    polygon.add({c[0] + S(s1) * p[0] + S(s2) * q[0], c[1] + S(s1) * p[1] + S(s2) * q[1],
                 c[2] + S(s1) * p[2] + S(s2) * q[2], face,
                 incident_face + s1 * kFeatureWeight[l1] + s2 * kFeatureWeight[l2], side, S(0)});
  }
}

// The features that meet where the polygon's side crosses the reference's side `cut` (0: u = +h, 1: u = -h, 2, 3: v
// likewise).
template <class S> void set_features(const FacePair<S>& f, int side, int cut, Corner<S>& at) {
  const int u = next_axis(f.k), v = next_axis(u), l1 = next_axis(f.l), l2 = next_axis(l1);
  const auto sides = [&](int which) { return (which % 2 == 0 ? 1 : -1) * kFeatureWeight[which < 2 ? u : v]; };
  at.feature = kFeatureNone + static_cast<int>(f.sign) * kFeatureWeight[f.k] + sides(cut);
  at.incident_feature = kFeatureNone + static_cast<int>(f.incident_sign) * kFeatureWeight[f.l];
  if (side >= 4) at.feature += sides(side - 4);  // a corner of the reference face over the incident face
  else at.incident_feature += (side == 0 || side == 3 ? 1 : -1) * kFeatureWeight[side % 2 == 0 ? l2 : l1];
}

// False: nothing lies beyond the side, and `kept` is not written.
template <class S> bool clip(const FacePair<S>& f, int cut, const Polygon<S>& polygon, Polygon<S>& kept) {
  const S sign = cut % 2 == 0 ? S(1) : S(-1), h = f.h[next_axis(cut < 2 ? f.k : next_axis(f.k))];
  const auto coordinate = [cut](const Corner<S>& c) { return cut < 2 ? c.u : c.v; };
  // Points within round-off of the side stay: clipping them would cut an end off a capsule parallel to another.
  const auto beyond = [&](const Corner<S>& c) { return sign * coordinate(c) > h + f.round_off; };
  bool any = false;
  for (int i = 0; i < polygon.count; ++i) any = any || beyond(polygon[i]);
  if (!any) return false;
  const S tolerance = S(1e-3) * (f.h[next_axis(f.k)] + f.h[next_axis(next_axis(f.k))]);
  const Corner<S>* inherited = nullptr;
  kept.count = 0;
  for (int i = 0; i < polygon.count; ++i) {
    const Corner<S>& p = polygon[i];
    const Corner<S>& q = polygon[i + 1 == polygon.count ? 0 : i + 1];
    const bool p_out = beyond(p), q_out = beyond(q);
    if (!p_out) kept.add(p);
    if (p_out == q_out) continue;
    const S way = (sign * h - coordinate(p)) / (coordinate(q) - coordinate(p));
    const S part = real::max(S(0), real::min(S(1), way));  // within round-off of the side both ends may lie beyond it
    const auto between = [part](S x, S y) { return x + part * (y - x); };
    Corner<S> at{between(p.u, q.u), between(p.v, q.v), between(p.gap, q.gap), 0, 0, q_out ? 4 + cut : p.side, S(0)};
    (cut < 2 ? at.u : at.v) = sign * h;
    set_features(f, p.side, cut, at);
    // A corner cut off within `tolerance` passes its features to one of the two new corners, so that the ids of flush
    // boxes do not change by round-off.
    const Corner<S>& lost = q_out ? q : p;
    if (real::abs(lost.u - at.u) + real::abs(lost.v - at.v) <= tolerance && &lost != inherited) {
      at.feature = lost.feature, at.incident_feature = lost.incident_feature;
      inherited = &lost;
    }
    kept.add(at);
  }
  return true;
}

// Neighbours that are one point to round-off, the last and the first among them.
template <class S> void remove_duplicates(Polygon<S>& polygon, S tolerance) {
  const auto same = [tolerance](const Corner<S>& p, const Corner<S>& q) {
    return real::abs(p.u - q.u) <= tolerance && real::abs(p.v - q.v) <= tolerance &&
           real::abs(p.gap - q.gap) <= tolerance;
  };
  int kept = 0;
  for (int i = 0; i < polygon.count; ++i) {
    if (kept > 0 && (same(polygon[i], polygon[kept - 1]) || (i + 1 == polygon.count && same(polygon[i], polygon[0]))))
      continue;
    if (kept != i) polygon[kept] = polygon[i];
    ++kept;
  }
  polygon.count = kept;
}

// Of more than four corners, the deepest and the three that span the largest quadrangle with it.
template <class S> void keep_four(Polygon<S>& polygon) {
  const int n = polygon.count;
  int deepest = 0;
  for (int i = 1; i < n; ++i)
    if (polygon[i].gap < polygon[deepest].gap) deepest = i;
  std::array<int, Polygon<S>::kMaxCorners> index;  // onwards from the deepest, and where they lie from there
  std::array<S, Polygon<S>::kMaxCorners> u, v;
  for (int i = 0, at = deepest; i < n; ++i, at = at + 1 == n ? 0 : at + 1)
    index[i] = at, u[i] = polygon[at].u - polygon[deepest].u, v[i] = polygon[at].v - polygon[deepest].v;
  S largest = S(-1);
  std::array<int, 3> best{1, 2, 3};
  for (int j = 2; j < n - 1; ++j) {  // diagonals 0-j and i-k: twice the area is their product
    for (int i = 1; i < j; ++i) {
      for (int k = j + 1; k < n; ++k) {
        const S area = real::abs(u[j] * (v[k] - v[i]) - v[j] * (u[k] - u[i]));
        if (area > largest) largest = area, best = {i, j, k};
      }
    }
  }
  const std::array<Corner<S>, 4> four{polygon[deepest], polygon[index[best[0]]], polygon[index[best[1]]],
                                      polygon[index[best[2]]]};
  for (int i = 0; i < 4; ++i) polygon[i] = four[i];
  polygon.count = 4;
}

// Turns the gap of the cores into that of the surfaces.
template <class S> void subtract_radii(const FacePair<S>& f, S radius, S other_radius, Corner<S>& c) {
  std::array<S, 3> x;
  x[f.k] = f.sign * f.h[f.k], x[next_axis(f.k)] = c.u, x[next_axis(next_axis(f.k))] = c.v;
  S cosine = S(0), along = S(0);
  for (int i = 0; i < 3; ++i) cosine += f.n[i] * f.R[i][2], along += (x[i] + c.gap * f.n[i] - f.t[i]) * f.R[i][2];
  c.thickness = core_to_surface(radius, f.h[2], x[2], f.n[2]);
  c.gap -= c.thickness + core_to_surface(other_radius, f.incident_h[2], along, -cosine);
}

}  // namespace

template <class S>
Manifold<S> face_manifold(const BoxPair<S>& pair, bool reference_is_a, int k, const Vec3<S>& normal_W, S margin,
                          S& deepest) {
  const FacePair<S> f = face_pair(pair, reference_is_a, k, normal_W);
  Polygon<S> buffers[2];
  Polygon<S>*polygon = &buffers[0], *spare = &buffers[1];
  project_incident_face(f, *polygon);
  Corner<S> lowest = (*polygon)[0];
  for (int i = 1; i < 4; ++i)
    if ((*polygon)[i].gap < lowest.gap) lowest = (*polygon)[i];
  for (int cut = 0; cut < 4; ++cut)
    if (clip(f, cut, *polygon, *spare)) std::swap(polygon, spare);
  Polygon<S>& near = *polygon;

  const S radius = reference_is_a ? pair.radius_a : pair.radius_b;
  const S other_radius = reference_is_a ? pair.radius_b : pair.radius_a;
  deepest = std::numeric_limits<S>::infinity();
  if (near.count == 0) {  // the faces do not overlap; of overlapping boxes by round-off only
    const S u = f.h[next_axis(k)], v = f.h[next_axis(next_axis(k))];
    lowest.u = real::max(-u, real::min(u, lowest.u)), lowest.v = real::max(-v, real::min(v, lowest.v));
    near.add(lowest);
  } else {
    for (int i = 0; i < near.count; ++i) deepest = real::min(deepest, near[i].gap);
  }
  S least = std::numeric_limits<S>::infinity();
  for (int i = 0; i < near.count; ++i) {
    if (radius > S(0) || other_radius > S(0)) subtract_radii(f, radius, other_radius, near[i]);
    least = real::min(least, near[i].gap);
  }
  int kept = 0;
  for (int i = 0; i < near.count; ++i) {
    if (!(near[i].gap <= margin || near[i].gap <= least + f.round_off)) continue;
    if (kept != i) near[kept] = near[i];
    ++kept;
  }
  near.count = kept;
  remove_duplicates(near, f.round_off);
  if (near.count > 4) keep_four(near);

  Manifold<S> m;
  m.normal_W = normal_W;
  m.type = near.count > 2 ? ManifoldType::face : near.count == 2 ? ManifoldType::edge : ManifoldType::point;
  m.count = near.count;
  const Transform<S>& pose = reference_is_a ? *pair.pose_a : *pair.pose_b;
  const Vec3<S> outward = reference_is_a ? normal_W : -normal_W;  // from the reference to the other
  for (int i = 0; i < near.count; ++i) {
    const Corner<S>& c = near[i];
    const Vec3<S> on_reference = c.u * pose.axis_W[next_axis(k)] + c.v * pose.axis_W[next_axis(next_axis(k))] +
                                 (f.sign * f.h[k]) * pose.axis_W[k];
    m.points[static_cast<std::size_t>(i)] = {pose.p_W + (on_reference + (c.thickness + c.gap / S(2)) * outward), c.gap,
                                             feature_id(normal_W, reference_is_a ? c.feature : c.incident_feature,
                                                        reference_is_a ? c.incident_feature : c.feature)};
  }
  return m;
}

#define ATWOOD_BOX_FACES(S) template Manifold<S> face_manifold<S>(const BoxPair<S>&, bool, int, const Vec3<S>&, S, S&);
ATWOOD_BOX_FACES(float)
ATWOOD_BOX_FACES(double)
ATWOOD_BOX_FACES(long double)
#undef ATWOOD_BOX_FACES

}  // namespace atwood
