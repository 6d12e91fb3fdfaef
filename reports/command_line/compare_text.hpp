// What `compare` prints: plot, rungs, which method is cheapest, what a budget buys, which steps are stable.
#pragma once

#include <string>

#include "reports/report.hpp"

namespace atwood {

std::string compare_text(const ReportData& data, const Scenario& scenario, const Question& question, int width);

}  // namespace atwood
