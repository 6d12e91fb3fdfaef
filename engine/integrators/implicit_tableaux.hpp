// Coefficients of the implicit Runge-Kutta methods that are not collocation on Legendre's zeros.
#pragma once

#include "integrators/collocation_nodes.hpp"

namespace atwood {

CollocationTableau trapezoid_tableau();  // Hairer, Norsett, Wanner I, table II.7.1: Lobatto IIIA of 2 stages
CollocationTableau sdirk2_tableau();  // Alexander, SIAM J. Numer. Anal. 14 (1977) 1006, theorem 5: gamma = 1 - 1/sqrt 2
CollocationTableau sdirk4_tableau();  // Hairer, Wanner, Solving ODEs II (2nd ed.), table IV.6.5: gamma = 1/4

}  // namespace atwood
