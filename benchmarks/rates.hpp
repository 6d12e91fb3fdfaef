// The right-hand side that a method evaluates. Natively our methods evaluate the engine's, libraries the reference's,
// so that a ratio of times compares right-hand sides as well as methods. At the same rate our methods run as
// `atwood-same-rate/...` (benchmarks/same_rate) and evaluate the reference's too.
#pragma once

#include <string>

namespace atwood {

inline constexpr const char* kSameRateEngine = "atwood-same-rate";

// odeint, ARKODE, CVODE and IDA: methods without a right-hand side of their own.
bool is_library(const std::string& engine);
// A method of a library or of the same-rate worker.
bool runs_at_reference_rate(const std::string& method);

}  // namespace atwood
