// SUNDIALS ARKODE's one-step methods on the reference's own equations: each packaged Butcher table by ERKStep and by
// ARKStep (explicit, diagonally implicit, and additive pairs). Manual: Reynolds et al., ACM TOMS 49 (2023), article 19.
#pragma once

#include "protocol/method.hpp"

namespace atwood {

// arkode/erkstep/TABLE, arkode/arkstep-explicit/TABLE, arkode/arkstep-implicit/TABLE, arkode/arkstep-imex/PAIR with the
// library's names of its tables. Equal steps, or a tolerance `:rtol[,atol]`. The claimed order is the table's q.
Engine arkode_engine();

}  // namespace atwood
