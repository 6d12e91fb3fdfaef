// Fluids: what each method loses to the Mach number, to space and to time, at each resolution.
#pragma once

#include <string>
#include <vector>

#include "validation/row.hpp"

namespace atwood {

// A line a scenario, method, spacing and sound speed, at its finest steps; the figures are words ("1.2e-3", "-").
// Scenarios with a line whose parts were all measured come first, else the order of the rows.
struct FluidLine {
  std::string scenario, method, spacing, sound_speed, steps, total, model, space, time, orders, kept;
  bool in_parts = false;  // model, space and time were all measured
};
std::vector<FluidLine> fluid_lines(const std::vector<Row>& rows);

std::string fluid_text(const std::vector<Row>& rows);      // for a terminal; empty: no fluid
std::string fluid_markdown(const std::vector<Row>& rows);  // a section with its heading; empty: no fluid
std::string fluid_html(const std::vector<Row>& rows);      // a section; empty: no fluid

}  // namespace atwood
