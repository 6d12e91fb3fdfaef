// Whose right-hand side a method evaluates. Natively our methods evaluate the engine's own and a library's the reference's,
// so that a ratio of times compares the two as much as the methods. At the same rate ours run as `atwood-same-rate/...`
// (benchmarks/same_rate) and evaluate the reference's too.
#pragma once

#include <string>

namespace atwood {

inline constexpr const char* kSameRateEngine = "atwood-same-rate";

// odeint, ARKODE, CVODE and IDA: methods without a right-hand side of their own.
bool is_library(const std::string& engine);
// A method of a library or of the same-rate worker.
bool runs_at_reference_rate(const std::string& method);

}  // namespace atwood
