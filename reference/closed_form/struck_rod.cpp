// Impact of a ball on a capsule or a box without gravity (E. J. Routh, Dynamics of a System of Rigid Bodies, art.
// 168-169, 180-195; Delannoy 2005, eq. 5-8). Before the impact both move uniformly and the rod does not rotate, so that
// the time of contact is a root of a polynomial of degree 2 at most. n points from the rod to the ball, r from the
// rod's centre to the contact:
//   J = -(1 + e) u_n / (1/m_rod + 1/m_ball + (r x n) I^-1 (r x n)),   w' = I^-1 (r x J)
//
// With friction the impact must be planar: velocities, r and the rod's new spin stay in a plane of symmetry. There the
// relative velocity of the surfaces u = (u_t, u_n) changes by K (T, J), K symmetric, and Routh's method integrates over
// the normal impulse J: T' = -mu sign u_t during slip; from u_t = 0 on stick, T' = -K_tn / K_tt, if the size of that is
// at most mu, otherwise slip in the direction that K_tn gives. It ends, by Newton's law, at u_n = -e u_n(0).
#include "closed_form/obstacles.hpp"
#include "protocol/fault.hpp"

namespace atwood::closed_form {

namespace {

template <class S> struct Pair {
  int rod = -1, ball = -1;
  Pose<S> rod0, ball0;
  S inverse_rod{}, inverse_ball{}, radius{}, ball_inverse_mass_spin{};  // ball_yield: r^2 / I
  S moment[3]{};                                                        // of the rod, body axes
};

template <class S> std::string find_pair(const Scene& scene, Pair<S>& pair) {
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const Body& body = scene.bodies[i];
    const std::string name = "`" + body.name + "`";
    const int at = static_cast<int>(i);
    if (body.fixed && body.shape.index() == 0) continue;
    const bool rod = std::holds_alternative<Capsule>(body.shape) || std::holds_alternative<Box>(body.shape);
    if (body.fixed || (rod ? pair.rod : pair.ball) >= 0 || !(rod || std::holds_alternative<Sphere>(body.shape)))
      return name + " is one body too many or of another shape: expected a free sphere and a free capsule or box";
    (rod ? pair.rod : pair.ball) = at;
    if (body.release_s > 0) return name + " has a later release, which is not covered";
    if (body.angular_velocity_body_rad_per_s != Real3{}) return name + " has an initial spin, which is not covered";
    for (const Force& force : scene.forces)
      if (acts_on(force, at)) return force_on_body(scene, force, at) + " is not covered";
  }
  if (pair.rod < 0 || pair.ball < 0) return "expected a free sphere and a free capsule or box";
  if (scene.gravity_m_per_s2 != Real3{}) return "uniform gravity is not covered";
  const Body &rod = scene.bodies[pair.rod], &ball = scene.bodies[pair.ball];
  const Real33& I = rod.inertia_kg_m2;
  if (!rotates(rod) || I[1] != 0 || I[2] != 0 || I[5] != 0) return "the inertia of `" + rod.name + "` is not diagonal";
  if (!rotates(ball) || !has_spherical_inertia(ball))
    return "`" + ball.name + "` has different principal moments of inertia";
  pair.rod0 = initial_pose<S>(rod);
  pair.ball0 = initial_pose<S>(ball);
  pair.inverse_rod = 1 / S(rod.mass_kg);
  pair.inverse_ball = 1 / S(ball.mass_kg);
  pair.radius = std::get<Sphere>(ball.shape).radius_m;
  pair.ball_inverse_mass_spin = pair.radius * pair.radius / S(ball.inertia_kg_m2[0]);
  for (int k = 0; k < 3; ++k) pair.moment[k] = I[4 * k];
  return "";
}

template <class S> struct ContactPoint {
  bool happens = false;
  S t{};
  Vec<S> n_B{}, r_B{};  // in the rod's axes: from rod to ball; from the rod's centre to the contact
};

// The smaller root of |d + t u| = reach, with the norm over the first `axes` coordinates. False: there is none.
template <class S> bool first_root(const Vec<S>& d, const Vec<S>& u, int axes, S radius, S& t) {
  S a = 0, b = 0, c = -radius * radius;
  for (int k = 0; k < axes; ++k) {
    a = a + u[k] * u[k];
    b = b + d[k] * u[k];
    c = c + d[k] * d[k];
  }
  const S discriminant = b * b - a * c;
  if (!(b < 0) || !(discriminant > 0) || c < 0) return false;
  t = c / (sqrt(discriminant) - b);
  return true;
}

template <class S>
ContactPoint<S> contact_with_capsule(const Capsule& capsule, const Vec<S>& d, const Vec<S>& u, S radius) {
  ContactPoint<S> made;
  const S half = capsule.half_length_m, own = capsule.radius_m;
  const auto take = [&](S t, S along) {
    if (made.happens && made.t <= t) return;
    Vec<S> n = d + t * u;
    n[2] = n[2] - along;
    made.happens = true;
    made.t = t;
    made.n_B = (1 / norm(n)) * n;
    made.r_B = own * made.n_B;
    made.r_B[2] = made.r_B[2] + along;
  };
  S t{};
  if (first_root(d, u, 2, own + radius, t) && magnitude(d[2] + t * u[2]) <= half) take(t, d[2] + t * u[2]);
  for (const S end : {half, -half}) {
    const Vec<S> from{d[0], d[1], d[2] - end};
    if (first_root(from, u, 3, own + radius, t) && (end > 0 ? d[2] + t * u[2] > end : d[2] + t * u[2] < end))
      take(t, end);
  }
  return made;
}

// A ball that may hit an edge is refused.
template <class S>
Result<ContactPoint<S>> contact_with_box(const Box& box, const Vec<S>& d, const Vec<S>& u, S radius) {
  ContactPoint<S> made;
  bool near_edge = false;
  S t_edge{};
  for (int k = 0; k < 3; ++k) {
    if (u[k] == 0) continue;
    const S side = u[k] < 0 ? 1 : -1, t = (side * (S(box.half_extents_m[k]) + radius) - d[k]) / u[k];
    const Vec<S> p = d + t * u;
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    const S beyond_i = magnitude(p[i]) - S(box.half_extents_m[i]),
            beyond_j = magnitude(p[j]) - S(box.half_extents_m[j]);
    if (t < 0 || beyond_i > radius || beyond_j > radius) continue;
    if (beyond_i > 0 || beyond_j > 0) {
      near_edge = true;
      t_edge = t;
      continue;
    }
    made.happens = true;
    made.t = t;
    made.n_B[k] = side;
    made.r_B = p - (radius * side) * Vec<S>{S(k == 0), S(k == 1), S(k == 2)};
  }
  if (near_edge && (!made.happens || t_edge <= made.t))
    return Fault{"the ball may hit an edge of the box, which is not covered"};
  return made;
}

template <class S> struct ContactImpulse { S normal{}, tangential{}, before{}, after{}; };

// Routh's method in the plane of t and n. K = (K_tt, K_tn, K_nn); u_n < 0.
template <class S> ContactImpulse<S> routh(S K_tt, S K_tn, S K_nn, S u_t, S u_n, S e, S mu) {
  ContactImpulse<S> made;
  made.before = u_n;
  made.after = -e * u_n;
  S left = made.after - u_n;  // remaining change of the normal velocity
  for (int phase = 0; phase < 2; ++phase) {
    const bool slides = u_t != 0;
    S ratio = -K_tn / K_tt;  // T' that keeps u_t
    if (slides || magnitude(ratio) > mu) {
      const S way = slides ? (u_t > 0 ? 1 : -1) : (K_tn > 0 ? 1 : -1);
      ratio = -mu * way;
    }
    const S gain_n = K_nn + K_tn * ratio, gain_t = K_tn + K_tt * ratio;  // of u_n, u_t by unit normal impulse
    S J = left / gain_n;
    const bool stops = slides && u_t * gain_t < 0 && -u_t / gain_t < J;
    if (stops) J = -u_t / gain_t;
    made.normal = made.normal + J;
    made.tangential = made.tangential + ratio * J;
    if (!stops) return made;
    left = left - gain_n * J;
    u_t = 0;
  }
  return made;
}

template <class S> S distance_to_rod(const Shape& rod, const Vec<S>& p) {
  Vec<S> beyond = p;
  if (const auto* box = std::get_if<Box>(&rod)) {
    for (int k = 0; k < 3; ++k) beyond[k] = larger(S(0), magnitude(p[k]) - S(box->half_extents_m[k]));
    return norm(beyond);
  }
  const auto& capsule = std::get<Capsule>(rod);
  beyond[2] = larger(S(0), magnitude(p[2]) - S(capsule.half_length_m));
  return norm(beyond) - S(capsule.radius_m);
}

// Can the rotating rod hit the ball again? In the rod's frame (d, u: position and velocity of the ball at the impact,
// w: the rod's angular velocity) the gap is at least separation_speed t - A t^2 / 2 with the largest relative
// acceleration A = w^2 d + 2 w u; it is positive until 2 separation_speed / A. From half of that time on it is checked
// by bisection.
template <class S>
bool may_collide_again(const Shape& rod, const Vec<S>& d, const Vec<S>& u, const Vec<S>& w_B, S radius,
                       S separation_speed, S rest) {
  const S rate = norm(w_B), speed = norm(u), farthest = norm(d) + speed * rest;
  if (rate == 0) return false;
  const S acceleration = rate * (rate * farthest + 2 * speed), from = separation_speed / acceleration;
  if (!(from < rest)) return false;
  const auto gap = [&](S t) {
    const Vec<S> p = rotate(conjugate(turn((1 / rate) * w_B, rate * t)), d + t * u);
    return distance_to_rod(rod, p) - radius;
  };
  const auto way = [&](S since, S until) { return (speed + rate * farthest) * (until - since); };
  return !stays_positive<S>(from, rest, gap, way, S(1e-9) * radius);
}

// Outcome of the impact: the impulse on the ball and both new angular velocities, in the rod's axes.
template <class S> struct ImpactResult {
  std::string refusal;
  ContactImpulse<S> impulse;
  Vec<S> J{}, rod_w{}, ball_w{};
  InputRoundOff<S> input_round_off;
};

// Terms of a sum below this relative size are round-off: they are set to zero, and the bars include their effect.
template <class S> S round_off_tolerance() { return 256 * unit_round_off<S>(); }

template <class S>
ImpactResult<S> resolve_impact(const Pair<S>& pair, const ContactPoint<S>& contact, const Vec<S>& u, const PairLaw& law,
                               S rest) {
  ImpactResult<S> made;
  const Vec<S>&n = contact.n_B, &r = contact.r_B;
  const auto turned_by = [&](const Vec<S>& impulse) {
    const Vec<S> moment = cross(r, impulse);
    return Vec<S>{moment[0] / pair.moment[0], moment[1] / pair.moment[1], moment[2] / pair.moment[2]};
  };
  // Change of the surfaces' relative velocity (ball minus rod) along `measured` by a unit impulse on the ball
  // along `given`.
  const auto inverse_mass = [&](const Vec<S>& measured, const Vec<S>& given) {
    const S aside = dot(measured, given) - dot(measured, n) * dot(given, n);
    return dot(measured, given) * (pair.inverse_rod + pair.inverse_ball) + pair.ball_inverse_mass_spin * aside +
           dot(measured, cross(turned_by(given), r));
  };
  const Vec<S> sliding = u - dot(u, n) * n, lean = r - dot(r, n) * n;
  const bool slides = norm(sliding) > round_off_tolerance<S>() * norm(u);
  Vec<S> along{};
  // Without initial slip the impact itself may start it, in the plane of r and n.
  if (slides) along = (1 / norm(sliding)) * sliding;
  else if (norm(lean) > round_off_tolerance<S>() * norm(r)) along = (1 / norm(lean)) * lean;
  const bool rough = law.friction != 0 && !is_zero(along);
  // Where it is small, what is left of a difference is not orthogonal to n: once more.
  if (!is_zero(along)) along = along - dot(along, n) * n;
  if (!is_zero(along)) along = (1 / norm(along)) * along;
  const Vec<S> across = cross(n, along);
  if (rough && magnitude(inverse_mass(across, n)) + magnitude(inverse_mass(across, along)) >
                   round_off_tolerance<S>() * inverse_mass(n, n))
    made.refusal = "the impact has friction and is not planar";
  made.impulse =
      routh(rough ? inverse_mass(along, along) : S(1), rough ? inverse_mass(along, n) : S(0), inverse_mass(n, n),
            slides ? norm(sliding) : S(0), dot(u, n), S(law.restitution), rough ? S(law.friction) : S(0));
  made.J = made.impulse.normal * n + made.impulse.tangential * along;
  made.rod_w = S(-1) * turned_by(made.J);
  made.ball_w = (pair.ball_inverse_mass_spin / pair.radius) * cross(S(-1) * n, made.impulse.tangential * along);
  const Vec<S>& w = made.rod_w;
  const Vec<S> L{pair.moment[0] * w[0], pair.moment[1] * w[1], pair.moment[2] * w[2]};
  const S tumbles = norm(cross(w, L));
  if (tumbles > round_off_tolerance<S>() * norm(w) * norm(L)) {
    made.refusal = "the impact is not in a plane of symmetry of the rod, so that it tumbles, which is not covered";
    return made;
  }
  const std::array<S, 3> moment{pair.moment[0], pair.moment[1], pair.moment[2]};
  const S least = std::min(moment[0], std::min(moment[1], moment[2]));
  // |w x L| is w^2 times a difference of moments times the angle to the axis. It gives no bound of this angle when the
  // moments are equal, but then the angular velocity is constant.
  const S neglected = tumbles == 0 ? S(0) : round_off_tolerance<S>() * norm(w);
  made.input_round_off.w_rad_per_s = grown_rate(moment, norm(w), neglected, rest) + tumbles * rest / least;
  made.input_round_off.q = made.input_round_off.w_rad_per_s * rest;
  if (law.friction != 0) {  // slip and offsets below the round-off tolerance
    made.input_round_off.v_m_per_s = round_off_tolerance<S>() * norm(u);
    made.input_round_off.p_m = made.input_round_off.v_m_per_s * rest;
  }
  return made;
}

template <class S>
ContactEvent<S> contact_event(const Pair<S>& pair, const ContactPoint<S>& contact, const ContactImpulse<S>& impulse) {
  const bool in_order = pair.rod < pair.ball;
  ContactEvent<S> hit;
  hit.t_s = contact.t;
  hit.body_a = in_order ? pair.rod : pair.ball;
  hit.body_b = in_order ? pair.ball : pair.rod;
  hit.x_W = pair.rod0.p_WB + contact.t * pair.rod0.v_WB + rotate(pair.rod0.q_WB, contact.r_B);
  hit.normal_W = S(in_order ? 1 : -1) * rotate(pair.rod0.q_WB, contact.n_B);
  hit.impulse_n_N_s = impulse.normal;
  hit.impulse_t_N_s = magnitude(impulse.tangential);
  hit.vn_before_m_per_s = impulse.before;
  hit.vn_after_m_per_s = impulse.after;
  return hit;
}

template <class S> Motion<S> solve_struck_rod(const Scenario& scenario, const std::vector<S>& t_s) {
  const Scene& scene = scenario.scene;
  const S t_end = scenario.t_end_s;
  Motion<S> motion;
  Pair<S> pair;
  motion.refusal = find_pair(scene, pair);
  if (!motion.refusal.empty()) return motion;
  const Quat<S> to_rod = conjugate(pair.rod0.q_WB);
  const Vec<S> d = rotate(to_rod, pair.ball0.p_WB - pair.rod0.p_WB),
               u = rotate(to_rod, pair.ball0.v_WB - pair.rod0.v_WB);
  const Body& rod = scene.bodies[pair.rod];
  const auto* box = std::get_if<Box>(&rod.shape);
  const S apart = distance_to_rod(rod.shape, d) - pair.radius;
  if (apart < 0) {
    motion.refusal = "the rod and the ball overlap at the start";
    return motion;
  }
  const Result<ContactPoint<S>> found = box != nullptr
                                            ? contact_with_box(*box, d, u, pair.radius)
                                            : contact_with_capsule(std::get<Capsule>(rod.shape), d, u, pair.radius);
  if (!found) {
    motion.refusal = found.fault().reason;
    return motion;
  }
  ContactPoint<S> contact = *found;
  contact.happens = contact.happens && contact.t <= t_end;
  ImpactResult<S> result;
  if (contact.happens) {
    result = resolve_impact(pair, contact, u, pair_law(scene, pair.rod, pair.ball), t_end - contact.t);
    motion.refusal = result.refusal;
    motion.input_round_off = result.input_round_off;
    const Vec<S> parts = u + (pair.inverse_rod + pair.inverse_ball) * result.J;
    if (motion.refusal.empty() && may_collide_again(rod.shape, d + contact.t * u, parts, result.rod_w, pair.radius,
                                                    result.impulse.after, t_end - contact.t))
      motion.refusal = "the rotating rod may hit the ball again, which is not covered";
    if (!motion.refusal.empty()) return motion;
    motion.events.push_back(contact_event(pair, contact, result.impulse));
  }
  const Vec<S> J_W = rotate(pair.rod0.q_WB, result.J);
  const auto fly = [&](const Pose<S>& start, S t, S kick, const Vec<S>& spin_B) {
    Pose<S> now = start;
    now.p_WB = start.p_WB + t * start.v_WB;
    if (!contact.happens || t < contact.t) return now;
    const S since = t - contact.t, rate = norm(spin_B);
    now.v_WB = start.v_WB + kick * J_W;
    now.p_WB = now.p_WB + (since * kick) * J_W;
    now.w_WB_B = spin_B;
    if (rate != 0) now.q_WB = start.q_WB * turn((1 / rate) * spin_B, rate * since);
    return now;
  };
  const Vec<S> ball_spin = rotate(conjugate(pair.ball0.q_WB), rotate(pair.rod0.q_WB, result.ball_w));
  for (const S& t : t_s) {
    auto& poses = motion.poses.emplace_back();
    for (const Body& body : scene.bodies) poses.push_back(initial_pose<S>(body));
    poses[pair.rod] = fly(pair.rod0, t, -pair.inverse_rod, result.rod_w);
    poses[pair.ball] = fly(pair.ball0, t, pair.inverse_ball, ball_spin);
  }
  return motion;
}

}  // namespace

Solution struck_rod() {
  return {"struck-rod",
          "impact of a ball on a rod without gravity: linear and angular impulse, Routh's method with friction: "
          "Routh, art. 168-195; Delannoy (2005), eq. 5-8",
          feature::kSimpleContact, solve_struck_rod<Narrow>, solve_struck_rod<Wide>};
}

}  // namespace atwood::closed_form
