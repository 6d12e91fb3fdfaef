// The rows of a scene's constraints: what they are, what they tie together, and which of them act.
#include <algorithm>
#include <cstdint>
#include <functional>
#include <numeric>

#include "joints/planar_loops.hpp"
#include "scene/driven_closings.hpp"

namespace atwood {
namespace {

// Of rows on the constraints, where dependent columns leave nothing but round-off.
template <class S> S rank_tolerance() { return real::sqrt(real::epsilon<S>()) / S(8); }

std::string constraint_fault(const Scene& scene) {
  for (int j = 0; j < static_cast<int>(scene.joints.size()); ++j) {
    const Joint& joint = scene.joints[j];
    const std::string named = "joint `" + joint.name + "`";
    if (joint.limits && joint.driven_rate) return named + " has limits and a prescribed motion";
    if (!joint.closes_loop) continue;
    if (joint.driven_rate) {
      const std::string obstacle = obstacle_to_placing(scene, j);
      return named + " closes a loop and is driven" +
             (obstacle.empty() ? "" : ", and cannot be a joint of the tree: " + obstacle) +
             "; drive a joint of the tree instead";
    }
    if (joint.limits) return named + " closes a loop and has limits; give them to a joint of the tree instead";
    for (const int body : {joint.parent, joint.child})
      if (body >= 0 && !scene.bodies[body].fixed && !rotates(scene.bodies[body]))
        return named + " ties the point mass `" + scene.bodies[body].name + "`: a body on a joint needs an inertia";
  }
  for (const Joint& joint : scene.joints)
    if (joint.closes_loop)
      for (const int body : {joint.parent, joint.child})
        if (body >= 0 && scene.bodies[body].release_s > 0)
          return "release_s is not supported for bodies in a closed loop: `" + scene.bodies[body].name + "`";
  for (const Rope& rope : scene.ropes) {
    for (const int body : rope.bodies)
      if (scene.bodies[body].release_s > 0)
        return "release_s is not supported for bodies on a rope: `" + scene.bodies[body].name + "`";
    bool moves = false;
    for (const int body : rope.bodies) moves = moves || !scene.bodies[body].fixed;
    if (!moves) return "rope `" + rope.name + "` ties no moving body";
  }
  return "";
}

}  // namespace

template <class S>
Constraints<S>::Constraints(const Scene& scene, Tree<S>& tree) : refusal_(constraint_fault(scene)), tree_(tree) {
  if (!refusal_.empty()) return;
  for (const Body& body : scene.bodies) {
    const auto& q = body.orientation_wxyz;
    resting_.push_back({narrow3<S>(body.position_m), normalised(Quat<S>{S(q[0]), S(q[1]), S(q[2]), S(q[3])}), {}, {}});
  }
  twist_.resize(tree.links().size());
  wrenches_.resize(tree.links().size());
  no_loads_.resize(scene.bodies.size());
  open_components_.assign(scene.joints.size(), 0);
  locked_row_.assign(scene.joints.size(), -1);
  closing_of_joint_.assign(scene.joints.size(), -1);
  const auto rates = static_cast<std::size_t>(tree.rate_count());
  for (auto* room : {&inverse_sqrt_D_, &change_, &scratch_}) room->assign(rates, S(0));
  trial_.resize(static_cast<std::size_t>(tree.state_end()));
  for (const Link<S>& link : tree.links())
    size_m_ = real::max(size_m_, norm(link.from_parent_P) + norm(link.to_centre_B));
  build_rows(scene);
  build_groups();
}

template <class S> void Constraints<S>::build_rows(const Scene& scene) {
  const auto link_of = [&](int body) { return body < 0 ? -1 : tree_.link_of(body); };
  for (int j = 0; j < static_cast<int>(scene.joints.size()); ++j) {
    const Joint& joint = scene.joints[j];
    if (joint.closes_loop) {
      closing_of_joint_[j] = static_cast<int>(joints_.size());
      scene_joint_.push_back(j);
      joints_.push_back(joint_constraint(joint, joint.parent < 0 ? Quat<S>{} : resting_[joint.parent].q_WB));
      for (int part = 0; part < static_cast<int>(joints_.back().conditions.size()); ++part) {
        Row row;
        row.joint = closing_of_joint_[j];
        row.part = part;
        row.link[0] = link_of(joint.parent);
        row.link[1] = link_of(joint.child);
        rows_.push_back(row);
      }
    } else if (joint.limits) {
      locked_row_[j] = static_cast<int>(rows_.size());
      Row row;
      row.link[1] = tree_.link_of_joint(j);
      const Link<S>& link = tree_.links()[row.link[1]];
      row.rate = link.first_rate;
      rows_.push_back(row);
      stops_.push_back({joint.name, j, joint.parent, joint.child, row.link[1], row.rate, link.at_q, link.at_u,
                        S(joint.limits->lower), S(joint.limits->upper), S(joint.limits->restitution)});
    }
  }
  for (const Rope& rope : scene.ropes) {
    ropes_.push_back(rope_constraint<S>(rope));
    for (int part = 0; part < (ropes_.back().mass_kg > S(0) ? 2 : 1); ++part) {
      Row row;
      row.rope = static_cast<int>(ropes_.size()) - 1;
      row.part = part;
      for (int k = 0; k < 2; ++k) row.link[k] = link_of(rope.bodies[k]);
      rows_.push_back(row);
    }
  }
  for (Row& row : rows_) {
    for (int link : row.link)
      for (; link >= 0; link = tree_.links()[link].parent) row.path.push_back(link);
    std::sort(row.path.begin(), row.path.end(), std::greater<>());
    row.path.erase(std::unique(row.path.begin(), row.path.end()), row.path.end());
  }
}

// Links that rows and joints tie together, directly or not, are solved for together.
template <class S> void Constraints<S>::build_groups() {
  const int links = static_cast<int>(tree_.links().size());
  std::vector<int> root(links);
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&](int i) {
    while (root[i] != i) i = root[i] = root[root[i]];
    return i;
  };
  for (int i = 0; i < links; ++i)
    if (tree_.links()[i].parent >= 0) root[find(i)] = find(tree_.links()[i].parent);
  for (const Row& row : rows_)
    for (const int link : row.path) root[find(link)] = find(row.path.front());
  std::vector<int> group_of(links, -1);
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    Row& row = rows_[r];
    if (row.path.empty()) continue;
    int& group = group_of[find(row.path.front())];
    if (group < 0) {
      group = static_cast<int>(groups_.size());
      groups_.emplace_back();
    }
    row.group = group;
    groups_[group].rows.push_back(static_cast<int>(r));
  }
  local_.assign(static_cast<std::size_t>(tree_.rate_count()), -1);
  for (int i = 0; i < links; ++i) {
    const int group = group_of[find(i)];
    if (group < 0) continue;
    groups_[group].links.push_back(i);
    const Link<S>& link = tree_.links()[i];
    for (int k = link.first_rate; k < link.first_rate + link.rates; ++k) {
      local_[k] = static_cast<int>(groups_[group].rates.size());
      groups_[group].rates.push_back(k);
    }
  }
  for (Group& group : groups_) {
    for (const int r : group.rows) {
      Row& row = rows_[r];
      if (row.rope < 0 || ropes_[row.rope].mass_kg == S(0)) continue;
      if (row.part == 0) group.extra_kg.push_back(ropes_[row.rope].mass_kg);
      row.extra = group.size() - 1;
    }
    group.qr.resize(group.size(), static_cast<int>(group.rows.size()));
  }
  // Room for the unknowns of the largest group.
  std::size_t most = 0, equations = rows_.size();
  for (const Group& group : groups_) most = std::max(most, static_cast<std::size_t>(group.size()));
  z_.resize(most);
  b_.resize(std::max(most, equations));
  x_.resize(equations);
}

