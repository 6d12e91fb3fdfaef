// Work of the terms of +sph that give or take energy, from the samples of a run.
#include <algorithm>
#include <array>
#include <cmath>

#include "fluid_truth/powers.hpp"
#include "validation/metrics/fluid_parts.hpp"
#include "validation/metrics/measurements.hpp"

namespace atwood {
namespace {

constexpr std::size_t kMaxParticlesOfWork = 50'000;
constexpr std::size_t kMinSamplesOfWork = 9;  // of fewer, every second one is too coarse a check of the integral
constexpr double kRoundOff = 1e-14;           // of the scale
constexpr double kUnresolved = 0.2;           // of the works: what is left of a motion that the samples resolve

struct Term {
  const char* metric;
  double FluidPowers::*power;
};
constexpr std::array<Term, 6> kTerms{{{"work-by-diffusion", &FluidPowers::diffusion},
                                      {"work-by-shift", &FluidPowers::shift},
                                      {"work-by-viscosity", &FluidPowers::viscosity},
                                      {"work-by-bodies", &FluidPowers::bodies},
                                      {"work-by-walls", &FluidPowers::walls},
                                      {"work-by-sources", &FluidPowers::sources}}};

}  // namespace

namespace {

// Simpson's rule over an even number of intervals; of an odd number, from 3 on, its 3/8 rule takes the last three.
Integral by_both_rules(const std::vector<double>& values, double h) {
  Integral made;
  const std::size_t intervals = values.empty() ? 0 : values.size() - 1;
  for (std::size_t k = 0; k < intervals; ++k) made.trapezoid += h * (values[k] + values[k + 1]) / 2;
  if (intervals < 2) return {made.trapezoid, made.trapezoid, 0};
  const std::size_t by_thirds = intervals % 2 == 0 ? intervals : intervals - 3;
  for (std::size_t k = 0; k < by_thirds; k += 2)
    made.simpson += h * (values[k] + 4 * values[k + 1] + values[k + 2]) / 3;
  if (const std::size_t k = by_thirds; k < intervals)
    made.simpson += 3 * h * (values[k] + 3 * (values[k + 1] + values[k + 2]) + values[k + 3]) / 8;
  return made;
}

}  // namespace

Integral integral_of(const std::vector<double>& values, double h) {
  Integral made = by_both_rules(values, h);
  std::vector<double> even(values.begin(),
                           values.end() - static_cast<std::ptrdiff_t>(values.size() % 2 == 0 && !values.empty()));
  const double fine = by_both_rules(even, h).simpson;
  std::vector<double> coarse;
  for (std::size_t k = 0; k < even.size(); k += 2) coarse.push_back(even[k]);
  made.bar = std::max(std::fabs(made.simpson - made.trapezoid), std::fabs(fine - by_both_rules(coarse, 2 * h).simpson));
  return made;
}

std::vector<Row> fluid_work_rows(const Scene& scene, const Recording& run, const std::string& response) {
  if (run.outcome.status != Status::ok || run.values.size() < kMinSamplesOfWork) return {};
  const std::size_t count = run.values.front().particles.size();
  if (count != fluid_of_particles(scene).size() || count > kMaxParticlesOfWork) return {};
  const FluidPowersOf powers(scene, response);
  if (!powers.unsupported().empty()) return {};
  const std::vector<metrics::FluidEnergies> energies = metrics::fluid_energies(scene, run.values);
  const Wide scale = metrics::fluid_energy_scale(energies);
  if (!(scale > 0)) return {};
  std::array<std::vector<double>, kTerms.size() + 1> of;  // the last: their sum
  for (const SampleView sample : run.values) {
    const FluidPowers now = powers.at(static_cast<double>(sample.t_s), sample.particles, sample.bodies);
    double sum = 0;
    for (std::size_t k = 0; k < kTerms.size(); ++k) {
      of[k].push_back(now.*kTerms[k].power);
      sum += of[k].back();
    }
    of.back().push_back(sum);
  }
  const double h = static_cast<double>(run.values[1].t_s - run.values[0].t_s), unit = static_cast<double>(scale);
  const std::string over = "of " + format_measure(unit, 0) + " J; ",
                    samples = std::to_string(run.values.size()) + " samples";
  const Integral whole = integral_of(of.back(), h);
  const double change = static_cast<double>(energies.back().total() - energies.front().total());
  const double left = std::fabs(change - whole.simpson);
  std::vector<Row> rows;
  double works = 0;  // sum of their sizes
  for (std::size_t k = 0; k < kTerms.size(); ++k) {
    const Integral work = integral_of(of[k], h);
    // A term that the method or the scene does not have, or viscosity all of which becomes heat.
    if (std::fabs(work.simpson) < kRoundOff * unit && std::fabs(work.trapezoid) < kRoundOff * unit) continue;
    works += std::fabs(work.simpson);
    rows.push_back(metrics::row(kTerms[k].metric, work.simpson / unit, std::max(work.bar, left) / unit,
                                over + "powers of " + samples + ", integrated by Simpson's rule"));
  }
  if (rows.empty()) return rows;
  const bool resolved = left <= kUnresolved * works;
  if (!resolved) rows.clear();
  rows.push_back(metrics::row("energy-unaccounted", left / unit, whole.bar / unit,
                              over + "energy changed by " + format_measure(change, 0) + " J, work is " +
                                  format_measure(whole.simpson, 0) + " J" +
                                  (resolved ? ""
                                            : "; " + samples +
                                                  " do not resolve the motion, so that rows of work "
                                                  "are left out")));
  return rows;
}

}  // namespace atwood
