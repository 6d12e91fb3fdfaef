#include "forces/gravity_tree.hpp"

#include <algorithm>
#include <cmath>

#include "math/scalar.hpp"
#include "parallel/team.hpp"

namespace atwood {
namespace {

constexpr int kMinShared = 1000;              // bodies
constexpr int kGroupBlocks = 2;               // blocks of bodies that share one interaction list
constexpr int kMaxWaiting = 7 * 3 * 21 + 64;  // stack of a walk: seven siblings per level, and a reserve

// The pull of nodes on the bodies of a block, as in the header's equation.
template <class Moments, class S>
ATWOOD_INLINE void pull_block(const Moments* nodes, const std::int32_t* list, int count, S softening2, const S* x,
                              const S* y, const S* z, S* ax, S* ay, S* az) {
  S at_x[kGravityBlock], at_y[kGravityBlock], at_z[kGravityBlock], sum_x[kGravityBlock], sum_y[kGravityBlock],
      sum_z[kGravityBlock];
  for (int l = 0; l < kGravityBlock; ++l) at_x[l] = x[l], at_y[l] = y[l], at_z[l] = z[l];
  for (int l = 0; l < kGravityBlock; ++l) sum_x[l] = ax[l], sum_y[l] = ay[l], sum_z[l] = az[l];
  for (int k = 0; k < count; ++k) {
    const Moments& node = nodes[list[k]];
    const S M = node.GM, cx = node.centre[0], cy = node.centre[1], cz = node.centre[2];
    const S xx = node.GQ[0], yy = node.GQ[1], zz = node.GQ[2], xy = node.GQ[3], xz = node.GQ[4], yz = node.GQ[5];
    const S trace = S(1.5) * (xx + yy + zz);
    for (int l = 0; l < kGravityBlock; ++l) {
      const S rx = cx - at_x[l], ry = cy - at_y[l], rz = cz - at_z[l];
      const S rho2 = rx * rx + ry * ry + rz * rz + softening2;
      const S i1 = S(1) / std::sqrt(rho2), i2 = i1 * i1, i3 = i2 * i1, i5 = i3 * i2;
      const S Qx = xx * rx + xy * ry + xz * rz, Qy = xy * rx + yy * ry + yz * rz, Qz = xz * rx + yz * ry + zz * rz;
      const S rQr = rx * Qx + ry * Qy + rz * Qz;
      const S along = M * i3 + (S(7.5) * rQr * i2 - trace) * i5, across = S(3) * i5;
      sum_x[l] += along * rx - across * Qx;
      sum_y[l] += along * ry - across * Qy;
      sum_z[l] += along * rz - across * Qz;
    }
  }
  for (int l = 0; l < kGravityBlock; ++l) ax[l] = sum_x[l], ay[l] = sum_y[l], az[l] = sum_z[l];
}

// Squared distance from a point to the nearest point of a box.
template <class S, class Box> S distance2(const Box& box, const S (&at)[3]) {
  S sum = S(0);
  for (int axis = 0; axis < 3; ++axis) {
    const S out = real::max(S(0), real::max(box.low[axis] - at[axis], at[axis] - box.high[axis]));
    sum += out * out;
  }
  return sum;
}

}  // namespace

double gravity_tree_bound(double opening) {
  const double far = (1 + opening) / (1 - opening);
  return opening * opening * opening * (4 - 3 * opening) * far * far;
}

template <class S>
GravityTree<S>::GravityTree(int bodies, int threads)
    : count_(bodies), padded_(whole_blocks(bodies) * kGravityBlock), key_(bodies), key_room_(bodies), order_(bodies),
      order_room_(bodies), sorted_(std::size_t(7) * padded_), nodes_(std::size_t(bodies) / 2 + 64),
      boxes_(nodes_.size()), moments_(nodes_.size()), lists_(std::max(threads, 1)) {}

template <class S> void GravityTree<S>::flush_nodes(VectorWidth width, int group, S softening2_m2, List& list) {
  const Moments* const nodes = moments_.data();
  const int first = group * kGroupBlocks * kGravityBlock,
            last = std::min(first + kGroupBlocks * kGravityBlock, padded_);
  S *const x = row(0), *const y = row(1), *const z = row(2), *const ax = row(4), *const ay = row(5), *const az = row(6);
  const std::int32_t* const waiting = list.node;
  const int count = list.nodes;
  at_width(
      width, [=]() __attribute__((always_inline)) {
        for (int k = first; k < last; k += kGravityBlock)
          pull_block(nodes, waiting, count, softening2_m2, x + k, y + k, z + k, ax + k, ay + k, az + k);
      });
  list.counts.by_node += static_cast<std::int64_t>(count) * (std::min(last, count_) - first);
  list.nodes = 0;
}

template <class S> void GravityTree<S>::flush_bodies(VectorWidth width, int group, S softening2_m2, List& list) {
  if (list.from == list.to) return;
  const int first_block = group * kGroupBlocks,
            last_block = std::min(first_block + kGroupBlocks, padded_ / kGravityBlock);
  atwood::add_gravity<S>(width, {row(0), row(1), row(2), row(3)}, list.from, list.to, softening2_m2, first_block,
                         last_block, {row(4), row(5), row(6)});
  list.counts.by_body += static_cast<std::int64_t>(list.to - list.from) *
                         (std::min(last_block * kGravityBlock, count_) - first_block * kGravityBlock);
  list.from = list.to;
}

// Depth first, first child first; bodies of neighbouring leaves are summed in one call.
template <class S>
void GravityTree<S>::pull_group(VectorWidth width, int group, S softening2_m2, S opening, List& list) {
  const int first = group * kGroupBlocks * kGravityBlock;
  const Box box = box_of(first, std::min(first + kGroupBlocks * kGravityBlock, count_));
  const S opening2 = opening * opening;
  std::int32_t waiting[kMaxWaiting];
  int top = 0;
  waiting[top++] = 0;
  list.from = list.to = 0;
  while (top > 0) {
    const int n = waiting[--top];
    const Node& node = nodes_[n];
    const Moments& m = moments_[n];
    if (m.radius * m.radius < opening2 * distance2(box, m.centre)) {
      list.node[list.nodes++] = n;
      if (list.nodes == static_cast<int>(std::size(list.node))) flush_nodes(width, group, softening2_m2, list);
    } else if (node.children == 0) {
      if (list.to != node.first) flush_bodies(width, group, softening2_m2, list);
      if (list.from == list.to) list.from = node.first;
      list.to = node.last;
    } else {
      for (int c = node.child + node.children - 1; c >= node.child; --c) waiting[top++] = c;
    }
  }
  flush_nodes(width, group, softening2_m2, list);
  flush_bodies(width, group, softening2_m2, list);
}

template <class S>
void GravityTree<S>::add_gravity(VectorWidth width, const PointMasses<S>& bodies, S softening2_m2, S opening,
                                 Team* team, const Accelerations<S>& sums) {
  sort_bodies(bodies);
  build();
  sum_moments();
  std::fill(row(4), row(4) + std::size_t(3) * padded_, S(0));
  const int groups = (whole_blocks(count_) + kGroupBlocks - 1) / kGroupBlocks;
  const auto part = [&](int p, int parts) {
    lists_[p].counts = {};
    for (int group = p; group < groups; group += parts) pull_group(width, group, softening2_m2, opening, lists_[p]);
  };
  if (team == nullptr) part(0, 1);
  else team->run(count_ >= kMinShared, [&](int p) { part(p, team->size()); });
  for (int k = 0; k < count_; ++k) {
    sums.x[order_[k]] += row(4)[k];
    sums.y[order_[k]] += row(5)[k];
    sums.z[order_[k]] += row(6)[k];
  }
}

template <class S> auto GravityTree<S>::counts() const -> Counts {
  Counts all;
  for (const List& list : lists_) {
    all.by_node += list.counts.by_node;
    all.by_body += list.counts.by_body;
  }
  return all;
}

template class GravityTree<float>;
template class GravityTree<double>;

}  // namespace atwood
