// Of a small run every figure that decides, scenario by scenario and method by method.
#pragma once

#include <string>

#include "palette.hpp"
#include "reports/report.hpp"

namespace atwood {

// Empty where the run has more than 40 pairs of scenario and method, or no rows.
std::string figures_table(const ReportData& data, const Palette& palette, std::size_t room);
std::string refused_words(const RefusedTruth& refused);

}  // namespace atwood
