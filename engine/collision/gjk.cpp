#include "collision/gjk.hpp"

#include <limits>
#include <utility>

namespace atwood {
namespace {

template <class S> Simplex<S> subset(const Simplex<S>& from, std::initializer_list<int> which) {
  Simplex<S> part;
  for (const int i : which) part.corner[part.count++] = from.corner[i];
  return part;
}

template <class S> Vec3<S> nearest_on_edge(Simplex<S>& s) {
  const Vec3<S>&p = s.corner[0].w, &q = s.corner[1].w;
  const Vec3<S> along = q - p;
  const S from_p = -dot(p, along), from_q = dot(q, along);  // times |along|: how far the origin's foot lies from p, q
  if (from_p > S(0) && from_q > S(0)) {
    s.weight[1] = from_p / (from_p + from_q);
    s.weight[0] = from_q / (from_p + from_q);
    return p + s.weight[1] * along;
  }
  s = subset(s, {from_p > S(0) ? 1 : 0});
  s.weight[0] = S(1);
  return s.corner[0].w;
}

// Signed areas of the three sub-triangles at the foot of the perpendicular, projected along the normal's largest
// component.
template <class S> Vec3<S> nearest_on_triangle(Simplex<S>& s) {
  const Vec3<S>&p = s.corner[0].w, &q = s.corner[1].w, &r = s.corner[2].w;
  const Vec3<S> pq = q - p, pr = r - p, area = cross(pq, pr);
  const S size = largest_component(area),
          noise = S(8) * real::epsilon<S>() * largest_component(pq) * largest_component(pr);
  bool may_hold_nearest[3] = {true, true, true};  // the edge opposite to corner i may hold the nearest point
  if (size > noise) {
    const Vec3<S> normal = unit_vector(area);
    const S height = dot(normal, p);
    const Vec3<S> foot = height * normal, a = p - foot, b = q - foot, c = r - foot;
    const auto signed_area = [&](const Vec3<S>& u, const Vec3<S>& v) {
      if (size == real::abs(area.x)) return (u.y * v.z - u.z * v.y) * (area.x < S(0) ? S(-1) : S(1));
      if (size == real::abs(area.y)) return (u.z * v.x - u.x * v.z) * (area.y < S(0) ? S(-1) : S(1));
      return (u.x * v.y - u.y * v.x) * (area.z < S(0) ? S(-1) : S(1));
    };
    const S part[3] = {signed_area(b, c), signed_area(c, a), signed_area(a, b)};
    if (part[0] > S(0) && part[1] > S(0) && part[2] > S(0)) {
      const S whole = part[0] + part[1] + part[2];
      for (int i = 0; i < 3; ++i) s.weight[i] = part[i] / whole;
      return foot;
    }
    for (int i = 0; i < 3; ++i) may_hold_nearest[i] = !(part[i] > S(0));
  }
  constexpr int opposite[3][2] = {{1, 2}, {2, 0}, {0, 1}};
  Simplex<S> best;
  Vec3<S> nearest;
  for (int i = 0; i < 3; ++i) {
    if (!may_hold_nearest[i]) continue;
    Simplex<S> edge = subset(s, {opposite[i][0], opposite[i][1]});
    const Vec3<S> v = nearest_on_edge(edge);
    if (best.count == 0 || dot(v, v) < dot(nearest, nearest)) best = edge, nearest = v;
  }
  s = best;
  return nearest;
}

template <class S> Vec3<S> nearest_in_tetrahedron(Simplex<S>& s) {
  const Vec3<S>&p = s.corner[0].w, &q = s.corner[1].w, &r = s.corner[2].w, &t = s.corner[3].w;
  const Vec3<S> edge[3] = {q - p, r - p, t - p};
  const S whole = dot(edge[0], cross(edge[1], edge[2]));
  const S noise =
      S(32) * real::epsilon<S>() * largest_component(edge[0]) * largest_component(edge[1]) * largest_component(edge[2]);
  bool may_hold_nearest[4] = {true, true, true, true};
  if (real::abs(whole) > noise) {
    const S sign = whole < S(0) ? S(-1) : S(1);
    const Vec3<S> rt = cross(r - q, t - q);
    const S part[4] = {sign * dot(q, rt), -sign * dot(p, cross(edge[1], edge[2])),
                       -sign * dot(p, cross(edge[2], edge[0])), -sign * dot(p, cross(edge[0], edge[1]))};
    if (part[0] >= S(0) && part[1] >= S(0) && part[2] >= S(0) && part[3] >= S(0)) {
      const S sum = part[0] + part[1] + part[2] + part[3];
      for (int i = 0; i < 4; ++i) s.weight[i] = part[i] / sum;
      return {};
    }
    for (int i = 0; i < 4; ++i) may_hold_nearest[i] = part[i] < S(0);
  }
  constexpr int opposite[4][3] = {{1, 2, 3}, {0, 2, 3}, {0, 1, 3}, {0, 1, 2}};
  Simplex<S> best;
  Vec3<S> nearest;
  for (int i = 0; i < 4; ++i) {
    if (!may_hold_nearest[i]) continue;
    Simplex<S> face = subset(s, {opposite[i][0], opposite[i][1], opposite[i][2]});
    const Vec3<S> v = nearest_on_triangle(face);
    if (best.count == 0 || dot(v, v) < dot(nearest, nearest)) best = face, nearest = v;
  }
  s = best;
  return nearest;
}

template <class S> bool contains(const Simplex<S>& simplex, const Vec3<S>& w) {
  for (int i = 0; i < simplex.count; ++i) {
    const Vec3<S>& c = simplex.corner[i].w;
    if (c.x == w.x && c.y == w.y && c.z == w.z) return true;
  }
  return false;
}

template <class S> void set_witnesses(Closest<S>& closest) {
  closest.on_a = closest.on_b = {};
  for (int i = 0; i < closest.simplex.count; ++i) {
    closest.on_a += closest.simplex.weight[i] * closest.simplex.corner[i].a;
    closest.on_b += closest.simplex.weight[i] * closest.simplex.corner[i].b;
  }
}

}  // namespace

template <class S> Vec3<S> nearest_to_origin(Simplex<S>& simplex) {
  switch (simplex.count) {
    case 1: simplex.weight[0] = S(1); return simplex.corner[0].w;
    case 2: return nearest_on_edge(simplex);
    case 3: return nearest_on_triangle(simplex);
    default: return nearest_in_tetrahedron(simplex);
  }
}

template <class S>
DifferencePoint<S> difference_support(const ConvexPart<S>& a, const ConvexPart<S>& b, const Transform<S>& b_in_a,
                                      const Vec3<S>& direction, int start_a, int start_b) {
  DifferencePoint<S> p;
  p.vertex_a = start_a, p.vertex_b = start_b;
  p.a = support(a, direction, p.vertex_a);
  p.b = point_to_world(b_in_a, support(b, to_body(b_in_a, -direction), p.vertex_b));
  p.w = p.a - p.b;
  return p;
}

template <class S>
Closest<S> closest_points(const ConvexPart<S>& a, const ConvexPart<S>& b, const Transform<S>& b_in_a, S max_distance) {
  constexpr int max_iterations = 200;  // curved cores gain about a digit in two iterations
  constexpr int max_stagnations = 4;
  const S round_off = S(8) * real::epsilon<S>();
  Closest<S> closest;
  Simplex<S>& simplex = closest.simplex;
  Vec3<S> v = dot(b_in_a.p_W, b_in_a.p_W) > S(0) ? -b_in_a.p_W : Vec3<S>{S(1), S(0), S(0)};
  S extent{}, least = std::numeric_limits<S>::infinity();
  int start_a = 0, start_b = 0, stagnations = 0;
  SolveReport& solve = closest.solve;
  solve.ended = SolveEnd::capped;
  S misfit{}, length{};
  for (int iteration = 0; iteration < max_iterations; ++iteration) {
    const DifferencePoint<S> p = difference_support(a, b, b_in_a, -v, start_a, start_b);
    start_a = p.vertex_a, start_b = p.vertex_b;
    extent =
        real::max(extent, real::max(largest_component(p.w), real::max(largest_component(p.a), largest_component(p.b))));
    length = norm(v);
    const S toward = dot(v, p.w);
    misfit = length * length - toward;  // the distance lies between toward / |v| and |v|
    solve.iterations = iteration + 1;
    if (toward > max_distance * length) {
      solve.ended = SolveEnd::converged;
      closest.apart = closest.out_of_range = true;
      closest.normal = (S(-1) / length) * v;
      return closest;
    }
    if (simplex.count > 0 && (contains(simplex, p.w) || misfit <= round_off * extent * length)) {
      solve.ended = SolveEnd::converged;
      break;
    }
    Simplex<S> next = simplex;
    next.corner[next.count++] = p;
    const Vec3<S> nearer = nearest_to_origin(next);
    const S size = norm(nearer);
    // An error d of the direction changes |v| by d^2 only, so |v| may stagnate while the direction still improves.
    if (simplex.count > 0 && !(size < least) &&
        (size > least + round_off * extent || ++stagnations > max_stagnations)) {
      solve.ended = SolveEnd::stagnated;
      break;
    }
    simplex = next;
    v = nearer;
    least = real::min(size, least);
    if (simplex.count == 4 || size <= round_off * extent) {
      solve.ended = SolveEnd::converged;
      set_witnesses(closest);
      return closest;
    }
  }
  solve.residual = static_cast<double>(real::max(S(0), misfit) / (extent * length));
  set_witnesses(closest);
  closest.apart = true;
  closest.distance = norm(v);
  closest.normal = unit_vector(-v);
  return closest;
}

#define ATWOOD_GJK(S)                                                                                                \
  template Vec3<S> nearest_to_origin<S>(Simplex<S>&);                                                                \
  template DifferencePoint<S> difference_support<S>(const ConvexPart<S>&, const ConvexPart<S>&, const Transform<S>&, \
                                                    const Vec3<S>&, int, int);                                       \
  template Closest<S> closest_points<S>(const ConvexPart<S>&, const ConvexPart<S>&, const Transform<S>&, S);
ATWOOD_GJK(float)
ATWOOD_GJK(double)
ATWOOD_GJK(long double)
#undef ATWOOD_GJK

}  // namespace atwood
