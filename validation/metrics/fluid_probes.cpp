// Probes of a fluid, and how its particles lie.
#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <unordered_map>

#include "validation/metrics/fluid_parts.hpp"
#include "validation/metrics/measurements.hpp"

namespace atwood {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kReachSpacings = 3;  // of the fit around a probe

using Vec = std::array<double, 3>;

double coarsest_spacing(const Scene& scene) {
  double spacing = 0;
  for (const Fluid& fluid : scene.fluids) spacing = std::max(spacing, fluid.spacing_m);
  return spacing;
}

// From `from` to `to`, by the nearest image.
Vec nearest_image(const Domain& domain, const Vec& from, const std::array<Wide, 3>& to) {
  Vec d{};
  for (std::size_t i = 0; i < 3; ++i) {
    d[i] = static_cast<double>(to[i] - from[i]);
    if (domain.periodic_m[i] > 0) d[i] -= domain.periodic_m[i] * std::round(d[i] / domain.periodic_m[i]);
  }
  return d;
}

// The value at x of the linear function that fits best, by weighted least squares: minimise
// sum_j w(r_j) (a + b . (x_j - x) - f_j)^2 over a and b; w(r) = (1 - r/R)^4 (1 + 4 r/R). Its value at x is a. Fewer
// particles than unknowns, or all in a line: the weighted mean. None: NaN. `place` gives x_j of particle j.
template <class Place, class Get>
double fitted(const Scene& scene, const SampleView& sample, const Vec& x, Place place, Get get) {
  const auto d = static_cast<Eigen::Index>(scene.domain.dimensions);
  const double radius = kReachSpacings * coarsest_spacing(scene);
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(d + 1, d + 1);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(d + 1);
  Eigen::Index count = 0;
  for (std::size_t j = 0; j < sample.particles.size(); ++j) {
    const ParticleSample& p = sample.particles[j];
    const Vec away = nearest_image(scene.domain, x, place(j));
    const double r = std::hypot(away[0], away[1], away[2]) / radius;
    if (!(r < 1)) continue;
    const double weight = std::pow(1 - r, 4) * (1 + 4 * r);
    Eigen::VectorXd basis(d + 1);
    basis[0] = 1;
    for (Eigen::Index i = 0; i < d; ++i) basis[i + 1] = away[static_cast<std::size_t>(i)] / radius;
    normal += weight * basis * basis.transpose();
    right += weight * static_cast<double>(get(p)) * basis;
    ++count;
  }
  if (count == 0) return kNan;
  const Eigen::FullPivLU<Eigen::MatrixXd> lu(normal / normal(0, 0));
  if (count <= d || !(lu.rcond() > 1e-10)) return right[0] / normal(0, 0);
  return lu.solve(right / normal(0, 0))[0];
}

template <class Get> double fitted(const Scene& scene, const SampleView& sample, const Vec& x, Get get) {
  return fitted(
      scene, sample, x, [&](std::size_t j) { return sample.particles[j].p_m; }, get);
}

// Where the point that began at x is now, by the particles that began around it; its distance from the origin.
double marker(const Scene& scene, const FluidProbe& probe, const SampleView& sample) {
  std::vector<std::array<Wide, 3>> start;
  for (const Fluid& fluid : scene.fluids)
    for (const Real3& x : fluid.particles.position_m) start.push_back({x[0], x[1], x[2]});
  Vec at{};
  // The displacement is fitted, because the nearest image of a particle may be another than the particle.
  for (std::size_t i = 0; i < 3; ++i)
    at[i] = probe.position_m[i] + fitted(
                                      scene, sample, probe.position_m, [&](std::size_t j) { return start[j]; },
                                      [&, i](const ParticleSample& p) {
                                        const auto j = static_cast<std::size_t>(&p - sample.particles.data());
                                        return p.p_m[i] - start[j][i];
                                      });
  return std::hypot(at[0], at[1], at[2]);
}

double column_height(const Scene& scene, const FluidProbe& probe, const SampleView& sample) {
  Vec up{0, 1, 0};
  const Real3& g = scene.gravity_m_per_s2;
  if (const double size = std::hypot(g[0], g[1], g[2]); size > 0) up = {-g[0] / size, -g[1] / size, -g[2] / size};
  const double spacing = coarsest_spacing(scene);
  double highest = kNan;
  for (const ParticleSample& p : sample.particles) {
    const Vec away = nearest_image(scene.domain, probe.position_m, p.p_m);
    const double along = away[0] * up[0] + away[1] * up[1] + away[2] * up[2];
    const double aside = std::hypot(away[0] - along * up[0], away[1] - along * up[1], away[2] - along * up[2]);
    if (aside > spacing) continue;
    double height = 0;
    for (std::size_t i = 0; i < 3; ++i) height += up[i] * static_cast<double>(p.p_m[i]);
    if (!(height <= highest)) highest = height;
  }
  return highest + spacing / 2;
}

double front(const Scene& scene, const SampleView& sample) {
  double farthest = kNan;
  for (const ParticleSample& p : sample.particles)
    if (const double x = static_cast<double>(p.p_m[0]); !(x <= farthest)) farthest = x;
  return farthest + coarsest_spacing(scene) / 2;
}

}  // namespace

