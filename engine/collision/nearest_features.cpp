#include "collision/nearest_features.hpp"

#include <limits>

namespace atwood {
namespace {

template <class S> S extent_of(const ConvexPart<S>& a, const ConvexPart<S>& b, const Transform<S>& b_in_a) {
  const auto size = [](const ConvexPart<S>& p) {
    if (p.core == Core::hull) return p.topology->bounding_radius;
    if (p.core != Core::triangle) return p.half.x + p.half.y + p.half.z;
    return real::max(norm(p.own[0]), real::max(norm(p.own[1]), norm(p.own[2])));
  };
  return real::max(real::max(size(a), size(b)), norm(b_in_a.p_W));
}

// One of the two cores, and its pose in A's axes.
template <class S> struct PlacedCore {
  const ConvexPart<S>& part;
  const Transform<S>& pose;
  S sign;        // outwards along sign * n
  Vec3<S> edge;  // the edge in contact, unit; 0: none
};

template <class S> Vec3<S> axis_of(const PlacedCore<S>& side) { return side.pose.axis_W[2]; }

// The edge of a polyhedron that the corners of a simplex lie on; the axis of a cylinder whose side is in contact.
template <class S> void read_features(PlacedCore<S>& side, const Simplex<S>& simplex, const Vec3<S>& n) {
  side.edge = {};
  if (!side.part.polyhedral()) {
    if (real::abs(dot(n, axis_of(side))) < S(0.1)) side.edge = axis_of(side);
    return;
  }
  int named[4], count = 0;
  for (int i = 0; i < simplex.count; ++i) {
    const int vertex = side.sign > S(0) ? simplex.corner[i].vertex_a : simplex.corner[i].vertex_b;
    bool known = vertex < 0;
    for (int k = 0; k < count; ++k) known = known || named[k] == vertex;
    if (!known) named[count++] = vertex;
  }
  if (count == 2)
    side.edge = to_world(side.pose, unit_vector(side.part.vertices()[named[1]] - side.part.vertices()[named[0]]));
}

// The outward normal of the face nearest to `outwards`; 0 when none is within 26 degrees (cosine 0.9).
template <class S> Vec3<S> nearest_face_normal(const PlacedCore<S>& side, const Vec3<S>& outwards) {
  const Vec3<S> d = to_body(side.pose, outwards);
  if (!side.part.polyhedral()) return d.z < S(0) ? -axis_of(side) : axis_of(side);
  const Vec3<S>* best = nullptr;
  S most{};
  for (const auto& face : side.part.faces())
    if (const S here = dot(face.normal, d); here > most) most = here, best = &face.normal;
  return best && most > S(0.9) ? to_world(side.pose, *best) : Vec3<S>{};
}

// u . H u for the second derivative H of the cylinder's support function at n: the rim's r / |n_across| along its
// tangent.
template <class S>
S support_second_derivative(const PlacedCore<S>& side, const Vec3<S>& n, const Vec3<S>& u, const Vec3<S>& v) {
  if (side.part.polyhedral()) return S(0);
  const Vec3<S> axis = axis_of(side), around = cross(axis, n);
  const S across = norm(around);
  if (!(across > S(0))) return S(0);
  return side.part.half.x * dot(around, u) * dot(around, v) / (across * across * across);
}

template <class S> struct Refinement {
  PlacedCore<S> a, b;
  const Transform<S>& b_in_a;
  S round_off;
  LeastOverlap<S> best;

  DifferencePoint<S> support_along(const Vec3<S>& n) const { return difference_support(a.part, b.part, b_in_a, n); }
  // Accepts n unless it is worse by more than round-off: later candidates are more accurate.
  void consider(const Vec3<S>& n) {
    if (!(dot(n, n) > S(0.5))) return;
    const S overlap = dot(n, support_along(n).w);
    if (!(overlap <= best.overlap + round_off)) return;
    best.overlap = overlap;
    best.normal = n;
  }
  void consider_either_sign(Vec3<S> n) { consider(dot(n, best.normal) < S(0) ? -n : n); }
};

// Newton's method for the least of f(n) = n . w(n) over unit n, or over those across `edge`. In tangents u of the
// sphere: gradient w . u, second derivative u . H u - f.
template <class S> void minimize_by_newton(Refinement<S>& m, const Vec3<S>& edge) {
  const bool bound = dot(edge, edge) > S(0);
  Vec3<S> n = bound ? unit_vector(m.best.normal - dot(m.best.normal, edge) * edge) : m.best.normal;
  for (int round = 0; round < 12; ++round) {
    const Vec3<S> w = m.support_along(n).w;
    const S f = dot(n, w);
    const Vec3<S> least = real::abs(n.x) <= real::abs(n.y) && real::abs(n.x) <= real::abs(n.z)
                              ? Vec3<S>{S(1), S(0), S(0)}
                          : real::abs(n.y) <= real::abs(n.z) ? Vec3<S>{S(0), S(1), S(0)}
                                                             : Vec3<S>{S(0), S(0), S(1)};
    const Vec3<S> u = unit_vector(cross(n, bound ? edge : least)), v = cross(n, u);
    const auto second = [&](const Vec3<S>& p, const Vec3<S>& q) {
      return support_second_derivative(m.a, n, p, q) + support_second_derivative(m.b, n, p, q);
    };
    const S uu = second(u, u) - f, g = dot(w, u);
    S s{}, t{};
    if (bound) {
      if (!(uu > S(0))) return;
      s = -g / uu;
    } else {
      const S uv = second(u, v), vv = second(v, v) - f, h = dot(w, v), whole = uu * vv - uv * uv;
      if (!(whole > S(0) && uu > S(0))) return;
      s = (-g * vv + h * uv) / whole;
      t = (-h * uu + g * uv) / whole;
    }
    const S step = real::sqrt(s * s + t * t);
    if (!(step < S(0.5))) return;
    n = unit_vector(n + s * u + t * v);
    if (step <= S(4) * real::epsilon<S>()) break;
  }
  m.consider(n);
}

template <class S> void refine(Refinement<S>& m, const Simplex<S>& simplex) {
  const bool curved = !m.a.part.polyhedral() || !m.b.part.polyhedral();
  read_features(m.a, simplex, m.best.normal);
  read_features(m.b, simplex, m.best.normal);
  if (curved) {
    minimize_by_newton(m, Vec3<S>{});
    for (const Vec3<S>& edge : {m.a.edge, m.b.edge})
      if (dot(edge, edge) > S(0)) minimize_by_newton(m, edge);
  }
  for (const Vec3<S>& edge : {m.a.edge, m.b.edge})
    if (dot(edge, edge) > S(0)) m.consider(unit_vector(m.best.normal - dot(m.best.normal, edge) * edge));
  m.consider_either_sign(unit_vector(accurate_cross(m.a.edge, m.b.edge)));
  m.consider(nearest_face_normal(m.a, m.best.normal));
  m.consider(-nearest_face_normal(m.b, -m.best.normal));
}

// The extreme feature of a core along sign * n: a vertex (or a rim's point), an edge (or a cylinder's side), or a face.
// `from` and `to` are its ends, in A's axes.
template <class S> struct ExtremeFeature {
  enum Kind { vertex, edge, face } kind = vertex;
  Vec3<S> from, to;
};
template <class S> ExtremeFeature<S> extreme_feature(const PlacedCore<S>& side, const Vec3<S>& n, S round_off) {
  const Vec3<S> d = to_body(side.pose, side.sign * n);
  const ConvexPart<S>& part = side.part;
  int first = -1;
  const Vec3<S> top = support(part, d, first);
  ExtremeFeature<S> found{ExtremeFeature<S>::vertex, top, top};
  if (part.polyhedral()) {
    const S level = dot(d, top) - round_off;
    int count = 0;
    for (const Vec3<S>& v : part.vertices())
      if (dot(d, v) >= level) (count == 0 ? found.from : found.to) = v, ++count;
    found.kind = count < 2 ? ExtremeFeature<S>::vertex : count == 2 ? ExtremeFeature<S>::edge : ExtremeFeature<S>::face;
  } else if (S(2) * part.half.z * real::abs(d.z) <= round_off) {
    found.kind = ExtremeFeature<S>::edge;
    found.from.z = -part.half.z, found.to.z = part.half.z;
  } else if (S(2) * part.half.x * norm(Vec3<S>{d.x, d.y, S(0)}) <= round_off) {
    found.kind = ExtremeFeature<S>::face;
  }
  found.from = point_to_world(side.pose, found.from), found.to = point_to_world(side.pose, found.to);
  return found;
}

// The point of a's edge where two edges perpendicular to n cross in projection along n; of parallel ones, the middle of
// their common stretch.
template <class S> Vec3<S> edge_crossing(const ExtremeFeature<S>& a, const ExtremeFeature<S>& b) {
  const Vec3<S> along_a = a.to - a.from, along_b = b.to - b.from, between = b.from - a.from;
  const Vec3<S> across = accurate_cross(along_a, along_b);
  const S aa = dot(along_a, along_a), square = dot(across, across);
  const auto within = [](S x) { return real::max(S(0), real::min(S(1), x)); };
  constexpr S parallel_sine = S(64) * real::epsilon<S>();
  if (square > parallel_sine * parallel_sine * aa * dot(along_b, along_b))
    return a.from + within(dot(accurate_cross(between, along_b), across) / square) * along_a;
  const S p = within(dot(between, along_a) / aa), q = within(dot(between + along_b, along_a) / aa);
  return a.from + (S(0.5) * (p + q)) * along_a;
}

// Sets the nearest points, a distance `gap` apart along the normal. Those of the simplex are wrong where the polytope
// ended on one half of a parallelogram of edges and the origin is over the other, or on a part of a cylinder.
template <class S> void set_points(const Refinement<S>& m, NearestFeatures<S>& features) {
  const Vec3<S>& n = features.normal;
  const ExtremeFeature<S> a = extreme_feature(m.a, n, S(16) * m.round_off),
                          b = extreme_feature(m.b, n, S(16) * m.round_off);
  constexpr auto vertex_kind = ExtremeFeature<S>::vertex, edge_kind = ExtremeFeature<S>::edge;
  Vec3<S> middle = S(0.5) * (features.on_a + features.on_b);
  if (a.kind == vertex_kind) middle = a.from + (features.gap / S(2)) * n;
  else if (b.kind == vertex_kind) middle = b.from - (features.gap / S(2)) * n;
  else if (a.kind == edge_kind && b.kind == edge_kind) middle = edge_crossing(a, b) + (features.gap / S(2)) * n;
  else features.faces = true, middle += (dot(n, a.from - middle) + features.gap / S(2)) * n;
  features.on_a = middle - (features.gap / S(2)) * n;
  features.on_b = middle + (features.gap / S(2)) * n;
}

template <class S> void set_weights(LeastOverlap<S>& least) {
  if (least.face.count == 0) return;
  Simplex<S> part = least.face;
  nearest_to_origin(part);
  least.on_a = least.on_b = {};
  for (int i = 0; i < part.count; ++i) {
    least.on_a += part.weight[i] * part.corner[i].a;
    least.on_b += part.weight[i] * part.corner[i].b;
  }
}

template <class S, class Visit>
void each_edge(const ConvexPart<S>& part, const Transform<S>& pose, const Visit& visit) {
  if (!part.polyhedral()) visit(pose.axis_W[2]);
  for (const auto& edge : part.edges()) visit(to_world(pose, edge.along));
}
template <class S, class Visit>
void each_face(const ConvexPart<S>& part, const Transform<S>& pose, const Visit& visit) {
  if (!part.polyhedral()) visit(pose.axis_W[2]), visit(-pose.axis_W[2]);
  for (const auto& face : part.faces()) visit(to_world(pose, face.normal));
}

// Normals of faces and caps, and products of edges, a cylinder's axis being one.
template <class S, class Visit>
void each_axis(const ConvexPart<S>& a, const ConvexPart<S>& b, const Transform<S>& b_in_a, const Visit& visit) {
  const Transform<S> own;
  each_face(a, own, visit);
  each_face(b, b_in_a, [&](const Vec3<S>& normal) { visit(-normal); });
  each_edge(b, b_in_a, [&](const Vec3<S>& of_b) {
    each_edge(a, own, [&](const Vec3<S>& of_a) {
      const Vec3<S> n = unit_vector(accurate_cross(of_a, of_b));
      visit(n);
      visit(-n);
    });
  });
}

// For a polytope that did not converge: refinement from every axis and from 26 directions all around.
template <class S> void refine_from_all_axes(Refinement<S>& m) {
  LeastOverlap<S> best = m.best;
  const auto from = [&](const Vec3<S>& n) {
    if (!(dot(n, n) > S(0.5))) return;
    m.best.normal = n;
    m.best.overlap = dot(n, m.support_along(n).w);
    refine(m, Simplex<S>{});
    if (m.best.overlap < best.overlap) best.overlap = m.best.overlap, best.normal = m.best.normal;
  };
  each_axis(m.a.part, m.b.part, m.b_in_a, from);
  for (int i = 0; i < 27; ++i)
    if (i != 13) from(unit_vector(Vec3<S>{S(i % 3 - 1), S(i / 3 % 3 - 1), S(i / 9 - 1)}));
  m.best = best;
}

}  // namespace

template <class S>
S overlap_along(const ConvexPart<S>& a, const ConvexPart<S>& b, const Transform<S>& b_in_a, const Vec3<S>& n) {
  return dot(n, difference_support(a, b, b_in_a, n).w);
}

template <class S>
LeastOverlap<S> least_overlap_of_all_axes(const ConvexPart<S>& a, const ConvexPart<S>& b, const Transform<S>& b_in_a) {
  LeastOverlap<S> best;
  best.overlap = std::numeric_limits<S>::infinity();
  each_axis(a, b, b_in_a, [&](const Vec3<S>& n) {
    if (!(dot(n, n) > S(0.5))) return;
    if (const S overlap = overlap_along(a, b, b_in_a, n); overlap < best.overlap)
      best.overlap = overlap, best.normal = n;
  });
  best.certified = best.overlap;
  return best;
}

// How the search for the direction of least overlap ended. Every axis of two polyhedra tried is as good as a
// certificate; nothing certifies what Newton's method found on round ones, or on shapes that lie in one plane.
template <class S> SolveReport report_of(S overlap, S certified, int points, bool every_axis, S round_off, S extent) {
  const S left = real::max(S(0), real::min(overlap - certified, real::abs(overlap)));
  if (left <= S(16) * round_off) return {points + 1, static_cast<double>(left / extent), SolveEnd::converged};
  if (every_axis) return {points + 1, 0, SolveEnd::converged};
  return {points + 1, static_cast<double>(left / extent), SolveEnd::capped};
}

template <class S>
NearestFeatures<S> nearest_features(const ConvexPart<S>& a, const ConvexPart<S>& b, const Transform<S>& b_in_a,
                                    S max_distance) {
  NearestFeatures<S> features;
  const Transform<S> own;
  const S extent = extent_of(a, b, b_in_a), round_off = S(4) * real::epsilon<S>() * extent;
  const Closest<S> closest = closest_points(a, b, b_in_a, max_distance);
  features.solve.closest_points = closest.solve;
  if (closest.out_of_range) {
    features.out_of_range = true;
    return features;
  }
  Refinement<S> m{{a, own, S(1), {}}, {b, b_in_a, S(-1), {}}, b_in_a, round_off, {}};
  bool exact = false;
  if (closest.apart) {
    m.best.normal = closest.normal;
    m.best.overlap = overlap_along(a, b, b_in_a, closest.normal);
    m.best.on_a = closest.on_a, m.best.on_b = closest.on_b;
    refine(m, closest.simplex);
    exact = m.best.overlap + closest.distance <= S(16) * round_off + S(64) * real::epsilon<S>() * closest.distance;
  }
  if (!exact) {
    const LeastOverlap<S> before = m.best;
    m.best = expanding_polytope(a, b, b_in_a);
    const S certified = m.best.certified;
    const int points = m.best.points;
    set_weights(m.best);
    if (closest.apart && before.overlap < m.best.overlap) m.best = before;
    refine(m, m.best.face);
    const bool every_axis = a.polyhedral() && b.polyhedral();
    if (m.best.overlap - m.best.certified > S(16) * round_off) {
      if (every_axis) {
        const LeastOverlap<S> all = least_overlap_of_all_axes(a, b, b_in_a);
        if (all.overlap < m.best.overlap) m.best.overlap = all.overlap, m.best.normal = all.normal;
      } else {
        refine_from_all_axes(m);
      }
    }
    features.solve.least_overlap = report_of(m.best.overlap, certified, points, every_axis, round_off, extent);
  }
  features.gap = -m.best.overlap;
  features.normal = m.best.normal;
  features.on_a = m.best.on_a, features.on_b = m.best.on_b;
  // A gap within round-off: the simplex of GJK contains the origin there; the polytope may have ended on any part of
  // the faces.
  if (!exact && real::abs(features.gap) <= S(16) * round_off)
    features.on_a = closest.on_a, features.on_b = closest.on_b;
  set_points(m, features);
  return features;
}

#define ATWOOD_NEAREST_FEATURES(S)                                                                              \
  template S overlap_along<S>(const ConvexPart<S>&, const ConvexPart<S>&, const Transform<S>&, const Vec3<S>&); \
  template LeastOverlap<S> least_overlap_of_all_axes<S>(const ConvexPart<S>&, const ConvexPart<S>&,             \
                                                        const Transform<S>&);                                   \
  template NearestFeatures<S> nearest_features<S>(const ConvexPart<S>&, const ConvexPart<S>&, const Transform<S>&, S);
ATWOOD_NEAREST_FEATURES(float)
ATWOOD_NEAREST_FEATURES(double)
ATWOOD_NEAREST_FEATURES(long double)
#undef ATWOOD_NEAREST_FEATURES

}  // namespace atwood
