#include "validation/metrics/fluid_picture.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "validation/metrics/measurements.hpp"

namespace atwood {
namespace {

double wrapped(double x, double period) { return period > 0 ? x - period * std::floor(x / period) : x; }

// Positions in the plane, of the particles that are drawn; `which` are their numbers.
struct PlaneSection {
  std::vector<std::size_t> which;
  std::vector<std::array<double, 2>> at;
};

PlaneSection plane_of(const Scene& scene, const SampleView& sample, double spacing) {
  PlaneSection plane;
  const std::array<double, 3>& period = scene.domain.periodic_m;
  double low = 0, high = 0;
  if (scene.domain.dimensions == 3) {
    low = INFINITY, high = -INFINITY;
    for (const ParticleSample& p : sample.particles) {
      const double z = wrapped(static_cast<double>(p.p_m[2]), period[2]);
      low = std::min(low, z), high = std::max(high, z);
    }
  }
  for (std::size_t i = 0; i < sample.particles.size(); ++i) {
    const ParticleSample& p = sample.particles[i];
    const double z = wrapped(static_cast<double>(p.p_m[2]), period[2]);
    if (scene.domain.dimensions == 3 && std::fabs(z - (low + high) / 2) > spacing / 2) continue;
    plane.which.push_back(i);
    plane.at.push_back(
        {wrapped(static_cast<double>(p.p_m[0]), period[0]), wrapped(static_cast<double>(p.p_m[1]), period[1])});
  }
  return plane;
}

// Keeps the first particle of every square of this side.
PlaneSection thinned(const PlaneSection& plane, double side_m) {
  std::set<std::pair<std::int64_t, std::int64_t>> taken;
  PlaneSection kept;
  for (std::size_t k = 0; k < plane.which.size(); ++k) {
    const auto column = static_cast<std::int64_t>(std::floor(plane.at[k][0] / side_m));
    const auto row = static_cast<std::int64_t>(std::floor(plane.at[k][1] / side_m));
    if (!taken.emplace(column, row).second) continue;
    kept.which.push_back(plane.which[k]);
    kept.at.push_back(plane.at[k]);
  }
  return kept;
}

// Which quantity's error is drawn, and its size at a particle.
enum class Drawn { none, velocity, temperature, pressure };

Drawn drawn_of(const FieldAtParticles& exact, std::size_t samples, std::size_t particles) {
  if (exact.outcome.status != Status::ok || exact.samples.size() != samples) return Drawn::none;
  const auto& last = exact.samples.back().values;
  if (last.size() != particles) return Drawn::none;
  const bool moves = exact.known.velocity && std::any_of(last.begin(), last.end(), [](const ParticleSample& p) {
                       return metrics::norm(p.v_m_per_s) > 0;
                     });
  return moves                     ? Drawn::velocity
         : exact.known.temperature ? Drawn::temperature
         : exact.known.pressure    ? Drawn::pressure
                                   : Drawn::none;
}

double error_at(Drawn drawn, const ParticleSample& p, const ParticleSample& exact) {
  switch (drawn) {
    case Drawn::velocity: return metrics::distance(p.v_m_per_s, exact.v_m_per_s);
    case Drawn::temperature: return std::fabs(static_cast<double>(p.temperature_K - exact.temperature_K));
    case Drawn::pressure: return std::fabs(static_cast<double>(p.pressure_Pa - exact.pressure_Pa));
    case Drawn::none: break;
  }
  return 0;
}

const char* drawn_words(Drawn drawn) {
  switch (drawn) {
    case Drawn::velocity: return "velocity [m/s]";
    case Drawn::temperature: return "temperature [K]";
    case Drawn::pressure: return "pressure [Pa]";
    case Drawn::none: break;
  }
  return "";
}

}  // namespace

FluidPicture picture_of(const Scenario& scenario, const FieldAtParticles& exact, const Recording& run) {
  FluidPicture picture;
  const Scene& scene = scenario.scene;
  if (run.outcome.status != Status::ok || run.values.empty() || scene.fluids.empty()) return picture;
  const SampleView& last = run.values.back();
  double spacing = 0;
  for (const Fluid& fluid : scene.fluids) spacing = std::max(spacing, fluid.spacing_m);
  PlaneSection plane = plane_of(scene, last, spacing);
  double side = spacing;
  for (const PlaneSection all = plane; plane.which.size() > kMaxDrawn; plane = thinned(all, side)) side *= 1.1;
  const bool heat = std::any_of(scene.fluids.begin(), scene.fluids.end(),
                                [](const Fluid& fluid) { return fluid.heat_capacity_J_per_kg_K > 0; });
  const Drawn drawn = drawn_of(exact, run.values.size(), last.particles.size());
  picture.t_s = static_cast<double>(last.t_s);
  picture.side_m = side;
  picture.particles = static_cast<std::int64_t>(last.particles.size());
  picture.error_of = drawn_words(drawn);
  for (std::size_t k = 0; k < plane.which.size(); ++k) {
    const ParticleSample& p = last.particles[plane.which[k]];
    picture.x_m.push_back(static_cast<float>(plane.at[k][0]));
    picture.y_m.push_back(static_cast<float>(plane.at[k][1]));
    picture.speed_m_per_s.push_back(static_cast<float>(metrics::norm(p.v_m_per_s)));
    picture.pressure_Pa.push_back(static_cast<float>(static_cast<double>(p.pressure_Pa)));
    if (heat) picture.temperature_K.push_back(static_cast<float>(static_cast<double>(p.temperature_K)));
    if (drawn != Drawn::none)
      picture.error.push_back(static_cast<float>(error_at(drawn, p, exact.samples.back().values[plane.which[k]])));
  }
  for (std::size_t i = 0; i < 2; ++i) {
    const double period = scene.domain.periodic_m[i];
    double low = INFINITY, high = -INFINITY;
    for (const auto& at : plane.at) low = std::min(low, at[i]), high = std::max(high, at[i]);
    picture.low_m[i] = period > 0 ? 0 : low - side / 2;
    picture.high_m[i] = period > 0 ? period : high + side / 2;
  }
  return picture;
}

}  // namespace atwood
