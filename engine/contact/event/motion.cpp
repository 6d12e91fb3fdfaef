// Poses and gaps of bodies in a state.
#include "contact/event/run.hpp"
#include "math/so3.hpp"

namespace atwood::event {

template <class S> void take_pose(const EventRun<S>& run, int body, const S* y, Pose<S>& pose) {
  const int offset = run.model.offset(body);
  if (offset < 0) return;
  const S* at = y + offset;
  const bool moves = run.moves[body] != 0;
  pose.p = load3(at + kAtPosition);
  pose.v = moves ? load3(at + kAtVelocity) : Vec3<S>{};
  pose.w = {};
  if (!run.model.rotates(body)) return;
  const Quat<S> q = load4(at + kAtAttitude);
  const S two = S(2) / (q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);  // a method's stages are not of unit length
  const S x = two * q.x, y2 = two * q.y, z = two * q.z;
  const S xx = x * q.x, yy = y2 * q.y, zz = z * q.z, xy = x * q.y, xz = x * q.z, yz = y2 * q.z, wx = x * q.w,
          wy = y2 * q.w, wz = z * q.w;
  pose.axis[0] = {S(1) - yy - zz, xy + wz, xz - wy};
  pose.axis[1] = {xy - wz, S(1) - xx - zz, yz + wx};
  pose.axis[2] = {xz + wy, yz - wx, S(1) - xx - yy};
  if (moves) pose.w = turned(pose, load3(at + kAtBodyRate));
}

template <class S> Pose<S> pose_of(const EventRun<S>& run, int body, const S* y) {
  Pose<S> pose = run.poses[body];
  take_pose(run, body, y, pose);
  return pose;
}

template <class S> void pose_bodies(EventRun<S>& run, const Feature<S>& feature, const S* y) {
  for (const int body : {feature.knob_body, feature.surface_body}) take_pose(run, body, y, run.poses[body]);
}

// What of a knob stands on its surface's facet: of a rim the point that lies farthest against the face on its side.
template <class S> Vec3<S> outermost_of(const EventRun<S>& run, const Feature<S>& feature) {
  const Surface<S>& surface = run.surfaces[feature.surface];
  const Pose<S>&of = run.poses[feature.knob_body], &on = run.poses[feature.surface_body];
  if (feature.knob.centered) return of.p;
  if (!feature.knob.rim || surface.kind == SurfaceKind::plane) return of.p + turned(of, feature.knob.center_B);
  const Vec3<S> side_B = turned_back(on, of.p - on.p);
  S beside{};
  const Facet<S> face = nearest_facet(surface, side_B, true, side_B, beside);
  return outermost_of_rim(feature.knob, of, turned(on, face.direction_B));
}

template <class S> Facet<S> facet_under(const EventRun<S>& run, const Feature<S>& feature, S& beside) {
  const Surface<S>& surface = run.surfaces[feature.surface];
  beside = S(0);
  if (feature.knob.edge) return edge_facet_of(run, feature, beside);
  if (surface.kind == SurfaceKind::plane) return {2, {}, {}};
  if (surface.kind == SurfaceKind::point) return {0, {}, {}};
  const Pose<S>&of = run.poses[feature.knob_body], &on = run.poses[feature.surface_body];
  const Vec3<S> center = outermost_of(run, feature);
  const bool corner = surface.radius + feature.knob.radius == S(0) || !feature.knob.centered;
  const Vec3<S> center_B = turned_back(on, center - on.p), side_B = turned_back(on, of.p - on.p);
  if (surface.flat) {  // above one of its triangles: nothing is nearer
    const auto face = [&](const Triangle<S>& triangle) {
      const bool below = dot(triangle.normal_B, (corner ? side_B : center_B) - triangle.corner_B[0]) < S(0);
      return Facet<S>{2, triangle.corner_B[0], below ? -triangle.normal_B : triangle.normal_B};
    };
    if (within_triangle(surface.mesh[feature.over_triangle], center_B) > S(0))
      return face(surface.mesh[feature.over_triangle]);
    for (std::size_t i = 0; i < surface.mesh.size(); ++i) {
      if (!(within_triangle(surface.mesh[i], center_B) > S(0))) continue;
      feature.over_triangle = static_cast<int>(i);
      return face(surface.mesh[i]);
    }
  }
  return nearest_facet(surface, center_B, corner, side_B, beside);
}

template <class S> Sight<S> sight_of_ball(const EventRun<S>& run, const Feature<S>& feature, const S* y) {
  const Surface<S>& surface = run.surfaces[feature.surface];
  Sight<S> sight;
  const auto place = [&](int body) {
    const int at = run.model.offset(body);
    return at < 0 ? run.poses[body].p : load3(y + at);
  };
  const auto speed = [&](int body) {
    return run.moves[body] ? load3(y + run.model.offset(body) + kAtVelocity) : Vec3<S>{};
  };
  const Vec3<S> p = place(feature.knob_body), v = speed(feature.knob_body);
  if (surface.kind == SurfaceKind::plane) {
    sight.normal = surface.normal_W;
    sight.gap = dot(sight.normal, p) - surface.offset - feature.knob.radius;
    sight.rate = dot(sight.normal, v);
  } else {
    const Vec3<S> away = p - place(feature.surface_body);
    const Vec3<S> drift = v - speed(feature.surface_body);
    const S distance = norm(away);
    sight.normal = distance > S(0) ? (S(1) / distance) * away : Vec3<S>{S(0), S(0), S(1)};
    sight.gap = distance - feature.knob.radius - surface.radius;
    sight.rate = dot(sight.normal, drift);
  }
  sight.x = p - feature.knob.radius * sight.normal;
  return sight;
}

template <class S> Sight<S> posed_sight(const EventRun<S>& run, const Feature<S>& feature) {
  S beside{};
  const Facet<S> facet = facet_under(run, feature, beside);
  const Surface<S>& surface = run.surfaces[feature.surface];
  Sight<S> sight = look(feature.knob, run.poses[feature.knob_body], surface, facet, run.poses[feature.surface_body]);
  if (beside > S(0)) sight.gap = real::max(sight.gap, beside);  // a corner past the face's end is above nothing
  return sight;
}

template <class S> Sight<S> sight_of(EventRun<S>& run, const Feature<S>& feature, const S* y) {
  if (!needs_axes(run, feature)) return sight_of_ball(run, feature, y);
  pose_bodies(run, feature, y);
  return posed_sight(run, feature);
}

// I^-1 in world axes, R I_B^-1 R^T, by its action on the world's axes (it is symmetric, so columns are rows).
template <class S> ImpactBody<S> impact_body(const EventRun<S>& run, int body, const Vec3<S>& x_W) {
  const Pose<S>& pose = run.poses[body];
  ImpactBody<S> out;
  out.r_W = x_W - pose.p;
  if (!run.moves[body]) return out;
  const MassProperties<S>& mass = run.model.mass(body);
  out.inverse_mass_per_kg = mass.inverse_mass_per_kg;
  out.v_W = pose.v;
  if (!run.model.rotates(body)) return out;
  out.w_W = pose.w;
  const Vec3<S> axes[3] = {{S(1), S(0), S(0)}, {S(0), S(1), S(0)}, {S(0), S(0), S(1)}};
  for (int i = 0; i < 3; ++i)
    out.I_inverse_W_row[i] = run.round[body] ? mass.I_inverse_row[0].x * axes[i]
                                             : turned(pose, mass.times_inverse_inertia(turned_back(pose, axes[i])));
  return out;
}

template <class S> void store_velocity(EventRun<S>& run, int body, const Vec3<S>& v_W, const Vec3<S>& w_W, S* y) {
  if (!run.moves[body]) return;
  Pose<S>& pose = run.poses[body];
  S* at = y + run.model.offset(body);
  pose.v = v_W;
  store3(v_W, at + kAtVelocity);
  if (!run.model.rotates(body)) return;
  pose.w = w_W;
  store3(turned_back(pose, w_W), at + kAtBodyRate);
}

#define ATWOOD_MOTION(S)                                                               \
  template void take_pose<S>(const EventRun<S>&, int, const S*, Pose<S>&);             \
  template Pose<S> pose_of<S>(const EventRun<S>&, int, const S*);                      \
  template void pose_bodies<S>(EventRun<S>&, const Feature<S>&, const S*);             \
  template Vec3<S> outermost_of<S>(const EventRun<S>&, const Feature<S>&);             \
  template Facet<S> facet_under<S>(const EventRun<S>&, const Feature<S>&, S&);         \
  template Sight<S> sight_of_ball<S>(const EventRun<S>&, const Feature<S>&, const S*); \
  template Sight<S> posed_sight<S>(const EventRun<S>&, const Feature<S>&);             \
  template Sight<S> sight_of<S>(EventRun<S>&, const Feature<S>&, const S*);            \
  template ImpactBody<S> impact_body<S>(const EventRun<S>&, int, const Vec3<S>&);      \
  template void store_velocity<S>(EventRun<S>&, int, const Vec3<S>&, const Vec3<S>&, S*);
ATWOOD_MOTION(float)
ATWOOD_MOTION(double)
ATWOOD_MOTION(long double)
#undef ATWOOD_MOTION

}  // namespace atwood::event
