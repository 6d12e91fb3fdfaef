// One measured figure. The columns are a published contract (`atwood schema rows`).
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "protocol/sample_series.hpp"

namespace atwood {

// Where a figure came from: everything that could change it and is not in the cell itself.
struct Provenance {
  std::string engine_version, commit, compiler, flags, cpu, run_id;
  std::string cpu_features = {};  // those that choose among variants of the same code: "avx2 fma avx512f ..."
  std::string libm = {};          // "glibc 2.36": its functions differ in the last place between versions
  std::string host = {};          // that measured a time; empty: of other figures, or not recorded
};

// A provenance that many rows have: a copy shares it.
class SharedProvenance {
 public:
  SharedProvenance() = default;  // all fields empty
  SharedProvenance(Provenance provenance) : shared_(std::make_shared<const Provenance>(std::move(provenance))) {}
  const Provenance& operator*() const {
    static const Provenance empty;
    return shared_ ? *shared_ : empty;
  }
  const Provenance* operator->() const { return &**this; }

 private:
  std::shared_ptr<const Provenance> shared_;
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
  SharedProvenance provenance;
};

// What tells the runs of a scene with fluids by one method apart, beside the steps: spacing and sound speed.
using Resolution = std::pair<std::optional<double>, std::optional<double>>;
inline Resolution resolution_of(const Row& row) { return {row.spacing_m, row.sound_speed_m_per_s}; }
// "dx=0.02,c=20"; empty: the scene has no fluid.
inline std::string resolution_text(const Resolution& at) {
  std::string text;
  if (at.first) text += "dx=" + format_double(*at.first);
  if (at.second) text += (text.empty() ? "c=" : ",c=") + format_double(*at.second);
  return text;
}

// A run as it was recorded: what metrics see. `values` has samples + 1 entries, or fewer when it ended early.
struct Recording {
  SampleSeries values;
  std::vector<Event> events;
  Outcome outcome;
  // Further instants at which errors, drift and growth are judged (metrics/instants.hpp), and how many samples the run
  // was asked for: the instants are among them. Empty and 0: the samples alone.
  SampleSeries between = {};
  std::int64_t shared = 0;
};

}  // namespace atwood
