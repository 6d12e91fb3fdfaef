// One measured figure. The columns are a published contract (see README, "Rows").
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "protocol/sample.hpp"

namespace atwood {

// Where a figure came from: everything that could change it and is not in the cell itself.
struct Provenance {
  std::string engine_version, commit, compiler, flags, cpu, run_id;
  std::string cpu_features = {};  // those that choose among variants of the same code: "avx2 fma avx512f ..."
  std::string libm = {};          // "glibc 2.36": its functions differ in the last place between versions
};

struct Row {
  std::string scenario, method;  // method as written in the study, suffixes included
  std::int64_t steps = 0;        // 0 for figures of a whole ladder (orders)
  double h_s = 0;
  std::optional<double> spacing_m, sound_speed_m_per_s;  // of particles; empty: the scene has none
  std::string body;                                      // empty: whole run
  std::optional<double> t_s;                             // empty: whole run
  std::string metric, unit;
  double value = 0;
  double truth_bar = 0;
  Status status = Status::ok;
  std::string reason;
  std::string settings_hash;
  Provenance provenance;
};

// A run as it was recorded: what metrics see. `values` has samples + 1 entries, or fewer when it ended early.
struct Recording {
  std::vector<Sample> values;
  std::vector<Event> events;
  Outcome outcome;
};

}  // namespace atwood
