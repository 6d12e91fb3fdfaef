#include "mechanism/reduced.hpp"

#include <algorithm>

#include "mechanism/reaction.hpp"

namespace atwood::mechanism {

template <class S> bool Reduced<S>::is_held(int dof) const {
  if (driven_[dof]) return true;
  return std::any_of(choice.locks.begin(), choice.locks.end(),
                     [&](const StepChoice::Lock& lock) { return joint_u_[lock.joint] == dof; });
}

// Rows and columns of rates that are prescribed become those of the identity.
template <class S> void Reduced<S>::hold(Envelope<S>& M) const {
  for (int k = 0; k < rates_; ++k) {
    if (!is_held(k)) continue;
    for (int j = M.first[k]; j < k; ++j) M(k, j) = S(0);
    for (int i = k + 1; i < rates_; ++i)
      if (M.first[i] <= k) M(i, k) = S(0);
    M(k, k) = 1;
  }
}

template <class S>
std::vector<Row<S>> Reduced<S>::other_rows(const S& t_s, const S* y, const std::vector<Motion<S>>& now,
                                           bool all) const {
  std::vector<Row<S>> rows;
  for (const int j : model_.closing) add_constraint_rows(model_, j, now, t_s, choice.memory, rows);
  for (std::size_t k = 0; k < model_.ropes.size(); ++k)
    add_rope_rows(model_, static_cast<int>(k), now, rope_q_[k] < 0 ? S(0) : y[rope_q_[k]], choice.memory, rows);
  if (all) return rows;
  std::vector<Row<S>> chosen;
  for (const int k : choice.chosen) chosen.push_back(rows[k]);
  return chosen;
}

namespace {
// With M = L L^T and W_r = L^-1 g_r: the multipliers for W W^T m = b, and the change L^-T W^T m.
template <class S> struct Multipliers {
  std::vector<std::vector<S>> W;
  Envelope<S> gram;
  void factor(const Envelope<S>& L, const std::vector<std::vector<S>>& G) {
    W = G;
    gram.reset(static_cast<int>(G.size()));
    for (std::size_t i = 0; i < G.size(); ++i) {
      solve_lower(L, W[i].data());
      gram.first[i] = 0;
      for (std::size_t j = 0; j <= i; ++j)
        for (std::size_t k = 0; k < W[i].size(); ++k) gram(i, j) += W[i][k] * W[j][k];
    }
    factorise(gram);
  }
  std::vector<S> solve(std::vector<S> b) const {
    solve_lower(gram, b.data());
    solve_upper(gram, b.data());
    return b;
  }
  void add(const Envelope<S>& L, const std::vector<S>& m, std::vector<S>& to) const {
    std::vector<S> sum(to.size(), S(0));
    for (std::size_t i = 0; i < W.size(); ++i)
      for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += m[i] * W[i][k];
    solve_upper(L, sum.data());
    for (std::size_t k = 0; k < sum.size(); ++k) to[k] += sum[k];
  }
};
}  // namespace

// With the branches of the tree's coordinates in y.
template <class S> StepChoice Reduced<S>::choice_at(const S* y) const {
  StepChoice made = choice;
  for (const int j : model_.tree)
    for (int k = 0; k < atwood::coordinate_count(model_.joints[j].kind); ++k)
      made.memory.joints[j][k] = static_cast<double>(y[joint_q_[j] + k]);
  return made;
}

// The forces of the scene, by way of the accelerations of free bodies.
template <class S>
std::vector<Acceleration<S>> Reduced<S>::free_accelerations(const S& t_s, const std::vector<Motion<S>>& now) const {
  std::vector<Acceleration<S>> made(model_.world + 1);
  const std::vector<S> all = full_state(now);
  std::vector<S> f(free_.size());
  free_.rate(t_s, all.data(), f.data(), choice.interval);
  for (int i = 0; i < model_.world; ++i) {
    const dynamics::Slot& slot = free_.layout().slots[i];
    if (slot.velocity < 0) continue;
    made[i].a = dynamics::read3(&f[slot.velocity]);
    if (slot.rate >= 0) made[i].alpha = rotate(now[i].q, dynamics::read3(&f[slot.rate]));
  }
  return made;
}

template <class S> typename Reduced<S>::Solved Reduced<S>::solve(const S& t_s, const S* y) const {
  Solved made;
  made.tree = kinematics(y);
  const std::vector<Motion<S>>& now = made.tree.now;
  const int n = model_.world;
  made.a_free = free_accelerations(t_s, now);
  const std::vector<Acceleration<S>> a0 = accelerations(made.tree, y, nullptr);
  std::vector<Wrench<S>> loads(n + 1);
  const StepChoice here = choice_at(y);
  for (std::size_t j = 0; j < model_.joints.size(); ++j)
    add_applied(model_, static_cast<int>(j), now, here, t_s, loads);
  for (int i = 0; i < n; ++i) {
    if (!model_.mobile[i]) continue;
    loads[i].force += model_.mass[i] * (made.a_free[i].a - a0[i].a);
    if (model_.turns[i]) loads[i].torque += turned(model_.inertia[i], now[i].q, made.a_free[i].alpha - a0[i].alpha);
  }
  std::vector<S> tau = pull_back(made.tree, std::move(loads));
  Envelope<S> L = mass_matrix(made.tree);
  hold(L);
  for (int k = 0; k < rates_; ++k)
    if (is_held(k)) tau[k] = 0;
  factorise(L);
  made.u_rate = tau;
  solve_lower(L, made.u_rate.data());
  solve_upper(L, made.u_rate.data());
  made.rows = other_rows(t_s, y, now, false);
  if (!made.rows.empty()) {
    std::vector<std::vector<S>> G;
    std::vector<S> b;
    for (const Row<S>& row : made.rows) {
      std::vector<S>& g = G.emplace_back(pull_back(made.tree, row));
      for (int k = 0; k < rates_; ++k)
        if (is_held(k)) g[k] = 0;
      S sum = acceleration_of(row, a0) + row.gamma;
      for (int k = 0; k < rates_; ++k) sum += g[k] * made.u_rate[k];
      b.push_back(-sum);
    }
    Multipliers<S> held;
    held.factor(L, G);
    made.multipliers = held.solve(std::move(b));
    held.add(L, made.multipliers, made.u_rate);
  }
  made.a = accelerations(made.tree, y, made.u_rate.data());
  return made;
}

template <class S> void Reduced<S>::coordinate_rates(const S* y, const S* u, S* dqdt) const {
  const auto turning_quaternion = [](const S* q, const S* w, S* rate) {
    const Quaternion<S> made = product<S>({q[0], q[1], q[2], q[3]}, {S(0), w[0], w[1], w[2]});
    for (int k = 0; k < 4; ++k) rate[k] = made[k] / 2;
  };
  for (int i = 0; i < model_.world; ++i) {
    if (body_q_[i] < 0) continue;
    std::copy_n(u + body_u_[i], 3, dqdt + body_q_[i]);
    if (model_.turns[i]) turning_quaternion(y + body_q_[i] + 3, u + body_u_[i] + 3, dqdt + body_q_[i] + 3);
  }
  for (const int j : model_.tree) {
    const JointKind kind = model_.joints[j].kind;
    if (kind == JointKind::ball) turning_quaternion(y + joint_q_[j], u + joint_u_[j], dqdt + joint_q_[j]);
    else std::copy_n(u + joint_u_[j], atwood::rate_count(kind), dqdt + joint_q_[j]);
  }
  for (std::size_t k = 0; k < rope_q_.size(); ++k)
    if (rope_q_[k] >= 0) dqdt[rope_q_[k]] = u[rope_u_[k]];
}

template <class S> void Reduced<S>::rate(const S& t_s, const S* y, S* dydt) const {
  const Solved now = solve(t_s, y);
  std::vector<S> u(y + coordinates_, y + size());
  for (int i = 0; i < model_.world; ++i)  // held until its release
    if (body_u_[i] >= 0 && model_.scene->bodies[i].release_s > choice.interval_s)
      std::fill_n(u.begin() + body_u_[i], dof_count_[i], S(0));
  coordinate_rates(y, u.data(), dydt);
  for (int k = 0; k < rates_; ++k) dydt[coordinates_ + k] = now.u_rate[k];
  for (int i = 0; i < model_.world; ++i)
    if (body_u_[i] >= 0 && model_.scene->bodies[i].release_s > choice.interval_s)
      std::fill_n(dydt + coordinates_ + body_u_[i], dof_count_[i], S(0));
}

template <class S> Independence Reduced<S>::choose(const S& t_s, const S* y) {
  const Tree tree = kinematics(y);
  choice = choice_at(y);
  remember(model_, tree.now, choice.memory);
  choice.chosen.clear();
  const std::vector<Row<S>> rows = other_rows(t_s, y, tree.now, true);
  if (rows.empty()) return {};
  Envelope<S> L = mass_matrix(tree);
  hold(L);
  factorise(L);
  const std::size_t n = rows.size();
  std::vector<std::vector<S>> W, A(n, std::vector<S>(n));
  std::vector<S> diagonal(n);
  for (const Row<S>& row : rows) {
    std::vector<S>& g = W.emplace_back(pull_back(tree, row));
    S size{};
    for (int k = 0; k < rates_; ++k) {
      if (is_held(k)) g[k] = 0;
    }
    solve_lower(L, g.data());
    for (const S& x : g) size += x * x;
    diagonal[W.size() - 1] = size;
  }
  // Rows that the tree cannot move at all have a diagonal of round-off: they are measured against the largest.
  const S largest = *std::max_element(diagonal.begin(), diagonal.end());
  for (S& d : diagonal) d = std::max(d, S(1e-12) * largest);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j <= i; ++j) {
      S sum{};
      for (int k = 0; k < rates_; ++k) sum += W[i][k] * W[j][k];
      A[i][j] = A[j][i] = sum;
    }
  const Independent<S> found = independent_rows(std::move(A), diagonal, S(1e-24));
  choice.chosen = found.rows;
  std::sort(choice.chosen.begin(), choice.chosen.end());
  return {static_cast<double>(found.smallest), static_cast<double>(found.largest_dropped),
          static_cast<int>(found.rows.size())};
}

