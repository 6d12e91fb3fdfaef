// Boundaries of faces and lines that contacts leave.
#pragma once

#include "contact/event/active_set.hpp"

namespace atwood::event {

// Does the contact's surface have a boundary (all but planes and spheres)?
template <class S> bool has_boundary(const Proximity<S>& proximity, const Contact<S>& contact);
// The distance [m] of a contact's feature from the boundary of its facet; negative outside. From bodies.poses.
template <class S> S depth_inside_facet(const Bodies<S>& bodies, const Proximity<S>& proximity, Contact<S>& contact);
// Sets the facet that a contact moves on to. False: no contact is known there; report.outcome says why.
template <class S>
bool change_facet(const Bodies<S>& bodies, const Proximity<S>& proximity, Report& report, Contact<S>& contact);
// False: in the state y some body overlaps the boundary of a face; report.outcome says which.
template <class S>
bool clear_of_boundaries(const Bodies<S>& bodies, const Proximity<S>& proximity, const ActiveSet<S>& active,
                         Report& report, const S* y);
// May a body cross a boundary between the states y and y_end unseen at both?
template <class S>
bool may_cross_boundary(const Bodies<S>& bodies, const Proximity<S>& proximity, const S* y, const S* y_end);

}  // namespace atwood::event
