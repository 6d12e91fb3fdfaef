#include "mechanism_under_test.hpp"
#include "mujoco/mujoco.hpp"

namespace atwood::test {
Engine engine_under_test() { return mujoco_engine(); }
std::vector<Scheme> schemes_under_test() {
  std::vector<Scheme> schemes = {{"default", false, true}, {"rk4", true}, {"stiff", true}, {"implicit"}};
  for (Scheme& scheme : schemes) scheme.gap = scheme.name == "stiff" ? 1e-3 : 1e-2;  // equality constraints are soft
  return schemes;
}
int chains_taken() { return 5; }
std::vector<JointKind> closings_taken() {
  using enum JointKind;
  return {fixed, hinge, ball};
}
bool reacts_in_loops() { return true; }
bool drives() { return false; }
bool stops() { return true; }
bool hangs() { return true; }
}  // namespace atwood::test
