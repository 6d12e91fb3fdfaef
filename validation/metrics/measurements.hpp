// The families of metrics behind `measure`, one .cpp each. Private to this room.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "validation/metrics/instants.hpp"
#include "validation/metrics/metrics.hpp"

namespace atwood::dynamics {
template <class S> class Dynamics;
}

namespace atwood::metrics {

// A whole-run row; the unit comes from the catalogue of metrics (throws std::logic_error for an unknown name).
Row row(const std::string& metric, double value, double bar = 0, std::string reason = "");

// Euclidean norm of a - b, subtracted in Wide, then rounded to double.
double distance(const std::array<Wide, 3>& a, const std::array<Wide, 3>& b);
double norm(const std::array<Wide, 3>& a);

// The largest of several figures e with bars b. The true maximum lies in [max(e - b), max(e + b)]; bar() is the
// distance from the largest e to max(e + b), which may come from another figure.
struct Largest {
  std::vector<std::pair<double, double>> figures;
  void take(double e, double b) { figures.emplace_back(e, b); }
  double value() const {
    double largest = 0;
    for (const auto& [e, b] : figures) largest = std::max(largest, e);
    return largest;
  }
  double bar() const {
    const double largest = value();
    double excess = 0;
    for (const auto& [e, b] : figures) excess = std::max(excess, b - (largest - e));
    return excess;
  }
};

// A "status" row with the reason where the recording cannot be measured (number of samples differs from the truth's,
// values are not finite, ...); no row where it can.
std::vector<Row> status_rows(const Scenario& scenario, const Truth& truth, const Recording& run);

// Whether the truth has samples to compare with.
bool has_truth(const Truth& truth);
// Predictability horizon of a scene tagged "chaotic": the time at which twins that start 1e-10 of the scale apart are
// 1e-3 apart, by the reference's equations. t_end for other scenes.
double state_horizon_s(const Scenario& scenario, const Truth& truth);
// error-position-*, error-velocity-*, ...: of bodies, or of the unknowns of a bare problem.
void append_state_errors(const Scenario& scenario, const Observed& all, std::vector<Row>& rows);
// quaternion-norm-drift; needs no truth.
void append_norm_drift(const Scenario& scenario, const Recording& run, std::vector<Row>& rows);
// Largest sizes of the truth's quantities, by which relative errors are divided.
void append_sizes(const Scenario& scenario, const Truth& truth, std::vector<Row>& rows);
// Energy, momenta and their drifts. `all`: for energy.
void append_conservation(const Scenario& scenario, const Truth& truth, const Recording& run, const Observed& all,
                         std::vector<Row>& rows);
// joint-gap, joint-tilt, error-joint-*, error-reaction-*; none for a scene without joints and ropes.
void append_joints(const Scenario& scenario, const Truth& truth, const Recording& run, const Observed& all,
                   std::vector<Row>& rows);
// Times, impulses and points of impacts; none without contacts.
void append_contact(const Scenario& scenario, const Truth& truth, const Recording& run, std::vector<Row>& rows);
// Complementarity and friction of the reported contact forces; needs no truth.
void append_contact_forces(const Scenario& scenario, const Recording& run, std::vector<Row>& rows);
// The deepest overlap of the samples.
void append_penetration(const Scene& scene, const Recording& run, std::vector<Row>& rows);
// Position and velocity where a body lands.
void append_landing(const Scenario& scenario, const Truth& truth, const Recording& run, std::vector<Row>& rows);
// solver-* rows, also for a run that ended early. None for a run that reports no solver.
void append_solver_figures(const Recording& run, std::vector<Row>& rows);
// Errors below 30 of these are dominated by the truth's bar or by round-off and show no law. Energy is relative to
// energy_scale().
struct GrowthFloors {
  double position_m = 0, attitude_rad = 0, energy = 0;
};
// The errors at the judged instants, and at t = 0; the scale of the energy is by the truth.
Series judged_series(const Scenario& scenario, const Truth& truth, const Observed& all);
// The laws by which the errors of a series grow.
void append_growth(const Series& series, const GrowthFloors& floors, std::vector<Row>& rows);

// Max of kinetic + |V - V0| over the truth's samples, or over a run of the reference whose energy has converged under
// refinement (smooth scenes of moderate size), without a truth or where that run has over 1 % more between the samples.
// Else, and where the samples show only the energy's round-off, `joules` is 0 and energies stay in joules.
struct EnergyScale {
  double joules = 0;
  std::string source;
};
EnergyScale energy_scale(const Scenario& scenario, const Truth& truth);
// One step of classical RK4 over the reference's own rates, with the force of its own interval; `work`: five vectors of
// y's size.
void reference_step(const dynamics::Dynamics<double>& f, double t, double h, std::vector<double>& y,
                    std::array<std::vector<double>, 5>& work);
// Kinetic and potential energy of the bodies [J], one entry a sample; not of a bare problem.
std::vector<Wide> mechanical_energy(const Scene& scene, const Recording& run);
bool declares_energy(const Scenario& scenario);  // among its invariants, or the Jacobi constant
// (E - E0) over the scale, or in joules where there is none; one entry per sample. Empty for a bare problem and where
// the scenario declares neither energy nor the Jacobi constant.
std::vector<double> energy_change(const Scenario& scenario, const Recording& run, const EnergyScale& scale);

// The unit round-off of the narrowest of float, double, long double and quad that represents all recorded values
// exactly: engines widen without loss, so this is the scalar in which they computed.
double recorded_unit_round_off(const Scene& scene, const Recording& run);
// u sqrt(steps) of a run; steps as the run reports them, at least its samples.
double relative_floor(const Scene& scene, const Recording& run);
// The round-off of energy_change, in its unit: relative_floor, times the run's largest energy where there is no scale.
double energy_floor(const Scenario& scenario, const Recording& run, const EnergyScale& scale);

}  // namespace atwood::metrics
