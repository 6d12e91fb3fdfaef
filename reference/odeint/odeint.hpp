// Boost.odeint's steppers on the reference's own equations. Ahnert and Mulansky, AIP Conf. Proc. 1389 (2011) 1586.
#pragma once

#include "protocol/method.hpp"

namespace atwood {

// odeint/STEPPER with the library's names. What each claims is what its own order() answers, where it has one. Equal
// steps in double or long double, in place or out of place; the controlled and dense-output forms take a tolerance.
Engine odeint_engine();

}  // namespace atwood
