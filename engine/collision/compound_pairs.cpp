#include "collision/compound_pairs.hpp"

#include <limits>

namespace atwood {

namespace {

template <class S> Geometry<S> box_of(const typename Geometry<S>::Part& part) {
  Geometry<S> box;
  box.kind = ShapeKind::box;
  box.half_extents = part.half_extents;
  box.bounding_radius = (S(1) + S(4) * real::epsilon<S>()) * norm(part.half_extents);
  return box;
}

// The distance that two bounding spheres certainly keep (planes have no sphere: the plane's own distance).
template <class S> S spheres_apart(const Posed<S>& a, const Vec3<S>& p_W, S radius) {
  if (a.shape.kind == ShapeKind::plane) return dot(a.shape.normal_W, p_W) - a.shape.offset - radius;
  return (S(1) - S(4) * real::epsilon<S>()) * norm(p_W - a.pose.p_W) - a.shape.bounding_radius - radius;
}

}  // namespace

template <class S>
void compound_contacts(const Posed<S>& a, const Posed<S>& b, S margin, std::vector<Manifold<S>>& out) {
  if (spheres_apart(a, b.pose.p_W, b.shape.bounding_radius) > margin) return;
  for (std::size_t i = 0; i < b.shape.parts.size(); ++i) {
    const Geometry<S> box = box_of<S>(b.shape.parts[i]);
    const Transform<S> pose = part_transform(b.pose, b.shape.parts[i]);
    if (spheres_apart(a, pose.p_W, box.bounding_radius) > margin) continue;
    const std::size_t from = out.size();
    find_contacts(a.shape, a.pose, box, pose, margin, out);
    for (std::size_t k = from; k < out.size(); ++k) out[k].part_b = static_cast<int>(i);
  }
}

template <class S> Separation<S> compound_separation(const Posed<S>& a, const Posed<S>& b) {
  Separation<S> least;
  least.gap = std::numeric_limits<S>::infinity();
  for (const auto& part : b.shape.parts) {
    const Geometry<S> box = box_of<S>(part);
    const Transform<S> pose = part_transform(b.pose, part);
    if (spheres_apart(a, pose.p_W, box.bounding_radius) > least.gap) continue;
    const Separation<S> one = separation(a.shape, a.pose, box, pose);
    if (one.gap < least.gap) least = one;
  }
  return least;
}

#define ATWOOD_COMPOUND_PAIRS(S)                                                                      \
  template void compound_contacts<S>(const Posed<S>&, const Posed<S>&, S, std::vector<Manifold<S>>&); \
  template Separation<S> compound_separation<S>(const Posed<S>&, const Posed<S>&);
ATWOOD_COMPOUND_PAIRS(float)
ATWOOD_COMPOUND_PAIRS(double)
ATWOOD_COMPOUND_PAIRS(long double)
#undef ATWOOD_COMPOUND_PAIRS

}  // namespace atwood
