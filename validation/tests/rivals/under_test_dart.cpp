#include "dart/engine.hpp"
#include "under_test.hpp"

namespace atwood::test {
Engine engine_under_test() { return dart_engine(); }
}  // namespace atwood::test
