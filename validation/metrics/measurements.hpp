// The families of metrics behind `measure`, one .cpp each. Private to this room.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "validation/metrics/metrics.hpp"

namespace atwood::metrics {

// A whole-run row; the unit comes from the catalogue of metrics (throws std::logic_error on a name that is not there).
Row row(const std::string& metric, double value, double bar = 0, std::string reason = "");

// Euclidean norm of a - b, subtracted wide, then narrowed.
double distance(const std::array<Wide, 3>& a, const std::array<Wide, 3>& b);
double norm(const std::array<Wide, 3>& a);

// The largest of several figures e, each known to within its bar b. It lies somewhere in [max(e - b), max(e + b)], and
// what reaches highest need not be the figure that is largest: bar() is the distance from the largest to max(e + b),
// which is the further end, for the largest has a bar too.
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
    double reach = 0;
    for (const auto& [e, b] : figures) reach = std::max(reach, b - (largest - e));
    return reach;
  }
};

// Why the recording can't be measured (not as many samples as the truth, a number that is not finite, ...) as a
// "status" row; no row when it can.
std::vector<Row> status_rows(const Scenario& scenario, const Truth& truth, const Recording& run);

bool has_truth(const Truth& truth);
// Until when a state of a scene tagged "chaotic" can be foretold: twins 1e-10 of the scale apart are 1e-3 apart, by the
// reference's own equations. t_end for other scenes.
double state_horizon_s(const Scenario& scenario, const Truth& truth);
void append_state_errors(const Scenario& scenario, const Truth& truth, const Recording& run, std::vector<Row>& rows);
void append_sizes(const Scenario& scenario, const Truth& truth, std::vector<Row>& rows);
void append_conservation(const Scenario& scenario, const Recording& run, std::vector<Row>& rows);
void append_contact(const Scenario& scenario, const Truth& truth, const Recording& run, std::vector<Row>& rows);
void append_contact_forces(const Scenario& scenario, const Recording& run, std::vector<Row>& rows);
void append_penetration(const Scene& scene, const Recording& run, std::vector<Row>& rows);
void append_landing(const Scenario& scenario, const Truth& truth, const Recording& run, std::vector<Row>& rows);
void append_growth(const Series& series, double truth_bar_m, std::vector<Row>& rows);

// (E - E0) / max over the run of (kinetic + |V - V0|), one entry a sample; empty for a bare problem.
std::vector<double> relative_energy(const Scenario& scenario, const Recording& run);

}  // namespace atwood::metrics