template <class S> TiedBody<S> Constraints<S>::body_motion(int body) const {
  if (body < 0) return {};
  const int link = tree_.link_of(body);
  if (link < 0) return resting_[body];
  const LinkMotion<S>& m = tree_.motion(link);
  return {m.A + m.r, m.q_WB, m.v + cross(m.w, m.r), m.w};
}

template <class S> bool Constraints<S>::evaluate() {
  bool complete = true;
  const S round_off = S(16) * real::epsilon<S>();
  std::vector<Row>& rows = rows_;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    Row& row = rows[r];
    if (row.joint >= 0 && row.part == 0) {
      const JointConstraint<S>& joint = joints_[row.joint];
      const TiedBody<S> parent = body_motion(joint.parent), child = body_motion(joint.child);
      const S lengths = norm(parent.p_WB) + norm(child.p_WB) + norm(joint.anchor[0]) + norm(joint.anchor[1]) + size_m_;
      for (std::size_t part = 0; part < joint.conditions.size(); ++part) {
        Row& one = rows[r + part];
        constraint_row(joint, static_cast<int>(part), parent, child, S(0), one.row);
        const ConditionKind kind = joint.conditions[part].kind;
        const bool angle = kind == ConditionKind::square || kind == ConditionKind::turn;
        one.tolerance = round_off * (angle ? S(1) : lengths);
      }
    } else if (row.rope >= 0 && row.part == 0) {
      const RopeConstraint<S>& rope = ropes_[row.rope];
      const TiedBody<S> first = body_motion(rope.body[0]), last = body_motion(rope.body[1]);
      const RopePath<S> path = rope_path(rope, first, last);
      if (path.fault != nullptr) {
        complete = false;
        if (fault_.empty()) fault_ = path.fault;
        continue;  // the rows stay as they were
      }
      JointRow<S> both[2];
      const int count = rope_rows(rope, path, first, last, both);
      for (int part = 0; part < count; ++part) {
        rows[r + part].row = both[part];
        rows[r + part].tolerance = round_off * (path.length_m + norm(path.x[0]) + norm(path.x[1]));
      }
    }
  }
  return complete;
}

