// The kinds of probes: questions that one run does not answer.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace atwood {

// none: an ordinary cell, one run that is measured.
enum class Probe : unsigned char {
  none,
  ensemble,
  reversal,
  symplecticity,
  lyapunov,
  round_off_v,
  tolerance,
  contact_sweep,
  touch_sweep,
  contact_tables
};

struct ProbeInfo {
  Probe probe;
  std::string name, doc;  // name: as a study's `probe` writes it
};
const std::vector<ProbeInfo>& all_probes();  // in the order of the README's table; without Probe::none

std::string to_string(Probe probe);                        // its name; "" of none
std::optional<Probe> find_probe(const std::string& name);  // empty: there is none of that name

// Sweeps of poses and tables of cases: cells that need a worker's contacts and no run
// (validation/metrics/pose_metrics.hpp).
inline bool is_sweep(Probe probe) {
  return probe == Probe::contact_sweep || probe == Probe::touch_sweep || probe == Probe::contact_tables;
}
// Those that are ladders of ordinary cells: of scalars and compensated summation, and of tolerances.
inline bool is_ladder(Probe probe) { return probe == Probe::tolerance || probe == Probe::round_off_v; }

}  // namespace atwood
