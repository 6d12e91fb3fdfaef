#include "integrators/kick_drift.hpp"

#include <algorithm>

namespace atwood {
namespace {

template <class S> void add3(int at, const Vec3<S>& increment, S* y, Compensation<S>& compensation) {
  y[at] = compensation.add(at, y[at], increment.x);
  y[at + 1] = compensation.add(at + 1, y[at + 1], increment.y);
  y[at + 2] = compensation.add(at + 2, y[at + 2], increment.z);
}
// Whether the body has an angular velocity. Without one every free top keeps the attitude exactly.
template <class S> bool turns(const RigidModel<S>& model, int body, const S* y) {
  if (!model.rotates(body)) return false;
  const S* w = y + model.offset(body) + kAtBodyRate;
  return w[0] != S(0) || w[1] != S(0) || w[2] != S(0);
}

template <class S> void add4(int at, const Quat<S>& increment, S* y, Compensation<S>& compensation) {
  y[at] = compensation.add(at, y[at], increment.w);
  add3(at + 1, Vec3<S>{increment.x, increment.y, increment.z}, y, compensation);
}

}  // namespace

template <class S>
bool drift(RigidModel<S>& model, FreeTop top, S direct_s, S adjoint_s, S* y, Compensation<S>& compensation) {
  const S h_s = direct_s + adjoint_s;
  bool solved = true;
  for (const int i : model.moving()) {
    const int at = model.offset(i);
    add3(at + kAtPosition, h_s * load3(y + at + kAtVelocity), y, compensation);
    if (!turns(model, i, y)) continue;
    FreeTurn<S> turn;
    solved = free_turn(top, model.mass(i), direct_s, adjoint_s, load3(y + at + kAtBodyRate), turn) && solved;
    if (turn.solve.iterations > 0)
      model.system().solvers.add_unless_capped(IterativeSolver::implicit_stages, turn.solve);
    add4(at + kAtAttitude, load4(y + at + kAtAttitude) * turn.minus_one, y, compensation);
    add3(at + kAtBodyRate, turn.dw_B, y, compensation);
  }
  return solved;
}

template <class S> void renormalise(const RigidModel<S>& model, S* y, Compensation<S>& compensation) {
  for (const auto& [at, rate_at] : model.attitudes()) {
    const Quat<S> q = load4(y + at);
    const S change = S(1) / real::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z) - S(1);
    add4(at, Quat<S>{change * q.w, change * q.x, change * q.y, change * q.z}, y, compensation);
  }
}

// Entries that accelerations() does not set stay 0: a kick changes no position and no attitude.
template <class S>
Kicker<S>::Kicker(RigidModel<S>& model)
    : model_(model), acceleration_(model.state_size()), middle_(model.state_size()), omega_W_(model.body_count()),
      solver_(model.velocity_dependent() ? model.state_size() : 0) {
}  // a square matrix: none where no kick is solved for

template <class S> void Kicker<S>::add(S h_s, S* y, Compensation<S>& compensation) const {
  for (const int i : model_.moving()) {
    const int v = model_.offset(i) + kAtVelocity, w = model_.offset(i) + kAtBodyRate;
    add3(v, h_s * load3(acceleration_.data() + v), y, compensation);
    if (model_.rotates(i)) add3(w, h_s * load3(acceleration_.data() + w), y, compensation);
  }
}

template <class S> void Kicker<S>::kick_again(S h_s, S* y, Compensation<S>& compensation) { add(h_s, y, compensation); }

// v_m = v + r a(v_m) with a(v) = b + v x omega: x = v_m - v solves x + s x x = r a(v), s = r omega, whose inverse is
// x -> (x - s x x + (s . x) s) / (1 + s^2); a(v_m) is x / r.
template <class S>
void Kicker<S>::kick_in_magnetic_field(S t_s, S direct_s, S adjoint_s, S* y, Compensation<S>& compensation) {
  if (omega_epoch_ != model_.system().epoch) {
    model_.gyration(omega_W_);
    omega_epoch_ = model_.system().epoch;
  }
  model_.accelerations(t_s, y, acceleration_.data());
  for (const int i : model_.moving()) {
    S* at = acceleration_.data() + model_.offset(i) + kAtVelocity;
    const Vec3<S> a = load3(at), s = adjoint_s * omega_W_[i];
    store3((S(1) / (S(1) + dot(s, s))) * (a - cross(s, a) + dot(s, a) * s), at);
  }
  add(direct_s + adjoint_s, y, compensation);
}

template <class S> bool Kicker<S>::kick(S t_s, S direct_s, S adjoint_s, S* y, Compensation<S>& compensation) {
  if (!model_.velocity_dependent() || adjoint_s == S(0)) {
    model_.accelerations(t_s, y, acceleration_.data());
    add(direct_s + adjoint_s, y, compensation);
    return true;
  }
  if (model_.magnetic_only()) {
    kick_in_magnetic_field(t_s, direct_s, adjoint_s, y, compensation);
    return true;
  }
  const auto kick_rate = [](void* model, S t, const S* z, S* g) {
    static_cast<RigidModel<S>*>(model)->accelerations(t, z, g);
  };
  std::copy(y, y + model_.state_size(), middle_.begin());
  solver_.solve(kick_rate, &model_, t_s, adjoint_s, y, middle_.data());
  const bool solved = model_.system().solvers.add_unless_capped(IterativeSolver::implicit_stages, solver_.report());
  model_.accelerations(t_s, middle_.data(), acceleration_.data());
  add(direct_s + adjoint_s, y, compensation);
  return solved;
}

#define ATWOOD_INSTANTIATE(S)                                                  \
  template bool drift<S>(RigidModel<S>&, FreeTop, S, S, S*, Compensation<S>&); \
  template void renormalise<S>(const RigidModel<S>&, S*, Compensation<S>&);    \
  template class Kicker<S>;
ATWOOD_INSTANTIATE(float)
ATWOOD_INSTANTIATE(double)
ATWOOD_INSTANTIATE(long double)
ATWOOD_INSTANTIATE(Quad)
#undef ATWOOD_INSTANTIATE

}  // namespace atwood
