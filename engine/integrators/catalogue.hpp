// Every method of the engine: its id, its claimed orders, and its stepper.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "integrators/stepper.hpp"
#include "protocol/method.hpp"
#include "rigid/model.hpp"

namespace atwood {

// Ids are "atwood/" + scheme.
const std::vector<MethodInfo>& integrator_catalogue();
const MethodInfo* find_integrator(const std::string& scheme);  // null: no method has that name

// A stepper of `scheme` for the model, which must outlive it. Null with a reason in `why` where the scheme cannot keep
// its claim ("leapfrog needs positions and velocities").
template <class S>
std::unique_ptr<Stepper<S>> make_stepper(const std::string& scheme, RigidModel<S>& model, std::string& why,
                                         const Settings& overrides = {});

}  // namespace atwood
