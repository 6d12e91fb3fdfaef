// Where Eigen stays out of the other files of this room. Its settings here are Eigen's own: this room is linked to
// engines that are themselves written in Eigen (DART, FCL), and one program has one Eigen.
#include <Eigen/Core>
#include <Eigen/Jacobi>
#include <stdexcept>
#include <utility>

#include "scene/inertia.hpp"

namespace atwood {

// Jacobi's method of cyclic rotations (Golub and Van Loan, Matrix Computations, 4th ed., section 8.5), which ends after
// a few sweeps of a 3 x 3 matrix. The QR iteration of Eigen's SelfAdjointEigenSolver would sort the axes, and give a
// slender body's small moment only to the round-off of the largest (Demmel and Veselic, SIAM J. Matrix Anal. Appl. 13
// (1992) 1204).
Diagonalised diagonalise(const Real33& symmetric) {
  using RowMajor = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  RowMajor a = RowMajor::Map(symmetric.data()), axes = RowMajor::Identity();
  constexpr int max_sweeps = 50;
  bool turned = true;  // false: what is left of the off-diagonal entries is too small for a rotation
  for (int sweep = 0; turned && !a.isDiagonal(0) && a.allFinite(); ++sweep) {
    if (sweep == max_sweeps) throw std::logic_error("the principal axes of an inertia did not converge");
    turned = false;
    for (const auto& [p, q] : {std::pair(0, 1), std::pair(0, 2), std::pair(1, 2)}) {
      Eigen::JacobiRotation<double> turn;
      if (!turn.makeJacobi(a, p, q)) continue;
      turned = true;
      a.applyOnTheRight(p, q, turn);  // a := J^T a J, axes := axes J
      axes.applyOnTheRight(p, q, turn);
      a.applyOnTheLeft(p, q, turn.adjoint());
      a(p, q) = a(q, p) = 0;
    }
  }
  Diagonalised made{{a(0, 0), a(1, 1), a(2, 2)}, {}};
  RowMajor::Map(made.axes.data()) = axes;
  return made;
}

}  // namespace atwood
