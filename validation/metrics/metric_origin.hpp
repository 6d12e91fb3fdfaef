// The formula of each metric and where it comes from, beside the definition in words (metrics.hpp).
#pragma once

#include <string>

namespace atwood {

struct MetricOrigin {
  std::string formula, source;  // plain text; source: a paper or book, or "here" where the project defines it
};

// Throws std::logic_error for a name without an entry. `status` and `truth` are not figures: both texts are empty.
MetricOrigin origin_of(const std::string& metric);

}  // namespace atwood
