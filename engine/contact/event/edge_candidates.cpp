// Candidates of crossing edges. A pair of boxes has 144 pairs of edges, of which few ever meet: they become candidates
// when edges first touch, or when bodies overlap whose other candidates have not met.
#include "contact/event/edge_candidates.hpp"

#include <algorithm>

#include "contact/event/surface_boundaries.hpp"
#include "math/bracketed_root.hpp"

namespace atwood::event {

namespace {

template <class S> const FaceBoundary<S>* boundary_of(const Proximity<S>& proximity, int pair) {
  const auto found = std::find_if(proximity.boundaries.begin(), proximity.boundaries.end(),
                                  [&](const FaceBoundary<S>& boundary) { return boundary.pair == pair; });
  return found == proximity.boundaries.end() ? nullptr : &*found;
}

template <class S>
Candidate<S> candidate_of(int pair, int feature_body, int surface_body, int surface, const ContactFeature<S>& feature) {
  Candidate<S> candidate;
  candidate.pair = pair;
  candidate.feature_body = feature_body;
  candidate.surface_body = surface_body;
  candidate.surface = surface;
  candidate.feature = feature;
  return candidate;
}

// The vertices of a rectangle, on which a box over its boundary may stand.
template <class S> void add_rectangle_vertices(Proximity<S>& proximity, const FaceBoundary<S>& boundary) {
  if (boundary.surface.kind != ShapeKind::rectangle || boundary.feature.kind != ShapeKind::box) return;
  Surface<S> back;
  back.kind = SurfaceKind::slab;
  back.half_extents = boundary.feature.half_extents;
  proximity.surfaces.push_back(back);
  const int surface = static_cast<int>(proximity.surfaces.size()) - 1;
  const Vec3<S>& half = boundary.surface.half_extents;
  for (int i = 0; i < 4; ++i) {
    const ContactFeature<S> vertex{{i & 1 ? half.x : -half.x, i & 2 ? half.y : -half.y, S(0)}, S(0), false, false, {}};
    proximity.candidates.push_back(
        candidate_of(boundary.pair, boundary.surface_body, boundary.feature_body, surface, vertex));
  }
}

template <class S>
bool edges_touch(const Bodies<S>& bodies, const Proximity<S>& proximity, const FaceBoundary<S>& boundary, const S* y) {
  const Pose<S> of = pose_of(bodies, boundary.feature_body, y), on = pose_of(bodies, boundary.surface_body, y);
  if (norm(of.p - on.p) > proximity.pairs[boundary.pair].bounding_radii) return false;
  for (const BodyEdge<S>& a : proximity.edges[boundary.feature_body])
    for (const BodyEdge<S>& b : proximity.edges[boundary.surface_body]) {
      bool apart = false;
      const Facet<S> facet = edge_facet(a, of, b, on, bodies.gap_round_off(), apart);
      if (apart) continue;
      GapKinematics<S> kinematics;
      edge_kinematics(edge_feature(a), of, facet, on, false, kinematics);
      if (kinematics.gap <= bodies.gap_round_off()) return true;
    }
  return false;
}

// Two edges next to each other that are too near to parallel to cross.
template <class S> struct Parallel {
  bool found = false;
  Vec3<S> from, along;  // a point of one, and its direction
};
template <class S>
Parallel<S> parallel_edges(const Bodies<S>& bodies, const Proximity<S>& proximity, const FaceBoundary<S>& boundary,
                           const S* y, S near_by_m) {
  const Pose<S> of = pose_of(bodies, boundary.feature_body, y), on = pose_of(bodies, boundary.surface_body, y);
  for (const BodyEdge<S>& a : proximity.edges[boundary.feature_body])
    for (const BodyEdge<S>& b : proximity.edges[boundary.surface_body]) {
      const Vec3<S> along = to_world(of, a.along_B);
      if (norm(cross(along, to_world(on, b.along_B))) >= least_crossing_sine<S>()) continue;
      const Vec3<S> middle = of.p + to_world(of, a.middle_B), to = on.p + to_world(on, b.middle_B) - middle;
      const S offset = dot(to, along);
      if (real::abs(offset) <= a.half_length + b.half_length && norm(to - offset * along) <= near_by_m)
        return {true, middle, along};
    }
  return {};
}

template <class S> std::string parallel_reason(const Proximity<S>& proximity, int pair, S t_s, bool parallel) {
  std::string reason =
      proximity.pairs[pair].boundary_refusal + ", at t = " + format_double(static_cast<double>(t_s)) + " s";
  if (parallel)
    reason +=
        ": their edges are parallel, within a sine of " + format_double(static_cast<double>(least_crossing_sine<S>()));
  return reason;
}

// The theta in (low, high] where the candidate's gap falls through zero, by Newton's method within a bracket; above 1:
// none, the gap is negative where the candidate becomes valid.
template <class S> S gap_zero_of(Flow<S>& flow, const Candidate<S>& candidate, S low, S high, S drift_m) {
  const S tiny = flow.run.bodies.gap_round_off();
  S theta = high;
  constexpr int max_iterations = 200;
  int i = 0;
  for (; i < max_iterations; ++i) {
    const GapKinematics<S> kinematics = gap_at(flow.run.bodies, flow.run.proximity, candidate, flow.at(theta).data());
    if (real::abs(kinematics.gap) <= tiny / S(16)) {
      flow.report_search(i + 1, S(0), true);
      return theta;
    }
    if (kinematics.gap > S(0)) low = theta;
    else high = theta;
    if (high - low <= real::epsilon<S>() * high) break;
    const S slope = kinematics.rate * flow.h_s, next = slope < S(0) ? theta - kinematics.gap / slope : low;
    theta = next > low && next < high ? next : low + (high - low) / S(2);
  }
  flow.report_search(i < max_iterations ? i + 1 : i, high - low, i < max_iterations);
  return real::abs(gap_at(flow.run.bodies, flow.run.proximity, candidate, flow.at(high).data()).gap) <=
                 S(4) * tiny + drift_m
             ? high
             : S(2);
}

}  // namespace

template <class S> void list_edges(Proximity<S>& proximity, const Scene& scene) {
  proximity.edges.clear();
  for (const Body& body : scene.bodies) proximity.edges.push_back(edges_of<S>(body.shape));
  Surface<S> surface;
  surface.kind = SurfaceKind::edge;
  proximity.edge_surface = static_cast<int>(proximity.surfaces.size());
  proximity.surfaces.push_back(surface);
  proximity.candidates_without_edges = proximity.candidates.size();
  proximity.surfaces_without_edges = proximity.surfaces.size();
}

template <class S> void remove_edge_candidates(Proximity<S>& proximity) {
  proximity.candidates.resize(proximity.candidates_without_edges);
  proximity.surfaces.resize(proximity.surfaces_without_edges);
  for (ShapePair<S>& pair : proximity.pairs) {
    if (!pair.has_edge_candidates) continue;
    pair.first = pair.first_without_edges;
    pair.count = pair.count_without_edges;
    pair.has_edge_candidates = false;
  }
}

template <class S> bool has_edges(const Proximity<S>& proximity, int pair) {
  return boundary_of(proximity, pair) != nullptr && !proximity.edges[proximity.pairs[pair].a].empty() &&
         !proximity.edges[proximity.pairs[pair].b].empty();
}

template <class S>
void add_edge_candidates(Proximity<S>& proximity, ActiveSet<S>& active, Impacts<S>& impacts, int index) {
  ShapePair<S>& pair = proximity.pairs[index];
  if (pair.has_edge_candidates || !has_edges(proximity, index)) return;
  const FaceBoundary<S>& boundary = *boundary_of(proximity, index);
  pair.has_edge_candidates = true;
  pair.first_without_edges = pair.first;
  pair.count_without_edges = pair.count;
  pair.first = static_cast<int>(proximity.candidates.size());
  for (int f = 0; f < pair.count; ++f) {
    const Candidate<S> candidate = proximity.candidates[pair.first_without_edges + f];
    proximity.candidates.push_back(candidate);
    proximity.candidates[pair.first_without_edges + f].in_contact = false;
  }
  for (std::size_t i = 0; i < proximity.edges[boundary.feature_body].size(); ++i)
    for (std::size_t j = 0; j < proximity.edges[boundary.surface_body].size(); ++j) {
      Candidate<S> candidate = candidate_of(index, boundary.feature_body, boundary.surface_body, proximity.edge_surface,
                                            edge_feature(proximity.edges[boundary.feature_body][i]));
      candidate.edge[0] = static_cast<int>(i);
      candidate.edge[1] = static_cast<int>(j);
      proximity.candidates.push_back(candidate);
    }
  add_rectangle_vertices(proximity, boundary);
  pair.count = static_cast<int>(proximity.candidates.size()) - pair.first;
  pair.gaps_segment = -1;
  const auto renumber = [&](auto& list) {
    for (auto& item : list)
      if (item.candidate >= pair.first_without_edges &&
          item.candidate < pair.first_without_edges + pair.count_without_edges)
        item.candidate += pair.first - pair.first_without_edges;
  };
  renumber(active.contacts);
  renumber(active.previous);
  renumber(impacts.points);
}

template <class S> void add_crossing_edges(EventRun<S>& run) {
  for (const FaceBoundary<S>& boundary : run.proximity.boundaries)
    if (!run.proximity.pairs[boundary.pair].has_edge_candidates && has_edges(run.proximity, boundary.pair) &&
        std::find(run.proximity.near.begin(), run.proximity.near.end(), boundary.pair) != run.proximity.near.end() &&
        edges_touch(run.bodies, run.proximity, boundary, run.states.y.data()))
      add_edge_candidates(run.proximity, run.active, run.impacts, boundary.pair);
}

template <class S> bool refuse_parallel_edges(EventRun<S>& run, S t_s) {
  for (const FaceBoundary<S>& boundary : run.proximity.boundaries) {
    if (!has_edges(run.proximity, boundary.pair)) continue;
    const auto approaches = [&](const ImpactPoint<S>& point) {
      return point.pair == boundary.pair && point.kinematics.rate < -run.bodies.approach_round_off();
    };
    if (std::none_of(run.impacts.points.begin(), run.impacts.points.end(), approaches)) continue;
    const Parallel<S> line =
        parallel_edges(run.bodies, run.proximity, boundary, run.states.y.data(), S(4) * run.bodies.gap_round_off());
    const auto on_the_line = [&](const ImpactPoint<S>& point) {
      const Vec3<S> to = point.kinematics.x - line.from;
      return point.pair != boundary.pair ||
             norm(to - dot(to, line.along) * line.along) <= S(4) * run.bodies.gap_round_off();
    };
    if (!line.found || !std::all_of(run.impacts.points.begin(), run.impacts.points.end(), on_the_line)) continue;
    return end_run(run.report, Status::unsupported, parallel_reason(run.proximity, boundary.pair, t_s, true));
  }
  return true;
}

template <class S>
Facet<S> edge_facet_of(const Bodies<S>& bodies, const Proximity<S>& proximity, const Candidate<S>& candidate,
                       S& outside_m) {
  bool apart = false;
  const Facet<S> facet =
      edge_facet(proximity.edges[candidate.feature_body][candidate.edge[0]], bodies.poses[candidate.feature_body],
                 proximity.edges[candidate.surface_body][candidate.edge[1]], bodies.poses[candidate.surface_body],
                 bodies.gap_round_off(), apart);
  outside_m = apart ? proximity.pairs[candidate.pair].bounding_radii : S(0);
  return facet;
}

template <class S>
EdgeDepths<S> depths_inside_edges_of(const Bodies<S>& bodies, const Proximity<S>& proximity,
                                     const Contact<S>& contact) {
  const Candidate<S>& candidate = proximity.candidates[contact.candidate];
  return depths_inside_edges(proximity.edges[candidate.feature_body][candidate.edge[0]],
                             bodies.poses[candidate.feature_body],
                             proximity.edges[candidate.surface_body][candidate.edge[1]], contact.facet,
                             bodies.poses[candidate.surface_body], bodies.gap_round_off());
}

template <class S> bool locate_penetration(Flow<S>& flow, S low, S high, Crossing<S>& first) {
  EventRun<S>& run = flow.run;
  bool found = false;
  for (const FaceBoundary<S>& boundary : run.proximity.boundaries) {
    if (!has_edges(run.proximity, boundary.pair) ||
        clear_of_boundary(run.bodies, run.proximity, run.active, boundary, flow.at(high).data()))
      continue;
    add_edge_candidates(run.proximity, run.active, run.impacts, boundary.pair);
    // Where the overlap begins it is hardly more than round-off, and equals one candidate's gap.
    const auto clear_at = [&](S theta) {
      return clear_of_boundary(run.bodies, run.proximity, run.active, boundary, flow.at(theta).data());
    };
    const BracketedRoot<S> begins = bisect(clear_at, low, high, S(0x1p-40), 60);
    flow.report_search(begins.evaluations, begins.high - begins.low, begins.converged);
    const S overlap = begins.high;
    const ShapePair<S>& pair = run.proximity.pairs[boundary.pair];
    // Next to a lasting contact that drifts, a candidate may become valid with a gap as far below zero.
    const S drift = S(2) * real::abs(target_gap_of_pair(run.bodies, run.proximity, run.active, boundary.pair,
                                                        flow.at(overlap).data()));
    S earliest = S(2), deepest = S(0);
    int candidate = -1, overlapping = -1;
    for (int f = pair.first; f < pair.first + pair.count; ++f) {
      const GapKinematics<S> kinematics =
          gap_at(run.bodies, run.proximity, run.proximity.candidates[f], flow.at(overlap).data());
      if (run.proximity.candidates[f].in_contact || !(kinematics.gap < S(0))) continue;
      if (kinematics.gap < deepest && kinematics.rate < S(0)) {
        deepest = kinematics.gap;
        overlapping = f;
      }
      const S theta = gap_zero_of(flow, run.proximity.candidates[f], low, overlap, drift);
      if (!(theta < earliest)) continue;
      earliest = theta;
      candidate = f;
    }
    if (candidate < 0 && overlapping >= 0) {  // valid only where its gap is negative: closed within the tolerance
      candidate = overlapping;
      earliest = overlap;
    }
    // A vertex on an edge that is parallel to one of its own edges: the contact normal is not unique.
    const S near_by = S(16) * real::sqrt(real::epsilon<S>()) * pair.bounding_radii;
    const bool parallel = (candidate < 0 || !run.proximity.candidates[candidate].feature.edge) &&
                          parallel_edges(run.bodies, run.proximity, boundary, flow.at(overlap).data(), near_by).found;
    if (candidate < 0 || parallel) {
      run.report.outcome.reason =
          parallel_reason(run.proximity, boundary.pair, flow.t_s + overlap * flow.h_s, parallel);
      return false;
    }
    if (!found || earliest < first.theta) first = {earliest, SwitchingFunction::gap, candidate};
    found = true;
  }
  if (found) run.report.outcome = {};  // clear_of_boundaries() has refused
  return found;
}

#define ATWOOD_EDGE_CANDIDATES(S)                                                                             \
  template void list_edges<S>(Proximity<S>&, const Scene&);                                                   \
  template void remove_edge_candidates<S>(Proximity<S>&);                                                     \
  template bool has_edges<S>(const Proximity<S>&, int);                                                       \
  template void add_edge_candidates<S>(Proximity<S>&, ActiveSet<S>&, Impacts<S>&, int);                       \
  template void add_crossing_edges<S>(EventRun<S>&);                                                          \
  template bool refuse_parallel_edges<S>(EventRun<S>&, S);                                                    \
  template Facet<S> edge_facet_of<S>(const Bodies<S>&, const Proximity<S>&, const Candidate<S>&, S&);         \
  template EdgeDepths<S> depths_inside_edges_of<S>(const Bodies<S>&, const Proximity<S>&, const Contact<S>&); \
  template bool locate_penetration<S>(Flow<S>&, S, S, Crossing<S>&);
ATWOOD_EDGE_CANDIDATES(float)
ATWOOD_EDGE_CANDIDATES(double)
ATWOOD_EDGE_CANDIDATES(long double)
#undef ATWOOD_EDGE_CANDIDATES

}  // namespace atwood::event
