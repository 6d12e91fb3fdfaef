#include "collision/convex_contacts.hpp"

#include <limits>

#include "collision/convex_manifold.hpp"

namespace atwood {
namespace {

template <class S> void express_in_world(const Transform<S>& pose_a, Manifold<S>& manifold) {
  manifold.normal_W = to_world(pose_a, manifold.normal_W);
  for (int i = 0; i < manifold.count; ++i) manifold.points[i].x_W = point_to_world(pose_a, manifold.points[i].x_W);
}

template <class S> S size_of(const ConvexPart<S>& part) {
  return part.radius + (part.core == Core::hull ? part.topology->bounding_radius : norm(part.half));
}

// The mean of the deepest contact points (within round-off) of two parts whose faces touch.
template <class S>
Vec3<S> middle_of_deepest(const ConvexPart<S>& a, const ConvexPart<S>& b, const Transform<S>& b_in_a,
                          const NearestFeatures<S>& features, const Vec3<S>& otherwise) {
  Manifold<S> manifold;
  contact_points(a, b, b_in_a, features, std::numeric_limits<S>::infinity(), manifold);
  S least = std::numeric_limits<S>::infinity(), count = S(0);
  for (int i = 0; i < manifold.count; ++i) least = real::min(least, manifold.points[i].gap);
  const S level = least + S(64) * real::epsilon<S>() * (size_of(a) + size_of(b) + norm(b_in_a.p_W));
  Vec3<S> sum;
  for (int i = 0; i < manifold.count; ++i)
    if (manifold.points[i].gap <= level) sum += manifold.points[i].x_W, count += S(1);
  return count > S(0) ? (S(1) / count) * sum : otherwise;
}

}  // namespace

template <class S>
void convex_contacts(const Geometry<S>& a, const Transform<S>& pose_a, const Geometry<S>& b, const Transform<S>& pose_b,
                     S margin, std::vector<Manifold<S>>& out) {
  ConvexPart<S> part_a, part_b;
  if (!convex_part(a, part_a) || !convex_part(b, part_b)) return;
  const Transform<S> b_in_a = relative_transform(pose_a, pose_b);
  const S max_distance = margin + part_a.radius + part_b.radius;
  if (norm(b_in_a.p_W) > (size_of(part_a) + size_of(part_b) + margin) * (S(1) + S(8) * real::epsilon<S>())) return;
  const NearestFeatures<S> features = nearest_features(part_a, part_b, b_in_a, max_distance);
  if (features.out_of_range || features.gap > max_distance) return;
  Manifold<S> manifold;
  contact_points(part_a, part_b, b_in_a, features, margin, manifold);
  if (manifold.count == 0) return;
  express_in_world(pose_a, manifold);
  out.push_back(manifold);
}

template <class S>
Separation<S> convex_separation(const Geometry<S>& a, const Transform<S>& pose_a, const Geometry<S>& b,
                                const Transform<S>& pose_b) {
  constexpr S unbounded = std::numeric_limits<S>::infinity();
  ConvexPart<S> part_a, part_b;
  if (!convex_part(a, part_a) || !convex_part(b, part_b))
    return {unbounded, {S(0), S(0), S(1)}, pose_a.p_W, pose_b.p_W};
  const Transform<S> b_in_a = relative_transform(pose_a, pose_b);
  const NearestFeatures<S> features = nearest_features(part_a, part_b, b_in_a, unbounded);
  const S gap = features.gap - part_a.radius - part_b.radius;
  Vec3<S> middle =
      S(0.5) * ((features.on_a + part_a.radius * features.normal) + (features.on_b - part_b.radius * features.normal));
  if (features.faces) middle = middle_of_deepest(part_a, part_b, b_in_a, features, middle);
  const Vec3<S> half = (gap / S(2)) * features.normal;
  return {gap, to_world(pose_a, features.normal), point_to_world(pose_a, middle - half),
          point_to_world(pose_a, middle + half), features.solve};
}

template <class S>
void hull_plane_contacts(const Geometry<S>& plane, const Geometry<S>& hull, const Transform<S>& pose_hull, S margin,
                         std::vector<Manifold<S>>& out) {
  static thread_local std::vector<ContactPoint<S>> found;
  found.clear();
  if (!hull.hull) return;
  // Heights are computed in the hull's axes, relative to its centre: only `plane_offset`, a difference of offsets,
  // involves large numbers.
  const Vec3<S> n = to_body(pose_hull, plane.normal_W);
  const S plane_offset = plane.offset - dot(plane.normal_W, pose_hull.p_W);
  for (std::size_t i = 0; i < hull.hull->vertices.size(); ++i) {
    const Vec3<S>& v = hull.hull->vertices[i];
    const S gap = dot(n, v) - plane_offset;
    if (gap <= margin)
      found.push_back(
          {point_to_world(pose_hull, v) - (gap / S(2)) * plane.normal_W, gap, static_cast<std::uint32_t>(i + 1)});
  }
  if (found.empty()) return;
  Manifold<S> manifold;
  manifold.normal_W = plane.normal_W;
  keep_four(found, plane.normal_W, manifold);
  out.push_back(manifold);
}

template <class S>
Separation<S> hull_plane_separation(const Geometry<S>& plane, const Geometry<S>& hull, const Transform<S>& pose_hull) {
  if (!hull.hull || hull.hull->vertices.empty())
    return {std::numeric_limits<S>::infinity(), plane.normal_W, plane.offset * plane.normal_W, pose_hull.p_W};
  const Vec3<S> n = to_body(pose_hull, plane.normal_W);
  const Vec3<S>& v = hull.hull->vertices[farthest_vertex(*hull.hull, -n)];
  const S gap = dot(n, v) - (plane.offset - dot(plane.normal_W, pose_hull.p_W));
  const Vec3<S> x_W = point_to_world(pose_hull, v);
  return {gap, plane.normal_W, x_W - gap * plane.normal_W, x_W};
}

#define ATWOOD_CONVEX_CONTACTS(S)                                                                                    \
  template void convex_contacts<S>(const Geometry<S>&, const Transform<S>&, const Geometry<S>&, const Transform<S>&, \
                                   S, std::vector<Manifold<S>>&);                                                    \
  template Separation<S> convex_separation<S>(const Geometry<S>&, const Transform<S>&, const Geometry<S>&,           \
                                              const Transform<S>&);                                                  \
  template void hull_plane_contacts<S>(const Geometry<S>&, const Geometry<S>&, const Transform<S>&, S,               \
                                       std::vector<Manifold<S>>&);                                                   \
  template Separation<S> hull_plane_separation<S>(const Geometry<S>&, const Geometry<S>&, const Transform<S>&);
ATWOOD_CONVEX_CONTACTS(float)
ATWOOD_CONVEX_CONTACTS(double)
ATWOOD_CONVEX_CONTACTS(long double)
#undef ATWOOD_CONVEX_CONTACTS

}  // namespace atwood
