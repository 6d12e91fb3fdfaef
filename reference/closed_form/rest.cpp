// Nothing moves: bodies that stand on each other, held by contact forces within Coulomb's cones (statics of rigid
// bodies; C. A. Coulomb, 1785). Whether such forces exist is checked; the answer is the scene itself.
#include "closed_form/equilibrium.hpp"
#include "closed_form/solution.hpp"

namespace atwood::closed_form {

namespace {

template <class S> Motion<S> solve(const Scenario& scenario, const std::vector<S>& t_s) {
  Motion<S> motion;
  // One scalar looks: the check is in double for both.
  if constexpr (std::is_same_v<S, Wide>) {
    const Equilibrium found = find_equilibrium(scenario.scene);
    motion.misfit = found.misfit;
    motion.slack = {4 * S(found.open_m), found.open_m > 0 ? 4 * S(found.open_m) / S(found.least_m) : S(0), S(0)};
  }
  std::vector<Pose<S>> poses;
  for (const Body& body : scenario.scene.bodies) poses.push_back(initial_pose<S>(body));
  motion.poses.assign(t_s.size(), poses);
  return motion;
}

}  // namespace

Solution rest() {
  return {"rest", "statics: contact forces within Coulomb's cones hold every body",
          feature::uniform_gravity | feature::kTouching, solve<Narrow>, solve<Wide>};
}

}  // namespace atwood::closed_form
