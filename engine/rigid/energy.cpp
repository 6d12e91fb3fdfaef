// The energy of a rigid scene.
#include "joints/closing_force.hpp"
#include "rigid/model.hpp"

namespace atwood {

template <class S> S RigidModel<S>::kinetic_energy(const S* y) const {
  S twice = S(0);
  for (const int i : moving_) {
    const S* at = y + slots_[i].offset;
    const Vec3<S> v = load3(at + kAtVelocity);
    twice += mass_[i].mass_kg * dot(v, v);
    if (!slots_[i].rotates) continue;
    const Vec3<S> w = load3(at + kAtBodyRate);
    twice += dot(w, mass_[i].times_inertia(w));
  }
  for (const int i : on_joints_) {  // placed by the caller
    const S* at = placed_.data() + i * kBodyScalars;
    const Vec3<S> v = load3(at + kAtVelocity), w = load3(at + kAtBodyRate);
    twice += mass_[i].mass_kg * dot(v, v) + dot(w, mass_[i].times_inertia(w));
  }
  return twice / S(2);
}

// Joints whose motion is prescribed are where y has them, as in body().
template <class S> S RigidModel<S>::potential_energy(const S* y) const {
  place_bodies(S(0), y, DrivenJoints::from_state);
  const S forces = conservative_.potential_energy(Motion<S>{S(0), y, slots_.data()});
  if (joint_forces_ == nullptr) return forces;
  S energy = forces + joint_forces_->potential_energy(*tree_, y);
  for (const auto& term : terms_)
    if (const ClosingForce<S>* force = closing_force(term.get()))
      energy += force->potential_energy(Motion<S>{S(0), y, slots_.data()});
  return energy;
}

template <class S> S RigidModel<S>::energy(const S* y) const {
  const S potential = potential_energy(y);  // places the bodies
  return kinetic_energy(y) + potential;
}

template <class S> S RigidModel<S>::energy_scale(const S* y) const {
  const S potential = potential_energy(y);
  return kinetic_energy(y) + real::abs(potential);
}

template float RigidModel<float>::energy(const float*) const;
template double RigidModel<double>::energy(const double*) const;
template long double RigidModel<long double>::energy(const long double*) const;
template Quad RigidModel<Quad>::energy(const Quad*) const;
template float RigidModel<float>::energy_scale(const float*) const;
template double RigidModel<double>::energy_scale(const double*) const;
template long double RigidModel<long double>::energy_scale(const long double*) const;
template Quad RigidModel<Quad>::energy_scale(const Quad*) const;

}  // namespace atwood
