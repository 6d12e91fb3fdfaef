#include "collision/geometry.hpp"

#include <limits>
#include <type_traits>

#include "collision/hull.hpp"
#include "collision/triangle_mesh.hpp"

namespace atwood {

namespace {

// Bounding radii and boxes must hold the shape, not its rounded copy: half an ulp here and there is given back.
template <class S> constexpr S kOutward = S(1) + S(4) * real::epsilon<S>();

template <class S> Vec3<S> with_signs(const Vec3<S>& v, int bits) {
  return {bits & 1 ? -v.x : v.x, bits & 2 ? -v.y : v.y, bits & 4 ? -v.z : v.z};
}

template <class S> S farthest(const std::vector<Real3>& points) {
  S most{};
  for (const Real3& p : points) most = real::max(most, norm(narrow3<S>(p)));
  return most;
}

template <class S> Aabb<S> around(const Vec3<S>& center, const Vec3<S>& half_extent) {
  const auto low = [](S p, S r) { return p - r - S(2) * real::epsilon<S>() * (real::abs(p) + r); };
  const auto high = [](S p, S r) { return p + r + S(2) * real::epsilon<S>() * (real::abs(p) + r); };
  return {{low(center.x, half_extent.x), low(center.y, half_extent.y), low(center.z, half_extent.z)},
          {high(center.x, half_extent.x), high(center.y, half_extent.y), high(center.z, half_extent.z)}};
}

template <class S> Vec3<S> magnitude(const Vec3<S>& v) { return {real::abs(v.x), real::abs(v.y), real::abs(v.z)}; }

template <class S> Vec3<S> box_half_extents(const Vec3<S>* axis_W, const Vec3<S>& h) {
  return h.x * magnitude(axis_W[0]) + h.y * magnitude(axis_W[1]) + h.z * magnitude(axis_W[2]);
}

template <class S> void join(Aabb<S>& box, const Aabb<S>& other) {
  box.low = {real::min(box.low.x, other.low.x), real::min(box.low.y, other.low.y), real::min(box.low.z, other.low.z)};
  box.high = {real::max(box.high.x, other.high.x), real::max(box.high.y, other.high.y),
              real::max(box.high.z, other.high.z)};
}

template <class S> Aabb<S> around_points(const std::vector<Vec3<S>>& points, const Transform<S>& pose) {
  Aabb<S> all;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3<S> out = to_world(pose, points[i]);
    const Vec3<S> point = pose.p_W + out;
    const Aabb<S> one = around(point, real::epsilon<S>() * magnitude(out));
    if (i == 0) all = one;
    else join(all, one);
  }
  return all;
}

}  // namespace

