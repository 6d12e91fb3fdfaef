// The rates of a rigid scene. A run spends most of its time here.
#include "rigid/model.hpp"

namespace atwood {

template <class S> void RigidModel<S>::add_loads(S t_s, const S* y) {
  for (const int i : moving_) loads_[i] = Load<S>{gravity_, {}, {}};
  for (const int i : on_joints_) loads_[i] = Load<S>{gravity_, {}, {}};
  const Motion<S> motion{t_s, y, slots_.data()};
  for (const ForceTerm<S>* term : active_) term->add_loads(motion, loads_.data());
}

// Newton and Euler, attitude embedded in R^4:
//   p' = v    v' = g + F / m    q' = 1/2 q (0, w)    I w' = tau - w x (I w)      (w, tau in body axes)
template <class S> void RigidModel<S>::rate_of(void* context, S t_s, const S* y, S* dydt) {
  RigidModel& model = *static_cast<RigidModel*>(context);
  if (model.holds_)
    for (int i = 0; i < model.state_size_; ++i) dydt[i] = S(0);  // held bodies do not move
  model.add_loads(t_s, y);
  for (const int i : model.moving_) {
    const Slot<S>& slot = model.slots_[i];
    const MassProperties<S>& mass = model.mass_[i];
    const Load<S>& load = model.loads_[i];
    const S* at = y + slot.offset;
    S* rate = dydt + slot.offset;
    for (int k = 0; k < 3; ++k) rate[kAtPosition + k] = at[kAtVelocity + k];
    store3(load.acceleration_W + mass.inverse_mass_per_kg * load.force_W, rate + kAtVelocity);
    if (!slot.rotates) continue;
    const Vec3<S> w = load3(at + kAtBodyRate);
    store4(quaternion_rate(load4(at + kAtAttitude), w), rate + kAtAttitude);
    store3(mass.times_inverse_inertia(load.torque_B - cross(w, mass.times_inertia(w))), rate + kAtBodyRate);
  }
}

template <class S> void RigidModel<S>::accelerations(S t_s, const S* y, S* dydt) {
  ++system_.evaluations;
  add_loads(t_s, y);
  for (const int i : moving_) {
    S* rate = dydt + slots_[i].offset;
    store3(loads_[i].acceleration_W + mass_[i].inverse_mass_per_kg * loads_[i].force_W, rate + kAtVelocity);
    if (slots_[i].rotates) store3(mass_[i].times_inverse_inertia(loads_[i].torque_B), rate + kAtBodyRate);
  }
}

// The class itself is instantiated in model.cpp.
#define ATWOOD_RATE(S)                                          \
  template void RigidModel<S>::add_loads(S, const S*);          \
  template void RigidModel<S>::rate_of(void*, S, const S*, S*); \
  template void RigidModel<S>::accelerations(S, const S*, S*);
ATWOOD_RATE(float)
ATWOOD_RATE(double)
ATWOOD_RATE(long double)
ATWOOD_RATE(Quad)
#undef ATWOOD_RATE

}  // namespace atwood
