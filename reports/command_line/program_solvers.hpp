// The library's part of an evidence program: how ARKODE and odeint are called. Private to program.cpp.
#pragma once

#include <string>

#include "protocol/method.hpp"

namespace atwood {

// Texts of the program: how it is compiled, its includes, its function `solve`, and where the claimed order comes from.
struct Solver {
  std::string compile, includes, solve, claimed;
};
Solver arkode(const MethodInfo& info, bool tolerance);
Solver odeint(const MethodId& id, const MethodInfo& info);  // InputError: of a method that chooses its steps

std::string setting(const MethodInfo& info, const std::string& name);  // a word; empty: there is none of that name
std::string replaced(std::string text, const std::string& from, const std::string& to);  // everywhere

}  // namespace atwood
