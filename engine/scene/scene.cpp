#include "scene/scene.hpp"

#include <algorithm>
#include <stdexcept>

namespace atwood {

const PairLaw& pair_law(const Scene& scene, int body_a, int body_b) {
  const int m_a = scene.bodies.at(static_cast<std::size_t>(body_a)).material;
  const int m_b = scene.bodies.at(static_cast<std::size_t>(body_b)).material;
  const int a = std::min(m_a, m_b), b = std::max(m_a, m_b);
  for (const PairLaw& law : scene.pairs)
    if (law.a == a && law.b == b) return law;
  throw std::logic_error("a scene without the law of its materials " + std::to_string(a) + " and " + std::to_string(b));
}

}  // namespace atwood
