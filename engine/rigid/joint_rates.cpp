#include "rigid/joint_rates.hpp"

#include <algorithm>

#include "joints/planar_loops.hpp"

namespace atwood {

template <class S>
JointRates<S>::JointRates(RigidModel<S>& model)
    : model_(model), one_(2 * static_cast<std::size_t>(model.state_size())) {
  const Tree<S>& tree = *model.tree_;
  if constexpr (PackOf<S>::in_register) {
    part_.resize(one_.size() + 1);
    applied_lanes_.assign(tree.rate_count(), LaneBlock<S>{});
  }
  if (model.constraints_ != nullptr) return;
  planar_ = PlanarRates<S>::of(tree);
  tree_.emplace(tree);
}

// ---- which rates -------------------------------------------------------------------------------------------------
// Whether bodies feel nothing but uniform gravity and their joints now.
template <class S> bool JointRates<S>::by_joints_alone() const {
  return tree_ && model_.active_.empty() && !model_.holds_;
}

// Whether loops are closed in planes; forces may act on their bodies. Their usual pivot is known from projections.
template <class S> bool JointRates<S>::by_loops() const {
  return model_.project_constraints_ && model_.constraints_ != nullptr && model_.constraints_->planar() != nullptr;
}

template <class S> void JointRates<S>::rate(S t_s, const S* y, S* dydt) {
  const OneState<S> state{t_s, y, dydt};
  if (by_loops() && rate_of_loops(state)) return;
  if (!by_joints_alone()) return model_.rate_of_links(t_s, y, dydt);
  model_.apply_joint_forces(t_s, y);
  if (planar_) planar_->rates(state, model_.gravity_, model_.applied_.data());
  else tree_->rates(state, model_.gravity_, model_.applied_.data());
}

// Eight states at once; of a part of eight, the last state fills the lanes that are left.
template <class S> void JointRates<S>::rates(int count, const S* t_s, const S* y, S* dydt) {
  constexpr int fewest = 3;  // that are worth lanes
  const int size = model_.state_size_;
  const auto one_by_one = [&](int first) {
    S *state = one_.data(), *rate_of_state = state + size;
    for (int k = first; k < count; ++k) {
      for (int i = 0; i < size; ++i) state[i] = y[i * count + k];
      rate(t_s[k], state, rate_of_state);
      for (int i = 0; i < size; ++i) dydt[i * count + k] = rate_of_state[i];
    }
  };
  if constexpr (PackOf<S>::in_register) {
    if (!by_joints_alone() && !(by_loops() && model_.lanes_)) return one_by_one(0);
    for (int first = 0; first < count; first += kLaneCount) {
      const int block = std::min(kLaneCount, count - first);
      if (block < fewest) return one_by_one(first);
      if (block == kLaneCount) {
        rates_in_lanes({t_s + first, y + first, dydt + first, count});
        continue;
      }
      LaneBlock<S>*states = part_.data(), *rates_of_states = states + size + 1;
      const auto fill = [&](LaneBlock<S>& to, const S* from) {
        for (int k = 0; k < kLaneCount; ++k) to.lane[k] = from[std::min(k, block - 1)];
      };
      for (int i = 0; i < size; ++i) fill(states[i], y + i * count + first);
      fill(states[size], t_s + first);
      rates_in_lanes({states[size].lane, states->lane, rates_of_states->lane, kLaneCount});
      for (int i = 0; i < size; ++i)
        std::copy(rates_of_states[i].lane, rates_of_states[i].lane + block, dydt + i * count + first);
    }
  } else {
    one_by_one(0);
  }
}

template <class S> void JointRates<S>::apply_in_lanes(const StateLanes<S>& y) {
  if constexpr (PackOf<S>::in_register) {
    if (model_.joint_forces_->empty()) return;
    for (int k = 0; k < kLaneCount; ++k) {
      for (int i = 0; i < model_.state_size_; ++i) one_[i] = y.y[i * y.stride + k];
      model_.apply_joint_forces(y.t_s[k], one_.data());
      for (std::size_t i = 0; i < model_.applied_.size(); ++i) applied_lanes_[i].lane[k] = model_.applied_[i];
    }
  }
}

template <class S> void JointRates<S>::rates_in_lanes(const StateLanes<S>& y) {
  apply_in_lanes(y);
  if (by_loops()) loops_in_lanes(y);
  else if (planar_) planar_->rates(model_.width_, y, model_.gravity_, applied_lanes_.data());
  else tree_->rates(model_.width_, y, model_.gravity_, applied_lanes_.data());
}

// ---- loops in planes ---------------------------------------------------------------------------------------------
// False: too near to where their constraints lose rank.
template <class S> bool JointRates<S>::rate_of_loops(const OneState<S>& y) {
  PlanarLoops<S>& loops = *model_.constraints_->planar();
  loops.forward_kinematics(y);
  if (!model_.active_.empty()) {
    loops.write_poses(y, model_.placed_.data());
    for (const int i : model_.on_joints_) model_.loads_[i] = {};
    const Motion<S> motion{y.t_s, y.y, model_.slots_.data()};
    for (const ForceTerm<S>* term : model_.active_) term->add_loads(motion, model_.loads_.data());
    loops.apply_loads(model_.loads_.data());
  }
  model_.apply_joint_forces(y.t_s, y.y);
  const S least = loops.accelerate(y, model_.gravity_, model_.applied_.data());
  if (!(least >= S(PlanarLoops<S>::kMinPivot))) return false;
  model_.constraints_->record_pivot(least);
  return true;
}

template <class S> void JointRates<S>::loops_in_lanes(const StateLanes<S>& y) {
  if constexpr (PackOf<S>::in_register) {
    PlanarLoops<S>& loops = *model_.constraints_->planar();
    const VectorWidth width = model_.width_;
    loops.forward_kinematics(width, y);
    if (!model_.active_.empty()) {
      loops.write_poses(width, y, model_.resting_lanes_.data());
      for (const int i : model_.on_joints_)
        std::fill_n(model_.load_lanes_[i * kLoadScalars].lane, kLoadScalars * kLaneCount, S(0));
      const S* resting = lanes_of(model_.resting_lanes_);
      const S* identity = resting + model_.slots_.size() * kBodyScalars * kLaneCount;
      const LaneMotion<S> motion{width, kLaneCount, y.t_s, y.y, y.stride, model_.slots_.data(), resting, identity};
      for (const ForceTerm<S>* term : model_.active_) term->add_lane_loads(motion, lanes_of(model_.load_lanes_));
      loops.apply_loads(width, model_.load_lanes_.data());
    }
    const LaneBlock<S> least = loops.accelerate(width, y, model_.gravity_, applied_lanes_.data());
    for (int k = 0; k < kLaneCount; ++k) {
      if (least.lane[k] >= S(PlanarLoops<S>::kMinPivot)) {
        model_.constraints_->record_pivot(least.lane[k]);
        continue;
      }
      S *state = one_.data(), *rate_of_state = state + model_.state_size_;
      for (int i = 0; i < model_.state_size_; ++i) state[i] = y.y[i * y.stride + k];
      model_.rate_of_links(y.t_s[k], state, rate_of_state);
      for (int i = 0; i < model_.state_size_; ++i) y.dydt[i * y.stride + k] = rate_of_state[i];
    }
  }
}

template class JointRates<float>;
template class JointRates<double>;
template class JointRates<long double>;
template class JointRates<Quad>;

}  // namespace atwood
