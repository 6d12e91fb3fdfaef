// Two straight edges that cross: the gap along their common normal.
//
// An edge of the feature's body, x = a_0 + s a, and one of the surface's, x = b_0 + t b, have the common normal
//   n = +-(a x b) / |a x b|,  from the surface to the feature,
// and the gap g = n . (a_0 - b_0). Touching at the crossing point needs that it lies within both edges, and that n lies
// in both edges' normal cones: that the arcs of a and -b on the Gauss map cross (D. Gregorius, "The separating axis
// test between convex polyhedra", GDC 2013; Ericson, Real-Time Collision Detection, 2005, 5.2.1). Both bodies turn n,
// and the point moves along both edges:
//   c = a x b,  n' = (c' - (n . c') n) / |c|,  c' = (w_a x a) x b + a x (w_b x b)
//   s' = (g n' - u) . (b x n) / |c|,           u = v_a(x_a) - v_b(x_b)
//   g' = n . u,  g'' = n . u' + n' . u         with x' = v_a(x_a) + s' a in u'
#pragma once

#include <vector>

#include "contact/event/features.hpp"
#include "scene/scene.hpp"

namespace atwood::event {

// A straight edge in its body's axes. Its normal cone: the unit vectors n across it with n . side_B >= 0 for both.
template <class S> struct BodyEdge {
  Vec3<S> middle_B, along_B;  // along_B: unit
  S half_length{};
  Vec3<S> side_B[2];
  S depth{};  // a line into the body, against a normal of the cone, is at least that long within it
};

// 12 of a box, 4 of a rectangle, none of any other shape. The contact feature of an edge.
template <class S> std::vector<BodyEdge<S>> edges_of(const Shape& shape);
template <class S> ContactFeature<S> edge_feature(const BodyEdge<S>& edge);

// Edges nearer to parallel than that (the sine of their angle) do not cross: their normal would be round-off.
template <class S> S least_crossing_sine() { return S(64) * real::sqrt(real::epsilon<S>()); }

// An edge feature over another edge; facet.direction_B is along that edge, signed so that n = a x b / |a x b|.
template <class S>
void edge_kinematics(const ContactFeature<S>& feature, const Pose<S>& of, const Facet<S>& facet, const Pose<S>& on,
                     bool with_rates, GapKinematics<S>& kinematics);

// The facet of the surface's edge for the feature's; `apart`: the edges do not meet, whatever the
// gap between their lines.
template <class S>
Facet<S> edge_facet(const BodyEdge<S>& a, const Pose<S>& of, const BodyEdge<S>& b, const Pose<S>& on, S round_off_m,
                    bool& apart);
// How far [m] a contact of two edges is from its end: the least distance of the crossing point from an end of an edge,
// and of the normal (times the shorter half length) to the boundary of a cone, where one edge lies on a face of the
// other's body. Below -round_off_m the contact has ended.
template <class S> struct EdgeDepths { S to_ends{}, to_face{}; };
template <class S>
EdgeDepths<S> depths_inside_edges(const BodyEdge<S>& a, const Pose<S>& of, const BodyEdge<S>& b, const Facet<S>& facet,
                                  const Pose<S>& on, S round_off_m);

}  // namespace atwood::event
