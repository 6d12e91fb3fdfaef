// The rates of several states of one scene at once: what rate.cpp computes, a state a lane, with the same bits.
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

template <class S> [[gnu::always_inline]] inline void start(const Lanes<S>& lanes, const Vec3<S>& gravity) {
  for (const int i : lanes.moving) {
    S* load = lanes.load + i * load_scalars * lane_count;
    for_lanes(lanes.count, [&](int k) {
      store3(gravity, load + k, lane_count);
      store3(Vec3<S>{}, load + 3 * lane_count + k, lane_count);
    });
    if (lanes.slots[i].rotates)
      for_lanes(lanes.count, [&](int k) { store3(Vec3<S>{}, load + 6 * lane_count + k, lane_count); });
  }
}

// Newton and Euler, as in rate.cpp.
template <class S> [[gnu::always_inline]] inline void move(const Lanes<S>& lanes) {
  const std::ptrdiff_t stride = lanes.stride;
  for (const int i : lanes.moving) {
    const S* load = lanes.load + i * load_scalars * lane_count;
    const S* y = lanes.y + lanes.slots[i].offset * stride;
    S* dydt = lanes.dydt + lanes.slots[i].offset * stride;
    const MassProperties<S>& mass = lanes.mass[i];
    const S inverse_mass = mass.inverse_mass_per_kg;
    for_lanes(lanes.count, [&](int k) {
      store3(load3(y + at_velocity * stride + k, stride), dydt + k, stride);
      const Vec3<S> acceleration = load3(load + k, lane_count), force = load3(load + 3 * lane_count + k, lane_count);
      store3(acceleration + inverse_mass * force, dydt + at_velocity * stride + k, stride);
    });
    if (!lanes.slots[i].rotates) continue;
    for_lanes(lanes.count, [&](int k) {
      const Vec3<S> w = load3(y + at_body_rate * stride + k, stride);
      const Vec3<S> torque = load3(load + 6 * lane_count + k, lane_count);
      store4(quaternion_rate(load4(y + at_attitude * stride + k, stride), w), dydt + at_attitude * stride + k, stride);
      store3(mass.times_inverse_inertia(torque - cross(w, mass.times_inertia(w))), dydt + at_body_rate * stride + k,
             stride);
    });
  }
}

ATWOOD_VECTOR_WIDTHS void start_lanes(const Lanes<float>& lanes, const Vec3<float>& gravity) { start(lanes, gravity); }
ATWOOD_VECTOR_WIDTHS void start_lanes(const Lanes<double>& lanes, const Vec3<double>& gravity) { start(lanes, gravity); }
void start_lanes(const Lanes<long double>& lanes, const Vec3<long double>& gravity) { start(lanes, gravity); }
void start_lanes(const Lanes<Quad>& lanes, const Vec3<Quad>& gravity) { start(lanes, gravity); }

ATWOOD_VECTOR_WIDTHS void move_lanes(const Lanes<float>& lanes) { move(lanes); }
ATWOOD_VECTOR_WIDTHS void move_lanes(const Lanes<double>& lanes) { move(lanes); }
void move_lanes(const Lanes<long double>& lanes) { move(lanes); }
void move_lanes(const Lanes<Quad>& lanes) { move(lanes); }

}  // namespace

template <class S>
void RigidModel<S>::rates_of(void* context, int count, const S* t_s, const S* y, S* dydt) {
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
  if (model.moving_.size() < model.slots_.size())
    for (int i = 0; i < model.state_size_ * count; ++i) dydt[i] = S(0);  // held bodies do not move
  for (int first = 0; first < count; first += lane_count) {
    const int block = std::min(lane_count, count - first);
    const Lanes<S> lanes{block, count, y + first, dydt + first, lanes_of(model.load_lanes_), model.slots_.data(),
                         model.mass_.data(), model.moving_};
    start_lanes(lanes, model.gravity_);
    const S* resting = lanes_of(model.resting_lanes_);
    const LaneMotion<S> motion{block, t_s + first, y + first, count, model.slots_.data(), resting,
                               resting + model.slots_.size() * body_scalars * lane_count};
    for (const ForceTerm<S>* term : model.active_) term->add_lane_loads(motion, lanes.load);
    move_lanes(lanes);
  }
}

template void RigidModel<float>::rates_of(void*, int, const float*, const float*, float*);
template void RigidModel<double>::rates_of(void*, int, const double*, const double*, double*);
template void RigidModel<long double>::rates_of(void*, int, const long double*, const long double*, long double*);
template void RigidModel<Quad>::rates_of(void*, int, const Quad*, const Quad*, Quad*);

}  // namespace atwood
