#include "rivals/pairs.hpp"

#include <stdexcept>
#include <string>

#include "protocol/refusal.hpp"
#include "rivals/world.hpp"
#include "scene/inertia.hpp"

namespace atwood::rivals {

ContactAnswer ask_pairs(const char* engine, const Scene& scene,
                        const std::function<void(int a, int b, ContactAnswer&)>& ask) {
  ContactAnswer answer;
  const int n = static_cast<int>(scene.bodies.size());
  try {
    for (int a = 0; a < n; ++a)
      for (int b = a + 1; b < n; ++b) {
        const Body &one = scene.bodies[static_cast<std::size_t>(a)], &other = scene.bodies[static_cast<std::size_t>(b)];
        if (has_shape(one) && has_shape(other) && !(one.fixed && other.fixed)) ask(a, b, answer);
      }
  } catch (const std::invalid_argument& error) {
    answer = {};
    answer.outcome = refused(std::string(engine) + ": " + error.what());
  }
  return answer;
}

std::array<Wide, 3> widened(const Real3& v) { return {v[0], v[1], v[2]}; }

std::vector<std::array<int, 3>> hull_of(const Convex& shape) {
  auto triangles = convex_hull(shape.points_m);
  if (triangles.empty())
    throw std::invalid_argument("expected a convex shape with a volume; found all its points in a plane");
  return triangles;
}

}  // namespace atwood::rivals
