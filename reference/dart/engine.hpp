// DART 6.12 as an engine under test. (Not dart.hpp: that is the name of DART's own header.)
#pragma once

#include "protocol/method.hpp"

namespace atwood {

Engine dart_engine();

}  // namespace atwood
