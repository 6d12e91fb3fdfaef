// Two straight edges that cross: the gap along their common normal.
//
// An edge of the knob's body, x = a_0 + s a, and one of the surface's, x = b_0 + t b, have the common normal
//   n = +-(a x b) / |a x b|,  from the surface to the knob,
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

template <class S> struct EventRun;
template <class S> struct Feature;
template <class S> struct Contact;
template <class S> struct Flow;
template <class S> struct Fall;

// A straight edge in its body's axes. Its normal cone: the unit vectors n across it with n . side_B >= 0 for both.
template <class S> struct Edge {
  Vec3<S> middle_B, along_B;  // along_B: unit
  S half_length{};
  Vec3<S> side_B[2];
  S depth{};  // a line into the body, against a normal of the cone, is at least that long within it
};

// 12 of a box, 4 of a rectangle, none of any other shape. An edge as a knob, to be seen by look() and watch().
template <class S> std::vector<Edge<S>> edges_of(const Shape& shape);
template <class S> Knob<S> edge_knob(const Edge<S>& edge);

// Edges nearer to parallel than that (the sine of their angle) do not cross: their normal would be round-off's.
template <class S> S least_crossing_sine() { return S(64) * real::sqrt(real::epsilon<S>()); }

// An edge knob over another edge; facet.direction_B is along that edge, signed so that n = a x b / |a x b|.
template <class S>
void see_edge(const Knob<S>& knob, const Pose<S>& of, const Facet<S>& facet, const Pose<S>& on, bool with_rates,
              Sight<S>& sight);

// The facet of the surface's edge for the knob's; `apart`: they do not meet, whatever the gap between the lines is.
template <class S>
Facet<S> edge_facet(const Edge<S>& a, const Pose<S>& of, const Edge<S>& b, const Pose<S>& on, S round_off_m,
                    bool& apart);
// How far [m] a contact of two edges is from its end: the least way of the crossing point to an end of an edge, and of
// the normal (times the shorter half length) to the border of a cone. Below -round_off_m: it has ended.
template <class S>
S within_edges(const Edge<S>& a, const Pose<S>& of, const Edge<S>& b, const Facet<S>& facet, const Pose<S>& on,
               S round_off_m);

// ---- edges of a run's pairs: listed as features from when they are first needed ------------------------------------
template <class S> void find_edges(EventRun<S>& run, const Scene& scene);
template <class S> void put_edges_away(EventRun<S>& run);        // of all pairs, before a run
template <class S> void list_edges(EventRun<S>& run, int pair);  // as features of the pair; contacts are renumbered
template <class S> bool has_edges(const EventRun<S>& run, int pair);
template <class S> void list_crossing_edges(EventRun<S>& run, const S* y);  // of near pairs whose edges touch in y
// False: the impacts of run.hits are of two parallel edges on each other, whose normal is any of both cones.
template <class S> bool refuse_parallel_edges(EventRun<S>& run, S t_s);
template <class S> Facet<S> edge_facet_of(const EventRun<S>& run, const Feature<S>& feature, S& beside);
template <class S> S within_edges_of(const EventRun<S>& run, const Contact<S>& contact);
// Bodies overlap at `high` of a step, not at `low`, and no feature's gap has shown it: where the first did fall through
// zero. False: none did.
template <class S> bool locate_overlap(Flow<S>& flow, S low, S high, Fall<S>& first);

}  // namespace atwood::event
