// Mutual gravity by a tree (Barnes and Hut, Nature 324 (1986) 446): a far group of bodies pulls as its mass and its
// second moments about its centre of mass. O(N log N).
//
// A node of radius b about its centre of mass (no body of it is farther) replaces its bodies where b < opening * d, d
// the distance from that centre to the nearest point of the box around the attracted bodies; otherwise the node is
// opened, and the bodies of a leaf attract one by one. With s from the centre, r from the pulled body to the centre,
// rho^2 = r^2 + eps^2 (Plummer):
//
//   a = G [ r (M / rho^3 + 15/2 r.Q r / rho^7 - 3/2 tr Q / rho^5) - 3 Q r / rho^5 ],     Q = sum m s s^T
//
// which is the exact pull but for terms of third order and more in s. Those are bounded (Salmon and Warren, J. Comput.
// Phys. 111 (1994) 136, eq. 12 to 15: term n of the potential's series pulls with at most (n + 1) G m s^n / d^(n+2)),
// so that for each body
//
//   |error| <= opening^3 (4 - 3 opening) (1 + opening)^2 / (1 - opening)^2  *  sum_j G m_j / (r_ij^2 + eps^2)
//
// The bound is for the worst placement of the bodies; typical errors are hundreds of times smaller.
//
// The tree is built from the positions alone, in index order, and each body's sum runs in the tree's order: the same
// bits at any vector width and number of threads.
#pragma once

#include <cstdint>
#include <vector>

#include "forces/gravity_pairs.hpp"

namespace atwood {

class Team;

// The factor of the error bound above.
double gravity_tree_bound(double opening);

template <class S> class GravityTree {
 public:
  GravityTree(int bodies, int threads);  // allocates what all calls need

  // The accelerations of all bodies by all others, added to `sums`. `team`: at most the `threads` of the constructor;
  // null: one thread.
  void add_gravity(VectorWidth width, const PointMasses<S>& bodies, S softening2_m2, S opening, Team* team,
                   const Accelerations<S>& sums);

  // Interactions computed in the last call
  struct Counts {
    std::int64_t by_node = 0, by_body = 0;
  };
  Counts counts() const;
  int nodes() const { return node_count_; }

 private:
  struct Box {
    S low[3], high[3];
  };
  // Bodies [first, last) in the tree's order; no children: a leaf
  struct Node {
    std::int32_t first, last, child, children;
  };
  // The multipoles of a node: G M, the centre of mass, G Q (xx yy zz xy xz yz); and its radius about the centre.
  struct Moments {
    S GM, centre[3], GQ[6], radius;
  };
  // The interaction list of a group: nodes and bodies not yet summed; one per thread.
  struct List {
    std::int32_t node[256];
    int nodes = 0, from = 0, to = 0;
    Counts counts;
  };

  // gravity_tree_build.cpp
  void sort_bodies(const PointMasses<S>& bodies);
  void build();
  void split(int node);
  void sum_moments();
  void find_centre(int node);
  void find_second_moments(int node);
  Box box_of(int first, int last) const;
  // gravity_tree.cpp
  void pull_group(VectorWidth width, int group, S softening2_m2, S opening, List& list);
  void flush_nodes(VectorWidth width, int group, S softening2_m2, List& list);
  void flush_bodies(VectorWidth width, int group, S softening2_m2, List& list);

  S* row(int n) { return sorted_.data() + static_cast<std::size_t>(n) * padded_; }  // 0 .. 3: x y z Gm; 4 .. 6: sums
  const S* row(int n) const { return sorted_.data() + static_cast<std::size_t>(n) * padded_; }

  int count_, padded_, node_count_ = 0;
  std::vector<std::uint64_t> key_, key_room_;
  std::vector<std::int32_t> order_, order_room_;  // order_[k]: which body is k-th in the tree
  std::vector<S> sorted_;                         // whole blocks, in the tree's order
  std::vector<Node> nodes_;                       // parents before their children, which are adjacent
  std::vector<Box> boxes_;                        // around each node's bodies
  std::vector<Moments> moments_;
  std::vector<List> lists_;
};

}  // namespace atwood
