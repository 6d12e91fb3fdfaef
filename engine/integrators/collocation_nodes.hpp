// Collocation on the zeros of Legendre polynomials and of their sums: nodes and integrated Lagrange polynomials in
// quad.
#pragma once

#include <vector>

#include "math/scalar.hpp"

namespace atwood {

// The polynomial u of degree `stages` with u(t) = y, u'(t + c_i h) = f(t + c_i h, u(t + c_i h)) steps to u(t + h):
//   Y_i = y + h sum_j a_ij f(t + c_j h, Y_j),   y_new = y + h sum_j b_j f(t + c_j h, Y_j)
// Hairer, Norsett, Wanner, Solving ODEs I (2nd ed.), theorem II.7.7. Each entry is right to a few units of quad's last
// place at 1; tables of up to 12 stages are tested.
struct CollocationTableau {
  int stages;
  std::vector<Quad> c, b, a;  // a row-major, stages x stages; nodes increase
};

// The nodes are the zeros in [0, 1] of the polynomial beside each function; P_s: Legendre polynomial shifted to [0, 1].
CollocationTableau gauss_collocation(int stages);        // P_s: order 2 s
CollocationTableau radau_right_collocation(int stages);  // P_s - P_(s-1), Radau IIA: c_s = 1, order 2 s - 1
CollocationTableau radau_left_collocation(int stages);   // P_s + P_(s-1), nodes of Radau I: c_1 = 0, order 2 s - 1

}  // namespace atwood
