// C. G. J. Jacobi, Crelle 30 (1846) 51: rotations in coordinate planes, each zeroing one off-diagonal entry.
#include "closed_form/principal_axes.hpp"

#include <Eigen/Jacobi>
#include <algorithm>
#include <limits>
#include <utility>

#include "dynamics/eigen_quad.hpp"

namespace atwood::closed_form {

namespace {

template <class S> Quat<S> about(int axis, S angle) {
  Vec<S> unit{};
  unit[axis] = 1;
  return turn(unit, angle);
}

// A quarter turn about the third axis swaps the other two moments.
template <class S> void swap_axes(PrincipalAxes<S>& axes, int i, int j) {
  const int k = 3 - i - j;
  axes.q_BP = axes.q_BP * about(k, pi<S>() / 2);
  std::swap(axes.moment[i], axes.moment[j]);
}

}  // namespace

template <class S> PrincipalAxes<S> principal_axes(const Real33& inertia) {
  std::array<S, 9> wide;
  for (std::size_t k = 0; k < 9; ++k) wide[k] = S(inertia[k]);
  return principal_axes_of(wide);
}

template <class S> PrincipalAxes<S> principal_axes_of(const std::array<S, 9>& inertia) {
  Eigen::Matrix<S, 3, 3> m;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) m(i, j) = (inertia[3 * i + j] + inertia[3 * j + i]) / 2;
  PrincipalAxes<S> axes;
  bool converged = false;
  for (int sweep = 0; sweep < 60 && !converged; ++sweep) {
    converged = true;
    for (const auto& [p, q] : {std::pair{0, 1}, std::pair{1, 2}, std::pair{2, 0}}) {
      if (magnitude(m(p, q)) <= unit_round_off<S>() * unit_round_off<S>() * (m(p, p) + m(q, q))) continue;
      converged = false;
      // tan 2 angle = 2 m_pq / (m_pp - m_qq), the smaller turn; new axes p' = c p + s q, q' = -s p + c q.
      const S half = (m(p, p) - m(q, q)) / (2 * m(p, q));
      const S t = (half < 0 ? -1 : 1) / (magnitude(half) + sqrt(1 + half * half));
      const S angle = atan(t), c = cos(angle), s = sin(angle);
      const Eigen::JacobiRotation<S> turned(c, -s);
      m.applyOnTheRight(p, q, turned);
      m.applyOnTheLeft(p, q, turned.adjoint());
      m(p, q) = m(q, p) = 0;
      axes.q_BP = axes.q_BP * about(3 - p - q, angle);  // (p, q, k) is cyclic: the turn about k takes p towards q
    }
  }
  for (int i = 0; i < 3; ++i) axes.moment[i] = converged ? m(i, i) : S(std::numeric_limits<double>::quiet_NaN());
  if (axes.moment[0] > axes.moment[1]) swap_axes(axes, 0, 1);
  if (axes.moment[1] > axes.moment[2]) swap_axes(axes, 1, 2);
  if (axes.moment[0] > axes.moment[1]) swap_axes(axes, 0, 1);
  return axes;
}

template PrincipalAxes<Narrow> principal_axes(const Real33&);
template PrincipalAxes<Wide> principal_axes(const Real33&);
template PrincipalAxes<Narrow> principal_axes_of(const std::array<Narrow, 9>&);
template PrincipalAxes<Wide> principal_axes_of(const std::array<Wide, 9>&);

}  // namespace atwood::closed_form
