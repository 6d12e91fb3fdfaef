// Boxes that slide and round bodies that slip and roll along a floor, each on a straight line: Coulomb's friction
// (C. A. Coulomb, Theorie des machines simples, 1785), spins by Euler (E. J. Routh, Dynamics of a System of Rigid
// Bodies, art. 144; G. G. Coriolis, Jeu de billard, 1835).
//
// Along the line (e; gravity g_s along it, g_n into the floor) the surface slides at u = v - r w, w about n x e:
//   slip:  v' = g_s - mu g_n sign u,  w' = mu g_n sign u m r / I,
//          u' = g_s - kappa mu g_n sign u,  kappa = 1 + m r^2 / I
//   roll:  u = 0,  v' = r w' = g_s (1 - 1 / kappa), while friction can: |g_s| <= kappa mu g_n
// A box does not rotate (kappa = 1); "rolling" then means rest. It tips when the centre of pressure, at height f / N
// ahead of the box's centre, is outside of its base.
#include <algorithm>

#include "closed_form/floor.hpp"

namespace atwood::closed_form {

namespace {

template <class S> struct Leg {  // s, v along the line; angle, w about n x e; constant accelerations
  S t{}, s{}, v{}, angle{}, w{}, a{}, spin_up{};
  bool holds = false;  // rolling, or at rest
  S slowed{};          // how fast the slip of the phase before went down
};

template <class S> struct Line {
  Vec<S> e{}, about{};               // unit; zero when nothing moves
  S kappa{1}, r{}, turn_per_push{};  // turn_per_push: m r / I
  bool round = false;
  std::vector<Leg<S>> legs;
  S s_least{}, s_most{};
  S dropped_v{}, dropped_a{};  // speed and acceleration treated as zero: off the line, and slip

  Leg<S> at(S t) const {
    std::size_t k = 0;
    while (k + 1 < legs.size() && legs[k + 1].t <= t) ++k;
    Leg<S> now = legs[k];
    const S since = t - now.t;
    now.t = t;
    now.s += since * (now.v + since * now.a / 2);
    now.angle += since * (now.w + since * now.spin_up / 2);
    now.v += since * now.a;
    now.w += since * now.spin_up;
    return now;
  }

  // One phase of constant acceleration after another, the first with the slip u: slip ends at u = 0.
  void march(S u, S g_s, S grip, S t_end) {
    Leg<S> next = legs.front();
    legs.clear();
    while (legs.size() < 4) {
      next.holds = u == 0 && magnitude(g_s) <= kappa * grip;
      const S side = u != 0 ? (u > 0 ? 1 : -1) : (g_s > 0 ? 1 : -1);
      next.a = next.holds ? g_s * (1 - 1 / kappa) : g_s - side * grip;
      next.spin_up = !round ? S(0) : next.holds ? next.a / r : side * grip * turn_per_push;
      legs.push_back(next);
      const S slowing = -side * (g_s - side * kappa * grip);  // of |u|
      const S until = next.holds || u == 0 || !(slowing > 0) ? t_end : next.t + magnitude(u) / slowing;
      const S stop = until < t_end ? until : t_end;
      reach(next, stop);
      if (!(until < t_end)) return;
      next = at(until);
      next.slowed = slowing;
      if (round) next.w = next.v / r;
      else next.v = 0;
      u = 0;
    }
  }
  // The part of the line that this phase covers until `stop`, including a turning point.
  void reach(const Leg<S>& leg, S stop) {
    const S turns = leg.a != 0 ? leg.t - leg.v / leg.a : leg.t;
    for (const S t : {leg.t, stop, turns}) {
      if (t < leg.t || t > stop) continue;
      const S s = leg.s + (t - leg.t) * (leg.v + (t - leg.t) * leg.a / 2);
      s_most = larger(s_most, s);
      s_least = s < s_least ? s : s_least;
    }
  }
};

template <class S> bool across(const Vec<S>& a, const Vec<S>& e) { return norm(cross(a, e)) > S(0x1p-48) * norm(a); }

template <class S>
std::string tips(const FloorContact<S>& contact, const Line<S>& line, const Floor<S>& floor, S g_s, S grip) {
  for (const Leg<S>& leg : line.legs) {
    const S ahead = contact.height * (leg.holds ? magnitude(g_s) : grip) / floor.g_n;
    for (int k = 0; k < 2; ++k)
      if (ahead * magnitude(dot(contact.side[k], line.e)) > contact.half[k])
        return "would tip over, which is not covered";
  }
  return "";
}

template <class S>
std::string find_line(const Scene& scene, int at, const Floor<S>& floor, const FloorContact<S>& contact, S t_end,
                      Line<S>& line) {
  const Body& body = scene.bodies[at];
  const std::string name = "`" + body.name + "`";
  const PairLaw& law = pair_law(scene, at, floor.body);
  if (law.rolling_friction_m != 0) return name + " has rolling friction";
  for (const Force& force : scene.forces)
    if (acts_on(force, at)) return force_on_body(scene, force, at) + " is not covered";
  const Pose<S> start = initial_pose<S>(body);
  const Vec<S> v = start.v_WB - dot(start.v_WB, floor.n) * floor.n, w = rotate(start.q_WB, start.w_WB_B);
  line.round = !std::holds_alternative<Box>(body.shape);
  if (!line.round && !is_zero(w)) return name + " is a box that spins";
  if (line.round && !rotates(body)) return name + " is a point mass: expected an inertia for rolling";
  const Vec<S> spun = cross(w, floor.n);  // velocity of the surface due to the spin
  const Vec<S> along = !is_zero(v) ? v : !is_zero(spun) ? spun : floor.g_t;
  line.legs.push_back({});
  if (is_zero(along) && is_zero(w)) {
    line.legs[0].holds = true;
    return "";
  }
  if (is_zero(along)) return name + " spins about the normal of the floor, which is not covered";
  line.e = (1 / norm(along)) * along;
  line.about = cross(floor.n, line.e);
  line.dropped_v = norm(cross(v, line.e)) + S(contact.extent_m) * norm(cross(w, line.about));
  line.dropped_a = norm(cross(floor.g_t, line.e));
  if (across(v, line.e) || across(floor.g_t, line.e) || across(w, line.about))
    return name + " does not move along one line: its velocity, its spin and the slope have different directions";
  if (line.round) {
    const Real33& I = body.inertia_kg_m2;
    const bool cylinder = std::holds_alternative<Cylinder>(body.shape);
    if (cylinder && (across(contact.axis, line.about) || I[2] != 0 || I[5] != 0))
      return name + " does not rotate about its axis";
    if (!cylinder && !has_spherical_inertia(body)) return name + " has different principal moments of inertia";
    line.r = contact.height;
    line.turn_per_push = S(body.mass_kg) * line.r / S(I[8]);
    line.kappa = 1 + line.r * line.turn_per_push;
  }
  const S g_s = dot(floor.g_t, line.e), grip = S(law.friction) * floor.g_n;
  Leg<S>& first = line.legs.front();
  first.v = dot(v, line.e);
  first.w = dot(w, line.about);
  S slip = first.v - line.r * first.w;
  // Values that mean rolling differ from it by round-off, which is treated as zero slip and included in the bars.
  if (line.round && magnitude(slip) <= S(0x1p-48) * magnitude(first.v)) {
    line.dropped_v = line.dropped_v + magnitude(slip);
    first.w = first.v / line.r;
    slip = 0;
  }
  line.march(slip, g_s, grip, t_end);
  const std::string falls = line.round ? "" : tips(contact, line, floor, g_s, grip);
  return falls.empty() ? "" : name + " " + falls;
}

// With friction the difference of two motions of a body does not grow in the norm of kinetic energy. The neglected
// parts therefore act on the velocity by themselves and their time integral, and on r w by sqrt(m r^2 / I) times that.
// A factor of 4 covers all terms of second order in the neglected parts. Answers the bound for the slip.
template <class S>
S add_slack(InputRoundOff<S>& input_round_off, const Body& body, const FloorContact<S>& contact, const Line<S>& line,
            S slope, S t_end) {
  const S v = 4 * (contact.normal_speed + line.dropped_v + t_end * (line.dropped_a + slope));
  input_round_off.v_m_per_s = larger(input_round_off.v_m_per_s, v);
  input_round_off.p_m = larger(input_round_off.p_m, contact.gap_error_m + v * t_end);
  S turned = 4 * contact.tilt, slip = v;
  if (line.round || line.kappa != 1) {
    const S inertia = body.inertia_kg_m2[8], r = contact.height;
    const S w = inertia > 0 ? v / r * larger(S(1), sqrt(S(body.mass_kg) * r * r / inertia)) : S(0);
    input_round_off.w_rad_per_s = larger(input_round_off.w_rad_per_s, w);
    turned = turned + w * t_end;
    slip += r * w;
  }
  input_round_off.q = larger(input_round_off.q, turned);
  return slip;
}

template <class S>
ContactEvent<S> holding(const Floor<S>& floor, int at, const Line<S>& line, const Vec<S>& foot, const Leg<S>& leg,
                        S slip) {
  ContactEvent<S> made;
  made.t_s = leg.t;
  made.slack_s = slip / leg.slowed;
  made.kind = line.round ? EventKind::roll : EventKind::stick;
  made.body_a = at < floor.body ? at : floor.body;
  made.body_b = at < floor.body ? floor.body : at;
  made.x_W = foot + leg.s * line.e;
  made.normal_W = S(at < floor.body ? -1 : 1) * floor.n;
  return made;
}

struct Way {
  int body;
  Vec<double> from, to;
  double extent_m;
};

std::string ways_meet(const Scene& scene, const std::vector<Way>& ways) {
  for (std::size_t i = 0; i < ways.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (segment_distance(ways[i].from, ways[i].to, ways[j].from, ways[j].to) <= ways[i].extent_m + ways[j].extent_m)
        return "`" + scene.bodies[ways[j].body].name + "` and `" + scene.bodies[ways[i].body].name +
               "` could touch each other, which is not covered";
  return "";
}

template <class S> Motion<S> solve_slide_or_roll(const Scenario& scenario, const std::vector<S>& t_s) {
  const Scene& scene = scenario.scene;
  Motion<S> motion;
  const Floor<S> floor = find_floor<S>(scene);
  motion.refusal = floor.refusal;
  motion.poses.assign(t_s.size(), std::vector<Pose<S>>(scene.bodies.size()));
  std::vector<Way> ways;
  for (std::size_t i = 0; i < scene.bodies.size() && motion.refusal.empty(); ++i) {
    const Body& body = scene.bodies[i];
    const Pose<S> start = initial_pose<S>(body);
    for (auto& poses : motion.poses) poses[i] = start;
    if (body.fixed) continue;
    const int at = static_cast<int>(i);
    const FloorContact<S> contact = floor_contact(floor, scene, at);
    Line<S> line;
    motion.refusal = contact.refusal;
    if (motion.refusal.empty()) motion.refusal = find_line(scene, at, floor, contact, S(scenario.t_end_s), line);
    if (!motion.refusal.empty()) return motion;
    const Vec<S> axis_B = rotate(conjugate(start.q_WB), line.about);
    for (std::size_t k = 1; k < t_s.size(); ++k) {
      const Leg<S> now = line.at(t_s[k]);
      motion.poses[k][i] = {start.p_WB + now.s * line.e, now.v * line.e, now.w * axis_B,
                            start.q_WB * turn(axis_B, now.angle)};
    }
    const S slip = add_slack(motion.input_round_off, body, contact, line, floor.neglected, S(scenario.t_end_s));
    for (std::size_t k = 1; k < line.legs.size(); ++k)
      if (line.legs[k].holds)
        motion.events.push_back(holding(floor, at, line, start.p_WB - contact.height * floor.n, line.legs[k], slip));
    const Vec<S> least = start.p_WB + line.s_least * line.e, most = start.p_WB + line.s_most * line.e;
    ways.push_back({at, rounded(least), rounded(most), contact.extent_m});
    motion.refusal = leaves_floor(floor, scene, ways.back().from, ways.back().to, contact.extent_m);
  }
  if (motion.refusal.empty()) motion.refusal = ways_meet(scene, ways);
  std::sort(motion.events.begin(), motion.events.end(),
            [](const ContactEvent<S>& a, const ContactEvent<S>& b) { return a.t_s < b.t_s; });
  return motion;
}

}  // namespace

Solution slide_or_roll() {
  return {"slide-or-roll", "sliding blocks and rolling bodies on a floor: Coulomb (1785), Routh, art. 144",
          feature::uniform_gravity | feature::spin | feature::kSimpleContact, solve_slide_or_roll<Narrow>,
          solve_slide_or_roll<Wide>};
}

}  // namespace atwood::closed_form
