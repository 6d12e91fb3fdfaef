#include "mujoco/mujoco.hpp"
#include "under_test.hpp"

namespace atwood::test {
Engine engine_under_test() { return mujoco_engine(); }
}  // namespace atwood::test
