// The limits of joints: their gaps, and the course of a gap over a step.
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

// The cubic through a gap and its rate at both ends of a step, x in [0, 1].
struct Hermite {
  Wide g0, g1, r0, r1;  // rates times the step
  Wide operator()(Wide x) const {
    const Wide y = 1 - x;
    return g0 * y * y * (1 + 2 * x) + r0 * x * y * y + g1 * x * x * (3 - 2 * x) - r1 * x * x * y;
  }
};

}  // namespace atwood::extended
