// Solves that ended above their tolerance, as a report tells them.
#pragma once

#include <string>
#include <vector>

#include "validation/row.hpp"

namespace atwood {

// Markdown: for each scenario, method and solver the cell with the largest residual, at most `most` lines, largest
// residual first. Empty: every solve reached its tolerance or round-off.
std::string solvers_section(const std::vector<Row>& rows, std::size_t most);
// One line a solver, for a terminal; empty as above.
std::string unconverged_words(const std::vector<Row>& rows);

}  // namespace atwood
