// Measures the cost of methods besides the rates that they evaluate (fitted by validation/metrics/overhead.hpp).
#pragma once

#include <vector>

#include "validation/metrics/overhead.hpp"
#include "validation/row.hpp"
#include "validation/study/study.hpp"

namespace atwood {

// Overheads of the methods with a ladder on a scenario that evaluate the reference's rate, at most eight, each at the
// rung whose run takes nearest to a millisecond. `rows`: those of the cells, with run-time and rate-evaluations. Throws
// Interrupted.
std::vector<MethodOverhead> measure_overheads(const std::vector<Cell>& cells, const std::vector<Worker>& workers,
                                              const std::vector<Row>& rows, double limit_s);

}  // namespace atwood
