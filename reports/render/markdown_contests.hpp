// Sections of the Markdown report about which method is cheapest, which most accurate, and which goals are reached.
#pragma once

#include <string>

#include "reports/report.hpp"

namespace atwood {

std::string dominance_section(const std::vector<Dominance>& tables);  // empty when there are none
std::string goals_section(const std::vector<GoalResult>& goals);

}  // namespace atwood
