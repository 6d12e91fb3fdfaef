#include "collision/swept.hpp"

#include "collision/convex_piece.hpp"
#include "math/so3.hpp"

namespace atwood {
namespace {

template <class S> Placement<S> placement_at(const SweptBody<S>& body, S t) {
  return placement(body.p_W + t * body.v_W, so3_exp(t * body.w_W) * body.q_WB);
}

template <class S> SweptBody<S> held(const Geometry<S>& shape, const SweptBody<S>& body) {
  return shape.kind == ShapeKind::plane ? SweptBody<S>{} : body;
}

template <class S> Touch<S> touch_of_spheres(const Vec3<S>& p_a, const Vec3<S>& p_b, S radius_a, S radius_b, S t) {
  const Vec3<S> between = p_b - p_a;
  const Vec3<S> normal = dot(between, between) > S(0) ? unit_along(between) : Vec3<S>{S(0), S(0), S(1)};
  return {t, S(0.5) * ((p_a + radius_a * normal) + (p_b - radius_b * normal)), normal};
}

// |r + v t| = R with r, v from a to b: with c = |r|^2 - R^2 > 0 and r . v < 0 the first root is c / (-r.v + sqrt(d)), where
// d = |v|^2 R^2 - |r x v|^2. Both differences of squares are taken as products, so grazing and fast passes keep their digits.
template <class S>
std::optional<Touch<S>> spheres(const SweptBody<S>& a, const SweptBody<S>& b, S radius_a, S radius_b, S t_end_s) {
  const Vec3<S> r = b.p_W - a.p_W, v = b.v_W - a.v_W;
  const S R = radius_a + radius_b, distance = norm(r);
  if (distance <= R) return touch_of_spheres(a.p_W, b.p_W, radius_a, radius_b, S(0));
  const S approach = -dot(r, v), speed = norm(v);
  if (!(approach > S(0))) return {};
  const S miss = norm(accurate_cross(r, v)), reach = speed * R;
  if (miss > reach) return {};
  const S root = real::sqrt((reach - miss) * (reach + miss));
  const S t = (distance - R) * ((distance + R) / (approach + root));
  if (t > t_end_s) return {};
  return touch_of_spheres(a.p_W + t * a.v_W, b.p_W + t * b.v_W, radius_a, radius_b, t);
}

// The normal of the plane out of it; the touch's from the plane to the sphere.
template <class S>
std::optional<Touch<S>> plane_and_sphere(const Geometry<S>& plane, const SweptBody<S>& ball, S radius, S t_end_s) {
  const S gap = dot(plane.normal_W, ball.p_W) - plane.offset - radius, closing = -dot(plane.normal_W, ball.v_W);
  if (gap > S(0) && !(closing > S(0))) return {};
  const S t = gap > S(0) ? gap / closing : S(0);
  if (t > t_end_s) return {};
  const Vec3<S> center = ball.p_W + t * ball.v_W;
  return Touch<S>{t, center - (radius + (gap > S(0) ? S(0) : gap / S(2))) * plane.normal_W, plane.normal_W};
}

// How fast points of the body can move along +-n: of spheres the spin moves none, of others |w x n| times the farthest.
template <class S> S spin_along(const Geometry<S>& shape, const SweptBody<S>& body, const Vec3<S>& n) {
  if (shape.kind == ShapeKind::sphere || shape.kind == ShapeKind::plane) return S(0);
  return norm(cross(body.w_W, n)) * shape.bounding_radius;
}

// The gap along the normal of the nearest points can close no faster than `closing`: v and w are constant in world axes, so
// the bound holds for all times, and each step ends before the touch. The step is Newton's for bodies that do not spin.
template <class S>
std::optional<Touch<S>> advance(const Geometry<S>& a, const SweptBody<S>& from_a, const Geometry<S>& b,
                                const SweptBody<S>& from_b, S t_end_s) {
  const auto finite_size = [](const Geometry<S>& g) {
    return g.kind == ShapeKind::plane ? real::abs(g.offset) : g.bounding_radius;
  };
  const S size = finite_size(a) + finite_size(b);
  Vec3<S> normal_before{};
  for (S t{};;) {
    const Placement<S> place_a = placement_at(from_a, t), place_b = placement_at(from_b, t);
    const Separation<S> s = separation(a, place_a, b, place_b);
    // Which way a gap of round-off points is chance; the step before was to its right side.
    const Vec3<S> normal_W = dot(s.normal_W, normal_before) < S(0) ? normal_before : s.normal_W;
    const Touch<S> here{t, S(0.5) * (s.on_a_W + s.on_b_W), normal_W};
    if (!(s.gap > S(0))) return here;
    // Within round-off they touch, and between points so close together the normal says nothing of the closing.
    const S round_off = S(4) * real::epsilon<S>() * (size + norm(place_a.p_W) + norm(place_b.p_W));
    if (s.gap <= round_off) return here;
    const S closing =
        dot(from_a.v_W - from_b.v_W, s.normal_W) + spin_along(a, from_a, s.normal_W) + spin_along(b, from_b, s.normal_W);
    if (!(closing > S(0))) return {};
    const S next = t + s.gap / closing;
    if (next > t_end_s) return {};
    if (!(next > t)) return here;  // the touch is within round-off of the time
    t = next;
    normal_before = s.normal_W;
  }
}

}  // namespace

template <class S>
std::optional<Touch<S>> first_touch(const Geometry<S>& a, const SweptBody<S>& from_a, const Geometry<S>& b,
                                    const SweptBody<S>& from_b, S t_end_s) {
  using enum ShapeKind;
  if (a.kind == sphere && b.kind == sphere) return spheres(from_a, from_b, a.radius, b.radius, t_end_s);
  if (a.kind == plane && b.kind == sphere) return plane_and_sphere(a, from_b, b.radius, t_end_s);
  if (a.kind == sphere && b.kind == plane) {
    std::optional<Touch<S>> touch = plane_and_sphere(b, from_a, a.radius, t_end_s);
    if (touch) touch->normal_W = -touch->normal_W;
    return touch;
  }
  if (no_contact_test(a.kind, b.kind)) return {};
  return advance(a, held(a, from_a), b, held(b, from_b), t_end_s);
}

#define ATWOOD_SWEPT(S)                                                                                                    \
  template std::optional<Touch<S>> first_touch<S>(const Geometry<S>&, const SweptBody<S>&, const Geometry<S>&,              \
                                                  const SweptBody<S>&, S);
ATWOOD_SWEPT(float)
ATWOOD_SWEPT(double)
ATWOOD_SWEPT(long double)
#undef ATWOOD_SWEPT

}  // namespace atwood
