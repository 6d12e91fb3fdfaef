// Contact forces compared with the laws of Signorini and Coulomb and with the principle of greatest dissipation.
#include <algorithm>
#include <cmath>

#include "validation/metrics/joints.hpp"
#include "validation/metrics/measurements.hpp"

namespace atwood::metrics {
namespace {

using Triple = std::array<double, 3>;

Triple narrow(const std::array<Wide, 3>& a) {
  return {static_cast<double>(a[0]), static_cast<double>(a[1]), static_cast<double>(a[2])};
}
double dot(const Triple& a, const Triple& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
double length(const Triple& a) { return std::sqrt(dot(a, a)); }
Triple cross(const Triple& a, const Triple& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

// v + w x r of a body's point, world axes; q w q* written out.
Triple point_velocity(const Body& body, const BodySample& sample, const Triple& x_m) {
  if (body.fixed) return {};
  const Triple p = narrow(sample.p_m), v = narrow(sample.v_m_per_s), w_B = narrow(sample.w_rad_per_s);
  const double qw = static_cast<double>(sample.q_wxyz[0]);
  const Triple u{static_cast<double>(sample.q_wxyz[1]), static_cast<double>(sample.q_wxyz[2]),
                 static_cast<double>(sample.q_wxyz[3])};
  const Triple c = cross(u, w_B), cc = cross(u, c);
  Triple w{}, r{};
  for (int i = 0; i < 3; ++i) {
    w[i] = w_B[i] + 2 * (qw * c[i] + cc[i]);
    r[i] = x_m[i] - p[i];
  }
  const Triple turn = cross(w, r);
  return {v[0] + turn[0], v[1] + turn[1], v[2] + turn[2]};
}

// Slip of b on a at the contact: the relative velocity without its part along the normal.
Triple slip(const Scene& scene, const SampleView& sample, const ContactSample& contact) {
  const Triple a = point_velocity(scene.bodies[contact.body_a], sample.bodies[contact.body_a], contact.x_m);
  const Triple b = point_velocity(scene.bodies[contact.body_b], sample.bodies[contact.body_b], contact.x_m);
  Triple u{b[0] - a[0], b[1] - a[1], b[2] - a[2]};
  const double along = dot(u, contact.normal);
  for (int i = 0; i < 3; ++i) u[i] -= along * contact.normal[i];
  return u;
}

// A contact with less than this fraction of the run's largest force counts as unloaded: it has just separated.
constexpr double kLoaded = 1e-9;

// Speeds below this fraction of the speed that gravity gives over the run are round-off of bodies at rest, not slip.
constexpr double kAtRest = 1e-12;

struct Excess {  // excess over a friction cone, and the force that it is relative to
  double beyond = 0, normal = 0;
  bool has_friction = true;  // false: the engine does not report friction, whose part is NaN
  void take(double f_n, double f_t, double mu) {
    has_friction = has_friction && !std::isnan(f_t);
    beyond = std::max(beyond, f_t - mu * f_n);
    normal = std::max(normal, f_n);
  }
  double relative() const { return normal > 0 ? beyond / normal : 0; }
};

}  // namespace

void append_contact_forces(const Scenario& scenario, const Recording& run, std::vector<Row>& rows) {
  const Scene& scene = scenario.scene;
  Excess impulses, forces;
  for (const Event& e : run.events) {
    if (e.kind != EventKind::impact || stop_of(scene, e) != nullptr) continue;
    const double mu = pair_law(scene, e.body_a, e.body_b).friction;
    impulses.take(static_cast<double>(e.impulse_n_N_s), static_cast<double>(e.impulse_t_N_s), mu);
  }
  double pull = 0;
  for (const SampleView sample : run.values)
    for (const ContactSample& c : sample.contacts) {
      forces.take(c.force_n_N, length(c.force_t_N), pair_law(scene, c.body_a, c.body_b).friction);
      pull = std::max(pull, -c.force_n_N);
    }
  const bool has_friction = impulses.has_friction && forces.has_friction;
  if (has_friction && (impulses.normal > 0 || forces.normal > 0))
    rows.push_back(row("cone-violation", std::max(impulses.relative(), forces.relative())));
  if (!(forces.normal > 0)) return;

  double gap = 0, least = 0, most_friction = 0, fastest = 0;
  for (const SampleView sample : run.values)
    for (const ContactSample& c : sample.contacts) {
      if (std::fabs(c.force_n_N) <= kLoaded * forces.normal) continue;
      gap = std::max(gap, std::fabs(c.gap_m));
      const double friction = pair_law(scene, c.body_a, c.body_b).friction * c.force_n_N;
      const Triple u = slip(scene, sample, c);
      least = std::max(least, friction * length(u) + dot(c.force_t_N, u));
      most_friction = std::max(most_friction, friction);
      fastest = std::max(fastest, length(u));
      for (const int body : {c.body_a, c.body_b})
        fastest = std::max(fastest, length(narrow(sample.bodies[body].v_m_per_s)));
    }
  rows.push_back(row("signorini-gap", gap));
  rows.push_back(row("signorini-pull", pull));
  if (has_friction && most_friction > 0 && fastest > kAtRest * length(scene.gravity_m_per_s2) * scenario.t_end_s)
    rows.push_back(row("dissipation-defect", least / (most_friction * fastest)));
}

}  // namespace atwood::metrics
