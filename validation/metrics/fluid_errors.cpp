// Errors of a fluid's fields against exact fields at the particles, and their parts.
#include <algorithm>
#include <cmath>

#include "scene/files.hpp"
#include "validation/metrics/fluid.hpp"
#include "validation/metrics/fluid_parts.hpp"
#include "validation/metrics/measurements.hpp"

namespace atwood {
namespace {

using Vec = std::array<double, 3>;

// Three norms at once: of errors over those of the exact values.
struct Norms {
  double sum = 0, squares = 0, largest = 0;
  void take(double mass, double size) {
    sum += mass * size;
    squares += mass * size * size;
    if (!(size <= largest)) largest = size;  // also NaN
  }
  double of(std::size_t norm) const { return norm == 0 ? sum : norm == 1 ? std::sqrt(squares) : largest; }
};
constexpr std::array<const char*, 3> kNorms{"l1", "l2", "linf"};
constexpr double kFieldRoundOff = 0x1p-51;  // relative, of an interpolated velocity: two units in the last place

// The scale in the unit of a norm over particles of this mass, where the exact field is 0.
Norms uniform(double mass, double size) {
  Norms norms;
  norms.take(mass, size);
  return norms;
}

double length(const Vec& v) { return std::hypot(v[0], v[1], v[2]); }
Vec difference(const std::array<Wide, 3>& a, const std::array<Wide, 3>& b) {
  return {static_cast<double>(a[0] - b[0]), static_cast<double>(a[1] - b[1]), static_cast<double>(a[2] - b[2])};
}
double size_of(const std::array<Wide, 3>& a) { return metrics::norm(a); }

struct Quantity {
  const char* name;
  const char* unit;
  bool FieldKnown::*known;
  Wide ParticleSample::*scalar;  // null: the velocity
};
const std::array<Quantity, 4> kQuantities{
    {{"velocity", "m/s", &FieldKnown::velocity, nullptr},
     {"pressure", "Pa", &FieldKnown::pressure, &ParticleSample::pressure_Pa},
     {"density", "kg/m^3", &FieldKnown::density, &ParticleSample::density_kg_per_m3},
     {"temperature", "K", &FieldKnown::temperature, &ParticleSample::temperature_K}}};

double own_scale(const Quantity& quantity, const Fluid& fluid) {
  const double c = fluid.sound_speed_m_per_s, rho0 = fluid.density_kg_per_m3;
  if (!quantity.scalar) return c;
  if (quantity.scalar == &ParticleSample::pressure_Pa) return rho0 * c * c;
  return quantity.scalar == &ParticleSample::density_kg_per_m3 ? rho0 : 1;
}

// Rows of one quantity at one sample; of the whole run where it is the last.
void append_norms(const Scenario& scenario, const Quantity& quantity, const std::vector<double>& masses,
                  const SampleView& sample, const FieldSample& exact, bool last, const std::string& source,
                  std::vector<Row>& rows) {
  Norms error, size, bar;
  double mass = 0;
  for (std::size_t i = 0; i < sample.particles.size(); ++i) {
    const ParticleSample &p = sample.particles[i], &e = exact.values[i], &b = exact.bars[i];
    mass += masses[i];
    if (quantity.scalar) {
      error.take(masses[i], std::fabs(static_cast<double>(p.*quantity.scalar - e.*quantity.scalar)));
      size.take(masses[i], std::fabs(static_cast<double>(e.*quantity.scalar)));
      bar.take(masses[i], std::fabs(static_cast<double>(b.*quantity.scalar)));
    } else {
      error.take(masses[i], length(difference(p.v_m_per_s, e.v_m_per_s)));
      size.take(masses[i], size_of(e.v_m_per_s));
      bar.take(masses[i], size_of(b.v_m_per_s));
    }
  }
  const bool none = !(size.largest > 0);
  if (none) size = uniform(mass, own_scale(quantity, scenario.scene.fluids.front()));
  for (std::size_t n = 0; n < 3; ++n) {
    const double mean = n == 0 ? size.of(n) / mass : n == 1 ? size.of(n) / std::sqrt(mass) : size.of(n);
    const std::string scale = std::string(none ? kOfOwnScale : "of the exact field's own norm") + ", " +
                              format_measure(mean, 0) + " " + quantity.unit;
    Row row = metrics::row(std::string(quantity.name) + "-" + kNorms[n], error.of(n) / size.of(n),
                           bar.of(n) / size.of(n), scale + "; " + source);
    if (last) rows.push_back(row);
    row.t_s = static_cast<double>(sample.t_s);
    rows.push_back(row);
  }
}

// ---- the parts of the velocity's error ------------------------------------------------------------------------------
struct Parts {
  std::vector<Vec> total, model, space, time;
};

void append_part(const char* metric, const std::vector<Vec>& part, const std::vector<Vec>& bars,
                 const std::vector<double>& masses, const Norms& size, const std::string& reason,
                 std::vector<Row>& rows) {
  Norms error, bar;
  for (std::size_t i = 0; i < part.size(); ++i) {
    error.take(masses[i], length(part[i]));
    bar.take(masses[i], length(bars[i]));
  }
  for (std::size_t n = 0; n < 3; ++n) {
    Row row = metrics::row(metric, error.of(n) / size.of(n), bar.of(n) / size.of(n), reason);
    if (n > 0) row.body = kNorms[n];
    rows.push_back(row);
  }
}

Vec sum_of(const Vec& a, const Vec& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
Vec bar_of(const ParticleSample& p) {
  return {static_cast<double>(p.v_m_per_s[0]), static_cast<double>(p.v_m_per_s[1]),
          static_cast<double>(p.v_m_per_s[2])};
}

bool usable(const FieldAtParticles& field, std::size_t samples) {
  return field.outcome.status == Status::ok && field.known.velocity && field.samples.size() == samples;
}

// At the last sample. Each difference is taken in quad, then narrowed.
void append_parts(const FluidTruths& truths, const Recording& run, const std::vector<double>& masses,
                  std::vector<Row>& rows) {
  const std::size_t samples = run.values.size(), last = samples - 1;
  if (!usable(truths.exact, samples)) return;
  const bool model = truths.model && usable(truths.compressible, samples);
  const FieldAtParticles& against = model ? truths.compressible : truths.exact;
  const bool stepped = truths.semi_discrete.values.size() == samples && usable(truths.compressible_there, samples);
  const auto& particles = run.values[last].particles;
  const auto &exact = truths.exact.samples[last], &near = against.samples[last];
  Parts parts;
  std::vector<Vec> model_bar, space_bar, time_bar;
  Norms size;
  double residual = 0;
  for (std::size_t i = 0; i < particles.size(); ++i) {
    size.take(masses[i], size_of(exact.values[i].v_m_per_s));
    parts.total.push_back(difference(particles[i].v_m_per_s, exact.values[i].v_m_per_s));
    parts.model.push_back(model ? difference(near.values[i].v_m_per_s, exact.values[i].v_m_per_s) : Vec{});
    model_bar.push_back(model ? sum_of(bar_of(near.bars[i]), bar_of(exact.bars[i])) : Vec{});
    const Vec left = difference(particles[i].v_m_per_s, near.values[i].v_m_per_s);
    if (stepped) {
      const ParticleSample& there = truths.semi_discrete.values[last].particles[i];
      const FieldSample& field = truths.compressible_there.samples[last];
      const Vec space = difference(there.v_m_per_s, field.values[i].v_m_per_s);
      parts.space.push_back(space);
      parts.time.push_back({left[0] - space[0], left[1] - space[1], left[2] - space[2]});
      const Vec bar = bar_of(truths.semi_discrete.bars[last].particles[i]);
      space_bar.push_back(sum_of(bar, bar_of(field.bars[i])));
      // The field's own bar is common to both differences; its round-off is not, for it is solved and interpolated in
      // double.
      Vec wider = bar;
      for (std::size_t k = 0; k < 3; ++k)
        wider[k] += kFieldRoundOff * std::fabs(static_cast<double>(near.values[i].v_m_per_s[k]));
      time_bar.push_back(wider);
    } else {
      parts.space.push_back(left);
      space_bar.push_back(bar_of(near.bars[i]));
      parts.time.push_back({});
    }
    Vec open{};
    for (std::size_t k = 0; k < 3; ++k)
      open[k] = parts.total[i][k] - parts.model[i][k] - parts.space[i][k] - parts.time[i][k];
    residual = std::max(residual, length(open));
  }
  if (!(size.largest > 0)) return;
  const std::string of = "of the exact velocity's own norm at the end";
  if (model)
    append_part("model-error", parts.model, model_bar, masses, size, of + "; " + truths.compressible.source, rows);
  append_part("space-error", parts.space, space_bar, masses, size,
              of + "; " + (stepped ? truths.semi_discrete.source : kWithStepsError), rows);
  if (stepped)
    append_part("time-error", parts.time, time_bar, masses, size, of + "; " + truths.semi_discrete.source, rows);
  rows.push_back(metrics::row("closing-residual", residual / size.largest, 0,
                              std::string("largest of all particles, of the largest exact velocity; parts: ") +
                                  (model ? "model, " : "") + (stepped ? "space, time" : "space with time")));
}

}  // namespace

FluidTruths fluid_truths(const Scenario& scenario, const Recording& run, const AskField& ask,
                         const std::function<Truth()>& semi_discrete) {
  FluidTruths truths;
  for (FieldAtParticles* field : {&truths.exact, &truths.compressible, &truths.compressible_there, &truths.on_grid})
    field->outcome.status = Status::unsupported;
  truths.semi_discrete.outcome.status = Status::unsupported;
  const TruthSpec& truth = scenario.truth;
  if (truth.kind == TruthKind::none || run.values.empty() || run.outcome.status != Status::ok) return truths;
  std::vector<Wide> t_s;
  const auto positions_of = [](const SampleSeries& samples) {
    std::vector<std::vector<FieldPosition>> positions;
    for (const SampleView sample : samples) {
      positions.emplace_back();
      for (const ParticleSample& p : sample.particles) positions.back().push_back(p.p_m);
    }
    return positions;
  };
  for (const SampleView sample : run.values) t_s.push_back(sample.t_s);
  const auto here = positions_of(run.values);
  const bool stepping = truth.kind == TruthKind::semi_discrete;
  const bool named = !truth.solution.empty();
  if (!stepping || named) truths.exact = ask(stepping ? TruthKind::closed_form : truth.kind, t_s, here);
  if (const auto grid = comparison_grid(scenario.scene); !grid.empty() && truths.exact.outcome.status == Status::ok)
    truths.on_grid = ask(stepping ? TruthKind::closed_form : truth.kind, {t_s.back()}, {grid});
  const bool closed = stepping || truth.kind == TruthKind::closed_form;
  if (closed && named && truths.exact.outcome.status == Status::ok) {
    truths.compressible = ask(TruthKind::weakly_compressible, t_s, here);
    truths.model = truths.compressible.outcome.status == Status::ok;
  }
  if (!stepping) return truths;
  truths.semi_discrete = semi_discrete();
  if (truths.semi_discrete.values.size() == run.values.size() && named)
    truths.compressible_there = ask(truths.model ? TruthKind::weakly_compressible : TruthKind::closed_form, t_s,
                                    positions_of(truths.semi_discrete.values));
  return truths;
}

std::vector<Row> measure_fluid(const Scenario& scenario, const FluidTruths& truths, const Recording& run) {
  std::vector<Row> rows = metrics::fluid_status_rows(scenario, run);
  metrics::append_solver_figures(run, rows);
  if (std::any_of(rows.begin(), rows.end(), [](const Row& r) { return r.metric == "status"; })) return rows;
  std::vector<double> masses;
  for (const Fluid& fluid : scenario.scene.fluids)
    masses.insert(masses.end(), fluid.particles.mass_kg.begin(), fluid.particles.mass_kg.end());
  const FieldAtParticles& exact = truths.exact;
  if (exact.outcome.status == Status::ok && exact.samples.size() == run.values.size())
    for (const Quantity& quantity : kQuantities)
      for (std::size_t k = 1; k < run.values.size() && exact.known.*quantity.known; ++k)
        append_norms(scenario, quantity, masses, run.values[k], exact.samples[k], k + 1 == run.values.size(),
                     exact.source, rows);
  metrics::append_grid_norms(scenario, truths, run, rows);
  append_parts(truths, run, masses, rows);
  metrics::append_semi_discrete(truths.semi_discrete, run, masses, rows);
  metrics::append_fluid_energy(scenario, exact, run, rows);
  metrics::append_fluid_momenta(scenario, run, rows);
  metrics::append_fluid_order(scenario, run, rows);
  metrics::append_probes(scenario, exact, run, rows);
  if (run.outcome.rate_evaluations > 0)
    rows.push_back(metrics::row("rate-evaluations", static_cast<double>(run.outcome.rate_evaluations)));
  return rows;
}

}  // namespace atwood
