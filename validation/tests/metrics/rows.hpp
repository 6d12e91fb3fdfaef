// Reading one figure out of rows.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "validation/row.hpp"

namespace atwood::testing {

// -999: there is no such row.
inline double value_of(const std::vector<Row>& rows, const std::string& metric) {
  const auto found = std::find_if(rows.begin(), rows.end(), [&](const Row& r) { return r.metric == metric; });
  return found == rows.end() ? -999 : found->value;
}

}  // namespace atwood::testing
