// What `compare` and `advise` share: the ladders that methods run on a scene, and who wins on them. The judgement
// itself is in validation/metrics/work_precision.
#pragma once

#include <string>
#include <vector>

#include "benchmarks/turn_times.hpp"
#include "reports/command_line/command_line.hpp"
#include "validation/metrics/work_precision.hpp"

namespace atwood {

// A method that takes a tolerance was run both ways. A half that it refuses is not its failure, and where equal steps
// change nothing (it chooses its own, at a tolerance of its own) they are not a ladder: the other half stands for it.
// `asked`: ids that were named as they are; `notes` gets a sentence on each method whose half was left out.
std::vector<Row> without_idle_halves(const std::vector<Row>& rows, const std::vector<std::string>& asked,
                                     std::vector<std::string>& notes);

// The margin of what was reached, in words, and what the finer rungs say against it.
std::string caution_words(const Reached& reached, double wanted);

// Why no ranking by time has a method whose curve is `under_wasm`.
inline constexpr const char* kUnrankedUnderWasm =
    "timed only under WebAssembly: such times are not ranked with those of native engines "
    "(docs/engines-under-node.md)";
// The sentence on the methods that were timed so; empty where there is none.
std::string under_wasm_note(const std::vector<Row>& rows);

}  // namespace atwood
