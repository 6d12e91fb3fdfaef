// Compositions of kicks and drifts as data: the fractions of the step that each method takes, in order.
//
// A kick K changes velocities by forces at fixed positions, a drift D moves bodies freely. With chi_h = D_h K_h (K
// first) of order 1 and its adjoint chi*_h = K*_h D*_h, every method here is
//   ... chi*_{c4 h} chi_{c3 h} chi*_{c2 h} chi_{c1 h}          or the same with chi* first,
// so that a kick is K_{direct} K*_{adjoint} and a drift D*_{adjoint} D_{direct} (the right one first). Where kicks and
// drifts are flows, only the sums direct + adjoint count, and the method is the splitting method that the papers print.
// Where they are not (a kick by a force that depends on velocities, a rotating body's drift), the parts keep the order:
// a splitting method of order p for any two flows is a composition of order p of any chi with chi* (McLachlan, SIAM J.
// Sci. Comput. 16 (1995) 151; Hairer, Lubich, Wanner, Geometric Numerical Integration (2nd ed.), II.5 and III.3.4).
#pragma once

#include <string>
#include <vector>

#include "math/scalar.hpp"

namespace atwood {

struct Substep {
  bool kick;
  Quad direct, adjoint;  // fractions of a step
};

struct Composition {
  const char* id;
  int order;
  std::vector<Substep> (*substeps)();
};

// All compositions of the catalogue, in its order.
const std::vector<Composition>& compositions();
const Composition* find_composition(const std::string& id);  // null: there is none of that name

}  // namespace atwood
