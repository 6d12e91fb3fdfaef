// Bullet Physics 3.24 as an engine under test. Compiled twice, against each of Debian's builds: double precision
// ("bullet64") and float ("bullet32"). Their symbols collide, so one process links one of them.
#pragma once

#include "protocol/method.hpp"

namespace atwood {

Engine bullet_engine();

}  // namespace atwood
