#include "contact/stepping/impact_prediction.hpp"

#include "contact/stepping/contact_points.hpp"

namespace atwood::stepping {

template <class S> LinearMotion<S> linear_motion(const World<S>& world, int body) {
  const BodyRows<S>& bodies = world.bodies;
  if (!bodies.moves[body]) return {load3(bodies.pose[body].at), {}, {}, {}};
  const S *p = bodies.pose[body].at, *v = bodies.velocity[body].at, *shift = bodies.impact_shift[body].at;
  return {load3(p) + load3(shift), load3(v), load3(v + 3), load3(bodies.velocity_increment[body].at)};
}

namespace {

// The predict_* functions below ask whether a gap closes within within_s, at the present velocities or with the
// velocity increment added, and whether it then closes faster than that increment. An overlap gives an impact at time
// 0.

// Two spheres: |d + u t| = r_a + r_b.
template <class S>
PredictedImpact<S> predict_sphere_impact(const SphereBatch<S>& batch, int k, const LinearMotion<S>& a,
                                         const LinearMotion<S>& b, S within_s) {
  PredictedImpact<S> out;
  const S r_a = batch.radius_a.lane[k], r_b = batch.radius_b.lane[k], radii = r_a + r_b;
  const Vec3<S> d = b.p - a.p, u = b.v - a.v, dv = b.dv - a.dv;
  const S du = dot(d, u), c = dot(d, d) - radii * radii, uu = dot(u, u);
  if (!(du < S(0))) return out;
  if (c > S(0)) {
    const S discriminant = du * du - uu * c;
    if (!(discriminant > S(0))) return out;
    out.t_s = c / (-du + real::sqrt(discriminant));
    if (!(out.t_s <= within_s)) {  // later, unless the velocity increment closes the remaining gap
      const Vec3<S> end = d + within_s * (u + dv);
      if (!(dot(end, end) < radii * radii)) return out;
      out.t_s = within_s;
    }
  }
  const Vec3<S> at = d + out.t_s * u;
  const S distance = norm(at);
  if (!(distance > S(0))) return out;
  out.normal = (S(1) / distance) * at;
  const S half = (distance - radii) / S(2);  // of an overlap: one point for both, midway
  out.arm_a = (r_a + half) * out.normal;
  out.arm_b = -(r_b + half) * out.normal;
  out.occurs = dot(u, out.normal) < -real::abs(dot(dv, out.normal));
  return out;
}

template <class S>
PredictedImpact<S> predict_plane_impact(const SphereBatch<S>& batch, int k, const LinearMotion<S>& a, S within_s) {
  PredictedImpact<S> out;
  out.normal = lane_vector(batch.normal, k);
  const S gap = -dot(out.normal, a.p) - batch.radius_a.lane[k] - batch.radius_b.lane[k];
  const S approach = dot(a.v, out.normal), dv_n = dot(a.dv, out.normal);
  if (!(approach > real::abs(dv_n))) return out;
  if (gap > S(0)) {
    out.t_s = gap / approach;
    if (out.t_s > within_s) {
      if (!(gap < within_s * (approach + dv_n))) return out;
      out.t_s = within_s;
    }
  }
  out.arm_a = batch.radius_a.lane[k] * out.normal;
  out.occurs = true;
  return out;
}

// A point of a manifold, along the manifold's normal. rotation_a, rotation_b: rotation vectors since detection.
template <class S>
PredictedImpact<S> predict_point_impact(const ManifoldBatch<S>& batch, int k, int i, const LinearMotion<S>& a,
                                        const LinearMotion<S>& b, const Vec3<S>& rotation_a, const Vec3<S>& rotation_b,
                                        S within_s) {
  PredictedImpact<S> out;
  const ManifoldPoint<S>& point = batch.point[i];
  if (!(point.gap_at_detection.lane[k] < S(kMaxValue))) return out;
  out.normal = lane_vector(batch.normal, k);
  const Rounding<S> rounding_a{lane_vector(batch.rounding_axis_a, k), batch.rounding_radius_a.lane[k]};
  const Rounding<S> rounding_b{lane_vector(batch.rounding_axis_b, k), batch.rounding_radius_b.lane[k]};
  const auto [arm_a, arm_b, gap] = advance_point<S, S>(
      out.normal, lane_vector(point.r_a, k), lane_vector(point.r_b, k), point.gap_at_detection.lane[k], b.p - a.p,
      rotation_a, rotation_b, rounding_a, rounding_b, batch.witness_offset.lane[k]);
  out.arm_a = arm_a;
  out.arm_b = arm_b;
  const Vec3<S> u = (b.v + cross(b.w, out.arm_b)) - (a.v + cross(a.w, out.arm_a));
  const S approach = -dot(u, out.normal), dv_n = -dot(b.dv - a.dv, out.normal);
  if (!(approach > real::abs(dv_n))) return out;
  if (gap > S(0)) {
    out.t_s = gap / approach;
    if (out.t_s > within_s) {
      if (!(gap < within_s * (approach + dv_n))) return out;
      out.t_s = within_s;
    }
  }
  out.occurs = true;
  return out;
}

// The next impact from now_s on, within within_s of it; the time is relative to now_s.
template <class S> PredictedImpact<S> predict_impact_after(const World<S>& world, int contact, S now_s, S within_s) {
  const ContactAddress at = address_of(world, contact);
  const auto [a, b] = bodies_of(world, contact);
  LinearMotion<S> fa = linear_motion(world, a), fb = linear_motion(world, b);
  fa.p += now_s * fa.v;
  fb.p += now_s * fb.v;
  if (at.point < 0) {
    const SphereBatch<S>& batch = sphere_batch(world, at);
    if (world.geometry[b].kind == ShapeKind::plane) return predict_plane_impact(batch, at.lane, fa, within_s);
    return predict_sphere_impact(batch, at.lane, fa, fb, within_s);
  }
  const auto rotation = [&](int body) {
    if (!world.bodies.moves[body]) return Vec3<S>{};
    const BodyRows<S>& all = world.bodies;
    return load3(all.pose[body].at + 3) + load3(all.impact_shift[body].at + 3) +
           now_s * load3(all.velocity[body].at + 3);
  };
  const ManifoldBatch<S>& batch = manifold_batch(world, at);
  const Vec3<S> rotation_a = rotation(a) - lane_vector(batch.rotation_a, at.lane),
                rotation_b = rotation(b) - lane_vector(batch.rotation_b, at.lane);
  return predict_point_impact(batch, at.lane, at.point, fa, fb, rotation_a, rotation_b, within_s);
}

}  // namespace

template <class S> PredictedImpact<S> predict_impact(const World<S>& world, int contact, S now_s) {
  PredictedImpact<S> out = predict_impact_after(world, contact, now_s, world.sub_s - now_s);
  out.t_s += now_s;
  return out;
}

#define ATWOOD_IMPACT_PREDICTION(S)                                \
  template LinearMotion<S> linear_motion<S>(const World<S>&, int); \
  template PredictedImpact<S> predict_impact<S>(const World<S>&, int, S);
ATWOOD_IMPACT_PREDICTION(float)
ATWOOD_IMPACT_PREDICTION(double)
#undef ATWOOD_IMPACT_PREDICTION

}  // namespace atwood::stepping
