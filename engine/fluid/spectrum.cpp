// Arnoldi's method with a Jacobian by differences.
#include "fluid/spectrum.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "scene/split_mix.hpp"

namespace atwood::fluid {
namespace {

using Vector = Eigen::VectorXd;

constexpr double kDifference = 1e-7;  // of the scale: half of the digits of a rate

// J v, with v and the result in units of the scale.
struct Derivative {
  System<double>& system;
  double t_s;
  const double* y;
  const std::vector<double>& scale;
  Vector rate, moved, moved_rate;

  void apply(const Vector& v, Vector& product) {
    for (int i = 0; i < system.size; ++i) moved[i] = y[i] + kDifference * scale[i] * v[i];
    system.rate(t_s, moved.data(), moved_rate.data());
    for (int i = 0; i < system.size; ++i) product[i] = (moved_rate[i] - rate[i]) / (kDifference * scale[i]);
  }
};

}  // namespace

Spectrum extremal_eigenvalues(System<double>& system, double t_s, const double* y, const std::vector<double>& scale,
                              int dimension) {
  const int n = system.size, most = std::min(dimension, n);
  Derivative derivative{system, t_s, y, scale, Vector(n), Vector(n), Vector(n)};
  system.rate(t_s, y, derivative.rate.data());
  Eigen::MatrixXd basis(n, most + 1), H = Eigen::MatrixXd::Zero(most + 1, most);
  SplitMix64 random;
  for (int i = 0; i < n; ++i) basis(i, 0) = random.next_unit() - 0.5;
  basis.col(0).normalize();
  // A component of the start along v changes the rate by kDifference |J| |v|: v is scaled to unit size per unknown.
  const double size = std::sqrt(static_cast<double>(n));
  Vector w(n);
  int steps = 0;
  while (steps < most) {
    derivative.apply(size * basis.col(steps), w);
    w /= size;
    if (!w.allFinite()) return {};
    for (int pass = 0; pass < 2; ++pass)  // orthogonalised twice: to round-off
      for (int k = 0; k <= steps; ++k) {
        const double component = basis.col(k).dot(w);
        w -= component * basis.col(k);
        H(k, steps) += component;
      }
    const double remainder = w.norm();
    ++steps;
    H(steps, steps - 1) = remainder;
    if (!(remainder > 1e-12 * H.col(steps - 1).norm())) break;  // an invariant subspace
    basis.col(steps) = w / remainder;
  }
  const Eigen::EigenSolver<Eigen::MatrixXd> solver(H.topLeftCorner(steps, steps));
  if (solver.info() != Eigen::Success) return {};
  const auto& values = solver.eigenvalues();
  Spectrum spectrum{{values.data(), values.data() + values.size()}};
  Eigen::Index largest = 0;
  const double modulus = values.cwiseAbs().maxCoeff(&largest);
  const Eigen::VectorXcd vector = solver.eigenvectors().col(largest);
  if (modulus > 0) spectrum.residual = H(steps, steps - 1) * std::abs(vector(steps - 1)) / (modulus * vector.norm());
  return spectrum;
}

}  // namespace atwood::fluid
