#include "ode/ode.hpp"
#include "under_test.hpp"

namespace atwood::test {
Engine engine_under_test() { return ode_engine(); }
}  // namespace atwood::test
