// Conserved quantities of a motion, from samples, by the reference's own formulas. SI units; world axes; sums in Wide.
#pragma once

#include <array>
#include <string_view>

#include "protocol/sample_series.hpp"
#include "scene/scene.hpp"

namespace atwood::dynamics {

using Wide3 = std::array<Wide, 3>;

struct Energy {
  Wide kinetic_J = 0;    // 1/2 m v^2 + 1/2 w I w, of pulleys too; in a rotating frame: of the velocity relative to it
  Wide potential_J = 0;  // uniform and mutual gravity, attractors, springs, electric field, Coulomb, named potentials,
                         // springs and constant torques of joints,
                         // and -1/2 m |W x r|^2 in a rotating frame: then kinetic + potential is the Jacobi integral
};
Energy energy(const Scene& scene, const SampleView& sample);

Wide3 momentum(const Scene& scene, const SampleView& sample);                       // sum m v [kg m/s]
Wide3 angular_momentum(const Scene& scene, const SampleView& sample);               // about the origin [kg m^2/s]
Wide3 angular_momentum_about_center(const Scene& scene, const SampleView& sample);  // about the centre of mass
Wide3 center_of_mass(const Scene& scene, const SampleView& sample);                 // [m]
Wide total_mass_kg(const Scene& scene);                                             // of mobile bodies

// v x (r x v) - mu r / |r| about the first attractor (mu, its centre) that acts on `body`; or of two mutually
// gravitating bodies (r = p_1 - p_0, mu = G (m_0 + m_1)) when body is 1 and there is no attractor. Zero otherwise.
Wide3 laplace_runge_lenz(const Scene& scene, const SampleView& sample, int body);

// m |v_perp - v_drift|^2 / (2 |B|) [J/T] with v_drift = E x B / B^2, of the first Lorentz force on `body`.
Wide magnetic_moment(const Scene& scene, const SampleView& sample, int body);

// Does the exact motion of the scene conserve this quantity? energy, momentum, angular-momentum (about the origin),
// angular-momentum-center, center-of-mass (its motion is uniform), jacobi-constant, laplace-runge-lenz,
// magnetic-moment, swinging-atwood (swinging_atwood.hpp). Unknown names: false. Impacts count: a bounce with
// restitution < 1 loses energy.
bool conserves(const Scene& scene, std::string_view quantity);

}  // namespace atwood::dynamics
