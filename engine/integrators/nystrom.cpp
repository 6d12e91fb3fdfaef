#include "integrators/nystrom.hpp"

#include <algorithm>

#include "math/scalar.hpp"

namespace atwood {
namespace {

// Calls of(p, v) with the indices of a position and its velocity for each coordinate of the moving bodies, which are
// all points. Held bodies do not move, also where they have a velocity for their release.
template <class S, class Of> void for_each_coordinate(const RigidModel<S>& model, const Of& of) {
  for (const int body : model.moving())
    for (int p = model.offset(body) + kAtPosition, k = 0; k < 3; ++k, ++p) of(p, p + kAtVelocity - kAtPosition);
}

}  // namespace

// ---- accelerations ----------------------------------------------------------------------------------------------
template <class S>
NystromAccelerations<S>::NystromAccelerations(RigidModel<S>& model, int stages)
    : model_(model), values_(static_cast<std::size_t>(stages) * model.state_size()), start_(model.state_size()),
      end_(model.state_size()) {
  for (int i = 0; i < stages; ++i) k_.push_back(values_.data() + static_cast<std::size_t>(i) * model.state_size());
}

template <class S> void NystromAccelerations<S>::start(S t_s, const S* y) {
  const std::size_t size = start_.size();
  const bool same_law = epoch_ == model_.system().epoch;
  const S same_instant_s = S(8) * real::epsilon<S>() * real::max(real::abs(t_s), real::abs(end_s_));
  const bool again = same_law && start_known_ && start_s_ == t_s && std::equal(y, y + size, start_.begin());
  const bool carries_on =
      same_law && end_stage_ >= 0 && real::abs(end_s_ - t_s) <= same_instant_s && std::equal(y, y + size, end_.begin());
  if (again) return;
  if (carries_on) std::swap(k_[0], k_[end_stage_]);
  else evaluate(0, t_s, y);
  std::copy(y, y + size, start_.begin());
  start_s_ = t_s;
  start_known_ = true;
  epoch_ = model_.system().epoch;
  end_stage_ = -1;
}

template <class S> void NystromAccelerations<S>::end(int stage, S t_s, const S* y_new) {
  std::copy(y_new, y_new + end_.size(), end_.begin());
  end_s_ = t_s;
  end_stage_ = stage;
}

// ---- Dormand and Prince -----------------------------------------------------------------------------------------
template <class S>
Nystrom<S>::Nystrom(RigidModel<S>& model, const NystromTableau& tableau, bool compensated)
    : Stepper<S>(model.system()), model_(model), stages_(tableau.stages),
      estimate_order_(std::min(tableau.order, tableau.embedded_order)), first_same_as_last_(tableau.first_same_as_last),
      k_(model, tableau.stages), stage_(model.state_size()), compensation_(compensated, model.state_size()) {
  const auto read = [&](const char* row) { return read_row(row, stages_); };
  const auto difference = [&](const char* weights, const char* embedded) {
    TableauRow row = read(weights);
    const TableauRow other = read(embedded);
    for (std::size_t i = 0; i < row.size(); ++i) row[i] -= other[i];
    return combine(row);
  };
  const TableauRow c = read(tableau.c);
  for (int i = 0; i < stages_; ++i) {
    a_[i] = combine(read(tableau.a[static_cast<std::size_t>(i)]));
    c_[i] = static_cast<S>(c[static_cast<std::size_t>(i)]);
  }
  b_ = combine(read(tableau.b));
  b_velocity_ = combine(read(tableau.b_velocity));
  error_ = difference(tableau.b, tableau.embedded);
  error_velocity_ = difference(tableau.b_velocity, tableau.embedded_velocity);
}

template <class S> auto Nystrom<S>::combine(const TableauRow& row) -> Combination {
  Combination combination;
  for (int j = 0; j < static_cast<int>(row.size()); ++j)
    if (row[static_cast<std::size_t>(j)] != Quad(0)) {
      combination.stage[combination.terms] = j;
      combination.weight[combination.terms++] = static_cast<S>(row[static_cast<std::size_t>(j)]);
    }
  return combination;
}

template <class S> S Nystrom<S>::sum(const Combination& combination, int velocity_entry) const {
  S total = S(0);
  for (int j = 0; j < combination.terms; ++j) total += combination.weight[j] * k_[combination.stage[j]][velocity_entry];
  return total;
}

// Forces are evaluated at stage_: it has the positions of the stage. Its velocities are not updated, as no force reads
// them.
template <class S> bool Nystrom<S>::step(S t_s, S h_s, const S* y, S* y_new) {
  const int size = this->system_.size;
  k_.start(t_s, y);
  std::copy(y, y + size, stage_.begin());
  const int inner = first_same_as_last_ ? stages_ - 1 : stages_;
  for (int i = 1; i < inner; ++i) {
    for_each_coordinate(model_, [&](int p, int v) { stage_[p] = y[p] + h_s * (c_[i] * y[v] + h_s * sum(a_[i], v)); });
    k_.evaluate(i, t_s + c_[i] * h_s, stage_.data());
  }
  std::copy(y, y + size, y_new);
  compensation_.begin(y);
  for_each_coordinate(model_,
                      [&](int p, int v) { y_new[p] = compensation_.add(p, y[p], h_s * (y[v] + h_s * sum(b_, v))); });
  if (first_same_as_last_) k_.evaluate(stages_ - 1, t_s + h_s, y_new);  // b' has a weight for it
  for_each_coordinate(model_, [&](int, int v) { y_new[v] = compensation_.add(v, y[v], h_s * sum(b_velocity_, v)); });
  compensation_.end(y_new);
  if (first_same_as_last_) k_.end(stages_ - 1, t_s + h_s, y_new);
  this->set_last_step(t_s, h_s, y, y_new);
  return true;
}

template <class S> S Nystrom<S>::error_norm(S rtol, S atol) const {
  const int size = this->system_.size;
  const S h = this->h_s_;
  S squares = S(0);
  const auto add = [&](int i, S error) {
    const S scale = atol + rtol * real::max(real::abs(this->y_[i]), real::abs(this->y_new_[i]));
    squares += (error / scale) * (error / scale);
  };
  for_each_coordinate(model_, [&](int p, int v) {
    add(p, h * h * sum(error_, v));
    add(v, h * sum(error_velocity_, v));
  });
  return real::sqrt(squares / S(size));
}

// ---- Blanes and Moan --------------------------------------------------------------------------------------------
template <class S>
SymplecticNystrom<S>::SymplecticNystrom(RigidModel<S>& model, const SymplecticNystromTable& table, bool compensated)
    : Stepper<S>(model.system()), model_(model), k_(model, 2), compensation_(compensated, model.state_size()) {
  for (const Quad kick : read_row(table.kicks)) kicks_.push_back(static_cast<S>(kick));
  for (const Quad drift : read_row(table.drifts)) drifts_.push_back(static_cast<S>(drift));
}

template <class S> bool SymplecticNystrom<S>::step(S t_s, S h_s, const S* y, S* y_new) {
  const int size = this->system_.size;
  const std::size_t last = drifts_.size();
  const auto kick = [&](S weight, const S* acceleration) {
    for_each_coordinate(model_,
                        [&](int, int v) { y_new[v] = compensation_.add(v, y_new[v], weight * h_s * acceleration[v]); });
  };
  std::copy(y, y + size, y_new);
  compensation_.begin(y);
  if (kicks_[0] != S(0)) {
    k_.start(t_s, y);
    kick(kicks_[0], k_[0]);
  }
  S node = S(0);
  for (std::size_t i = 0; i < last; ++i) {
    for_each_coordinate(model_,
                        [&](int p, int v) { y_new[p] = compensation_.add(p, y_new[p], drifts_[i] * h_s * y_new[v]); });
    node += drifts_[i];
    const S weight = kicks_[i + 1];
    if (weight == S(0)) continue;
    k_.evaluate(1, t_s + (i + 1 == last ? h_s : node * h_s), y_new);
    kick(weight, k_[1]);
  }
  compensation_.end(y_new);
  if (kicks_[last] != S(0)) k_.end(1, t_s + h_s, y_new);
  this->set_last_step(t_s, h_s, y, y_new);
  return true;
}

template class Nystrom<float>;
template class Nystrom<double>;
template class Nystrom<long double>;
template class Nystrom<Quad>;
template class SymplecticNystrom<float>;
template class SymplecticNystrom<double>;
template class SymplecticNystrom<long double>;
template class SymplecticNystrom<Quad>;

}  // namespace atwood
