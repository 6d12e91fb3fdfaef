#include "extended/collocation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace atwood::extended {

namespace {

// P_0 ... P_10 on [-1, 1] and the derivative of P_10.
struct Legendre {
  std::array<Wide, kStages + 1> P;
  Wide derivative;
};

Legendre legendre(Wide x) {
  Legendre made;
  made.P[0] = 1;
  made.P[1] = x;
  for (int n = 1; n < kStages; ++n) made.P[n + 1] = ((2 * n + 1) * x * made.P[n] - n * made.P[n - 1]) / (n + 1);
  made.derivative = kStages * (x * made.P[kStages] - made.P[kStages - 1]) / (x * x - 1);
  return made;
}

// With p_n(s) = P_n(2 s - 1) the j-th Lagrange polynomial is sum_n (2 n + 1) b_j p_n(c_j) p_n(s), and
// integral_0^c p_n = (p_{n+1}(c) - p_{n-1}(c)) / (2 (2 n + 1)) for n >= 1, c for n = 0.
GaussTableau make_tableau() {
  GaussTableau made;
  std::array<Legendre, kStages> at;
  for (int i = 0; i < kStages; ++i) {
    Wide x = -std::cos(std::numbers::pi * (i + 0.75) / (kStages + 0.5));
    for (int k = 0; k < 8; ++k) {
      const Legendre now = legendre(x);
      x -= now.P[kStages] / now.derivative;
    }
    at[i] = legendre(x);
    made.c[i] = (1 + x) / 2;
    made.b[i] = 1 / ((1 - x * x) * at[i].derivative * at[i].derivative);
  }
  for (int i = 0; i < kStages; ++i)
    for (int j = 0; j < kStages; ++j) {
      Wide sum = made.c[i];
      for (int n = 1; n < kStages; ++n) sum += at[j].P[n] * (at[i].P[n + 1] - at[i].P[n - 1]) / 2;
      made.A[i][j] = made.b[j] * sum;
    }
  const Legendre middle = legendre(0);
  for (int j = 0; j < kStages; ++j) {
    Wide sum = Wide(0.5);
    for (int n = 1; n < kStages; ++n) sum += at[j].P[n] * (middle.P[n + 1] - middle.P[n - 1]) / 2;
    made.half[j] = made.b[j] * sum;
  }
  for (int j = 0; j < kStages; ++j) {
    made.degree8[j] = static_cast<double>(17 * made.b[j] * at[j].P[8]);
    made.degree9[j] = static_cast<double>(19 * made.b[j] * at[j].P[9]);
  }
  return made;
}

struct NarrowTableau {
  double c[kStages], A[kStages][kStages];
};

const NarrowTableau& narrow_tableau() {
  static const NarrowTableau made = [] {
    NarrowTableau n;
    const GaussTableau& wide = gauss_tableau();
    for (int i = 0; i < kStages; ++i) {
      n.c[i] = static_cast<double>(wide.c[i]);
      for (int j = 0; j < kStages; ++j) n.A[i][j] = static_cast<double>(wide.A[i][j]);
    }
    return n;
  }();
  return made;
}

constexpr double kNotableLoss = 1e4;  // four digits: without them the usual tolerances hold
constexpr double kWholeLoss = 1e14;   // double has next to no digits left

// The larger of both; NaN when x is, and from then on.
double larger(double largest, double x) { return x <= largest || std::isnan(largest) ? largest : x; }

}  // namespace

const GaussTableau& gauss_tableau() {
  static const GaussTableau made = make_tableau();
  return made;
}

Collocation::Collocation(const Problem& problem, Wide tolerance, double stage_residual)
    : problem_(problem), tolerance_(tolerance), stage_residual_(stage_residual), scale_(problem.size, problem.group) {
  const int n = problem_.size, all = kStages * n;
  Y_.resize(all);
  F_.resize(all);
  rate_.resize(n);
  y0_.resize(n);
  scale_double_.resize(n);
  for (auto* in_double : {&y_, &f_, &d_, &rates_at_guess_, &stage_shift_}) in_double->resize(all);
}

void Collocation::measure_loss(Wide t, const Wide* y, double h) {
  const int n = problem_.size;
  std::vector<double> narrow(n), at(n);
  for (int k = 0; k < n; ++k) at[k] = static_cast<double>(y[k]);
  std::vector<Wide> same(at.begin(), at.end());
  const auto narrow_t = static_cast<double>(t);
  problem_.rate(Wide(narrow_t), same.data(), rate_.data());
  ++evaluations;
  problem_.narrow_rate(narrow_t, at.data(), narrow.data());
  double apart = 0, size = 0;
  for (int k = 0; k < n; ++k) {
    apart = std::max(apart, magnitude(static_cast<double>(Wide(narrow[k]) - rate_[k])) / scale_double_[k]);
    size = std::max(size, magnitude(narrow[k]) / scale_double_[k]);
  }
  // Of rates that change the state by less than a thousandth of its scale, round-off matters less.
  const double found = h * apart / std::max(h * size, 1e-3) / std::numeric_limits<double>::epsilon();
  if (found > kNotableLoss) loss_ = std::max(loss_, found);
}

