#include "math/principal_axes.hpp"

#include <Eigen/Jacobi>
#include <limits>

#include "math/eigen_quad.hpp"

namespace atwood {
namespace {

// One rotation in the plane (i, j) that makes m(i, j) zero; the angle's tangent is the smaller root of
// t^2 + 2 theta t - 1 = 0, theta = (m_jj - m_ii) / (2 m_ij).
template <class S> Quat<S> rotate_plane(Eigen::Matrix<S, 3, 3>& m, int i, int j) {
  const S theta = (m(j, j) - m(i, i)) / (S(2) * m(i, j));
  const S t = (theta < S(0) ? S(-1) : S(1)) / (real::abs(theta) + real::sqrt(theta * theta + S(1)));
  const S c = S(1) / real::sqrt(t * t + S(1));
  const S s = t * c;
  const Eigen::JacobiRotation<S> turn(c, s);
  m.applyOnTheRight(i, j, turn);
  m.applyOnTheLeft(i, j, turn.adjoint());
  m(i, j) = m(j, i) = S(0);
  // The columns turned by the matrix [c s; -s c] in (i, j): a rotation by -angle about k = i x j (cyclic order).
  const S half_cos = real::sqrt((S(1) + c) / S(2));
  const S half_sin = s / (S(2) * half_cos);
  const int k = 3 - i - j;
  const S sign = (j == (i + 1) % 3) ? S(-1) : S(1);
  Quat<S> q{half_cos, S(0), S(0), S(0)};
  (k == 0 ? q.x : k == 1 ? q.y : q.z) = sign * half_sin;
  return q;
}

}  // namespace

template <class S> PrincipalAxes<S> principal_axes(const std::array<double, 9>& inertia_kg_m2) {
  Eigen::Matrix<S, 3, 3> m;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) m(i, j) = (S(inertia_kg_m2[3 * i + j]) + S(inertia_kg_m2[3 * j + i])) / S(2);
  PrincipalAxes<S> axes;
  const S negligible = real::epsilon<S>() * real::epsilon<S>() * (m(0, 0) + m(1, 1) + m(2, 2));
  bool converged = false;
  for (int sweep = 0; sweep < 30; ++sweep) {
    converged = real::abs(m(0, 1)) + real::abs(m(0, 2)) + real::abs(m(1, 2)) <= negligible;
    if (converged) break;
    axes.body_axes = false;
    for (int i = 0; i < 2; ++i)
      for (int j = i + 1; j < 3; ++j)
        if (real::abs(m(i, j)) > S(0)) axes.q_BP = normalised(axes.q_BP * rotate_plane(m, i, j));
  }
  axes.moments = {m(0, 0), m(1, 1), m(2, 2)};
  if (!converged) axes.moments.x = axes.moments.y = axes.moments.z = S(std::numeric_limits<double>::quiet_NaN());
  return axes;
}

template PrincipalAxes<float> principal_axes<float>(const std::array<double, 9>&);
template PrincipalAxes<double> principal_axes<double>(const std::array<double, 9>&);
template PrincipalAxes<long double> principal_axes<long double>(const std::array<double, 9>&);
template PrincipalAxes<Quad> principal_axes<Quad>(const std::array<double, 9>&);

}  // namespace atwood
