// Probes: figures from several runs of a scene with changed initial states. A probe uses only the worker protocol, so
// it works for every engine; `ensemble` needs the method in wider arithmetic as well.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "validation/metrics/metrics.hpp"
#include "validation/metrics/probe.hpp"

namespace atwood {

// The cell that a probe measures, and the function that makes a run.
struct ProbeRequest {
  const Scenario& scenario;
  std::string method;
  Plan plan;
  const Truth& truth;
  std::function<Recording(const std::string& method, const Scene& scene, const Plan& plan)> run;
};

// The rows of ensemble, reversal, symplecticity, lyapunov or determinism for one cell; fields as `measure` fills them.
// Where the probe does not apply or a run fails, one row of its first metric with that status and the reason.
// std::logic_error for other probes.
std::vector<Row> run_probe(Probe probe, const ProbeRequest& request);

}  // namespace atwood
