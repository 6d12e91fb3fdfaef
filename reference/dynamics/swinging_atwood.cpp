#include "dynamics/swinging_atwood.hpp"

#include "dynamics/arithmetic.hpp"

namespace atwood::dynamics {
namespace {

using Wide3 = Triple<Wide>;

constexpr double kAlong = 1e-12;  // of the sizes: motion out of the vertical or of the plane that is round-off

struct Ends {
  std::size_t bob = 0, heavy = 0;
  Wide3 bob_point{}, heavy_point{};
};
Ends ends_of(const Scene& scene) {
  const Rope& rope = scene.ropes.front();
  const auto a = static_cast<std::size_t>(rope.bodies[0]), b = static_cast<std::size_t>(rope.bodies[1]);
  const Wide3 first = widen<Wide>(rope.over.front().axle_m), last = widen<Wide>(rope.over.back().axle_m);
  if (scene.bodies[a].mass_kg < scene.bodies[b].mass_kg) return {a, b, first, last};
  return {b, a, last, first};
}

Wide3 down(const Scene& scene) {
  const Wide3 g = widen<Wide>(scene.gravity_m_per_s2);
  return (1 / norm(g)) * g;
}

Wide3 across(const Wide3& v, const Wide3& along) { return v - dot(v, along) * along; }

// The horizontal direction in which the bob starts or first moves; 0: it hangs still.
Wide3 sideways(const Scene& scene, const Ends& ends) {
  const Body& bob = scene.bodies[ends.bob];
  const Wide3 x = across(widen<Wide>(bob.position_m) - ends.bob_point, down(scene));
  const Wide3 v = across(widen<Wide>(bob.velocity_m_per_s), down(scene));
  const Wide3& chosen = norm(x) > 0 ? x : v;
  return norm(chosen) > 0 ? (1 / norm(chosen)) * chosen : Wide3{};
}

}  // namespace

bool is_swinging_atwood_machine(const Scene& scene) {
  if (scene.ropes.size() != 1 || !scene.joints.empty() || !scene.forces.empty() || scene.bodies.size() != 2)
    return false;
  const Rope& rope = scene.ropes.front();
  if (rope.over.empty() || norm(widen<Wide>(scene.gravity_m_per_s2)) == 0) return false;
  for (const Pulley& pulley : rope.over)
    if (pulley.radius_m != 0) return false;
  for (int end = 0; end < 2; ++end)
    if (scene.bodies[static_cast<std::size_t>(end)].fixed ||
        rope.points_body_m[static_cast<std::size_t>(end)] != Real3{})
      return false;
  const Ends ends = ends_of(scene);
  const Body &bob = scene.bodies[ends.bob], &heavy = scene.bodies[ends.heavy];
  if (heavy.mass_kg != 3 * bob.mass_kg) return false;
  const Wide3 d = down(scene), hangs = widen<Wide>(heavy.position_m) - ends.heavy_point;
  const Wide3 heavy_v = widen<Wide>(heavy.velocity_m_per_s), v = widen<Wide>(bob.velocity_m_per_s);
  const Wide3 normal = cross(d, sideways(scene, ends));
  return dot(hangs, d) > 0 && norm(across(hangs, d)) <= kAlong * norm(hangs) &&
         norm(across(heavy_v, d)) <= kAlong * norm(heavy_v) && magnitude(dot(v, normal)) <= kAlong * norm(v);
}

SwingingAtwood swinging_atwood(const Scene& scene, const SampleView& sample) {
  const Ends ends = ends_of(scene);
  const Wide3 d = down(scene), e = sideways(scene, ends);
  const Wide3 x = sample.bodies[ends.bob].p_m - ends.bob_point, v = sample.bodies[ends.bob].v_m_per_s;
  const Wide r = norm(x), g = norm(widen<Wide>(scene.gravity_m_per_s2));
  const Wide half = atan2q(dot(x, e), dot(x, d)) / 2;
  const Wide r_rate = dot(x, v) / r, angle_rate = (dot(x, d) * dot(v, e) - dot(x, e) * dot(v, d)) / (r * r);
  const Wide s = sinq(half), c = cosq(half);
  const Wide terms[] = {r * r * angle_rate * r_rate * c, -r * r * r * angle_rate * angle_rate * s / 2,
                        g * r * r * s * c * c};
  SwingingAtwood out;
  for (const Wide term : terms) {
    out.invariant += term;
    out.size += magnitude(term);
  }
  out.invariant = magnitude(out.invariant);
  return out;
}

}  // namespace atwood::dynamics
