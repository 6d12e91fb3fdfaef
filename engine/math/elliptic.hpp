// Elliptic functions and integrals in the scalar of a run.
#pragma once

#include "math/scalar.hpp"

namespace atwood {

// Carlson's symmetric integrals by duplication (Carlson, Numer. Algorithms 10 (1995) 13; DLMF 19.36(i)), to round-off.
// R_F(x, y, z) for x, y, z >= 0, at most one of them 0. R_J(x, y, z, p) as well, for p no less than any of x, y, z.
template <class S> S carlson_rf(S x, S y, S z);
template <class S> S carlson_rj(S x, S y, S z, S p);

// sn, cn, dn of a modulus given by its complement k'^2 = 1 - k^2 in (0, 1], so that k near 1 keeps its digits. NaN for
// k'^2 = 0, where the functions have no period.
template <class S> class JacobiFunctions {
 public:
  explicit JacobiFunctions(S complement);

  S quarter() const { return quarter_; }  // K: sn has the period 4 K
  struct Values {
    S sn, cn, dn;
  };
  Values at(S u) const;  // |u| <= K

 private:
  static constexpr int kMaxLevels = 24;
  int levels_ = 0;
  S a_[kMaxLevels], b_[kMaxLevels];  // of the arithmetic-geometric mean of 1 and k'
  S quarter_{};
};

}  // namespace atwood
