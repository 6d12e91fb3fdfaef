// Random scenes with events that begin and end between two samples: balls thrown past pegs, sliders that just reach
// their stop, what is lifted from its stop or its floor for a moment. Each is answered with one, few and many samples.
// Half of the scenes are grazes: the nearest approach, or the height of a lift, is 1e-9 to 1e-2 of the size on either
// side of zero.
#include <algorithm>
#include <boost/math/constants/constants.hpp>
#include <cmath>

#include "draw.hpp"
#include "flights_check.hpp"

namespace atwood::fuzz {
namespace {

// ---- a point on a line above a stop, under a constant and an oscillating acceleration -------------------------------

struct Line {
  Long a, b, w, phase;  // z'' = a + b cos(w t + phase)
  Long e;               // restitution at z = 0

  Long pull(const Long& t) const { return a + b * cos(w * t + phase); }
  // From z0, v0 at t0.
  Long speed(const Long& t, const Long& t0, const Long& v0) const {
    return v0 + a * (t - t0) + b / w * (sin(w * t + phase) - sin(w * t0 + phase));
  }
  Long height(const Long& t, const Long& t0, const Long& z0, const Long& v0) const {
    const Long s = t - t0;
    return z0 + v0 * s + a * s * s / 2 - b / w * sin(w * t0 + phase) * s -
           b / (w * w) * (cos(w * t + phase) - cos(w * t0 + phase));
  }
  // Where a + b cos(w t + phase) changes its sign in (from, to).
  std::vector<Long> turns(const Long& from, const Long& to) const {
    std::vector<Long> made;
    if (abs(a) >= abs(b)) return made;
    const Long angle = acos(-a / b), whole = 2 * boost::math::constants::pi<Long>();
    for (const Long& side : {angle, Long(-angle)}) {
      const Long first = (side - phase) / w;
      for (Long k = ceil((from - first) * w / whole); first + k * whole / w < to; k += 1)
        if (first + k * whole / w > from) made.push_back(first + k * whole / w);
    }
    std::sort(made.begin(), made.end());
    return made;
  }
};

template <class F> Long bisect(const F& f, Long low, Long high) {
  const bool rises = f(low) < 0;
  for (int halving = 0; halving < 205; ++halving) {
    const Long middle = (low + high) / 2;
    ((f(middle) < 0) == rises ? low : high) = middle;
  }
  return (low + high) / 2;
}

struct OnLine {
  Line line;
  Long t = 0, z, v;
  bool rests = false;
  std::string refused = {};

