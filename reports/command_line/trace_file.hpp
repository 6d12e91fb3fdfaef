// A trace that any program recorded, as CSV with the columns of `atwood trace`.
#pragma once

#include <string>
#include <vector>

#include "scene/scene.hpp"
#include "validation/row.hpp"

namespace atwood {

struct Trace {
  std::vector<std::string> columns;  // as the header names them
  Recording run;
};

// Throws InputError with line and column. Every body that moves has a row at every instant, and instants are equally
// spaced from 0 on, as the truth's are. `path` stands for the file in messages.
Trace read_trace(std::string text, const std::string& path, const Scene& scene);

}  // namespace atwood
