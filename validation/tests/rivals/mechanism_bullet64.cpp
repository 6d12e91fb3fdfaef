#include "bullet/bullet.hpp"
#include "mechanism_under_test.hpp"

// Bullet's multibodies, which step in reduced coordinates. Its rigid bodies: maximal_mechanism_test.cpp.
namespace atwood::test {
Engine engine_under_test() { return bullet_engine(); }
std::vector<Scheme> schemes_under_test() { return {{"multibody", false, true}}; }
int chains_taken() { return 5; }
std::vector<JointKind> closings_taken() {
  using enum JointKind;
  return {fixed, hinge, ball};
}
bool reacts_in_loops() { return false; }
bool drives() { return true; }
bool stops() { return true; }
bool hangs() { return false; }
}  // namespace atwood::test