template <class S> S Reduced<S>::project(const S& t_s, S* y) const {
  const auto normalise = [&](int at) {
    const Quaternion<S> q = normalised<S>({y[at], y[at + 1], y[at + 2], y[at + 3]});
    std::copy(q.begin(), q.end(), y + at);
  };
  for (int i = 0; i < model_.world; ++i)
    if (body_q_[i] >= 0 && model_.turns[i]) normalise(body_q_[i] + 3);
  for (const int j : model_.tree) {
    const JointModel<S>& joint = model_.joints[j];
    if (joint.kind == JointKind::ball) normalise(joint_q_[j]);
    if (joint.driven) y[joint_q_[j]] = joint.start + joint.rate * t_s;
  }
  for (const StepChoice::Lock& lock : choice.locks) {
    y[joint_q_[lock.joint]] = lock.coordinate;
    y[coordinates_ + joint_u_[lock.joint]] = 0;
  }
  if (choice.chosen.empty()) return S(0);
  const auto correct = [&](bool velocities) {
    const Tree tree = kinematics(y);
    Envelope<S> L = mass_matrix(tree);
    hold(L);
    factorise(L);
    std::vector<std::vector<S>> G;
    std::vector<S> b, change(rates_, S(0));
    S largest{};
    for (const Row<S>& row : other_rows(t_s, y, tree.now, false)) {
      std::vector<S>& g = G.emplace_back(pull_back(tree, row));
      for (int k = 0; k < rates_; ++k)
        if (is_held(k)) g[k] = 0;
      const S rope = row.rope >= 0 ? row.cp * y[coordinates_ + rope_u_[row.rope]] : S(0);
      b.push_back(velocities ? row.bias - velocity_of(row, tree.now) - rope : -row.residual);
      largest = std::max(largest, dynamics::magnitude(b.back()));
    }
    Multipliers<S> held;
    held.factor(L, G);
    held.add(L, held.solve(std::move(b)), change);
    if (velocities) {
      for (int k = 0; k < rates_; ++k) y[coordinates_ + k] += change[k];
    } else {
      displace(y, change);
    }
    return largest;
  };
  S last{};
  for (int k = 0; k < 8; ++k) {
    const S found = correct(false);
    if (!(found > 0) || (k > 0 && !(found < S(0.1) * last))) break;
    last = found;
  }
  correct(true);
  correct(true);
  S largest{};
  for (const Row<S>& row : other_rows(t_s, y, motions(y), true))
    largest = std::max(largest, dynamics::magnitude(row.residual));
  return largest;
}

