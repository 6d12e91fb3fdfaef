#include "validation/metrics/least_squares.hpp"

#include <Eigen/Core>
#include <cmath>

namespace atwood::metrics {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

Eigen::Map<const VectorXd> vector_of(std::span<const double> x) { return {x.data(), static_cast<Index>(x.size())}; }

std::vector<double> values_of(const VectorXd& x) { return {x.data(), x.data() + x.size()}; }

}  // namespace

ColumnFit fit_columns(const std::vector<std::vector<double>>& columns, std::span<const double> y,
                      std::span<const double> root) {
  const auto count = static_cast<Index>(columns.size());
  VectorXd scale = VectorXd::Ones(static_cast<Index>(y.size()));
  if (!root.empty()) scale = vector_of(root);
  VectorXd left = scale.cwiseProduct(vector_of(y));
  Eigen::MatrixXd basis(left.size(), count);
  ColumnFit fit;
  for (Index c = 0; c < count; ++c) {
    auto q = basis.col(c);
    q = scale.cwiseProduct(vector_of(columns[static_cast<std::size_t>(c)]));
    for (int pass = 0; pass < 2; ++pass)
      for (Index b = 0; b < c; ++b) q -= q.dot(basis.col(b)) * basis.col(b);
    const double norm = q.norm();
    if (norm > 0) q /= norm;
    const double along = q.dot(left);
    left -= along * q;
    if (c + 1 < count) continue;
    fit.last = along / norm;
    fit.weight = values_of((q / norm).cwiseProduct(scale));
  }
  fit.squares = left.squaredNorm();
  fit.residual = values_of(left);
  return fit;
}

}  // namespace atwood::metrics
