// Carlson's symmetric elliptic integrals R_C, R_F, R_J and Jacobi's elliptic functions. Arguments >= 0; the results are
// not finite where an integral diverges or its iteration does not converge.
#pragma once

#include "closed_form/number.hpp"

namespace atwood::closed_form {

template <class S> S carlson_rc(S x, S y);  // y > 0
template <class S> S carlson_rf(S x, S y, S z);
template <class S> S carlson_rj(S x, S y, S z, S p);  // p > 0

// sn, cn, dn at u - 2 K halves, which lies in [-K, K] (so that cn >= 0), for the complementary modulus kc,
// kc^2 = 1 - k^2, 0 <= kc <= 1. For kc = 0 there is no period, and halves is 0.
template <class S> struct Jacobi { S sn{0}, cn{1}, dn{1}, halves{0}; };
template <class S> Jacobi<S> jacobi(S u, S kc);

}  // namespace atwood::closed_form
