#include "mechanism_under_test.hpp"
#include "simbody/simbody.hpp"

namespace atwood::test {
Engine engine_under_test() { return simbody_engine(); }
std::vector<Scheme> schemes_under_test() { return {{"default", true}, {"chosen", true, false, true, 1e-8, true}}; }
int chains_taken() { return 5; }
std::vector<JointKind> closings_taken() {
  using enum JointKind;
  return {fixed, hinge, slider, cylindrical, universal, ball};
}
bool reacts_in_loops() { return true; }
bool drives() { return true; }
bool stops() { return false; }
bool hangs() { return false; }
}  // namespace atwood::test
