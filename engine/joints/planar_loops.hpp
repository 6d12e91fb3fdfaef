// Loops of trees that move in planes, closed by hinges across the plane: the equations of joints/constraints.hpp, of
// which every closing leaves two, in vectors of two components.
//
// Rates are solved for by a QR factorisation of W G^T in the order of the rows, of one state or of eight at once. Where
// a pivot is below kMinPivot, rows may be dependent, and the pivoted factorisation of constraints.hpp has to take
// over; both give the same accelerations elsewhere. Projections use the pivoted one. A gap of round-off turns links by
// itself over the pivot, and their rates by that over the pivot once more; so below kMinPivot a projection of float
// or double positions ends with a step by gaps of a wider scalar.
#pragma once

#include <memory>
#include <type_traits>

#include "joints/constraints.hpp"
#include "joints/planar_rates.hpp"

namespace atwood {

template <class S> class PlanarLoops {
 public:
  static constexpr double kMinPivot = 0.05;

  // Null where some mechanism does not move in a plane, or is tied by anything but hinges across it that close loops.
  // The kinematics of `tree` are those of some state; `constraints` has chosen its rows.
  static std::unique_ptr<PlanarLoops> of(Tree<S>& tree, Constraints<S>& constraints);

  // ---- rates, in this order; V: S, or the pack of float or double at the kernel's width
  // Kinematics at (t, y), where the rates of the coordinates are written.
  void forward_kinematics(const OneState<S>& y);
  void forward_kinematics(VectorWidth width, const StateLanes<S>& y);
  // For forces on bodies: p v q w of each link's body, as Tree::write_body gives them, scalar i of body b at
  // to[b kBodyScalars + i]; and the loads that act on it (forces/force.hpp), without uniform gravity. At the same
  // state.
  void write_poses(const OneState<S>& y, S* to);
  void write_poses(VectorWidth width, const StateLanes<S>& y, LaneBlock<S>* to);
  void apply_loads(const Load<S>* loads);
  void apply_loads(VectorWidth width, const LaneBlock<S>* loads);
  // The rates' accelerations under the constraints; the least pivot of one state, and of each of eight.
  S accelerate(const OneState<S>& y, const Vec3<S>& gravity_W, const S* applied);
  LaneBlock<S> accelerate(VectorWidth width, const StateLanes<S>& y, const Vec3<S>& gravity_W,
                          const LaneBlock<S>* applied);

  // Constraints::project(); false, and y as it was: the constraints have to do it.
  bool project(S* y);

 private:
  using Pair = typename PlanarRates<S>::Vec2;
  template <class V> using PairOf = typename PlanarRates<S>::template Pair<V>;
  template <class V> using State = typename PlanarRates<S>::template State<V>;
  struct End {
    int link = -1;                                 // -1: at rest, `point` in the axes of the plane
    Pair point;                                    // from A to the anchor, at coordinates 0
    Pair arm;                                      // from the centre of mass to the anchor
    S across{}, inverse_mass{}, inverse_moment{};  // across: the arm along the normal
  };
  struct Closing {
    End end[2];
    int plane = 0;
    S lengths{};            // that do not change, of the tolerances
    std::vector<int> path;  // links from both ends to the roots, outermost first
  };
  struct Equation {
    int closing = 0;
    Pair direction;
    bool chosen = false;
  };
  struct Body {  // of a link
    int body = 0;
    Pair origin;  // of the plane's axes, of a root
    S across{};   // the centre of mass along the normal
    Quat<S> attitude;
    Vec3<S> normal_B;
  };
  template <class V> struct Twist {
    V n{};
    PairOf<V> f;
  };
  template <class V> struct LinkPose {
    V angle{};
    PairOf<V> A, v;
  };
  using WideScalar = std::conditional_t<std::is_same_v<S, long double>, Quad, long double>;
  struct WideLinkPose {
    WideScalar angle{}, cosine = WideScalar(1), sine{}, x{}, y{};  // x, y: of the link's point A
    void turn(const Pair& v, WideScalar& along, WideScalar& across) const {
      along = cosine * WideScalar(v.x) - sine * WideScalar(v.y);
      across = cosine * WideScalar(v.y) + sine * WideScalar(v.x);
    }
  };
  template <class V> struct Work {
    RegisterVector<State<V>> links;
    RegisterVector<LinkPose<V>> poses;
    RegisterVector<Twist<V>> twists;
    RegisterVector<V> root, column, diagonal, reflected, size, b, z;

    void resize(std::size_t links_count, std::size_t rates, std::size_t equations);
  };

  PlanarLoops(Tree<S>& tree, Constraints<S>& constraints, PlanarRates<S> planar);
  bool take_rows();
  void take_bodies();
  bool take_end(int body, const Vec3<S>& anchor_B, Closing& closing, End& end) const;
  template <class V> ATWOOD_INLINE PairOf<V> arm_of(const End& end, const Pair& v, const Work<V>& work) const;
  template <class States, class V> ATWOOD_INLINE void locate(const States& y, DrivenJoints driven, Work<V>& work) const;
  template <class V> ATWOOD_INLINE void write_pose(int i, const Work<V>& work, V (&to)[kBodyScalars]) const;
  template <class V>
  ATWOOD_INLINE void apply_load(int i, const Vec3<V>& acceleration_W, const Vec3<V>& force_W, const Vec3<V>& torque_B,
                                Work<V>& work) const;
  template <class K, class V> ATWOOD_INLINE void compute_inverse_sqrt_D(K lane, Work<V>& work) const;
  template <class K, class V> ATWOOD_INLINE V whiten(K lane, const Equation& equation, Work<V>& work, V* column) const;
  template <class V, class F> ATWOOD_INLINE void unwhiten(const V* z, Work<V>& work, const F& add) const;
  template <class V>
  ATWOOD_INLINE V acceleration_along(const Equation& equation, const Vec3<S>& gravity_W, const Work<V>& work) const;
  template <class K, class V> ATWOOD_INLINE V factor_in_order(K lane, int count, Work<V>& work) const;
  template <class V> ATWOOD_INLINE void solve_in_order(int count, Work<V>& work) const;
  template <class K, class States, class Applied, class V>
  ATWOOD_INLINE V constrain(K lane, const States& y, const Vec3<S>& gravity_W, const Applied& applied,
                            Work<V>& work) const;
  void set_values(const S* y);
  void refine_positions(S* y);
  void refine_or_keep(S* y);
  S worst_value(bool chosen_alone) const;
  void factor();
  void change(S* y, bool rates);
  bool project_positions(S* y);

  Tree<S>& tree_;
  Constraints<S>& constraints_;
  PlanarRates<S> planar_;
  std::vector<Body> bodies_;  // by link
  std::vector<Closing> closings_;
  std::vector<Equation> equations_;  // the chosen ones first
  int chosen_ = 0, rates_ = 0;
  Work<S> one_;
  WorkInLanes<Work, S> lanes_;  // float and double
  // of projections
  LeastNorm<S> qr_;
  std::vector<WideLinkPose> wide_poses_;
  std::vector<S> value_, tolerance_, rate_, scale_, before_, unused_, no_forces_, b_, z_;
};

}  // namespace atwood
