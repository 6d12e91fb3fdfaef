// Probes: questions that one run does not answer, asked by running a scene again with its initial state changed. A
// probe needs the worker protocol alone, so it works for every engine.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "validation/metrics/metrics.hpp"

namespace atwood {

struct ProbeInfo {
  std::string name, doc;
};
const std::vector<ProbeInfo>& all_probes();  // in the order of the README's table

// Sweeps of poses and tables of cases: cells that need a worker's contacts and no run
// (validation/metrics/pose_metrics.hpp).
inline bool is_sweep(const std::string& probe) {
  return probe == "contact-sweep" || probe == "touch-sweep" || probe == "contact-tables";
}

// What a probe asks about, and how it gets a run.
struct ProbeRequest {
  const Scenario& scenario;
  std::string method;
  Plan plan;
  const Truth& truth;
  std::function<Recording(const std::string& method, const Scene& scene, const Plan& plan)> run;
};

// The rows of "ensemble", "reversal", "symplecticity" or "lyapunov" for one cell; fields as `measure` fills them. Where
// it cannot be asked or a run fails, one row of the probe's first metric with that status and the reason.
std::vector<Row> run_probe(const std::string& probe, const ProbeRequest& request);

}  // namespace atwood
