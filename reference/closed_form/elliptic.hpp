// Carlson's symmetric elliptic integrals and Jacobi's amplitude.
#pragma once

#include "closed_form/number.hpp"

namespace atwood::closed_form {

template <class S>
S carlson_rc(S x, S y);  // y > 0
template <class S>
S carlson_rf(S x, S y, S z);
template <class S>
S carlson_rj(S x, S y, S z, S p);  // p > 0

// am(u | k) from the complementary modulus kc, kc^2 = 1 - k^2, 0 <= kc <= 1; continuous in u, odd.
template <class S>
S amplitude(S u, S kc);

}  // namespace atwood::closed_form
