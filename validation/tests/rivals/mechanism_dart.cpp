#include "dart/engine.hpp"
#include "mechanism_under_test.hpp"

namespace atwood::test {
Engine engine_under_test() { return dart_engine(); }
std::vector<Scheme> schemes_under_test() { return {{"default", false, true}}; }
int chains_taken() { return 4; }  // all but the cylindrical joint's
std::vector<JointKind> closings_taken() {
  using enum JointKind;
  return {fixed, hinge, ball};
}
bool reacts_in_loops() { return false; }
bool drives() { return true; }
bool stops() { return true; }
bool hangs() { return false; }
}  // namespace atwood::test
