#include "mechanism/reduced.hpp"

#include <algorithm>

namespace atwood::mechanism {

namespace {
enum Group { lengths, attitudes, angles, speeds, turn_rates };

bool is_length(JointKind kind, int k) {
  return kind == JointKind::slider || (kind == JointKind::cylindrical && k == 1);
}
}  // namespace

template <class S>
Reduced<S>::Reduced(const Scene& scene, double t_end_s, const Sample& start)
    : model_(make_model<S>(scene)), free_(scene, t_end_s) {
  const int n = model_.world;
  body_q_.assign(n, -1);
  body_u_.assign(n, -1);
  dof_begin_.assign(n + 1, 0);
  dof_count_.assign(n + 1, 0);
  parent_.assign(n + 1, -1);
  joint_q_.assign(model_.joints.size(), -1);
  joint_u_.assign(model_.joints.size(), -1);
  std::vector<int> rate_groups;
  for (int i = 0; i < n; ++i) {
    if (!model_.mobile[i] || model_.placing[i] >= 0) continue;
    body_q_[i] = coordinates_;
    body_u_[i] = dof_begin_[i] = rates_;
    dof_count_[i] = model_.turns[i] ? 6 : 3;
    for (int k = 0; k < 3; ++k) groups_.push_back(lengths), rate_groups.push_back(speeds);
    if (model_.turns[i])
      for (int k = 0; k < 4; ++k) groups_.push_back(attitudes);
    if (model_.turns[i])
      for (int k = 0; k < 3; ++k) rate_groups.push_back(turn_rates);
    coordinates_ += model_.turns[i] ? 7 : 3;
    rates_ += dof_count_[i];
  }
  for (const int j : model_.tree) {
    const JointModel<S>& joint = model_.joints[j];
    joint_q_[j] = coordinates_;
    joint_u_[j] = dof_begin_[joint.child] = rates_;
    dof_count_[joint.child] = atwood::rate_count(joint.kind);
    parent_[joint.child] = joint.parent;
    for (int k = 0; k < atwood::coordinate_count(joint.kind); ++k)
      groups_.push_back(joint.kind == JointKind::ball ? attitudes : is_length(joint.kind, k) ? lengths : angles);
    for (int k = 0; k < atwood::rate_count(joint.kind); ++k)
      rate_groups.push_back(is_length(joint.kind, k) ? speeds : turn_rates);
    coordinates_ += atwood::coordinate_count(joint.kind);
    rates_ += dof_count_[joint.child];
  }
  for (const RopeModel<S>& rope : model_.ropes) {
    const bool has = rope.inertia > 0;
    rope_q_.push_back(has ? coordinates_++ : -1);
    rope_u_.push_back(has ? rates_++ : -1);
    if (has) groups_.push_back(lengths), rate_groups.push_back(speeds);
  }
  groups_.insert(groups_.end(), rate_groups.begin(), rate_groups.end());
  driven_.assign(rates_, 0);
  first_.resize(rates_);
  for (int k = 0; k < rates_; ++k) first_[k] = k;
  for (int i = 0; i < n; ++i)
    for (int k = 0; k < dof_count_[i]; ++k)
      for (int b = i; b >= 0 && b < n; b = parent_[b])
        if (dof_count_[b] > 0) first_[dof_begin_[i] + k] = std::min(first_[dof_begin_[i] + k], dof_begin_[b]);
  for (const int j : model_.tree)
    if (model_.joints[j].driven) driven_[joint_u_[j]] = 1;
  choice.memory = begin_at(model_, start);
  std::vector<S> y = initial(start);
  begin_ropes(model_, motions(y.data()), choice.memory);
}

template <class S> std::vector<S> Reduced<S>::initial(const Sample& start) const {
  std::vector<S> y(size(), S(0));
  for (int i = 0; i < model_.world; ++i) {
    if (body_q_[i] < 0) continue;
    const BodySample& body = start.bodies[i];
    for (int k = 0; k < 3; ++k) {
      y[body_q_[i] + k] = static_cast<S>(body.p_m[k]);
      y[coordinates_ + body_u_[i] + k] = static_cast<S>(body.v_m_per_s[k]);
    }
    if (!model_.turns[i]) continue;
    Quaternion<S> q;
    for (int k = 0; k < 4; ++k) q[k] = static_cast<S>(body.q_wxyz[k]);
    q = normalised(q);
    std::copy(q.begin(), q.end(), y.begin() + body_q_[i] + 3);
    for (int k = 0; k < 3; ++k) y[coordinates_ + body_u_[i] + 3 + k] = static_cast<S>(body.w_rad_per_s[k]);
  }
  for (const int j : model_.tree) {
    const JointModel<S>& joint = model_.joints[j];
    std::array<S, 4> q{};
    for (int k = 0; k < 4; ++k) q[k] = static_cast<S>(start.joints[j].q[k]);
    if (joint.kind == JointKind::ball) q = normalised<S>(q);
    std::copy_n(q.begin(), atwood::coordinate_count(joint.kind), y.begin() + joint_q_[j]);
    for (int k = 0; k < atwood::rate_count(joint.kind); ++k)
      y[coordinates_ + joint_u_[j] + k] = static_cast<S>(start.joints[j].u[k]);
    if (joint.driven) y[coordinates_ + joint_u_[j]] = joint.rate;
  }
  const std::vector<Motion<S>> now = motions(y.data());
  for (std::size_t k = 0; k < model_.ropes.size(); ++k) {
    if (rope_u_[k] < 0) continue;
    std::vector<Row<S>> rows;
    add_rope_rows(model_, static_cast<int>(k), now, S(0), choice.memory, rows);
    y[coordinates_ + rope_u_[k]] = -velocity_of(rows[0], now);
  }
  return y;
}

template Reduced<double>::Reduced(const Scene&, double, const Sample&);
template Reduced<long double>::Reduced(const Scene&, double, const Sample&);
template Reduced<Wide>::Reduced(const Scene&, double, const Sample&);
template std::vector<double> Reduced<double>::initial(const Sample&) const;
template std::vector<long double> Reduced<long double>::initial(const Sample&) const;
template std::vector<Wide> Reduced<Wide>::initial(const Sample&) const;

}  // namespace atwood::mechanism
