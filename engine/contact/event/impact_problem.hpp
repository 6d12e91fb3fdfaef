// Impulses at the points that touch at one instant.
//
// Several points are one complementarity problem, with Newton's or Poisson's law at each (Stronge's is taken as
// Poisson's there):
//   v_n + e v_n- >= 0,  p_n >= 0,  (v_n + e v_n-) p_n = 0,  |p_t| <= mu p_n, p_t opposed to the slip
// Sources: Moreau (1988); Glocker and Pfeiffer, Multiple impacts with friction in rigid multibody systems (1995).
#pragma once

#include <vector>

#include "contact/event/run.hpp"

namespace atwood::event {

// The impacts of one instant: velocities in bodies.poses change, impulses are appended to impacts.applied.
template <class S> struct ImpactProblem {
  Bodies<S>& bodies;
  const Proximity<S>& proximity;
  Impacts<S>& impacts;
  const EventOptions& options;
  Report& report;
  S approach_round_off;  // [m/s] an approach below it is none
  int unconverged = 0;   // solutions for several points that did not converge

  const Candidate<S>& candidate(const ImpactPoint<S>& point) const { return proximity.candidates[point.candidate]; }
  // Velocity of the feature's body relative to the surface's at the point, and its normal part.
  Vec3<S> u(const ImpactPoint<S>& point) const {
    const Pose<S>& feature = bodies.poses[candidate(point).feature_body];
    const Pose<S>& surface = bodies.poses[candidate(point).surface_body];
    return (feature.v + cross(feature.w, point.kinematics.x - feature.p)) -
           (surface.v + cross(surface.w, point.kinematics.x - surface.p));
  }
  S vn(const ImpactPoint<S>& point) const { return dot(u(point), point.kinematics.normal); }
};

// The end of the range of impact points of the pair of point `first`.
template <class S> int end_of_pair(const Impacts<S>& impacts, int first) {
  int end = first;
  while (end < static_cast<int>(impacts.points.size()) && impacts.points[end].pair == impacts.points[first].pair) ++end;
  return end;
}

template <class S> ImpactLaw<S> law_of(const Proximity<S>& proximity, const EventOptions& options, int pair);
// Changes both bodies' velocities by an impulse [N s] on the feature's body, the opposite on the surface's. Needs
// point.surface and point.feature.
template <class S> void apply_impulse(ImpactProblem<S>& problem, ImpactPoint<S>& point, const Vec3<S>& impulse);
// Applies the impact law at one point: changes both bodies' velocities and the point's impulses.
template <class S> void collide_point(ImpactProblem<S>& problem, ImpactPoint<S>& point);
// Several points of one pair that have the same normal velocity and response, as one point. False: they have not;
// nothing has changed.
template <class S> bool collide_as_one_point(ImpactProblem<S>& problem, int first, int count);
// Points [first, first + count) as one complementarity problem. False: the run ends; report.outcome says why.
template <class S> bool collide_simultaneously(ImpactProblem<S>& problem, int first, int count);

}  // namespace atwood::event
