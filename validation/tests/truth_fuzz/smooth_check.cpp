#include "smooth_check.hpp"

#include <algorithm>
#include <cmath>

#include "extrapolation.hpp"

namespace atwood::fuzz {
namespace {

// A state: p, v, q, w of each body, fixed ones included.

// ---- the equations of motion ------------------------------------------------------------------------------------

struct Equations {
  const Scene& scene;
  std::vector<std::array<Long, 9>> inverse_inertia;
  std::vector<Force> acting;  // in the present interval of time
  double now_s = 0;           // its middle

  explicit Equations(const Scene& s) : scene(s) {
    for (const Body& body : scene.bodies)
      inverse_inertia.push_back(rotates(body) ? inverse(body.inertia_kg_m2) : std::array<Long, 9>{});
  }
  bool held(int i) const { return scene.bodies[i].fixed || now_s < scene.bodies[i].release_s; }
};

constexpr int kPerBody = 13;
LongBody body_at(const State& y, int i) {
  const Long* at = &y[static_cast<std::size_t>(kPerBody * i)];
  return {{at[0], at[1], at[2]}, {at[6], at[7], at[8], at[9]}, {at[3], at[4], at[5]}, {at[10], at[11], at[12]}};
}

struct Loads {
  const Equations& of;
  const Long& t_s;
  std::vector<LongBody> bodies;
  std::vector<Long3> force, torque_body;  // world axes, body axes

