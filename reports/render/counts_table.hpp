// Cells and gates by scene, in reports of so many cells that only some ladders are shown.
#pragma once

#include <string>

#include "reports/report.hpp"
#include "text.hpp"

namespace atwood {

JudgementCounts count(const ReportData& data);        // of all gates, also those whose verdicts are not shown
std::string counts_html(const ReportData& data);      // a section; empty: all ladders are shown
std::string counts_markdown(const ReportData& data);  // a section with its heading; empty as above

}  // namespace atwood
