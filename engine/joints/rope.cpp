#include "joints/rope.hpp"

namespace atwood {
namespace {

template <class S> S turn() { return S(2) * real::atan2(S(0), S(-1)); }

template <class S> Vec3<S> point_velocity(const TiedBody<S>& body, const Vec3<S>& r) {
  return body.v_WB + cross(body.w_WB, r);
}

}  // namespace

template <class S> RopeConstraint<S> rope_constraint(const Rope& rope) {
  RopeConstraint<S> c;
  for (int k = 0; k < 2; ++k) {
    c.body[k] = rope.bodies[k];
    c.point_B[k] = narrow3<S>(rope.points_body_m[k]);
  }
  for (const atwood::Pulley& p : rope.over) {
    const Vec3<S> axis = narrow3<S>(p.axis);
    c.pulleys.push_back({narrow3<S>(p.axle_m), (S(1) / norm(axis)) * axis, S(p.radius_m), S(p.angle_rad)});
    if (p.radius_m > 0) c.mass_kg += S(p.inertia_kg_m2) / (S(p.radius_m) * S(p.radius_m));
  }
  return c;
}

template <class S>
RopePath<S> rope_path(const RopeConstraint<S>& rope, const TiedBody<S>& first, const TiedBody<S>& last) {
  RopePath<S> path;
  const TiedBody<S>* body[2] = {&first, &last};
  for (int k = 0; k < 2; ++k) {
    path.r[k] = rotate(body[k]->q_WB, rope.point_B[k]);
    path.x[k] = body[k]->p_WB + path.r[k];
  }
  const std::size_t pulleys = rope.pulleys.size();
  const Vec3<S> n = pulleys > 0 ? rope.pulleys[0].axis : Vec3<S>{};
  const auto rho_of = [&](std::size_t i) {
    return rope.pulleys[i].radius * (dot(rope.pulleys[i].axis, n) < S(0) ? S(-1) : S(1));
  };
  Vec3<S> before;
  for (std::size_t part = 0; part <= pulleys; ++part) {
    const Vec3<S> from = part == 0 ? path.x[0] : rope.pulleys[part - 1].axle;
    const Vec3<S> to = part == pulleys ? path.x[1] : rope.pulleys[part].axle;
    const S rho_difference = (part == pulleys ? S(0) : rho_of(part)) - (part == 0 ? S(0) : rho_of(part - 1));
    const bool on_pulley =
        (part > 0 && rope.pulleys[part - 1].radius > S(0)) || (part < pulleys && rope.pulleys[part].radius > S(0));
    const Vec3<S> v = to - from;
    const S square = dot(v, v), straight_square = square - rho_difference * rho_difference;
    if (!(straight_square > S(0))) path.fault = "an end of the rope reaches its pulley";
    const S out_of_plane = dot(v, n);
    const S plane_tolerance = real::max(S(1e-9), S(256) * real::epsilon<S>());
    if (on_pulley && real::abs(out_of_plane) > plane_tolerance * real::sqrt(square))
      path.fault = "the rope leaves the plane of its pulley";
    if (path.fault) return path;
    const S straight = real::sqrt(straight_square);
    // d = (l v - rho_difference n x v) / v^2
    const Vec3<S> d = (S(1) / square) * (straight * v - rho_difference * cross(n, v));
    path.length_m += straight;
    if (part > 0 && rope.pulleys[part - 1].radius > S(0)) {
      const auto& pulley = rope.pulleys[part - 1];
      S angle = real::atan2(dot(pulley.axis, cross(before, d)), dot(before, d));
      if (angle < -turn<S>() / S(8)) angle += turn<S>();
      if (angle < S(0)) path.fault = "the rope leaves its pulley, or bends around it by more than 315 degrees";
      path.length_m += pulley.radius * angle;
    }
    if (part == 0) {
      path.direction[0] = d;
      path.straight_m[0] = straight;
    }
    before = d;
    path.direction[1] = d;
    path.straight_m[1] = straight;
  }
  return path;
}

template <class S> void start_rope(const RopePath<S>& path, RopeConstraint<S>& rope) {
  rope.length_m = path.length_m;
  rope.first_m = path.straight_m[0];
  rope.first_rad = S(0);
  rope.reference = path.direction[0];
}

template <class S> S rope_travel(const RopeConstraint<S>& rope, const RopePath<S>& path, S& previous_angle) {
  const S shortened = rope.first_m - path.straight_m[0];
  if (rope.pulleys.empty() || rope.pulleys[0].radius == S(0)) return shortened;
  const Vec3<S>&n = rope.pulleys[0].axis, &d = path.direction[0];
  const S angle = real::atan2(dot(n, cross(rope.reference, d)), dot(rope.reference, d));
  previous_angle = angle + turn<S>() * real::floor((previous_angle - angle) / turn<S>() + S(0.5));
  return shortened + rope.pulleys[0].radius * (previous_angle - rope.first_rad);
}

template <class S>
int rope_rows(const RopeConstraint<S>& rope, const RopePath<S>& path, const TiedBody<S>& first, const TiedBody<S>& last,
              JointRow<S>* rows) {
  const TiedBody<S>* body[2] = {&first, &last};
  S bend[2];
  Vec3<S> velocity[2];
  for (int k = 0; k < 2; ++k) velocity[k] = point_velocity(*body[k], path.r[k]);
  const bool straight = rope.pulleys.empty();  // one part, both of whose ends move
  if (straight) {
    velocity[1] = velocity[1] - velocity[0];
    velocity[0] = {};
  }
  for (int k = 0; k < 2; ++k) {
    const Vec3<S>& d = path.direction[k];
    const Vec3<S> across = velocity[k] - dot(d, velocity[k]) * d;
    bend[k] = dot(across, across) / path.straight_m[k];
  }
  const auto end = [&](int k, S sign) {
    const Vec3<S> f = sign * path.direction[k];
    return Wrench<S>{f, cross(path.r[k], f)};
  };
  const auto turning = [&](int k) {
    const Vec3<S>& w = body[k]->w_WB;
    return dot(path.direction[k], cross(w, cross(w, path.r[k])));
  };
  if (rope.mass_kg == S(0)) {
    rows[0].on[0] = end(0, S(-1));
    rows[0].on[1] = end(1, S(1));
    rows[0].value = path.length_m - rope.length_m;
    rows[0].rate = S(0);
    rows[0].drift = (bend[0] + bend[1]) + (turning(1) - turning(0));
    return 1;
  }
  rows[0].on[0] = end(0, S(1));
  rows[0].on[1] = {};
  rows[0].value = S(0);
  rows[0].drift = turning(0) - bend[0];
  rows[1].on[0] = {};
  rows[1].on[1] = end(1, S(1));
  rows[1].value = path.length_m - rope.length_m;
  rows[1].drift = turning(1) + bend[1];
  rows[0].rate = rows[1].rate = S(0);
  return 2;
}

#define ATWOOD_ROPE(S)                                                                                            \
  template RopeConstraint<S> rope_constraint<S>(const Rope&);                                                     \
  template RopePath<S> rope_path<S>(const RopeConstraint<S>&, const TiedBody<S>&, const TiedBody<S>&);            \
  template void start_rope<S>(const RopePath<S>&, RopeConstraint<S>&);                                            \
  template S rope_travel<S>(const RopeConstraint<S>&, const RopePath<S>&, S&);                                    \
  template int rope_rows<S>(const RopeConstraint<S>&, const RopePath<S>&, const TiedBody<S>&, const TiedBody<S>&, \
                            JointRow<S>*);
ATWOOD_ROPE(float)
ATWOOD_ROPE(double)
ATWOOD_ROPE(long double)
ATWOOD_ROPE(Quad)
#undef ATWOOD_ROPE

}  // namespace atwood
