#include "collision/expanding_polytope.hpp"

#include <limits>
#include <utility>

namespace atwood {
namespace {

template <class S> struct Polytope {
  static constexpr int kMaxPoints = 160, kMaxFaces = 2 * kMaxPoints;
  struct Face {
    int corner[3];
    int across[3];   // the face beyond corner[k] -> corner[k + 1]
    Vec3<S> normal;  // unit, outwards
    S offset{};      // signed distance of the origin, positive inside
    bool on_hull = true;
  };
  struct HorizonEdge {
    int from, to, outside;
  };

  DifferencePoint<S> point[kMaxPoints];
  Face face[kMaxFaces];
  HorizonEdge horizon[kMaxFaces];
  int stack[kMaxFaces];
  int points = 0, faces = 0, horizon_edges = 0;

  // False when it has no area.
  bool set(int f, int i, int j, int k) {
    Face& made = face[f];
    made.corner[0] = i, made.corner[1] = j, made.corner[2] = k;
    made.on_hull = true;
    // The corner opposite to the longest side gives the least round-off.
    const Vec3<S>&p = point[i].w, &q = point[j].w, &r = point[k].w;
    const Vec3<S> pq = q - p, qr = r - q, rp = p - r;
    const S a = dot(pq, pq), b = dot(qr, qr), c = dot(rp, rp);
    made.normal = unit_vector(a >= b && a >= c ? cross(qr, rp) : b >= c ? cross(rp, pq) : cross(pq, qr));
    made.offset = dot(made.normal, p);
    return dot(made.normal, made.normal) > S(0);
  }
};

// A tetrahedron with volume; false when A - B is flat, and then `normal` is across it.
template <class S, class Support>
bool first_tetrahedron(Polytope<S>& polytope, const Support& farthest, Vec3<S>& normal, S& extent) {
  const Vec3<S> axes[3] = {{S(1), S(0), S(0)}, {S(0), S(1), S(0)}, {S(0), S(0), S(1)}};
  DifferencePoint<S>* p = polytope.point;
  const auto flat = [&](S size) { return size <= S(64) * real::epsilon<S>() * extent; };
  S widest{};
  for (const Vec3<S>& axis : axes) {
    const DifferencePoint<S> high = farthest(axis), low = farthest(-axis);
    extent = real::max(extent, real::max(real::max(largest_component(high.w), largest_component(low.w)),
                                         real::max(real::max(largest_component(high.a), largest_component(high.b)),
                                                   real::max(largest_component(low.a), largest_component(low.b)))));
    if (const S width = norm(high.w - low.w); p[0].vertex_a == -2 || width > widest)
      widest = width, p[0] = low, p[1] = high;
  }
  normal = axes[2];
  if (flat(widest)) return false;
  const Vec3<S> along = unit_vector(p[1].w - p[0].w);
  const Vec3<S> least = real::abs(along.x) <= real::abs(along.y) && real::abs(along.x) <= real::abs(along.z) ? axes[0]
                        : real::abs(along.y) <= real::abs(along.z)                                           ? axes[1]
                                                                                                             : axes[2];
  const Vec3<S> u = unit_vector(cross(along, least)), v = cross(along, u);
  const auto off_line = [&](const DifferencePoint<S>& q) { return norm(cross(along, q.w - p[0].w)); };
  S most{-1};
  for (const Vec3<S>& d : {u, -u, v, -v}) {
    const DifferencePoint<S> q = farthest(d);
    if (const S off = off_line(q); off > most) most = off, p[2] = q;
  }
  normal = u;
  if (flat(most)) return false;
  normal = unit_vector(cross(p[1].w - p[0].w, p[2].w - p[0].w));
  const DifferencePoint<S> above = farthest(normal), below = farthest(-normal);
  const S up = dot(normal, above.w - p[0].w), down = dot(normal, p[0].w - below.w);
  if (flat(real::max(up, down))) return false;
  p[3] = up >= down ? above : below;
  if (up >= down) std::swap(p[1], p[2]);  // 0 1 2 looks away from 3
  polytope.points = 4;
  return true;
}

// Removes the faces visible from the new point and joins the point to their horizon. False when round-off leaves no
// closed horizon.
template <class S> bool grow(Polytope<S>& polytope, int visible, int point) {
  const Vec3<S>& w = polytope.point[point].w;
  polytope.horizon_edges = 0;
  int height = 0;
  polytope.stack[height++] = visible;
  polytope.face[visible].on_hull = false;
  while (height > 0) {
    const auto& face = polytope.face[polytope.stack[--height]];
    for (int k = 0; k < 3; ++k) {
      const int next = face.across[k];
      auto& beyond = polytope.face[next];
      if (!beyond.on_hull) continue;
      if (dot(beyond.normal, w) > beyond.offset) {
        beyond.on_hull = false;
        polytope.stack[height++] = next;
      }
    }
  }
  for (int f = 0; f < polytope.faces; ++f) {
    auto& inner = polytope.face[f];
    if (inner.on_hull || inner.corner[0] < 0) continue;
    for (int k = 0; k < 3; ++k)
      if (polytope.face[inner.across[k]].on_hull)
        polytope.horizon[polytope.horizon_edges++] = {inner.corner[k], inner.corner[(k + 1) % 3], inner.across[k]};
  }
  for (int f = 0; f < polytope.faces; ++f)
    if (!polytope.face[f].on_hull) polytope.face[f].corner[0] = -1;
  int free = 0, made[Polytope<S>::kMaxFaces];
  for (int r = 0; r < polytope.horizon_edges; ++r) {
    while (free < polytope.faces && polytope.face[free].corner[0] >= 0) ++free;
    if (free == polytope.faces && ++polytope.faces > Polytope<S>::kMaxFaces) return false;
    made[r] = free;
    if (!polytope.set(free, polytope.horizon[r].from, polytope.horizon[r].to, point)) return false;
  }
  for (int r = 0; r < polytope.horizon_edges; ++r) {
    const auto& edge = polytope.horizon[r];
    auto& face = polytope.face[made[r]];
    auto& outside = polytope.face[edge.outside];
    face.across[0] = edge.outside;
    face.across[1] = face.across[2] = -1;
    for (int k = 0; k < 3; ++k)
      if (outside.corner[k] == edge.to && outside.corner[(k + 1) % 3] == edge.from) outside.across[k] = made[r];
    for (int s = 0; s < polytope.horizon_edges; ++s) {
      if (polytope.horizon[s].from == edge.to) face.across[1] = face.across[1] < 0 ? made[s] : -2;
      if (polytope.horizon[s].to == edge.from) face.across[2] = face.across[2] < 0 ? made[s] : -2;
    }
    if (face.across[1] < 0 || face.across[2] < 0) return false;
  }
  return true;
}

template <class S> int nearest_face(const Polytope<S>& polytope) {
  int best = -1;
  for (int f = 0; f < polytope.faces; ++f)
    if (polytope.face[f].on_hull && (best < 0 || polytope.face[f].offset < polytope.face[best].offset)) best = f;
  return best;
}

template <class S> void set_face(LeastOverlap<S>& result, const Polytope<S>& polytope, int f) {
  result.face = {};
  for (const int corner : polytope.face[f].corner) result.face.corner[result.face.count++] = polytope.point[corner];
}

}  // namespace

template <class S>
LeastOverlap<S> expanding_polytope(const ConvexPart<S>& a, const ConvexPart<S>& b, const Transform<S>& b_in_a) {
  Polytope<S> polytope;
  LeastOverlap<S> result;
  const auto farthest = [&](const Vec3<S>& d) { return difference_support(a, b, b_in_a, d); };
  S extent{};
  polytope.point[0].vertex_a = -2;  // none yet
  result.certified = -std::numeric_limits<S>::infinity();
  constexpr int start[4][3] = {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}},
                next[4][3] = {{1, 2, 3}, {3, 2, 0}, {1, 3, 0}, {2, 1, 0}};
  bool solid = first_tetrahedron(polytope, farthest, result.normal, extent);
  polytope.faces = 4;
  for (int f = 0; f < 4 && solid; ++f) {
    solid = polytope.set(f, start[f][0], start[f][1], start[f][2]);  // a face without a normal is a sliver's
    for (int k = 0; k < 3; ++k) polytope.face[f].across[k] = next[f][k];
  }
  if (!solid) {
    const DifferencePoint<S> p = farthest(result.normal), q = farthest(-result.normal);
    const S front = dot(result.normal, p.w), back = -dot(result.normal, q.w);
    if (back < front) result.normal = -result.normal;
    result.overlap = real::min(front, back);
    result.face.corner[0] = back < front ? q : p;
    result.face.count = 1;
    return result;
  }
  const S round_off = S(8) * real::epsilon<S>() * extent;
  result.overlap = std::numeric_limits<S>::infinity();
  while (true) {
    const int f = nearest_face(polytope);
    if (f < 0) break;
    const auto& face = polytope.face[f];
    const DifferencePoint<S> p = farthest(face.normal);
    const S overlap = dot(face.normal, p.w);
    if (overlap < result.overlap) {
      result.overlap = overlap;
      result.normal = face.normal;
      set_face(result, polytope, f);
    }
    result.certified = face.offset;
    if (overlap - face.offset <= round_off || result.overlap <= face.offset ||
        polytope.points == Polytope<S>::kMaxPoints)
      break;
    polytope.point[polytope.points] = p;
    if (!grow(polytope, f, polytope.points++)) break;
  }
  result.points = polytope.points - 4;
  return result;
}

#define ATWOOD_EXPANDING_POLYTOPE(S) \
  template LeastOverlap<S> expanding_polytope<S>(const ConvexPart<S>&, const ConvexPart<S>&, const Transform<S>&);
ATWOOD_EXPANDING_POLYTOPE(float)
ATWOOD_EXPANDING_POLYTOPE(double)
ATWOOD_EXPANDING_POLYTOPE(long double)
#undef ATWOOD_EXPANDING_POLYTOPE

}  // namespace atwood
