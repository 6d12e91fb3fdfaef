// The query of `atwood contacts`: the contacts of a scene's bodies in the initial pose, or their first contact.
#pragma once

#include <array>
#include <vector>

#include "protocol/sample.hpp"

namespace atwood {

struct ContactQuery {
  bool swept = false;  // straight motion with constant spin (no gravity, no forces) from the initial pose to t_end_s
  double t_end_s = 0;
};

struct FoundContact {                   // one point
  int body_a = 0, body_b = 0;           // a < b
  std::array<Wide, 3> x_m{}, normal{};  // unit, from a to b
  Wide depth_m = 0;                     // >= 0
};
struct FoundTouch {  // the first touch of a pair
  int body_a = 0, body_b = 0;
  Wide toi_s = 0;  // 0: they overlap at the start
  std::array<Wide, 3> x_m{}, normal{};
};

struct ContactAnswer {
  std::vector<FoundContact> contacts;
  std::vector<FoundTouch> touches;
  Outcome outcome;  // unsupported: with the reason
};

}  // namespace atwood
