// The limits of joints and their gaps.
#pragma once

#include <array>

#include "protocol/sample.hpp"

namespace atwood::extended {

// One side of a joint's limits.
struct Stop {
  int joint = 0;
  int side = 1;  // 1: lower, -1: upper
  double limit = 0;
  Wide restitution = 0;
  Wide gap(const std::array<Wide, 2>& qu) const { return side * (qu[0] - Wide(limit)); }
  Wide speed(const std::array<Wide, 2>& qu) const { return side * qu[1]; }
};

}  // namespace atwood::extended
