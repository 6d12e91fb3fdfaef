// A smooth ball on a plane under uniform gravity, Newton's restitution (Principia, scholium to the laws of motion).
// The first impact has speed V; after the k-th the speed is e^k V and the next flight takes 2 e^k V / a, so
//   t_k = t_1 + (2 V / a) (e + e^2 + ... + e^(k-1)),   all bounces end at t_1 + (2 V / a) e / (1 - e)
// and the ball stays on the plane. Along the plane it moves freely (no friction).
#include <algorithm>

#include "closed_form/solution.hpp"

namespace atwood::closed_form {

namespace {

constexpr std::size_t kMaxBounces = 1000000;

struct Cast {
  int ball = -1, plane = -1;
};

std::string find_cast(const Scene& scene, Cast& cast) {
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const Body& body = scene.bodies[i];
    const bool plane = std::holds_alternative<Plane>(body.shape), ball = std::holds_alternative<Sphere>(body.shape);
    if (body.fixed && body.shape.index() == 0) continue;
    if (body.fixed && plane && cast.plane < 0) cast.plane = static_cast<int>(i);
    else if (!body.fixed && ball && cast.ball < 0) cast.ball = static_cast<int>(i);
    else
      return "`" + body.name +
             "` is one body too many or of another shape: expected one free sphere and one fixed plane";
  }
  if (cast.ball < 0 || cast.plane < 0) return "expected one free sphere and one fixed plane";
  for (const Force& force : scene.forces)
    if (acts_on(force, cast.ball)) return force_on_body(scene, force, cast.ball) + " is not covered";
  return "";
}

template <class S> struct Bounces {
  S e{}, h0{}, u0{}, a{};              // gap, its rate, acceleration towards the plane
  Vec<S> p0{}, n{}, slide{}, drift{};  // velocity and acceleration along the plane
  S V{}, stop{};
  bool ever = false, stops = false;
  std::vector<S> t;      // impacts
  std::vector<S> speed;  // after each impact

  // The root of h0 + u0 t - a t^2 / 2 with a decreasing gap, without cancellation.
  void first_impact() {
    const S square = u0 * u0 + 2 * a * h0;
    ever = square >= 0 && (a > 0 || u0 < 0) && !(a == 0 && u0 == 0);
    if (!ever) return;
    V = sqrt(square);
    t.push_back(u0 <= 0 && V - u0 > 0 ? 2 * h0 / (V - u0) : a > 0 ? (u0 + V) / a : S(0));
    speed.push_back(e * V);
  }
  // All flights after one that begins with speed u, itself included: (2 u / a) (1 + e + e^2 + ...).
  S remaining(S u) const { return 2 * u / (a * (1 - e)); }
  std::string list_impacts(S t_end) {
    first_impact();
    if (!ever || !(a > 0)) return "";
    stops = e < 1;
    stop = stops ? t[0] + remaining(e * V) : S(0);
    while (t.back() <= t_end && speed.back() > 0) {
      const S next = t.back() + 2 * speed.back() / a;
      if (stops && remaining(speed.back()) <= unit_round_off<S>() * stop) break;
      if (t.size() >= kMaxBounces) return "more than " + std::to_string(kMaxBounces) + " impacts";
      t.push_back(next);
      speed.push_back(e * speed.back());
    }
    return "";
  }
  CenterMotion<S> at(S now) const {
    const bool lies = ever && a > 0 && V == 0;  // from the start, whatever its restitution
    const bool rests = lies || (stops && now >= stop);
    S h = 0, u = 0;
    if (!rests) {
      S from = 0, height = h0, up = u0;
      const auto after = std::upper_bound(t.begin(), t.end(), now);
      if (after != t.begin()) {
        const auto k = static_cast<std::size_t>(after - t.begin()) - 1;
        from = t[k];
        height = 0;
        up = speed[k];
      }
      const S since = now - from;
      h = height + since * (up - a * since / 2);
      u = up - a * since;
    }
    return {p0 + (h - h0) * n + now * (slide + (now / 2) * drift), slide + now * drift + u * n};
  }
};

template <class S> ContactEvent<S> contact_event(const Bounces<S>& path, const Cast& cast, S radius, S t, S release) {
  ContactEvent<S> made;
  made.t_s = t + release;
  made.body_a = std::min(cast.ball, cast.plane);
  made.body_b = std::max(cast.ball, cast.plane);
  made.x_W = path.p0 + (-path.h0 - radius) * path.n + t * (path.slide + (t / 2) * path.drift);
  made.normal_W = S(cast.ball > cast.plane ? 1 : -1) * path.n;
  return made;
}

template <class S>
void list_happenings(const Bounces<S>& path, const Cast& cast, S radius, S mass, S release, S t_end,
                     Motion<S>& motion) {
  S before = path.V;
  for (std::size_t k = 0; k < path.t.size() && path.t[k] + release <= t_end; ++k) {
    // Bounces whose times equal the end in double have no events of their own.
    if (k > 0 && path.stops && path.remaining(path.speed[k]) < S(0x1p-53) * path.stop) break;
    if (before == 0) break;
    ContactEvent<S> impact = contact_event(path, cast, radius, path.t[k], release);
    impact.vn_before_m_per_s = -before;
    impact.vn_after_m_per_s = path.speed[k];
    impact.impulse_n_N_s = mass * (1 + path.e) * before;
    motion.events.push_back(impact);
    before = path.speed[k];
  }
  if (!path.stops || path.stop + release > t_end) return;
  if (path.stop == 0 && path.V == 0) return;  // at rest from the start
  ContactEvent<S> rest = contact_event(path, cast, radius, path.stop, release);
  rest.kind = EventKind::rest;
  motion.events.push_back(rest);
}

template <class S> Motion<S> solve_bounce(const Scenario& scenario, const std::vector<S>& t_s) {
  const Scene& scene = scenario.scene;
  Motion<S> motion;
  Cast cast;
  motion.refusal = find_cast(scene, cast);
  if (!motion.refusal.empty()) return motion;
  const Body& ball = scene.bodies[cast.ball];
  const Plane& plane = std::get<Plane>(scene.bodies[cast.plane].shape);
  const PairLaw& law = pair_law(scene, std::min(cast.ball, cast.plane), std::max(cast.ball, cast.plane));
  const Pose<S> start = initial_pose<S>(ball);
  const Vec<S> g = vec<S>(scene.gravity_m_per_s2), normal = vec<S>(plane.normal);
  const S radius = std::get<Sphere>(ball.shape).radius_m, length = norm(normal), release = ball.release_s;
  Bounces<S> path;
  path.e = law.restitution;
  path.n = (1 / length) * normal;
  path.p0 = start.p_WB;
  path.h0 = (dot(normal, path.p0) - S(plane.offset_m)) / length - radius;
  path.u0 = dot(path.n, start.v_WB);
  path.a = -dot(path.n, g);
  path.slide = start.v_WB - path.u0 * path.n;
  path.drift = g + path.a * path.n;
  const Vec<S> spin = rotate(start.q_WB, start.w_WB_B);
  const S contact_tolerance = 4 * unit_round_off<double>() * radius;  // the round-off of the scene's doubles
  if (path.h0 < 0 && -path.h0 <= contact_tolerance) {
    motion.input_round_off.p_m = -2 * path.h0 * (1 + path.a * S(scenario.t_end_s) * S(scenario.t_end_s) / radius);
    motion.input_round_off.v_m_per_s =
        motion.input_round_off.p_m / radius * larger(path.a * S(scenario.t_end_s), norm(start.v_WB));
    path.h0 = 0;
  }
  if (path.h0 < 0) motion.refusal = "`" + ball.name + "` overlaps the plane at the start";
  if (law.friction != 0 && !(is_zero(path.slide) && is_zero(path.drift) && is_zero(cross(spin, path.n))))
    motion.refusal = "the contact has friction and `" + ball.name + "` slides or spins, which is not covered";
  const RotationSolution<S> turns = free_rotation<S>(ball, S(0));
  if (motion.refusal.empty()) motion.refusal = turns.refusal;
  if (motion.refusal.empty()) motion.refusal = path.list_impacts(S(scenario.t_end_s) - release);
  if (!motion.refusal.empty()) return motion;
  for (const S& t : t_s) {
    auto& poses = motion.poses.emplace_back();
    for (const Body& body : scene.bodies) poses.push_back(initial_pose<S>(body));
    const S since = t - release;
    if (!(since > 0)) continue;
    const CenterMotion<S> flight = path.at(since);
    const Rotation<S> now = turns.at(since);
    poses[cast.ball] = {flight.p, flight.v, now.w, now.q};
  }
  list_happenings(path, cast, radius, S(ball.mass_kg), release, S(scenario.t_end_s), motion);
  return motion;
}

}  // namespace

Solution bounce() {
  return {"bounce", "ball on a plane, impacts in closed form: geometric series of flights, Newton's restitution",
          feature::kFreeMotion | feature::kSimpleContact, solve_bounce<Narrow>, solve_bounce<Wide>};
}

}  // namespace atwood::closed_form
