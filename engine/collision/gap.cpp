#include "collision/gap.hpp"

namespace atwood {

namespace {

const char* shape_name(const Shape& shape) {
  constexpr const char* names[] = {"point",   "sphere",   "plane",  "rectangle", "box",
                                   "capsule", "cylinder", "convex", "mesh",      "compound"};
  return names[shape.index()];
}

// A sphere's and a plane's surfaces along the plane's normal.
template <class S> Gap<S> sphere_to_plane(const Vec3<S>& center, S radius, const Vec3<S>& normal, S offset) {
  const S distance = dot(normal, center) - offset - radius;
  return {distance, -normal, center - (radius + distance / S(2)) * normal};
}

}  // namespace

template <class S> std::vector<ContactPair<S>> contact_pairs(const Scene& scene, std::string& why) {
  std::vector<ContactPair<S>> pairs;
  const int n = static_cast<int>(scene.bodies.size());
  for (int a = 0; a < n; ++a) {
    for (int b = a + 1; b < n; ++b) {
      const Body& body_a = scene.bodies[a];
      const Body& body_b = scene.bodies[b];
      if (body_a.shape.index() == 0 || body_b.shape.index() == 0 || (body_a.fixed && body_b.fixed)) continue;
      ContactPair<S> pair;
      pair.a = a;
      pair.b = b;
      const PairLaw& law = pair_law(scene, a, b);
      pair.restitution = S(law.restitution);
      pair.friction = S(law.friction);
      auto take = [&](const Body& body, S& radius, bool& is_plane) {
        if (const auto* sphere = std::get_if<Sphere>(&body.shape)) {
          radius = S(sphere->radius_m);
          return true;
        }
        if (const auto* plane = std::get_if<Plane>(&body.shape)) {
          is_plane = true;
          pair.plane_normal = narrow3<S>(plane->normal);
          pair.plane_normal = (S(1) / norm(pair.plane_normal)) * pair.plane_normal;
          pair.plane_offset = S(plane->offset_m);
          return true;
        }
        return false;
      };
      const bool known = take(body_a, pair.radius_a, pair.plane_a) && take(body_b, pair.radius_b, pair.plane_b);
      if (!known || (pair.plane_a && pair.plane_b)) {
        why = std::string("atwood has no contact between ") + shape_name(body_a.shape) + " `" + body_a.name + "` and " +
              shape_name(body_b.shape) + " `" + body_b.name + "`";
        return {};
      }
      pairs.push_back(pair);
    }
  }
  return pairs;
}

template <class S> Gap<S> gap_between(const ContactPair<S>& pair, const Vec3<S>& p_a, const Vec3<S>& p_b) {
  if (pair.plane_b) return sphere_to_plane(p_a, pair.radius_a, pair.plane_normal, pair.plane_offset);
  if (pair.plane_a) {
    Gap<S> gap = sphere_to_plane(p_b, pair.radius_b, pair.plane_normal, pair.plane_offset);
    gap.normal_W = -gap.normal_W;
    return gap;
  }
  const Vec3<S> between = p_b - p_a;
  const S centers = norm(between);
  const Vec3<S> normal = centers > S(0) ? (S(1) / centers) * between : Vec3<S>{S(0), S(0), S(1)};
  const S distance = centers - pair.radius_a - pair.radius_b;
  return {distance, normal, p_a + (pair.radius_a + distance / S(2)) * normal};
}

#define ATWOOD_GAP(S)                                                                \
  template std::vector<ContactPair<S>> contact_pairs<S>(const Scene&, std::string&); \
  template Gap<S> gap_between<S>(const ContactPair<S>&, const Vec3<S>&, const Vec3<S>&);
ATWOOD_GAP(float)
ATWOOD_GAP(double)
ATWOOD_GAP(long double)
#undef ATWOOD_GAP

}  // namespace atwood