// f_ holds a first approximation of the stage rates. Fixed-point iteration F <- f(y + h A F) in double. False: it did
// not converge in 60 iterations.
bool Collocation::solve_narrow(double t, double h) {
  const NarrowTableau& tableau = narrow_tableau();
  const int n = problem_.size;
  double last = HUGE_VAL;
  for (int round = 0; round < 60; ++round) {
    double change = 0;
    for (int i = 0; i < kStages; ++i)
      for (int k = 0; k < n; ++k) {
        double sum = 0;
        for (int j = 0; j < kStages; ++j) sum += tableau.A[i][j] * f_[j * n + k];
        const double next = y0_[k] + h * sum;
        change = larger(change, magnitude(next - y_[i * n + k]) / scale_double_[k]);
        y_[i * n + k] = next;
      }
    for (int i = 0; i < kStages; ++i) problem_.narrow_rate(t + tableau.c[i] * h, &y_[i * n], &f_[i * n]);
    if (!std::isfinite(change)) return false;
    if (change < 1e-14 || (round > 20 && change < 1e-11)) return true;
    if (loss_ > 1 && round > 12 && change > 0.1 * last && change < 1e-15 * loss_) return true;
    if (round > 12 && change > last && change > 1e-10) return false;
    last = change;
  }
  return false;
}

// Solves d = residual + J h A d by fixed-point iteration, with J the derivative of f at each stage along h A d, by a
// difference quotient in double. d_ is then the first-order correction of F. Where 40 rounds do not converge, the
// caller sees it: its corrections stop shrinking, and it refuses the step.
void Collocation::correct(double t, double h, const std::vector<double>& residual) {
  const NarrowTableau& tableau = narrow_tableau();
  const int n = problem_.size;
  std::vector<double> probe(n), rate(n);
  d_ = residual;
  for (int round = 0; round < 40; ++round) {
    double change = 0, size = 0;
    for (int i = 0; i < kStages; ++i) {
      double largest_shift = 0;
      for (int k = 0; k < n; ++k) {
        double sum = 0;
        for (int j = 0; j < kStages; ++j) sum += tableau.A[i][j] * d_[j * n + k];
        stage_shift_[i * n + k] = h * sum;
        largest_shift = std::max(largest_shift, magnitude(stage_shift_[i * n + k]) / scale_double_[k]);
      }
      const double difference_step = largest_shift > 0 ? 1e-7 * std::sqrt(loss_) / largest_shift : 0;
      for (int k = 0; k < n; ++k) probe[k] = y_[i * n + k] + difference_step * stage_shift_[i * n + k];
      problem_.narrow_rate(t + tableau.c[i] * h, probe.data(), rate.data());
      for (int k = 0; k < n; ++k) {
        const double along = difference_step > 0 ? (rate[k] - rates_at_guess_[i * n + k]) / difference_step : 0;
        const double next = residual[i * n + k] + along;
        change = larger(change, magnitude(h * (next - f_[i * n + k])) / scale_double_[k]);
        size = larger(size, magnitude(h * next) / scale_double_[k]);
        f_[i * n + k] = next;
      }
    }
    d_ = f_;
    if (!(change > 1e-8 * size)) break;
  }
}

bool Collocation::solve_stages(Wide t, const Wide* y, Wide h) {
  const GaussTableau& tableau = gauss_tableau();
  const int n = problem_.size;
  const double narrow_t = static_cast<double>(t), narrow_h = static_cast<double>(h);
  for (int k = 0; k < n; ++k) {
    y0_[k] = static_cast<double>(y[k]);
    scale_double_[k] = static_cast<double>(scale_.of(k));
  }
  problem_.narrow_rate(narrow_t, y0_.data(), f_.data());
  for (int i = 1; i < kStages; ++i) std::copy_n(f_.begin(), n, f_.begin() + i * n);
  std::fill(y_.begin(), y_.end(), 0.0);
  if (!solve_narrow(narrow_t, narrow_h)) return false;
  for (int i = 0; i < kStages * n; ++i) F_[i] = f_[i];
  rates_at_guess_ = f_;
  for (int i = 0; i < kStages; ++i)
    for (int k = 0; k < n; ++k) {
      Wide sum = 0;
      for (int j = 0; j < kStages; ++j) sum += tableau.A[i][j] * F_[j * n + k];
      Y_[i * n + k] = y[k] + h * sum;
    }
  std::vector<double> residual(kStages * n);
  double last = HUGE_VAL;
  for (int pass = 0; pass < 12; ++pass) {
    double size = 0;
    for (int i = 0; i < kStages; ++i) {
      problem_.rate(t + tableau.c[i] * h, &Y_[i * n], rate_.data());
      ++evaluations;
      for (int k = 0; k < n; ++k) {
        residual[i * n + k] = static_cast<double>(rate_[k] - F_[i * n + k]);
        size = larger(size, magnitude(narrow_h * residual[i * n + k]) / scale_double_[k]);
      }
    }
    if (!std::isfinite(size)) return false;
    // Converged, or stagnated at the round-off of the 10 x 10 sums or of the rates.
    if (size < stage_residual_ || (size < std::max(1e-28, 1e-32 * loss_) && size > 0.1 * last)) return true;
    last = size;
    correct(narrow_t, narrow_h, residual);
    for (int i = 0; i < kStages; ++i)
      for (int k = 0; k < n; ++k) {
        F_[i * n + k] += Wide(d_[i * n + k]);
        double sum = 0;  // the correction is small: double has all of its significant digits
        for (int j = 0; j < kStages; ++j) sum += narrow_tableau().A[i][j] * d_[j * n + k];
        Y_[i * n + k] += h * Wide(sum);
      }
  }
  return false;
}