double probe_value(const Scene& scene, const FluidProbe& probe, const SampleView& sample) {
  switch (probe.kind) {
    case ProbeKind::pressure:
      return fitted(scene, sample, probe.position_m, [](const ParticleSample& p) { return p.pressure_Pa; });
    case ProbeKind::velocity: {
      Vec v{};
      for (std::size_t i = 0; i < 3; ++i)
        v[i] = fitted(scene, sample, probe.position_m, [i](const ParticleSample& p) { return p.v_m_per_s[i]; });
      return std::hypot(v[0], v[1], v[2]);
    }
    case ProbeKind::front: return front(scene, sample);
    case ProbeKind::column_height: return column_height(scene, probe, sample);
    case ProbeKind::force_on_body: return kNan;  // of a single sample: probe_values()
    case ProbeKind::marker: return marker(scene, probe, sample);
  }
  return kNan;
}

namespace {

// The mean force [N] of the fluid on a free body between two samples: the change of its momentum, less gravity and
// point forces that are always on. None: the body is fixed, or the scene has joints, ropes or other forces.
std::optional<Vec> mean_force(const Scene& scene, int index, const SampleView& before, const SampleView& now) {
  const auto b = static_cast<std::size_t>(index);
  const Body& body = scene.bodies[b];
  if (body.fixed || !scene.joints.empty() || !scene.ropes.empty() || b >= now.bodies.size() ||
      b >= before.bodies.size())
    return std::nullopt;
  Vec force{};
  const Wide passed_s = now.t_s - before.t_s;
  for (std::size_t i = 0; i < 3; ++i)
    force[i] =
        static_cast<double>(body.mass_kg * ((now.bodies[b].v_m_per_s[i] - before.bodies[b].v_m_per_s[i]) / passed_s -
                                            scene.gravity_m_per_s2[i]));
  for (const Force& each : scene.forces) {
    const auto* push = std::get_if<PointForce>(&each);
    if (push == nullptr || !push->on_s.empty()) return std::nullopt;
    if (push->body != index) continue;
    for (std::size_t i = 0; i < 3; ++i) force[i] -= push->force_N[i];
  }
  return force;
}

// The same on a body that is the only fixed boundary: the momentum that the fluid loses and no free body gains.
std::optional<Vec> mean_force_on_fixed(const Scene& scene, int index, const SampleView& before, const SampleView& now) {
  Vec force{};
  for (const FluidBoundary& boundary : scene.fluid_boundaries) {
    if (boundary.body == index) continue;
    const std::optional<Vec> other = mean_force(scene, boundary.body, before, now);
    if (!other) return std::nullopt;
    for (std::size_t i = 0; i < 3; ++i) force[i] -= (*other)[i];
  }
  const Wide passed_s = now.t_s - before.t_s;
  std::size_t j = 0;
  for (const Fluid& fluid : scene.fluids) {
    if (!fluid.source.name.empty() || fluid.expansion_per_K != 0) return std::nullopt;
    for (const double mass : fluid.particles.mass_kg) {
      if (j >= now.particles.size() || j >= before.particles.size()) return std::nullopt;
      for (std::size_t i = 0; i < 3; ++i)
        force[i] +=
            static_cast<double>(mass * (scene.gravity_m_per_s2[i] -
                                        (now.particles[j].v_m_per_s[i] - before.particles[j].v_m_per_s[i]) / passed_s));
      ++j;
    }
  }
  return force;
}

}  // namespace

