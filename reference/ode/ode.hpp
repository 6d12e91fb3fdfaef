// The Open Dynamics Engine 0.16.2 as an engine under test. (Here `ode` always names the engine.)
#pragma once

#include "protocol/method.hpp"

namespace atwood {

Engine ode_engine();

}  // namespace atwood
