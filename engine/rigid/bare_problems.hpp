// Systems of equations without bodies, by name.
#pragma once

#include <string>

namespace atwood {

// The rate of three unknowns; null for a name that is not in the catalogue. Its context is not used.
template <class S> using BareRate = void (*)(void* context, S t_s, const S* y, S* dydt);
template <class S> BareRate<S> bare_problem_rate(const std::string& name);

}  // namespace atwood
