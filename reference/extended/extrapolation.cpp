#include "extended/extrapolation.hpp"

#include <algorithm>
#include <cmath>

namespace atwood::extended {

namespace {
constexpr int kMaxColumns = 12;  // order 24
constexpr int kMinColumns = 3;

// Work of a step that ends at column k: rates 1 + sum (2 j - 1) = 1 + k^2.
double work(int column) { return 1.0 + column * column; }
}  // namespace

template <class S>
Extrapolation<S>::Extrapolation(int size, std::vector<int> group, Rate<S> rate, S tolerance)
    : size_(size), rate_(std::move(rate)), tolerance_(tolerance), scale_(size, std::move(group)), slope_(size),
      before_(size), now_(size), after_(size), dydt_(size), row_(kMaxColumns + 1, std::vector<S>(size)),
      middle_((kMaxColumns + 1) / 2, std::vector<S>(size)) {}

// z_1 = y + h f(y); z_{m+1} = z_{m-1} + 2 h f(z_m): z_n for even n. No smoothing step: the expansion of z_n is even.
template <class S> void Extrapolation<S>::midpoint(S t, const S* y, S H, int substeps, std::vector<S>& result) {
  const S h = H / substeps;
  for (int i = 0; i < size_; ++i) {
    before_[i] = y[i];
    now_[i] = y[i] + h * slope_[i];
  }
  for (int m = 1; m < substeps; ++m) {
    if (2 * m == substeps && m % 2 == 1) middle_[m / 2] = now_;
    rate_(t + m * h, now_.data(), dydt_.data());
    for (int i = 0; i < size_; ++i) {
      after_[i] = before_[i] + 2 * h * dydt_[i];
      before_[i] = now_[i];
      now_[i] = after_[i];
    }
  }
  this->evaluations += substeps - 1;
  result = now_;
}

// Aitken and Neville: row k holds T_{k,1} ... T_{k,k}; in place, row_[l] keeps T_{k,k-l+1} of the latest k:
//   T_{k,l+1} = T_{k,l} + (T_{k,l} - T_{k-1,l}) / ((k / (k-l))^2 - 1)
template <class S> int Extrapolation<S>::columns(S t, const S* y, S H, S& error) {
  for (int k = 1; k <= kMaxColumns; ++k) {
    std::vector<S>& fresh = row_[k];
    midpoint(t, y, H, 2 * k, fresh);
    // row_[j] (j < k) holds T_{k-1, k-j}; it becomes T_{k, k-j+1}.
    for (int j = k - 1; j >= 1; --j) {
      const S ratio = S(k) / S(j), factor = 1 / (ratio * ratio - 1);
      for (int i = 0; i < size_; ++i) row_[j][i] = row_[j + 1][i] + (row_[j + 1][i] - row_[j][i]) * factor;
    }
    if (k < kMinColumns) continue;
    error = 0;
    for (int i = 0; i < size_; ++i) {
      const S difference = row_[1][i] - row_[2][i];
      const S relative = (difference < 0 ? -difference : difference) / scale_.of(i);
      if (!(relative <= error)) error = relative;  // NaN stays
    }
    if (error <= tolerance_) return k;
    if (!(error < 1e6)) return 0;
  }
  return 0;
}

template <class S> S Extrapolation<S>::step(S t, S* y, S limit) {
  scale_.include(y);
  rate_(t, y, slope_.data());
  ++this->evaluations;
  if (!(proposal_ > 0)) {  // first step: 0.3 of the time in which the state changes by its own size
    S fastest = 0;
    for (int i = 0; i < size_; ++i)
      fastest = std::max(fastest, (slope_[i] < 0 ? -slope_[i] : slope_[i]) / scale_.of(i));
    proposal_ = fastest > 0 ? S(0.3) / fastest : limit;
  }
  for (int tries = 0; tries < 60; ++tries) {
    // Two equal steps to the limit rather than a full and a tiny one.
    const S H = proposal_ >= limit ? limit : (2 * proposal_ > limit ? limit / 2 : proposal_);
    S error = 0;
    const int column = columns(t, y, H, error);
    if (column == 0) {
      const double much = static_cast<double>(error / tolerance_);
      const bool measured = std::isfinite(much) && much > 0 && error < 1e6;
      const double shrink = measured ? 0.9 * std::pow(much, -1.0 / (2 * kMaxColumns - 1)) : 0.25;
      proposal_ = H * S(std::clamp(shrink, 0.1, 0.8));
      if (!(t + proposal_ > t)) return 0;
      continue;
    }
    // The step for which this column would just be accepted, and with one more column if that is cheaper per unit of
    // time.
    const double spare = std::max(static_cast<double>(error / tolerance_), 1e-30);
    double accumulate_growth = 0.9 * std::pow(spare, -1.0 / (2 * column - 1));
    if (column < kMaxColumns - 1)
      accumulate_growth = std::max(accumulate_growth, accumulate_growth * work(column + 1) / work(column));
    const S next = H * S(std::clamp(accumulate_growth, 0.3, 6.0));
    const bool cut = H < proposal_;  // the limit and not the error determined this step: keep the larger proposal
    proposal_ = cut ? std::max(proposal_, next) : next;
    last_.t = t;
    last_.span = H;
    last_.y0.assign(y, y + size_);
    last_column_ = column;
    std::copy_n(row_[1].begin(), size_, y);
    last_.y1.assign(y, y + size_);
    scale_.include(y);
    ++this->steps;
    return H;
  }
  return 0;
}

// Aitken and Neville as in columns(), with the substeps 2, 6, 10, ...
template <class S> DenseStep<S> Extrapolation<S>::dense() {
  DenseStep<S> made = last_;
  made.f0 = slope_;
  std::vector<std::vector<S>> row(middle_.begin(), middle_.begin() + (last_column_ + 1) / 2);
  for (std::size_t k = 1; k < row.size(); ++k)
    for (std::size_t j = k; j-- > 0;) {
      const S ratio = S(static_cast<double>(2 * k + 1)) / S(static_cast<double>(2 * j + 1)),
              factor = 1 / (ratio * ratio - 1);
      for (int i = 0; i < size_; ++i) row[j][i] = row[j + 1][i] + (row[j + 1][i] - row[j][i]) * factor;
    }
  made.ym = row.front();
  made.fm.resize(size_);
  made.f1.resize(size_);
  rate_(made.t + made.span / 2, made.ym.data(), made.fm.data());
  rate_(made.t + made.span, made.y1.data(), made.f1.data());
  this->evaluations += 2;
  return made;
}

template class Extrapolation<double>;
template class Extrapolation<long double>;
template class Extrapolation<Wide>;

}  // namespace atwood::extended
