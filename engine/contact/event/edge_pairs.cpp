// Edges of a run's pairs. A pair of boxes has 144 pairs of edges, of which few ever meet: they are listed as features
// where edges first touch, or where bodies overlap whose other features have not met.
#include <algorithm>

#include "contact/event/fall.hpp"

namespace atwood::event {

namespace {

template <class S> const SheetEnds<S>* ends_of(const EventRun<S>& run, int pair) {
  const auto found =
      std::find_if(run.ends.begin(), run.ends.end(), [&](const SheetEnds<S>& ends) { return ends.pair == pair; });
  return found == run.ends.end() ? nullptr : &*found;
}

template <class S> Feature<S> feature_of(int pair, int knob_body, int surface_body, int surface, const Knob<S>& knob) {
  Feature<S> feature;
  feature.pair = pair;
  feature.knob_body = knob_body;
  feature.surface_body = surface_body;
  feature.surface = surface;
  feature.knob = knob;
  return feature;
}

// A sheet has corners too, which a box over its end may stand on.
template <class S> void list_sheet_corners(EventRun<S>& run, const SheetEnds<S>& ends) {
  if (ends.surface.kind != ShapeKind::rectangle || ends.knob.kind != ShapeKind::box) return;
  Surface<S> back;
  back.kind = SurfaceKind::slab;
  back.half_extents = ends.knob.half_extents;
  run.surfaces.push_back(back);
  const int surface = static_cast<int>(run.surfaces.size()) - 1;
  const Vec3<S>& half = ends.surface.half_extents;
  for (int i = 0; i < 4; ++i) {
    const Knob<S> corner{{i & 1 ? half.x : -half.x, i & 2 ? half.y : -half.y, S(0)}, S(0), false, false, {}};
    run.features.push_back(feature_of(ends.pair, ends.surface_body, ends.knob_body, surface, corner));
  }
}

template <class S> bool edges_touch(const EventRun<S>& run, const SheetEnds<S>& ends, const S* y) {
  const Pose<S> of = pose_of(run, ends.knob_body, y), on = pose_of(run, ends.surface_body, y);
  if (norm(of.p - on.p) > run.pairs[ends.pair].reach) return false;
  for (const Edge<S>& a : run.edges[ends.knob_body])
    for (const Edge<S>& b : run.edges[ends.surface_body]) {
      bool apart = false;
      const Facet<S> facet = edge_facet(a, of, b, on, run.gap_round_off(), apart);
      if (apart) continue;
      Sight<S> sight;
      see_edge(edge_knob(a), of, facet, on, false, sight);
      if (sight.gap <= run.gap_round_off()) return true;
    }
  return false;
}

// Two edges that are too near to parallel to cross, and next to each other.
template <class S> struct Parallel {
  bool found = false;
  Vec3<S> from, along;  // a point of one, and its direction
};
template <class S>
Parallel<S> parallel_edges(const EventRun<S>& run, const SheetEnds<S>& ends, const S* y, S near_by_m) {
  const Pose<S> of = pose_of(run, ends.knob_body, y), on = pose_of(run, ends.surface_body, y);
  for (const Edge<S>& a : run.edges[ends.knob_body])
    for (const Edge<S>& b : run.edges[ends.surface_body]) {
      const Vec3<S> along = turned(of, a.along_B);
      if (norm(cross(along, turned(on, b.along_B))) >= least_crossing_sine<S>()) continue;
      const Vec3<S> middle = of.p + turned(of, a.middle_B), to = on.p + turned(on, b.middle_B) - middle;
      const S beside = dot(to, along);
      if (real::abs(beside) <= a.half_length + b.half_length && norm(to - beside * along) <= near_by_m)
        return {true, middle, along};
    }
  return {};
}

template <class S> std::string parallel_reason(const EventRun<S>& run, int pair, S t_s, bool parallel) {
  std::string reason = run.pairs[pair].past_the_end + ", at t = " + format_double(static_cast<double>(t_s)) + " s";
  if (parallel)
    reason +=
        ": their edges are parallel, within a sine of " + format_double(static_cast<double>(least_crossing_sine<S>()));
  return reason;
}

// Where in (low, high] the feature's gap falls through zero, by Newton within a bracket; above 1: it does not, the gap
// is below zero where the feature comes to count.
template <class S> S fall_of(Flow<S>& flow, const Feature<S>& feature, S low, S high, S drift_m) {
  const S tiny = flow.run.gap_round_off();
  S theta = high;
  for (int i = 0; i < 200; ++i) {
    const Sight<S> sight = sight_of(flow.run, feature, flow.at(theta));
    if (real::abs(sight.gap) <= tiny / S(16)) return theta;
    if (sight.gap > S(0)) low = theta;
    else high = theta;
    if (high - low <= real::epsilon<S>() * high) break;
    const S slope = sight.rate * flow.h_s, next = slope < S(0) ? theta - sight.gap / slope : low;
    theta = next > low && next < high ? next : low + (high - low) / S(2);
  }
  return real::abs(sight_of(flow.run, feature, flow.at(high)).gap) <= S(4) * tiny + drift_m ? high : S(2);
}

}  // namespace

template <class S> void find_edges(EventRun<S>& run, const Scene& scene) {
  run.edges.clear();
  for (const Body& body : scene.bodies) run.edges.push_back(edges_of<S>(body.shape));
  Surface<S> surface;
  surface.kind = SurfaceKind::edge;
  run.edge_surface = static_cast<int>(run.surfaces.size());
  run.surfaces.push_back(surface);
  run.features_without_edges = run.features.size();
  run.surfaces_without_edges = run.surfaces.size();
}

template <class S> void put_edges_away(EventRun<S>& run) {
  run.features.resize(run.features_without_edges);
  run.surfaces.resize(run.surfaces_without_edges);
  for (ShapePair<S>& pair : run.pairs) {
    if (!pair.lists_edges) continue;
    pair.first = pair.first_without_edges;
    pair.count = pair.count_without_edges;
    pair.lists_edges = false;
  }
}

template <class S> bool has_edges(const EventRun<S>& run, int pair) {
  return ends_of(run, pair) != nullptr && !run.edges[run.pairs[pair].a].empty() &&
         !run.edges[run.pairs[pair].b].empty();
}

template <class S> void list_edges(EventRun<S>& run, int index) {
  ShapePair<S>& pair = run.pairs[index];
  if (pair.lists_edges || !has_edges(run, index)) return;
  const SheetEnds<S>& ends = *ends_of(run, index);
  pair.lists_edges = true;
  pair.first_without_edges = pair.first;
  pair.count_without_edges = pair.count;
  pair.first = static_cast<int>(run.features.size());
  for (int f = 0; f < pair.count; ++f) {
    const Feature<S> feature = run.features[pair.first_without_edges + f];
    run.features.push_back(feature);
    run.features[pair.first_without_edges + f].lasting = false;
  }
  for (std::size_t i = 0; i < run.edges[ends.knob_body].size(); ++i)
    for (std::size_t j = 0; j < run.edges[ends.surface_body].size(); ++j) {
      Feature<S> feature = feature_of(index, ends.knob_body, ends.surface_body, run.edge_surface,
                                      edge_knob(run.edges[ends.knob_body][i]));
      feature.edge[0] = static_cast<int>(i);
      feature.edge[1] = static_cast<int>(j);
      run.features.push_back(feature);
    }
  list_sheet_corners(run, ends);
  pair.count = static_cast<int>(run.features.size()) - pair.first;
  pair.known_at = -1;
  const auto renumber = [&](auto& list) {
    for (auto& item : list)
      if (item.feature >= pair.first_without_edges &&
          item.feature < pair.first_without_edges + pair.count_without_edges)
        item.feature += pair.first - pair.first_without_edges;
  };
  renumber(run.contacts);
  renumber(run.contacts_before);
  renumber(run.hits);
  run.has_factors = false;
  run.modes = 0;
}

template <class S> void list_crossing_edges(EventRun<S>& run, const S* y) {
  for (const SheetEnds<S>& ends : run.ends)
    if (!run.pairs[ends.pair].lists_edges && has_edges(run, ends.pair) &&
        std::find(run.near.begin(), run.near.end(), ends.pair) != run.near.end() && edges_touch(run, ends, y))
      list_edges(run, ends.pair);
}

template <class S> bool refuse_parallel_edges(EventRun<S>& run, S t_s) {
  for (const SheetEnds<S>& ends : run.ends) {
    if (!has_edges(run, ends.pair)) continue;
    const auto approaches = [&](const Hit<S>& hit) {
      return hit.pair == ends.pair && hit.sight.rate < -run.approach_round_off();
    };
    if (std::none_of(run.hits.begin(), run.hits.end(), approaches)) continue;
    const Parallel<S> line = parallel_edges(run, ends, run.y.data(), S(4) * run.gap_round_off());
    const auto on_the_line = [&](const Hit<S>& hit) {
      const Vec3<S> to = hit.sight.x - line.from;
      return hit.pair != ends.pair || norm(to - dot(to, line.along) * line.along) <= S(4) * run.gap_round_off();
    };
    if (!line.found || !std::all_of(run.hits.begin(), run.hits.end(), on_the_line)) continue;
    run.outcome = {Status::unsupported, parallel_reason(run, ends.pair, t_s, true), 0, 0, {}};
    return false;
  }
  return true;
}

template <class S> Facet<S> edge_facet_of(const EventRun<S>& run, const Feature<S>& feature, S& beside) {
  bool apart = false;
  const Facet<S> facet = edge_facet(run.edges[feature.knob_body][feature.edge[0]], run.poses[feature.knob_body],
                                    run.edges[feature.surface_body][feature.edge[1]], run.poses[feature.surface_body],
                                    run.gap_round_off(), apart);
  beside = apart ? run.pairs[feature.pair].reach : S(0);
  return facet;
}

template <class S> S within_edges_of(const EventRun<S>& run, const Contact<S>& contact) {
  const Feature<S>& feature = run.features[contact.feature];
  return within_edges(run.edges[feature.knob_body][feature.edge[0]], run.poses[feature.knob_body],
                      run.edges[feature.surface_body][feature.edge[1]], contact.facet, run.poses[feature.surface_body],
                      run.gap_round_off());
}

template <class S> bool locate_overlap(Flow<S>& flow, S low, S high, Fall<S>& first) {
  EventRun<S>& run = flow.run;
  bool found = false;
  for (const SheetEnds<S>& ends : run.ends) {
    if (!has_edges(run, ends.pair) || clear_of_end(run, ends, flow.at(high))) continue;
    list_edges(run, ends.pair);
    // As the overlap begins it is hardly more than round-off: one feature's gap is it.
    S apart = low, overlap = high;
    for (int i = 0; i < 60 && overlap - apart > S(0x1p-40) * overlap; ++i) {
      const S middle = apart + (overlap - apart) / S(2);
      (clear_of_end(run, ends, flow.at(middle)) ? apart : overlap) = middle;
    }
    const ShapePair<S>& pair = run.pairs[ends.pair];
    // Next to a lasting contact that drifts, a feature may come to count as far below zero.
    const S drift = S(2) * real::abs(held_at(run, ends.pair, flow.at(overlap)));
    S earliest = S(2), deepest = S(0);
    int feature = -1, below = -1;
    for (int f = pair.first; f < pair.first + pair.count; ++f) {
      const Sight<S> sight = sight_of(run, run.features[f], flow.at(overlap));
      if (run.features[f].lasting || !(sight.gap < S(0))) continue;
      if (sight.gap < deepest && sight.rate < S(0)) {
        deepest = sight.gap;
        below = f;
      }
      const S theta = fall_of(flow, run.features[f], low, overlap, drift);
      if (!(theta < earliest)) continue;
      earliest = theta;
      feature = f;
    }
    if (feature < 0 && below >= 0) {  // it counts where it is below zero already: touches to within the tolerance
      feature = below;
      earliest = overlap;
    }
    // A corner right on an edge that its own edge is parallel to: its face's normal is one of many.
    const S near_by = S(16) * real::sqrt(real::epsilon<S>()) * pair.reach;
    const bool parallel =
        (feature < 0 || !run.features[feature].knob.edge) && parallel_edges(run, ends, flow.at(overlap), near_by).found;
    if (feature < 0 || parallel) {
      run.outcome.reason = parallel_reason(run, ends.pair, flow.t_s + overlap * flow.h_s, parallel);
      return false;
    }
    if (!found || earliest < first.theta) first = {earliest, Condition::gap, feature};
    found = true;
  }
  if (found) run.outcome = {};  // clear_of_ends() has refused
  return found;
}

#define ATWOOD_EDGE_PAIRS(S)                                                     \
  template void find_edges<S>(EventRun<S>&, const Scene&);                       \
  template void put_edges_away<S>(EventRun<S>&);                                 \
  template bool has_edges<S>(const EventRun<S>&, int);                           \
  template void list_edges<S>(EventRun<S>&, int);                                \
  template void list_crossing_edges<S>(EventRun<S>&, const S*);                  \
  template bool refuse_parallel_edges<S>(EventRun<S>&, S);                       \
  template Facet<S> edge_facet_of<S>(const EventRun<S>&, const Feature<S>&, S&); \
  template S within_edges_of<S>(const EventRun<S>&, const Contact<S>&);          \
  template bool locate_overlap<S>(Flow<S>&, S, S, Fall<S>&);
ATWOOD_EDGE_PAIRS(float)
ATWOOD_EDGE_PAIRS(double)
ATWOOD_EDGE_PAIRS(long double)
#undef ATWOOD_EDGE_PAIRS

}  // namespace atwood::event
