// Times of engines that run as WebAssembly: a table of their own, apart from those of native engines.
#pragma once

#include <vector>

#include "benchmarks/figures.hpp"
#include "validation/row.hpp"

namespace atwood {

// A line a scenario and method, at the most steps that were timed, in the order of the rows: the time of a step and
// what of it a world without bodies takes. Empty: no such times.
std::vector<BenchTable> wasm_tables(const std::vector<Row>& rows);

}  // namespace atwood