// Moves the coordinates along a small change of the rates times 1 s.
template <class S> void Reduced<S>::displace(S* y, const std::vector<S>& change) const {
  const auto turn = [&](int at, const S* by) {
    const Quaternion<S> q =
        normalised(product<S>({y[at], y[at + 1], y[at + 2], y[at + 3]}, turn_by<S>({by[0], by[1], by[2]})));
    std::copy(q.begin(), q.end(), y + at);
  };
  for (int i = 0; i < model_.world; ++i) {
    if (body_q_[i] < 0) continue;
    for (int k = 0; k < 3; ++k) y[body_q_[i] + k] += change[body_u_[i] + k];
    if (model_.turns[i]) turn(body_q_[i] + 3, &change[body_u_[i] + 3]);
  }
  for (const int j : model_.tree) {
    if (model_.joints[j].kind == JointKind::ball) turn(joint_q_[j], &change[joint_u_[j]]);
    else
      for (int k = 0; k < atwood::rate_count(model_.joints[j].kind); ++k) y[joint_q_[j] + k] += change[joint_u_[j] + k];
  }
  for (std::size_t k = 0; k < rope_q_.size(); ++k)
    if (rope_q_[k] >= 0) y[rope_q_[k]] += change[rope_u_[k]];
}

// Reactions of the tree: what the bodies beyond a joint need for their accelerations, less what the scene's forces,
// closing joints, ropes, springs and motors give them.
template <class S> Sample Reduced<S>::sample(const S& t_s, const S* y) const {
  const Solved now = solve(t_s, y);
  const std::vector<Motion<S>>& at = now.tree.now;
  Sample made = dynamics::unpack<S>(*model_.scene, t_s, full_state(at).data());
  const StepChoice here = choice_at(y);
  fill_joints(model_, at, here, t_s, made);
  std::vector<Wrench<S>> known(model_.world + 1), on_child(model_.joints.size());
  for (std::size_t i = 0; i < now.rows.size(); ++i) {
    const Row<S>& row = now.rows[i];
    add_load(row, now.multipliers[i], known);
    if (row.tension_of >= 0) made.ropes[row.tension_of].tension_N = -now.multipliers[i];
    if (row.joint < 0) continue;
    on_child[row.joint].force += now.multipliers[i] * row.lb;
    on_child[row.joint].torque += now.multipliers[i] * row.ab;
  }
  for (std::size_t j = 0; j < model_.joints.size(); ++j) add_applied(model_, static_cast<int>(j), at, here, t_s, known);
  for (const StepChoice::Lock& lock : choice.locks) {
    const S along = stop_force(t_s, y, lock.joint);
    made.joints[lock.joint].stop[0] = along;
    add_load(rate_rows(model_, lock.joint, at)[0], along, known);
  }
  std::vector<Wrench<S>> needed = inertial_loads(now);
  for (auto j = model_.tree.rbegin(); j != model_.tree.rend(); ++j) {
    const int c = model_.joints[*j].child, p = model_.joints[*j].parent;
    Wrench<S>& load = on_child[*j];
    load.force = needed[c].force - known[c].force;
    load.torque = needed[c].torque - known[c].torque;
    known[p].force -= load.force;
    known[p].torque -= load.torque + cross(at[c].p - at[p].p, load.force);
  }
  for (std::size_t j = 0; j < model_.joints.size(); ++j)
    set_reaction(model_, static_cast<int>(j), at, on_child[j], made.joints[j]);
  for (std::size_t k = 0; k < model_.ropes.size(); ++k)
    fill_pulleys(model_, static_cast<int>(k), at, choice.memory, made.ropes[k]);
  return made;
}

