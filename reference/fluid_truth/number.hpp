// The arithmetic of the closed forms (closed_form/number.hpp) and what fluids need beside it.
#pragma once

#include "closed_form/number.hpp"

namespace atwood::fluid_truth {

using closed_form::Narrow;
using closed_form::Vec;
using namespace closed_form;

// Double as well, for the systems that CVODE integrates.
using closed_form::cos;
using closed_form::exp;
using closed_form::expm1;
using closed_form::log;
using closed_form::log1p;
using closed_form::sin;
using closed_form::sqrt;
inline double cos(double x) { return std::cos(x); }
inline double exp(double x) { return std::exp(x); }
inline double expm1(double x) { return std::expm1(x); }
inline double log(double x) { return std::log(x); }
inline double log1p(double x) { return std::log1p(x); }
inline double sin(double x) { return std::sin(x); }
inline double sqrt(double x) { return std::sqrt(x); }
inline Narrow erf(Narrow x) { return std::erf(x); }
inline Wide erf(Wide x) { return erfq(x); }
inline Narrow erfc(Narrow x) { return std::erfc(x); }
inline Wide erfc(Wide x) { return erfcq(x); }
inline Narrow pow(Narrow x, Narrow y) { return std::pow(x, y); }
inline double pow(double x, double y) { return std::pow(x, y); }
inline Wide pow(Wide x, Wide y) { return powq(x, y); }

}  // namespace atwood::fluid_truth
