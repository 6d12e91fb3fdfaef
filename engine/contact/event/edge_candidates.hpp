// Candidates of crossing edges, added to a pair when they are first needed.
#pragma once

#include "contact/event/event_location.hpp"

namespace atwood::event {

// The edges of all bodies (Proximity::edges), once a scene.
template <class S> void list_edges(Proximity<S>& proximity, const Scene& scene);
// Does the pair have edges on both bodies, and a face boundary?
template <class S> bool has_edges(const Proximity<S>& proximity, int pair);
// Adds the edge candidates of a pair. Renumbers the pair's other candidates, also where contacts and impact points
// refer to them.
template <class S>
void add_edge_candidates(Proximity<S>& proximity, ActiveSet<S>& active, Impacts<S>& impacts, int pair);
// Adds those of near pairs whose edges touch at states.y.
template <class S> void add_crossing_edges(EventRun<S>& run);
// Removes those of all pairs, before a run.
template <class S> void remove_edge_candidates(Proximity<S>& proximity);
// False: the impact points are those of two parallel edges on each other, whose normal is not unique; the run ends, and
// report.outcome says so.
template <class S> bool refuse_parallel_edges(EventRun<S>& run, S t_s);
// The facet of a candidate of two edges; outside_m > 0: they do not meet.
template <class S>
Facet<S> edge_facet_of(const Bodies<S>& bodies, const Proximity<S>& proximity, const Candidate<S>& candidate,
                       S& outside_m);
// depths_inside_edges() of a contact, from bodies.poses.
template <class S>
EdgeDepths<S> depths_inside_edges_of(const Bodies<S>& bodies, const Proximity<S>& proximity, const Contact<S>& contact);
// Bodies overlap at `high` of a trial step, not at `low`, and no candidate's gap has shown it: `first` becomes the
// earliest crossing of a gap through zero, of edges too. False: there is none; the run ends as report.outcome says.
template <class S> bool locate_penetration(Flow<S>& flow, S low, S high, Crossing<S>& first);

}  // namespace atwood::event
