// The mass matrix of a tree by composite rigid bodies (Walker and Orin, J. Dyn. Syst. Meas. Control 104 (1982) 205;
// Featherstone 2008, chapter 6).
#pragma once

#include <vector>

#include "joints/tree.hpp"

namespace atwood {

// M of twice the kinetic energy u^T M u, in the order of generalised vectors (joints/tree.hpp), at the tree's last
// kinematics(): rate_count() rows of as many entries, symmetric. Rates of driven joints and held bodies have their rows
// like all others. O(links times depth).
template <class S> std::vector<S> mass_matrix(const Tree<S>& tree);

}  // namespace atwood
