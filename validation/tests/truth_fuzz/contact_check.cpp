#include "contact_check.hpp"

#include <algorithm>

#include "extrapolation.hpp"

namespace atwood::fuzz {
namespace {

Long size(const Long3& v) { return sqrt(dot(v, v)); }

struct Floor {
  Long3 n{}, g_t{};  // unit normal; gravity along the floor
  Long g_n = 0;      // into the floor
};
Floor floor_of(const Scene& scene) {
  Floor made;
  made.n = normalised(widened(std::get<Plane>(scene.bodies[0].shape).normal));
  const Long3 g = widened(scene.gravity_m_per_s2);
  made.g_n = -dot(made.n, g);
  made.g_t = g + made.g_n * made.n;
  if (size(made.g_t) < Long("1e-50") * made.g_n) made.g_t = {};  // of exact numbers: the round-off of 60 digits
  return made;
}

}  // namespace

// With f the acceleration by friction: v' = g_t + f, w' = -(m r / I) n x f, and the slip u = v - r w x n changes by
// g_t + kappa f, kappa = 1 + m r^2 / I.
Checked check_slide_or_roll(const Scenario& scenario, std::int64_t samples) {
  const Scene& scene = scenario.scene;
  const Body& body = scene.bodies[1];
  const Floor floor = floor_of(scene);
  const Long grip = Long(pair_law(scene, 0, 1).friction) * floor.g_n;
  const auto* sphere = std::get_if<Sphere>(&body.shape);
  const auto* cylinder = std::get_if<Cylinder>(&body.shape);
  const Long r = sphere ? sphere->radius_m : cylinder ? cylinder->radius_m : 0;
  const Long turn = r > 0 ? Long(body.mass_kg) * r / body.inertia_kg_m2[8] : Long(0), kappa = 1 + r * turn;
  LongBody now = start_of(body);
  Long3 w = turned(now.q, now.w);
  Checked made = of_starts(scenario, samples);
  made.has_events = true;
  const Long end = scenario.t_end_s;
  Long t = 0;
  std::size_t sample = 0;
  for (int phase = 0; phase < 6; ++phase) {
    const Long3 u = now.v - r * cross(w, floor.n);
    const Long slip = size(u), pull = size(floor.g_t), scale = size(now.v) + r * size(w);
    const bool slips = slip > Long("1e-50") * scale;
    const bool holds = !slips && pull <= kappa * grip;
    const Long3 way = slips ? Long(1) / slip * u : pull > 0 ? Long(1) / pull * floor.g_t : Long3{};
    const Long3 f = holds ? Long(-1) / kappa * floor.g_t : -grip * way, a = floor.g_t + f;
    const Long3 dw = -turn * cross(floor.n, f);
    const Long slows = -dot(way, floor.g_t + kappa * f);
    const Long until = slips && slows > 0 ? Long(t + slip / slows) : Long(2 * end);
    if (phase > 0 && holds) made.event_s.push_back(t);
    // The truth takes such slip for none: it is within the round-off of the doubles of a roll.
    if (phase == 0 && slips && slip < Long(0x1p-47) * scale) made.has_events = false;
    for (; sample < made.values.size() && Long(end * static_cast<int>(sample) / samples) <= until; ++sample) {
      const Long h = end * static_cast<int>(sample) / samples - t;
      LongBody& at = made.values[sample][1];
      at.p = now.p + h * (now.v + h / 2 * a);
      at.v = now.v + h * a;
      // Angular velocity and acceleration have one line.
      const Long3 way_round = size(w) > 0 ? w : dw;
      const Long3 angle = h * w + h * h / 2 * dw;
      at.q = now.q;
      if (size(way_round) > 0) {
        const Long3 axis = normalised(way_round);
        at.q = product(quaternion_about(axis, dot(axis, angle)), now.q);
      }
      at.w = turned_back(at.q, w + h * dw);
    }
    if (until > end) break;
    const Long h = until - t;
    const Long3 way_round = size(w) > 0 ? w : dw;
    if (size(way_round) > 0) {
      const Long3 axis = normalised(way_round);
      now.q = product(quaternion_about(axis, dot(axis, h * w + h * h / 2 * dw)), now.q);
    }
    now.p = now.p + h * (now.v + h / 2 * a);
    now.v = now.v + h * a;
    w = w + h * dw;
    // The slip has ended: its round-off goes.
    if (r > 0) w = dot(w, floor.n) * floor.n + Long(1) / r * cross(floor.n, now.v);
    else now.v = {};
    t = until;
  }
  set_own(made, made, Long("1e-48"));
  for (auto& row : made.own)
    for (std::size_t c = 0; c < 4; ++c) row[1].q[c] += Long("1e-48");
  return made;
}

Checked check_rest(const Scenario& scenario, std::int64_t samples) {
  const Scene& scene = scenario.scene;
  Checked made = of_starts(scenario, samples);
  const Long3 g = widened(scene.gravity_m_per_s2);  // the floor's normal is z
  const Long slope = sqrt(g[0] * g[0] + g[1] * g[1]), into = -g[2];
  if (!(into > 0)) made.contradicts = "gravity does not press on the floor";
  // One coefficient for all pairs: a stack that slides does so as a whole.
  const Long friction = scene.pairs[0].friction, slides = slope - friction * into;
  const Long3 a = slides > 0 ? slides / slope * Long3{g[0], g[1], 0} : Long3{};
  for (std::size_t i = 1; i < scene.bodies.size(); ++i) {
    for (std::size_t k = 1; k < made.values.size(); ++k) {
      const Long t = Long(scenario.t_end_s) * static_cast<int>(k) / samples;
      made.values[k][i].p = made.values[k][i].p + t * t / 2 * a;
      made.values[k][i].v = t * a;
    }
    Long mass = 0;
    Long3 centre{};
    for (std::size_t k = i; k < scene.bodies.size(); ++k) {
      mass += scene.bodies[k].mass_kg;
      centre = centre + Long(scene.bodies[k].mass_kg) * widened(scene.bodies[k].position_m);
    }
    centre = 1 / mass * centre;
    const auto& half = std::get<Box>(scene.bodies[i].shape).half_extents_m;
    const Long height = centre[2] - (scene.bodies[i].position_m[2] - Long(half[2]));
    for (std::size_t c = 0; c < 2; ++c) {
      const Long at = centre[c] + height * (g[c] - a[c]) / into;
      Long low = scene.bodies[i].position_m[c] - Long(half[c]), high = scene.bodies[i].position_m[c] + Long(half[c]);
      if (i > 1) {
        const double below = std::get<Box>(scene.bodies[i - 1].shape).half_extents_m[c];
        low = std::max(low, Long(scene.bodies[i - 1].position_m[c] - Long(below)));
        high = std::min(high, Long(scene.bodies[i - 1].position_m[c] + Long(below)));
      }
      if (!(low <= at && at <= high)) made.contradicts = "`" + scene.bodies[i].name + "` tips";
    }
  }
  set_own(made, made, slides > 0 ? Long("1e-50") : Long(0));
  return made;
}

// ---- the struck rod -----------------------------------------------------------------------------------------------

namespace {

struct Side {
  LongBody now;
  Long light = 0;                           // 1 / mass
  Long3 yields{};                           // 1 / moments, body axes
  Long3 arm{};                              // from the centre to the contact, world
  Long3 spun(const Long3& impulse) const {  // change of the angular velocity, world
    const Long3 moment = turned_back(now.q, cross(arm, impulse));
    return turned(now.q, {yields[0] * moment[0], yields[1] * moment[1], yields[2] * moment[2]});
  }
  Long3 moved(const Long3& impulse) const { return light * impulse + cross(spun(impulse), arm); }
};

Side side_of(const Body& body) {
  Side made;
  made.now = start_of(body);
  made.light = 1 / Long(body.mass_kg);
  for (std::size_t c = 0; c < 3; ++c) made.yields[c] = 1 / Long(body.inertia_kg_m2[4 * c]);
  return made;
}

// The point of the capsule's line next to p, from its centre, world.
Long3 next_to(const LongBody& rod, const Capsule& capsule, const Long3& p) {
  const Long half = capsule.half_length_m, along = turned_back(rod.q, p - rod.p)[2];
  return turned(rod.q, {0, 0, std::clamp(along, Long(-half), half)});
}

}  // namespace

Checked check_struck_rod(const Scenario& scenario, std::int64_t samples) {
  const Scene& scene = scenario.scene;
  const auto& capsule = std::get<Capsule>(scene.bodies[0].shape);
  const Long reach = Long(capsule.radius_m) + std::get<Sphere>(scene.bodies[1].shape).radius_m, end = scenario.t_end_s;
  Side rod = side_of(scene.bodies[0]), ball = side_of(scene.bodies[1]);
  const auto fly = [](LongBody at, const Long& t) {
    at.p = at.p + t * at.v;
    return at;
  };
  const auto gap = [&](const Long& t) {
    const LongBody r = fly(rod.now, t), b = fly(ball.now, t);
    return Long(size(b.p - r.p - next_to(r, capsule, b.p)) - reach);
  };
  // The distance is a convex function of the time: its minimum, then the sign change before it.
  Long low = 0, high = end;
  for (int third = 0; third < 360; ++third) {
    const Long a = (2 * low + high) / 3, b = (low + 2 * high) / 3;
    if (gap(a) < gap(b)) high = b;
    else low = a;
  }
  Checked made = of_starts(scenario, samples);
  made.has_events = true;
  Long touch = 2 * end;
  Long3 rod_w{}, ball_w{};
  const LongBody rod0 = rod.now, ball0 = ball.now;
  if (gap(high) < 0) {
    for (low = 0; high - low > Long("1e-58") * end;) {
      const Long middle = (low + high) / 2;
      (gap(middle) > 0 ? low : high) = middle;
    }
    touch = low;
    made.event_s = {touch};
    rod.now = fly(rod.now, touch);
    ball.now = fly(ball.now, touch);
    const Long3 line = next_to(rod.now, capsule, ball.now.p), n = normalised(ball.now.p - rod.now.p - line);
    rod.arm = line + Long(capsule.radius_m) * n;
    ball.arm = Long(-std::get<Sphere>(scene.bodies[1].shape).radius_m) * n;
    // Routh: per unit of the normal impulse, -mu s during slip in the direction s, or what keeps the slip at 0.
    const PairLaw& law = pair_law(scene, 0, 1);
    Long3 u = ball.now.v - rod.now.v, J{};
    const auto yields = [&](const Long3& impulse) { return ball.moved(impulse) + rod.moved(impulse); };
    Long left = -(1 + Long(law.restitution)) * dot(u, n);
    for (int phase = 0; phase < 3 && left > 0; ++phase) {
      const Long3 slip = u - dot(u, n) * n, own = yields(n), across = own - dot(own, n) * n;
      const bool slides = law.friction > 0 && size(slip) > Long("1e-45") * size(u);
      Long3 push = n;
      if (slides) {
        push = n - Long(law.friction) / size(slip) * slip;
      } else if (law.friction > 0 && size(across) > Long("1e-45") * size(own)) {
        const Long3 s = normalised(across);
        const Long holds = size(across) / dot(s, yields(s));
        push = n - std::min(holds, Long(law.friction)) * s;
      }
      const Long3 gains = yields(push);
      Long part = left / dot(gains, n);
      const Long stops = slides ? Long(-dot(slip, gains) / dot(slip, slip)) : Long(0);  // of the slip, by unit impulse
      if (stops > 0 && 1 / stops < part) part = 1 / stops;
      J = J + part * push;
      u = u + part * gains;
      left -= part * dot(gains, n);
      if (left < Long("1e-50") * abs(dot(u, n))) break;
    }
    rod.now.v = rod.now.v - rod.light * J;
    ball.now.v = ball.now.v + ball.light * J;
    rod_w = Long(-1) * rod.spun(J);
    if (law.friction > 0) ball_w = ball.spun(J);
  }
  const auto spun = [](LongBody at, const Long3& w, const Long& t) {
    const Long rate = size(w);
    at.w = turned_back(at.q, w);
    if (rate > 0) at.q = product(quaternion_about(Long(1) / rate * w, rate * t), at.q);
    return at;
  };
  for (std::size_t k = 0; k < made.values.size(); ++k) {
    const Long t = end * static_cast<int>(k) / samples;
    made.values[k] = t < touch ? std::vector<LongBody>{fly(rod0, t), fly(ball0, t)}
                               : std::vector<LongBody>{spun(fly(rod.now, t - touch), rod_w, t - touch),
                                                       spun(fly(ball.now, t - touch), ball_w, t - touch)};
  }
  set_own(made, made, Long("1e-46"));
  widen_bodies(made, Long("1e-46"));
  return made;
}

}  // namespace atwood::fuzz