// M (a - a_free) of every body: the sum of the loads of constraints, springs and motors.
template <class S> std::vector<Wrench<S>> Reduced<S>::inertial_loads(const Solved& now) const {
  std::vector<Wrench<S>> made(model_.world + 1);
  for (int i = 0; i < model_.world; ++i) {
    if (!model_.mobile[i]) continue;
    made[i].force = model_.mass[i] * (now.a[i].a - now.a_free[i].a);
    if (model_.turns[i])
      made[i].torque = turned(model_.inertia[i], now.tree.now[i].q, now.a[i].alpha - now.a_free[i].alpha);
  }
  return made;
}

template <class S> std::vector<S> Reduced<S>::full_state(const std::vector<Motion<S>>& now) const {
  std::vector<S> all(free_.size());
  for (int i = 0; i < model_.world; ++i) {
    const dynamics::Slot& slot = free_.layout().slots[i];
    if (slot.position < 0) continue;
    std::copy_n(now[i].p.begin(), 3, all.begin() + slot.position);
    std::copy_n(now[i].v.begin(), 3, all.begin() + slot.velocity);
    if (slot.attitude < 0) continue;
    std::copy_n(now[i].q.begin(), 4, all.begin() + slot.attitude);
    const Triple<S> w_B = rotate_back(now[i].q, now[i].w);
    std::copy_n(w_B.begin(), 3, all.begin() + slot.rate);
  }
  return all;
}

