#include "contact/event/edges.hpp"

#include <algorithm>

namespace atwood::event {

namespace {

template <class S> std::vector<BodyEdge<S>> box_edges(const Real3& half) {
  std::vector<BodyEdge<S>> edges;
  for (int axis = 0; axis < 3; ++axis)
    for (int corner = 0; corner < 4; ++corner) {
      BodyEdge<S> edge;
      component(edge.along_B, axis) = S(1);
      edge.half_length = S(half[axis]);
      for (int k = 0; k < 2; ++k) {
        const int other = (axis + 1 + k) % 3;
        const S sign = corner & (1 << k) ? S(1) : S(-1);
        component(edge.middle_B, other) = sign * S(half[other]);
        component(edge.side_B[k], other) = sign;
      }
      edge.depth = S(2) * real::min(S(half[(axis + 1) % 3]), S(half[(axis + 2) % 3]));
      edges.push_back(edge);
    }
  return edges;
}

template <class S> std::vector<BodyEdge<S>> rectangle_edges(const std::array<double, 2>& half) {
  std::vector<BodyEdge<S>> edges;
  for (int axis = 0; axis < 2; ++axis)
    for (const S sign : {S(-1), S(1)}) {
      BodyEdge<S> edge;
      component(edge.along_B, axis) = S(1);
      edge.half_length = S(half[axis]);
      component(edge.middle_B, 1 - axis) = sign * S(half[1 - axis]);
      component(edge.side_B[0], 1 - axis) = sign;
      edge.side_B[1] = edge.side_B[0];
      edges.push_back(edge);
    }
  return edges;
}

// The crossing of two lines: coordinates along each, and the gap across.
template <class S> struct LineCrossing {
  Vec3<S> a, b, n, from;  // from a's middle to b's
  S sine{}, along_a{}, along_b{}, gap{};
};
template <class S>
LineCrossing<S> cross_lines(const Vec3<S>& middle_a, const Vec3<S>& a, const Vec3<S>& middle_b, const Vec3<S>& b) {
  LineCrossing<S> it{a, b, cross(a, b), middle_b - middle_a, {}, {}, {}, {}};
  it.sine = norm(it.n);
  if (!(it.sine > S(0))) return it;
  it.n = (S(1) / it.sine) * it.n;
  it.along_a = dot(it.from, cross(b, it.n)) / it.sine;
  it.along_b = dot(it.from, cross(a, it.n)) / it.sine;
  // Between the crossing points: the round-off of n, which grows as edges become parallel, does not enter.
  it.gap = dot(it.n, it.along_a * a - it.along_b * b - it.from);
  return it;
}

// The least of n . side over b's cone and -n . side over a's.
template <class S>
S depth_inside_cones(const BodyEdge<S>& a, const Pose<S>& of, const BodyEdge<S>& b, const Pose<S>& on,
                     const Vec3<S>& n) {
  S least = S(1);
  for (int k = 0; k < 2; ++k) {
    least = real::min(least, dot(n, to_world(on, b.side_B[k])));
    least = real::min(least, -dot(n, to_world(of, a.side_B[k])));
  }
  return least;
}

template <class S> S cone_round_off(S sine, S round_off_m, S length) {
  return S(2) * round_off_m / length + S(64) * real::epsilon<S>() / sine;
}

}  // namespace

template <class S> std::vector<BodyEdge<S>> edges_of(const Shape& shape) {
  if (const auto* box = std::get_if<Box>(&shape)) return box_edges<S>(box->half_extents_m);
  if (const auto* sheet = std::get_if<Rectangle>(&shape))
    return rectangle_edges<S>({sheet->half_extents_m[0], sheet->half_extents_m[1]});
  return {};
}

template <class S> ContactFeature<S> edge_feature(const BodyEdge<S>& edge) {
  ContactFeature<S> feature{edge.middle_B, S(0), false, false, edge.along_B};
  feature.edge = true;
  return feature;
}

template <class S>
void edge_kinematics(const ContactFeature<S>& feature, const Pose<S>& of, const Facet<S>& facet, const Pose<S>& on,
                     bool with_rates, GapKinematics<S>& kinematics) {
  kinematics.normal_dot = kinematics.x_dot = {};
  const Vec3<S> arm = to_world(of, feature.center_B), to_edge = to_world(on, facet.point_B);
  const LineCrossing<S> it =
      cross_lines(of.p + arm, to_world(of, feature.axis_B), on.p + to_edge, to_world(on, facet.direction_B));
  const Vec3<S>&a = it.a, &b = it.b, &n = it.n;
  const Vec3<S> arm_a = arm + it.along_a * a, arm_b = to_edge + it.along_b * b;
  kinematics.normal = n;
  kinematics.gap = it.gap;
  kinematics.x = of.p + arm_a;
  const Vec3<S> v_a = of.v + cross(of.w, arm_a), u = v_a - (on.v + cross(on.w, arm_b));
  kinematics.rate = dot(n, u);
  if (!with_rates || !(it.sine > S(0))) return;
  const Vec3<S> c_dot = cross(cross(of.w, a), b) + cross(a, cross(on.w, b));
  kinematics.normal_dot = (S(1) / it.sine) * (c_dot - dot(n, c_dot) * n);
  const S along_dot = dot(it.gap * kinematics.normal_dot - u, cross(b, n)) / it.sine;
  kinematics.x_dot = v_a + along_dot * a;
}

template <class S>
Facet<S> edge_facet(const BodyEdge<S>& a, const Pose<S>& of, const BodyEdge<S>& b, const Pose<S>& on, S round_off_m,
                    bool& apart) {
  LineCrossing<S> it = cross_lines(of.p + to_world(of, a.middle_B), to_world(of, a.along_B),
                                   on.p + to_world(on, b.middle_B), to_world(on, b.along_B));
  Facet<S> facet{1, b.middle_B, b.along_B};
  apart = true;
  if (!(it.sine >= least_crossing_sine<S>())) return facet;
  S within = depth_inside_cones(a, of, b, on, it.n);
  if (const S other = depth_inside_cones(a, of, b, on, -it.n); other > within) {
    within = other;
    it.gap = -it.gap;
    facet.direction_B = -facet.direction_B;
  }
  const S length = real::min(a.half_length, b.half_length), margin = round_off_m / S(2);
  apart = within < -cone_round_off(it.sine, round_off_m, length) ||
          !(a.half_length - real::abs(it.along_a) >= margin) || !(b.half_length - real::abs(it.along_b) >= margin) ||
          it.gap < -(a.depth + b.depth) / S(2);  // one has passed the other
  return facet;
}

template <class S>
EdgeDepths<S> depths_inside_edges(const BodyEdge<S>& a, const Pose<S>& of, const BodyEdge<S>& b, const Facet<S>& facet,
                                  const Pose<S>& on, S round_off_m) {
  const LineCrossing<S> it = cross_lines(of.p + to_world(of, a.middle_B), to_world(of, a.along_B),
                                         on.p + to_world(on, b.middle_B), to_world(on, facet.direction_B));
  const S length = real::min(a.half_length, b.half_length);
  if (!(it.sine >= least_crossing_sine<S>())) return {-length, -length};
  const S cones = depth_inside_cones(a, of, b, on, it.n) + S(2) * cone_round_off(it.sine, round_off_m, length);
  return {real::min(a.half_length - real::abs(it.along_a), b.half_length - real::abs(it.along_b)), cones * length};
}

#define ATWOOD_EDGES(S)                                                                                              \
  template std::vector<BodyEdge<S>> edges_of<S>(const Shape&);                                                       \
  template ContactFeature<S> edge_feature<S>(const BodyEdge<S>&);                                                    \
  template void edge_kinematics<S>(const ContactFeature<S>&, const Pose<S>&, const Facet<S>&, const Pose<S>&, bool,  \
                                   GapKinematics<S>&);                                                               \
  template Facet<S> edge_facet<S>(const BodyEdge<S>&, const Pose<S>&, const BodyEdge<S>&, const Pose<S>&, S, bool&); \
  template EdgeDepths<S> depths_inside_edges<S>(const BodyEdge<S>&, const Pose<S>&, const BodyEdge<S>&,              \
                                                const Facet<S>&, const Pose<S>&, S);
ATWOOD_EDGES(float)
ATWOOD_EDGES(double)
ATWOOD_EDGES(long double)
#undef ATWOOD_EDGES

}  // namespace atwood::event
