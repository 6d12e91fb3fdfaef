// One run of one method, outside any study: what `trace` and `play` share.
#pragma once

#include <string>
#include <vector>

#include "reports/command_line/command_line.hpp"

namespace atwood {

// The available worker of this method. InputError: not one method's id, or no engine provides it.
const Worker& worker_of(const std::vector<Worker>& workers, const std::string& method);

// The scenario at the spacing and the sound speed of the options; its steps grow as those of a run do. InputError: more
// than one of each, or not above 0. For scenes with fluids.
void refine(const Options& options, Scenario& scenario);

// The method's run of the scenario with `scenario.samples` samples. `unsupported` where the engine lacks fluids or
// joints; `not finite` where a value is.
Recording recorded(const Worker& worker, const std::string& method, const Scenario& scenario, std::int64_t steps,
                   double limit_s);

// Says how a run ended that did not reach its end. Its motion, if any, is not what was asked for: never exit_pass.
int status_exit(const Outcome& outcome);

}  // namespace atwood
