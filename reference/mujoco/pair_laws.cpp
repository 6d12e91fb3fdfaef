#include "mujoco/pair_laws.hpp"

#include <algorithm>

#include "rivals/world.hpp"

namespace atwood::mujoco {
namespace {

bool same(const PairLaw& a, const PairLaw& b) {
  return a.friction == b.friction && a.rolling_friction_m == b.rolling_friction_m;
}

}  // namespace

std::optional<std::vector<Precedence>> precedences(const Scene& scene) {
  std::vector<PairLaw> left = rivals::laws_in_play(scene);
  std::vector<Precedence> all(scene.materials.size());
  // From the highest priority: a material with the same law for all remaining ones determines these laws and is
  // removed.
  for (int priority = static_cast<int>(scene.materials.size()); !left.empty(); --priority) {
    bool found = false;
    for (int m = 0; m < static_cast<int>(scene.materials.size()) && !found; ++m) {
      const auto has = [m](const PairLaw& law) { return law.a == m || law.b == m; };
      const auto first = std::find_if(left.begin(), left.end(), has);
      if (first == left.end()) continue;
      const PairLaw law = *first;
      found = std::all_of(left.begin(), left.end(), [&](const PairLaw& l) { return !has(l) || same(l, law); });
      if (!found) continue;
      all[static_cast<std::size_t>(m)] = {priority, law.friction, law.rolling_friction_m};
      std::erase_if(left, has);
    }
    if (!found) return std::nullopt;
  }
  return all;
}

}  // namespace atwood::mujoco