// R = 1 + 2 / |q|^2 (w [u] + [u]^2): the division makes a quaternion that is a few ulp off the unit sphere harmless.
template <class S> Transform<S> transform(const Vec3<S>& p_WB, const Quat<S>& q) {
  const S two = S(2) / (q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  const S x = two * q.x, y = two * q.y, z = two * q.z;
  const S xx = x * q.x, yy = y * q.y, zz = z * q.z, xy = x * q.y, xz = x * q.z, yz = y * q.z;
  const S wx = x * q.w, wy = y * q.w, wz = z * q.w;
  return {p_WB,
          {{S(1) - (yy + zz), xy + wz, xz - wy},
           {xy - wz, S(1) - (xx + zz), yz + wx},
           {xz + wy, yz - wx, S(1) - (xx + yy)}}};
}

template <class S> Transform<S> part_transform(const Transform<S>& body, const typename Geometry<S>::Part& part) {
  Transform<S> in_body = transform(part.p_B, part.q_BP), out;
  out.p_W = body.p_W + to_world(body, in_body.p_W);
  for (int k = 0; k < 3; ++k) out.axis_W[k] = to_world(body, in_body.axis_W[k]);
  return out;
}

template <class S> Geometry<S> make_geometry(const Shape& shape) {
  Geometry<S> g;
  g.kind = static_cast<ShapeKind>(shape.index());
  std::visit(
      [&g]<class T>(const T& from) {
        if constexpr (std::is_same_v<T, Sphere>) {
          g.radius = S(from.radius_m);
          g.bounding_radius = g.radius;
        } else if constexpr (std::is_same_v<T, Plane>) {
          const Vec3<S> given = narrow3<S>(from.normal);
          const S scale = S(1) / norm(given);
          g.normal_W = scale * given;
          g.offset = scale * S(from.offset_m);
          g.bounding_radius = std::numeric_limits<S>::infinity();
        } else if constexpr (std::is_same_v<T, Rectangle>) {
          g.half_extents = {S(from.half_extents_m[0]), S(from.half_extents_m[1]), S(0)};
          g.bounding_radius = kOutward<S> * norm(g.half_extents);
        } else if constexpr (std::is_same_v<T, Box>) {
          g.half_extents = narrow3<S>(from.half_extents_m);
          g.bounding_radius = kOutward<S> * norm(g.half_extents);
        } else if constexpr (std::is_same_v<T, Capsule>) {
          g.radius = S(from.radius_m), g.half_length = S(from.half_length_m);
          g.bounding_radius = kOutward<S> * (g.radius + g.half_length);
        } else if constexpr (std::is_same_v<T, Cylinder>) {
          g.radius = S(from.radius_m), g.half_length = S(from.half_length_m);
          g.bounding_radius = kOutward<S> * norm(Vec3<S>{g.radius, g.half_length, S(0)});
        } else if constexpr (std::is_same_v<T, Convex> || std::is_same_v<T, Mesh>) {
          g.bounding_radius = kOutward<S> * farthest<S>(from.points_m);
          if constexpr (std::is_same_v<T, Convex>) g.hull = make_hull<S>(from);
          else g.mesh = make_triangle_mesh<S>(from);
        } else if constexpr (std::is_same_v<T, Compound>) {
          for (const auto& box : from.boxes) {
            const Real4& q = box.orientation_wxyz;
            const typename Geometry<S>::Part part{
                narrow3<S>(box.half_extents_m), narrow3<S>(box.position_body_m), {S(q[0]), S(q[1]), S(q[2]), S(q[3])}};
            const Transform<S> pose = transform(part.p_B, part.q_BP);
            for (int corner = 0; corner < 8; ++corner)
              g.bounding_radius =
                  real::max(g.bounding_radius,
                            kOutward<S> * norm(pose.p_W + to_world(pose, with_signs(part.half_extents, corner))));
            g.parts.push_back(part);
          }
        }
      },
      shape);
  return g;
}

template <class S> Aabb<S> bounds(const Geometry<S>& g, const Transform<S>& pose) {
  const Vec3<S>* axis = pose.axis_W;
  switch (g.kind) {
    case ShapeKind::sphere: return around(pose.p_W, {g.radius, g.radius, g.radius});
    case ShapeKind::rectangle:
    case ShapeKind::box: return around(pose.p_W, box_half_extents(axis, g.half_extents));
    case ShapeKind::capsule:
      return around(pose.p_W, g.half_length * magnitude(axis[2]) + Vec3<S>{g.radius, g.radius, g.radius});
    case ShapeKind::cylinder: {  // a disc of unit normal z reaches sqrt(1 - z_k^2) = |(x_k, y_k)| along world axis k
      const Vec3<S> disc{real::sqrt(axis[0].x * axis[0].x + axis[1].x * axis[1].x),
                         real::sqrt(axis[0].y * axis[0].y + axis[1].y * axis[1].y),
                         real::sqrt(axis[0].z * axis[0].z + axis[1].z * axis[1].z)};
      return around(pose.p_W, g.half_length * magnitude(axis[2]) + g.radius * disc);
    }
    case ShapeKind::convex: return around_points(g.hull->vertices, pose);
    case ShapeKind::mesh: return around_points(g.mesh->points, pose);
    case ShapeKind::compound: {
      Aabb<S> all;
      for (std::size_t i = 0; i < g.parts.size(); ++i) {
        const Transform<S> part = part_transform(pose, g.parts[i]);
        const Aabb<S> box = around(part.p_W, box_half_extents(part.axis_W, g.parts[i].half_extents));
        if (i == 0) all = box;
        else join(all, box);
      }
      return all;
    }
    case ShapeKind::plane: {
      const S far = std::numeric_limits<S>::infinity();
      return {{-far, -far, -far}, {far, far, far}};
    }
    default: return around(pose.p_W, {g.bounding_radius, g.bounding_radius, g.bounding_radius});
  }
}

#define ATWOOD_GEOMETRY(S)                                                                \
  template Transform<S> transform<S>(const Vec3<S>&, const Quat<S>&);                     \
  template Transform<S> part_transform<S>(const Transform<S>&, const Geometry<S>::Part&); \
  template Geometry<S> make_geometry<S>(const Shape&);                                    \
  template Aabb<S> bounds<S>(const Geometry<S>&, const Transform<S>&);
ATWOOD_GEOMETRY(float)
ATWOOD_GEOMETRY(double)
ATWOOD_GEOMETRY(long double)
#undef ATWOOD_GEOMETRY

}  // namespace atwood
