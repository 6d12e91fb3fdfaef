#include "rigid/joint_rates.hpp"

#include <algorithm>
#include <map>
#include <mutex>

#include "joints/planar_loops.hpp"

namespace atwood {

template <class S>
JointRates<S>::JointRates(const MechanismParts<S>& parts)
    : parts_(parts), model_(parts.system), applied_(parts.tree.rate_count()),
      one_(2 * static_cast<std::size_t>(parts.state_size)) {
  if constexpr (PackOf<S>::in_register) {
    part_.resize(one_.size() + 1);
    applied_lanes_.assign(applied_.size(), broadcast(S(0)));
  }
  if (parts.constraints != nullptr) return;
  planar_ = PlanarRates<S>::of(parts.tree);
  tree_.emplace(parts.tree);
}

// ---- the functions of a system ----------------------------------------------------------------------------------------
namespace {

// Of every model that has mechanisms, by its system; models may be made in several threads.
template <class S> struct Registry {
  std::mutex mutex;
  std::map<const System<S>*, std::unique_ptr<JointRates<S>>> rates;
};
template <class S> Registry<S>& registry() {
  static Registry<S> all;
  return all;
}

}  // namespace

template <class S> void JointRates<S>::take(const MechanismParts<S>& parts) {
  auto rates = std::make_unique<JointRates>(parts);
  System<S>& system = parts.system;
  system.context = rates.get();
  system.rate_of = &JointRates::rate_of;
  system.rates_of = &JointRates::rates_of;
  if (system.project_of != nullptr) system.project_of = &JointRates::project_of;
  if (system.projection_of != nullptr) system.projection_of = &JointRates::projection_of;
  const std::lock_guard lock(registry<S>().mutex);
  registry<S>().rates[&system] = std::move(rates);
}

template <class S> void JointRates<S>::forget(const System<S>& system) {
  const std::lock_guard lock(registry<S>().mutex);
  registry<S>().rates.erase(&system);
}

template <class S> void JointRates<S>::rate_of(void* context, S t_s, const S* y, S* dydt) {
  static_cast<JointRates*>(context)->rate(t_s, y, dydt);
}
template <class S> void JointRates<S>::rates_of(void* context, int count, const S* t_s, const S* y, S* dydt) {
  static_cast<JointRates*>(context)->rates(count, t_s, y, dydt);
}
template <class S> void JointRates<S>::project_of(void* context, S* y) {
  static_cast<JointRates*>(context)->model_.project(y);
}
template <class S> void JointRates<S>::projection_of(void* context, const S* y, S* change) {
  const System<S>& model = static_cast<JointRates*>(context)->model_;
  model.projection_of(model.context, y, change);
}

// ---- which rates ----------------------------------------------------------------------------------------------------------
// Whether bodies feel nothing but uniform gravity and their joints now.
template <class S> bool JointRates<S>::by_joints_alone() const {
  return tree_ && parts_.active.empty() && !parts_.holds;
}

// Whether loops are closed in planes; forces may act on their bodies. Projections are what tells the usual pivot then.
template <class S> bool JointRates<S>::by_loops() const {
  return parts_.projects && parts_.constraints != nullptr && parts_.constraints->planar() != nullptr;
}

template <class S> void JointRates<S>::apply(S t_s, const S* y) {
  if (parts_.joint_forces.empty()) return;
  std::fill(applied_.begin(), applied_.end(), S(0));
  parts_.joint_forces.add(parts_.tree, t_s, y, applied_.data());
}

template <class S> void JointRates<S>::rate(S t_s, const S* y, S* dydt) {
  const OneState<S> state{t_s, y, dydt};
  if (by_loops() && rate_of_loops(state)) return;
  if (!by_joints_alone()) return rate_of_model(t_s, y, dydt);
  apply(t_s, y);
  if (planar_) planar_->rates(state, parts_.gravity, applied_.data());
  else tree_->rates(state, parts_.gravity, applied_.data());
}

// Eight states at once; of a part of eight, the last state fills the lanes that are left.
template <class S> void JointRates<S>::rates(int count, const S* t_s, const S* y, S* dydt) {
  constexpr int fewest = 3;  // that are worth lanes
  const int size = parts_.state_size;
  const auto one_by_one = [&](int first) {
    S *state = one_.data(), *rate_of_state = state + size;
    for (int k = first; k < count; ++k) {
      for (int i = 0; i < size; ++i) state[i] = y[i * count + k];
      rate(t_s[k], state, rate_of_state);
      for (int i = 0; i < size; ++i) dydt[i * count + k] = rate_of_state[i];
    }
  };
  if constexpr (PackOf<S>::in_register) {
    if (!by_joints_alone() && !(by_loops() && parts_.lanes)) return one_by_one(0);
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
    if (parts_.joint_forces.empty()) return;
    for (int k = 0; k < kLaneCount; ++k) {
      for (int i = 0; i < parts_.state_size; ++i) one_[i] = y.y[i * y.stride + k];
      apply(y.t_s[k], one_.data());
      for (std::size_t i = 0; i < applied_.size(); ++i) applied_lanes_[i][k] = applied_[i];
    }
  }
}

template <class S> void JointRates<S>::rates_in_lanes(const StateLanes<S>& y) {
  apply_in_lanes(y);
  if (by_loops()) loops_in_lanes(y);
  else if (planar_) planar_->rates(parts_.width, y, parts_.gravity, applied_lanes_.data());
  else tree_->rates(parts_.width, y, parts_.gravity, applied_lanes_.data());
}

// ---- loops in planes ----------------------------------------------------------------------------------------------------
// False: too near to where their constraints lose rank.
template <class S> bool JointRates<S>::rate_of_loops(const OneState<S>& y) {
  PlanarLoops<S>& loops = *parts_.constraints->planar();
  loops.move(y);
  if (!parts_.active.empty()) {
    loops.place(y, parts_.placed.data());
    for (const int i : parts_.on_joints) parts_.loads[i] = {};
    const Motion<S> motion{y.t_s, y.y, parts_.slots.data()};
    for (const ForceTerm<S>* term : parts_.active) term->add_loads(motion, parts_.loads.data());
    loops.bear(parts_.loads.data());
  }
  apply(y.t_s, y.y);
  const S least = loops.accelerate(y, parts_.gravity, applied_.data());
  if (!(least >= S(PlanarLoops<S>::kLeastPivot))) return false;
  parts_.constraints->note_pivot(least);
  return true;
}

template <class S> void JointRates<S>::loops_in_lanes(const StateLanes<S>& y) {
  if constexpr (PackOf<S>::in_register) {
    PlanarLoops<S>& loops = *parts_.constraints->planar();
    const VectorWidth width = parts_.width;
    loops.move(width, y);
    if (!parts_.active.empty()) {
      loops.place(width, y, parts_.resting_lanes.data());
      for (const int i : parts_.on_joints)
        std::fill_n(parts_.load_lanes[i * kLoadScalars].lane, kLoadScalars * kLaneCount, S(0));
      const S* resting = lanes_of(parts_.resting_lanes);
      const S* identity = resting + parts_.slots.size() * kBodyScalars * kLaneCount;
      const LaneMotion<S> motion{width, kLaneCount, y.t_s, y.y, y.stride, parts_.slots.data(), resting, identity};
      for (const ForceTerm<S>* term : parts_.active) term->add_lane_loads(motion, lanes_of(parts_.load_lanes));
      loops.bear(width, parts_.load_lanes.data());
    }
    const LaneBlock<S> least = loops.accelerate(width, y, parts_.gravity, applied_lanes_.data());
    for (int k = 0; k < kLaneCount; ++k) {
      if (least.lane[k] >= S(PlanarLoops<S>::kLeastPivot)) {
        parts_.constraints->note_pivot(least.lane[k]);
        continue;
      }
      S *state = one_.data(), *rate_of_state = state + parts_.state_size;
      for (int i = 0; i < parts_.state_size; ++i) state[i] = y.y[i * y.stride + k];
      rate_of_model(y.t_s[k], state, rate_of_state);
      for (int i = 0; i < parts_.state_size; ++i) y.dydt[i * y.stride + k] = rate_of_state[i];
    }
  }
}

template class JointRates<float>;
template class JointRates<double>;
template class JointRates<long double>;
template class JointRates<Quad>;

}  // namespace atwood
