#include "compliant_check.hpp"

#include <algorithm>

#include "extrapolation.hpp"

namespace atwood::fuzz {
namespace {

struct Overlap {
  Long d, rate;
};

// ---- linear -------------------------------------------------------------------------------------------------------

struct LinearLaw {
  Long k, c;  // over the reduced mass
  bool pull = false;

  // d'' = -k d - c d' after h, by Taylor's series: a_(n+2) = -(k a_n + c (n + 1) a_(n+1)) / ((n + 1)(n + 2)).
  Overlap after(const Overlap& from, const Long& h) const {
    Long a = from.d, b = from.rate, power = 1;
    Overlap made{0, 0};
    for (int n = 0; n < 70; ++n) {
      made.d += a * power;
      made.rate += (n + 1) * b * power;
      power *= h;
      const Long next = -(k * a + c * (n + 1) * b) / ((n + 1) * (n + 2));
      a = b;
      b = next;
    }
    return made;
  }
  // Positive as long as the bodies press on each other.
  Long pressing(const Overlap& at) const { return pull ? at.d : k * at.d + c * at.rate; }
};

// The overlap at `times` (ascending, from the touch), and the duration of the force (or a later time than the last of
// them); afterwards free motion.
std::vector<Overlap> linear(const LinearLaw& law, const Long& v, const std::vector<Long>& times, const Long& step_share,
                            Long& duration) {
  const Long step = step_share / (sqrt(law.k) + law.c);
  std::vector<Overlap> made;
  Overlap now{0, v}, next{0, 0};
  Long t = 0;
  std::size_t at = 0;
  for (;; t += step, now = next) {
    next = law.after(now, step);
    const bool ends = law.pressing(next) < 0;
    Long part = step;
    if (ends) {
      Long low = 0, high = step;
      for (int halving = 0; halving < 230; ++halving) {
        const Long middle = (low + high) / 2;
        (law.pressing(law.after(now, middle)) < 0 ? high : low) = middle;
      }
      part = low;
    }
    for (; at < times.size() && times[at] <= t + part; ++at) made.push_back(law.after(now, times[at] - t));
    if (!ends && at == times.size()) return duration = t + 2 * step, made;  // later than the end
    if (!ends) continue;
    duration = t + part;
    const Overlap last = law.after(now, part);
    for (; at < times.size(); ++at) made.push_back({last.d + last.rate * (times[at] - duration), last.rate});
    return made;
  }
}

// ---- Hertz --------------------------------------------------------------------------------------------------------
// d'' = -K d^(3/2). With z = K v^(1/2) t^(5/2), d = v t f(z), f = sum c_j z^j:
//   c_(j+1) (1 + 5 (j + 1) / 2) (5 (j + 1) / 2) = -g_j,  g = f^(3/2)

constexpr int kTerms = 120;

std::vector<Long> series() {
  std::vector<Long> c{1}, g;
  for (int j = 0; j < kTerms; ++j) {
    Long sum = j == 0 ? 1 : 0;
    for (int i = 1; i <= j; ++i)
      sum += (Long(3) * i / 2 - (j - i)) * c[static_cast<std::size_t>(i)] * g[static_cast<std::size_t>(j - i)] / j;
    g.push_back(sum);
    const Long p = Long(5) * (j + 1) / 2;
    c.push_back(-sum / (p * (1 + p)));
  }
  return c;
}

Overlap early(const Long& K, const Long& v, const Long& t) {
  static const std::vector<Long> c = series();
  if (t == 0) return {0, v};
  const Long z = K * sqrt(v) * t * t * sqrt(t);
  Overlap made{0, 0};
  Long power = 1;
  for (int j = 0; j <= kTerms; ++j, power *= z) {
    made.d += c[static_cast<std::size_t>(j)] * power;
    made.rate += (1 + Long(5) * j / 2) * c[static_cast<std::size_t>(j)] * power;
  }
  return {v * t * made.d, v * made.rate};
}

std::vector<Overlap> hertz(const Long& K, const Long& v, const std::vector<Long>& times, double z_first, int digits,
                           Long& duration) {
  const auto f = [&](const Long&, const State& y, State& dydt) {
    dydt[0] = y[1];
    dydt[1] = -K * y[0] * sqrt(y[0]);
  };
  const Long t_first = pow(Long(z_first / (K * sqrt(v))), Long(2) / 5);
  const Overlap first = early(K, v, t_first);
  // The rate vanishes at z = 3.2840...: from a little before it on by Newton's method.
  const Long near = pow(Long(3.283 / (K * sqrt(v))), Long(2) / 5);
  State before = solve(f, {first.d, first.rate}, {0, 1}, {t_first, near}, digits).back();
  Long left = 0;
  for (int iteration = 0; iteration < 8; ++iteration) {
    const State at = left == 0 ? before : extrapolate(f, near, before, left, {before[0], v}).y;
    left += at[1] / (K * at[0] * sqrt(at[0]));
  }
  const Long half = near + left;
  duration = 2 * half;
  std::vector<Long> folded{t_first};
  for (const Long& t : times) {
    const Long since = t > half ? Long(duration - t) : t;
    if (since > t_first) folded.push_back(since);
  }
  std::sort(folded.begin(), folded.end());
  const std::vector<State> path = solve(f, {first.d, first.rate}, {0, 1}, folded, digits);
  std::vector<Overlap> made;
  for (const Long& t : times) {
    if (t >= duration) {
      made.push_back({-v * (t - duration), -v});
      continue;
    }
    const bool back = t > half;
    const Long since = back ? Long(duration - t) : t;
    const auto k = static_cast<std::size_t>(std::lower_bound(folded.begin(), folded.end(), since) - folded.begin());
    const Overlap now = since > t_first ? Overlap{path[k][0], path[k][1]} : early(K, v, since);
    made.push_back({now.d, back ? Long(-now.rate) : now.rate});
  }
  return made;
}

// ---- the scene ----------------------------------------------------------------------------------------------------

LongBody flown(const Body& body, const Long& t) {
  LongBody made = start_of(body);
  made.p = made.p + t * made.v;
  const Long rate = sqrt(dot(made.w, made.w));
  if (rate > 0) made.q = product(made.q, quaternion_about(Long(1) / rate * made.w, rate * t));
  return made;
}

Checked run(const Scenario& scenario, std::int64_t samples, bool finer) {
  const Scene& scene = scenario.scene;
  const std::size_t a = std::holds_alternative<Sphere>(scene.bodies[0].shape) ? 0 : 1, b = 1 - a;
  const Body &one = scene.bodies[a], &other = scene.bodies[b];
  const auto* plane = std::get_if<Plane>(&other.shape);
  const Long radius = std::get<Sphere>(one.shape).radius_m;
  Long3 n = plane ? Long(-1) * widened(plane->normal) : widened(other.position_m) - widened(one.position_m);
  const Long length = sqrt(dot(n, n));
  n = 1 / length * n;
  const Long3 u = widened(one.velocity_m_per_s) - (plane ? Long3{} : widened(other.velocity_m_per_s));
  const Long v = dot(n, u), light = plane ? Long(0) : 1 / Long(other.mass_kg), m = 1 / (1 / Long(one.mass_kg) + light);
  const Long other_radius = plane ? Long(0) : Long(std::get<Sphere>(other.shape).radius_m);
  const Long gap = plane ? Long(-dot(n, widened(one.position_m)) - plane->offset_m / length - radius)
                         : Long(length - radius - other_radius);
  const Long touch = v > 0 ? Long(gap / v) : Long(2 * scenario.t_end_s);
  const std::vector<Long> times = sample_times(scenario.t_end_s, samples);
  std::vector<Long> since;
  for (const Long& t : times)
    if (t > touch) since.push_back(t - touch);
  Checked made;
  made.has_events = true;
  std::vector<Overlap> overlaps;
  if (touch <= scenario.t_end_s) {
    const PairLaw& law = pair_law(scene, 0, 1);
    Long duration = 0;
    if (law.contact_law == ContactLaw::hertz) {
      const Long curvature = 1 / radius + (plane ? Long(0) : 1 / other_radius);
      overlaps = hertz(4 * Long(law.modulus_Pa) / (3 * sqrt(curvature) * m), v, since, finer ? 0.25 : 0.35,
                       finer ? 46 : 42, duration);
    } else {
      overlaps = linear({law.stiffness_N_per_m / m, law.damping_N_s_per_m / m, law.pull}, v, since,
                        finer ? Long(0.4) : Long(0.5), duration);
    }
    made.event_s = {touch};
    if (touch + duration <= scenario.t_end_s) made.event_s.push_back(touch + duration);
  }
  const std::size_t first = times.size() - overlaps.size();
  for (std::size_t k = 0; k < times.size(); ++k) {
    auto& bodies = made.values.emplace_back();
    for (const Body& body : scene.bodies) bodies.push_back(flown(body, times[k]));
    if (k < first) continue;
    const Overlap& now = overlaps[k - first];
    // Without the contact the overlap would be v (t - touch).
    const Long off = now.d - v * (times[k] - touch), slower = now.rate - v;
    bodies[a].p = bodies[a].p + off * m / one.mass_kg * n;
    bodies[a].v = bodies[a].v + slower * m / one.mass_kg * n;
    bodies[b].p = bodies[b].p - off * m * light * n;
    bodies[b].v = bodies[b].v - slower * m * light * n;
  }
  return made;
}

}  // namespace

Checked check_penalty(const Scenario& scenario, std::int64_t samples) {
  Checked made = run(scenario, samples, true);
  set_own(made, run(scenario, samples, false), Long("1e-50"));
  return made;
}

}  // namespace atwood::fuzz
