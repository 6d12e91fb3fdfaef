// What an impact does to two bodies: an impulse at a point, linear and angular.
#pragma once

#include "math/vec3.hpp"

namespace atwood {

// One side of an impact. A fixed body has inverse mass 0 and an inverse inertia of zeros.
template <class S> struct ImpactBody {
  S inverse_mass_per_kg{};
  Vec3<S> I_inverse_W_row[3];  // about the centre of mass, world axes
  Vec3<S> r_W;                 // from the centre of mass to the point
  Vec3<S> v_W, w_W;            // before; the impulse changes them
};

template <class S> struct ImpactLaw { S restitution{}, friction{}; };

template <class S> struct Impulse {
  S normal_N_s{}, tangential_N_s{};
  S vn_before_m_per_s{}, vn_after_m_per_s{};  // (v_b - v_a) . n at the point
};

// Newton's restitution and Coulomb friction at one point; `normal` is a unit vector from a to b. Not approaching:
// nothing happens. The tangential impulse opposes the slip and stops it if the cone allows (stick), else lies on the
// cone (slip); its direction is the slip's, so it is exact where slip keeps its direction (spheres always).
// Source: Brach, Mechanical Impact Dynamics (1991), ch. 6; J_n = -(1 + e) v_n / (n . K n).
template <class S>
Impulse<S> collide(const ImpactLaw<S>& law, const Vec3<S>& normal, ImpactBody<S>& a, ImpactBody<S>& b);

// An impulse along `direction` on b, its opposite on a.
template <class S> void push(ImpactBody<S>& a, ImpactBody<S>& b, const Vec3<S>& direction, S impulse_N_s);
// (v_b - v_a) at the point.
template <class S> Vec3<S> velocity_between(const ImpactBody<S>& a, const ImpactBody<S>& b);
// d . K d: how much relative velocity along the unit vector d an impulse of 1 N s along d makes [1/kg].
template <class S> S mobility(const ImpactBody<S>& a, const ImpactBody<S>& b, const Vec3<S>& d);

}  // namespace atwood
