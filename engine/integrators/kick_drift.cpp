#include "integrators/kick_drift.hpp"

#include <algorithm>

#include "rigid/free_top.hpp"

namespace atwood {

template <class S> void drift(const RigidModel<S>& model, S h_s, FreeTop top, S* y) {
  for (const int i : model.moving()) {
    S* at = y + model.offset(i);
    for (int k = 0; k < 3; ++k) at[at_position + k] += h_s * at[at_velocity + k];
    if (!model.rotates(i)) continue;
    Quat<S> q = load4(at + at_attitude);
    Vec3<S> w = load3(at + at_body_rate);
    if (top == FreeTop::lie) free_top_lie(model.mass(i), h_s, q, w);
    else free_top_strang(model.mass(i), h_s, q, w);
    store4(q, at + at_attitude);
    store3(w, at + at_body_rate);
  }
}

// Entries that accelerations() leaves alone stay 0: kicks move nothing.
template <class S>
Kicker<S>::Kicker(RigidModel<S>& model)
    : model_(model), acceleration_(model.state_size()), middle_(model.state_size()), solver_(model.state_size()) {}

template <class S> void Kicker<S>::explicit_kick(S t_s, S h_s, S* y) {
  model_.accelerations(t_s, y, acceleration_.data());
  for (const int i : model_.moving()) {
    const int at = model_.offset(i);
    for (int k = at + at_velocity; k < at + at_velocity + 3; ++k) y[k] += h_s * acceleration_[k];
    if (!model_.rotates(i)) continue;
    for (int k = at + at_body_rate; k < at + at_body_rate + 3; ++k) y[k] += h_s * acceleration_[k];
  }
}

// v_m = v + h/2 a(t, x, v_m), then v + h a(t, x, v_m).
template <class S> bool Kicker<S>::symmetric_kick(S t_s, S h_s, S* y) {
  if (!model_.velocity_dependent()) {
    explicit_kick(t_s, h_s, y);
    return true;
  }
  const auto kick_rate = [](void* model, S t, const S* z, S* g) {
    static_cast<RigidModel<S>*>(model)->accelerations(t, z, g);
  };
  std::copy(y, y + model_.state_size(), middle_.begin());
  const bool solved = solver_.solve(kick_rate, &model_, t_s, h_s / S(2), y, middle_.data());
  for (int k = 0; k < model_.state_size(); ++k) y[k] += S(2) * (middle_[k] - y[k]);
  return solved;
}

template void drift<float>(const RigidModel<float>&, float, FreeTop, float*);
template void drift<double>(const RigidModel<double>&, double, FreeTop, double*);
template void drift<long double>(const RigidModel<long double>&, long double, FreeTop, long double*);
template void drift<Quad>(const RigidModel<Quad>&, Quad, FreeTop, Quad*);
template class Kicker<float>;
template class Kicker<double>;
template class Kicker<long double>;
template class Kicker<Quad>;

}  // namespace atwood
