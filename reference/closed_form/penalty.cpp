// Compliant contact of two spheres, or of a sphere and a fixed plane, along the line of centres and without gravity.
// With the reduced mass m, the overlap d and the approach speed v:
//
// Linear (T. Schwager and T. Poschel, Granular Matter 9 (2007) 465):  m d'' = -k d - c d',  z = c / (2 sqrt(k m)) < 1,
//   d = v / w_d exp(-z w0 t) sin(w_d t),  w0^2 = k / m,  w_d = w0 sqrt(1 - z^2)
//   with tensile forces:    until d = 0 again, t = pi / w_d, with e = exp(-pi z / sqrt(1 - z^2))
//   without tensile forces: until k d + c d' = 0, t = 2 acos(z) / w_d, with e = exp(-2 z acos z / sqrt(1 - z^2));
//                           and free motion after that
// Hertz (J. reine angew. Math. 92 (1881) 156):  m d'' = -K d^(3/2),  K = 4/3 E sqrt(R)
//   by energy, with d = d_m sin(a)^(4/5), d_m = (5 m v^2 / (4 K))^(2/5):
//   d' = v cos a,  t = 4 d_m / (5 v) int_0^a sin^(-1/5)
//   and separation is the time reversal of the approach.
#include "closed_form/gauss.hpp"
#include "closed_form/hertz_phase.hpp"
#include "closed_form/solution.hpp"

