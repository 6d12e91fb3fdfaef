// Poses of bodies and gaps of candidates in a state.
#include "contact/event/proximity.hpp"

#include "contact/event/edge_candidates.hpp"
#include "math/so3.hpp"

namespace atwood::event {

template <class S> void update_pose(const Bodies<S>& bodies, int body, const S* y, Pose<S>& pose) {
  const int offset = bodies.model.offset(body);
  if (offset < 0) return;
  const S* at = y + offset;
  const bool moves = bodies.moves[body] != 0;
  pose.p = load3(at + kAtPosition);
  pose.v = moves ? load3(at + kAtVelocity) : Vec3<S>{};
  pose.w = {};
  if (!bodies.model.rotates(body)) return;
  const Quat<S> q = load4(at + kAtAttitude);
  const S two = S(2) / (q.w * q.w + q.x * q.x + q.y * q.y +
                        q.z * q.z);  // quaternions at the stages of a method are not normalised
  const S x = two * q.x, y2 = two * q.y, z = two * q.z;
  const S xx = x * q.x, yy = y2 * q.y, zz = z * q.z, xy = x * q.y, xz = x * q.z, yz = y2 * q.z, wx = x * q.w,
          wy = y2 * q.w, wz = z * q.w;
  pose.axis[0] = {S(1) - yy - zz, xy + wz, xz - wy};
  pose.axis[1] = {xy - wz, S(1) - xx - zz, yz + wx};
  pose.axis[2] = {xz + wy, yz - wx, S(1) - xx - yy};
  if (moves) pose.w = to_world(pose, load3(at + kAtBodyRate));
}

template <class S> Pose<S> pose_of(const Bodies<S>& bodies, int body, const S* y) {
  Pose<S> pose = bodies.poses[body];
  update_pose(bodies, body, y, pose);
  return pose;
}

template <class S> void update_poses(Bodies<S>& bodies, const Candidate<S>& candidate, const S* y) {
  bodies.poses_version = 0;
  for (const int body : {candidate.feature_body, candidate.surface_body})
    update_pose(bodies, body, y, bodies.poses[body]);
}

namespace {

// The normal of the face of a box or a rectangle that a circle is over: the face on the side of the circle's body with
// the largest gap, measured at the circle's lowest point over that face.
template <class S>
Vec3<S> normal_below_circle(const Surface<S>& surface, const ContactFeature<S>& feature, const Pose<S>& of,
                            const Pose<S>& on, const Vec3<S>& side_B) {
  const bool sheet = surface.half_extents.z == S(0);
  Vec3<S> normal_B{S(0), S(0), side_B.z < S(0) ? S(-1) : S(1)};
  S widest{};
  for (int i = 0; i < 3 && !sheet; ++i) {
    Vec3<S> n_B;
    component(n_B, i) = component(side_B, i) < S(0) ? S(-1) : S(1);
    const Vec3<S> lowest = lowest_point_of_circle(feature, of, to_world(on, n_B));
    const S gap = dot(n_B, to_body(on, lowest - on.p)) - component(surface.half_extents, i);
    if (i > 0 && gap <= widest) continue;
    widest = gap;
    normal_B = n_B;
  }
  return normal_B;
}

// That face, and how far [m] the lowest point is beyond its boundary.
template <class S>
Facet<S> face_below_circle(const Surface<S>& surface, const ContactFeature<S>& feature, const Pose<S>& of,
                           const Pose<S>& on, S& outside_m) {
  const Vec3<S> n_B = normal_below_circle(surface, feature, of, on, to_body(on, of.p - on.p));
  const Vec3<S> lowest = to_body(on, lowest_point_of_circle(feature, of, to_world(on, n_B)) - on.p);
  Facet<S> facet{2, {}, n_B};
  for (int i = 0; i < 3; ++i) {
    if (component(n_B, i) != S(0)) component(facet.point_B, i) = component(surface.half_extents, i) * component(n_B, i);
    else outside_m = real::max(outside_m, real::abs(component(lowest, i)) - component(surface.half_extents, i));
  }
  return facet;
}

}  // namespace

template <class S>
Vec3<S> reference_point(const Bodies<S>& bodies, const Proximity<S>& proximity, const Candidate<S>& candidate) {
  const Surface<S>& surface = proximity.surfaces[candidate.surface];
  const Pose<S>&of = bodies.poses[candidate.feature_body], &on = bodies.poses[candidate.surface_body];
  if (candidate.feature.centered) return of.p;
  if (!candidate.feature.circle || surface.kind == SurfaceKind::plane)
    return of.p + to_world(of, candidate.feature.center_B);
  const Vec3<S> side_B = to_body(on, of.p - on.p);
  if (surface.kind == SurfaceKind::slab)
    return lowest_point_of_circle(candidate.feature, of,
                                  to_world(on, normal_below_circle(surface, candidate.feature, of, on, side_B)));
  S outside_m{};
  const Facet<S> face = nearest_facet(surface, side_B, true, side_B, outside_m);
  return lowest_point_of_circle(candidate.feature, of, to_world(on, face.direction_B));
}

template <class S>
Facet<S> facet_below(const Bodies<S>& bodies, const Proximity<S>& proximity, const Candidate<S>& candidate,
                     S& outside_m) {
  const Surface<S>& surface = proximity.surfaces[candidate.surface];
  outside_m = S(0);
  if (candidate.feature.edge) return edge_facet_of(bodies, proximity, candidate, outside_m);
  if (surface.kind == SurfaceKind::plane) return {2, {}, {}};
  if (surface.kind == SurfaceKind::point) return {0, {}, {}};
  const Pose<S>&of = bodies.poses[candidate.feature_body], &on = bodies.poses[candidate.surface_body];
  if (candidate.feature.circle && surface.kind == SurfaceKind::slab)
    return face_below_circle(surface, candidate.feature, of, on, outside_m);
  const Vec3<S> center = reference_point(bodies, proximity, candidate);
  // Features without a radius are vertices; so is a sphere off its body's centre, whose side of a face follows from its
  // body's centre.
  const bool is_vertex = surface.radius + candidate.feature.radius == S(0) || !candidate.feature.centered;
  const Vec3<S> center_B = to_body(on, center - on.p), side_B = to_body(on, of.p - on.p);
  if (surface.flat) {  // a triangle that the feature is above is the nearest facet
    const auto face = [&](const FacetTriangle<S>& triangle) {
      const bool below = dot(triangle.normal_B, (is_vertex ? side_B : center_B) - triangle.corner_B[0]) < S(0);
      return Facet<S>{2, triangle.corner_B[0], below ? -triangle.normal_B : triangle.normal_B};
    };
    if (depth_inside_triangle(surface.mesh[candidate.last_triangle], center_B) > S(0))
      return face(surface.mesh[candidate.last_triangle]);
    for (std::size_t i = 0; i < surface.mesh.size(); ++i) {
      if (!(depth_inside_triangle(surface.mesh[i], center_B) > S(0))) continue;
      candidate.last_triangle = static_cast<int>(i);
      return face(surface.mesh[i]);
    }
  }
  return nearest_facet(surface, center_B, is_vertex, side_B, outside_m);
}

template <class S>
GapKinematics<S> sphere_gap(const Bodies<S>& bodies, const Proximity<S>& proximity, const Candidate<S>& candidate,
                            const S* y) {
  const Surface<S>& surface = proximity.surfaces[candidate.surface];
  GapKinematics<S> kinematics;
  const auto position = [&](int body) {
    const int at = bodies.model.offset(body);
    return at < 0 ? bodies.poses[body].p : load3(y + at);
  };
  const auto velocity = [&](int body) {
    return bodies.moves[body] ? load3(y + bodies.model.offset(body) + kAtVelocity) : Vec3<S>{};
  };
  const Vec3<S> p = position(candidate.feature_body), v = velocity(candidate.feature_body);
  if (surface.kind == SurfaceKind::plane) {
    kinematics.normal = surface.normal_W;
    kinematics.gap = dot(kinematics.normal, p) - surface.offset - candidate.feature.radius;
    kinematics.rate = dot(kinematics.normal, v);
  } else {
    const Vec3<S> away = p - position(candidate.surface_body);
    const Vec3<S> relative_velocity = v - velocity(candidate.surface_body);
    const S distance = norm(away);
    kinematics.normal = distance > S(0) ? (S(1) / distance) * away : Vec3<S>{S(0), S(0), S(1)};
    kinematics.gap = distance - candidate.feature.radius - surface.radius;
    kinematics.rate = dot(kinematics.normal, relative_velocity);
  }
  kinematics.x = p - candidate.feature.radius * kinematics.normal;
  return kinematics;
}

template <class S>
GapKinematics<S> gap_from_poses(const Bodies<S>& bodies, const Proximity<S>& proximity, const Candidate<S>& candidate) {
  S outside_m{};
  const Facet<S> facet = facet_below(bodies, proximity, candidate, outside_m);
  const Surface<S>& surface = proximity.surfaces[candidate.surface];
  GapKinematics<S> kinematics = gap_kinematics(candidate.feature, bodies.poses[candidate.feature_body], surface, facet,
                                               bodies.poses[candidate.surface_body]);
  if (outside_m > S(0))
    kinematics.gap = real::max(kinematics.gap, outside_m);  // beyond the face's boundary there is no contact
  return kinematics;
}

template <class S>
GapKinematics<S> gap_at(Bodies<S>& bodies, const Proximity<S>& proximity, const Candidate<S>& candidate, const S* y) {
  if (!needs_orientation(proximity, candidate)) return sphere_gap(bodies, proximity, candidate, y);
  update_poses(bodies, candidate, y);
  return gap_from_poses(bodies, proximity, candidate);
}

// I^-1 = R I_B^-1 R^T by its action on the world's axes: it is symmetric, so columns are rows.
template <class S> ImpactBody<S> impact_body(const Bodies<S>& bodies, int body, const Vec3<S>& x_W) {
  const Pose<S>& pose = bodies.poses[body];
  ImpactBody<S> out;
  out.r_W = x_W - pose.p;
  if (!bodies.moves[body]) return out;
  const MassProperties<S>& mass = bodies.model.mass(body);
  out.inverse_mass_per_kg = mass.inverse_mass_per_kg;
  out.v_W = pose.v;
  if (!bodies.model.rotates(body)) return out;
  out.w_W = pose.w;
  const Vec3<S> axes[3] = {{S(1), S(0), S(0)}, {S(0), S(1), S(0)}, {S(0), S(0), S(1)}};
  for (int i = 0; i < 3; ++i)
    out.I_inverse_W_row[i] = bodies.isotropic[body]
                                 ? mass.I_inverse_row[0].x * axes[i]
                                 : to_world(pose, mass.times_inverse_inertia(to_body(pose, axes[i])));
  return out;
}

template <class S> void store_velocity(Bodies<S>& bodies, int body, const Vec3<S>& v_W, const Vec3<S>& w_W, S* y) {
  if (!bodies.moves[body]) return;
  Pose<S>& pose = bodies.poses[body];
  S* at = y + bodies.model.offset(body);
  pose.v = v_W;
  store3(v_W, at + kAtVelocity);
  if (!bodies.model.rotates(body)) return;
  pose.w = w_W;
  store3(to_body(pose, w_W), at + kAtBodyRate);
}

// (|v| + r |w|)^2 <= 2 (v^2 + r^2 w^2): most steps need no square root.
template <class S> void update_speed_scale(Bodies<S>& bodies, const S* y) {
  for (const int body : bodies.model.moving()) {
    const S* at = y + bodies.model.offset(body);
    const Vec3<S> v = load3(at + kAtVelocity), w = bodies.model.rotates(body) ? load3(at + kAtBodyRate) : Vec3<S>{};
    const S radius = bodies.bounding_radius[body];
    if (S(2) * (dot(v, v) + radius * radius * dot(w, w)) <= bodies.speed_scale * bodies.speed_scale) continue;
    bodies.speed_scale = real::max(bodies.speed_scale, norm(v) + radius * norm(w));
  }
}

#define ATWOOD_KINEMATICS(S)                                                                                     \
  template void update_pose<S>(const Bodies<S>&, int, const S*, Pose<S>&);                                       \
  template void update_speed_scale<S>(Bodies<S>&, const S*);                                                     \
  template Pose<S> pose_of<S>(const Bodies<S>&, int, const S*);                                                  \
  template void update_poses<S>(Bodies<S>&, const Candidate<S>&, const S*);                                      \
  template Vec3<S> reference_point<S>(const Bodies<S>&, const Proximity<S>&, const Candidate<S>&);               \
  template Facet<S> facet_below<S>(const Bodies<S>&, const Proximity<S>&, const Candidate<S>&, S&);              \
  template GapKinematics<S> sphere_gap<S>(const Bodies<S>&, const Proximity<S>&, const Candidate<S>&, const S*); \
  template GapKinematics<S> gap_from_poses<S>(const Bodies<S>&, const Proximity<S>&, const Candidate<S>&);       \
  template GapKinematics<S> gap_at<S>(Bodies<S>&, const Proximity<S>&, const Candidate<S>&, const S*);           \
  template ImpactBody<S> impact_body<S>(const Bodies<S>&, int, const Vec3<S>&);                                  \
  template void store_velocity<S>(Bodies<S>&, int, const Vec3<S>&, const Vec3<S>&, S*);
ATWOOD_KINEMATICS(float)
ATWOOD_KINEMATICS(double)
ATWOOD_KINEMATICS(long double)
#undef ATWOOD_KINEMATICS

}  // namespace atwood::event
