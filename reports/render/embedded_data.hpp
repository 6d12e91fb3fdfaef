// The data inside the HTML report: columns and string tables, thinned until they fit.
#pragma once

#include <string>

#include "reports/report.hpp"

namespace atwood {

// How much detail goes along. Rows lose digits and series lose rungs and points before any row is lost; what was left
// out is said in the report, and the CSV has it all.
struct Detail {
  int value_digits = 6;
  std::size_t series_rungs = 3;  // per scenario x method
  std::size_t series_points = 129;
  bool rms_and_timed_rows = true;      // *-rms rows and rows at one instant
  std::size_t ranks = 8;               // of those who compete for an error or a budget
  std::size_t drawn_particles = 2500;  // of a fluid's picture
};

std::string embedded_json(const ReportData& data, const Detail& detail);

// The first of a fixed list of details whose compressed, base64-coded JSON has at most `limit` bytes; the last one when
// none does.
std::string embedded_data(const ReportData& data, std::size_t limit);

}  // namespace atwood
