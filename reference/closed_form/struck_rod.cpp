// A ball strikes a capsule or a box in empty space (E. J. Routh, Dynamics of a System of Rigid Bodies, art. 168-169,
// 180-195; Delannoy 2005, eq. 5-8). Until then both fly straight and the rod does not turn, so the ball meets its side,
// a round end or a face at the root of a quadratic at most. n points from the rod to the ball, r from the rod's centre
// to the touch:
//   J = -(1 + e) u_n / (1/m_rod + 1/m_ball + (r x n) I^-1 (r x n)),   w' = I^-1 (r x J)
//
// With friction only where the impact is planar: velocities, r and the rod's new spin keep to a plane of symmetry.
// There the feet's velocity u = (u_t, u_n) changes by K (T, J), K symmetric, and Routh's process follows the normal
// impulse J as it grows: T' = -mu sign u_t while they slide; once u_t = 0 they stick, T' = -K_tn / K_tt, if mu >= |K_tn
// / K_tt|, else they slide on the way that K_tn drives them. It ends, after Newton, where u_n = -e u_n(0).
#include "closed_form/obstacles.hpp"

namespace atwood::closed_form {

namespace {

template <class S> struct Pair {
  int rod = -1, ball = -1;
  Pose<S> rod0, ball0;
  S inverse_rod{}, inverse_ball{}, radius{}, ball_yield{};  // ball_yield: r^2 / I
  S moment[3]{};                                            // of the rod, body axes
};

template <class S> std::string find_pair(const Scene& scene, Pair<S>& pair) {
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const Body& body = scene.bodies[i];
    const std::string name = "`" + body.name + "`";
    const int at = static_cast<int>(i);
    if (body.fixed && body.shape.index() == 0) continue;
    const bool rod = std::holds_alternative<Capsule>(body.shape) || std::holds_alternative<Box>(body.shape);
    if (body.fixed || (rod ? pair.rod : pair.ball) >= 0 || !(rod || std::holds_alternative<Sphere>(body.shape)))
      return name + " is there beside a free ball and a free capsule or box";
    (rod ? pair.rod : pair.ball) = at;
    if (body.release_s > 0) return name + " is released late";
    if (body.angular_velocity_body_rad_per_s != Real3{}) return name + " spins before it is struck";
    for (const Force& force : scene.forces)
      if (acts_on(force, at)) return named(scene, force, at) + " is not covered";
  }
  if (pair.rod < 0 || pair.ball < 0) return "a free ball and a free capsule or box are needed";
  if (scene.gravity_m_per_s2 != Real3{}) return "there is gravity";
  const Body &rod = scene.bodies[pair.rod], &ball = scene.bodies[pair.ball];
  const Real33& I = rod.inertia_kg_m2;
  if (!rotates(rod) || I[1] != 0 || I[2] != 0 || I[5] != 0) return "the inertia of `" + rod.name + "` is not diagonal";
  if (!rotates(ball) || !turns_like_a_ball(ball))
    return "`" + ball.name + "` has moments of inertia that are not all alike";
  pair.rod0 = initial_pose<S>(rod);
  pair.ball0 = initial_pose<S>(ball);
  pair.inverse_rod = 1 / S(rod.mass_kg);
  pair.inverse_ball = 1 / S(ball.mass_kg);
  pair.radius = std::get<Sphere>(ball.shape).radius_m;
  pair.ball_yield = pair.radius * pair.radius / S(ball.inertia_kg_m2[0]);
  for (int k = 0; k < 3; ++k) pair.moment[k] = I[4 * k];
  return "";
}

template <class S> struct Touch {
  bool happens = false;
  S t{};
  Vec<S> n_B{}, r_B{};  // rod's axes: from rod to ball; from its centre to the touch
};

// |d + t u| = reach in the first `axes` coordinates from `foot` on; the smaller root.
template <class S> bool meets(const Vec<S>& d, const Vec<S>& u, int axes, S reach, S& t) {
  S a = 0, b = 0, c = -reach * reach;
  for (int k = 0; k < axes; ++k) {
    a = a + u[k] * u[k];
    b = b + d[k] * u[k];
    c = c + d[k] * d[k];
  }
  const S inside = b * b - a * c;
  if (!(b < 0) || !(inside > 0) || c < 0) return false;
  t = c / (sqrt(inside) - b);
  return true;
}

template <class S> Touch<S> touch_capsule(const Capsule& capsule, const Vec<S>& d, const Vec<S>& u, S radius) {
  Touch<S> made;
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
  if (meets(d, u, 2, own + radius, t) && magnitude(d[2] + t * u[2]) <= half) take(t, d[2] + t * u[2]);
  for (const S end : {half, -half}) {
    const Vec<S> from{d[0], d[1], d[2] - end};
    if (meets(from, u, 3, own + radius, t) && (end > 0 ? d[2] + t * u[2] > end : d[2] + t * u[2] < end)) take(t, end);
  }
  return made;
}

template <class S> Touch<S> touch_box(const Box& box, const Vec<S>& d, const Vec<S>& u, S radius, std::string& misfit) {
  Touch<S> made;
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
  if (near_edge && (!made.happens || t_edge <= made.t)) misfit = "the ball may meet an edge";
  return made;
}

template <class S> struct Blow { S normal{}, tangential{}, before{}, after{}; };

// Routh's process in the plane of t and n. K = (K_tt, K_tn, K_nn); u_n < 0.
template <class S> Blow<S> routh(S K_tt, S K_tn, S K_nn, S u_t, S u_n, S e, S mu) {
  Blow<S> made;
  made.before = u_n;
  made.after = -e * u_n;
  S left = made.after - u_n;  // of the normal velocity's change
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

template <class S> S off_rod(const Shape& rod, const Vec<S>& p) {
  Vec<S> beyond = p;
  if (const auto* box = std::get_if<Box>(&rod)) {
    for (int k = 0; k < 3; ++k) beyond[k] = larger(S(0), magnitude(p[k]) - S(box->half_extents_m[k]));
    return norm(beyond);
  }
  const auto& capsule = std::get<Capsule>(rod);
  beyond[2] = larger(S(0), magnitude(p[2]) - S(capsule.half_length_m));
  return norm(beyond) - S(capsule.radius_m);
}

// Does the turning rod strike the ball again? Seen from the rod (d, u: the ball's place and velocity at the blow,
// turning with w) the gap along the touch's normal is parted * t at least, less half the greatest acceleration A = w^2
// d + 2 w u times t^2: it is open until 2 parted / A. From half of that on, halving decides; beyond the rod's reach
// nothing can.
template <class S>
bool strikes_again(const Shape& rod, const Vec<S>& d, const Vec<S>& u, const Vec<S>& w_B, S radius, S parted, S rest) {
  const S rate = norm(w_B), speed = norm(u), farthest = norm(d) + speed * rest;
  if (rate == 0) return false;
  const S acceleration = rate * (rate * farthest + 2 * speed), from = parted / acceleration;
  if (!(from < rest)) return false;
  const auto gap = [&](S t) {
    const Vec<S> p = rotate(conjugate(turn((1 / rate) * w_B, rate * t)), d + t * u);
    return off_rod(rod, p) - radius;
  };
  const auto way = [&](S since, S until) { return (speed + rate * farthest) * (until - since); };
  return !stays_open<S>(from, rest, gap, way, S(1e-9) * radius);
}

// What the blow gives: the impulse on the ball and both new spins, in the rod's axes.
template <class S> struct Struck {
  std::string misfit;
  Blow<S> blow;
  Vec<S> J{}, rod_w{}, ball_w{};
  Slack<S> slack;
};

// Smaller parts of a sum are its own round-off: they are dropped, and the bars hold what they could do.
template <class S> S noise() { return 256 * unit_round_off<S>(); }

template <class S>
Struck<S> strike(const Pair<S>& pair, const Touch<S>& touch, const Vec<S>& u, const PairLaw& law, S rest) {
  Struck<S> made;
  const Vec<S>&n = touch.n_B, &r = touch.r_B;
  const auto turned_by = [&](const Vec<S>& impulse) {
    const Vec<S> moment = cross(r, impulse);
    return Vec<S>{moment[0] / pair.moment[0], moment[1] / pair.moment[1], moment[2] / pair.moment[2]};
  };
  // How the feet's velocity along `seen` (ball minus rod) changes by a unit impulse along `given` on the ball.
  const auto yields = [&](const Vec<S>& seen, const Vec<S>& given) {
    const S aside = dot(seen, given) - dot(seen, n) * dot(given, n);
    return dot(seen, given) * (pair.inverse_rod + pair.inverse_ball) + pair.ball_yield * aside +
           dot(seen, cross(turned_by(given), r));
  };
  const Vec<S> sliding = u - dot(u, n) * n, lean = r - dot(r, n) * n;
  const bool slides = norm(sliding) > noise<S>() * norm(u);
  Vec<S> along{};
  // Where nothing slides yet, the blow itself may start it, in the plane of r and n.
  if (slides) along = (1 / norm(sliding)) * sliding;
  else if (norm(lean) > noise<S>() * norm(r)) along = (1 / norm(lean)) * lean;
  const bool rough = law.friction != 0 && !is_zero(along);
  const Vec<S> across = cross(n, along);
  if (rough && magnitude(yields(across, n)) + magnitude(yields(across, along)) > noise<S>() * yields(n, n))
    made.misfit = "the impact has friction and is not planar";
  made.blow = routh(rough ? yields(along, along) : S(1), rough ? yields(along, n) : S(0), yields(n, n),
                    slides ? norm(sliding) : S(0), dot(u, n), S(law.restitution), rough ? S(law.friction) : S(0));
  made.J = made.blow.normal * n + made.blow.tangential * along;
  made.rod_w = S(-1) * turned_by(made.J);
  made.ball_w = (pair.ball_yield / pair.radius) * cross(S(-1) * n, made.J);
  const Vec<S>& w = made.rod_w;
  const Vec<S> L{pair.moment[0] * w[0], pair.moment[1] * w[1], pair.moment[2] * w[2]};
  const S tumbles = norm(cross(w, L));
  if (tumbles > noise<S>() * norm(w) * norm(L)) {
    made.misfit = "the rod is not struck in one of its planes of symmetry: it tumbles";
    return made;
  }
  const std::array<S, 3> moment{pair.moment[0], pair.moment[1], pair.moment[2]};
  const S least = std::min(moment[0], std::min(moment[1], moment[2]));
  // |w x L| = w^2 times a difference of moments times the angle off the axis, so `tumbles` over |L| least bounds no
  // angle where moments are alike; there the spin keeps to itself.
  const S dropped = tumbles == 0 ? S(0) : noise<S>() * norm(w);
  made.slack.w_rad_per_s = grown(moment, norm(w), dropped, rest) + tumbles * rest / least;
  made.slack.q = made.slack.w_rad_per_s * rest;
  if (law.friction != 0) {  // what slid, or leaned, by less than the noise
    made.slack.v_m_per_s = noise<S>() * norm(u);
    made.slack.p_m = made.slack.v_m_per_s * rest;
  }
  return made;
}

template <class S> Happening<S> happening(const Pair<S>& pair, const Touch<S>& touch, const Blow<S>& blow) {
  const bool in_order = pair.rod < pair.ball;
  Happening<S> hit;
  hit.t_s = touch.t;
  hit.body_a = in_order ? pair.rod : pair.ball;
  hit.body_b = in_order ? pair.ball : pair.rod;
  hit.x_W = pair.rod0.p_WB + touch.t * pair.rod0.v_WB + rotate(pair.rod0.q_WB, touch.r_B);
  hit.normal_W = S(in_order ? 1 : -1) * rotate(pair.rod0.q_WB, touch.n_B);
  hit.impulse_n_N_s = blow.normal;
  hit.impulse_t_N_s = magnitude(blow.tangential);
  hit.vn_before_m_per_s = blow.before;
  hit.vn_after_m_per_s = blow.after;
  return hit;
}

template <class S> Motion<S> solve(const Scenario& scenario, const std::vector<S>& t_s) {
  const Scene& scene = scenario.scene;
  const S t_end = scenario.t_end_s;
  Motion<S> motion;
  Pair<S> pair;
  motion.misfit = find_pair(scene, pair);
  if (!motion.misfit.empty()) return motion;
  const Quat<S> to_rod = conjugate(pair.rod0.q_WB);
  const Vec<S> d = rotate(to_rod, pair.ball0.p_WB - pair.rod0.p_WB),
               u = rotate(to_rod, pair.ball0.v_WB - pair.rod0.v_WB);
  const Body& rod = scene.bodies[pair.rod];
  const auto* box = std::get_if<Box>(&rod.shape);
  const S apart = off_rod(rod.shape, d) - pair.radius;
  if (apart < 0) {
    motion.misfit = "the bodies overlap at the start";
    return motion;
  }
  Touch<S> touch = box != nullptr ? touch_box(*box, d, u, pair.radius, motion.misfit)
                                  : touch_capsule(std::get<Capsule>(rod.shape), d, u, pair.radius);
  if (!motion.misfit.empty()) return motion;
  touch.happens = touch.happens && touch.t <= t_end;
  Struck<S> struck;
  if (touch.happens) {
    struck = strike(pair, touch, u, pair_law(scene, pair.rod, pair.ball), t_end - touch.t);
    motion.misfit = struck.misfit;
    motion.slack = struck.slack;
    const Vec<S> parts = u + (pair.inverse_rod + pair.inverse_ball) * struck.J;
    if (motion.misfit.empty() &&
        strikes_again(rod.shape, d + touch.t * u, parts, struck.rod_w, pair.radius, struck.blow.after, t_end - touch.t))
      motion.misfit = "the rod, turning, may strike the ball again";
    if (!motion.misfit.empty()) return motion;
    motion.happenings.push_back(happening(pair, touch, struck.blow));
  }
  const Vec<S> J_W = rotate(pair.rod0.q_WB, struck.J);
  const auto fly = [&](const Pose<S>& start, S t, S kick, const Vec<S>& spin_B) {
    Pose<S> now = start;
    now.p_WB = start.p_WB + t * start.v_WB;
    if (!touch.happens || t < touch.t) return now;
    const S since = t - touch.t, rate = norm(spin_B);
    now.v_WB = start.v_WB + kick * J_W;
    now.p_WB = now.p_WB + (since * kick) * J_W;
    now.w_WB_B = spin_B;
    if (rate != 0) now.q_WB = start.q_WB * turn((1 / rate) * spin_B, rate * since);
    return now;
  };
  const Vec<S> ball_spin = rotate(conjugate(pair.ball0.q_WB), rotate(pair.rod0.q_WB, struck.ball_w));
  for (const S& t : t_s) {
    auto& poses = motion.poses.emplace_back();
    for (const Body& body : scene.bodies) poses.push_back(initial_pose<S>(body));
    poses[pair.rod] = fly(pair.rod0, t, -pair.inverse_rod, struck.rod_w);
    poses[pair.ball] = fly(pair.ball0, t, pair.inverse_ball, ball_spin);
  }
  return motion;
}

}  // namespace

Solution struck_rod() {
  return {"struck-rod",
          "a rod struck by a ball in empty space, linear and angular impulse, Routh's process with friction: "
          "Routh, art. 168-195; Delannoy (2005), eq. 5-8",
          feature::kTouching, solve<Narrow>, solve<Wide>};
}

}  // namespace atwood::closed_form
