// The impact of two bodies at a point: impulses of Coulomb's law of friction and an impact law.
#pragma once

#include "math/vec3.hpp"
#include "protocol/solver_report.hpp"

namespace atwood {

// One body of an impact. A fixed body has the inverse mass 0 and an inverse inertia of zeros.
template <class S> struct ImpactBody {
  S inverse_mass_per_kg{};
  Vec3<S> I_inverse_W_row[3];  // about the centre of mass, world axes
  Vec3<S> r_W;                 // [m] from the centre of mass to the point
  Vec3<S> v_W, w_W;            // [m/s], [rad/s] before the impact, then after it
};

// What restitution e means, v_n the normal velocity between the bodies at the point (negative: they approach), p the
// normal impulse, W the work of the normal impulse; compression ends where v_n = 0.
//   newton   v_n after = -e v_n before                     can gain energy where friction couples to v_n (eccentric
//                                                          impacts)
//   poisson  p after compression = e p of compression      never gains for e <= 1
//   stronge  W after compression = -e^2 W of compression   never gains for e <= 1
// Without friction, and where friction does not act on v_n (spheres), the three are one.
enum class Restitution : unsigned char { newton, poisson, stronge };

template <class S> struct ImpactLaw {
  S restitution{}, friction{};
  S rolling_friction_m{};  // bound of the couple against rolling per normal impulse
  Restitution hypothesis = Restitution::newton;
};

template <class S> struct Impulse {
  S normal_N_s{}, tangential_N_s{};
  S vn_before_m_per_s{}, vn_after_m_per_s{};  // (v_b - v_a) . n at the point
  bool converged = true;                      // false: `solve` is capped
  SolveReport solve;  // the slip's path (slip_path.hpp) or, after one that was not capped, that against rolling
};

// Keeps the report of a solve within the impact, unless one before it was capped.
template <class S> void add_solve(const SolveReport& solve, Impulse<S>& impulse);

// One impact at one point under Coulomb friction; `normal` is a unit vector from a to b. Without approach nothing
// happens. Friction opposes the slip while there is slip, and sticks where the cone allows; slip may stop, reverse or
// turn during the impact (slip_path.hpp). In closed form, exact to round-off, where the inverse mass matrix K of the
// point (slip_path.hpp) keeps the slip's direction: always for spheres. Rolling friction: of the couples within its
// bound, the one that leaves the least energy. Sources: Brach, Mechanical Impact Dynamics (1991), ch. 6; Keller, J.
// Appl. Mech. 53 (1986) 1; Stronge, Impact Mechanics (2000).
template <class S>
Impulse<S> collide(const ImpactLaw<S>& law, const Vec3<S>& normal, ImpactBody<S>& a, ImpactBody<S>& b);

// The impact without collision of a point in contact, v_n = 0, that slips along s so that friction presses it on more
// than it is pushed back (n . K n - mu n . K s < 0): compression goes on until the slip has stopped or turned far
// enough, then restitution follows. Needs Poisson's or Stronge's hypothesis; under newton, which has no approach speed
// to restore, the impulse is 0, as where there is no such impact. Sources: Darboux, Etude geometrique sur les
// percussions et le choc des corps (1880); Keller (1986); Champneys and Varkonyi, IMA J. Appl. Math. 81 (2016) 538.
template <class S>
Impulse<S> collide_without_approach(const ImpactLaw<S>& law, const Vec3<S>& normal, ImpactBody<S>& a, ImpactBody<S>& b);

// An impulse along `direction` on b, the opposite on a.
template <class S> void apply_impulse(ImpactBody<S>& a, ImpactBody<S>& b, const Vec3<S>& direction, S impulse_N_s);
// An angular impulse [N m s] on b, the opposite on a.
template <class S> void apply_couple(ImpactBody<S>& a, ImpactBody<S>& b, const Vec3<S>& couple_N_m_s);
// Velocity of b relative to a at the point.
template <class S> Vec3<S> relative_velocity(const ImpactBody<S>& a, const ImpactBody<S>& b);
// Inverse effective mass d . K d [1/kg]: relative velocity along the unit vector d per impulse of 1 N s along d.
template <class S> S inverse_effective_mass(const ImpactBody<S>& a, const ImpactBody<S>& b, const Vec3<S>& d);
// c . K d: relative velocity along c per impulse along d.
template <class S>
S inverse_effective_mass(const ImpactBody<S>& a, const ImpactBody<S>& b, const Vec3<S>& c, const Vec3<S>& d);

}  // namespace atwood
