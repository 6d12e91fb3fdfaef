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

// A stepper of `scheme` for the model, which must outlive it; never null. Fails for an unknown scheme or
// setting, for a value outside its range, and where the scheme cannot keep its claim on this model ("needs positions and
// velocities").
template <class S>
Result<std::unique_ptr<Stepper<S>>> make_stepper(const std::string& scheme, RigidModel<S>& model,
                                                 const Settings& overrides = {});
// The same for a system of equations without bodies. Methods for first-order systems take it; those that need
// positions, velocities, bodies, an energy or a power series refuse it.
template <class S>
Result<std::unique_ptr<Stepper<S>>> make_stepper(const std::string& scheme, System<S>& system,
                                                 const Settings& overrides = {});

}  // namespace atwood
