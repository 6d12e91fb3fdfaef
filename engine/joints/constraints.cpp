// Accelerations, projections and multipliers under constraints.
#include "joints/constraints.hpp"

#include <algorithm>

#include "joints/planar_loops.hpp"
#include "math/so3.hpp"
#include "protocol/sample.hpp"

namespace atwood {
namespace {

constexpr int kMaxIterations = 30;

// Of a pivot that is round-off: what the columns of a chain of a thousand links leave of it.
template <class S> S pivot_tolerance() { return S(1024) * real::epsilon<S>(); }

}  // namespace

template <class S> Constraints<S>::~Constraints() = default;

// The row's covector applied to the rates of a generalised vector.
template <class S> S Constraints<S>::row_rate(const Row& row, const S* rates) const {
  if (row.rate >= 0) return rates[row.rate];
  S sum = S(0);
  for (int end = 0; end < 2; ++end) {
    if (row.link[end] < 0) continue;
    const Wrench<S>& on = row.row.on[end];
    const Vec3<S> centre = tree_.motion(row.link[end]).A + tree_.motion(row.link[end]).r;
    for (int i = row.link[end]; i >= 0; i = tree_.links()[i].parent) {
      const Link<S>& link = tree_.links()[i];
      const Vec3<S> moment = on.torque + cross(centre - tree_.motion(i).A, on.force);
      for (int k = link.first_rate; k < link.first_rate + link.rates; ++k) {
        const Column<S>& c = tree_.column(k);
        sum += rates[k] * dot(c.s, c.angular ? moment : on.force);
      }
    }
  }
  return sum;
}

// G u' at the accelerations of Tree::accelerations(), the motion at constant rates included.
template <class S> S Constraints<S>::row_acceleration(const Row& row, const S* du) const {
  if (row.rate >= 0) return du[row.rate];
  S sum = row.row.drift;
  for (int end = 0; end < 2; ++end) {
    if (row.link[end] < 0) continue;
    const LinkMotion<S>& m = tree_.motion(row.link[end]);
    const Vec3<S> a = m.a + cross(m.alpha, m.r) + cross(m.w, cross(m.w, m.r));
    sum += dot(row.row.on[end].force, a) + dot(row.row.on[end].torque, m.alpha);
  }
  return sum;
}

// Adds to du the smallest change that changes the rows of the group by b, which holds one scalar a row in use.
template <class S> void Constraints<S>::solve(Group& group, const std::vector<S>& b, S* du) {
  group.qr.solve(b.data(), z_.data());
  group.qr.multipliers(x_.data());
  for (std::size_t j = 0; j < group.used.size(); ++j) {
    Row& row = rows_[group.used[j]];
    row.multiplier = x_[j] * row.scale;
  }
  unwhiten(group, z_.data(), du);
}

template <class S> void Constraints<S>::constrain(S* du) {
  compute_inverse_sqrt_D();
  evaluate();
  for (Row& row : rows_) row.multiplier = S(0);
  S least = S(1);
  for (Group& group : groups_) {
    factor(group, false, pivot_tolerance<S>());
    if (group.used.empty()) continue;
    least = real::min(least, group.qr.rank() < group.qr.columns() ? S(0) : group.qr.pivot(group.qr.rank() - 1));
    for (std::size_t j = 0; j < group.used.size(); ++j) {
      const Row& row = rows_[group.used[j]];
      b_[j] = -row.scale * row_acceleration(row, du);
    }
    solve(group, b_, du);
  }
  least_pivot_ = real::min(least_pivot_, least);
  typical_pivot_ = real::max(typical_pivot_, least);
}

template <class S> auto Constraints<S>::wrenches() -> const typename Tree<S>::JointWrench* {
  std::fill(wrenches_.begin(), wrenches_.end(), typename Tree<S>::JointWrench{});
  for (const Row& row : rows_) {
    if (row.rate >= 0 || row.multiplier == S(0)) continue;
    for (int k = 0; k < 2; ++k) {
      if (row.link[k] < 0) continue;
      const Wrench<S>& on = row.row.on[k];
      typename Tree<S>::JointWrench& to = wrenches_[row.link[k]];
      to.force_W += row.multiplier * on.force;
      to.moment_W += row.multiplier * (on.torque + cross(tree_.motion(row.link[k]).r, on.force));
    }
  }
  return wrenches_.data();
}

template <class S> S Constraints<S>::tension(int rope) const {
  for (const Row& row : rows_)
    if (row.rope == rope) return ropes_[rope].mass_kg > S(0) ? row.multiplier : -row.multiplier;
  return S(0);
}

template <class S> auto Constraints<S>::closing_wrench(int joint) const -> typename Tree<S>::JointWrench {
  typename Tree<S>::JointWrench wrench;
  const int closing = closing_of_joint_[joint];
  if (closing < 0) return wrench;
  const JointConstraint<S>& constraint = joints_[closing];
  const Vec3<S> r = rotate(body_motion(constraint.child).q_WB, constraint.anchor[1]);
  for (const Row& row : rows_) {
    if (row.joint != closing) continue;
    const Wrench<S>& on = row.row.on[1];
    wrench.force_W += row.multiplier * on.force;
    wrench.moment_W += row.multiplier * (on.torque - cross(r, on.force));
  }
  return wrench;
}

template <class S> void Constraints<S>::closing_coordinates(const Joint& joint, S* q, S* u) const {
  coordinates_of(joint, body_motion(joint.parent), body_motion(joint.child), q, u);
}

template <class S> RopePath<S> Constraints<S>::rope_path_of(int rope) const {
  return rope_path(ropes_[rope], body_motion(ropes_[rope].body[0]), body_motion(ropes_[rope].body[1]));
}

// ---- projection ---------------------------------------------------------------------------------------------------
// The coordinates at y moved by `change`, a generalised vector of small displacements.
template <class S> void Constraints<S>::apply_change(const Group& group, const S* change, S* y) const {
  const auto turn = [&](S* q, const Vec3<S>& by) { store4(normalised(load4(q) * so3_exp(by)), q); };
  for (const int i : group.links) {
    const Link<S>& link = tree_.links()[i];
    if (link.driven) continue;
    const S* by = change + link.first_rate;
    if (link.joint < 0) {
      for (int k = 0; k < 3; ++k) y[link.at_q + k] += by[k];
      if (link.rotates) turn(y + link.at_q + 6, load3(by + 3));
    } else if (link.kind == JointKind::ball) {
      turn(y + link.at_q, load3(by));
    } else {
      for (int k = 0; k < link.rates; ++k) y[link.at_q + k] += by[k];
    }
  }
}

// In tolerances.
template <class S> S Constraints<S>::worst_value(bool chosen_alone) const {
  S worst = S(0);
  for (const Row& row : rows_) {
    if (row.rate >= 0 || (chosen_alone && !row.chosen)) continue;
    const S value = real::abs(row.row.value) / row.tolerance;
    if (!(value <= worst)) worst = value;
  }
  return worst;
}

// Newton's method; the factors of one configuration serve while they divide the values by 10 at least.
template <class S> bool Constraints<S>::project_positions(S* y) {
  report_ = {};
  tree_.kinematics(S(0), y, DrivenJoints::from_state);
  fault_.clear();
  if (!evaluate()) return false;
  S before = worst_value(true), best = before;
  bool fresh = false;
  for (int n = 0; before > S(1); ++n) {
    report_.iterations = n + 1;
    if (!fresh) {
      refactor(y);
      for (Group& group : groups_) factor(group, false, pivot_tolerance<S>());
      fresh = true;
    }
    std::fill(change_.begin(), change_.end(), S(0));
    for (Group& group : groups_) {
      for (std::size_t j = 0; j < group.used.size(); ++j) {
        const Row& row = rows_[group.used[j]];
        b_[j] = row.rate >= 0 ? S(0) : -row.scale * row.row.value;
      }
      solve(group, b_, change_.data());
      apply_change(group, change_.data(), y);
    }
    tree_.kinematics(S(0), y, DrivenJoints::from_state);
    if (!evaluate()) return false;
    const S now = worst_value(true);
    report_.residual = static_cast<double>(now * S(16) * real::epsilon<S>());
    if (!(now < S(1e30f)) || n == kMaxIterations) {
      report_.ended = SolveEnd::capped;
      break;
    }
    if (now > best / S(2) && now <= S(256)) {
      report_.ended = now <= S(1) ? SolveEnd::converged : SolveEnd::stagnated;
      return true;
    }
    if (now > before / S(10)) fresh = false;
    best = real::min(best, now);
    before = now;
  }
  if (report_.ended != SolveEnd::capped) return true;
  fault_ = "the positions of its loops were not found: after " + std::to_string(report_.iterations) +
           " iterations the largest gap is still " + format_double(report_.residual) + " of the lengths in it";
  return false;
}

// b_: what the rates of the rows in use lack, of the rates in scratch_. The speed at which a rope with heavy pulleys
// runs is that of its first end.
template <class S> void Constraints<S>::missing_rates(const Group& group) {
  for (std::size_t j = 0; j < group.used.size(); ++j) {
    const Row& row = rows_[group.used[j]];
    S rate = row.row.rate - row_rate(row, scratch_.data());
    if (row.extra >= 0) rate += row_rate(row.part == 0 ? row : rows_[group.used[j] - 1], scratch_.data());
    b_[j] = row.scale * rate;
  }
}

template <class S> void Constraints<S>::project_rates(S* y) {
  for (std::size_t k = 0; k < scratch_.size(); ++k) scratch_[k] = y[tree_.state_of_rate(static_cast<int>(k))];
  std::fill(change_.begin(), change_.end(), S(0));
  for (Group& group : groups_) {
    factor(group, false, pivot_tolerance<S>());
    if (group.used.empty()) continue;
    missing_rates(group);
    solve(group, b_, change_.data());
  }
  for (std::size_t k = 0; k < change_.size(); ++k)
    if (change_[k] != S(0)) y[tree_.state_of_rate(static_cast<int>(k))] += change_[k];
}

// Rows that were not chosen hold by themselves, or they are independent of those that were.
template <class S> bool Constraints<S>::add_rows(const S* y) {
  const S most = real::sqrt(real::epsilon<S>()) / (S(16) * real::epsilon<S>()) * S(1e-3);
  if (!(worst_value(false) > most)) return false;
  refactor(y);
  bool more = false;
  for (Group& group : groups_) {
    factor(group, true, real::sqrt(real::epsilon<S>()));
    int chosen = 0;
    for (const int r : group.used) chosen += rows_[r].chosen ? 1 : 0;
    if (group.qr.rank() <= chosen) continue;
    more = true;
    for (const int r : group.rows) rows_[r].chosen = false;
    for (int k = 0; k < group.qr.rank(); ++k) rows_[group.used[group.qr.equation(k)]].chosen = true;
  }
  return more;
}

template <class S> bool Constraints<S>::project(S* y) {
  if (planar_ != nullptr && planar_->project(y)) return true;
  set_locked(y);
  if (joints_.empty() && ropes_.empty()) return true;
  if (!project_positions(y)) return false;
  const bool more = add_rows(y);
  if (more && !project_positions(y)) return false;
  refactor(y);
  if (more && planar_ != nullptr) planar_ = PlanarLoops<S>::of(tree_, *this);
  project_rates(y);
  set_locked(y);
  return true;
}

template <class S> void Constraints<S>::rows_at(const S* y, std::vector<BodyRow<S>>& rows) {
  tree_.kinematics(S(0), y, DrivenJoints::from_state);
  evaluate();
  rows.clear();
  for (const Row& row : rows_) {
    if (!row.chosen || row.rate >= 0 || row.extra >= 0) continue;
    BodyRow<S> out{{-1, -1}, {row.row.on[0], row.row.on[1]}, row.row.value, row.tolerance};
    for (int k = 0; k < 2; ++k)
      if (row.link[k] >= 0) out.body[k] = tree_.links()[row.link[k]].body;
    rows.push_back(out);
  }
}

// ---- stops ----------------------------------------------------------------------------------------------------------
template <class S> void Constraints<S>::lock(int joint, bool locked, S at) {
  rows_[locked_row_[joint]].locked = locked;
  rows_[locked_row_[joint]].locked_at = at;
}

// Coordinates that rest at a stop and their rates, exactly.
template <class S> void Constraints<S>::set_locked(S* y) const {
  for (const JointStop<S>& stop : stops_) {
    const Row& row = rows_[locked_row_[stop.joint]];
    if (!row.locked) continue;
    y[stop.q_at] = row.locked_at;
    y[stop.u_at] = S(0);
  }
}

template <class S> S Constraints<S>::locked_force(int joint) const {
  const int row = locked_row_[joint];
  return row >= 0 && rows_[row].locked ? rows_[row].multiplier : S(0);
}

template <class S>
void Constraints<S>::impact_at_limits(const S* y, const std::vector<int>& joints, const std::vector<S>& change, S* du,
                                      S* impulse) {
  std::vector<char> before;
  for (const int joint : joints) {
    Row& row = rows_[locked_row_[joint]];
    before.push_back(row.locked);
    row.locked = true;
  }
  refactor(y);
  std::fill(du, du + tree_.rate_count(), S(0));
  for (Group& group : groups_) {
    factor(group, false, pivot_tolerance<S>());
    if (group.used.empty()) continue;
    for (std::size_t j = 0; j < group.used.size(); ++j) {
      b_[j] = S(0);
      for (std::size_t i = 0; i < joints.size(); ++i)
        if (locked_row_[joints[i]] == group.used[j]) b_[j] = rows_[group.used[j]].scale * change[i];
    }
    solve(group, b_, du);
  }
  for (std::size_t i = 0; i < joints.size(); ++i) {
    Row& row = rows_[locked_row_[joints[i]]];
    impulse[i] = row.multiplier;
    row.locked = before[i] != 0;
  }
}

// ---- reactions ---------------------------------------------------------------------------------------------------
// What a dependence of the rows on each other (multipliers that move nothing) does to the reaction of each joint.
template <class S> void Constraints<S>::find_open_components() {
  std::fill(open_components_.begin(), open_components_.end(), 0u);
  const int links = static_cast<int>(tree_.links().size());
  std::vector<S> kept;
  for (const Row& row : rows_) kept.push_back(row.multiplier);
  for (Group& group : groups_) {
    factor(group, true, real::sqrt(real::epsilon<S>()) / S(8));
    const int rank = group.qr.rank();
    std::vector<S> w(static_cast<std::size_t>(rank));
    for (int j = rank; j < group.qr.columns(); ++j) {
      group.qr.dependence(j, w.data());
      for (Row& row : rows_) row.multiplier = S(0);
      for (int k = 0; k <= rank; ++k) {
        Row& row = rows_[group.used[group.qr.equation(k < rank ? k : j)]];
        row.multiplier = (k < rank ? -w[k] : S(1)) * row.scale;
      }
      mark_open_components(links);
    }
  }
  for (std::size_t r = 0; r < rows_.size(); ++r) rows_[r].multiplier = kept[r];
}

// Under the present multipliers, which leave all bodies at rest: a joint of the tree carries what acts outwards of it.
template <class S> void Constraints<S>::mark_open_components(int links) {
  wrenches();
  for (int i = links - 1; i >= 0; --i) {
    const int parent = tree_.links()[i].parent;
    if (parent < 0) continue;
    wrenches_[parent].moment_W += wrenches_[i].moment_W + cross(tree_.motion(i).d, wrenches_[i].force_W);
    wrenches_[parent].force_W += wrenches_[i].force_W;
  }
  S force = S(0), moment = S(0);
  const auto each_joint = [&](const auto& what) {
    for (int j = 0; j < static_cast<int>(open_components_.size()); ++j) {
      const int link = tree_.link_of_joint(j);
      what(j, link >= 0 ? wrenches_[link] : closing_wrench(j));
    }
  };
  each_joint([&](int, const typename Tree<S>::JointWrench& wrench) {
    force = real::max(force, norm(wrench.force_W));
    moment = real::max(moment, norm(wrench.moment_W));
  });
  const S size = size_m_ > S(0) ? size_m_ : S(1);
  const S least_force = S(1e-6) * real::max(force, moment / size), least_moment = least_force * size;
  each_joint([&](int j, const typename Tree<S>::JointWrench& wrench) {
    const S of[6] = {wrench.force_W.x,  wrench.force_W.y,  wrench.force_W.z,
                     wrench.moment_W.x, wrench.moment_W.y, wrench.moment_W.z};
    for (int k = 0; k < 6; ++k)
      if (real::abs(of[k]) > (k < 3 ? least_force : least_moment)) open_components_[j] |= 1u << k;
  });
}

template class Constraints<float>;
template class Constraints<double>;
template class Constraints<long double>;
template class Constraints<Quad>;

}  // namespace atwood
