#include <Eigen/LU>

#include "dynamics/complementarity.hpp"
#include "dynamics/eigen_quad.hpp"

namespace atwood::dynamics {

template <class S>
bool eliminate(const std::vector<std::vector<S>>& A, const std::vector<S>& b, S least, std::vector<S>& x) {
  constexpr auto max_unknowns = static_cast<int>(kMaxSimultaneous);
  using Vector = Eigen::Matrix<S, Eigen::Dynamic, 1, 0, max_unknowns, 1>;
  using Square = Eigen::Matrix<S, Eigen::Dynamic, Eigen::Dynamic, 0, max_unknowns, max_unknowns>;
  const auto n = static_cast<Eigen::Index>(b.size());
  x.assign(b.size(), S(0));
  if (n == 0) return true;
  Square matrix(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j) matrix(i, j) = A[i][j];
  const Eigen::FullPivLU<Square> lu(matrix);
  const S pivot = least * matrix.diagonal().maxCoeff();
  if (!(lu.matrixLU().diagonal().cwiseAbs().array() > pivot).all()) return false;
  // P A Q = L U; FullPivLU::solve() asks for a function of Wide that std:: lacks.
  Vector y = lu.permutationP() * Vector::Map(b.data(), n);
  lu.matrixLU().template triangularView<Eigen::UnitLower>().solveInPlace(y);
  lu.matrixLU().template triangularView<Eigen::Upper>().solveInPlace(y);
  Vector::Map(x.data(), n) = lu.permutationQ() * y;
  return true;
}

#define ATWOOD_ELIMINATE(S) \
  template bool eliminate(const std::vector<std::vector<S>>&, const std::vector<S>&, S, std::vector<S>&);
ATWOOD_ELIMINATE(double)
ATWOOD_ELIMINATE(long double)
ATWOOD_ELIMINATE(__float128)
#undef ATWOOD_ELIMINATE

}  // namespace atwood::dynamics
