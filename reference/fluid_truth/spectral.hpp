// The equations of a weakly compressible viscous fluid in a doubly periodic box, by Fourier collocation in space and
// extrapolation in time (C. Canuto, M. Y. Hussaini, A. Quarteroni and T. A. Zang, Spectral Methods, 1988, 2.1).
//
//   rho_t + div(rho u) = 0
//   u_t + u.grad u = -(p'(rho) / rho) grad rho + rho0 nu / rho (lap u + beta grad div u) + s(t, x)
#pragma once

#include <functional>
#include <map>
#include <vector>

#include "fluid_truth/manufactured.hpp"
#include "fluid_truth/response.hpp"
#include "scene/scene.hpp"

namespace atwood::fluid_truth {

struct SpectralProblem {
  double period_x = 1, period_y = 1;
  double rho0 = 1, c = 1, gamma = 1;  // gamma = 1: linear equation of state
  double nu = 0, beta = 0;            // beta: 0 of Morris's term, 2 of Monaghan and Gingold's
  std::array<double, 2> gravity{};
  std::function<std::array<double, 3>(double x, double y)> initial;           // u, v, rho
  std::function<std::array<double, 2>(double t, double x, double y)> source;  // empty: none
};

struct SpectralPoint {
  double u = 0, v = 0, rho = 0;
};

// One solution: n x n collocation points (n odd: no mode without a partner), the integrator's tolerance. States are
// kept at multiples of `stride_s`, each stretch is integrated anew from its beginning: what is answered at t does not
// depend on what was asked before.
class Spectral {
 public:
  Spectral(const SpectralProblem& problem, int n, double tolerance, double stride_s);
  // The state at t: n * n values of u, then of v, then of rho; first index x. Throws std::invalid_argument where the
  // integration fails.
  const std::vector<double>& state_at(double t);
  // Trigonometric interpolation of a state.
  SpectralPoint interpolate(const std::vector<double>& state, double x, double y) const;
  void rate(double t, const double* y, double* dydt);

 private:
  void derivative_x(const std::vector<double>& matrix, const double* f, double* to) const;
  void derivative_y(const std::vector<double>& matrix, const double* f, double* to) const;
  std::vector<double> integrate(double from, const std::vector<double>& y, double to);

  SpectralProblem of_;
  int n_;
  double tolerance_, stride_s_;
  std::vector<double> first_x_, first_y_, second_x_, second_y_;  // n x n matrices of differentiation
  std::vector<double> ux_, uy_, vx_, vy_, rx_, ry_, lap_u_, lap_v_, work_;
  std::vector<std::vector<double>> kept_;        // at multiples of stride_s
  std::map<double, std::vector<double>> asked_;  // at times that were asked for
};

}  // namespace atwood::fluid_truth
