// Probes: questions that one run does not answer, asked by running a scene again with its initial state changed. A
// probe needs the worker protocol alone, so it works for every engine.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "validation/metrics/metrics.hpp"
#include "validation/metrics/probe.hpp"

namespace atwood {

// What a probe asks about, and how it gets a run.
struct ProbeRequest {
  const Scenario& scenario;
  std::string method;
  Plan plan;
  const Truth& truth;
  std::function<Recording(const std::string& method, const Scene& scene, const Plan& plan)> run;
};

// The rows of ensemble, reversal, symplecticity or lyapunov for one cell; fields as `measure` fills them. Where the probe
// does not apply or a run fails, one row of its first metric with that status and the reason. std::logic_error of others.
std::vector<Row> run_probe(Probe probe, const ProbeRequest& request);

}  // namespace atwood
