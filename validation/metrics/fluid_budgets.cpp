// What a fluid conserves: energy, momentum, angular momentum, volume. Computed from states by the formulas below, never
// taken from an engine's report.
#include <quadmath.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "validation/metrics/fluid_parts.hpp"
#include "validation/metrics/measurements.hpp"

namespace atwood {

std::vector<int> fluid_of_particles(const Scene& scene) {
  std::vector<int> fluids;
  for (std::size_t f = 0; f < scene.fluids.size(); ++f)
    fluids.insert(fluids.end(), scene.fluids[f].particles.position_m.size(), static_cast<int>(f));
  return fluids;
}

namespace metrics {
namespace {

using WideVec = std::array<Wide, 3>;

std::vector<double> masses_of(const Scene& scene) {
  std::vector<double> masses;
  for (const Fluid& fluid : scene.fluids)
    masses.insert(masses.end(), fluid.particles.mass_kg.begin(), fluid.particles.mass_kg.end());
  return masses;
}

Wide dot(const WideVec& a, const WideVec& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
WideVec cross(const WideVec& a, const WideVec& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
void add(WideVec& to, Wide factor, const WideVec& v) {
  for (std::size_t i = 0; i < 3; ++i) to[i] += factor * v[i];
}

// Elastic energy of a unit of mass, the integral of p / rho^2 from rho0, with s = rho / rho0:
// linear c^2 (ln s + 1/s - 1); Tait c^2 / n (s^(n-1) / (n-1) + 1/s - n / (n-1)). Both are 0 at s = 1 with slope 0.
Wide elastic(const Fluid& fluid, Wide density) {
  const Wide c = fluid.sound_speed_m_per_s, s = density / Wide(fluid.density_kg_per_m3);
  const Wide n = fluid.equation_of_state == EquationOfState::linear ? Wide(1) : Wide(fluid.tait_exponent);
  if (n == 1) return c * c * (logq(s) + 1 / s - 1);
  return c * c / n * (powq(s, n - 1) / (n - 1) + 1 / s - n / (n - 1));
}

Wide kinetic_energy_of(const std::vector<double>& masses, const SampleView& sample) {
  Wide kinetic = 0;
  for (std::size_t i = 0; i < sample.particles.size(); ++i) {
    const WideVec& v = sample.particles[i].v_m_per_s;
    kinetic += Wide(masses[i]) * dot(v, v) / 2;
  }
  return kinetic;
}

FluidEnergies energies_of(const Scene& scene, const std::vector<int>& fluids, const std::vector<double>& masses,
                          const SampleView& sample) {
  FluidEnergies e;
  e.kinetic = kinetic_energy_of(masses, sample);
  const WideVec g{Wide(scene.gravity_m_per_s2[0]), Wide(scene.gravity_m_per_s2[1]), Wide(scene.gravity_m_per_s2[2])};
  for (std::size_t i = 0; i < sample.particles.size(); ++i) {
    const ParticleSample& p = sample.particles[i];
    const Fluid& fluid = scene.fluids[static_cast<std::size_t>(fluids[i])];
    const Wide m = masses[i];
    e.elastic += m * elastic(fluid, p.density_kg_per_m3);
    e.potential -= m * dot(g, p.p_m);
    e.heat += m * Wide(fluid.heat_capacity_J_per_kg_K) * (p.temperature_K - Wide(fluid.temperature_K));
  }
  return e;
}

// What stands against a budget of energy; empty: nothing does.
std::string open_budget(const Scene& scene) {
  for (const Fluid& fluid : scene.fluids) {
    if (fluid.viscosity_m2_per_s > 0 && !(fluid.viscous_heat && fluid.heat_capacity_J_per_kg_K > 0))
      return "viscosity without viscous_heat";
    if (!fluid.source.name.empty()) return "a body acceleration of its own";
    if (fluid.expansion_per_K != 0) return "gravity that depends on the temperature";
  }
  for (const FluidBoundary& boundary : scene.fluid_boundaries) {
    const Body& body = scene.bodies[static_cast<std::size_t>(boundary.body)];
    if (!body.fixed) return "a body that floats";
    if (body.velocity_m_per_s != Real3{} || body.angular_velocity_body_rad_per_s != Real3{}) return "a wall that moves";
    if (boundary.temperature_K || boundary.heat_flux_W_per_m2) return "a wall that heats";
  }
  for (std::size_t i = 0; i < 3; ++i)
    if (scene.domain.periodic_m[i] > 0 && scene.gravity_m_per_s2[i] != 0) return "gravity along a period";
  return "";
}

struct Fluxes {
  Wide sum = 0, size = 0;  // of flux times area, and of its absolute value [W]; in two dimensions of a metre of depth
};

// Of the walls around a box of fluid that fills what they enclose; none: the heat has another source, or an area is not
// known from the box.
std::optional<Fluxes> fluxes_of(const Scene& scene) {
  if (scene.fluids.size() != 1 || scene.fluids[0].viscous_heat || !(scene.fluids[0].heat_capacity_J_per_kg_K > 0))
    return std::nullopt;
  const auto* box = std::get_if<BoxRegion>(&scene.fluids[0].region);
  if (box == nullptr) return std::nullopt;
  Fluxes fluxes;
  int faces = 0;  // of the box that a plane closes
  for (const FluidBoundary& boundary : scene.fluid_boundaries) {
    const Body& body = scene.bodies[static_cast<std::size_t>(boundary.body)];
    const auto* plane = std::get_if<Plane>(&body.shape);
    if (plane == nullptr || !body.fixed || boundary.temperature_K) return std::nullopt;
    Wide area = 1;
    for (int c = 0; c < scene.domain.dimensions; ++c) {
      const double low = box->min_m[c], high = box->max_m[c], normal = plane->normal[c];
      if (normal != 0 && std::fabs(plane->offset_m * normal - (normal > 0 ? low : high)) > 1e-9 * (high - low))
        return std::nullopt;
      if (normal != 0 && std::fabs(normal) != 1) return std::nullopt;
      if (normal != 0) ++faces;
      else area *= Wide(high) - Wide(low);
    }
    const Wide power = Wide(boundary.heat_flux_W_per_m2.value_or(0)) * area;
    fluxes.sum += power, fluxes.size += fabsq(power);
  }
  for (int c = 0; c < scene.domain.dimensions; ++c) {
    const double period = scene.domain.periodic_m[c];
    if (period > 0 && std::fabs(box->max_m[c] - box->min_m[c] - period) > 1e-9 * period) return std::nullopt;
    if (period > 0) faces += 2;
  }
  if (faces != 2 * scene.domain.dimensions) return std::nullopt;
  return fluxes;
}

Wide volume_of(const std::vector<double>& masses, const SampleView& sample) {
  Wide volume = 0;
  for (std::size_t i = 0; i < sample.particles.size(); ++i) volume += masses[i] / sample.particles[i].density_kg_per_m3;
  return volume;
}

// Moving bodies take part in the balance of momenta.
WideVec turn(const std::array<Wide, 4>& q, const WideVec& v) {
  const WideVec u{q[1], q[2], q[3]}, once = cross(u, v), twice = cross(u, once);
  return {v[0] + 2 * (q[0] * once[0] + twice[0]), v[1] + 2 * (q[0] * once[1] + twice[1]),
          v[2] + 2 * (q[0] * once[2] + twice[2])};
}

struct Momenta {
  WideVec linear{}, angular{};
  Wide linear_sizes = 0, angular_sizes = 0;  // sums of |m v| and |m x v|
};

Momenta momenta_of(const Scene& scene, const std::vector<double>& masses, const SampleView& sample) {
  Momenta sum;
  const auto take = [&](Wide m, const WideVec& x, const WideVec& v) {
    const WideVec moment = cross(x, v);
    add(sum.linear, m, v), add(sum.angular, m, moment);
    sum.linear_sizes += m * sqrtq(dot(v, v)), sum.angular_sizes += m * sqrtq(dot(moment, moment));
  };
  for (std::size_t i = 0; i < sample.particles.size(); ++i)
    take(masses[i], sample.particles[i].p_m, sample.particles[i].v_m_per_s);
  for (std::size_t b = 0; b < sample.bodies.size(); ++b) {
    const Body& body = scene.bodies[b];
    if (body.fixed) continue;
    const BodySample& s = sample.bodies[b];
    take(body.mass_kg, s.p_m, s.v_m_per_s);
    WideVec spin{};
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t k = 0; k < 3; ++k) spin[i] += Wide(body.inertia_kg_m2[3 * i + k]) * s.w_rad_per_s[k];
    add(sum.angular, 1, turn(s.q_wxyz, spin));
  }
  return sum;
}

bool finite(const ParticleSample& p) {
  const auto is = [](Wide x) { return std::isfinite(static_cast<double>(x)); };
  return is(p.p_m[0]) && is(p.p_m[1]) && is(p.p_m[2]) && is(p.v_m_per_s[0]) && is(p.v_m_per_s[1]) &&
         is(p.v_m_per_s[2]) && is(p.density_kg_per_m3) && is(p.pressure_Pa) && is(p.temperature_K);
}

Row status_row(Status status, const std::string& reason) {
  Row bad = row("status", 0);
  bad.status = status;
  bad.reason = reason;
  return bad;
}

}  // namespace

std::vector<Row> fluid_status_rows(const Scenario& scenario, const Recording& run) {
  if (run.outcome.status != Status::ok) return {status_row(run.outcome.status, run.outcome.reason)};
  if (run.values.size() != static_cast<std::size_t>(scenario.samples) + 1)
    return {status_row(Status::crashed, "a recording of " + std::to_string(run.values.size()) + " samples; expected " +
                                            std::to_string(scenario.samples + 1))};
  const std::vector<int> fluids = fluid_of_particles(scenario.scene);
  for (const SampleView sample : run.values) {
    if (sample.particles.size() != fluids.size())
      return {status_row(Status::crashed, "a sample of " + std::to_string(sample.particles.size()) +
                                              " particles; the scene has " + std::to_string(fluids.size()))};
    for (std::size_t i = 0; i < fluids.size(); ++i)
      if (!finite(sample.particles[i]))
        return {status_row(Status::not_finite, "particle " + std::to_string(i) + " of the fluid `" +
                                                   scenario.scene.fluids[static_cast<std::size_t>(fluids[i])].name +
                                                   "` at t = " + format_double(static_cast<double>(sample.t_s)) +
                                                   " s")};
  }
  return {};
}

std::vector<FluidEnergies> fluid_energies(const Scene& scene, const SampleSeries& samples) {
  const std::vector<double> masses = masses_of(scene);
  const std::vector<int> fluids = fluid_of_particles(scene);
  std::vector<FluidEnergies> all;
  for (const SampleView sample : samples) all.push_back(energies_of(scene, fluids, masses, sample));
  return all;
}

Wide fluid_energy_scale(const std::vector<FluidEnergies>& energies) {
  Wide scale = 0;
  for (const FluidEnergies& e : energies)
    scale = std::max(scale,
                     e.kinetic + fabsq(e.potential - energies[0].potential) + fabsq(e.elastic - energies[0].elastic));
  return scale;
}

namespace {

void append_heat_entered(const Scenario& scenario, const FieldAtParticles& exact, const Recording& run,
                         const std::vector<FluidEnergies>& all, std::vector<Row>& rows) {
  const Scene& scene = scenario.scene;
  const std::optional<Fluxes> given = fluxes_of(scene);
  const Wide t = run.values.back().t_s, gained = all.back().heat - all[0].heat;
  if (!given || !(given->size * t > 0)) return;
  const auto joules = [](Wide heat) { return format_measure(static_cast<double>(heat), 0, 5) + " J"; };
  std::string reason = joules(gained) + " gained, " + joules(given->sum * t) + " through the walls";
  if (exact.outcome.status == Status::ok && exact.known.temperature && exact.samples.size() == run.values.size()) {
    const std::vector<double> masses = masses_of(scene);
    Wide sum = 0;
    for (std::size_t i = 0; i < masses.size(); ++i)
      sum += masses[i] * Wide(scene.fluids[0].heat_capacity_J_per_kg_K) *
             (exact.samples.back().values[i].temperature_K - exact.samples.front().values[i].temperature_K);
    reason += "; the same sum of the exact temperatures there: " + joules(sum);
  }
  rows.push_back(row("heat-entered-error", static_cast<double>((gained - given->sum * t) / (given->size * t)), 0,
                     std::move(reason)));
}

}  // namespace

void append_fluid_energy(const Scenario& scenario, const FieldAtParticles& exact, const Recording& run,
                         std::vector<Row>& rows) {
  const Scene& scene = scenario.scene;
  const std::vector<double> masses = masses_of(scene);
  const std::vector<FluidEnergies> all = fluid_energies(scene, run.values);
  if (exact.outcome.status == Status::ok && exact.known.velocity && exact.samples.size() == run.values.size()) {
    std::vector<Wide> truth;
    Wide bar = 0, scale = 0;
    for (const FieldSample& field : exact.samples) {
      Wide sum = 0;
      bar = 0;
      for (std::size_t i = 0; i < field.values.size(); ++i) {
        sum += masses[i] * dot(field.values[i].v_m_per_s, field.values[i].v_m_per_s) / 2;
        bar += masses[i] * sqrtq(dot(field.values[i].v_m_per_s, field.values[i].v_m_per_s) *
                                 dot(field.bars[i].v_m_per_s, field.bars[i].v_m_per_s));
      }
      truth.push_back(sum);
      scale = std::max(scale, sum);
    }
    if (scale > 0)
      rows.push_back(row(
          "kinetic-energy-error", static_cast<double>((all.back().kinetic - truth.back()) / scale),
          static_cast<double>(bar / scale),
          "at the end, of the largest of the exact field, " + format_measure(static_cast<double>(scale), 0) + " J"));
  }
  const std::string open = open_budget(scene);
  if (open.empty()) {
    const Wide scale = fluid_energy_scale(all);
    Wide largest = 0;
    for (const FluidEnergies& e : all) largest = std::max(largest, fabsq(e.total() - all[0].total()));
    if (scale > 0)
      rows.push_back(row("energy-budget", static_cast<double>(largest / scale), 0,
                         "kinetic " + format_measure(static_cast<double>(all.back().kinetic), 0) + ", elastic " +
                             format_measure(static_cast<double>(all.back().elastic), 0) + ", potential " +
                             format_measure(static_cast<double>(all.back().potential - all[0].potential), 0) +
                             ", heat " + format_measure(static_cast<double>(all.back().heat - all[0].heat), 0) +
                             " J at the end"));
  }
  append_heat_entered(scenario, exact, run, all, rows);
  const Wide before = volume_of(masses, run.values.front()), after = volume_of(masses, run.values.back());
  rows.push_back(row("volume-error", static_cast<double>((after - before) / before)));
}

namespace {

// The force from outside on everything that moves [N], which is constant; none: it is not, or not known from the scene.
std::optional<WideVec> constant_force(const Scene& scene, const std::vector<double>& masses) {
  for (const Fluid& fluid : scene.fluids)
    if (!fluid.source.name.empty() || fluid.expansion_per_K != 0) return std::nullopt;
  for (const FluidBoundary& boundary : scene.fluid_boundaries)
    if (scene.bodies[static_cast<std::size_t>(boundary.body)].fixed) return std::nullopt;
  Wide mass = 0;
  for (const double m : masses) mass += m;
  for (const Body& body : scene.bodies)
    if (!body.fixed) mass += body.mass_kg;
  WideVec sum{};
  for (std::size_t i = 0; i < 3; ++i) sum[i] = mass * scene.gravity_m_per_s2[i];
  for (const Force& force : scene.forces) {
    const auto* push = std::get_if<PointForce>(&force);
    if (push == nullptr || !push->on_s.empty()) return std::nullopt;
    for (std::size_t i = 0; i < 3; ++i) sum[i] += push->force_N[i];
  }
  return sum;
}

}  // namespace

void append_fluid_momenta(const Scenario& scenario, const Recording& run, std::vector<Row>& rows) {
  const Scene& scene = scenario.scene;
  const std::vector<double> masses = masses_of(scene);
  const std::optional<WideVec> outside = constant_force(scene, masses);
  if (!outside) return;
  const bool free = *outside == WideVec{} && scene.forces.empty();
  const Momenta first = momenta_of(scene, masses, run.values.front());
  Wide linear = 0, angular = 0;
  for (const SampleView sample : run.values) {
    const Momenta now = momenta_of(scene, masses, sample);
    WideVec dp = now.linear, dl = now.angular;
    add(dp, -1, first.linear), add(dl, -1, first.angular);
    add(dp, -sample.t_s, *outside);
    const auto share = [](const WideVec& d, Wide size) { return size > 0 ? sqrtq(dot(d, d)) / size : Wide(0); };
    linear = std::max(linear, share(dp, std::max(now.linear_sizes, first.linear_sizes)));
    angular = std::max(angular, share(dl, std::max(now.angular_sizes, first.angular_sizes)));
  }
  rows.push_back(
      row("fluid-momentum-error", static_cast<double>(linear), 0,
          free ? "of the sum of |m v|, largest sample"
               : "beside the impulse of the constant force from outside; of the sum of |m v|, largest sample"));
  if (free && scene.domain.periodic_m == Real3{})
    rows.push_back(row("fluid-angular-momentum-error", static_cast<double>(angular), 0,
                       "about the origin, of the sum of |m x v|, largest sample"));
}

}  // namespace metrics
std::vector<Wide> fluid_kinetic_energy(const Scene& scene, const SampleSeries& samples) {
  const std::vector<double> masses = metrics::masses_of(scene);
  std::vector<Wide> energies;
  for (const SampleView sample : samples) energies.push_back(metrics::kinetic_energy_of(masses, sample));
  return energies;
}

}  // namespace atwood
