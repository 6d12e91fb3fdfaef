#include "fluid_truth/spectral.hpp"

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "extended/extrapolation.hpp"

namespace atwood::fluid_truth {

namespace {

constexpr std::size_t kMaxKept = 256;  // times asked for

// The derivative of the trigonometric interpolant at the points: sums over the modes k = 1 ... (n - 1) / 2,
// with w = 2 pi / L,
//   first   -(2 w / n) sum k sin(2 pi k (i - j) / n)         second   -(2 w^2 / n) sum k^2 cos(2 pi k (i - j) / n)
std::vector<double> differentiation(int n, double period, int order) {
  const double w = 2 * std::numbers::pi / period;
  std::vector<double> of_difference(n), made(static_cast<std::size_t>(n) * n);
  for (int m = 0; m < n; ++m) {
    long double sum = 0;
    for (int k = 1; k <= (n - 1) / 2; ++k) {
      const long double angle = 2 * std::numbers::pi_v<long double> * ((static_cast<long>(k) * m) % n) / n;
      sum += order == 1 ? k * std::sin(angle) : static_cast<long double>(k) * k * std::cos(angle);
    }
    of_difference[m] = static_cast<double>(-2 * sum / n) * (order == 1 ? w : w * w);
  }
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) made[static_cast<std::size_t>(i) * n + j] = of_difference[((i - j) % n + n) % n];
  return made;
}

// The cardinal function of the points at the phase p in turns: (1 + 2 sum cos(2 pi k (p - j / n))) / n
//   = sin(pi n q) / (n sin(pi q)),   q = p - j / n
void cardinal(double p, int n, std::vector<double>& to) {
  p -= std::floor(p);
  for (int j = 0; j < n; ++j) {
    double q = p - static_cast<double>(j) / n;
    q -= std::round(q);
    const double below = std::sin(std::numbers::pi * q);
    to[j] = std::fabs(q) < 1e-9 ? 1 - (static_cast<double>(n) * n - 1) * std::numbers::pi * std::numbers::pi * q * q / 6
                                : std::sin(std::numbers::pi * n * q) / (n * below);
  }
}

}  // namespace

Spectral::Spectral(const SpectralProblem& problem, int n, double tolerance, double stride_s)
    : of_(problem), n_(n), tolerance_(tolerance), stride_s_(stride_s),
      first_x_(differentiation(n, problem.period_x, 1)), first_y_(differentiation(n, problem.period_y, 1)),
      second_x_(differentiation(n, problem.period_x, 2)), second_y_(differentiation(n, problem.period_y, 2)) {
  const std::size_t size = static_cast<std::size_t>(n) * n;
  for (auto* each : {&ux_, &uy_, &vx_, &vy_, &rx_, &ry_, &lap_u_, &lap_v_, &work_}) each->assign(size, 0.0);
  auto& start = kept_.emplace_back(3 * size);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const auto at = problem.initial(problem.period_x * i / n, problem.period_y * j / n);
      for (std::size_t k = 0; k < 3; ++k) start[k * size + static_cast<std::size_t>(i) * n + j] = at[k];
    }
}

void Spectral::derivative_x(const std::vector<double>& matrix, const double* f, double* to) const {
  for (int i = 0; i < n_; ++i) {
    double* row = to + static_cast<std::size_t>(i) * n_;
    for (int j = 0; j < n_; ++j) row[j] = 0;
    for (int m = 0; m < n_; ++m) {
      const double d = matrix[static_cast<std::size_t>(i) * n_ + m];
      const double* from = f + static_cast<std::size_t>(m) * n_;
      for (int j = 0; j < n_; ++j) row[j] += d * from[j];
    }
  }
}

void Spectral::derivative_y(const std::vector<double>& matrix, const double* f, double* to) const {
  // Rows of the matrix in place of its columns, so that the inner loop is contiguous: the transpose, which is the
  // matrix itself for the second derivative and minus the matrix for the first.
  for (int i = 0; i < n_; ++i) {
    double* row = to + static_cast<std::size_t>(i) * n_;
    const double* from = f + static_cast<std::size_t>(i) * n_;
    for (int j = 0; j < n_; ++j) row[j] = 0;
    for (int m = 0; m < n_; ++m) {
      const double* d = matrix.data() + static_cast<std::size_t>(m) * n_;
      for (int j = 0; j < n_; ++j) row[j] += from[m] * d[j];
    }
  }
}

