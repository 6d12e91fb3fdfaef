// The tree itself: bodies along a space-filling curve, nodes over stretches of it, moments from the leaves up.
#include <algorithm>
#include <bit>
#include <cmath>

#include "forces/gravity_tree.hpp"
#include "math/scalar.hpp"

namespace atwood {
namespace {

constexpr int kLeafBodies = 32;             // at most, unless their keys are equal
constexpr int kLevels = 21;                 // bits of each coordinate in a key
constexpr int kDigitBits = 8, kDigits = 8;  // of the sort: 64 bits

// The 21 low bits of x, two zeros after each.
std::uint64_t interleave_bits(std::uint64_t x) {
  x = (x | x << 32) & 0x001f00000000ffffu;
  x = (x | x << 16) & 0x001f0000ff0000ffu;
  x = (x | x << 8) & 0x100f00f00f00f00fu;
  x = (x | x << 4) & 0x10c30c30c30c30c3u;
  return (x | x << 2) & 0x1249249249249249u;
}

// Index of the part of [low, low + side] that holds x, of 2^21 equal parts; NaN gives 0.
template <class S> std::uint64_t part_of(S x, S low, S parts_per_m) {
  constexpr std::int64_t last = (std::int64_t(1) << kLevels) - 1;
  const S part = (x - low) * parts_per_m;
  return static_cast<std::uint64_t>(part > S(0) ? (part < S(last) ? static_cast<std::int64_t>(part) : last) : 0);
}

// Least significant digit first: stable, so bodies of one key keep their order.
void radix_sort(std::vector<std::uint64_t>& key, std::vector<std::uint64_t>& key_room, std::vector<std::int32_t>& order,
                std::vector<std::int32_t>& order_room) {
  for (int digit = 0; digit < kDigits; ++digit) {
    const int shift = digit * kDigitBits;
    std::size_t start[(1 << kDigitBits) + 1] = {};
    for (const std::uint64_t k : key) ++start[(k >> shift & 0xff) + 1];
    for (int d = 0; d < 1 << kDigitBits; ++d) start[d + 1] += start[d];
    for (std::size_t i = 0; i < key.size(); ++i) {
      const std::size_t at = start[key[i] >> shift & 0xff]++;
      key_room[at] = key[i];
      order_room[at] = order[i];
    }
    key.swap(key_room);
    order.swap(order_room);
  }
}

}  // namespace

template <class S> auto GravityTree<S>::box_of(int first, int last) const -> Box {
  Box box;
  for (int axis = 0; axis < 3; ++axis) {
    const S* x = row(axis);
    S low = x[first], high = x[first];
    for (int k = first + 1; k < last; ++k) {
      low = real::min(low, x[k]);
      high = real::max(high, x[k]);
    }
    box.low[axis] = low;
    box.high[axis] = high;
  }
  return box;
}

template <class S> void GravityTree<S>::sort_bodies(const PointMasses<S>& bodies) {
  const S* at[3] = {bodies.x_m, bodies.y_m, bodies.z_m};
  for (int axis = 0; axis < 3; ++axis) std::copy(at[axis], at[axis] + count_, row(axis));
  const Box all = box_of(0, count_);
  const S side = real::max(all.high[0] - all.low[0], real::max(all.high[1] - all.low[1], all.high[2] - all.low[2]));
  const S parts_per_m = side > S(0) ? S(1 << kLevels) / side : S(0);
  for (int i = 0; i < count_; ++i) {
    std::uint64_t key = 0;
    for (int axis = 0; axis < 3; ++axis)
      key |= interleave_bits(part_of(at[axis][i], all.low[axis], parts_per_m)) << axis;
    key_[i] = key;
    order_[i] = i;
  }
  radix_sort(key_, key_room_, order_, order_room_);
  for (int k = 0; k < count_; ++k) {
    const int i = order_[k];
    for (int axis = 0; axis < 3; ++axis) row(axis)[k] = at[axis][i];
    row(3)[k] = bodies.Gm_m3_per_s2[i];
  }
}

// Children are formed by the first octal digit in which the keys of the node's bodies differ, so no node has a single
// child. When the array of nodes is full, the node stays a leaf.
template <class S> void GravityTree<S>::split(int n) {
  const Node node = nodes_[n];
  const std::uint64_t differ = key_[node.first] ^ key_[node.last - 1];
  if (node.last - node.first <= kLeafBodies || differ == 0 || node_count_ + 8 > static_cast<int>(nodes_.size())) return;
  const int shift = (63 - std::countl_zero(differ)) / 3 * 3;
  nodes_[n].child = node_count_;
  for (int first = node.first; first < node.last;) {
    const std::uint64_t digit = key_[first] >> shift;
    const auto end = std::partition_point(key_.begin() + first, key_.begin() + node.last,
                                          [=](std::uint64_t key) { return key >> shift == digit; });
    const int last = static_cast<int>(end - key_.begin());
    nodes_[node_count_++] = {first, last, 0, 0};
    ++nodes_[n].children;
    first = last;
  }
}

template <class S> void GravityTree<S>::build() {
  nodes_[0] = {0, count_, 0, 0};
  node_count_ = 1;
  for (int n = 0; n < node_count_; ++n) split(n);  // breadth first
}

// The centre of mass, the box and the radius: the farthest corner of the box is no nearer than the farthest body.
template <class S> void GravityTree<S>::find_centre(int n) {
  const Node& node = nodes_[n];
  S total = S(0), weighted[3] = {};
  Box box{};
  if (node.children == 0) {
    box = box_of(node.first, node.last);
    for (int k = node.first; k < node.last; ++k) {
      total += row(3)[k];
      for (int axis = 0; axis < 3; ++axis) weighted[axis] += row(3)[k] * row(axis)[k];
    }
  } else {
    box = boxes_[node.child];
    for (int c = node.child; c < node.child + node.children; ++c) {
      total += moments_[c].GM;
      for (int axis = 0; axis < 3; ++axis) {
        weighted[axis] += moments_[c].GM * moments_[c].centre[axis];
        box.low[axis] = real::min(box.low[axis], boxes_[c].low[axis]);
        box.high[axis] = real::max(box.high[axis], boxes_[c].high[axis]);
      }
    }
  }
  boxes_[n] = box;
  moments_[n].GM = total;
  S radius2 = S(0);
  for (int axis = 0; axis < 3; ++axis) {
    const S centre = total > S(0) ? weighted[axis] / total : (box.low[axis] + box.high[axis]) / S(2);
    moments_[n].centre[axis] = centre;
    const S half_extent = real::max(centre - box.low[axis], box.high[axis] - centre);
    radius2 += half_extent * half_extent;
  }
  moments_[n].radius = std::sqrt(radius2);
}

// About the node's own centre; a child's are moved there by its mass times the squared distance (Steiner).
template <class S> void GravityTree<S>::find_second_moments(int n) {
  const Node& node = nodes_[n];
  const bool leaf = node.children == 0;
  const int first = leaf ? node.first : node.child, last = leaf ? node.last : node.child + node.children;
  S Q[6] = {};
  for (int k = first; k < last; ++k) {
    const S m = leaf ? row(3)[k] : moments_[k].GM;
    S s[3];
    for (int axis = 0; axis < 3; ++axis)
      s[axis] = (leaf ? row(axis)[k] : moments_[k].centre[axis]) - moments_[n].centre[axis];
    const S steiner[6] = {s[0] * s[0], s[1] * s[1], s[2] * s[2], s[0] * s[1], s[0] * s[2], s[1] * s[2]};
    for (int q = 0; q < 6; ++q) Q[q] += m * steiner[q] + (leaf ? S(0) : moments_[k].GQ[q]);
  }
  for (int q = 0; q < 6; ++q) moments_[n].GQ[q] = Q[q];
}

template <class S> void GravityTree<S>::sum_moments() {
  for (int n = node_count_ - 1; n >= 0; --n) {
    find_centre(n);
    find_second_moments(n);
  }
}

template void GravityTree<float>::sort_bodies(const PointMasses<float>&);
template void GravityTree<double>::sort_bodies(const PointMasses<double>&);
template void GravityTree<float>::build();
template void GravityTree<double>::build();
template void GravityTree<float>::sum_moments();
template void GravityTree<double>::sum_moments();
template auto GravityTree<float>::box_of(int, int) const -> Box;
template auto GravityTree<double>::box_of(int, int) const -> Box;

}  // namespace atwood
