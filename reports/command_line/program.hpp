// Evidence for another library's maintainer: a complete program, nothing of Atwood in it, that shows what one of its
// methods claims and what order it executes on one scene.
#pragma once

#include <string>

#include "protocol/method.hpp"
#include "protocol/truth.hpp"
#include "scene/scene.hpp"

namespace atwood {

// C++17, the compile line in its first comment; it prints a ladder of steps and errors, the claimed and the executed
// order and a verdict by the audit's rule. A method id with a tolerance: a ladder of tolerances instead. Throws
// InputError where it can't be written: the scene needs one point mass under attractor, spring, drive or Lorentz force
// (or the Lorenz problem), the method equal steps of ARKODE or odeint, or a tolerance of ARKODE.
std::string evidence_program(const MethodId& id, const MethodInfo& info, const std::string& version,
                             const Scenario& scenario, const Truth& truth);

}  // namespace atwood
