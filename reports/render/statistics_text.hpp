// Statistics of a study as words: what takes several runs to tell, each figure beside its definition.
#pragma once

#include <string>
#include <vector>

#include "validation/row.hpp"

namespace atwood {

std::string statistics_section(const std::vector<Row>& rows);  // Markdown; empty when there are none

}  // namespace atwood
