// What may be asked of fluids by `compare` and `advise`: which metrics rank methods, and what to ask instead of others.
#pragma once

#include <string>
#include <vector>

#include "reports/command_line/command_line.hpp"
#include "validation/metrics/work_precision.hpp"

namespace atwood {

// The question put to scenes of which some have fluids: the words `velocity` and `energy` of --metric, and an error in
// per cent, mean the fluid's. `who` begins a message: "compare". InputError: scenes with and without fluids together, a
// metric that belongs to bodies, to a whole ladder or to the scene and not to a method, or one of an exact field that
// the scene does not name. Unchanged where no scene has a fluid; InputError there for a metric of fluids.
Question fluid_question(const std::string& who, const Options& options, const Question& asked,
                        const std::vector<const Scenario*>& scenarios);

}  // namespace atwood
