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
    const S end = scenario.t_end_s, speed = S(found.unheld_m_per_s2) * end,
            open = 4 * S(found.largest_gap_m) + speed * end / 2;
    motion.input_round_off.v_m_per_s = speed;
    motion.input_round_off.p_m = open;
    if (open > 0) motion.input_round_off.q = open / S(found.smallest_extent_m);
    if (speed > 0) motion.input_round_off.w_rad_per_s = speed / S(found.smallest_extent_m);
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
