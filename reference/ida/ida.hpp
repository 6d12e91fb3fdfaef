// SUNDIALS IDA on the reference's own equations, written as the residual F(t, y, y') = y' - f(t, y) = 0. Manual:
// Hindmarsh et al., ACM TOMS 31 (2005) 363.
#pragma once

#include "protocol/method.hpp"

namespace atwood {

// ida/bdf, variable order 1 to 5 and variable step: `:rtol[,atol]`, 1e-10 when none is given.
Engine ida_engine();

}  // namespace atwood
