#include "validation/metrics/probes.hpp"

#include <algorithm>
#include <cmath>

#include "dynamics/contacts.hpp"
#include "validation/metrics/probe_parts.hpp"

namespace atwood {

std::vector<Row> run_probe(Probe probe, const ProbeRequest& request) {
  using namespace metrics;
  struct Entry {
    Probe probe;
    const char* metric;
    std::vector<Row> (*run)(const ProbeRequest&);
  };
  static constexpr Entry entries[] = {{Probe::ensemble, "growth-exponent-round-off-energy", probe_ensemble},
                                      {Probe::reversal, "reversal-over-round-off", probe_reversal},
                                      {Probe::symplecticity, "symplecticity-defect", probe_symplecticity},
                                      {Probe::lyapunov, "lyapunov-exponent", probe_lyapunov},
                                      {Probe::determinism, "state-differences", probe_determinism}};
  for (const Entry& entry : entries) {
    if (probe != entry.probe) continue;
    try {
      return entry.run(request);
    } catch (const ProbeEnds& ended) {
      Row r = row(entry.metric, 0, 0, ended.what());
      r.status = ended.status;
      return {r};
    }
  }
  throw std::logic_error("the probe `" + to_string(probe) + "` is not made of runs");
}

namespace metrics {

Recording good_run(const ProbeRequest& request, const std::string& method, const Scene& scene, const Plan& plan) {
  Recording run = request.run(method, scene, plan);
  if (run.outcome.status != Status::ok) throw ProbeEnds(run.outcome.status, run.outcome.reason);
  if (run.values.size() != static_cast<std::size_t>(plan.samples) + 1)
    throw ProbeEnds(Status::crashed,
                    std::to_string(run.values.size()) + " samples, expected " + std::to_string(plan.samples + 1));
  for (const SampleView s : run.values) {
    const auto require_finite = [&](const Wide& sum) {
      if (!std::isfinite(static_cast<double>(sum)))
        throw ProbeEnds(Status::not_finite,
                        "a run of the probe is not finite at t = " + format_double(static_cast<double>(s.t_s)) + " s");
    };
    for (const BodySample& b : s.bodies)
      for (int i = 0; i < 3; ++i) require_finite(b.p_m[i] + b.v_m_per_s[i] + b.w_rad_per_s[i] + b.q_wxyz[i + 1]);
    for (const ParticleSample& p : s.particles)
      for (int i = 0; i < 3; ++i) require_finite(p.p_m[i] + p.v_m_per_s[i]);
  }
  return run;
}

Scene started_from(const Scene& scene, const SampleView& sample) {
  Scene started = scene;
  for (std::size_t b = 0; b < started.bodies.size() && b < sample.bodies.size(); ++b) {
    Body& body = started.bodies[b];
    if (body.fixed) continue;
    const BodySample& s = sample.bodies[b];
    for (int i = 0; i < 3; ++i) body.position_m[i] = static_cast<double>(s.p_m[i]);
    if (!scene.problem.empty()) continue;
    for (int i = 0; i < 3; ++i) {
      body.velocity_m_per_s[i] = static_cast<double>(s.v_m_per_s[i]);
      body.angular_velocity_body_rad_per_s[i] = static_cast<double>(s.w_rad_per_s[i]);
    }
    double norm = 0;
    for (int i = 0; i < 4; ++i) norm += static_cast<double>(s.q_wxyz[i] * s.q_wxyz[i]);
    // An integrator may let a quaternion's norm drift without changing the attitude; scenes need unit quaternions.
    const double scale = std::fabs(norm - 1) > 1e-12 ? std::sqrt(norm) : 1;
    for (int i = 0; i < 4; ++i) body.orientation_wxyz[i] = static_cast<double>(s.q_wxyz[i]) / scale;
  }
  return started;
}

void require_bodies(const ProbeRequest& request) {
  if (!request.scenario.scene.problem.empty())
    throw ProbeEnds(Status::unsupported, "the bare system `" + request.scenario.scene.problem + "` has no velocities");
}

void require_no_contacts(const ProbeRequest& request) {
  if (dynamics::contacts_possible(request.scenario.scene))
    throw ProbeEnds(Status::unsupported, "bodies of the scene can touch; probes need smooth motion");
  if (!request.plan.frame_ends_s.empty())
    throw ProbeEnds(Status::unsupported, "recorded frames are not probed, equal steps are");
}

void require_no_clock(const ProbeRequest& request) {
  for (const Body& body : request.scenario.scene.bodies)
    if (body.release_s > 0) throw ProbeEnds(Status::unsupported, "body `" + body.name + "` is released at a time");
  for (const Force& force : request.scenario.scene.forces) {
    const auto* pushed = std::get_if<PointForce>(&force);
    if (std::holds_alternative<Drive>(force) || std::holds_alternative<Thruster>(force) ||
        (pushed && !pushed->on_s.empty()))
      throw ProbeEnds(Status::unsupported, "a force of the scene depends on time");
  }
}

void require_no_dissipation(const ProbeRequest& request) {
  for (const Force& force : request.scenario.scene.forces) {
    const auto* spring = std::get_if<Spring>(&force);
    if (std::holds_alternative<LinearDrag>(force) || std::holds_alternative<QuadraticDrag>(force) ||
        (spring && spring->damping_N_s_per_m != 0))
      throw ProbeEnds(Status::unsupported, "a force of the scene dissipates");
  }
}

Sizes sizes_of(const Scene& scene, const SampleSeries& samples) {
  Sizes sizes;
  for (const SampleView s : samples)
    for (std::size_t b = 0; b < s.bodies.size(); ++b) {
      if (b < scene.bodies.size() && scene.bodies[b].fixed) continue;
      sizes.position_m = std::max(sizes.position_m, norm(s.bodies[b].p_m));
      sizes.velocity_m_per_s = std::max(sizes.velocity_m_per_s, norm(s.bodies[b].v_m_per_s));
      sizes.rate_rad_per_s = std::max(sizes.rate_rad_per_s, norm(s.bodies[b].w_rad_per_s));
    }
  return sizes;
}

}  // namespace metrics
}  // namespace atwood
