// The kinds of probes: figures that need several runs.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace atwood {

// none: an ordinary cell, whose single run is measured.
enum class Probe : unsigned char {
  none,
  ensemble,
  reversal,
  symplecticity,
  lyapunov,
  determinism,
  round_off_v,
  tolerance,
  contact_sweep,
  touch_sweep,
  contact_tables
};

struct ProbeInfo {
  Probe probe;
  std::string name, doc;  // name: the value of `probe` in a study
};
const std::vector<ProbeInfo>& all_probes();  // in the order of docs/gates.md, "Probes"; without Probe::none

std::string to_string(Probe probe);                        // its name; "" of none
std::optional<Probe> find_probe(const std::string& name);  // empty: unknown name

// Sweeps of poses and tables of cases: cells that query contacts and run nothing
// (validation/metrics/pose_metrics.hpp).
inline bool is_sweep(Probe probe) {
  return probe == Probe::contact_sweep || probe == Probe::touch_sweep || probe == Probe::contact_tables;
}
// Probes that are ladders of ordinary cells: of scalars and compensated summation, and of tolerances.
inline bool is_ladder(Probe probe) { return probe == Probe::tolerance || probe == Probe::round_off_v; }

}  // namespace atwood
