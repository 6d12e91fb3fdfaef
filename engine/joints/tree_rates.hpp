// The rates of a tree under uniform gravity and forces along its joints: the articulated-body algorithm of
// joints/tree.hpp without what only forces on bodies, constraints and reactions need, of one state or of eight at once.
//
// Each link first moves as if all rates were constant, and falls: alpha0, a0 are the accelerations of its parent's
// motion and of its joint's at u' = 0, relative to free fall, so gravity is an acceleration of the roots. With the
// matrix B = [alpha0] + [w][w] a point of the body at x from A then has the acceleration a0 + B x. The wrench n, f of
// that motion is what the rates' changes have to balance, and no bias is left for the way inwards.
#pragma once

#include "joints/states.hpp"
#include "joints/tree.hpp"

namespace atwood {

template <class S> class TreeRates {
 public:
  explicit TreeRates(const Tree<S>& tree);

  // The rates of the whole state, under the generalised forces `applied` (Tree::rate_count() of them): of one state,
  // and of eight at once with the bits of each (float and double only).
  void rates(const OneState<S>& y, const Vec3<S>& gravity_W, const S* applied);
  void rates(VectorWidth width, const StateLanes<S>& y, const Vec3<S>& gravity_W, const LaneBlock<S>* applied);

 private:
  // As in LinkMotion and Articulated; of a resting body that links hang on: q, R alone differ from 0.
  template <class V> struct Node {
    Quat<V> q;
    Mat3<V> R, B;
    Vec3<V> w, d, alpha, a;  // alpha, a: at constant rates; at last their changes by the rates'
    Sym3<V> J, M;
    Mat3<V> H;
    Vec3<V> n, f;
  };
  template <class V> struct Freedom {
    Vec3<V> s, U_n, U_f;
    V inverse_D, force;  // as in Column
  };
  struct Constants {
    const Link<S>* link;
    bool diagonal;  // J_B
    int parent;     // a node; -1: the root's
    Quat<S> q_root;
  };

  template <class States, class Applied, class V>
  ATWOOD_INLINE void evaluate(const States& y, const Vec3<S>& gravity_W, const Applied& applied, Node<V>* nodes,
                              Freedom<V>* freedoms) const;
  template <class States, class V>
  ATWOOD_INLINE void outward_pass(const Constants& of, const States& y, const Node<V>& parent, Node<V>& m,
                                  Freedom<V>* freedom) const;
  template <class V> ATWOOD_INLINE void start(const Constants& of, Node<V>& m) const;
  template <class Applied, class V>
  ATWOOD_INLINE void inward_pass(const Constants& of, const Applied& applied, Node<V>& m, Freedom<V>* freedom) const;
  template <class V> ATWOOD_INLINE void add_to_parent(const Node<V>& m, Node<V>& to) const;
  template <class States, class V>
  ATWOOD_INLINE void acceleration_pass(const Constants& of, const States& y, const Freedom<V>* freedom, Vec3<V>& alpha,
                                       Vec3<V>& a) const;

  std::vector<Constants> links_;
  std::vector<Node<S>> nodes_;
  std::vector<Freedom<S>> freedoms_;
  template <class V> using Nodes = RegisterVector<Node<V>>;
  template <class V> using Freedoms = RegisterVector<Freedom<V>>;
  WorkInLanes<Nodes, S> node_lanes_;  // float and double
  WorkInLanes<Freedoms, S> freedom_lanes_;
};

}  // namespace atwood
