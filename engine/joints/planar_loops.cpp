#include "joints/planar_loops_kernel.hpp"

#include <algorithm>
#include <functional>

namespace atwood {
namespace {

template <class S> bool nearly_zero(S x) { return real::abs(x) <= S(8) * real::epsilon<S>(); }

}  // namespace

template <class S>
template <class V>
void PlanarLoops<S>::Work<V>::resize(std::size_t links_count, std::size_t rates, std::size_t equations) {
  links.resize(links_count);
  poses.resize(links_count);
  twists.resize(links_count);
  root.resize(rates);
  z.resize(std::max(rates, equations));
  column.resize(rates * equations);
  for (auto* room : {&diagonal, &reflected, &b}) room->resize(equations);
}

template <class S>
PlanarLoops<S>::PlanarLoops(Tree<S>& tree, Constraints<S>& constraints, PlanarRates<S> planar)
    : tree_(tree), constraints_(constraints), planar_(std::move(planar)), rates_(tree.rate_count()) {}

template <class S> std::unique_ptr<PlanarLoops<S>> PlanarLoops<S>::of(Tree<S>& tree, Constraints<S>& constraints) {
  if (!constraints.ropes_.empty() || !constraints.stops_.empty() || constraints.joints_.empty()) return nullptr;
  auto planar = PlanarRates<S>::of(tree);
  if (!planar) return nullptr;
  std::unique_ptr<PlanarLoops> loops(new PlanarLoops(tree, constraints, std::move(*planar)));
  loops->take_bodies();
  if (!loops->take_rows()) return nullptr;
  const std::size_t links = tree.links().size(), rates = tree.rate_count(), equations = loops->equations_.size();
  loops->one_.resize(links, rates, equations);
  if constexpr (PackOf<S>::in_register) loops->lanes_.resize(links, rates, equations);
  loops->qr_.resize(static_cast<int>(rates), loops->chosen_);
  for (auto* room : {&loops->value_, &loops->tolerance_, &loops->rate_, &loops->scale_, &loops->b_})
    room->resize(equations);
  loops->wide_poses_.resize(loops->bodies_.size());
  loops->before_.resize(static_cast<std::size_t>(tree.state_end()));
  loops->unused_.resize(loops->before_.size());
  loops->z_.resize(rates);
  loops->no_forces_.assign(rates, S(0));
  return loops;
}

// At the tree's present kinematics.
template <class S> void PlanarLoops<S>::take_bodies() {
  std::vector<Quat<S>> attitudes;
  for (int i = 0; i < static_cast<int>(tree_.links().size()); ++i) {
    const Link<S>& link = tree_.links()[i];
    const auto& plane = planar_.planes_[planar_.links_[i].plane];
    attitudes.push_back((link.parent >= 0 ? attitudes[link.parent] : tree_.root_attitude(i)) * link.frame);
    const LinkMotion<S>& m = tree_.motion(i);
    const Vec3<S> hung_on = m.A - m.d;
    bodies_.push_back({link.body,
                       {dot(hung_on, plane.e1), dot(hung_on, plane.e2)},
                       dot(m.A + m.r, plane.normal),
                       attitudes.back(),
                       rotate_back(attitudes.back(), plane.normal)});
  }
}

template <class S> bool PlanarLoops<S>::take_end(int body, const Vec3<S>& anchor_B, Closing& closing, End& end) const {
  end.link = body < 0 ? -1 : tree_.link_of(body);
  closing.lengths += norm(anchor_B);
  if (end.link < 0) return true;
  const Link<S>& link = tree_.links()[end.link];
  const Body& of = bodies_[end.link];
  const auto& constants = planar_.links_[end.link];
  const auto& plane = planar_.planes_[constants.plane];
  const Vec3<S> arm = rotate(of.attitude, anchor_B);
  end.arm = {dot(arm, plane.e1), dot(arm, plane.e2)};
  end.across = dot(arm, plane.normal);
  end.point = {end.arm.x + constants.to_centre.x, end.arm.y + constants.to_centre.y};
  end.inverse_mass = S(1) / link.mass_kg;
  const S moment = (link.J_B.xx + link.J_B.yy + link.J_B.zz) / S(3);
  end.inverse_moment = moment > S(0) ? S(1) / moment : S(0);
  const bool first = closing.path.empty();
  for (int i = end.link; i >= 0; i = tree_.links()[i].parent) closing.path.push_back(i);
  const bool same_plane = first || closing.plane == constants.plane;
  closing.plane = constants.plane;
  return same_plane;
}

template <class S> bool PlanarLoops<S>::take_rows() {
  for (const JointConstraint<S>& joint : constraints_.joints_) {
    Closing closing;
    closing.lengths = constraints_.size_m_;
    for (int k = 0; k < 2; ++k)
      if (!take_end(k == 0 ? joint.parent : joint.child, joint.anchor[k], closing, closing.end[k])) return false;
    const auto& plane = planar_.planes_[closing.plane];
    for (int k = 0; k < 2; ++k) {  // the place of what is at rest
      End& end = closing.end[k];
      if (end.link >= 0) continue;
      const TiedBody<S> body = constraints_.body_motion(k == 0 ? joint.parent : joint.child);
      const Vec3<S> x = body.p_WB + rotate(body.q_WB, joint.anchor[k]);
      end.point = {dot(x, plane.e1), dot(x, plane.e2)};
      closing.lengths += norm(body.p_WB);
    }
    std::sort(closing.path.begin(), closing.path.end(), std::greater<>());
    closing.path.erase(std::unique(closing.path.begin(), closing.path.end()), closing.path.end());
    closings_.push_back(closing);
  }
  for (const auto& row : constraints_.rows_) {
    if (row.joint < 0) return false;
    const Condition<S>& condition = constraints_.joints_[row.joint].conditions[row.part];
    const auto& plane = planar_.planes_[closings_[row.joint].plane];
    const bool in_plane = condition.kind == ConditionKind::point && nearly_zero(dot(condition.a, plane.normal));
    if (!in_plane && row.chosen) return false;
    if (in_plane)
      equations_.push_back({row.joint, {dot(condition.a, plane.e1), dot(condition.a, plane.e2)}, row.chosen});
  }
  std::stable_partition(equations_.begin(), equations_.end(), [](const Equation& e) { return e.chosen; });
  for (const Equation& equation : equations_) chosen_ += equation.chosen ? 1 : 0;
  return chosen_ > 0;
}

// ---- rates -------------------------------------------------------------------------------------------------------
template <class S> void PlanarLoops<S>::forward_kinematics(const OneState<S>& y) {
  const bool turned = planar_.turn_hinges(y, one_.links.data());
  run_scalar<S>(widest_vectors(), [&]() ATWOOD_INLINED {
    planar_.outward_pass(y, turned, one_.links.data());
    planar_.start_links(one_.links.data());
  });
}

template <class S> void PlanarLoops<S>::forward_kinematics(VectorWidth width, const StateLanes<S>& y) {
  if constexpr (PackOf<S>::in_register)
    in_lanes<S>(width, [&](auto w) ATWOOD_INLINED {
      constexpr VectorWidth at = decltype(w)::value;
      auto* links = lanes_.template at<at>().links.data();
      const auto states = y.template at_width<at>();
      planar_.outward_pass(states, false, links);
      planar_.start_links(links);
    });
}

template <class S> void PlanarLoops<S>::write_poses(const OneState<S>& y, S* to) {
  locate(y, DrivenJoints::from_time, one_);
  S pose[kBodyScalars];
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    write_pose(static_cast<int>(i), one_, pose);
    std::copy(pose, pose + kBodyScalars, to + bodies_[i].body * kBodyScalars);
  }
}

