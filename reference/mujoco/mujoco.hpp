// MuJoCo 2.2 as an engine under test.
#pragma once

#include "protocol/method.hpp"

namespace atwood {

Engine mujoco_engine();

}  // namespace atwood
