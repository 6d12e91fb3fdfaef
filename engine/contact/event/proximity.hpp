// Broad phase of a run: pairs of bodies that may touch, and candidate contacts with their gaps.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "collision/geometry.hpp"
#include "contact/event/bodies.hpp"
#include "contact/event/edges.hpp"
#include "contact/event/features.hpp"
#include "contact/event/report.hpp"
#include "contact/event/states.hpp"
#include "scene/scene.hpp"

namespace atwood::event {

// Two bodies that may touch, their law, and their range of candidate contacts.
template <class S> struct ShapePair {
  int a = 0, b = 0;          // bodies, a < b
  int first = 0, count = 0;  // candidates
  S restitution{}, friction{}, rolling_friction_m{};
  S bounding_radii{};  // [m] the sum of both
  int plane = -1;      // the surface, if one of the bodies is a plane
  bool plane_is_a = false;
  // Message where a vertex would slide beyond its face, or a sphere touches two facets; empty: they cannot.
  std::string boundary_refusal;
  std::string names;             // "sphere `a` and box `b`"
  std::string flat_end_refusal;  // message where an end of a cylinder lies flat (flat_ends.hpp)
  std::string refusal;           // not empty: the pair has no contact test, and must not come near
  S travel_until_recheck{};      // [m] path lengths of both bodies up to which they cannot have met
  std::int64_t gaps_segment =
      -1;                    // the segment (Proximity::segment) at whose start its candidates' gaps are known; -1: none
  bool last_bounce = false;  // the impact of this instant is taken as the last of a series of bounces,
  S remaining_bounces_s{};   // which would go on for that long
  S bounces_end_s{};         // when the series will have ended, predicted from its impacts so far
  bool overlaps_at_start = false;    // its contacts may hold an overlap; of others an overlap is drift
  bool has_edge_candidates = false;  // edge_candidates.hpp; and its range without them:
  int first_without_edges = 0, count_without_edges = 0;
};

// A candidate contact: a feature of one body over a surface of another.
template <class S> struct Candidate {
  int pair = 0, feature_body = 0, surface_body = 0, surface = 0;
  ContactFeature<S> feature;
  int edge[2] = {-1, -1};         // an edge over an edge: of the feature's and the surface's body in Proximity::edges
  mutable int last_triangle = 0;  // of a flat mesh: where the search for the triangle below begins
  bool in_contact = false;        // listed in ActiveSet::contacts
  S gap{}, rate{};                // [m], [m/s] at the start of the segment, if known (ShapePair::gaps_segment)
  S gap_end{}, rate_end{};        // at the end of the trial step
};

// A body with vertices, sphere ends or circles that may stand on another's rectangle, flat mesh or box. Its candidates
// have contacts with faces only, so the run is refused where it overlaps the surface's boundary.
template <class S> struct FaceBoundary {
  int pair = 0, feature_body = 0, surface_body = 0;
  Geometry<S> feature, surface;
  Vec3<S> on_it_B, normal_B;  // a point and the unit normal of the surface's plane
  bool thick = false;         // a box, which has no other side; a body may cross its edges within one step
};

template <class S> struct Proximity {
  std::vector<ShapePair<S>> pairs;
  std::vector<Candidate<S>> candidates;
  std::vector<Surface<S>> surfaces;
  std::vector<FaceBoundary<S>> boundaries;
  std::vector<std::vector<BodyEdge<S>>> edges;  // of each body
  int edge_surface = -1;                        // the surface of candidates of edges
  bool has_circles = false;                     // some candidate's feature is a circle
  std::size_t candidates_without_edges = 0, surfaces_without_edges = 0;
  std::vector<int> near;                    // pairs that may touch within the present trial step
  std::vector<S> path_length, path_bounds;  // [m] a body: path length so far; bound of its path in the trial step
  std::int64_t segment = 0;                 // number of the present segment of a step; segments end at steps and events
};

// All pairs and candidates of a scene; also sets bounding radii and the length scale.
template <class S> void build_candidates(Bodies<S>& bodies, Proximity<S>& proximity, const Scene& scene);

// ---- kinematics.cpp: gaps of candidates
// Sets bodies.poses of the candidate's two bodies; the cache of contact poses is no longer valid.
template <class S> void update_poses(Bodies<S>& bodies, const Candidate<S>& candidate, const S* y);
// The point of a feature that decides which facet it is over: of a circle over a slab or mesh the lowest one. From
// bodies.poses, as the next two.
template <class S>
Vec3<S> reference_point(const Bodies<S>& bodies, const Proximity<S>& proximity, const Candidate<S>& candidate);
// The facet below a candidate; outside_m: see nearest_facet(). Updates the search hint last_triangle.
template <class S>
Facet<S> facet_below(const Bodies<S>& bodies, const Proximity<S>& proximity, const Candidate<S>& candidate,
                     S& outside_m);
template <class S>
GapKinematics<S> gap_from_poses(const Bodies<S>& bodies, const Proximity<S>& proximity, const Candidate<S>& candidate);
// A centred sphere over a plane or a sphere needs no orientation.
template <class S> bool needs_orientation(const Proximity<S>& proximity, const Candidate<S>& candidate) {
  return !candidate.feature.centered || proximity.surfaces[candidate.surface].kind > SurfaceKind::point;
}
// The gap of such a candidate in the state y, without computing poses.
template <class S>
GapKinematics<S> sphere_gap(const Bodies<S>& bodies, const Proximity<S>& proximity, const Candidate<S>& candidate,
                            const S* y);
// The gap of any candidate in the state y.
template <class S>
GapKinematics<S> gap_at(Bodies<S>& bodies, const Proximity<S>& proximity, const Candidate<S>& candidate, const S* y);

// ---- broad_phase.cpp
// Lists in proximity.near the pairs that may touch between states.y and states.y_new, h_s later. False: a pair without
// a contact test comes near; report.outcome says which.
template <class S>
bool find_near(const Bodies<S>& bodies, Proximity<S>& proximity, const StateBuffers<S>& states, Report& report, S h_s);
// Gaps and rates of the candidates of near pairs at both ends of the trial step. Those in contact are left out.
template <class S> void measure_gaps(Bodies<S>& bodies, Proximity<S>& proximity, const StateBuffers<S>& states);
// Adds the bounds of the trial step to the path lengths.
template <class S> void advance_path_lengths(Proximity<S>& proximity);
// The trial step was taken whole: its end is the start of the next segment.
template <class S> void shift_gaps(Proximity<S>& proximity);

}  // namespace atwood::event
