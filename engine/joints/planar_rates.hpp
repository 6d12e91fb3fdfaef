// Trees that move in planes: all hinges of a mechanism have parallel axes, its sliders move across them, and its root
// does not move. Forces normal to the plane and moments within it cause reactions only, and of the inertia only the
// moment about the axis of the hinges counts, so the articulated-body algorithm of joints/tree.hpp works with vectors
// of two components: an inertia about a point is a moment J, a coupling h and a 2x2 mass M,
//   n = J alpha + h . a + n0        f = alpha h + M a + f0
// Eliminating a hinge leaves neither J nor h: only M - h h^T / J.
#pragma once

#include <optional>
#include <vector>

#include "joints/states.hpp"
#include "joints/tree.hpp"

namespace atwood {

template <class S> class PlanarLoops;

template <class S> class PlanarRates {
 public:
  // Empty where some mechanism of the tree does not move in a plane to the round-off of S, or a body is free.
  static std::optional<PlanarRates> of(const Tree<S>& tree);

  // The rates of the joints' part of the state, under uniform gravity and the generalised forces `applied`
  // (Tree::rate_count() of them): of one state, and of eight at once with the bits of each (float and double only).
  void rates(const OneState<S>& y, const Vec3<S>& gravity_W, const S* applied);
  void rates(VectorWidth width, const StateLanes<S>& y, const Vec3<S>& gravity_W, const LaneBlock<S>* applied);

 private:
  template <class V> struct Pair { V x{}, y{}; };
  using Vec2 = Pair<S>;
  struct Constants {
    int parent, at_q, at_u, rate, plane;
    bool turns, slides, driven;
    S sign;  // of a hinge's axis along the plane's normal
    Vec2 from_parent, to_centre, axis;
    S mass, J, driven_start, driven_rate;
  };
  template <class V> struct State {
    Pair<V> z;               // (cos, sin) of the link's angle
    Pair<V> d;               // A less the parent's A [m]
    V offset, speed;         // of a slider
    Pair<V> s;               // a slider's axis
    Pair<V> c;               // bias of a [m/s^2]
    V w;                     // angular velocity [rad/s]
    V J;                     // articulated moment of inertia about A [kg m^2]
    V Mxx, Mxy, Myy;         // articulated mass [kg]
    V n;                     // bias moment about A [N m]
    Pair<V> h;               // coupling [kg m]
    Pair<V> f;               // bias force [N]
    V inverse_D, force, Un;  // of the rate's elimination: as in Column; Un, Uf: U
    Pair<V> Uf;
    V alpha;    // angular acceleration [rad/s^2]
    Pair<V> a;  // acceleration of A, relative to free fall [m/s^2]
  };
  struct Plane {
    Vec3<S> e1, e2, normal;
  };

  int plane_across(const Vec3<S>& normal);
  bool add_link(const Tree<S>& tree, int i, std::vector<Quat<S>>& attitudes);
  friend class PlanarLoops<S>;
  template <class States>
  ATWOOD_INLINE static auto coordinate(const Constants& link, const States& y, DrivenJoints driven) ->
      typename States::Value;
  bool turn_hinges(const OneState<S>& y, State<S>* state, DrivenJoints driven = DrivenJoints::from_time) const;
  template <class States, class V>
  ATWOOD_INLINE void outward_pass(const States& y, bool turned, State<V>* state,
                                  DrivenJoints driven = DrivenJoints::from_time) const;
  template <class V> ATWOOD_INLINE void start_link(int i, State<V>* state) const;
  template <class V> ATWOOD_INLINE void start_links(State<V>* state) const;
  template <class Applied, class V>
  ATWOOD_INLINE void inward_pass(const Applied& applied, int started, State<V>* state) const;
  template <class States, class V>
  ATWOOD_INLINE void acceleration_pass(const States& y, const Vec3<S>& gravity_W, State<V>* state) const;

  std::vector<Constants> links_;
  std::vector<int> hinges_;  // links
  std::vector<State<S>> state_;
  template <class V> using LinkStates = RegisterVector<State<V>>;
  WorkInLanes<LinkStates, S> lanes_;  // float and double
  std::vector<Plane> planes_;
};

}  // namespace atwood
