// Many steps of one rotating body in free flight, by any explicit Runge-Kutta method: its seven rotational unknowns in
// the lanes of one register, the rates inlined into the stages. The same bits as free_flight_lanes.hpp.
#pragma once

#include "integrators/free_flight_lanes.hpp"

namespace atwood {

// Whether fly_many_alone() can replace fly(): principal body axes, at most kMaxStagesAlone stages, and a machine
// whose instructions permute the doubles of a register. RK4 has a specialised loop, which is as fast.
bool flies_alone(VectorWidth width, FlightKind kind, const FlightSteps<double>& steps);

// `count` steps of the body whose 13 scalars are at `y`, in the order of a state.
void fly_many_alone(VectorWidth width, const FlightSteps<double>& steps, const FlightInertia<double, 1>& inertia,
                    std::int64_t count, double* y);

}  // namespace atwood
