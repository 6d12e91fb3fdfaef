// Slopes and their intervals, for every law that is a line on some pair of axes. Private to this room.
#pragma once

#include <span>
#include <vector>

namespace atwood::metrics {

// y = a + b x by least squares: b, its standard error, its 95 % half-width (Student's t, n - 2 degrees of freedom).
struct Line {
  double intercept = 0, slope = 0, standard_error = 0, half_width_95 = 0, residual_squares = 0;
};
Line fit_line(std::span<const double> x, std::span<const double> y);

// The median of the slopes of all pairs (Theil 1950, Sen 1968); of longer series about 400 samples are used.
double theil_sen(std::span<const double> x, std::span<const double> y);

// 95 % half-width of a line's slope through equally spaced x whose residuals are correlated from one to the next as
// rho^|i-j|, rho unknown. For each rho on a grid: the innovations' variance s^2 (Prais and Winsten 1954), the exact
// variance of the slope sum a_i y_i,
//
//     V(rho) = s^2 / (1 - rho^2) sum_ij a_i a_j rho^|i-j|,      a_i = (x_i - mean) / sum (x - mean)^2,
//
// and the restricted likelihood of rho (Harville 1974), |R|^-1/2 |X' R^-1 X|^-1/2 RSS^-(n-2)/2. The half-width contains
// 95 % of the mixture of Student's t_(n-2) with these widths, so the uncertainty of rho widens it; with a single
// estimate of rho, which is too small in short series, the coverage can be 80 %. `efficiency`: of the slope's estimator
// relative to least squares.
double correlated_half_width(std::span<const double> x, std::span<const double> residual, double efficiency);

// Whether the residuals of a line through equally spaced samples are stationary. The test of Dickey and Fuller (1981)
// with a trend and one lagged difference, Delta r_i = phi r_(i-1) + gamma Delta r_(i-1), phi = 0 for a random walk:
// true where this is rejected at the 5 % level (critical value by MacKinnon 1996), and for residuals that are zero.
bool stationary(std::span<const double> residual);

}  // namespace atwood::metrics