// 1 is the column of the row's wrenches on the bodies by themselves, without joints.
template <class S> void set_scale(const Tree<S>& tree, const int* links, const JointRow<S>& row, S& scale) {
  S square = S(0);
  for (int k = 0; k < 2; ++k) {
    if (links[k] < 0) continue;
    const Link<S>& link = tree.links()[links[k]];
    square += dot(row.on[k].force, row.on[k].force) / link.mass_kg;
    const S moment = (link.J_B.xx + link.J_B.yy + link.J_B.zz) / S(3);
    if (moment > S(0)) square += dot(row.on[k].torque, row.on[k].torque) / moment;
  }
  if (square > S(0)) scale = S(1) / real::sqrt(square);
}

// The wrenches of a row, or a unit force along its coordinate, taken inwards as in Tree::solve; what each rate
// receives, over the square root of its D.
template <class S> void Constraints<S>::whiten(const Row& row, S* column) {
  const Group& group = groups_[row.group];
  std::fill(column, column + group.size(), S(0));
  for (const int i : row.path) twist_[i] = {};
  for (int k = 0; k < 2; ++k) {
    if (row.link[k] < 0 || row.rate >= 0) continue;
    Twist& p = twist_[row.link[k]];
    p.angular += row.row.on[k].torque + cross(tree_.motion(row.link[k]).r, row.row.on[k].force);
    p.linear += row.row.on[k].force;
  }
  for (const int i : row.path) {
    const Link<S>& link = tree_.links()[i];
    Twist& p = twist_[i];
    if (!link.driven)
      for (int k = link.first_rate; k < link.first_rate + link.rates; ++k) {
        const Column<S>& c = tree_.column(k);
        const S force = (k == row.rate ? S(1) : S(0)) + dot(c.s, c.angular ? p.angular : p.linear);
        const S share = force * c.inverse_D;
        column[local_[k]] = force * inverse_sqrt_D_[k];
        p.angular -= share * c.U_n;
        p.linear -= share * c.U_f;
      }
    if (link.parent < 0) continue;
    Twist& to = twist_[link.parent];
    to.angular += p.angular + cross(tree_.motion(i).d, p.linear);
    to.linear += p.linear;
  }
  if (row.extra >= 0) column[row.extra] = S(-1) / real::sqrt(group.extra_kg[row.extra - group.rates.size()]);
}

