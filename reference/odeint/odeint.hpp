// Boost.odeint's steppers on the reference's own equations. Ahnert and Mulansky, AIP Conf. Proc. 1389 (2011) 1586.
#pragma once

#include "protocol/method.hpp"

namespace atwood {

// Methods odeint/STEPPER, with the library's names. The claimed order of each is the value of its order(), where it has
// that function. Equal steps in double or long double, in place or out of place; the controlled and dense-output forms
// take a tolerance.
Engine odeint_engine();

}  // namespace atwood
