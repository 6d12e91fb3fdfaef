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

// 95 % half-width of a line's slope through equally spaced x, of residuals that are one of
//
//     u_i                  correlated from one to the next, u_i = rho u_(i-1) + e_i with rho from -0.5 to 0.99;
//     u_i + w_i, rho = 1   a random walk under white noise w, of a variance from 0.1 to n^2 times that of e.
//
// Which one is unknown. For each on a grid: the variance s^2 of e, the exact variance V of the slope sum a_i y_i,
// a_i = (x_i - mean) / sum (x - mean)^2, and the restricted likelihood (Harville 1974), |R|^-1/2 |X' R^-1 X|^-1/2
// RSS^-(n-2)/2, by Kalman's filter (Harvey 1989, 3.4). The half-width contains 95 % of the mixture of Student's t_(n-2)
// with these widths, weighted by likelihood and by the prior of a walk, 3/4. It is wider than white noise alone would
// need (twice at n = 121), since a walk below the noise that moves the slope as much cannot be excluded. Observed
// coverage: white and correlated noise 97 to 100 %, a walk under white noise of 0.5 to 30 times its step 90 to 98 %.
// `efficiency`: of the slope's estimator relative to least squares.
double correlated_half_width(std::span<const double> x, std::span<const double> residual, double efficiency);

// Whether the residuals of a line through equally spaced samples are stationary. The test of Dickey and Fuller (1981)
// with a trend and one lagged difference, Delta r_i = phi r_(i-1) + gamma Delta r_(i-1), phi = 0 for a random walk:
// true where this is rejected at the 5 % level (critical value by MacKinnon 1996), and for residuals that are zero.
bool stationary(std::span<const double> residual);

}  // namespace atwood::metrics
