// Simbody 3.7 as an engine under test.
#pragma once

#include "protocol/method.hpp"

namespace atwood {

Engine simbody_engine();

}  // namespace atwood
