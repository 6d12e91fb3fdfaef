#include "collision/time_of_impact.hpp"

#include "collision/conservative_step.hpp"
#include "collision/convex_part.hpp"
#include "math/so3.hpp"

namespace atwood {
namespace {

template <class S> SweptBody<S> plane_at_rest(const Geometry<S>& shape, const SweptBody<S>& body) {
  return shape.kind == ShapeKind::plane ? SweptBody<S>{} : body;
}

template <class S> Touch<S> touch_of_spheres(const Vec3<S>& p_a, const Vec3<S>& p_b, S radius_a, S radius_b, S t) {
  const Vec3<S> between = p_b - p_a;
  const Vec3<S> normal = dot(between, between) > S(0) ? unit_vector(between) : Vec3<S>{S(0), S(0), S(1)};
  return {t, S(0.5) * ((p_a + radius_a * normal) + (p_b - radius_b * normal)), normal};
}

// |r + v t| = R with r, v from a to b: with c = |r|^2 - R^2 > 0 and r . v < 0 the first root is c / (-r.v + sqrt(d)),
// where d = |v|^2 R^2 - |r x v|^2. Both differences of squares are taken as products, so grazing and fast passes keep
// their digits. A gap of no more than round-off counts as a touch: at the start, in passing, or at the end.
template <class S>
std::optional<Touch<S>> touch_of_moving_spheres(const SweptBody<S>& a, const SweptBody<S>& b, S radius_a, S radius_b,
                                                S round_off, S t_end_s) {
  const Vec3<S> r = b.p_W - a.p_W, v = b.v_W - a.v_W;
  const S R = radius_a + radius_b, distance = norm(r), rounding = S(4) * real::epsilon<S>();
  if (distance <= R + round_off) return touch_of_spheres(a.p_W, b.p_W, radius_a, radius_b, S(0));
  const S approach = -dot(r, v), speed = norm(v);
  if (!(approach > S(0))) return {};
  const S moment = norm(accurate_cross(r, v)), speed_R = speed * R;
  if (moment > (S(1) + rounding) * speed_R) return {};
  const S root = real::sqrt(real::max(S(0), (speed_R - moment) * (speed_R + moment)));
  const S t = (distance - R) * ((distance + R) / (approach + root));
  const S gap_at_end = (t - t_end_s) * (root / R);
  if (t > t_end_s && gap_at_end > rounding * distance + round_off) return {};
  const S touch_s = real::min(t, t_end_s);
  return touch_of_spheres(a.p_W + touch_s * a.v_W, b.p_W + touch_s * b.v_W, radius_a, radius_b, touch_s);
}

// The touch's normal points from the plane to the sphere. Round-off as for spheres.
template <class S>
std::optional<Touch<S>> touch_of_plane_and_sphere(const Geometry<S>& plane, const SweptBody<S>& ball, S radius,
                                                  S round_off, S t_end_s) {
  const Vec3<S>&n = plane.normal_W, &p = ball.p_W;
  const S gap = dot(n, p) - plane.offset - radius, approach_speed = -dot(n, ball.v_W);
  if (gap > round_off && !(approach_speed > S(0))) return {};
  const S t = gap > round_off ? gap / approach_speed : S(0);
  if (t > t_end_s && (t - t_end_s) * approach_speed > round_off) return {};
  const S touch_s = real::min(t, t_end_s);
  const Vec3<S> center = p + touch_s * ball.v_W;
  return Touch<S>{touch_s, center - (radius + (gap > S(0) ? S(0) : gap / S(2))) * n, n};
}

// The interval in which two bounding spheres overlap, |r + v t| <= R: outside of it there is no contact. Empty: never.
template <class S> struct TimeSpan { S from_s{}, to_s{-1}; };
template <class S> TimeSpan<S> bounding_sphere_overlap(const Vec3<S>& r, const Vec3<S>& v, S R, S t_end_s) {
  constexpr S enlargement = S(1.001);  // any factor above 1 + round-off will do
  R *= enlargement;
  const S distance = norm(r), speed = norm(v), approach = -dot(r, v);
  if (!(speed > S(0))) return distance <= R ? TimeSpan<S>{S(0), t_end_s} : TimeSpan<S>{};
  const S miss_distance = norm(accurate_cross(r, v)) / speed, middle_s = approach / speed / speed;
  if (miss_distance > R) return {};
  const S half_s = real::sqrt((R - miss_distance) * (R + miss_distance)) / speed;
  return {real::max(S(0), middle_s - half_s), real::min(t_end_s, middle_s + half_s)};
}

// Conservative advancement in coordinates about a (the contact depends only on the relative position); a plane is
// moved to the other body instead.
template <class S>
std::optional<Touch<S>> conservative_advancement(Geometry<S> a, const SweptBody<S>& from_a, Geometry<S> b,
                                                 const SweptBody<S>& from_b, S given_round_off, S t_end_s) {
  const bool plane_a = a.kind == ShapeKind::plane, plane_b = b.kind == ShapeKind::plane;
  const Vec3<S>&origin_W = plane_a ? from_b.p_W : from_a.p_W, &drift_W = plane_a ? from_b.v_W : from_a.v_W;
  const Vec3<S> r = from_b.p_W - from_a.p_W, v = from_b.v_W - from_a.v_W;
  S size = S(0);
  TimeSpan<S> span{S(0), t_end_s};
  for (Geometry<S>* g : {&a, &b}) {
    if (g->kind != ShapeKind::plane) {
      size += g->bounding_radius;
      continue;
    }
    const Vec3<S>& n = g->normal_W;
    size +=
        real::abs(g->offset) + real::abs(n.x * origin_W.x) + real::abs(n.y * origin_W.y) + real::abs(n.z * origin_W.z);
    g->offset -= dot(n, origin_W);
  }
  if (!plane_a && !plane_b) span = bounding_sphere_overlap(r, v, size, t_end_s);
  // Edges that rotate together at a very small gap may need any number of steps. After every `steps_per_doubling` steps
  // at gaps below `close_gap` of the bodies' size the tolerance of a touch is doubled.
  constexpr int steps_per_doubling = 8192;
  const S close_gap = S(1e-6);
  int close_steps = 0, steps = 0;
  S tolerance_factor = S(1);
  Vec3<S> normal_before{};
  for (S t = span.from_s; t <= span.to_s;) {
    const auto pose = [t](const SweptBody<S>& from, const Vec3<S>& p_W) {
      return transform(p_W, so3_exp(t * from.w_W) * from.q_WB);
    };
    // A plane stays where it was moved to and the other body moves; without a plane b moves.
    const bool plane = plane_a || plane_b;
    const RotatingBody<S> now_a{a, pose(from_a, plane_b ? t * from_a.v_W : Vec3<S>{}), from_a.w_W};
    const RotatingBody<S> now_b{b,
                                pose(from_b, plane_a   ? t * from_b.v_W
                                             : plane_b ? Vec3<S>{}
                                                       : r + t * v),
                                from_b.w_W};
    const Vec3<S> shift_W = plane ? origin_W : origin_W + t * drift_W;
    const auto touch_now = [&] {
      const Separation<S> s = separation(a, now_a.pose, b, now_b.pose);
      // The sign of the normal of a gap of round-off is arbitrary: the normal of the step before decides.
      const Vec3<S> normal_W = dot(s.normal_W, normal_before) < S(0) ? normal_before : s.normal_W;
      const double residual = static_cast<double>(real::max(S(0), s.gap) / size);
      const SolveEnd ended = tolerance_factor > S(1) || s.solve.capped() ? SolveEnd::capped : SolveEnd::converged;
      return Touch<S>{t, shift_W + S(0.5) * (s.on_a_W + s.on_b_W), normal_W, {steps + 1, residual, ended}};
    };
    const S round_off = tolerance_factor *
                        (given_round_off + S(4) * real::epsilon<S>() * (size + norm(now_b.pose.p_W - now_a.pose.p_W)));
    if (t == span.from_s && !(separation(a, now_a.pose, b, now_b.pose).gap > round_off))
      return touch_now();  // overlap, or a start inside a closed mesh
    const ConservativeStep<S> step = conservative_step(now_a, now_b, -v, span.to_s - t, round_off);
    if (step.touching) return touch_now();
    if (step.gap <= close_gap * size && ++close_steps % steps_per_doubling == 0) tolerance_factor *= S(2);
    ++steps;
    const S next = t + step.step_s;
    if (next > span.to_s || t == span.to_s) return {};
    if (!(next > t)) return touch_now();  // the touch is within round-off of the time
    t = next;
    normal_before = step.normal_W;
  }
  return {};
}

}  // namespace

template <class S>
std::optional<Touch<S>> time_of_impact(const Geometry<S>& a, const SweptBody<S>& from_a, const Geometry<S>& b,
                                       const SweptBody<S>& from_b, S t_end_s) {
  using enum ShapeKind;
  if (missing_contact_test(a.kind, b.kind)) return {};
  const S round_off = touch_round_off(a, from_a.p_W, b, from_b.p_W);
  if (a.kind == sphere && b.kind == sphere)
    return touch_of_moving_spheres(from_a, from_b, a.radius, b.radius, round_off, t_end_s);
  if (a.kind == plane && b.kind == sphere) return touch_of_plane_and_sphere(a, from_b, b.radius, round_off, t_end_s);
  if (a.kind == sphere && b.kind == plane) {
    std::optional<Touch<S>> touch = touch_of_plane_and_sphere(b, from_a, a.radius, round_off, t_end_s);
    if (touch) touch->normal_W = -touch->normal_W;
    return touch;
  }
  return conservative_advancement(a, plane_at_rest(a, from_a), b, plane_at_rest(b, from_b), round_off, t_end_s);
}

#define ATWOOD_TIME_OF_IMPACT(S)                                                                                  \
  template std::optional<Touch<S>> time_of_impact<S>(const Geometry<S>&, const SweptBody<S>&, const Geometry<S>&, \
                                                     const SweptBody<S>&, S);
ATWOOD_TIME_OF_IMPACT(float)
ATWOOD_TIME_OF_IMPACT(double)
ATWOOD_TIME_OF_IMPACT(long double)
#undef ATWOOD_TIME_OF_IMPACT

}  // namespace atwood