template <class S> void PlanarLoops<S>::write_poses(VectorWidth width, const StateLanes<S>& y, LaneBlock<S>* to) {
  if constexpr (PackOf<S>::in_register)
    in_lanes<S>(width, [&](auto w) ATWOOD_INLINED {
      constexpr VectorWidth at = decltype(w)::value;
      auto& work = lanes_.template at<at>();
      locate(y.template at_width<at>(), DrivenJoints::from_time, work);
      PackAt<S, at> pose[kBodyScalars];
      for (std::size_t i = 0; i < bodies_.size(); ++i) {
        write_pose(static_cast<int>(i), work, pose);
        for (int k = 0; k < kBodyScalars; ++k) store<S>(pose[k], to[bodies_[i].body * kBodyScalars + k].lane);
      }
    });
}

template <class S> void PlanarLoops<S>::apply_loads(const Load<S>* loads) {
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const Load<S>& load = loads[bodies_[i].body];
    apply_load(static_cast<int>(i), load.acceleration_W, load.force_W, load.torque_B, one_);
  }
}

template <class S> void PlanarLoops<S>::apply_loads(VectorWidth width, const LaneBlock<S>* loads) {
  if constexpr (PackOf<S>::in_register)
    in_lanes<S>(width, [&](auto w) ATWOOD_INLINED {
      constexpr VectorWidth at = decltype(w)::value;
      for (std::size_t i = 0; i < bodies_.size(); ++i) {
        const S* load = loads[bodies_[i].body * kLoadScalars].lane;
        const auto three = [&](int c)
                               ATWOOD_INLINED { return load3(load + c * kLaneCount, kLaneCount, WholePack<at>{}); };
        apply_load(static_cast<int>(i), three(0), three(3), three(6), lanes_.template at<at>());
      }
    });
}

