#include "integrators/maximal_coordinates.hpp"

#include <algorithm>

#include "integrators/families.hpp"
#include "math/so3.hpp"
#include "rigid/free_top.hpp"

namespace atwood {

Result<Scene> in_maximal_coordinates(const Scene& scene, const std::string& scheme) {
  const auto none = [&](const std::string& of) { return cannot_step(scheme, "does not support " + of); };
  Scene free = scene;
  for (Joint& joint : free.joints) {
    if (joint.limits) return none("joint limits");
    if (joint.driven_rate) return none("prescribed motion of joints");
    joint.closes_loop = true;
    joint.hold.clear();
  }
  for (const Rope& rope : scene.ropes)
    for (const Pulley& pulley : rope.over)
      if (pulley.inertia_kg_m2 > 0) return none("pulleys with inertia");
  if (!scene.joint_forces.empty()) return none("forces along joints");
  return free;
}

// ---- constraints -------------------------------------------------------------------------------------------------
namespace {

// R^T v
template <class S> Vec3<S> in_body(const RigidModel<S>& model, int body, const S* y, const Vec3<S>& v) {
  return rotate_back(load4(y + model.offset(body) + kAtAttitude), v);
}

}  // namespace

template <class S> void MaximalConstraints<S>::factor_at(const S* y) {
  model_.constraints()->rows_at(y, rows_);
  ties_.clear();
  local_.assign(static_cast<std::size_t>(model_.body_count()), -1);
  int size = 0;
  for (const BodyRow<S>& row : rows_) {
    Tie tie{{row.body[0], row.body[1]}, {}, {}, S(1)};
    for (int k = 0; k < 2; ++k) {
      const int body = row.body[k];
      if (body < 0) continue;
      tie.force[k] = row.on[k].force;
      if (model_.rotates(body)) tie.torque_B[k] = in_body(model_, body, y, row.on[k].torque);
      if (local_[body] >= 0) continue;
      local_[body] = size;
      size += 6;
    }
    ties_.push_back(tie);
  }
  qr_.resize(size, count());
  for (int j = 0; j < count(); ++j) {
    Tie& tie = ties_[j];
    S* column = qr_.column(j);
    std::fill(column, column + size, S(0));
    for (int k = 0; k < 2; ++k) {
      if (tie.body[k] < 0) continue;
      const MassProperties<S>& mass = model_.mass(tie.body[k]);
      S* at = column + local_[tie.body[k]];
      store3(load3(at) + real::sqrt(mass.inverse_mass_per_kg) * tie.force[k], at);
      if (!model_.rotates(tie.body[k])) continue;
      const Vec3<S> t = rotate_back(mass.principal.q_BP, tie.torque_B[k]), &I = mass.principal.moments;
      store3(load3(at + 3) + Vec3<S>{t.x / real::sqrt(I.x), t.y / real::sqrt(I.y), t.z / real::sqrt(I.z)}, at + 3);
    }
    S square = S(0);
    for (int i = 0; i < size; ++i) square += column[i] * column[i];
    tie.scale = S(1) / real::sqrt(square);
    for (int i = 0; i < size; ++i) column[i] *= tie.scale;
  }
  qr_.factor(S(1024) * real::epsilon<S>());
  z_.resize(static_cast<std::size_t>(size));
  x_.resize(ties_.size());
  b_.resize(ties_.size());
}

template <class S> void MaximalConstraints<S>::change_rates(const std::vector<S>& b, S* v) {
  for (int j = 0; j < count(); ++j) b_[j] = ties_[j].scale * b[j];
  qr_.solve(b_.data(), z_.data());
  qr_.multipliers(x_.data());
  for (int j = 0; j < count(); ++j) {
    const Tie& tie = ties_[j];
    const S x = tie.scale * x_[j];
    if (x == S(0)) continue;
    for (int k = 0; k < 2; ++k) {
      if (tie.body[k] < 0) continue;
      const MassProperties<S>& mass = model_.mass(tie.body[k]);
      S* at = v + model_.offset(tie.body[k]);
      store3(load3(at + kAtVelocity) + (x * mass.inverse_mass_per_kg) * tie.force[k], at + kAtVelocity);
      if (!model_.rotates(tie.body[k])) continue;
      store3(load3(at + kAtBodyRate) + x * mass.times_inverse_inertia(tie.torque_B[k]), at + kAtBodyRate);
    }
  }
}

template <class S> void MaximalConstraints<S>::rates(const S* v, std::vector<S>& out) const {
  out.resize(ties_.size());
  for (int j = 0; j < count(); ++j) {
    const Tie& tie = ties_[j];
    out[j] = S(0);
    for (int k = 0; k < 2; ++k) {
      if (tie.body[k] < 0) continue;
      const S* at = v + model_.offset(tie.body[k]);
      out[j] += dot(tie.force[k], load3(at + kAtVelocity));
      if (model_.rotates(tie.body[k])) out[j] += dot(tie.torque_B[k], load3(at + kAtBodyRate));
    }
  }
}

template <class S> S MaximalConstraints<S>::values_at(const S* y, std::vector<S>& out) {
  model_.constraints()->rows_at(y, rows_);
  out.resize(rows_.size());
  S worst = S(0);
  for (std::size_t j = 0; j < rows_.size(); ++j) {
    out[j] = rows_[j].value;
    const S now = real::abs(rows_[j].value) / rows_[j].tolerance;
    if (!(now <= worst)) worst = now;
  }
  return worst;
}

// ---- RATTLE ------------------------------------------------------------------------------------------------------
template <class S>
Rattle<S>::Rattle(RigidModel<S>& model, std::vector<S> fractions)
    : Stepper<S>(model.system()), model_(model), fractions_(std::move(fractions)), acceleration_(model.state_size()),
      kicked_(model.state_size()), constraints_(model) {}

template <class S> void Rattle<S>::kick(S t_s, S h_s, S* y) {
  model_.accelerations(t_s, y, acceleration_.data());
  for (const int i : model_.moving()) {
    const int v = model_.offset(i) + kAtVelocity, w = model_.offset(i) + kAtBodyRate;
    for (int k = 0; k < 3; ++k) y[v + k] += h_s * acceleration_[v + k];
    if (!model_.rotates(i)) continue;
    for (int k = 0; k < 3; ++k) y[w + k] += h_s * acceleration_[w + k];
  }
}

namespace {

// The free motion of all bodies over h_s.
template <class S> bool drift_freely(const RigidModel<S>& model, S h_s, S* y) {
  bool solved = true;
  for (const int i : model.moving()) {
    S* at = y + model.offset(i);
    store3(load3(at + kAtPosition) + h_s * load3(at + kAtVelocity), at + kAtPosition);
    if (!model.rotates(i)) continue;
    const Vec3<S> w = load3(at + kAtBodyRate);
    if (w.x == S(0) && w.y == S(0) && w.z == S(0)) continue;
    FreeTurn<S> turn;
    solved = free_turn(FreeTop::exact, model.mass(i), h_s / S(2), h_s / S(2), w, turn) && solved;
    const Quat<S> q = load4(at + kAtAttitude), change = q * turn.minus_one;
    store4(normalised(Quat<S>{q.w + change.w, q.x + change.x, q.y + change.y, q.z + change.z}), at + kAtAttitude);
    store3(w + turn.dw_B, at + kAtBodyRate);
  }
  return solved;
}

}  // namespace

template <class S> bool Rattle<S>::rattle(S t_s, S h_s, S* y) {
  constexpr int max_iterations = 50;
  constraints_.factor_at(y);
  kick(t_s, h_s / S(2), y);
  std::copy(y, y + model_.state_size(), kicked_.begin());
  SolveReport report;
  S before = S(0);
  for (int n = 0;; ++n) {
    std::copy(kicked_.begin(), kicked_.end(), y);
    if (!drift_freely(model_, h_s, y)) return false;
    const S now = constraints_.values_at(y, values_);
    report.iterations = n;
    report.residual = static_cast<double>(now * S(16) * real::epsilon<S>());
    if (now <= S(1)) break;
    if (n > 2 && now > before / S(2) && now <= S(256)) {
      report.ended = SolveEnd::stagnated;
      break;
    }
    if (n == max_iterations || !(now < S(1e30f))) {
      report.ended = SolveEnd::capped;
      break;
    }
    before = now;
    for (S& value : values_) value = -value / h_s;
    constraints_.change_rates(values_, kicked_.data());
  }
  if (!model_.system().solvers.add_unless_capped(IterativeSolver::implicit_stages, report)) return false;
  kick(t_s + h_s, h_s / S(2), y);
  constraints_.factor_at(y);
  constraints_.rates(y, b_);
  for (S& rate : b_) rate = -rate;
  constraints_.change_rates(b_, y);
  return true;
}

template <class S> bool Rattle<S>::step(S t_s, S h_s, const S* y, S* y_new) {
  std::copy(y, y + model_.state_size(), y_new);
  S at = S(0);
  for (const S fraction : fractions_) {
    if (!rattle(t_s + at * h_s, fraction * h_s, y_new)) return false;
    at += fraction;
  }
  this->set_last_step(t_s, h_s, y, y_new);
  return true;
}

// ---- Baumgarte ---------------------------------------------------------------------------------------------------
template <class S>
BaumgarteEuler<S>::BaumgarteEuler(RigidModel<S>& model, S erp)
    : Stepper<S>(model.system()), model_(model), erp_(erp), acceleration_(model.state_size()), constraints_(model) {}

template <class S> bool BaumgarteEuler<S>::step(S t_s, S h_s, const S* y, S* y_new) {
  std::copy(y, y + model_.state_size(), y_new);
  constraints_.factor_at(y);
  constraints_.values_at(y, values_);
  model_.accelerations(t_s, y, acceleration_.data());
  for (const int i : model_.moving()) {
    S* at = y_new + model_.offset(i);
    const S* a = acceleration_.data() + model_.offset(i);
    store3(load3(at + kAtVelocity) + h_s * load3(a + kAtVelocity), at + kAtVelocity);
    if (!model_.rotates(i)) continue;
    const MassProperties<S>& mass = model_.mass(i);
    const Vec3<S> w = load3(at + kAtBodyRate);
    const Vec3<S> gyration = mass.times_inverse_inertia(cross(mass.times_inertia(w), w));
    store3(w + h_s * (load3(a + kAtBodyRate) + gyration), at + kAtBodyRate);
  }
  constraints_.rates(y_new, b_);
  for (std::size_t j = 0; j < b_.size(); ++j) b_[j] = -(b_[j] + erp_ / h_s * values_[j]);
  constraints_.change_rates(b_, y_new);
  for (const int i : model_.moving()) {
    S* at = y_new + model_.offset(i);
    store3(load3(at + kAtPosition) + h_s * load3(at + kAtVelocity), at + kAtPosition);
    if (!model_.rotates(i)) continue;
    store4(normalised(load4(at + kAtAttitude) * so3_exp(h_s * load3(at + kAtBodyRate))), at + kAtAttitude);
  }
  this->set_last_step(t_s, h_s, y, y_new);
  return true;
}

#define ATWOOD_MAXIMAL(S)               \
  template class MaximalConstraints<S>; \
  template class Rattle<S>;             \
  template class BaumgarteEuler<S>;
ATWOOD_MAXIMAL(float)
ATWOOD_MAXIMAL(double)
ATWOOD_MAXIMAL(long double)
ATWOOD_MAXIMAL(Quad)
#undef ATWOOD_MAXIMAL

}  // namespace atwood
