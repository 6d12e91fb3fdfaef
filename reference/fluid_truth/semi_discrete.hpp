// The truth of a particle method's own equations: its number of particles is fixed, so that they are a finite system of
// ordinary differential equations, and a difference from their solution is an error of time alone.
#pragma once

#include <cstdint>

#include "protocol/truth.hpp"
#include "scene/scene.hpp"

namespace atwood {

// Solves the equations of scenario.truth.response ("sph{...}", "polynomial{...}" with all settings) from the scene's
// particles; Truth::values hold particles, the bars theirs. The methods, by the number of particles:
//   up to 256      extrapolation of order up to 24 at two tolerances: in quad where that takes half a minute at most,
//   else
//                  in long double (the source says which)
//   up to 2 500    CVODE's Adams at 1e-12, beside an own Adams of order 6 with 20 equal steps in the time in
//                  which sound crosses a spacing
//   above          the classical Runge-Kutta method with n, 2 n and 4 n steps
// A bar is twice the largest difference to the other runs, per kind of value, over the run up to its time; for the
// ladder of steps this holds where the differences fall by 8 or more, and the note says where they do not. A kernel of
// finite smoothness limits every order: small bars then come from small steps.
// Not covered, each Status::unsupported with a reason: bodies that move, and what docs/fluids.md leaves open. Never
// throws.
Truth semi_discrete_truth(const Scenario& scenario, std::int64_t samples);

}  // namespace atwood
