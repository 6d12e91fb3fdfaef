#include "bullet/bullet.hpp"
#include "under_test.hpp"

namespace atwood::test {
Engine engine_under_test() { return bullet_engine(); }
}  // namespace atwood::test
