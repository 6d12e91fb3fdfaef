// Loads of several states at once, one state per lane. A force writes its law once, for motions and loads of one state
// or of lanes. law() looks up the bodies of an item and returns a function of the lane k (an int, or all lanes together
// if the law accepts any type of k); it captures by value: the compiler then knows that no lane changes the captures,
// and copies no struct through memory.
//
//   template <class S> struct AttractorTerm final : ForceTerm<S> {
//     std::vector<int> bodies;
//     static constexpr Items items = Items::bodies;
//     template <class M, class L> ATWOOD_INLINE auto law(int item, const M& motion, const L& loads) const {
//       return [body = motion.body(bodies[item]), load = loads.body(bodies[item]), mu = mu](auto k) ATWOOD_INLINED {
//         load.acceleration_W(k) -= mu * body.p_WB(k) ...
//       };
//     }
//     ATWOOD_ONE_LAW
//   };
#pragma once

#include "forces/force.hpp"
#include "math/pack.hpp"

namespace atwood {

// ---- one state: the only lane is 0 ------------------------------------------------------------------------------
template <class S> struct OneBody {
  const S* at;
  bool rotates;
  Vec3<S> p_WB(int) const { return load3(at); }
  Vec3<S> v_WB(int) const { return load3(at + 3); }
  Quat<S> q_WB(int) const { return rotates ? load4(at + 6) : Quat<S>{}; }
  Vec3<S> w_WB_B(int) const { return rotates ? load3(at + 10) : Vec3<S>{}; }
};
template <class S> struct OneLoad {
  Load<S>* load;
  Vec3<S>& acceleration_W(int) const { return load->acceleration_W; }
  Vec3<S>& force_W(int) const { return load->force_W; }
  Vec3<S>& torque_B(int) const { return load->torque_B; }
};
template <class S> struct OneMotion {
  const Motion<S>& motion;
  const S* t_s;
  OneBody<S> body(int i) const { return {motion.of(i), motion.slots[i].rotates}; }
};
template <class S> struct OneLoads {
  Load<S>* loads;
  OneLoad<S> body(int i) const { return {loads + i}; }
};

// ---- lanes ------------------------------------------------------------------------------------------------------
// K: the number of a lane, or WholePack.
template <class S> struct BodyLanes {
  const S *at, *turn;  // a body without attitude: `turn` is the identity at rest
  std::ptrdiff_t stride, turn_stride;
  template <class K> ATWOOD_INLINE auto p_WB(K k) const { return load3(at, stride, k); }
  template <class K> ATWOOD_INLINE auto v_WB(K k) const { return load3(at + 3 * stride, stride, k); }
  template <class K> ATWOOD_INLINE auto q_WB(K k) const { return load4(turn, turn_stride, k); }
  template <class K> ATWOOD_INLINE auto w_WB_B(K k) const { return load3(turn + 4 * turn_stride, turn_stride, k); }
};
template <class S, class K> struct Vec3OfLane {
  S* at;
  K k;
  template <class V> ATWOOD_INLINE void operator+=(const Vec3<V>& b) const {
    store3(load3(at, kLaneCount, k) + b, at, kLaneCount, k);
  }
  template <class V> ATWOOD_INLINE void operator-=(const Vec3<V>& b) const {
    store3(load3(at, kLaneCount, k) - b, at, kLaneCount, k);
  }
};
template <class S> struct LoadLanes {
  S* at;
  template <class K> ATWOOD_INLINE Vec3OfLane<S, K> acceleration_W(K k) const { return {at, k}; }
  template <class K> ATWOOD_INLINE Vec3OfLane<S, K> force_W(K k) const { return {at + 3 * kLaneCount, k}; }
  template <class K> ATWOOD_INLINE Vec3OfLane<S, K> torque_B(K k) const { return {at + 6 * kLaneCount, k}; }
};
template <class S> struct MotionLanes {
  const LaneMotion<S>& motion;
  const S* t_s;
  ATWOOD_INLINE BodyLanes<S> body(int i) const {
    const Slot<S>& slot = motion.slots[i];
    const std::ptrdiff_t stride = slot.resting ? kLaneCount : motion.stride;
    const S* at = slot.resting ? motion.resting + i * kBodyScalars * kLaneCount : motion.y + slot.offset * stride;
    if (slot.rotates) return {at, at + 6 * stride, stride, stride};
    return {at, motion.identity_pose + 6 * kLaneCount, stride, kLaneCount};
  }
};
template <class S> struct LoadsLanes {
  S* loads;
  ATWOOD_INLINE LoadLanes<S> body(int i) const { return {loads + i * kLoadScalars * kLaneCount}; }
};

// ---- both -------------------------------------------------------------------------------------------------------
// A force at a point of a body: the load through the centre of mass, and its moment.
template <class L, class S>
void add_force_at(const L& load, int k, const Quat<S>& q_WB, const Vec3<S>& point_B, const Vec3<S>& force_W) {
  load.force_W(k) += force_W;
  load.torque_B(k) += cross(point_B, rotate_back(q_WB, force_W));
}

// f(item...) for what the law of a force acts on.
enum class Items { the_force, bodies, pairs };
template <class Term, class F> ATWOOD_INLINE void for_items(const Term& term, const F& f) {
  if constexpr (Term::items == Items::the_force) {
    f();
  } else {
    const int count = static_cast<int>(term.bodies.size());
    for (int a = 0; a < count; ++a) {
      if constexpr (Term::items == Items::bodies) f(a);
      else
        for (int b = a + 1; b < count; ++b) f(a, b);
    }
  }
}

template <class Term, class S> void add_loads_of_one(const Term& term, const Motion<S>& motion, Load<S>* loads) {
  const OneMotion<S> one{motion, &motion.t_s};
  for_items(term, [&](auto... item) { term.law(item..., one, OneLoads<S>{loads})(0); });
}
template <VectorWidth width, class Term, class S>
ATWOOD_INLINE void add_loads_of_lanes(const Term& term, const LaneMotion<S>& motion, S* loads) {
  const MotionLanes<S> lanes{motion, motion.t_s};
  for_items(term, [&](auto... item) ATWOOD_INLINED {
    const auto law = term.law(item..., lanes, LoadsLanes<S>{loads});
    if constexpr (PackOf<S>::in_register)
      if constexpr (std::is_invocable_v<decltype(law), WholePack<width>>) return for_packs<S, width>(motion.count, law);
    for_lanes(motion.count, law);
  });
}

}  // namespace atwood

#define ATWOOD_ONE_LAW                                                                                                 \
  void add_loads(const Motion<S>& motion, Load<S>* loads) const override { add_loads_of_one(*this, motion, loads); }   \
  bool has_lanes() const override { return true; }                                                                     \
  void add_lane_loads(const LaneMotion<S>& motion, S* loads) const override {                                          \
    in_lanes<S>(motion.width,                                                                                          \
                [&](auto width) ATWOOD_INLINED { add_loads_of_lanes<decltype(width)::value>(*this, motion, loads); }); \
  }
