// The rates of several states of one scene at once: what rate.cpp computes, one state per lane, with the same bits.
#include <algorithm>

#include "forces/lanes.hpp"
#include "rigid/model.hpp"

namespace atwood {
namespace {

// Where the lanes of a call are: scalar i of lane k at y[i * stride + k], load c of body i at load[(9 i + c) 8 + k].
template <class S> struct Lanes {
  int count;
  std::ptrdiff_t stride;
  const S* y;
  S *dydt, *load;
  const Slot<S>* slots;
  const MassProperties<S>* mass;
  const std::vector<int>& moving;
};

template <VectorWidth width, class S> ATWOOD_INLINE void start(const Lanes<S>& lanes, const Vec3<S>& gravity) {
  for (const int i : lanes.moving) {
    S* load = lanes.load + i * kLoadScalars * kLaneCount;
    const auto zero = broadcast_at<width>(S(0));
    store<S>(broadcast_at<width>(gravity.x), load);
    store<S>(broadcast_at<width>(gravity.y), load + kLaneCount);
    store<S>(broadcast_at<width>(gravity.z), load + 2 * kLaneCount);
    for (int c = 3; c < 6; ++c) store<S>(zero, load + c * kLaneCount);
    if (lanes.slots[i].rotates)
      for (int c = 6; c < kLoadScalars; ++c) store<S>(zero, load + c * kLaneCount);
  }
}

// Newton and Euler, as in rate.cpp.
template <VectorWidth width, class S> ATWOOD_INLINE void move(const Lanes<S>& lanes) {
  const std::ptrdiff_t stride = lanes.stride;
  for (const int i : lanes.moving) {
    const S* load = lanes.load + i * kLoadScalars * kLaneCount;
    const S* y = lanes.y + lanes.slots[i].offset * stride;
    S* dydt = lanes.dydt + lanes.slots[i].offset * stride;
    const MassProperties<S>& mass = lanes.mass[i];
    const S inverse_mass = mass.inverse_mass_per_kg;
    for_packs<S, width>(lanes.count, [&](auto k) ATWOOD_INLINED {
      store3(load3(y + kAtVelocity * stride, stride, k), dydt, stride, k);
      const auto acceleration = load3(load, kLaneCount, k), force = load3(load + 3 * kLaneCount, kLaneCount, k);
      store3(acceleration + inverse_mass * force, dydt + kAtVelocity * stride, stride, k);
    });
    if (!lanes.slots[i].rotates) continue;
    for_packs<S, width>(lanes.count, [&](auto k) ATWOOD_INLINED {
      const auto w = load3(y + kAtBodyRate * stride, stride, k);
      const auto torque = load3(load + 6 * kLaneCount, kLaneCount, k);
      store4(quaternion_rate(load4(y + kAtAttitude * stride, stride, k), w, S(0.5)), dydt + kAtAttitude * stride,
             stride, k);
      store3(mass.times_inverse_inertia(torque - cross(w, mass.times_inertia(w))), dydt + kAtBodyRate * stride, stride,
             k);
    });
  }
}

}  // namespace

template <class S> void RigidModel<S>::rates_of(void* context, int count, const S* t_s, const S* y, S* dydt) {
  RigidModel& model = *static_cast<RigidModel*>(context);
  if (!model.lanes_) {
    S *state = model.one_.data(), *rate = state + model.state_size_;
    for (int k = 0; k < count; ++k) {
      for (int i = 0; i < model.state_size_; ++i) state[i] = y[i * count + k];
      rate_of(context, t_s[k], state, rate);
      for (int i = 0; i < model.state_size_; ++i) dydt[i * count + k] = rate[i];
    }
    return;
  }
  if (model.holds_)
    for (int i = 0; i < model.state_size_ * count; ++i) dydt[i] = S(0);  // held bodies do not move
  for (int first = 0; first < count; first += kLaneCount) {
    const int block = std::min(kLaneCount, count - first);
    const Lanes<S> lanes{block,
                         count,
                         y + first,
                         dydt + first,
                         lanes_of(model.load_lanes_),
                         model.slots_.data(),
                         model.mass_.data(),
                         model.moving_};
    in_lanes<S>(model.width_, [&](auto width) ATWOOD_INLINED { start<decltype(width)::value>(lanes, model.gravity_); });
    const S* resting = lanes_of(model.resting_lanes_);
    const LaneMotion<S> motion{model.width_, block,
                               t_s + first,  y + first,
                               count,        model.slots_.data(),
                               resting,      resting + model.slots_.size() * kBodyScalars * kLaneCount};
    for (const ForceTerm<S>* term : model.active_) term->add_lane_loads(motion, lanes.load);
    in_lanes<S>(model.width_, [&](auto width) ATWOOD_INLINED { move<decltype(width)::value>(lanes); });
  }
}

template void RigidModel<float>::rates_of(void*, int, const float*, const float*, float*);
template void RigidModel<double>::rates_of(void*, int, const double*, const double*, double*);
template void RigidModel<long double>::rates_of(void*, int, const long double*, const long double*, long double*);
template void RigidModel<Quad>::rates_of(void*, int, const Quad*, const Quad*, Quad*);

}  // namespace atwood