template <class S> S PlanarLoops<S>::accelerate(const OneState<S>& y, const Vec3<S>& gravity_W, const S* applied) {
  S least{};
  run_scalar<S>(widest_vectors(), [&]() ATWOOD_INLINED { least = constrain(0, y, gravity_W, applied, one_); });
  return least;
}

template <class S>
LaneBlock<S> PlanarLoops<S>::accelerate(VectorWidth width, const StateLanes<S>& y, const Vec3<S>& gravity_W,
                                        const LaneBlock<S>* applied) {
  LaneBlock<S> least{};
  if constexpr (PackOf<S>::in_register)
    in_lanes<S>(width, [&](auto w) ATWOOD_INLINED {
      constexpr VectorWidth at = decltype(w)::value;
      const LaneValues<PackAt<S, at>> forces{lanes_of(applied)};
      store<S>(constrain(WholePack<at>{}, y.template at_width<at>(), gravity_W, forces, lanes_.template at<at>()),
               least.lane);
    });
  return least;
}

// ---- projection, as in constraints.cpp ---------------------------------------------------------------------------
// What the equations ask of positions and rates at y, in the plane; tolerances as in Constraints::evaluate().
template <class S> void PlanarLoops<S>::set_values(const S* y) {
  const OneState<S> state{S(0), y, unused_.data()};
  planar_.outward_pass(state, false, one_.links.data(), DrivenJoints::from_state);
  planar_.start_links(one_.links.data());
  locate(state, DrivenJoints::from_state, one_);
  const S round_off = S(16) * real::epsilon<S>();
  for (std::size_t e = 0; e < equations_.size(); ++e) {
    const Equation& equation = equations_[e];
    const Closing& closing = closings_[equation.closing];
    Pair gap, speed;
    S lengths = closing.lengths;
    for (int k = 0; k < 2; ++k) {
      const End& end = closing.end[k];
      const S sign = k == 0 ? S(-1) : S(1);
      Pair x = end.point, v{};
      if (end.link >= 0) {
        const LinkPose<S>& pose = one_.poses[end.link];
        const Pair r = arm_of(end, end.point, one_), arm = arm_of(end, end.arm, one_);
        const S w = one_.links[end.link].w, across = bodies_[end.link].across;
        x = {pose.A.x + r.x, pose.A.y + r.y};
        v = {pose.v.x - w * r.y, pose.v.y + w * r.x};
        const Pair centre{x.x - arm.x, x.y - arm.y};
        lengths += real::sqrt(centre.x * centre.x + centre.y * centre.y + across * across);
      }
      gap = {gap.x + sign * x.x, gap.y + sign * x.y};
      speed = {speed.x + sign * v.x, speed.y + sign * v.y};
    }
    value_[e] = gap.x * equation.direction.x + gap.y * equation.direction.y;
    rate_[e] = speed.x * equation.direction.x + speed.y * equation.direction.y;
    tolerance_[e] = round_off * lengths;
  }
}

