// The narrow phase's special tests, kind(a) <= kind(b); the other pairs are tested by convex_contacts.hpp,
// mesh_pairs.cpp and compound_pairs.hpp. contacts.cpp holds the table.
#pragma once

#include <vector>

#include "collision/contacts.hpp"

namespace atwood {

template <class S> struct Posed {
  const Geometry<S>& shape;
  const Transform<S>& pose;
};

// As find_contacts and separation, for one pair of kinds.
template <class S>
using ContactTest = void (*)(const Posed<S>& a, const Posed<S>& b, S margin, std::vector<Manifold<S>>& out);
template <class S> using SeparationTest = Separation<S> (*)(const Posed<S>& a, const Posed<S>& b);

// ---- one point: the separation is the manifold ---------------------------------------------------------------------
template <class S> void sphere_sphere_contacts(const Posed<S>&, const Posed<S>&, S margin, std::vector<Manifold<S>>&);
template <class S> void sphere_plane_contacts(const Posed<S>&, const Posed<S>&, S margin, std::vector<Manifold<S>>&);
template <class S>  // box or rectangle
void sphere_box_contacts(const Posed<S>&, const Posed<S>&, S margin, std::vector<Manifold<S>>&);
template <class S> void sphere_capsule_contacts(const Posed<S>&, const Posed<S>&, S margin, std::vector<Manifold<S>>&);
template <class S> void sphere_cylinder_contacts(const Posed<S>&, const Posed<S>&, S margin, std::vector<Manifold<S>>&);
template <class S> Separation<S> sphere_sphere_separation(const Posed<S>&, const Posed<S>&);
template <class S> Separation<S> sphere_plane_separation(const Posed<S>&, const Posed<S>&);
template <class S> Separation<S> sphere_box_separation(const Posed<S>&, const Posed<S>&);
template <class S> Separation<S> sphere_capsule_separation(const Posed<S>&, const Posed<S>&);
template <class S> Separation<S> sphere_cylinder_separation(const Posed<S>&, const Posed<S>&);

// ---- against planes -------------------------------------------------------------------------------------------------
template <class S>  // box or rectangle
void plane_box_contacts(const Posed<S>&, const Posed<S>&, S margin, std::vector<Manifold<S>>&);
template <class S> void plane_capsule_contacts(const Posed<S>&, const Posed<S>&, S margin, std::vector<Manifold<S>>&);
template <class S> void plane_cylinder_contacts(const Posed<S>&, const Posed<S>&, S margin, std::vector<Manifold<S>>&);
template <class S> Separation<S> plane_box_separation(const Posed<S>&, const Posed<S>&);
template <class S> Separation<S> plane_capsule_separation(const Posed<S>&, const Posed<S>&);
template <class S> Separation<S> plane_cylinder_separation(const Posed<S>&, const Posed<S>&);

// ---- boxes and rectangles -------------------------------------------------------------------------------------------
template <class S> void box_box_contacts(const Posed<S>&, const Posed<S>&, S margin, std::vector<Manifold<S>>&);
template <class S> Separation<S> box_box_separation(const Posed<S>&, const Posed<S>&);

}  // namespace atwood
