// The families of metrics behind measure_fluid(), one .cpp each. Private to this room.
#pragma once

#include "validation/metrics/fluid.hpp"
#include "validation/metrics/metrics.hpp"

namespace atwood {

std::vector<MetricInfo> fluid_metrics();  // part of all_metrics()

}  // namespace atwood

namespace atwood::metrics {

// Why the recording cannot be measured, as a "status" row: it did not end well, samples are missing, a number is not
// finite (which particle of which fluid, when).
std::vector<Row> fluid_status_rows(const Scenario& scenario, const Recording& run);

// time-error of scenes whose truth is the particles' own equations and names no field: of positions and velocities.
void append_semi_discrete(const Truth& truth, const Recording& run, const std::vector<double>& masses,
                          std::vector<Row>& rows);

// Energies of a fluid [J], in two dimensions per metre of depth.
struct FluidEnergies {
  Wide kinetic = 0, elastic = 0, potential = 0, heat = 0;
  Wide total() const { return kinetic + elastic + potential + heat; }
};
std::vector<FluidEnergies> fluid_energies(const Scene& scene, const SampleSeries& samples);
// What changes of the energy are divided by: the largest kinetic energy and change of potential and elastic energy.
Wide fluid_energy_scale(const std::vector<FluidEnergies>& energies);

// kinetic-energy-error against the exact field, energy-budget, volume-error.
void append_fluid_energy(const Scenario& scenario, const FieldAtParticles& exact, const Recording& run,
                         std::vector<Row>& rows);
// fluid-momentum-error, fluid-angular-momentum-error.
void append_fluid_momenta(const Scenario& scenario, const Recording& run, std::vector<Row>& rows);
// particle-order, spacing-min, speed-max.
void append_fluid_order(const Scenario& scenario, const Recording& run, std::vector<Row>& rows);
// velocity-grid-l1 and the other norms on comparison_grid(), at the end.
void append_grid_norms(const Scenario& scenario, const FluidTruths& truths, const Recording& run,
                       std::vector<Row>& rows);
// front-error and probe-error, where the truth knows the probe.
void append_probes(const Scenario& scenario, const FieldAtParticles& exact, const Recording& run,
                   std::vector<Row>& rows);

}  // namespace atwood::metrics
