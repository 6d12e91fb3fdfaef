#include "bullet/bullet.hpp"
#include "mechanism_under_test.hpp"

namespace atwood::test {
Engine engine_under_test() { return bullet_engine(); }
std::vector<Scheme> schemes_under_test() {
  Scheme scheme{"multibody-rk4", true};
  scheme.forces_held = true;
  return {scheme};
}
int chains_taken() { return 5; }
std::vector<JointKind> closings_taken() { return {}; }
bool reacts_in_loops() { return false; }
bool drives() { return false; }
bool stops() { return false; }
bool hangs() { return false; }
}  // namespace atwood::test
