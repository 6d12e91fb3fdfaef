#include "collision/swept.hpp"

#include "collision/convex_piece.hpp"
#include "collision/stay_apart.hpp"
#include "math/so3.hpp"

namespace atwood {
namespace {

template <class S> SweptBody<S> held(const Geometry<S>& shape, const SweptBody<S>& body) {
  return shape.kind == ShapeKind::plane ? SweptBody<S>{} : body;
}

template <class S> Touch<S> touch_of_spheres(const Vec3<S>& p_a, const Vec3<S>& p_b, S radius_a, S radius_b, S t) {
  const Vec3<S> between = p_b - p_a;
  const Vec3<S> normal = dot(between, between) > S(0) ? unit_along(between) : Vec3<S>{S(0), S(0), S(1)};
  return {t, S(0.5) * ((p_a + radius_a * normal) + (p_b - radius_b * normal)), normal};
}

// |r + v t| = R with r, v from a to b: with c = |r|^2 - R^2 > 0 and r . v < 0 the first root is c / (-r.v + sqrt(d)),
// where d = |v|^2 R^2 - |r x v|^2. Both differences of squares are taken as products, so grazing and fast passes keep
// their digits. What round-off alone keeps apart touches: at the start, in passing, or at the end.
template <class S>
std::optional<Touch<S>> spheres(const SweptBody<S>& a, const SweptBody<S>& b, S radius_a, S radius_b, S round_off,
                                S t_end_s) {
  const Vec3<S> r = b.p_W - a.p_W, v = b.v_W - a.v_W;
  const S R = radius_a + radius_b, distance = norm(r), rounding = S(4) * real::epsilon<S>();
  if (distance <= R + round_off) return touch_of_spheres(a.p_W, b.p_W, radius_a, radius_b, S(0));
  const S approach = -dot(r, v), speed = norm(v);
  if (!(approach > S(0))) return {};
  const S miss = norm(accurate_cross(r, v)), reach = speed * R;
  if (miss > (S(1) + rounding) * reach) return {};
  const S root = real::sqrt(real::max(S(0), (reach - miss) * (reach + miss)));
  const S t = (distance - R) * ((distance + R) / (approach + root));
  const S gap_at_end = (t - t_end_s) * (root / R);
  if (t > t_end_s && gap_at_end > rounding * distance + round_off) return {};
  const S touch_s = real::min(t, t_end_s);
  return touch_of_spheres(a.p_W + touch_s * a.v_W, b.p_W + touch_s * b.v_W, radius_a, radius_b, touch_s);
}

// The normal of the plane out of it; the touch's from the plane to the sphere. Round-off as for spheres.
template <class S>
std::optional<Touch<S>> plane_and_sphere(const Geometry<S>& plane, const SweptBody<S>& ball, S radius, S round_off,
                                         S t_end_s) {
  const Vec3<S>&n = plane.normal_W, &p = ball.p_W;
  const S gap = dot(n, p) - plane.offset - radius, closing = -dot(n, ball.v_W);
  if (gap > round_off && !(closing > S(0))) return {};
  const S t = gap > round_off ? gap / closing : S(0);
  if (t > t_end_s && (t - t_end_s) * closing > round_off) return {};
  const S touch_s = real::min(t, t_end_s);
  const Vec3<S> center = p + touch_s * ball.v_W;
  return Touch<S>{touch_s, center - (radius + (gap > S(0) ? S(0) : gap / S(2))) * n, n};
}

// From when to when two bounding spheres overlap, |r + v t| <= R: outside of that nothing touches. Empty: never.
template <class S> struct Span { S from_s{}, to_s{-1}; };
template <class S> Span<S> spheres_overlap(const Vec3<S>& r, const Vec3<S>& v, S R, S t_end_s) {
  constexpr S kWider = S(1.001);  // no matter how much
  R *= kWider;
  const S distance = norm(r), speed = norm(v), approach = -dot(r, v);
  if (!(speed > S(0))) return distance <= R ? Span<S>{S(0), t_end_s} : Span<S>{};
  const S miss = norm(accurate_cross(r, v)) / speed, middle_s = approach / speed / speed;
  if (miss > R) return {};
  const S half_s = real::sqrt((R - miss) * (R + miss)) / speed;
  return {real::max(S(0), middle_s - half_s), real::min(t_end_s, middle_s + half_s)};
}

// Conservative advancement. Where it happens hangs on where b is from a alone; a plane is brought to b.
template <class S>
std::optional<Touch<S>> advance(Geometry<S> a, const SweptBody<S>& from_a, Geometry<S> b, const SweptBody<S>& from_b,
                                S given_round_off, S t_end_s) {
  const bool plane_a = a.kind == ShapeKind::plane, plane_b = b.kind == ShapeKind::plane;
  const Vec3<S>&origin_W = plane_a ? from_b.p_W : from_a.p_W, &drift_W = plane_a ? from_b.v_W : from_a.v_W;
  const Vec3<S> r = from_b.p_W - from_a.p_W, v = from_b.v_W - from_a.v_W;
  S size = S(0);
  Span<S> span{S(0), t_end_s};
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
  if (!plane_a && !plane_b) span = spheres_overlap(r, v, size, t_end_s);
  // Edges that turn together a hair apart may still take ever so many steps: what stays nearer than a millionth of
  // their size for thousands touches at twice the round-off for every further thousands.
  constexpr int kCrawling = 8192;
  const S kClose = S(1e-6);
  int crawled = 0;
  S patience = S(1);
  int steps = 0;
  Vec3<S> normal_before{};
  for (S t = span.from_s; t <= span.to_s;) {
    const auto place = [t](const SweptBody<S>& from, const Vec3<S>& p_W) {
      return placement(p_W, so3_exp(t * from.w_W) * from.q_WB);
    };
    // The plane stays where it was brought to; beside it the other body moves, else b does.
    const bool plane = plane_a || plane_b;
    const Spinning<S> now_a{a, place(from_a, plane_b ? t * from_a.v_W : Vec3<S>{}), from_a.w_W};
    const Spinning<S> now_b{b, place(from_b, plane_a ? t * from_b.v_W : plane_b ? Vec3<S>{} : r + t * v), from_b.w_W};
    const Vec3<S> shift_W = plane ? origin_W : origin_W + t * drift_W;
    const auto here = [&] {
      const Separation<S> s = separation(a, now_a.place, b, now_b.place);
      // Which way a gap of round-off points is chance; the step before was to its right side.
      const Vec3<S> normal_W = dot(s.normal_W, normal_before) < S(0) ? normal_before : s.normal_W;
      const double residual = static_cast<double>(real::max(S(0), s.gap) / size);
      const SolveEnd ended = patience > S(1) ? SolveEnd::capped : SolveEnd::converged;
      return Touch<S>{t, shift_W + S(0.5) * (s.on_a_W + s.on_b_W), normal_W, {steps + 1, residual, ended}};
    };
    const S round_off =
        patience * (given_round_off + S(4) * real::epsilon<S>() * (size + norm(now_b.place.p_W - now_a.place.p_W)));
    if (t == span.from_s && !(separation(a, now_a.place, b, now_b.place).gap > round_off))
      return here();  // or inside a mesh
    const Stay<S> stay = stay_apart(now_a, now_b, -v, span.to_s - t, round_off);
    if (stay.touching) return here();
    if (stay.gap <= kClose * size && ++crawled % kCrawling == 0) patience *= S(2);
    ++steps;
    const S next = t + stay.until_s;
    if (next > span.to_s || t == span.to_s) return {};
    if (!(next > t)) return here();  // the touch is within round-off of the time
    t = next;
    normal_before = stay.normal_W;
  }
  return {};
}

}  // namespace

template <class S>
std::optional<Touch<S>> first_touch(const Geometry<S>& a, const SweptBody<S>& from_a, const Geometry<S>& b,
                                    const SweptBody<S>& from_b, S t_end_s) {
  using enum ShapeKind;
  if (no_contact_test(a.kind, b.kind)) return {};
  const S round_off = touch_round_off(a, from_a.p_W, b, from_b.p_W);
  if (a.kind == sphere && b.kind == sphere) return spheres(from_a, from_b, a.radius, b.radius, round_off, t_end_s);
  if (a.kind == plane && b.kind == sphere) return plane_and_sphere(a, from_b, b.radius, round_off, t_end_s);
  if (a.kind == sphere && b.kind == plane) {
    std::optional<Touch<S>> touch = plane_and_sphere(b, from_a, a.radius, round_off, t_end_s);
    if (touch) touch->normal_W = -touch->normal_W;
    return touch;
  }
  return advance(a, held(a, from_a), b, held(b, from_b), round_off, t_end_s);
}

#define ATWOOD_SWEPT(S)                                                                                        \
  template std::optional<Touch<S>> first_touch<S>(const Geometry<S>&, const SweptBody<S>&, const Geometry<S>&, \
                                                  const SweptBody<S>&, S);
ATWOOD_SWEPT(float)
ATWOOD_SWEPT(double)
ATWOOD_SWEPT(long double)
#undef ATWOOD_SWEPT

}  // namespace atwood
