// Butcher tableaux as data: exact rationals, narrowed to the scalar of a run when its stepper is made.
#pragma once

#include <array>
#include <cstdint>

namespace atwood {

struct Ratio {
  std::int64_t over = 0, under = 1;
  template <class S> constexpr S as() const { return S(over) / S(under); }
};

inline constexpr int max_stages = 7;
using TableauRow = std::array<Ratio, max_stages>;

// Stage i: k_i = f(t + c_i h, y + h sum_j<i a_ij k_j); y_new = y + h sum b_i k_i. Missing entries are 0.
struct Tableau {
  int stages = 0;
  int order = 0;                       // of b
  int embedded_order = 0;              // of b - error_weight; 0: there is none
  std::array<TableauRow, max_stages> a{};
  TableauRow b{}, c{};
  TableauRow error_weight{};           // b - b^, so the error estimate is h sum error_weight_i k_i
  bool first_same_as_last = false;     // the last stage is the rate at y_new
  // A continuous extension y + theta h sum_i (hermite on y, y_new, k_1, k_last, and) theta^2 (1-theta)^2 h sum d_i k_i.
  TableauRow dense_weight{};
  bool dense = false;
};

extern const Tableau explicit_euler_tableau, midpoint_tableau, heun_tableau, rk4_tableau, fehlberg45_tableau,
    dormand_prince5_tableau;

}  // namespace atwood
