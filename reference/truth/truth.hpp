// The truth of a scenario of any kind, for the worker, the tests and the study.
#pragma once

#include <cstdint>
#include <string>

#include "protocol/truth.hpp"
#include "scene/scene.hpp"

namespace atwood {

// Dispatches on scenario.truth.kind. Never throws on a scenario: Truth::outcome says what is missing or not covered.
Truth solve_truth(const Scenario& scenario, std::int64_t samples);

// Published values (kind = "values") from a CSV file. The first line that is not a comment names the columns:
//
//   # source: IVP Test Set, release 2.4, Pleiades          (the first such comment becomes Truth::source)
//   t_s,body,px_m,...,vz_m_per_s,px_m_bar,...
//   3,star-1,0.3706139143970502,...
//
// Columns are those of `atwood trace` (px_m ... wz_rad_per_s), each with its `_bar`; further columns are ignored.
// Values without a column are constant, the scene's initial values, with bar 0. Every mobile body needs a row at every
// sample time t_end k / samples (to 1e-12 of t_end) except t = 0, which is the initial state; further rows are ignored.
Truth values_truth(const Scenario& scenario, std::int64_t samples);

}  // namespace atwood
