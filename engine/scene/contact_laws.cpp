#include "scene/contact_laws.hpp"

#include <cstdint>

namespace atwood {

std::vector<PairLaw> laws_in_play(const Scene& scene) {
  std::vector<std::int64_t> moving(scene.materials.size()), fixed(scene.materials.size());
  for (const auto& body : scene.bodies) {
    if (body.shape.index() != 0) ++(body.fixed ? fixed : moving)[static_cast<std::size_t>(body.material)];
  }
  std::vector<PairLaw> laws;
  for (const auto& law : scene.pairs) {
    const auto a = static_cast<std::size_t>(law.a), b = static_cast<std::size_t>(law.b);
    const bool meet = a == b ? moving[a] > 1 || (moving[a] > 0 && fixed[a] > 0)
                             : (moving[a] > 0 && moving[b] + fixed[b] > 0) || (fixed[a] > 0 && moving[b] > 0);
    if (meet) laws.push_back(law);
  }
  return laws;
}

}  // namespace atwood
