// Checks of kernels against scenes with fluids, before any cell starts.
#pragma once

#include <string>
#include <vector>

#include "validation/study/study.hpp"

namespace atwood {

// InputError with the figures for a response of our own engine (+sph, +polynomial) that a scene with fluids does not
// admit: a kernel whose support is more than half a period of the domain, and degree 4 with a free surface. A support
// that is too wide at one spacing is an error of the call; of cells that a glob gave, and of degrees, only where the
// method fits none of its scenes. `who` begins the message: "--method ".
void check_fluids(const std::string& who, const std::vector<Cell>& cells, const std::vector<Worker>& workers);
void check_fluids(const std::string& who, const std::string& method, const Worker& worker, const Scenario& scenario);

}  // namespace atwood
