// What methods cost beside the rates that they evaluate, measured (validation/metrics/overhead.hpp has the fit).
#pragma once

#include <vector>

#include "validation/metrics/overhead.hpp"
#include "validation/row.hpp"
#include "validation/study/study.hpp"

namespace atwood {

// Of each method with a ladder on a scenario that evaluates the reference's rate, at the rung whose run takes nearest to a
// millisecond; of at most eight. `rows`: those of the cells, with run-time and rate-evaluations. Throws Interrupted.
std::vector<MethodOverhead> measure_overheads(const std::vector<Cell>& cells, const std::vector<Worker>& workers,
                                              const std::vector<Row>& rows, double limit_s);

}  // namespace atwood
