// Kinds of random scenes, each with the truth that answers it and the checker that judges the answer.
#pragma once

#include <functional>
#include <random>
#include <string>
#include <vector>

#include "number.hpp"

namespace atwood::fuzz {

class Random {
 public:
  Random(std::uint64_t seed, std::uint64_t index) : draw_(seed * 1000003u + index) {}
  double uniform(double from, double to) { return from + (to - from) * static_cast<double>(draw_() >> 11) * 0x1p-53; }
  double power(double from, double to) { return std::pow(10, uniform(from, to)); }  // 10^from to 10^to
  double sign() { return draw_() % 2 == 0 ? 1 : -1; }
  int whole(int from, int to) { return from + static_cast<int>(draw_() % static_cast<std::uint64_t>(to - from + 1)); }
  Real3 vector(double size) { return {uniform(-size, size), uniform(-size, size), uniform(-size, size)}; }
  Real3 direction() {
    for (;;) {
      const Real3 v = vector(1);
      const double length = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
      if (length > 0.1 && length < 1) return {v[0] / length, v[1] / length, v[2] / length};
    }
  }

 private:
  std::mt19937_64 draw_;
};

struct Kind {
  std::string truth, name;                              // "closed-form", "kepler": the pair is closed-form/kepler
  std::function<Scenario(Random&, bool border)> scene;  // border: near a limit of the formulas or of validity
  std::function<Checked(const Scenario&, std::int64_t samples)> check;
  // Share of the scenes that the truth or the checker may refuse: none was, of thousands of those that state no other.
  double most_refused = 0.002;
  // Numbers of samples with each of which the scene is answered and judged; empty: the scene's own. Bars at the end
  // must then be below 1e-9 of the scene's size: a wider answer counts as refused.
  std::vector<std::int64_t> counts = {};
};

const std::vector<Kind>& kinds();
std::vector<Kind> contact_kinds(), rolling_kinds(), joint_kinds(), mechanism_kinds(), event_kinds();  // parts of them

}  // namespace atwood::fuzz
