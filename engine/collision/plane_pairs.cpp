// A plane (a) against shapes (b) above it or in it: the lowest point, and the points of the same face or line that are
// within the margin. The normal, from a to b, is the plane's.
#include <array>

#include "collision/capsule_surface.hpp"
#include "collision/direction.hpp"
#include "collision/pair_tests.hpp"

namespace atwood {

namespace {

template <class S> struct SurfacePoint {
  Vec3<S> x_W;
  S height{};
  std::uint32_t id = 0;
};

template <class S> void add(Manifold<S>& m, const Vec3<S>& normal_W, const SurfacePoint<S>& low, S margin) {
  if (!(low.height <= margin)) return;
  m.points[static_cast<std::size_t>(m.count++)] = {low.x_W - (low.height / S(2)) * normal_W, low.height, low.id};
}

template <class S> Manifold<S>& new_manifold(const Posed<S>& plane, ManifoldType type, std::vector<Manifold<S>>& out) {
  Manifold<S>& m = out.emplace_back();
  m.normal_W = plane.shape.normal_W;
  m.type = type;
  return m;
}

template <class S> void set_type(Manifold<S>& m) {
  m.type = m.count > 2 ? ManifoldType::face : m.count == 2 ? ManifoldType::edge : ManifoldType::point;
}

template <class S> Separation<S> separation_at(const Posed<S>& plane, const Vec3<S>& x_W, S height) {
  return {height, plane.shape.normal_W, x_W - height * plane.shape.normal_W, x_W};
}

template <class S> S height_of_center(const Posed<S>& plane, const Posed<S>& b) {
  return dot(plane.shape.normal_W, b.pose.p_W) - plane.shape.offset;
}

// ---- boxes and rectangles -----------------------------------------------------------------------------------------
// A corner is p + sum s_k h_k axis_k, and its height above the plane
//   height(p) + sum s_k rise_k,   rise_k = h_k (n . axis_k).
template <class S> struct BoxHeights {
  S center, rise[3];
  Vec3<S> half_side[3];
  S lowest_height() const { return center - real::abs(rise[0]) - real::abs(rise[1]) - real::abs(rise[2]); }
};
template <class S> BoxHeights<S> box_heights(const Posed<S>& plane, const Posed<S>& b) {
  const Vec3<S>& n = plane.shape.normal_W;
  const Vec3<S>& h = b.shape.half_extents;
  const Vec3<S>* axis = b.pose.axis_W;
  return {height_of_center(plane, b),
          {h.x * dot(n, axis[0]), h.y * dot(n, axis[1]), h.z * dot(n, axis[2])},
          {h.x * axis[0], h.y * axis[1], h.z * axis[2]}};
}
// The corner whose sign s_k is positive where bit k of `bits` is set; the bits are its id.
template <class S> SurfacePoint<S> corner(const BoxHeights<S>& heights, const Vec3<S>& p_W, unsigned bits) {
  SurfacePoint<S> low{p_W, heights.center, bits};
  for (unsigned k = 0; k < 3; ++k) {
    const bool plus = (bits >> k) & 1u;
    low.height = plus ? low.height + heights.rise[k] : low.height - heights.rise[k];
    low.x_W = plus ? low.x_W + heights.half_side[k] : low.x_W - heights.half_side[k];
  }
  return low;
}
// The lowest corner: bit k is set where s_k = -sign(n . axis_k) is positive.
template <class S> unsigned lowest_corner(const Vec3<S>& n, const Vec3<S>* axis) {
  return (dot(n, axis[0]) < S(0) ? 1u : 0u) | (dot(n, axis[1]) < S(0) ? 2u : 0u) | (dot(n, axis[2]) < S(0) ? 4u : 0u);
}

// ---- cylinders ----------------------------------------------------------------------------------------------------
// `down` is the unit direction within the discs in which they sink deepest; without a tilt there is none, and it is
// zero.
template <class S> struct Tilt {
  S center, cosine, sine;  // cosine = n . axis, sine >= 0
  Vec3<S> down;
};
template <class S> Tilt<S> tilt_of(const Posed<S>& plane, const Posed<S>& b) {
  const Vec3<S>& n = plane.shape.normal_W;
  const S x = dot(n, b.pose.axis_W[0]), y = dot(n, b.pose.axis_W[1]);
  Tilt<S> out{height_of_center(plane, b), dot(n, b.pose.axis_W[2]), S(0), {}};
  Vec3<S> in_disc{};
  out.sine = length_and_direction(Vec3<S>{x, y, S(0)}, in_disc);
  out.down = -to_world(b.pose, in_disc);
  return out;
}
template <class S>
SurfacePoint<S> rim(const Tilt<S>& tilt, const Posed<S>& b, S disc, const Vec3<S>& radial, S radial_rise,
                    std::uint32_t id) {
  const S along = disc * b.shape.half_length;
  return {b.pose.p_W + (along * b.pose.axis_W[2] + b.shape.radius * radial),
          tilt.center + along * tilt.cosine + b.shape.radius * radial_rise, id};
}

// A disc that faces the plane: four points of its rim a quarter apart, fixed in the body; the nearest of them is
// replaced by the deepest point, so the depth is exact and the other three stay fixed on the body. Ids: 0 to 3 the rim
// points of the lower disc in body axes (disc < 0), 8 to 11 those of the upper; 4 and 12 the deepest points of their
// rims.
template <class S>
void disc_contacts(const Posed<S>& plane, const Tilt<S>& tilt, const Posed<S>& b, S disc, S margin, Manifold<S>& m) {
  const Vec3<S>* axis = b.pose.axis_W;
  const Vec3<S>& n = plane.shape.normal_W;
  const S down_x = dot(tilt.down, axis[0]), down_y = dot(tilt.down, axis[1]);
  const bool flat = !(tilt.sine > S(4) * real::epsilon<S>());
  const unsigned nearest =
      real::abs(down_y) > real::abs(down_x) ? (down_y < S(0) ? 3u : 1u) : (down_x < S(0) ? 2u : 0u);
  const std::uint32_t first_id = disc < S(0) ? 0u : 8u;
  for (unsigned k = 0; k < 4; ++k) {
    const Vec3<S> radial = k == 0 ? axis[0] : k == 1 ? axis[1] : k == 2 ? -axis[0] : -axis[1];
    if (!flat && k == nearest) add(m, n, rim(tilt, b, disc, tilt.down, -tilt.sine, first_id + k), margin);
    else add(m, n, rim(tilt, b, disc, radial, flat ? S(0) : dot(n, radial), first_id + k), margin);
  }
}

}  // namespace

template <class S>
void plane_box_contacts(const Posed<S>& a, const Posed<S>& b, S margin, std::vector<Manifold<S>>& out) {
  if (height_of_center(a, b) - b.shape.bounding_radius > margin) return;
  const BoxHeights<S> heights = box_heights(a, b);
  if (!(heights.lowest_height() <= margin)) return;
  // The four corners of the face most parallel to the plane.
  const Vec3<S>& n = a.shape.normal_W;
  const Vec3<S>* axis = b.pose.axis_W;
  const S x = real::abs(dot(n, axis[0])), y = real::abs(dot(n, axis[1])), z = real::abs(dot(n, axis[2]));
  const unsigned k = z >= x && z >= y ? 2u : y >= x ? 1u : 0u;
  const std::array<S, 3> h{b.shape.half_extents.x, b.shape.half_extents.y, b.shape.half_extents.z};
  const unsigned i = (k + 1) % 3, j = (k + 2) % 3, deepest = lowest_corner(n, axis);
  const unsigned u = h[i] > S(0) ? 1u << i : 0u, v = h[j] > S(0) ? 1u << j : 0u;  // a side without length has one end
  Manifold<S>& m = new_manifold(a, ManifoldType::face, out);
  add(m, n, {corner(heights, b.pose.p_W, deepest).x_W, heights.lowest_height(), deepest}, margin);
  if (u) add(m, n, corner(heights, b.pose.p_W, deepest ^ u), margin);
  if (u && v) add(m, n, corner(heights, b.pose.p_W, deepest ^ u ^ v), margin);
  if (v) add(m, n, corner(heights, b.pose.p_W, deepest ^ v), margin);
  set_type(m);
}
template <class S> Separation<S> plane_box_separation(const Posed<S>& a, const Posed<S>& b) {
  const BoxHeights<S> heights = box_heights(a, b);
  return separation_at(a, corner(heights, b.pose.p_W, lowest_corner(a.shape.normal_W, b.pose.axis_W)).x_W,
                       heights.lowest_height());
}

// Up to two points: the lowest of the lower cap, and the point below the upper end, if it lies on the cylindrical part.
template <class S>
void plane_capsule_contacts(const Posed<S>& a, const Posed<S>& b, S margin, std::vector<Manifold<S>>& out) {
  const Vec3<S>& n = a.shape.normal_W;
  const S center = height_of_center(a, b), cosine = dot(n, b.pose.axis_W[2]), rise = b.shape.half_length * cosine;
  if (!(center - real::abs(rise) - b.shape.radius <= margin)) return;
  const S sign = rise < S(0) ? S(1) : S(-1);  // of the lower end
  Manifold<S>& m = new_manifold(a, ManifoldType::edge, out);
  for (const S end : {sign, -sign}) {
    const S along = end * b.shape.half_length,
            thickness = core_to_surface(b.shape.radius, b.shape.half_length, along, -cosine);
    if (end != sign && real::abs(along - thickness * cosine) > b.shape.half_length) break;
    add(m, n,
        {b.pose.p_W + (along * b.pose.axis_W[2] - thickness * n), center + end * rise - thickness,
         end > S(0) ? 1u : 0u},
        margin);
    if (!(b.shape.half_length > S(0))) break;
  }
  set_type(m);
}
template <class S> Separation<S> plane_capsule_separation(const Posed<S>& a, const Posed<S>& b) {
  const Vec3<S>& n = a.shape.normal_W;
  const S rise = b.shape.half_length * dot(n, b.pose.axis_W[2]);
  const Vec3<S> half = (rise < S(0) ? b.shape.half_length : -b.shape.half_length) * b.pose.axis_W[2];
  return separation_at(a, b.pose.p_W + half - b.shape.radius * n,
                       height_of_center(a, b) - b.shape.radius - real::abs(rise));
}

template <class S>
void plane_cylinder_contacts(const Posed<S>& a, const Posed<S>& b, S margin, std::vector<Manifold<S>>& out) {
  if (height_of_center(a, b) - b.shape.bounding_radius > margin) return;
  const Tilt<S> tilt = tilt_of(a, b);
  const S lower = tilt.cosine < S(0) ? S(1) : S(-1);  // the disc that lies lower
  const SurfacePoint<S> deepest = rim(tilt, b, lower, tilt.down, -tilt.sine, lower < S(0) ? 4u : 12u);
  if (!(deepest.height <= margin)) return;
  Manifold<S>& m = new_manifold(a, ManifoldType::face, out);
  if (real::abs(tilt.cosine) > tilt.sine) {
    disc_contacts(a, tilt, b, lower, margin, m);
  } else {  // the lowest line of the side
    add(m, a.shape.normal_W, deepest, margin);
    add(m, a.shape.normal_W, rim(tilt, b, -lower, tilt.down, -tilt.sine, lower < S(0) ? 12u : 4u), margin);
  }
  set_type(m);
}
template <class S> Separation<S> plane_cylinder_separation(const Posed<S>& a, const Posed<S>& b) {
  const Tilt<S> tilt = tilt_of(a, b);
  const SurfacePoint<S> low = rim(tilt, b, tilt.cosine < S(0) ? S(1) : S(-1), tilt.down, -tilt.sine, 0u);
  return separation_at(a, low.x_W, low.height);
}

#define ATWOOD_PLANE_PAIR(S, other)                                                                          \
  template void plane_##other##_contacts<S>(const Posed<S>&, const Posed<S>&, S, std::vector<Manifold<S>>&); \
  template Separation<S> plane_##other##_separation<S>(const Posed<S>&, const Posed<S>&);
#define ATWOOD_PLANE_PAIRS(S) ATWOOD_PLANE_PAIR(S, box) ATWOOD_PLANE_PAIR(S, capsule) ATWOOD_PLANE_PAIR(S, cylinder)
ATWOOD_PLANE_PAIRS(float)
ATWOOD_PLANE_PAIRS(double)
ATWOOD_PLANE_PAIRS(long double)
#undef ATWOOD_PLANE_PAIRS
#undef ATWOOD_PLANE_PAIR

}  // namespace atwood
