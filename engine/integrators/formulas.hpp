// What each method computes, as formulas in plain text: the last part of its documentation.
#pragma once

#include <string>

namespace atwood {

// Of a scheme ("rk4") of the catalogue; throws std::logic_error where there is none.
std::string formula_of(const std::string& scheme);

// A method's documentation with its formula, as the manual's pages expect it.
std::string with_formula(const std::string& doc, const std::string& formula);

}  // namespace atwood