namespace atwood::closed_form {

namespace {

// Overlap and its rate. Not `converged`: Newton's method for the phase of a Hertz contact did not.
template <class S> struct Overlap {
  S d{}, rate{};
  bool converged = true;
};

template <class S> struct Law {
  S m{}, v{};
  bool hertz = false, may_pull = false;
  S k{}, c{}, K{};
  S duration{}, e{1};  // [s] of the force; restitution
  S z{}, w0{}, w_d{}, max_overlap{};

  void prepare() {
    if (hertz) {
      max_overlap = 5 * m * v * v / (4 * K);
      max_overlap = fifth_root(max_overlap * max_overlap);
      duration = 2 * time_of(pi<S>() / 2);
      return;
    }
    w0 = sqrt(k / m);
    z = c / (2 * sqrt(k * m));
    w_d = w0 * sqrt((1 - z) * (1 + z));
    const S phase = may_pull ? pi<S>() : 2 * atan2(sqrt((1 - z) * (1 + z)), z);
    duration = phase / w_d;
    e = exp(-z * w0 * duration);
  }
  // int_0^a sin^(-1/5) with a = b^5: the integrand 5 b^3 (sin(b^5) / b^5)^(-1/5) is smooth.
  S time_of(S a) const {
    static const GaussRule<S> rule = gauss_rule<S>(64);  // its error is 2.1^-128 because of the nearest pole, b^5 = pi
    const S top = fifth_root(a);
    S sum = 0;
    for (std::size_t k_node = 0; k_node < rule.node.size(); ++k_node) {
      const S b = top * rule.node[k_node], b5 = b * b * b * b * b;
      if (b5 > 0) sum = sum + rule.weight[k_node] * 5 * b * b * b / fifth_root(sin(b5) / b5);
    }
    return 4 * max_overlap / (5 * v) * top * sum;
  }
  Overlap<S> at(S t) const {
    if (t >= duration && (hertz || may_pull)) return {-e * v * (t - duration), -e * v};
    if (t >= duration) return {c / k * e * v - e * v * (t - duration), -e * v};
    if (!hertz) {
      const S decay = exp(-z * w0 * t), s = sin(w_d * t), co = cos(w_d * t);
      return {v / w_d * decay * s, v * decay * (co - z * w0 / w_d * s)};
    }
    const bool out = t > duration / 2;
    const S since = out ? duration - t : t;
    const auto [a, converged] = hertz_phase(since, v, max_overlap, [this](S phase) { return time_of(phase); });
    const S y = fifth_root(sin(a)), y2 = y * y;
    return {max_overlap * y2 * y2, (out ? -1 : 1) * v * cos(a), converged};
  }
};

// a: a sphere; b: a sphere or a plane
struct BodyPair {
  int a = -1, b = -1;
};

std::string find_pair(const Scene& scene, BodyPair& pair) {
  int plane = -1;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const Body& body = scene.bodies[i];
    const std::string name = "`" + body.name + "`";
    const int at = static_cast<int>(i);
    if (body.fixed && body.shape.index() == 0) continue;
    const bool unevenness = body.fixed && std::holds_alternative<Plane>(body.shape);
    if (unevenness && plane < 0) {
      plane = at;
      continue;
    }
    if (body.fixed || !std::holds_alternative<Sphere>(body.shape) || pair.b >= 0)
      return name +
             " is one body too many or of another shape: expected two free spheres, or a free sphere and a fixed plane";
    (pair.a < 0 ? pair.a : pair.b) = at;
    if (body.release_s > 0) return name + " has a later release, which is not covered";
    for (const Force& force : scene.forces)
      if (acts_on(force, at)) return force_on_body(scene, force, at) + " is not covered";
  }
  if (pair.b >= 0 && plane >= 0)
    return "`" + scene.bodies[plane].name + "` is a fixed plane beside two free spheres, which is not covered";
  if (pair.b < 0) pair.b = plane;
  if (pair.a < 0 || pair.b < 0) return "expected two free spheres, or a free sphere and a fixed plane";
  return scene.gravity_m_per_s2 != Real3{} ? "uniform gravity is not covered" : "";
}

// n: from a to b
template <class S> struct Approach {
  S gap{};
  Vec<S> n{};
  S speed{}, lateral{};
  S inverse_mass{}, curvature{};
};

template <class S> Approach<S> approach(const Scene& scene, const BodyPair& pair) {
  Approach<S> made;
  const Body &a = scene.bodies[pair.a], &b = scene.bodies[pair.b];
  const Pose<S> pose_a = initial_pose<S>(a), pose_b = initial_pose<S>(b);
  const S radius = std::get<Sphere>(a.shape).radius_m;
  made.inverse_mass = 1 / S(a.mass_kg);
  made.curvature = 1 / radius;
  if (const auto* plane = std::get_if<Plane>(&b.shape)) {
    const Vec<S> normal = vec<S>(plane->normal);
    const S length = norm(normal);
    made.n = (-1 / length) * normal;
    made.gap = (dot(normal, pose_a.p_WB) - S(plane->offset_m)) / length - radius;
    made.speed = dot(made.n, pose_a.v_WB);
    return made;
  }
  const S other = std::get<Sphere>(b.shape).radius_m;
  const Vec<S> d = pose_b.p_WB - pose_a.p_WB, u = pose_b.v_WB - pose_a.v_WB;
  made.n = (1 / norm(d)) * d;
  made.gap = norm(d) - radius - other;
  made.speed = -dot(made.n, u);
  made.lateral = norm(cross(d, u));  // differences and products of doubles: exactly 0 where they meet head on
  made.inverse_mass = made.inverse_mass + 1 / S(b.mass_kg);
  made.curvature = made.curvature + 1 / other;
  return made;
}

template <class S> std::string find_law(const PairLaw& given, const Approach<S>& way, bool turns, Law<S>& law) {
  if (given.contact_law == ContactLaw::rigid) return "the pair's `contact_law` is rigid: expected linear or hertz";
  if (!(way.gap > 0)) return "the bodies touch or overlap at the start: expected a gap";
  if (way.lateral != 0) return "the spheres do not collide along the line of centres";
  if (given.friction != 0 && turns)
    return "the contact has friction and a body rotates or slides, which is not covered";
  law.m = 1 / way.inverse_mass;
  law.v = way.speed;
  law.hertz = given.contact_law == ContactLaw::hertz;
  law.may_pull = given.pull;
  law.k = given.stiffness_N_per_m;
  law.c = given.damping_N_s_per_m;
  law.K = S(4) / 3 * S(given.modulus_Pa) / sqrt(way.curvature);
  if (law.hertz && given.damping_s_per_m != 0) return "a Hertz contact with damping has no closed form here";
  if (!law.hertz && !(law.c * law.c < 4 * law.k * law.m))
    return "the contact is overdamped: expected damping^2 < 4 stiffness x reduced mass";
  return "";
}

// x: point of the undeformed surface of a at the start and at the end of the force.
template <class S>
void append_events(const BodyPair& pair, const Law<S>& law, const Approach<S>& way, S touch, S t_end,
                   const std::array<Vec<S>, 2>& x, Motion<S>& motion) {
  ContactEvent<S> made;
  made.body_a = pair.a < pair.b ? pair.a : pair.b;
  made.body_b = pair.a < pair.b ? pair.b : pair.a;
  made.normal_W = S(pair.a < pair.b ? 1 : -1) * way.n;
  ContactEvent<S> parts = made;
  made.t_s = touch;
  made.x_W = x[0];
  made.vn_before_m_per_s = -law.v;
  made.vn_after_m_per_s = law.e * law.v;
  made.impulse_n_N_s = (1 + law.e) * law.m * law.v;
  motion.events.push_back(made);
  if (touch + law.duration > t_end) return;
  parts.kind = EventKind::separate;
  parts.t_s = touch + law.duration;
  parts.x_W = x[1];
  motion.events.push_back(parts);
}

template <class S> Motion<S> solve_penalty(const Scenario& scenario, const std::vector<S>& t_s) {
  const Scene& scene = scenario.scene;
  Motion<S> motion;
  BodyPair pair;
  motion.refusal = find_pair(scene, pair);
  if (!motion.refusal.empty()) return motion;
  const Body &a = scene.bodies[pair.a], &b = scene.bodies[pair.b];
  const Approach<S> way = approach<S>(scene, pair);
  const bool against_plane = b.fixed;
  const Pose<S> start_a = initial_pose<S>(a), start_b = initial_pose<S>(b);
  const Vec<S> along_plane = against_plane ? start_a.v_WB - dot(start_a.v_WB, way.n) * way.n : Vec<S>{};
  const bool turns = !is_zero(start_a.w_WB_B) || !is_zero(start_b.w_WB_B) || !is_zero(along_plane);
  Law<S> law;
  motion.refusal = find_law(pair_law(scene, pair.a, pair.b), way, turns, law);
  const std::array<RotationSolution<S>, 2> turning_of{free_rotation<S>(a, S(0)), free_rotation<S>(b, S(0))};
  for (const RotationSolution<S>& each : turning_of)
    if (motion.refusal.empty()) motion.refusal = each.refusal;
  if (!motion.refusal.empty()) return motion;
  const S t_end = scenario.t_end_s, touch = law.v > 0 ? way.gap / law.v : 2 * t_end;
  if (law.v > 0) law.prepare();
  // The deviation of the overlap from v (t - touch) is shared by the bodies in inverse proportion to their masses.
  bool converged = true;  // the overlap at every time so far
  const auto fly = [&](int at, S t) {
    const Pose<S>& start = at == pair.a ? start_a : start_b;
    const Rotation<S> spin = turning_of[at == pair.a ? 0 : 1].at(t);
    Pose<S> now{start.p_WB + t * start.v_WB, start.v_WB, spin.w, spin.q};
    if (!(t > touch)) return now;
    const Overlap<S> overlap = law.at(t - touch);
    converged = converged && overlap.converged;
    const S share = (at == pair.a ? 1 : -1) * law.m / S(scene.bodies[at].mass_kg);
    now.p_WB = now.p_WB + (share * (overlap.d - law.v * (t - touch))) * way.n;
    now.v_WB = now.v_WB + (share * (overlap.rate - law.v)) * way.n;
    return now;
  };
  for (const S& t : t_s) {
    auto& poses = motion.poses.emplace_back();
    for (const Body& body : scene.bodies) poses.push_back(initial_pose<S>(body));
    for (const int at : {pair.a, pair.b})
      if (!scene.bodies[at].fixed && t > 0) poses[at] = fly(at, t);
    if (converged) continue;
    motion.undecided = "Newton's method for the overlap did not converge";
    motion.end_s = t;
    motion.poses.pop_back();
    break;
  }
  const S end = converged ? t_end : motion.end_s;
  if (touch > end) return motion;
  const Vec<S> arm = S(std::get<Sphere>(a.shape).radius_m) * way.n;
  const Vec<S> begins = fly(pair.a, touch).p_WB + arm, ends = fly(pair.a, touch + law.duration).p_WB + arm;
  append_events(pair, law, way, touch, end, {begins, ends}, motion);
  return motion;
}

}  // namespace

Solution penalty() {
  return {"penalty", "compliant contact: spring and dashpot, Schwager and Poschel (2007); Hertz (1881)",
          feature::spin | feature::kSimpleContact | feature::linear_contact | feature::hertz_contact,
          solve_penalty<Narrow>, solve_penalty<Wide>};
}

}  // namespace atwood::closed_form