std::vector<double> probe_values(const Scene& scene, const FluidProbe& probe, const SampleSeries& samples) {
  std::vector<double> values;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    if (probe.kind != ProbeKind::force_on_body) {
      values.push_back(probe_value(scene, probe, samples[k]));
      continue;
    }
    std::optional<Vec> force;
    if (k > 0 && probe.body >= 0)
      force = scene.bodies[static_cast<std::size_t>(probe.body)].fixed
                  ? mean_force_on_fixed(scene, probe.body, samples[k - 1], samples[k])
                  : mean_force(scene, probe.body, samples[k - 1], samples[k]);
    values.push_back(force ? std::hypot((*force)[0], (*force)[1], (*force)[2]) : kNan);
  }
  return values;
}

std::string probe_gap(const Scene& scene, const FluidProbe& probe) {
  if (probe.kind == ProbeKind::force_on_body)
    return "the mean force since the sample before, of a body on which nothing but the fluid, gravity and constant forces act";
  const bool column = probe.kind == ProbeKind::column_height;
  const double reach = (column ? 1 : kReachSpacings) * coarsest_spacing(scene);
  std::string place;
  for (int i = 0; i < scene.domain.dimensions; ++i)
    place += (place.empty() ? "[" : ", ") + format_measure(probe.position_m[static_cast<std::size_t>(i)], 0);
  return "no particle is within " + format_measure(reach, 0) + " m of " + (column ? "the line through " : "") + place +
         "] m";
}

const char* probe_unit(const FluidProbe& probe) {
  switch (probe.kind) {
    case ProbeKind::pressure: return "Pa";
    case ProbeKind::velocity: return "m/s";
    case ProbeKind::front:
    case ProbeKind::column_height:
    case ProbeKind::marker: return "m";
    case ProbeKind::force_on_body: return "N";
  }
  return "";
}

const char* probe_kind(const FluidProbe& probe) {
  switch (probe.kind) {
    case ProbeKind::pressure: return "pressure";
    case ProbeKind::velocity: return "velocity";
    case ProbeKind::front: return "front";
    case ProbeKind::column_height: return "column-height";
    case ProbeKind::force_on_body: return "force-on-body";
    case ProbeKind::marker: return "marker";
  }
  return "";
}

namespace metrics {
namespace {

// Distance to the nearest other particle, of each, over the spacing of its fluid. Cells of two spacings, found by hash.
std::vector<double> nearest_of(const Scene& scene, const SampleView& sample) {
  const std::vector<int> fluids = fluid_of_particles(scene);
  const double wanted = 2 * coarsest_spacing(scene);
  std::array<double, 3> size{wanted, wanted, wanted};
  std::array<std::int64_t, 3> cells{};
  for (std::size_t i = 0; i < 3; ++i)
    if (const double period = scene.domain.periodic_m[i]; period > 0) {
      cells[i] = std::max<std::int64_t>(1, static_cast<std::int64_t>(std::floor(period / wanted)));
      size[i] = period / static_cast<double>(cells[i]);
    }
  const auto key_of = [&](const std::array<std::int64_t, 3>& at) {
    std::uint64_t h = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      std::int64_t c = at[i];
      if (cells[i] > 0) c = ((c % cells[i]) + cells[i]) % cells[i];
      h = (h ^ static_cast<std::uint64_t>(c)) * 0x9e3779b97f4a7c15u;
    }
    return h;
  };
  const auto cell_of = [&](const ParticleSample& p) {
    std::array<std::int64_t, 3> at{};
    for (std::size_t i = 0; i < 3; ++i)
      at[i] = static_cast<std::int64_t>(std::floor(static_cast<double>(p.p_m[i]) / size[i]));
    return at;
  };
  std::unordered_map<std::uint64_t, std::vector<std::size_t>> grid;
  for (std::size_t i = 0; i < sample.particles.size(); ++i) grid[key_of(cell_of(sample.particles[i]))].push_back(i);
  std::vector<double> nearest(sample.particles.size(), wanted);
  for (std::size_t i = 0; i < sample.particles.size(); ++i) {
    const ParticleSample& p = sample.particles[i];
    const Vec x{static_cast<double>(p.p_m[0]), static_cast<double>(p.p_m[1]), static_cast<double>(p.p_m[2])};
    const auto middle = cell_of(p);
    const int depth = scene.domain.dimensions == 2 ? 0 : 1;
    for (int a = -1; a <= 1; ++a)
      for (int b = -1; b <= 1; ++b)
        for (int c = -depth; c <= depth; ++c) {
          const auto found = grid.find(key_of({middle[0] + a, middle[1] + b, middle[2] + c}));
          if (found == grid.end()) continue;
          for (const std::size_t j : found->second) {
            if (j == i) continue;
            const Vec d = nearest_image(scene.domain, x, sample.particles[j].p_m);
            nearest[i] = std::min(nearest[i], std::hypot(d[0], d[1], d[2]));
          }
        }
    nearest[i] /= scene.fluids[static_cast<std::size_t>(fluids[i])].spacing_m;
  }
  return nearest;
}

}  // namespace