// du += W^T z
template <class S> void Constraints<S>::unwhiten(const Group& group, const S* z, S* du) {
  for (const int i : group.links) {
    const Link<S>& link = tree_.links()[i];
    Twist& a = twist_[i];
    a = {};
    if (link.parent >= 0) {
      const Twist& parent = twist_[link.parent];
      a = {parent.angular, parent.linear + cross(parent.angular, tree_.motion(i).d)};
    }
    if (link.driven) continue;
    for (int k = link.first_rate + link.rates - 1; k >= link.first_rate; --k) {
      const Column<S>& c = tree_.column(k);
      const S change = inverse_sqrt_D_[k] * z[local_[k]] - c.inverse_D * (dot(c.U_n, a.angular) + dot(c.U_f, a.linear));
      du[k] += change;
      (c.angular ? a.angular : a.linear) += change * c.s;
    }
  }
}

template <class S> void Constraints<S>::compute_inverse_sqrt_D() {
  for (std::size_t k = 0; k < inverse_sqrt_D_.size(); ++k) {
    const S inverse = tree_.column(static_cast<int>(k)).inverse_D;
    inverse_sqrt_D_[k] = inverse > S(0) ? real::sqrt(inverse) : S(0);
  }
}

template <class S> void Constraints<S>::factor(Group& group, bool all, S tolerance) {
  group.used.clear();
  for (const int r : group.rows) {
    const Row& row = rows_[r];
    if (row.locked || (row.rate < 0 && (all || row.chosen))) group.used.push_back(r);
  }
  group.qr.resize(group.size(), static_cast<int>(group.used.size()));
  for (std::size_t j = 0; j < group.used.size(); ++j) {
    Row& row = rows_[group.used[j]];
    if (row.rate >= 0) row.scale = real::sqrt(S(1) / tree_.column(row.rate).inverse_D);
    else set_scale(tree_, row.link, row.row, row.scale);
    S* column = group.qr.column(static_cast<int>(j));
    whiten(row, column);
    for (int i = 0; i < group.size(); ++i) column[i] *= row.scale;
  }
  group.qr.factor(tolerance);
}

// ---- which rows act -----------------------------------------------------------------------------------------------
template <class S> void Constraints<S>::refactor(const S* y) {
  tree_.kinematics(S(0), y, DrivenJoints::from_state);
  tree_.accelerations(no_loads_.data(), nullptr, scratch_.data());
  compute_inverse_sqrt_D();
  evaluate();
}

// Pivots of all rows at configurations beside the start, reached along the constraints; that one counts at which most
// rows are independent.
template <class S> void Constraints<S>::start(const S* y) {
  tree_.kinematics(S(0), y, DrivenJoints::from_state);
  for (RopeConstraint<S>& rope : ropes_) {
    const RopePath<S> path = rope_path(rope, body_motion(rope.body[0]), body_motion(rope.body[1]));
    if (path.fault != nullptr) {
      refusal_ = std::string("at the start ") + path.fault;
      return;
    }
    start_rope(path, rope);
  }
  for (Row& row : rows_) row.chosen = row.locked = false;
  refactor(y);
  for (Group& group : groups_) {
    factor(group, true, rank_tolerance<S>());
    for (int k = 0; k < group.qr.rank(); ++k) rows_[group.used[group.qr.equation(k)]].chosen = true;
  }
  choose_rows_nearby(y);
  tree_.kinematics(S(0), y, DrivenJoints::from_state);
  planar_ = PlanarLoops<S>::of(tree_, *this);
  fault_.clear();
}

