// Linear least squares. Private to this room.
#pragma once

#include <span>
#include <vector>

namespace atwood::metrics {

// The fit of sum_k c_k column_k to y.
struct ColumnFit {
  double last = 0;               // the last column's coefficient; NaN where the other columns span it
  double squares = 0;            // weighted sum of squared residuals
  std::vector<double> weight;    // of the y_i in the last coefficient: last = sum_i weight_i y_i
  std::vector<double> residual;  // residuals of y, times the root of their weights
};

// Minimises sum_i root_i^2 (y_i - sum_k c_k column_k[i])^2; without roots all weights are 1. Modified Gram-Schmidt in
// the order of the columns, each orthogonalised twice for its round-off (Giraud, Langou and Rozloznik, Numer. Math. 101
// (2005) 87); a column that those before it span is left out. As many roots as y, and columns as long as y.
ColumnFit fit_columns(const std::vector<std::vector<double>>& columns, std::span<const double> y,
                      std::span<const double> root = {});

}  // namespace atwood::metrics