void Spectral::rate(double t, const double* y, double* dydt) {
  const std::size_t size = static_cast<std::size_t>(n_) * n_;
  const double *u = y, *v = y + size, *rho = y + 2 * size;
  const auto minus = [&](std::vector<double>& f) {  // of an odd matrix: derivative_y takes its transpose
    for (double& each : f) each = -each;
  };
  derivative_x(first_x_, u, ux_.data());
  derivative_x(first_x_, v, vx_.data());
  derivative_x(first_x_, rho, rx_.data());
  derivative_y(first_y_, u, uy_.data());
  derivative_y(first_y_, v, vy_.data());
  derivative_y(first_y_, rho, ry_.data());
  minus(uy_), minus(vy_), minus(ry_);
  const auto add_laplacian = [&](const double* f, std::vector<double>& to) {
    derivative_x(second_x_, f, to.data());
    derivative_y(second_y_, f, work_.data());
    for (std::size_t k = 0; k < size; ++k) to[k] += work_[k];
  };
  if (of_.nu != 0) {
    add_laplacian(u, lap_u_);
    add_laplacian(v, lap_v_);
  }
  if (of_.nu != 0 && of_.beta != 0) {
    std::vector<double> divergence(size);
    for (std::size_t k = 0; k < size; ++k) divergence[k] = ux_[k] + vy_[k];
    derivative_x(first_x_, divergence.data(), work_.data());
    for (std::size_t k = 0; k < size; ++k) lap_u_[k] += of_.beta * work_[k];
    derivative_y(first_y_, divergence.data(), work_.data());
    for (std::size_t k = 0; k < size; ++k) lap_v_[k] -= of_.beta * work_[k];
  }
  for (std::size_t k = 0; k < size; ++k) {
    const double slope = of_.c * of_.c * std::pow(rho[k] / of_.rho0, of_.gamma - 1) / rho[k],
                 viscosity = of_.rho0 * of_.nu / rho[k];
    double su = of_.gravity[0], sv = of_.gravity[1];
    if (of_.source) {
      const auto s = of_.source(t, of_.period_x * static_cast<double>(k / n_) / n_,
                                of_.period_y * static_cast<double>(k % n_) / n_);
      su += s[0], sv += s[1];
    }
    dydt[k] = su - u[k] * ux_[k] - v[k] * uy_[k] - slope * rx_[k] + viscosity * lap_u_[k];
    dydt[size + k] = sv - u[k] * vx_[k] - v[k] * vy_[k] - slope * ry_[k] + viscosity * lap_v_[k];
    dydt[2 * size + k] = -u[k] * rx_[k] - v[k] * ry_[k] - rho[k] * (ux_[k] + vy_[k]);
  }
}

std::vector<double> Spectral::integrate(double from, const std::vector<double>& y, double to) {
  const std::size_t size = static_cast<std::size_t>(n_) * n_;
  std::vector<int> group(3 * size, 0);  // velocities share a scale, the density has its own
  for (std::size_t k = 2 * size; k < 3 * size; ++k) group[k] = 1;
  extended::Extrapolation<double> stepper(
      static_cast<int>(3 * size), group, [this](double t, const double* state, double* dydt) { rate(t, state, dydt); },
      tolerance_);
  std::vector<double> now = y;
  if (!extended::advance(stepper, from, now.data(), to - from))
    throw std::invalid_argument("the spectral integration failed after t = " + format_double(from) + " s");
  return now;
}

const std::vector<double>& Spectral::state_at(double t) {
  if (const auto found = asked_.find(t); found != asked_.end()) return found->second;
  const auto last = static_cast<std::size_t>(t / stride_s_);
  while (kept_.size() <= last) {
    const double from = stride_s_ * static_cast<double>(kept_.size() - 1);
    kept_.push_back(integrate(from, kept_.back(), stride_s_ * static_cast<double>(kept_.size())));
  }
  const double from = stride_s_ * static_cast<double>(last);
  if (asked_.size() >= kMaxKept) asked_.clear();
  return asked_[t] = t > from ? integrate(from, kept_[last], t) : kept_[last];
}

SpectralPoint Spectral::interpolate(const std::vector<double>& state, double x, double y) const {
  std::vector<double> along_x(n_), along_y(n_);
  cardinal(x / of_.period_x, n_, along_x);
  cardinal(y / of_.period_y, n_, along_y);
  const std::size_t size = static_cast<std::size_t>(n_) * n_;
  double made[3] = {0, 0, 0};
  for (std::size_t f = 0; f < 3; ++f)
    for (int i = 0; i < n_; ++i) {
      const double* row = state.data() + f * size + static_cast<std::size_t>(i) * n_;
      double sum = 0;
      for (int j = 0; j < n_; ++j) sum += row[j] * along_y[j];
      made[f] += along_x[i] * sum;
    }
  return {made[0], made[1], made[2]};
}

}  // namespace atwood::fluid_truth