void append_fluid_order(const Scenario& scenario, const Recording& run, std::vector<Row>& rows) {
  const std::vector<double> nearest = nearest_of(scenario.scene, run.values.back());
  double mean = 0, spread = 0, least = nearest.front();
  const double count = static_cast<double>(nearest.size());
  for (const double d : nearest) mean += d / count, least = std::min(least, d);
  for (const double d : nearest) spread += (d - mean) * (d - mean) / count;
  rows.push_back(row("particle-order", mean > 0 ? std::sqrt(spread) / mean : 0));
  rows.push_back(row("spacing-min", least, 0, "of the spacing, at the end"));
  double fastest = 0;
  for (const ParticleSample& p : run.values.back().particles) fastest = std::max(fastest, norm(p.v_m_per_s));
  rows.push_back(row("speed-max", fastest));
}

void append_semi_discrete(const Truth& truth, const Recording& run, const std::vector<double>& masses,
                          std::vector<Row>& rows) {
  if (truth.values.size() != run.values.size()) return;
  if (std::any_of(rows.begin(), rows.end(), [](const Row& r) { return r.metric == "time-error"; })) return;
  const auto &now = run.values.back().particles, &then = truth.values.back().particles,
             &bars = truth.bars.back().particles;
  if (then.size() != now.size() || bars.size() != now.size()) return;
  double error = 0, size = 0, bar = 0;
  for (std::size_t i = 0; i < now.size(); ++i) {
    error += masses[i] * distance(now[i].v_m_per_s, then[i].v_m_per_s);
    size += masses[i] * norm(then[i].v_m_per_s);
    bar += masses[i] * norm(bars[i].v_m_per_s);
  }
  if (size > 0)
    rows.push_back(
        row("time-error", error / size, bar / size, "of the true velocity's own norm at the end; " + truth.source));
}

