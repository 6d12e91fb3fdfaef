// Boundaries of faces and lines that contacts leave.
#pragma once

#include "contact/event/active_set.hpp"

namespace atwood::event {

// Does the contact's surface have a boundary (all but planes and spheres)?
template <class S> bool has_boundary(const Proximity<S>& proximity, const Contact<S>& contact);
// The distance [m] of a contact's feature from the boundary of its facet; negative outside. From bodies.poses. A
// contact of two edges persists while one of them lies on a face and another contact of the pair supports it.
template <class S>
S depth_inside_facet(const Bodies<S>& bodies, const Proximity<S>& proximity, const ActiveSet<S>& active,
                     Contact<S>& contact);
// Gap, rate, normal and point of a contact over the facet that it is held at, from bodies.poses.
template <class S>
GapKinematics<S> held_kinematics(const Bodies<S>& bodies, const Proximity<S>& proximity, const Contact<S>& contact);
// Speed [m/s] at which a feature of boxes or rectangles moves out over the boundary of the face it is on, to round-off;
// 0: it does not. From bodies.poses.
template <class S>
S leaving_speed(const Bodies<S>& bodies, const Proximity<S>& proximity, const Candidate<S>& candidate);
// True if a feature that approaches the face by `rate` leaves it before its gap has fallen by more than round-off: no
// impact.
template <class S>
bool leaves_without_impact(const Bodies<S>& bodies, const Proximity<S>& proximity, const Candidate<S>& candidate,
                           S rate);
// Of a sphere on a mesh: does it overlap a facet other than the one that its contact is held at, in the state y? A pair
// has one candidate, and so one contact.
template <class S>
bool overlaps_other_facet(const Bodies<S>& bodies, const Proximity<S>& proximity, const Contact<S>& contact,
                          const S* y);
// Sets the facet that a contact moves on to, or marks the contact as having left its facet (Contact::left_facet). A
// contact of two edges, one of which now lies on a face of the other's body, has not left it where another candidate of
// the pair is closed, or within round-off of the facet. False: no contact is known there; report.outcome says why.
template <class S> bool change_facet(EventRun<S>& run, Contact<S>& contact);
// The deepest gap at which a pair is held in the state y: 0, or below for bodies that overlap at the start, and by the
// drift of lasting contacts within a step.
template <class S>
S target_gap_of_pair(const Bodies<S>& bodies, const Proximity<S>& proximity, const ActiveSet<S>& active, int pair,
                     const S* y);
// In the state y: true unless the bodies overlap beyond the depth of their contacts.
template <class S>
bool clear_of_boundary(const Bodies<S>& bodies, const Proximity<S>& proximity, const ActiveSet<S>& active,
                       const FaceBoundary<S>& boundary, const S* y);
// False: in the state y some body overlaps the boundary of a face; report.outcome says which.
template <class S>
bool clear_of_boundaries(const Bodies<S>& bodies, const Proximity<S>& proximity, const ActiveSet<S>& active,
                         Report& report, const S* y);
// May a body cross a boundary between the states y and y_end although it is clear at both?
template <class S>
bool may_cross_boundary(const Bodies<S>& bodies, const Proximity<S>& proximity, const S* y, const S* y_end);

}  // namespace atwood::event
