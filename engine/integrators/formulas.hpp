// What each method computes, as formulas in plain text.
#pragma once

#include <string>

namespace atwood {

// Of a scheme ("rk4") of the catalogue, one equation a line; throws std::logic_error where there is none.
std::string formula_of(const std::string& scheme);

}  // namespace atwood
