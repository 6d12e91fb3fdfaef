// The nearest points of two boxes apart: a corner of one against the other, or two edges across each other.
// (Ericson, Real-Time Collision Detection, 2005, 5.1.4 and 5.1.9.)
#include "collision/box_pair.hpp"
#include "collision/direction.hpp"

namespace atwood {

namespace {

template <class S> using Three = std::array<S, 3>;

template <class S> S square(const Three<S>& v) { return v[0] * v[0] + v[1] * v[1] + v[2] * v[2]; }

// ---- corners ------------------------------------------------------------------------------------------------------
template <class S> struct CornerNearest {
  S square{};
  Three<S> on_box{}, way{};  // in the box's axes; from the box to the corner
  int box_feature = kFeatureNone, corner_feature = kFeatureNone;
  int steps = 0;  // parts of `way` that are not 0: 1 over a face, 2 beside an edge, 3 off a corner
};
// Squared distances that agree to round-off may have directions that differ by its square root: the feature that
// determines the direction best is then preferred (a face before an edge before a corner).
template <class S> bool nearer(const CornerNearest<S>& x, const CornerNearest<S>& y) {
  const S tie = S(8) * real::epsilon<S>() * real::max(x.square, y.square);
  if (real::abs(x.square - y.square) > tie || x.steps == y.steps) return x.square < y.square;
  return x.steps < y.steps;
}
// Corners of the other box (its centre at `t`, axis j along column j of R) against the box of half extents `h`.
template <class S>
CornerNearest<S> nearest_corner(const Three<S>& h, const Three<S>& t, const Three<S>& other_h,
                                const Three<Three<S>>& R) {
  CornerNearest<S> best;
  for (int bits = 0; bits < 8; ++bits) {
    CornerNearest<S> one;
    Three<S> x = t;
    bool repeats = false;  // a side without length has one end
    for (int j = 0; j < 3; ++j) {
      const int sign = (bits >> j) & 1 ? 1 : -1;
      repeats = repeats || (sign > 0 && other_h[j] == S(0));
      for (int i = 0; i < 3; ++i) x[i] += S(sign) * (other_h[j] * R[i][j]);
      one.corner_feature += sign * kFeatureWeight[j];
    }
    if (repeats) continue;
    for (int i = 0; i < 3; ++i) {
      const bool above = x[i] > h[i], below = x[i] < -h[i];
      one.on_box[i] = above ? h[i] : below ? -h[i] : x[i];
      one.way[i] = x[i] - one.on_box[i];
      one.box_feature += (above ? 1 : below ? -1 : 0) * kFeatureWeight[i];
      one.steps += above || below;
    }
    one.square = square(one.way);
    if (bits == 0 || nearer(one, best)) best = one;
  }
  return best;
}

template <class S> Three<Three<S>> transposed(const Three<Three<S>>& R) {
  Three<Three<S>> out;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) out[i][j] = R[j][i];
  return out;
}

// ---- edges --------------------------------------------------------------------------------------------------------
template <class S> struct EdgesNearest {
  S distance{};
  int i = -1, j = -1;         // -1: none nearer than the corners
  Three<S> normal{}, on_a{};  // in a's axes; from a to b
  int feature_a = kFeatureNone, feature_b = kFeatureNone;
};

// Edges along A_i and B_j whose lines come nearest within both. With n = (A_i x B_j) / s the lines through the edges'
// middles, w apart, keep |w . n|; they come nearest at b = -(w . e) / s along B_j, where e completes A_i and n, and at
// w . A_i + b R_ij along A_i.
template <class S> void nearest_edges(const BoxPair<S>& pair, int i, int j, EdgesNearest<S>& best) {
  const auto& R = pair.R;
  const int i1 = next_axis(i), i2 = next_axis(i1), j1 = next_axis(j), j2 = next_axis(j1);
  if (!(pair.h_a[i] > S(0)) || !(pair.h_b[j] > S(0))) return;  // without length: a corner
  const S sine = real::sqrt(R[i1][j] * R[i1][j] + R[i2][j] * R[i2][j]);
  if (sine <= S(4) * real::epsilon<S>()) return;  // parallel: a corner is as near
  const S e1 = R[i1][j] / sine, e2 = R[i2][j] / sine;
  for (int bits = 0; bits < 16; ++bits) {
    const S a1 = bits & 1 ? pair.h_a[i1] : -pair.h_a[i1], a2 = bits & 2 ? pair.h_a[i2] : -pair.h_a[i2];
    const S b1 = bits & 4 ? pair.h_b[j1] : -pair.h_b[j1], b2 = bits & 8 ? pair.h_b[j2] : -pair.h_b[j2];
    const auto w = [&](int k) { return pair.t_a[k] + b1 * R[k][j1] + b2 * R[k][j2]; };
    const S w1 = w(i1) - a1, w2 = w(i2) - a2, offset = w2 * e1 - w1 * e2;
    const S distance = real::abs(offset);
    if (!(distance < best.distance)) continue;
    const S b = -(w1 * e1 + w2 * e2) / sine, a = w(i) + b * R[i][j];
    if (!(real::abs(b) <= pair.h_b[j]) || !(real::abs(a) <= pair.h_a[i])) continue;
    best.distance = distance;
    best.i = i, best.j = j;
    best.normal[i] = S(0), best.normal[i1] = offset < S(0) ? e2 : -e2, best.normal[i2] = offset < S(0) ? -e1 : e1;
    best.on_a[i] = a, best.on_a[i1] = a1, best.on_a[i2] = a2;
    best.feature_a = kFeatureNone + (bits & 1 ? 1 : -1) * kFeatureWeight[i1] + (bits & 2 ? 1 : -1) * kFeatureWeight[i2];
    best.feature_b = kFeatureNone + (bits & 4 ? 1 : -1) * kFeatureWeight[j1] + (bits & 8 ? 1 : -1) * kFeatureWeight[j2];
  }
}

}  // namespace

