// Butcher tableaux as data, in the notation of the papers: rows of "35/384", "1/30" or decimals of 40 digits and more,
// read once, in quad, when a stepper is made.
#pragma once

#include <array>
#include <vector>

#include "math/scalar.hpp"

namespace atwood {

inline constexpr int kMaxStages = 22;  // those of dense output included
inline constexpr int kMaxDenseRows = 5;

// Stage i: k_i = f(t + c_i h, y + h sum_j<i a_ij k_j); y_new = y + h sum b_i k_i. Entries missing at the end of a row
// are 0.
struct Tableau {
  int stages = 0;
  int order = 0;           // of b
  int embedded_order = 0;  // of b^; 0: there is none
  std::array<const char*, kMaxStages> a{};
  const char *b = "", *c = "";
  const char* embedded = "";  // b^: the error estimate is h sum (b_i - b^_i) k_i
  // DOP853's second estimate, of order 3, which guards against a first estimate that is small by coincidence
  // (Hairer, Norsett, Wanner I, eq. II.10.17): |h| e5^2 / sqrt(e5^2 + e3^2 / 100).
  int companion_order = 0;
  const char* companion = "";
  bool first_same_as_last = false;  // the last stage is the rate at y_new
  // The interpolant, nested as in the codes DOPRI5 and DOP853:
  //   y + th (dy + u (h k_1 - dy + th (2 dy - h (k_1 + k_end) + u h (D_1 + th (D_2 + u (D_3 + th (D_4 + ...)))))))
  // with u = 1 - th, D_n = sum dense[n-1]_i k_i, k_end the rate at y_new; without rows it is the cubic Hermite
  // polynomial. The dense_stages further stages (the last rows of a) are evaluated only when dense output is requested;
  // where the last stage is not the rate at y_new, the first of them is.
  int dense_order = 0;  // 0: there is none
  int dense_stages = 0;
  std::array<const char*, kMaxDenseRows> dense{};
  int end_stage() const { return first_same_as_last ? stages - 1 : stages; }  // of the interpolant: its rate is k_end
};

using TableauRow = std::vector<Quad>;  // stages + dense_stages long

struct Coefficients {
  std::vector<TableauRow> a;  // dense stages included
  TableauRow b, c;
  TableauRow error, companion_error;  // b - b^; zeros where there is none
  std::vector<TableauRow> dense;
  int estimate_order = 0;  // k where the estimate is O(h^(k+1))
};

// Throws std::logic_error if an entry is not a number or a row is too long: an error in the built-in tables.
TableauRow read_row(const char* text);
TableauRow read_row(const char* text, int length);  // zeros added at the end
Coefficients read_coefficients(const Tableau& tableau);

extern const Tableau explicit_euler_tableau, midpoint_tableau, heun_tableau, ralston2_tableau, kutta3_tableau,
    rk4_tableau, rk38_tableau;
extern const Tableau bogacki_shampine3_tableau, fehlberg45_tableau, cash_karp5_tableau, dormand_prince5_tableau,
    tsitouras5_tableau;
extern const Tableau verner6_tableau, verner8_tableau, verner9_tableau;
extern const Tableau fehlberg78_tableau, dormand_prince853_tableau;

}  // namespace atwood
