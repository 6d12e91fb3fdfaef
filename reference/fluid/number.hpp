// The arithmetic of the closed forms (closed_form/number.hpp) and what fluids need beside it.
#pragma once

#include "closed_form/number.hpp"

namespace atwood::fluid_truth {

using closed_form::Narrow;
using closed_form::Vec;
using namespace closed_form;

inline Narrow erf(Narrow x) { return std::erf(x); }
inline Wide erf(Wide x) { return erfq(x); }
inline Narrow erfc(Narrow x) { return std::erfc(x); }
inline Wide erfc(Wide x) { return erfcq(x); }
inline Narrow pow(Narrow x, Narrow y) { return std::pow(x, y); }
inline Wide pow(Wide x, Wide y) { return powq(x, y); }

}  // namespace atwood::fluid_truth
