// The closest points of two convex cores, by points of their Minkowski difference A - B.
#pragma once

#include "collision/convex_part.hpp"
#include "protocol/solver_report.hpp"

namespace atwood {

// A point w = a - b of the difference, a in A, b in B; all in A's axes.
template <class S> struct DifferencePoint {
  Vec3<S> w, a, b;
  int vertex_a = -1, vertex_b = -1;
};

template <class S> struct Simplex {
  std::array<DifferencePoint<S>, 4> corner;
  std::array<S, 4> weight{};  // barycentric, of the point nearest to the origin
  int count = 0;
};

// Reduces the simplex to the face whose interior contains its point nearest to the origin, sets its weights and returns
// that point. A tetrahedron around the origin stays whole. Faces without area, up to round-off, count as their edges.
template <class S> Vec3<S> nearest_to_origin(Simplex<S>& simplex);

// The farthest point of A - B in `direction`.
template <class S>
DifferencePoint<S> difference_support(const ConvexPart<S>& a, const ConvexPart<S>& b, const Transform<S>& b_in_a,
                                      const Vec3<S>& direction, int start_a = 0, int start_b = 0);

template <class S> struct Closest {
  bool apart = false;  // false: the cores overlap, or their distance is within round-off
  S distance{};
  Vec3<S> on_a, on_b;  // A's axes
  Vec3<S> normal;      // unit, from a to b
  Simplex<S> simplex;
  bool out_of_range = false;  // more than `max_distance` apart: of the rest only `normal` and `solve` are set
  SolveReport solve = {};     // residual: bound of the error of `distance` over the extent of the cores
};

// Gilbert, Johnson, Keerthi (1988); sub-algorithm of Montanari, Petrinic, Barbieri, ACM Trans. Graph. 36 (2017) 30.
// `solve` is converged where no support point is nearer by more than round-off of the extents, or the distance is more
// than `max_distance`; stagnated where further support points no longer shorten it; capped after 200 iterations: the
// points are then the nearest ones found so far.
template <class S>
Closest<S> closest_points(const ConvexPart<S>& a, const ConvexPart<S>& b, const Transform<S>& b_in_a, S max_distance);

}  // namespace atwood