  Long mass(int i) const { return of.scene.bodies[i].mass_kg; }
  void push(int i, const Long3& point_body, const Long3& f) {
    force[i] = force[i] + f;
    torque_body[i] = torque_body[i] + cross(point_body, turned_back(bodies[i].q, f));
  }
  void operator()(const MutualGravity& g) {
    for (const int i : g.bodies)
      for (const int j : g.bodies) {
        if (i == j) continue;
        const Long3 d = bodies[j].p - bodies[i].p;
        const Long r2 = dot(d, d) + Long(g.softening_m) * g.softening_m;
        const Long massive = of.scene.bodies[j].mass_kg;
        force[i] = force[i] + Long(g.constant_m3_per_kg_s2) * mass(i) * massive / (r2 * sqrt(r2)) * d;
      }
  }
  void operator()(const Attractor& a) {
    for (const int i : a.bodies) {
      const Long3 d = widened(a.center_m) - bodies[i].p;
      const Long r2 = dot(d, d);
      force[i] = force[i] + mass(i) * Long(a.mu_m3_per_s2) / (r2 * sqrt(r2)) * d;
    }
  }
  void operator()(const LinearDrag& d) {
    for (const int i : d.bodies) {
      force[i] = force[i] - Long(d.coefficient_kg_per_s) * (bodies[i].v - widened(d.wind_m_per_s));
      torque_body[i] = torque_body[i] - Long(d.angular_coefficient_N_m_s) * bodies[i].w;
    }
  }
  void operator()(const QuadraticDrag& d) {
    const Long k = Long(d.density_kg_per_m3) * d.drag_coefficient * d.area_m2 / 2;
    for (const int i : d.bodies) {
      const Long3 u = bodies[i].v - widened(d.wind_m_per_s);
      force[i] = force[i] - k * sqrt(dot(u, u)) * u;
      torque_body[i] = torque_body[i] - Long(d.angular_coefficient_N_m_s) * bodies[i].w;
    }
  }
  void operator()(const Spring& s) {
    Long3 at[2]{}, speed[2]{}, arm[2]{};
    for (std::size_t k = 0; k < 2; ++k) {
      if (k >= s.bodies.size()) {
        at[k] = widened(s.anchor_m);
        continue;
      }
      const LongBody& b = bodies[s.bodies[k]];
      if (k < s.points_body_m.size()) arm[k] = widened(s.points_body_m[k]);
      at[k] = b.p + turned(b.q, arm[k]);
      speed[k] = b.v + turned(b.q, cross(b.w, arm[k]));
    }
    const Long3 d = at[1] - at[0];
    const Long length = sqrt(dot(d, d));
    Long3 pull = Long(s.stiffness_N_per_m) * d;  // of the first body towards the second point
    if (length > 0) {
      const Long stretch_rate = dot(d, speed[1] - speed[0]) / length;
      pull = pull + (s.damping_N_s_per_m * stretch_rate - Long(s.stiffness_N_per_m) * s.rest_length_m) / length * d;
    } else {
      pull = pull + Long(s.damping_N_s_per_m) * (speed[1] - speed[0]);
    }
    push(s.bodies[0], arm[0], pull);
    if (s.bodies.size() > 1) push(s.bodies[1], arm[1], Long(-1) * pull);
  }
  void operator()(const Drive& d) {
    const Long size = cos(d.angular_frequency_rad_per_s * t_s + d.phase_rad);
    for (const int i : d.bodies) force[i] = force[i] + size * widened(d.force_N);
  }
  void operator()(const Lorentz& l) {
    for (const int i : l.bodies)
      force[i] = force[i] + Long(of.scene.bodies[i].charge_C) *
                                (widened(l.electric_V_per_m) + cross(bodies[i].v, widened(l.magnetic_T)));
  }
  void operator()(const Coulomb& c) {
    for (const int i : c.bodies)
      for (const int j : c.bodies) {
        if (i == j) continue;
        const Long3 d = bodies[i].p - bodies[j].p;
        const Long r2 = dot(d, d), charges = Long(of.scene.bodies[i].charge_C) * of.scene.bodies[j].charge_C;
        force[i] = force[i] + Long(c.constant_N_m2_per_C2) * charges / (r2 * sqrt(r2)) * d;
      }
  }
  void operator()(const Thruster& t) {
    push(t.body, widened(t.point_body_m), Long(t.thrust_N) * turned(bodies[t.body].q, widened(t.direction_body)));
  }
  void operator()(const PointForce& f) { push(f.body, widened(f.point_body_m), widened(f.force_N)); }
  void operator()(const RotatingFrame&) {}
  void operator()(const Potential&) {}
};

void rate(const Equations& of, const Long& t_s, const State& y, State& dydt) {
  const int n = static_cast<int>(of.scene.bodies.size());
  Loads loads{of, t_s, {}, std::vector<Long3>(n), std::vector<Long3>(n)};
  for (int i = 0; i < n; ++i) {
    loads.bodies.push_back(body_at(y, i));
    if (of.held(i) && !of.scene.bodies[i].fixed)
      loads.bodies.back().v = loads.bodies.back().w = {};  // until its release
  }
  for (const Force& force : of.acting) std::visit(loads, force);
  std::fill(dydt.begin(), dydt.end(), Long(0));
  for (int i = 0; i < n; ++i) {
    if (of.held(i)) continue;
    const Body& body = of.scene.bodies[i];
    const LongBody& b = loads.bodies[i];
    Long* d = &dydt[static_cast<std::size_t>(kPerBody * i)];
    for (int k = 0; k < 3; ++k) {
      d[k] = b.v[k];
      d[3 + k] = loads.force[i][k] / body.mass_kg + of.scene.gravity_m_per_s2[k];
    }
    if (!rotates(body)) continue;
    const Long3 u{b.q[1], b.q[2], b.q[3]}, turning = Long(0.5) * (b.q[0] * b.w + cross(u, b.w));
    d[6] = -dot(u, b.w) / 2;
    const Long3 dw = times(of.inverse_inertia[i], loads.torque_body[i] - cross(b.w, times(body.inertia_kg_m2, b.w)));
    for (int k = 0; k < 3; ++k) {
      d[7 + k] = turning[k];
      d[10 + k] = dw[k];
    }
  }
}

State state_of_starts(const Scene& scene) {
  State y;
  for (const Body& body : scene.bodies) {
    const LongBody start = start_of(body);
    y.insert(y.end(), start.p.begin(), start.p.end());
    y.insert(y.end(), start.v.begin(), start.v.end());
    y.insert(y.end(), start.q.begin(), start.q.end());
    y.insert(y.end(), start.w.begin(), start.w.end());
  }
  return y;
}

// The kinds of a state's components: p, v, q, w of each body have scales of their own.
std::vector<int> kinds_of(std::size_t components) {
  std::vector<int> kind;
  for (int first = 0; kind.size() < components; first += 4)
    for (const int of : {0, 0, 0, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3}) kind.push_back(first + of);
  return kind;
}

// The times at which forces switch and bodies are released.
std::vector<double> switches(const Scene& scene, double t_end_s) {
  std::vector<double> at{t_end_s};
  const auto add = [&](double t) {
    if (t > 0 && t < t_end_s) at.push_back(t);
  };
  for (const Body& body : scene.bodies) add(body.release_s);
  for (const Force& force : scene.forces) {
    const auto* thruster = std::get_if<Thruster>(&force);
    const auto* push = std::get_if<PointForce>(&force);
    for (const Interval& on : thruster ? thruster->on_s : push ? push->on_s : std::vector<Interval>{}) {
      add(on.from_s);
      add(on.to_s);
    }
  }
  std::sort(at.begin(), at.end());
  at.erase(std::unique(at.begin(), at.end()), at.end());
  return at;
}

bool acts_at(const Force& force, double t_s) {
  const auto* thruster = std::get_if<Thruster>(&force);
  const auto* push = std::get_if<PointForce>(&force);
  if (!thruster && !push) return true;
  const auto& on_s = thruster ? thruster->on_s : push->on_s;
  return on_s.empty() ||
         std::any_of(on_s.begin(), on_s.end(), [&](const Interval& on) { return on.from_s <= t_s && t_s < on.to_s; });
}

// One integration with a relative error of 10^-digits per step. Empty: it needs more than kMaxSteps.
std::vector<State> integrate(const Scenario& scenario, std::int64_t samples, int digits) {
  Equations equations(scenario.scene);
  const Rate f = [&](const Long& t_s, const State& y, State& dydt) { rate(equations, t_s, y, dydt); };
  const State start = state_of_starts(scenario.scene);
  Integration integration(f, start, kinds_of(start.size()), 0, Long(scenario.t_end_s) / samples, digits);
  std::vector<State> at{start};
  double interval_from = 0;
  std::int64_t sample = 1;
  for (const double border : switches(scenario.scene, scenario.t_end_s)) {
    equations.now_s = interval_from + (border - interval_from) / 2;
    equations.acting.clear();
    for (const Force& force : scenario.scene.forces)
      if (acts_at(force, equations.now_s)) equations.acting.push_back(force);
    while (sample <= samples) {
      const Long next_sample = Long(scenario.t_end_s) * sample / samples;
      if (!integration.advance(std::min(next_sample, Long(border)))) return {};
      if (next_sample > border) break;
      at.push_back(integration.state());
      ++sample;
    }
    interval_from = border;
  }
  return at;
}

}  // namespace

Checked check_smooth(const Scenario& scenario, std::int64_t samples, int digits) {
  for (const Force& force : scenario.scene.forces)
    if (std::holds_alternative<RotatingFrame>(force) || std::holds_alternative<Potential>(force))
      return {"the checker has no rotating frames and no potentials", {}, {}};
  const std::vector<State> fine = integrate(scenario, samples, digits),
                           coarse = integrate(scenario, samples, digits - 4);
  if (fine.empty() || coarse.empty())
    return {"the checker needs more than " + std::to_string(kMaxSteps) + " steps", {}, {}};
  const auto at_samples = [&](const std::vector<State>& states) {
    Checked made;
    for (const State& y : states) {
      auto& values = made.values.emplace_back();
      for (int i = 0; i < static_cast<int>(scenario.scene.bodies.size()); ++i) values.push_back(body_at(y, i));
    }
    return made;
  };
  Checked made = at_samples(fine);
  set_own(made, at_samples(coarse), Long("1e-55"));
  return made;
}

}  // namespace atwood::fuzz