// The interpolation error of the polynomial of degree 9 through the stage rates is of the size of its last Legendre
// coefficients. The error of the step is of the size of its square: with 10 stages of order 20 it is the product of the
// residual and that of the adjoint problem, both of order 10.
double Collocation::error(double h) const {
  const GaussTableau& tableau = gauss_tableau();
  const int n = problem_.size;
  double largest = 0;
  for (int k = 0; k < n; ++k) {
    double high = 0, low = 0;
    for (int j = 0; j < kStages; ++j) {
      const double rate = static_cast<double>(F_[j * n + k]);
      high += tableau.degree9[j] * rate;
      low += tableau.degree8[j] * rate;
    }
    largest = larger(largest, h * larger(magnitude(high), 0.1 * magnitude(low)) / scale_double_[k]);
  }
  return largest * largest;
}

Wide Collocation::step(Wide t, Wide* y, Wide limit) {
  const int n = problem_.size;
  scale_.include(y);
  if (!(proposal_ > 0)) {
    problem_.rate(t, y, rate_.data());
    ++evaluations;
    Wide fastest = 0;
    for (int k = 0; k < n; ++k) fastest = std::max(fastest, (rate_[k] < 0 ? -rate_[k] : rate_[k]) / scale_.of(k));
    proposal_ = fastest > 0 ? Wide(0.1) / fastest : limit;
  }
  const double allowed = static_cast<double>(tolerance_);
  for (int tries = 0; tries < 60; ++tries) {
    const Wide h = proposal_ >= limit ? limit : (2 * proposal_ > limit ? limit / 2 : proposal_);
    const bool solved = solve_stages(t, y, h);
    if (!solved) measure_loss(t, y, static_cast<double>(h));
    if (!(loss_ < kWholeLoss)) return 0;
    // Coefficients below the round-off of double carry no information: 1e-32 is their square.
    const double found = solved ? std::max(error(static_cast<double>(h)), 1e-36) : HUGE_VAL;
    const double factor = solved ? 0.9 * std::pow(found / allowed, -1.0 / 20) : 0.4;
    if (!(found <= 4 * allowed)) {
      proposal_ = h * Wide(std::clamp(factor, 0.1, 0.8));
      if (!(t + proposal_ > t)) return 0;
      continue;
    }
    const Wide next = h * Wide(std::clamp(factor, 0.3, 4.0));
    proposal_ = h < proposal_ ? std::max(proposal_, next) : next;
    const GaussTableau& tableau = gauss_tableau();
    last_.t = t;
    last_.span = h;
    last_.y0.assign(y, y + n);
    for (int k = 0; k < n; ++k) {
      Wide sum = 0;
      for (int j = 0; j < kStages; ++j) sum += tableau.b[j] * F_[j * n + k];
      y[k] += h * sum;
    }
    last_.y1.assign(y, y + n);
    scale_.include(y);
    ++steps;
    return h;
  }
  return 0;
}

DenseStep<Wide> Collocation::dense() {
  const int n = problem_.size;
  DenseStep<Wide> made = last_;
  made.ym = made.y0;
  for (int k = 0; k < n; ++k) {
    Wide sum = 0;
    for (int j = 0; j < kStages; ++j) sum += gauss_tableau().half[j] * F_[j * n + k];
    made.ym[k] += made.span * sum;
  }
  for (auto* f : {&made.f0, &made.fm, &made.f1}) f->resize(n);
  problem_.rate(made.t, made.y0.data(), made.f0.data());
  problem_.rate(made.t + made.span / 2, made.ym.data(), made.fm.data());
  problem_.rate(made.t + made.span, made.y1.data(), made.f1.data());
  evaluations += 3;
  return made;
}

}  // namespace atwood::extended