template <class S> S PlanarLoops<S>::worst_value(bool chosen_alone) const {
  S worst = S(0);
  const std::size_t count = chosen_alone ? static_cast<std::size_t>(chosen_) : equations_.size();
  for (std::size_t e = 0; e < count; ++e) {
    const S value = real::abs(value_[e]) / tolerance_[e];
    if (!(value <= worst) && worst == worst) worst = value;  // also where it is not a number
  }
  return worst;
}

// At the configuration of the last set_values().
template <class S> void PlanarLoops<S>::factor() {
  planar_.inward_pass(no_forces_.data(), 0, one_.links.data());
  compute_inverse_sqrt_D(0, one_);
  for (int e = 0; e < chosen_; ++e) scale_[e] = whiten(0, equations_[e], one_, qr_.column(e));
  qr_.factor(S(1024) * real::epsilon<S>());
}

// Adds to the coordinates, or the rates, the least change that takes `b_` away; at the factors' configuration.
template <class S> void PlanarLoops<S>::change(S* y, bool rates) {
  qr_.solve(b_.data(), z_.data());
  unwhiten(z_.data(), one_, [&](const auto& link, const S& by) { y[rates ? link.at_u : link.at_q] += by; });
}

template <class S> bool PlanarLoops<S>::project_positions(S* y) {
  constexpr int max_iterations = 30;
  SolveReport& report = constraints_.report_;
  report = {};
  set_values(y);
  S before = worst_value(true), best = before;
  for (int n = 0; before > S(1); ++n) {
    report.iterations = n + 1;
    factor();
    for (int e = 0; e < chosen_; ++e) b_[e] = -scale_[e] * value_[e];
    change(y, false);
    set_values(y);
    const S now = worst_value(true);
    report.residual = static_cast<double>(now * S(16) * real::epsilon<S>());
    if (!(now < S(1e30f)) || n == max_iterations) return false;
    if (now > best / S(2) && now <= S(256)) {
      report.ended = now <= S(1) ? SolveEnd::converged : SolveEnd::stagnated;
      return true;
    }
    best = real::min(best, now);
    before = now;
  }
  return true;
}

// Sharpening is one step of Newton's method, of gap / pivot, and opens the gap by about its square: nearer to a
// singular configuration than the root of a rounding that is more than it closes. Where gaps then are beyond their
// tolerance, positions stay as they were, and the report says that they were not sharpened.
template <class S> void PlanarLoops<S>::refine_or_keep(S* y) {
  std::copy(y, y + before_.size(), before_.begin());
  const S most = real::max(S(1), worst_value(true));
  refine_positions(y);
  set_values(y);
  if (worst_value(true) <= most) return;
  std::copy(before_.begin(), before_.end(), y);
  set_values(y);
  constraints_.report_.ended = SolveEnd::stagnated;
  constraints_.report_.residual = static_cast<double>(worst_value(true) * S(16) * real::epsilon<S>());
}

template <class S> bool PlanarLoops<S>::project(S* y) {
  std::copy(y, y + before_.size(), before_.begin());
  const S most = real::sqrt(real::epsilon<S>()) / (S(16) * real::epsilon<S>()) * S(1e-3);
  if (!project_positions(y) || !(worst_value(false) <= most)) {  // more rows may have to be chosen
    std::copy(before_.begin(), before_.end(), y);
    return false;
  }
  constraints_.fault_.clear();
  factor();
  const auto least_pivot = [&] { return qr_.rank() < chosen_ ? S(0) : qr_.pivot(chosen_ - 1); };
  if (least_pivot() < S(kMinPivot)) {
    refine_or_keep(y);
    factor();
  }
  const S least = least_pivot();
  constraints_.typical_pivot_ = real::max(constraints_.typical_pivot_, least);
  for (int e = 0; e < chosen_; ++e) b_[e] = -scale_[e] * rate_[e];
  change(y, true);
  return true;
}

template class PlanarLoops<float>;
template class PlanarLoops<double>;
template class PlanarLoops<long double>;
template class PlanarLoops<Quad>;

}  // namespace atwood
