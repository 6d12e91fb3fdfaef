#include "mechanism/maximal.hpp"

#include <algorithm>

#include "mechanism/reaction.hpp"

namespace atwood::mechanism {

namespace {

template <class S> struct Moved {  // M^-1 times a row
  Triple<S> la{}, aa{}, lb{}, ab{};
  S cp{};
};

template <class S> Moved<S> moved(const Model<S>& model, const std::vector<Motion<S>>& now, const Row<S>& row) {
  Moved<S> made;
  if (model.mobile[row.a]) made.la = (1 / model.mass[row.a]) * row.la;
  if (model.mobile[row.b]) made.lb = (1 / model.mass[row.b]) * row.lb;
  if (model.turns[row.a]) made.aa = turned(model.inverse_inertia[row.a], now[row.a].q, row.aa);
  if (model.turns[row.b]) made.ab = turned(model.inverse_inertia[row.b], now[row.b].q, row.ab);
  if (row.rope >= 0) made.cp = row.cp / model.ropes[row.rope].inertia;
  return made;
}

template <class S> S product_of(const Row<S>& row, const Row<S>& other, const Moved<S>& m) {
  S sum{};
  if (row.a == other.a) sum += dot(row.la, m.la) + dot(row.aa, m.aa);
  if (row.a == other.b) sum += dot(row.la, m.lb) + dot(row.aa, m.ab);
  if (row.b == other.a) sum += dot(row.lb, m.la) + dot(row.ab, m.aa);
  if (row.b == other.b) sum += dot(row.lb, m.lb) + dot(row.ab, m.ab);
  if (row.rope >= 0 && row.rope == other.rope) sum += row.cp * m.cp;
  return sum;
}

}  // namespace

// Rows of the tree, then the others; their Gram matrix in the inverse mass.
template <class S> struct Maximal<S>::System {
  std::vector<Row<S>> rows;
  std::vector<Moved<S>> moved_rows;
  int tree = 0;
  Envelope<S> factor;             // of the tree's block: A_tt = L L^T
  std::vector<std::vector<S>> W;  // of each other row: L^-1 A_t,other
  Envelope<S> others;             // Cholesky factor of A_oo - W^T W

  S gram(int i, int j) const { return product_of(rows[i], rows[j], moved_rows[j]); }
  S schur(int i, int j) const {  // indices among the others
    S sum = gram(tree + i, tree + j);
    for (int k = 0; k < tree; ++k) sum -= W[i][k] * W[j][k];
    return sum;
  }
  void factor_tree(const Model<S>& model) {
    factor.reset(tree);
    std::vector<int> first_of_body(model.world + 1, tree);
    for (int i = tree - 1; i >= 0; --i)
      for (const int body : {rows[i].a, rows[i].b})
        if (model.mobile[body]) first_of_body[body] = i;
    for (int i = 0; i < tree; ++i) {
      for (const int body : {rows[i].a, rows[i].b})
        if (model.mobile[body]) factor.first[i] = std::min(factor.first[i], first_of_body[body]);
      for (int j = factor.first[i]; j <= i; ++j) factor(i, j) = gram(i, j);
    }
    factorise(factor);
    const int n = static_cast<int>(rows.size()) - tree;
    W.assign(n, std::vector<S>(tree));
    for (int i = 0; i < n; ++i) {
      for (int k = 0; k < tree; ++k) W[i][k] = gram(k, tree + i);
      solve_lower(factor, W[i].data());
    }
  }
  void factor_others() {
    const int n = static_cast<int>(W.size());
    others.reset(n);
    for (int i = 0; i < n; ++i) {
      others.first[i] = 0;
      for (int j = 0; j <= i; ++j) others(i, j) = schur(i, j);
    }
    factorise(others);
  }
  std::vector<S> solve(std::vector<S> b) const {
    const int n = static_cast<int>(W.size());
    solve_lower(factor, b.data());
    for (int i = 0; i < n; ++i)
      for (int k = 0; k < tree; ++k) b[tree + i] -= W[i][k] * b[k];
    solve_lower(others, b.data() + tree);
    solve_upper(others, b.data() + tree);
    for (int i = 0; i < n; ++i)
      for (int k = 0; k < tree; ++k) b[k] -= W[i][k] * b[tree + i];
    solve_upper(factor, b.data());
    return b;
  }
  // by += M^-1 G^T m
  void add(const std::vector<S>& m, std::vector<Acceleration<S>>& by, std::vector<S>& rope_by) const {
    for (std::size_t i = 0; i < rows.size(); ++i) {
      by[rows[i].a].a += m[i] * moved_rows[i].la;
      by[rows[i].a].alpha += m[i] * moved_rows[i].aa;
      by[rows[i].b].a += m[i] * moved_rows[i].lb;
      by[rows[i].b].alpha += m[i] * moved_rows[i].ab;
      if (rows[i].rope >= 0) rope_by[rows[i].rope] += m[i] * moved_rows[i].cp;
    }
  }
};

template <class S> struct Maximal<S>::Solved {
  System system;
  std::vector<Motion<S>> now;
  std::vector<Acceleration<S>> a;
  std::vector<S> rope_a, multipliers;
};

template <class S>
Maximal<S>::Maximal(const Scene& scene, double t_end_s, const Sample& start)
    : model_(make_model<S>(scene)), free_(scene, t_end_s) {
  size_ = free_.size();
  for (const RopeModel<S>& rope : model_.ropes) {
    rope_slot_.push_back(rope.inertia > 0 ? size_ : -1);
    if (rope.inertia > 0) size_ += 2;
  }
  choice.memory = begin_at(model_, start);
  std::vector<S> y = dynamics::pack<S>(scene, start);
  y.resize(size_, S(0));
  begin_ropes(model_, motions(y.data()), choice.memory);
}

template <class S> std::vector<S> Maximal<S>::initial(const Sample& start) const {
  std::vector<S> y = dynamics::pack<S>(*model_.scene, start);
  y.resize(size_, S(0));
  const std::vector<Motion<S>> now = motions(y.data());
  for (std::size_t k = 0; k < model_.ropes.size(); ++k) {
    if (rope_slot_[k] < 0) continue;
    std::vector<Row<S>> rows;
    add_rope_rows(model_, static_cast<int>(k), now, S(0), choice.memory, rows);
    y[rope_slot_[k] + 1] = -velocity_of(rows[0], now);
  }
  return y;
}

template <class S> std::vector<Motion<S>> Maximal<S>::motions(const S* y) const {
  std::vector<Motion<S>> made(model_.world + 1);
  const dynamics::Layout& layout = free_.layout();
  for (int i = 0; i < model_.world; ++i) {
    Motion<S>& body = made[i];
    const Body& given = model_.scene->bodies[i];
    const dynamics::Slot& slot = layout.slots[i];
    body.p = slot.position >= 0 ? dynamics::read3(y + slot.position) : dynamics::widen<S>(given.position_m);
    if (slot.velocity >= 0) body.v = dynamics::read3(y + slot.velocity);
    if (slot.attitude >= 0) {
      std::copy_n(y + slot.attitude, 4, body.q.begin());
      body.w = rotate(body.q, dynamics::read3(y + slot.rate));
    } else {
      for (int k = 0; k < 4; ++k) body.q[k] = S(given.orientation_wxyz[k]);
      body.q = normalised(body.q);
    }
  }
  return made;
}

template <class S> std::vector<Row<S>> Maximal<S>::rows_of_tree(const S& t_s, const std::vector<Motion<S>>& now) const {
  std::vector<Row<S>> rows;
  for (auto j = model_.tree.rbegin(); j != model_.tree.rend(); ++j)
    add_constraint_rows(model_, *j, now, t_s, choice.memory, rows);
  return rows;
}

template <class S>
Row<S> Maximal<S>::locked_row(const typename StepChoice::Lock& lock, const std::vector<Motion<S>>& now) const {
  Row<S> row = rate_rows(model_, lock.joint, now)[0];
  row.residual = coordinates(model_, lock.joint, now, choice.memory)[0] - S(lock.coordinate);
  return row;
}

template <class S>
std::vector<Row<S>> Maximal<S>::other_rows(const S& t_s, const S* y, const std::vector<Motion<S>>& now) const {
  std::vector<Row<S>> rows;
  for (const int j : model_.closing) add_constraint_rows(model_, j, now, t_s, choice.memory, rows);
  for (std::size_t k = 0; k < model_.ropes.size(); ++k)
    add_rope_rows(model_, static_cast<int>(k), now, rope_slot_[k] < 0 ? S(0) : y[rope_slot_[k]], choice.memory, rows);
  for (const auto& lock : choice.locks) rows.push_back(locked_row(lock, now));
  return rows;
}

template <class S>
typename Maximal<S>::System Maximal<S>::make_system(const S& t_s, const S* y, const std::vector<Motion<S>>& now,
                                                    bool all) const {
  System made;
  made.rows = rows_of_tree(t_s, now);
  made.tree = static_cast<int>(made.rows.size());
  const std::vector<Row<S>> others = other_rows(t_s, y, now);
  if (all) made.rows.insert(made.rows.end(), others.begin(), others.end());
  else
    for (const int k : choice.chosen) made.rows.push_back(others[k]);
  for (const Row<S>& row : made.rows) made.moved_rows.push_back(moved(model_, now, row));
  made.factor_tree(model_);
  return made;
}

template <class S> Independence Maximal<S>::choose(const S& t_s, const S* y) {
  const std::vector<Motion<S>> now = motions(y);
  remember(model_, now, choice.memory);
  const System system = make_system(t_s, y, now, true);
  const int n = static_cast<int>(system.W.size());
  std::vector<std::vector<S>> A(n, std::vector<S>(n));
  std::vector<S> diagonal(n);
  for (int i = 0; i < n; ++i) {
    diagonal[i] = system.gram(system.tree + i, system.tree + i);
    for (int j = 0; j <= i; ++j) A[i][j] = A[j][i] = system.schur(i, j);
  }
  const Independent<S> found = independent_rows(std::move(A), diagonal, S(1e-24));
  choice.chosen = found.rows;
  std::sort(choice.chosen.begin(), choice.chosen.end());
  return {static_cast<double>(found.smallest), static_cast<double>(found.largest_dropped),
          static_cast<int>(found.rows.size())};
}

template <class S> typename Maximal<S>::Solved Maximal<S>::solve(const S& t_s, const S* y) const {
  Solved made;
  made.now = motions(y);
  made.a.resize(model_.world + 1);
  made.rope_a.assign(model_.ropes.size(), S(0));
  std::vector<S> f(free_.size());
  free_.rate(t_s, y, f.data(), choice.interval);
  std::vector<Wrench<S>> loads(model_.world + 1);
  for (std::size_t j = 0; j < model_.joints.size(); ++j)
    add_applied(model_, static_cast<int>(j), made.now, choice, t_s, loads);
  for (int i = 0; i < model_.world; ++i) {
    const dynamics::Slot& slot = free_.layout().slots[i];
    if (slot.velocity < 0) continue;
    made.a[i].a = dynamics::read3(&f[slot.velocity]) + (1 / model_.mass[i]) * loads[i].force;
    if (slot.rate < 0) continue;
    made.a[i].alpha = rotate(made.now[i].q, dynamics::read3(&f[slot.rate])) +
                      turned(model_.inverse_inertia[i], made.now[i].q, loads[i].torque);
  }
  made.system = make_system(t_s, y, made.now, false);
  made.system.factor_others();
  std::vector<S> b;
  for (const Row<S>& row : made.system.rows) b.push_back(-(acceleration_of(row, made.a) + row.gamma));
  made.multipliers = made.system.solve(std::move(b));
  made.system.add(made.multipliers, made.a, made.rope_a);
  return made;
}

template <class S> void Maximal<S>::rate(const S& t_s, const S* y, S* dydt) const {
  const Solved now = solve(t_s, y);
  free_.rate(t_s, y, dydt, choice.interval);
  for (int i = 0; i < model_.world; ++i) {
    const dynamics::Slot& slot = free_.layout().slots[i];
    if (slot.velocity < 0 || model_.scene->bodies[i].release_s > choice.interval_s) continue;
    std::copy_n(now.a[i].a.begin(), 3, dydt + slot.velocity);
    if (slot.rate < 0) continue;
    const Triple<S> alpha_B = rotate_back(now.now[i].q, now.a[i].alpha);
    std::copy_n(alpha_B.begin(), 3, dydt + slot.rate);
  }
  for (std::size_t k = 0; k < rope_slot_.size(); ++k)
    if (rope_slot_[k] >= 0) {
      dydt[rope_slot_[k]] = y[rope_slot_[k] + 1];
      dydt[rope_slot_[k] + 1] = now.rope_a[k];
    }
}

// Adds small displacements (velocities = false) or velocity changes.
template <class S>
void Maximal<S>::move(S* y, const std::vector<Acceleration<S>>& by, const std::vector<S>& rope_by,
                      bool velocities) const {
  for (int i = 0; i < model_.world; ++i) {
    const dynamics::Slot& slot = free_.layout().slots[i];
    if (slot.position < 0) continue;
    for (int k = 0; k < 3; ++k) y[(velocities ? slot.velocity : slot.position) + k] += by[i].a[k];
    if (slot.attitude < 0) continue;
    Quaternion<S> q;
    std::copy_n(y + slot.attitude, 4, q.begin());
    if (velocities) {
      const Triple<S> change = rotate_back(q, by[i].alpha);
      for (int k = 0; k < 3; ++k) y[slot.rate + k] += change[k];
    } else {
      q = normalised(product(turn_by(by[i].alpha), q));
      std::copy_n(q.begin(), 4, y + slot.attitude);
    }
  }
  for (std::size_t k = 0; k < rope_slot_.size(); ++k)
    if (rope_slot_[k] >= 0) y[rope_slot_[k] + (velocities ? 1 : 0)] += rope_by[k];
}

template <class S> S Maximal<S>::project(const S& t_s, S* y) const {
  for (const dynamics::Slot& slot : free_.layout().slots)
    if (slot.attitude >= 0) {
      Quaternion<S> q;
      std::copy_n(y + slot.attitude, 4, q.begin());
      q = normalised(q);
      std::copy_n(q.begin(), 4, y + slot.attitude);
    }
  const auto correct = [&](bool velocities) {
    const std::vector<Motion<S>> now = motions(y);
    System system = make_system(t_s, y, now, false);
    system.factor_others();
    std::vector<S> b;
    S largest{};
    for (const Row<S>& row : system.rows) {
      const S rope = row.rope >= 0 ? row.cp * y[rope_slot_[row.rope] + 1] : S(0);
      b.push_back(velocities ? row.bias - velocity_of(row, now) - rope : -row.residual);
      largest = std::max(largest, dynamics::magnitude(b.back()));
    }
    std::vector<Acceleration<S>> by(model_.world + 1);
    std::vector<S> rope_by(model_.ropes.size(), S(0));
    system.add(system.solve(std::move(b)), by, rope_by);
    move(y, by, rope_by, velocities);
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
  const std::vector<Motion<S>> now = motions(y);
  S largest{};
  for (const Row<S>& row : rows_of_tree(t_s, now)) largest = std::max(largest, dynamics::magnitude(row.residual));
  for (const Row<S>& row : other_rows(t_s, y, now)) largest = std::max(largest, dynamics::magnitude(row.residual));
  return largest;
}

// Which components of the reactions the constraints leave open: those that a null vector of G^T changes. For each row
// that was not chosen there is one, with its own multiplier 1.
template <class S>
void Maximal<S>::mark_not_unique(const S& t_s, const S* y, const std::vector<Motion<S>>& now, Sample& sample) const {
  const System all = make_system(t_s, y, now, true);
  const int n = static_cast<int>(all.W.size());
  if (static_cast<int>(choice.chosen.size()) == n) return;
  System chosen = make_system(t_s, y, now, false);
  chosen.factor_others();
  for (int r = 0; r < n; ++r) {
    if (std::find(choice.chosen.begin(), choice.chosen.end(), r) != choice.chosen.end()) continue;
    std::vector<S> b(chosen.rows.size());
    for (std::size_t i = 0; i < b.size(); ++i)
      b[i] = -product_of(chosen.rows[i], all.rows[all.tree + r], all.moved_rows[all.tree + r]);
    std::vector<S> null = chosen.solve(std::move(b));
    std::vector<Row<S>> rows = chosen.rows;
    rows.push_back(all.rows[all.tree + r]);
    null.push_back(S(1));
    mark_open_components(model_, now, rows, null, sample.joints);
  }
}

template <class S> Sample Maximal<S>::sample(const S& t_s, const S* y) const {
  const Solved now = solve(t_s, y);
  Sample made = dynamics::unpack<S>(*model_.scene, t_s, y);
  fill_joints(model_, now.now, choice, t_s, made);
  std::vector<Wrench<S>> on_child(model_.joints.size());
  for (std::size_t i = 0; i < now.system.rows.size(); ++i) {
    const Row<S>& row = now.system.rows[i];
    if (row.tension_of >= 0) made.ropes[row.tension_of].tension_N = -now.multipliers[i];
    if (row.joint < 0) continue;
    on_child[row.joint].force += now.multipliers[i] * row.lb;
    on_child[row.joint].torque += now.multipliers[i] * row.ab;
  }
  for (std::size_t j = 0; j < model_.joints.size(); ++j)
    set_reaction(model_, static_cast<int>(j), now.now, on_child[j], made.joints[j]);
  for (std::size_t k = 0; k < model_.ropes.size(); ++k)
    fill_pulleys(model_, static_cast<int>(k), now.now, choice.memory, made.ropes[k]);
  for (const StepChoice::Lock& lock : choice.locks) made.joints[lock.joint].stop[0] = stop_force(t_s, y, lock.joint);
  mark_not_unique(t_s, y, now.now, made);
  return made;
}

template <class S> S Maximal<S>::stop_force(const S& t_s, const S* y, int joint) const {
  const Solved now = solve(t_s, y);
  // Locks are the last of the other rows.
  const int n = static_cast<int>(other_rows(t_s, y, now.now).size()), locks = static_cast<int>(choice.locks.size());
  for (int k = 0; k < locks; ++k)
    if (choice.locks[k].joint == joint)
      for (std::size_t i = 0; i < choice.chosen.size(); ++i)
        if (choice.chosen[i] == n - locks + k) return now.multipliers[now.system.tree + i];
  return S(0);
}

template <class S> S Maximal<S>::acceleration(const S& t_s, const S* y, int joint) const {
  const Solved now = solve(t_s, y);
  const Row<S> row = rate_rows(model_, joint, now.now)[0];
  return acceleration_of(row, now.a) + row.gamma;
}

namespace {
template <class S> struct Kick {
  std::vector<Acceleration<S>> by;
  std::vector<S> rope_by;
};
}  // namespace

template <class S> S Maximal<S>::response(const S& t_s, const S* y, int joint, int other) const {
  const std::vector<Motion<S>> now = motions(y);
  System system = make_system(t_s, y, now, false);
  system.factor_others();
  const Row<S> row = rate_rows(model_, joint, now)[0];
  const Moved<S> m = moved(model_, now, row);
  std::vector<S> b;
  for (const Row<S>& held : system.rows) b.push_back(-product_of(held, row, m));
  const std::vector<S> held = system.solve(std::move(b));
  const Row<S> to = rate_rows(model_, other, now)[0];
  S sum = product_of(to, row, m);
  for (std::size_t i = 0; i < held.size(); ++i) sum += held[i] * product_of(to, system.rows[i], system.moved_rows[i]);
  return sum;
}

template <class S> S Maximal<S>::impact(const S& t_s, S* y, int joint, const S& restitution) const {
  const std::vector<Motion<S>> now = motions(y);
  System system = make_system(t_s, y, now, false);
  system.factor_others();
  const Row<S> row = rate_rows(model_, joint, now)[0];
  const Moved<S> m = moved(model_, now, row);
  std::vector<S> b;
  for (const Row<S>& held : system.rows) b.push_back(-product_of(held, row, m));
  std::vector<S> held = system.solve(std::move(b));
  Kick<S> kick{std::vector<Acceleration<S>>(model_.world + 1), std::vector<S>(model_.ropes.size(), S(0))};
  system.add(held, kick.by, kick.rope_by);
  kick.by[row.a].a += m.la;
  kick.by[row.a].alpha += m.aa;
  kick.by[row.b].a += m.lb;
  kick.by[row.b].alpha += m.ab;
  const S before = velocity_of(row, now), impulse = -(1 + restitution) * before / acceleration_of(row, kick.by);
  for (Acceleration<S>& a : kick.by) {
    a.a = impulse * a.a;
    a.alpha = impulse * a.alpha;
  }
  for (S& s : kick.rope_by) s *= impulse;
  move(y, kick.by, kick.rope_by, true);
  return impulse;
}

template class Maximal<double>;
template class Maximal<Wide>;

}  // namespace atwood::mechanism
