#include "integrators/conserving_correction.hpp"

#include <algorithm>

namespace atwood {

template <class S>
ClassicalIncrement<S>::ClassicalIncrement(System<S>& system)
    : system_(system), first_(system.size), k_(system.size), stage_(system.size) {}

// d = h/6 (k1 + 2 k2 + 2 k3 + k4)        (Hairer, Norsett, Wanner I, table II.1.2)
template <class S> void ClassicalIncrement<S>::evaluate(S t_s, S h_s, const S* y, S* d) {
  const S node[] = {S(0), S(0.5), S(0.5), S(1)};
  const S weight[] = {S(1) / S(6), S(1) / S(3), S(1) / S(3), S(1) / S(6)};
  const int size = system_.size;
  for (int stage = 0; stage < 4; ++stage) {
    if (stage == 0) {
      system_.rate(t_s, y, k_.data());
      first_ = k_;
      std::fill(d, d + size, S(0));
    } else {
      for (int i = 0; i < size; ++i) stage_[i] = y[i] + node[stage] * h_s * k_[i];
      system_.rate(t_s + node[stage] * h_s, stage_.data(), k_.data());
    }
    for (int i = 0; i < size; ++i) d[i] += weight[stage] * k_[i];
  }
  for (int i = 0; i < size; ++i) d[i] *= h_s;
}

template <class S> bool RunInvariants<S>::continues(const S* y) {
  const std::int64_t epoch = model_.system().epoch;
  const bool known =
      epoch == epoch_ && (std::equal(end_.begin(), end_.end(), y) || std::equal(start_.begin(), start_.end(), y));
  epoch_ = epoch;
  std::copy(y, y + start_.size(), start_.begin());
  return known;
}

template <class S> void RunInvariants<S>::end(const S* y_new) { std::copy(y_new, y_new + end_.size(), end_.begin()); }

// ---- projection ---------------------------------------------------------------------------------------------------
template <class S>
ProjectedRungeKutta<S>::ProjectedRungeKutta(RigidModel<S>& model, bool compensated)
    : Stepper<S>(model.system()), model_(model), size_(model.state_size()), classical_(model.system()),
      run_invariants_(model), compensation_(compensated, size_), spin_(model.body_count()),
      force_W_(model.body_count()), d_(size_), trial_(size_), inverse_metric_(size_) {
  for (auto& direction : direction_) direction.resize(size_);
}

// g: energy and angular momentum of the bodies' centres less their values to be kept. scale: the scale of their
// round-off.
template <class S> void ProjectedRungeKutta<S>::residuals(const S* y, S* g, S* scale) const {
  const S potential = model_.conservative().potential_energy(model_.motion(S(0), y));
  S kinetic = S(0), size = S(0);
  Vec3<S> momentum;
  for (const int body : model_.moving()) {
    const S* at = y + model_.offset(body);
    const Vec3<S> r = load3(at + kAtPosition) - model_.conservative().centre(), v = load3(at + kAtVelocity);
    const S m = model_.mass(body).mass_kg;
    kinetic += m * dot(v, v) / S(2);
    momentum += m * cross(r, v);
    size += m * norm(r) * norm(v);
  }
  const Vec3<S> off = momentum - momentum_;
  g[0] = kinetic + potential - energy_;
  g[1] = off.x;
  g[2] = off.y;
  g[3] = off.z;
  scale[0] = kinetic + real::abs(potential);
  scale[1] = scale[2] = scale[3] = size;
}

template <class S> void ProjectedRungeKutta<S>::take_invariants(const S* y) {
  energy_ = S(0);
  momentum_ = {};
  S g[kMaxInvariants], scale[kMaxInvariants];
  residuals(y, g, scale);
  energy_ = g[0];
  momentum_ = {g[1], g[2], g[3]};
  for (const int body : model_.moving()) {
    if (!model_.rotates(body)) continue;
    const BodyState<S> state = model_.body(body, y);
    const Vec3<S> momentum_B = model_.mass(body).times_inertia(state.w_WB_B);
    spin_[body] = {dot(state.w_WB_B, momentum_B), rotate(state.q_WB, momentum_B)};
  }
}

template <class S> void ProjectedRungeKutta<S>::find_metric(const S* y) {
  S speeds = S(0), accelerations = S(0);
  for (const int body : model_.moving()) {
    const Vec3<S> v = load3(y + model_.offset(body) + kAtVelocity);
    const Vec3<S> a = load3(classical_.first_slope() + model_.offset(body) + kAtVelocity);
    speeds += model_.mass(body).mass_kg * dot(v, v);
    accelerations += model_.mass(body).mass_kg * dot(a, a);
  }
  const S tau2 = speeds > S(0) && accelerations > S(0) ? speeds / accelerations : S(1);
  std::fill(inverse_metric_.begin(), inverse_metric_.end(), S(0));
  for (const int body : model_.moving())
    for (int i = 0; i < 3; ++i) {
      const S inverse = model_.mass(body).inverse_mass_per_kg;
      inverse_metric_[model_.offset(body) + kAtPosition + i] = tau2 * inverse;
      inverse_metric_[model_.offset(body) + kAtVelocity + i] = inverse;
    }
}

// Gradients at y, made orthonormal one after another (modified Gram-Schmidt).
template <class S> void ProjectedRungeKutta<S>::find_directions(const S* y, int constraints) {
  for (auto& direction : direction_) std::fill(direction.begin(), direction.end(), S(0));
  std::copy(y, y + size_, trial_.begin());
  for (const int body : model_.moving())  // at rest: forces that do no work vanish, the rest is -grad U
    for (int i = 0; i < 3; ++i) trial_[model_.offset(body) + kAtVelocity + i] = S(0);
  std::fill(force_W_.begin(), force_W_.end(), Vec3<S>{});
  const Motion<S> motion = model_.motion(S(0), trial_.data());
  model_.conservative().add_discrete_forces(motion, motion, force_W_.data());
  for (const int body : model_.moving()) {
    const int p = model_.offset(body) + kAtPosition, v = model_.offset(body) + kAtVelocity;
    const S m = model_.mass(body).mass_kg;
    const Vec3<S> r = load3(y + p) - model_.conservative().centre(), u = load3(y + v);
    store3(-force_W_[body], &direction_[0][p]);
    store3(m * u, &direction_[0][v]);
    const Vec3<S> axis[] = {{S(1), S(0), S(0)}, {S(0), S(1), S(0)}, {S(0), S(0), S(1)}};
    for (int c = 1; c < constraints; ++c) {  // e . m (r x u): by r it is m u x e, by u it is m e x r
      store3(m * cross(u, axis[c - 1]), &direction_[c][p]);
      store3(m * cross(axis[c - 1], r), &direction_[c][v]);
    }
  }
  for (int c = 0; c < constraints; ++c) {
    const auto product = [&](int b) {
      S sum = S(0);
      for (int i = 0; i < size_; ++i) sum += inverse_metric_[i] * direction_[b][i] * direction_[c][i];
      return sum;
    };
    const S before = product(c);
    for (int b = 0; b < c; ++b) {
      if (!kept_[b]) continue;
      triangle_[c][b] = product(b);
      for (int i = 0; i < size_; ++i) direction_[c][i] -= triangle_[c][b] * direction_[b][i];
    }
    const S left = product(c);
    kept_[c] = before > S(0) && left > S(1e-4) * before;
    if (!kept_[c]) continue;
    triangle_[c][c] = real::sqrt(left);
    for (int i = 0; i < size_; ++i) direction_[c][i] /= triangle_[c][c];
  }
}

// Simplified Newton along the directions: sum_b triangle_cb mu_b = -g_c. Ends at round-off.
template <class S> SolveReport ProjectedRungeKutta<S>::satisfy(S* y, int constraints) {
  constexpr int max_rounds = 12;
  find_directions(y, constraints);
  S before = S(1e30f);
  for (int n = 0; n < max_rounds; ++n) {
    S g[kMaxInvariants], scale[kMaxInvariants], mu[kMaxInvariants] = {};
    residuals(y, g, scale);
    S now = S(0);
    for (int c = 0; c < constraints; ++c)
      if (kept_[c] && scale[c] > S(0)) now = real::max(now, real::abs(g[c]) / scale[c]);
    const double misfit = static_cast<double>(now);
    if (now <= real::epsilon<S>() / S(2)) return {n, misfit, SolveEnd::converged};
    if (now >= before / S(2) && now <= S(64) * real::epsilon<S>()) return {n, misfit, SolveEnd::stagnated};
    if (!(now < before)) return {n, misfit, SolveEnd::capped};
    before = now;
    for (int c = 0; c < constraints; ++c) {
      if (!kept_[c]) continue;
      mu[c] = -g[c];
      for (int b = 0; b < c; ++b)
        if (kept_[b]) mu[c] -= triangle_[c][b] * mu[b];
      mu[c] /= triangle_[c][c];
    }
    for (int i = 0; i < size_; ++i) {
      S change = S(0);
      for (int c = 0; c < constraints; ++c)
        if (kept_[c]) change += mu[c] * direction_[c][i];
      if (inverse_metric_[i] != S(0)) add(y, i, inverse_metric_[i] * change);
    }
  }
  return {max_rounds, static_cast<double>(before), SolveEnd::capped};  // before the last correction
}

template <class S> bool ProjectedRungeKutta<S>::project_orbits(S* y) {
  SolverTallies& solvers = this->system_.solvers;
  if (model_.conservative().central()) {
    const SolveReport all = satisfy(y, kMaxInvariants);
    solvers.add(IterativeSolver::invariant_projection, all);
    if (all.ended != SolveEnd::capped) return true;
  }
  return solvers.add_unless_capped(IterativeSolver::invariant_projection, satisfy(y, 1));
}

// Reports the projection of a spin. Near a principal axis |I w|^2 is given by the energy, and is not solved for.
template <class S>
void ProjectedRungeKutta<S>::report_spin(const Spin& wanted, const Vec3<S>& momentum, const Vec3<S>& w, int rounds) {
  const S misfit = real::abs(wanted.twice_energy - dot(w, momentum)) / wanted.twice_energy;
  const SolveEnd ended = misfit <= S(4) * real::epsilon<S>()    ? SolveEnd::converged
                         : misfit <= S(64) * real::epsilon<S>() ? SolveEnd::stagnated
                                                                : SolveEnd::capped;
  this->system_.solvers.add(IterativeSolver::invariant_projection, {rounds, static_cast<double>(misfit), ended});
}

// The body rate with the free top's two invariants, w . I w and |I w|^2, nearest to it; then the attitude that has the
// momentum where it was, by the smallest turn. Near a principal axis the two gradients I w and I I w are parallel.
template <class S> void ProjectedRungeKutta<S>::project_spin(const Spin& wanted, int body, S* at) {
  const MassProperties<S>& mass = model_.mass(body);
  Vec3<S> w = load3(at + kAtBodyRate);
  const Vec3<S> w_classical = w;
  const S momentum2 = dot(wanted.momentum_W, wanted.momentum_W);
  if (momentum2 == S(0)) return;
  constexpr int iterations = 6;
  for (int n = 0; n < iterations; ++n) {
    const Vec3<S> a = mass.times_inertia(w), b = mass.times_inertia(a);
    const S energy = (wanted.twice_energy - dot(w, a)) / S(2);
    const S size = (dot(wanted.momentum_W, wanted.momentum_W) - dot(a, a)) / S(2);
    const S aa = dot(a, a), ab = dot(a, b), bb = dot(b, b), determinant = aa * bb - ab * ab;
    if (determinant > S(1e-6) * aa * bb)
      w += ((energy * bb - size * ab) / determinant) * a + ((size * aa - energy * ab) / determinant) * b;
    else w += (energy / aa) * a;
  }
  report_spin(wanted, mass.times_inertia(w), w, iterations);
  for (int i = 0; i < 3; ++i) {
    const S wide[] = {w.x, w.y, w.z}, was[] = {w_classical.x, w_classical.y, w_classical.z};
    add(at - model_.offset(body), model_.offset(body) + kAtBodyRate + i, wide[i] - was[i]);
  }
  const Quat<S> q = load4(at + kAtAttitude);
  const Vec3<S> now = rotate(q, mass.times_inertia(load3(at + kAtBodyRate))), then = wanted.momentum_W;
  const Vec3<S> axis = cross(now, then);
  const Quat<S> turn = normalised(Quat<S>{norm(now) * norm(then) + dot(now, then), axis.x, axis.y, axis.z});
  const Quat<S> turned = normalised(turn * q);
  const S is[] = {turned.w, turned.x, turned.y, turned.z}, was[] = {q.w, q.x, q.y, q.z};
  for (int i = 0; i < 4; ++i) add(at - model_.offset(body), model_.offset(body) + kAtAttitude + i, is[i] - was[i]);
}

template <class S> bool ProjectedRungeKutta<S>::step(S t_s, S h_s, const S* y, S* y_new) {
  if (!run_invariants_.continues(y)) take_invariants(y);
  classical_.evaluate(t_s, h_s, y, d_.data());
  find_metric(y);
  compensation_.begin(y);
  for (int i = 0; i < size_; ++i) y_new[i] = compensation_.add(i, y[i], d_[i]);
  if (!project_orbits(y_new)) return false;
  this->system_.project(y_new);
  for (const int body : model_.moving())
    if (model_.rotates(body)) project_spin(spin_[body], body, y_new + model_.offset(body));
  compensation_.end(y_new);
  run_invariants_.end(y_new);
  this->set_last_step(t_s, h_s, y, y_new);
  return true;
}

// ---- relaxation ---------------------------------------------------------------------------------------------------
template <class S>
RelaxationRungeKutta<S>::RelaxationRungeKutta(RigidModel<S>& model, bool compensated)
    : Stepper<S>(model.system()), model_(model), size_(model.state_size()), classical_(model.system()),
      run_invariants_(model), compensation_(compensated, size_), d_(size_), trial_(size_) {}

template <class S> S RelaxationRungeKutta<S>::energy_error(const S* y, S gamma) {
  for (int i = 0; i < size_; ++i) trial_[i] = y[i] + gamma * d_[i];
  return model_.energy(trial_.data()) - energy_;
}

// The root near 1 of misfit(gamma), which is nearly c gamma (gamma - root): two values give c, the slope at the root,
// and corrections by that slope go on while they halve the misfit. (Secants would divide round-off by round-off at the
// end.)
template <class S> bool RelaxationRungeKutta<S>::find_gamma(const S* y, S& gamma) {
  int n = 0;
  gamma = S(1);
  S left = energy_error(y, gamma);
  const S c = S(2) * (left - S(2) * energy_error(y, S(0.5)));
  for (; n < 40 && real::abs(left) > energy_round_off_; ++n) {
    const S next = gamma - left / c;
    if (!(real::abs(next - S(1)) < S(0.25))) break;  // over a tiny step the round-off of the energy has no root
    const S then = energy_error(y, next);
    if (!(real::abs(then) <= real::abs(left) / S(2))) break;
    gamma = next;
    left = then;
  }
  const S misfit_now = real::abs(left);
  const SolveEnd ended = misfit_now <= energy_round_off_           ? SolveEnd::converged
                         : misfit_now <= S(64) * energy_round_off_ ? SolveEnd::stagnated
                                                                   : SolveEnd::capped;
  const S relative = misfit_now == S(0) ? S(0) : misfit_now / energy_round_off_ * (real::epsilon<S>() / S(2));
  return this->system_.solvers.add_unless_capped(IterativeSolver::energy_relaxation,
                                                 {n + 1, static_cast<double>(relative), ended});
}

template <class S> bool RelaxationRungeKutta<S>::step(S t_s, S h_s, const S* y, S* y_new) {
  if (!run_invariants_.continues(y)) energy_ = model_.energy(y);
  energy_round_off_ = real::epsilon<S>() / S(2) * model_.energy_scale(y);
  compensation_.begin(y);
  std::copy(y, y + size_, y_new);
  S done_s = S(0);
  for (int part = 0; part < 2; ++part) {
    const S remaining_s = h_s - done_s;
    if (real::abs(remaining_s) <= real::epsilon<S>() / S(4) * real::abs(h_s)) break;
    classical_.evaluate(t_s + done_s, remaining_s, y_new, d_.data());
    // A second step of delta h changes the energy by delta^6 c at most. Where that is below round-off its factor gamma
    // would be a quotient of round-off errors, and the end time wrong by it.
    const S delta = remaining_s / h_s, delta2 = delta * delta;
    S gamma = S(1);
    const bool relaxes = part == 0 || delta2 * delta2 * delta2 > real::epsilon<S>();
    if (relaxes && !find_gamma(y_new, gamma)) return false;
    for (int i = 0; i < size_; ++i) y_new[i] = compensation_.add(i, y_new[i], gamma * d_[i]);
    done_s = part == 0 ? gamma * h_s : done_s + gamma * remaining_s;
  }
  if (compensation_.on()) project_compensated(this->system_, compensation_, y_new, d_.data());
  else this->system_.project(y_new);
  compensation_.end(y_new);
  run_invariants_.end(y_new);
  this->set_last_step(t_s, h_s, y, y_new);
  return true;
}

template class ProjectedRungeKutta<float>;
template class ProjectedRungeKutta<double>;
template class ProjectedRungeKutta<long double>;
template class ProjectedRungeKutta<Quad>;
template class RelaxationRungeKutta<float>;
template class RelaxationRungeKutta<double>;
template class RelaxationRungeKutta<long double>;
template class RelaxationRungeKutta<Quad>;

}  // namespace atwood