namespace {

struct Curve {  // x over t, both rising: of a front that recedes, the farthest place so far
  std::vector<double> t_s, x_m;
  static double between(const std::vector<double>& at, const std::vector<double>& of, double value) {
    const auto after = std::lower_bound(at.begin(), at.end(), value);
    if (after == at.end() || (after == at.begin() && *after > value)) return kNan;
    const auto k = static_cast<std::size_t>(after - at.begin());
    if (k == 0) return of[0];
    return of[k - 1] + (of[k] - of[k - 1]) * (value - at[k - 1]) / (at[k] - at[k - 1]);
  }
  double x_at(double time_s) const { return between(t_s, x_m, time_s); }
  double t_at(double place_m) const { return between(x_m, t_s, place_m); }
};

double slope_of_line(const std::vector<double>& t, const std::vector<double>& x) {
  const double n = static_cast<double>(t.size());
  double st = 0, sx = 0, stt = 0, stx = 0;
  for (std::size_t k = 0; k < t.size(); ++k) st += t[k], sx += x[k], stt += t[k] * t[k], stx += t[k] * x[k];
  return (n * stx - st * sx) / (n * stt - st * st);
}

// The largest |run(t - delay) / measured(t) - 1| over the readings from `least_m` on within the run's time; before its
// start the run's front is where it begins. Infinite where fewer than four readings are left.
double worst_after(const Curve& run, const Curve& measured, double delay_s, double least_m) {
  double worst = 0;
  int compared = 0;
  for (std::size_t k = 0; k < measured.t_s.size(); ++k) {
    if (measured.x_m[k] < least_m || measured.t_s[k] > run.t_s.back()) continue;
    const double x = run.x_at(std::max(run.t_s.front(), measured.t_s[k] - delay_s));
    worst = std::max(worst, std::fabs(x / measured.x_m[k] - 1));
    ++compared;
  }
  return compared < 4 ? std::numeric_limits<double>::infinity() : worst;
}

// A front against a measured one, from 1.4 of its distance at t = 0 on, where the release is over: the speed at equal
// places, and the place after the one delay that fits best.
void append_measured_front(const Curve& run, const Curve& measured, std::vector<Row>& rows) {
  const double begin_m = 1.4 * run.x_m.front();
  constexpr int delays = 1000;
  std::vector<double> t_run, t_measured, x;
  for (std::size_t k = 0; k < measured.x_m.size(); ++k) {
    const double t_s = run.t_at(measured.x_m[k]);
    if (std::isnan(t_s) || measured.x_m[k] < begin_m) continue;
    t_run.push_back(t_s), t_measured.push_back(measured.t_s[k]), x.push_back(measured.x_m[k]);
  }
  if (x.size() < 4) return;
  const double own = slope_of_line(t_run, x), theirs = slope_of_line(t_measured, x);
  rows.push_back(row("front-speed-error", own / theirs - 1, 0,
                     "slopes of straight lines through the places from " + format_measure(x.front(), 0) + " to " +
                         format_measure(x.back(), 0) + " m; measured " + format_measure(theirs, 0) + " m/s"));
  double best_s = 0, least = worst_after(run, measured, 0, begin_m);
  for (int k = 1; k <= delays; ++k) {
    const double delay_s = 0.5 * run.t_s.back() * k / delays, worst = worst_after(run, measured, delay_s, begin_m);
    if (worst < least) least = worst, best_s = delay_s;
  }
  rows.push_back(row("front-delay", best_s, 0, "the measured front is that much later"));
  rows.push_back(row("front-delayed-error", least, 0,
                     "after a delay of " + format_measure(best_s, 0) + " s, from " + format_measure(begin_m, 0) +
                         " m on; over all readings " + format_measure(worst_after(run, measured, best_s, 0), 0)));
}

}  // namespace

void append_probes(const Scenario& scenario, const FieldAtParticles& exact, const Recording& run,
                   std::vector<Row>& rows) {
  if (exact.outcome.status != Status::ok || exact.samples.size() != run.values.size()) return;
  const auto& probes = scenario.scene.probes;
  for (std::size_t n = 0; n < probes.size(); ++n) {
    const bool of_front = probes[n].kind == ProbeKind::front;
    Curve own, measured;
    const std::vector<double> values = probe_values(scenario.scene, probes[n], run.values);
    for (std::size_t k = 0; k < run.values.size(); ++k) {
      const double value = values[k];
      const double t_s = static_cast<double>(run.values[k].t_s);
      own.t_s.push_back(t_s), own.x_m.push_back(own.x_m.empty() ? value : std::max(value, own.x_m.back()));
      const auto& known = exact.samples[k].probes;
      if (k == 0 || n >= known.size() || !known[n]) continue;
      const double truth = static_cast<double>(known[n]->value), bar = static_cast<double>(known[n]->bar);
      measured.t_s.push_back(t_s), measured.x_m.push_back(truth);
      const double scale = std::fabs(truth);
      if (!(scale > 0)) continue;
      Row one = row(of_front ? "front-error" : "probe-error", (value - truth) / scale, bar / scale,
                    std::isnan(value) ? probe_gap(scenario.scene, probes[n])
                                      : "of " + format_measure(truth, 0) + " " + probe_unit(probes[n]));
      one.body = of_front ? "" : probes[n].name;
      if (k + 1 == run.values.size()) rows.push_back(one);
      one.t_s = t_s;
      rows.push_back(one);
    }
    if (of_front && scenario.truth.kind == TruthKind::literature) append_measured_front(own, measured, rows);
  }
}

}  // namespace metrics
}  // namespace atwood
