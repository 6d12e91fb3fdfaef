// A scene at rest: bodies that stand on each other, held by contact forces within Coulomb's cones (statics of rigid
// bodies; C. A. Coulomb, 1785). The existence of such forces is checked; the solution is the initial state.
#include "closed_form/equilibrium.hpp"
#include "closed_form/solution.hpp"

namespace atwood::closed_form {

namespace {

template <class S> Motion<S> solve_rest(const Scenario& scenario, const std::vector<S>& t_s) {
  Motion<S> motion;
  // The check is in double and is made once, for quad.
  if constexpr (std::is_same_v<S, Wide>) {
    const Equilibrium found = find_equilibrium(scenario.scene);
    motion.refusal = found.refusal;
    motion.input_round_off = {4 * S(found.largest_gap_m),
                              found.largest_gap_m > 0 ? 4 * S(found.largest_gap_m) / S(found.smallest_extent_m) : S(0),
                              S(0)};
  }
  std::vector<Pose<S>> poses;
  for (const Body& body : scenario.scene.bodies) poses.push_back(initial_pose<S>(body));
  motion.poses.assign(t_s.size(), poses);
  return motion;
}

}  // namespace

Solution rest() {
  return {"rest", "statics: contact forces within Coulomb's cones hold every body",
          feature::uniform_gravity | feature::kSimpleContact, solve_rest<Narrow>, solve_rest<Wide>};
}

}  // namespace atwood::closed_form
