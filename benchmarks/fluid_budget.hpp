// The largest block of fluid that each engine steps within a frame of 16.7 ms and of 40 ms.
#pragma once

#include "benchmarks/figures.hpp"
#include "benchmarks/frame_budget.hpp"

namespace atwood {

// Whether a method steps fluids: it has a response of ours for fluids, or is of another engine that simulates them.
bool steps_fluids(const std::string& method, const std::vector<Worker>& workers);

// The table `fluid-budget`, of setup.methods (those that step fluids) or of ours and every other engine with fluids.
// `interrupted`: the rows measured until then. No row: no engine here simulates fluids, or none of these methods does.
FrameBudgetTables measure_fluid_budget(const FrameBudgetSetup& setup);

}  // namespace atwood