// A start may lie at a singular configuration, where the constraints have a lower rank than around it. A few random
// configurations nearby are tried; where none has a higher rank, or none can be reached, the rows chosen at the start
// stay.
template <class S> void Constraints<S>::choose_rows_nearby(const S* y) {
  constexpr int tries = 3;
  std::vector<S> beside(trial_.size()), z;
  std::uint64_t random = 0x9e3779b97f4a7c15u;
  const auto next = [&] {  // in [-1, 1): Knuth's linear congruential generator
    random = random * 6364136223846793005u + 1442695040888963407u;
    return S(static_cast<double>(random >> 11) * 0x1p-52 - 1.0);
  };
  for (std::size_t g = 0; g < groups_.size(); ++g)
    for (int attempt = 0; attempt < tries; ++attempt) {
      Group& group = groups_[g];
      refactor(y);
      factor(group, false, rank_tolerance<S>());
      const int rank = group.qr.rank();
      if (rank == group.size()) break;  // it cannot move
      z.assign(static_cast<std::size_t>(group.size()), S(0));
      std::fill(change_.begin(), change_.end(), S(0));
      for (S& component : z) component = next();
      unwhiten(group, z.data(), change_.data());
      for (std::size_t j = 0; j < group.used.size(); ++j)
        b_[j] = -(row_rate(rows_[group.used[j]], change_.data())) * rows_[group.used[j]].scale;
      group.qr.solve(b_.data(), z_.data());
      unwhiten(group, z_.data(), change_.data());
      S largest = S(0);
      for (const int i : group.links) {
        const Link<S>& link = tree_.links()[i];
        for (int k = link.first_rate; k < link.first_rate + link.rates; ++k)
          largest = real::max(largest,
                              real::abs(change_[k]) / (tree_.column(k).angular ? S(1) : real::max(size_m_, S(1e-30f))));
      }
      if (!(largest > S(0))) break;
      for (S& change : change_) change *= S(0.05) / largest;
      beside.assign(y, y + beside.size());
      apply_change(group, change_.data(), beside.data());
      if (!project_positions(beside.data())) continue;
      refactor(beside.data());
      factor(group, true, rank_tolerance<S>());
      if (group.qr.rank() <= rank) continue;
      for (const int r : group.rows) rows_[r].chosen = false;
      for (int k = 0; k < group.qr.rank(); ++k) rows_[group.used[group.qr.equation(k)]].chosen = true;
    }
}

#define ATWOOD_ROWS(S)                                                \
  template Constraints<S>::Constraints(const Scene&, Tree<S>&);       \
  template void Constraints<S>::build_rows(const Scene&);             \
  template void Constraints<S>::build_groups();                       \
  template TiedBody<S> Constraints<S>::body_motion(int) const;        \
  template bool Constraints<S>::evaluate();                           \
  template void Constraints<S>::whiten(const Row&, S*);               \
  template void Constraints<S>::unwhiten(const Group&, const S*, S*); \
  template void Constraints<S>::compute_inverse_sqrt_D();             \
  template void Constraints<S>::factor(Group&, bool, S);              \
  template void Constraints<S>::refactor(const S*);                   \
  template void Constraints<S>::start(const S*);                      \
  template void Constraints<S>::choose_rows_nearby(const S*);
ATWOOD_ROWS(float)
ATWOOD_ROWS(double)
ATWOOD_ROWS(long double)
ATWOOD_ROWS(Quad)
#undef ATWOOD_ROWS

}  // namespace atwood
