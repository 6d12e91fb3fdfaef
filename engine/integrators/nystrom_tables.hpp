// Runge-Kutta-Nystrom tables as data, for x'' = a(t, x); rows as in integrators/tableaux.hpp.
#pragma once

#include <array>

#include "integrators/tableaux.hpp"

namespace atwood {

inline constexpr int kMaxNystromStages = 17;

// Stage i: k_i = a(t + c_i h, x + c_i h v + h^2 sum_j<i a_ij k_j);
// x_new = x + h v + h^2 sum b_i k_i, v_new = v + h sum b'_i k_i     (Hairer, Norsett, Wanner I, eq. II.14.13).
struct NystromTableau {
  int stages = 0;
  int order = 0, embedded_order = 0;  // of position and velocity both
  std::array<const char*, kMaxNystromStages> a{};
  const char *b = "", *b_velocity = "", *c = "";
  const char *embedded = "", *embedded_velocity = "";
  bool first_same_as_last = false;  // the last stage is the acceleration at x_new
};

// Alternating kicks and drifts, a kick first: v += kicks_0 h a, x += drifts_0 h v, v += kicks_1 h a, ... The times of
// the accelerations advance with the drifts. First and last kicks of 0 are skipped.
struct SymplecticNystromTable {
  int order = 0;
  const char *kicks = "", *drifts = "";  // one kick more than drifts
};

extern const NystromTableau dormand_prince_nystrom6, dormand_prince_nystrom12;
extern const SymplecticNystromTable blanes_moan_nystrom4, blanes_moan_nystrom6;

}  // namespace atwood
