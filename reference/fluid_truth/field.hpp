// Exact fields of fluids as functions of time and place: what a particle method's space error is measured against.
//
// Closed forms: one solution a file, with its citation at the top. Each is evaluated from the scene's doubles in quad
// and in long double; the difference, divided by the ratio of the two unit round-offs, estimates the round-off error of
// the quad evaluation, as in closed_form/closed_form.hpp. What a formula leaves out (the remainder of a series, the
// square of an amplitude) is added to the bar.
#pragma once

#include <string>
#include <vector>

#include "protocol/fluid_field.hpp"
#include "scene/scene.hpp"

namespace atwood {

// The field that scenario.truth names: kind closed_form with its solution, or weakly_compressible. For any other kind,
// an unknown solution or a scene that the solution does not cover the outcome is Status::unsupported with a reason.
// Never throws on a scene. The field does not depend on the particles, with one exception that its solution names.
FluidField fluid_field_of(const Scenario& scenario, const std::string& response = "");

// The ids that `solution` may name.
std::vector<std::string> fluid_solution_ids();

}  // namespace atwood