template <class S> S Reduced<S>::stop_force(const S& t_s, const S* y, int joint) const {
  const Solved now = solve(t_s, y);
  std::vector<Wrench<S>> known(model_.world + 1), needed = inertial_loads(now);
  const StepChoice here = choice_at(y);
  for (std::size_t i = 0; i < now.rows.size(); ++i) add_load(now.rows[i], now.multipliers[i], known);
  for (std::size_t j = 0; j < model_.joints.size(); ++j)
    add_applied(model_, static_cast<int>(j), now.tree.now, here, t_s, known);
  for (int i = 0; i < model_.world; ++i) {
    needed[i].force -= known[i].force;
    needed[i].torque -= known[i].torque;
  }
  return pull_back(now.tree, std::move(needed))[joint_u_[joint]];
}

template <class S> S Reduced<S>::acceleration(const S& t_s, const S* y, int joint) const {
  return solve(t_s, y).u_rate[joint_u_[joint]];
}

// The change of the rates by a unit impulse along a joint's coordinate.
template <class S> std::vector<S> Reduced<S>::kick(const S& t_s, const S* y, int joint) const {
  const Tree tree = kinematics(y);
  Envelope<S> L = mass_matrix(tree);
  hold(L);
  factorise(L);
  std::vector<S> change(rates_, S(0));
  change[joint_u_[joint]] = 1;
  solve_lower(L, change.data());
  solve_upper(L, change.data());
  std::vector<std::vector<S>> G;
  std::vector<S> b;
  for (const Row<S>& row : other_rows(t_s, y, tree.now, false)) {
    std::vector<S>& g = G.emplace_back(pull_back(tree, row));
    S sum{};
    for (int k = 0; k < rates_; ++k) {
      if (is_held(k)) g[k] = 0;
      sum += g[k] * change[k];
    }
    b.push_back(-sum);
  }
  Multipliers<S> held;
  held.factor(L, G);
  held.add(L, held.solve(std::move(b)), change);
  return change;
}

template <class S> S Reduced<S>::response(const S& t_s, const S* y, int joint, int other) const {
  return kick(t_s, y, joint)[joint_u_[other]];
}

template <class S> S Reduced<S>::impact(const S& t_s, S* y, int joint, const S& restitution) const {
  const std::vector<S> change = kick(t_s, y, joint);
  const S impulse = -(1 + restitution) * y[rate_slot(joint)] / change[joint_u_[joint]];
  for (int k = 0; k < rates_; ++k) y[coordinates_ + k] += impulse * change[k];
  return impulse;
}

template <class S> std::vector<std::vector<S>> Reduced<S>::chosen_jacobian(const S& t_s, const S* y) const {
  const Tree tree = kinematics(y);
  std::vector<std::vector<S>> G;
  for (const Row<S>& row : other_rows(t_s, y, tree.now, false)) {
    std::vector<S>& g = G.emplace_back(pull_back(tree, row));
    for (int k = 0; k < rates_; ++k)
      if (is_held(k)) g[k] = 0;
  }
  return G;
}

// Gaussian elimination with complete pivoting.
template <class S> std::vector<int> Reduced<S>::pivot_columns(const S& t_s, const S* y) const {
  std::vector<std::vector<S>> G = chosen_jacobian(t_s, y);
  std::vector<int> columns;
  for (std::size_t k = 0; k < G.size(); ++k) {
    std::size_t best = k;
    int column = 0;
    S largest{};
    for (std::size_t i = k; i < G.size(); ++i)
      for (int j = 0; j < rates_; ++j)
        if (dynamics::magnitude(G[i][j]) > largest) {
          largest = dynamics::magnitude(G[i][j]);
          best = i;
          column = j;
        }
    std::swap(G[k], G[best]);
    columns.push_back(column);
    for (std::size_t i = k + 1; i < G.size(); ++i) {
      const S factor = G[i][column] / G[k][column];
      for (int j = 0; j < rates_; ++j) G[i][j] -= factor * G[k][j];
      G[i][column] = 0;
    }
  }
  return columns;
}