  // The first instant in (t, to] at which the flight from t meets the stop; -1: none. The height is monotone between
  // zeros of the speed, and the speed between zeros of the acceleration.
  Long next_impact(const Long& to) const {
    std::vector<Long> speeds{t};
    const auto add_zero = [&](std::vector<Long>& into, const Long& from, const Long& until, const auto& f) {
      const Long at_from = f(from), at_until = f(until);
      if ((at_from < 0) != (at_until < 0)) into.push_back(bisect(f, from, until));
    };
    std::vector<Long> borders = line.turns(t, to);
    borders.insert(borders.begin(), t);
    borders.push_back(to);
    const auto speed = [&](const Long& at) { return line.speed(at, t, v); };
    for (std::size_t k = 0; k + 1 < borders.size(); ++k) add_zero(speeds, borders[k], borders[k + 1], speed);
    speeds.push_back(to);
    const auto height = [&](const Long& at) { return line.height(at, t, z, v); };
    for (std::size_t k = 1; k < speeds.size(); ++k)
      if (height(speeds[k]) < 0) {
        const Long low = speeds[k - 1];  // above the stop, or the start on it
        return bisect([&](const Long& at) { return height(at); },
                      k == 1 && z == 0 ? low + (speeds[k] - low) * Long("1e-12") : low, speeds[k]);
      }
    return -1;
  }
  // To `target`, through rests, lifts and impacts.
  void advance(const Long& target, int& impacts) {
    while (t < target) {
      if (rests) {
        const std::vector<Long> turns = line.turns(t, target);
        const auto lifts =
            std::find_if(turns.begin(), turns.end(), [&](const Long& at) { return line.pull(at + Long("1e-20")) > 0; });
        if (lifts == turns.end()) return void(t = target);
        t = *lifts, v = 0, z = 0, rests = false;
        continue;
      }
      const Long at = next_impact(target);
      if (at < 0) {
        const Long height = line.height(target, t, z, v), speed = line.speed(target, t, v);
        t = target, z = height, v = speed;
        return;
      }
      if (++impacts > 30) return void((refused = "more than 30 impacts", t = target));
      v = -line.e * line.speed(at, t, v);
      t = at, z = 0;
      if (line.e == 0) {
        rests = line.pull(t) < 0;
        if (abs(line.pull(t)) < Long("1e-12") * abs(line.a)) refused = "neither stays nor leaves";
      }
    }
  }
};

// What the kinds below move: the last body along the world's z, the constant of its height where z = 0.
struct Placed {
  Line line;
  int body;
  Long zero;
  int up;  // 1: the stop is below; -1: above
};
Placed placed(const Scenario& s) {
  const Scene& scene = s.scene;
  Placed made{};
  made.body = static_cast<int>(scene.bodies.size()) - 1;
  const Body& body = scene.bodies[made.body];
  const Long mass = body.mass_kg;
  made.up = 1;
  made.line.a = scene.gravity_m_per_s2[2];
  made.line.b = 0;
  made.line.w = 1;
  made.line.phase = 0;
  made.line.e = scene.pairs[0].restitution;
  for (const Force& force : scene.forces)
    if (const auto* drive = std::get_if<Drive>(&force)) {
      made.line.b = Long(drive->force_N[2]) / mass;
      made.line.w = drive->angular_frequency_rad_per_s;
      made.line.phase = drive->phase_rad;
    }
  if (scene.joints.empty()) {
    made.zero = std::get<Sphere>(body.shape).radius_m;
    return made;
  }
  const JointLimits& limits = *scene.joints[0].limits;
  made.line.e = limits.restitution;
  made.up = limits.upper < 50 ? -1 : 1;
  made.zero = made.up > 0 ? limits.lower : limits.upper;
  if (made.up < 0) {
    made.line.a = -made.line.a;
    made.line.b = -made.line.b;
  }
  return made;
}

Checked check_line(const Scenario& s, std::int64_t samples) {
  const Placed at = placed(s);
  const Body& body = s.scene.bodies[at.body];
  const Long start = at.up * (Long(body.position_m[2]) - at.zero), speed = at.up * Long(body.velocity_m_per_s[2]);
  OnLine motion{at.line, 0, start, speed, start == 0 && speed == 0};
  Checked made;
  int impacts = 0;
  for (std::int64_t k = 0; k <= samples; ++k) {
    motion.advance(Long(s.t_end_s) * k / samples, impacts);
    auto& row = made.values.emplace_back();
    for (const Body& each : s.scene.bodies) row.push_back(start_of(each));
    row[at.body].p[2] = at.zero + at.up * motion.z;
    row[at.body].v[2] = at.up * motion.v;
    if (motion.rests) row[at.body].p[2] = at.zero, row[at.body].v[2] = 0;
    made.own.emplace_back(row.size());
    for (LongBody& own : made.own.back()) {
      own.p = {0, 0, Long("1e-45")};
      own.v = {0, 0, Long("1e-45")};
      own.q = {};
    }
  }
  made.refused = motion.refused;
  return made;
}

// ---- the scenes -----------------------------------------------------------------------------------------------------

Scenario line_scene(Random& r, double t_end_s) {
  Scenario s = empty(TruthKind::extended, "", t_end_s);
  s.truth.solution.clear();
  s.scene.gravity_m_per_s2 = {0, 0, -r.uniform(5, 15)};
  return s;
}
void add_slider(Scenario& s, double start_m, double rate, JointLimits limits) {
  s.scene.bodies.push_back(point("bead", 1, {0, 0, start_m}, {0, 0, rate}));
  s.scene.bodies.back().inertia_kg_m2 = {0.1, 0, 0, 0, 0.1, 0, 0, 0, 0.1};
  Joint rail = joint("rail", JointKind::slider, -1, 0, {0, 0, 0}, {0, 0, 0});
  rail.coordinates[0] = start_m;
  rail.rates[0] = rate;
  rail.limits = limits;
  s.scene.joints.push_back(rail);
}
double graze(Random& r) { return r.sign() * r.power(-9, -2); }

// A bead thrown up to a stop above it.
Scenario grazed_stop(Random& r, bool border) {
  Scenario s = line_scene(r, 2);
  const double g = -s.scene.gravity_m_per_s2[2], rate = r.uniform(4, 12), top = rate * rate / (2 * g);
  const double stop = top * (1 + (border ? graze(r) : r.uniform(-0.9, 0.5)));
  add_slider(s, 0, rate, {-100, stop, r.uniform(0.1, 0.9)});
  return s;
}

// At rest, under a force that lifts for a moment, or hardly, or not; slow and fast.
double drive_of(Random& r, bool border, double weight) {
  return weight * (1 + (border ? graze(r) : r.uniform(-0.3, 2)));
}
Scenario lifted_bead(Random& r, bool border) {
  Scenario s = line_scene(r, r.uniform(1, 3));
  const double force = drive_of(r, border, -s.scene.gravity_m_per_s2[2]);
  const double frequency = r.power(0, 1), phase = r.uniform(0.3, 5.9);
  add_slider(s, 0, 0, {0, 100, 0});
  s.scene.forces.push_back(Drive{{0}, {0, 0, force}, frequency, phase});
  if (force * std::cos(phase) > -0.9 * s.scene.gravity_m_per_s2[2])  // it starts at rest
    std::get<Drive>(s.scene.forces[0]).phase_rad = kPi;
  return s;
}
Scenario lifted_ball(TruthKind truth, Random& r, bool border) {
  Scenario s = line_scene(r, r.uniform(1, 3));
  s.truth.kind = truth;
  const double mass = r.power(-1, 1), force = mass * drive_of(r, border, -s.scene.gravity_m_per_s2[2]);
  Body body = ball("ball", mass, 0.1, {0, 0, 0.1}, {});
  s.scene.bodies = {plane({0, 0, 1}, 0), body};
  s.scene.forces.push_back(Drive{{1}, {0, 0, force}, r.power(0, 1), kPi});
  return s;
}

// A ball thrown past fixed ones, one of which it just misses or touches.
Scenario pegs(TruthKind truth, Random& r, bool border) {
  Scenario s = empty(truth, "", r.uniform(1, 2));
  s.truth.solution.clear();
  s.scene.pairs[0].restitution = r.uniform(0.5, 1);
  const double g = r.uniform(3, 12), radius = r.power(-2, -0.7);
  s.scene.gravity_m_per_s2 = {0, 0, -g};
  const Real3 p{-r.uniform(0.5, 2), r.uniform(-0.1, 0.1), -r.uniform(1, 4)}, v{r.uniform(0.3, 2), 0, r.uniform(6, 11)};
  const int count = r.whole(1, 3);
  for (int k = 0; k < count; ++k) {
    // Beside the place at which the ball is at t, in a direction across its velocity.
    const double t = s.t_end_s * r.uniform(0.2, 0.95), size = r.power(-1.5, -0.5);
    const Real3 at{p[0] + v[0] * t, p[1] + v[1] * t, p[2] + v[2] * t - g * t * t / 2};
    const Real3 n = across(Real3{v[0], v[1], v[2] - g * t}, r);
    const double away = (size + radius) * (1 + (border ? graze(r) : r.uniform(-0.8, 0.8)));
    s.scene.bodies.push_back(peg("peg" + std::to_string(k), size, sum(at, scaled(away, n))));
  }
  s.scene.bodies.push_back(ball("ball", 1, radius, p, v));
  return s;
}

}  // namespace

std::vector<Kind> event_kinds() {
  const std::vector<std::int64_t> counts{1, 7, 64};
  const auto flights = [](const Scenario& s, std::int64_t samples) { return check_flights(s, samples); };
  const auto of = [](TruthKind truth, auto scene) {
    return [=](Random& r, bool border) { return scene(truth, r, border); };
  };
  return {{"extended", "events-grazed-stops", grazed_stop, check_line, 0.05, counts},
          {"extended", "events-lifted-beads", lifted_bead, check_line, 0.05, counts},
          {"extended", "events-lifted-balls", of(TruthKind::extended, lifted_ball), check_line, 0.05, counts},
          {"extended", "events-pegs", of(TruthKind::extended, pegs), flights, 0.05, counts}};
}

}  // namespace atwood::fuzz
