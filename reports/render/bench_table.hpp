// Tables of measured figures, in Markdown and JSON; a terminal's is render_bench_table in reports/report.hpp.
#pragma once

#include <string>
#include <vector>

#include "json_text.hpp"
#include "reports/report.hpp"

namespace atwood {

std::string tables_section(const std::vector<BenchTable>& tables);  // empty when there are none
void append_tables(JsonText& json, const std::vector<BenchTable>& tables);

}  // namespace atwood