template <class S> int Reduced<S>::orientation(const S& t_s, const S* y, const std::vector<int>& columns) const {
  std::vector<std::vector<S>> G = chosen_jacobian(t_s, y);
  int sign = 1;
  for (std::size_t k = 0; k < G.size(); ++k) {
    std::size_t best = k;
    for (std::size_t i = k; i < G.size(); ++i)
      if (dynamics::magnitude(G[i][columns[k]]) > dynamics::magnitude(G[best][columns[k]])) best = i;
    if (best != k) sign = -sign;
    std::swap(G[k], G[best]);
    const S pivot = G[k][columns[k]];
    if (pivot == 0) return 0;
    if (pivot < 0) sign = -sign;
    for (std::size_t i = k + 1; i < G.size(); ++i) {
      const S factor = G[i][columns[k]] / pivot;
      for (int j = 0; j < rates_; ++j) G[i][j] -= factor * G[k][j];
    }
  }
  return sign;
}

template <class S>
void Reduced<S>::constrained(const S& t_s, const S* y, std::vector<S>& residual, std::vector<S>& rate_residual,
                             std::vector<std::vector<S>>& G) const {
  const Tree tree = kinematics(y);
  residual.clear();
  rate_residual.clear();
  for (const Row<S>& row : other_rows(t_s, y, tree.now, false)) {
    const S rope = row.rope >= 0 ? row.cp * y[coordinates_ + rope_u_[row.rope]] : S(0);
    residual.push_back(row.residual);
    rate_residual.push_back(velocity_of(row, tree.now) + rope - row.bias);
  }
  G = chosen_jacobian(t_s, y);
}

template <class S>
std::vector<S> Reduced<S>::imbalance(const S& t_s, const S* y, const S* rates_rate, const S* multipliers) const {
  Solved now;
  now.tree = kinematics(y);
  now.a_free = free_accelerations(t_s, now.tree.now);
  now.a = accelerations(now.tree, y, rates_rate);
  std::vector<Wrench<S>> loads = inertial_loads(now), known(model_.world + 1);
  const StepChoice here = choice_at(y);
  for (std::size_t j = 0; j < model_.joints.size(); ++j)
    add_applied(model_, static_cast<int>(j), now.tree.now, here, t_s, known);
  for (int i = 0; i <= model_.world; ++i) {
    loads[i].force -= known[i].force;
    loads[i].torque -= known[i].torque;
  }
  std::vector<S> made = pull_back(now.tree, std::move(loads));
  for (std::size_t k = 0; k < rope_u_.size(); ++k)
    if (rope_u_[k] >= 0) made[rope_u_[k]] = model_.ropes[k].inertia * rates_rate[rope_u_[k]];
  const std::vector<std::vector<S>> G = chosen_jacobian(t_s, y);
  for (std::size_t i = 0; i < G.size(); ++i)
    for (int k = 0; k < rates_; ++k) made[k] -= multipliers[i] * G[i][k];
  for (int k = 0; k < rates_; ++k)
    if (is_held(k)) made[k] = rates_rate[k];
  return made;
}

#define ATWOOD_REDUCED(S)                                                                      \
  template void Reduced<S>::constrained(const S&, const S*, std::vector<S>&, std::vector<S>&,  \
                                        std::vector<std::vector<S>>&) const;                   \
  template std::vector<S> Reduced<S>::imbalance(const S&, const S*, const S*, const S*) const; \
  template typename Reduced<S>::Solved Reduced<S>::solve(const S&, const S*) const;            \
  template void Reduced<S>::coordinate_rates(const S*, const S*, S*) const;                    \
  template StepChoice Reduced<S>::choice_at(const S*) const;                                   \
  template Independence Reduced<S>::choose(const S&, const S*);                                \
  template void Reduced<S>::rate(const S&, const S*, S*) const;                                \
  template S Reduced<S>::project(const S&, S*) const;                                          \
  template Sample Reduced<S>::sample(const S&, const S*) const;                                \
  template S Reduced<S>::stop_force(const S&, const S*, int) const;                            \
  template S Reduced<S>::acceleration(const S&, const S*, int) const;                          \
  template S Reduced<S>::impact(const S&, S*, int, const S&) const;                            \
  template S Reduced<S>::response(const S&, const S*, int, int) const;                         \
  template std::vector<int> Reduced<S>::pivot_columns(const S&, const S*) const;               \
  template int Reduced<S>::orientation(const S&, const S*, const std::vector<int>&) const;
ATWOOD_REDUCED(double)
ATWOOD_REDUCED(long double)
ATWOOD_REDUCED(__float128)
#undef ATWOOD_REDUCED

}  // namespace atwood::mechanism