template <class S> BoxClosest<S> closest_of_boxes(const BoxPair<S>& pair) {
  const CornerNearest<S> of_b = nearest_corner(pair.h_a, pair.t_a, pair.h_b, pair.R);
  const Three<S> back{-pair.t_b[0], -pair.t_b[1], -pair.t_b[2]};
  const CornerNearest<S> of_a = nearest_corner(pair.h_b, back, pair.h_a, transposed(pair.R));
  BoxClosest<S> out;
  Vec3<S> way{S(0), S(0), S(1)};
  if (nearer(of_a, of_b)) {
    out.distance = length_and_direction(Vec3<S>{of_a.way[0], of_a.way[1], of_a.way[2]}, way);
    out.normal_W = -to_world(*pair.pose_b, way);
    for (int i = 0; i < 3; ++i)
      out.on_a[i] = (of_a.corner_feature / kFeatureWeight[i]) % 3 == 2 ? pair.h_a[i] : -pair.h_a[i];
    out.feature_a = of_a.corner_feature, out.feature_b = of_a.box_feature;
  } else {
    out.distance = length_and_direction(Vec3<S>{of_b.way[0], of_b.way[1], of_b.way[2]}, way);
    out.normal_W = to_world(*pair.pose_a, way);
    out.on_a = of_b.on_box;
    out.feature_a = of_b.box_feature, out.feature_b = of_b.corner_feature;
  }
  EdgesNearest<S> edges;
  edges.distance = (S(1) + S(4) * real::epsilon<S>()) * out.distance;  // likewise
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) nearest_edges(pair, i, j, edges);
  if (edges.i >= 0) {
    out.distance = edges.distance;
    out.normal_W = to_world(*pair.pose_a, Vec3<S>{edges.normal[0], edges.normal[1], edges.normal[2]});
    out.on_a = edges.on_a;
    out.feature_a = edges.feature_a, out.feature_b = edges.feature_b;
  }
  return out;
}

#define ATWOOD_BOX_CLOSEST(S) template BoxClosest<S> closest_of_boxes<S>(const BoxPair<S>&);
ATWOOD_BOX_CLOSEST(float)
ATWOOD_BOX_CLOSEST(double)
ATWOOD_BOX_CLOSEST(long double)
#undef ATWOOD_BOX_CLOSEST

}  // namespace atwood
