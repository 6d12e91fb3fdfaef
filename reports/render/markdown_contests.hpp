// Sections of the Markdown report about who is cheapest, most accurate, and what of the goals is reached.
#pragma once

#include <string>

#include "reports/report.hpp"

namespace atwood {

std::string dominance_section(const std::vector<Dominance>& tables);  // empty when there are none
std::string goals_section(const std::vector<GoalResult>& goals);

}  // namespace atwood
