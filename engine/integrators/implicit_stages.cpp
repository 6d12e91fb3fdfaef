#include "integrators/implicit_stages.hpp"

#include <algorithm>
#include <cmath>

namespace atwood {
namespace {

std::vector<Quad> inverse(const std::vector<Quad>& a, int n) {
  DenseLu<Quad> lu(n);
  lu.entry = a;
  lu.factor();
  std::vector<Quad> result(a.size());
  for (int j = 0; j < n; ++j) {
    std::vector<Quad> column(n, Quad(0));
    column[j] = Quad(1);
    lu.solve(column.data());
    for (int i = 0; i < n; ++i) result[i * n + j] = column[i];
  }
  return result;
}

template <class S> constexpr S kHuge = S(1e30f);

// With a constant ratio of successive changes the further changes are a geometric series; whether its sum is below a
// thousandth of an ulp.
template <class S> bool further_changes_are_negligible(S now, S before) {
  if (now == S(0)) return true;
  return before < kHuge<S> && now <= before / S(2) && now * (now / before) * S(2) < real::epsilon<S>() / S(1024);
}

// The sum of that series, as a residual.
template <class S> S sum_of_further_changes(S now, S before) { return now == S(0) ? now : now * (now / before) * S(2); }

}  // namespace

template <class S>
StageSolver<S>::StageSolver(int size, std::vector<Quad> a)
    : size_(size), stages_(static_cast<int>(std::lround(std::sqrt(static_cast<double>(a.size()))))),
      a_(a.begin(), a.end()), guess_(static_cast<std::size_t>(size) * stages_), right_(guess_.size()),
      change_(guess_.size()), shifted_(guess_.size()), held_(stages_),
      lu_(size * stages_ <= largest_newton ? size * stages_ : 0) {
  for (const Quad& entry : inverse(a, stages_)) a_inverse_.push_back(S(entry));
  if (lu_.size > 0) jacobian_.resize(static_cast<std::size_t>(size) * size * stages_);
}

template <class S>
bool StageSolver<S>::solve(Rates rates, void* context, S h_s, const S* y, const S* known, S* z, S* k) {
  rates_ = rates;
  context_ = context;
  h_s_ = h_s;
  y_ = y;
  known_ = known;
  std::copy(z, z + guess_.size(), guess_.begin());
  took_newton_ = false;
  report_ = {};
  if (sweep(z, k) == Progress::solved) return true;
  if (lu_.size == 0) return false;
  took_newton_ = true;
  std::fill(z, z + guess_.size(), S(0));  // the start of the step: the guess of a stiff system may be far off
  if (newton(z, k) == Progress::solved) return true;
  std::copy(guess_.begin(), guess_.end(), z);
  return newton(z, k) == Progress::solved;
}

// Largest change of a component, relative to that component or to a thousandth of the largest.
template <class S> S StageSolver<S>::relative_size(const S* change, const S* z) const {
  S bulk = S(0);
  for (int i = 0; i < size_; ++i)
    for (int s = 0; s < stages_; ++s) bulk = real::max(bulk, real::abs(y_[i]) + real::abs(z[i * stages_ + s]));
  if (bulk == S(0)) bulk = S(1);
  S largest = S(0);
  for (int i = 0; i < size_; ++i)
    for (int s = 0; s < stages_; ++s) {
      const int at = i * stages_ + s;
      const S ratio = real::abs(change[at]) / real::max(real::abs(y_[i]) + real::abs(z[at]), bulk * S(1e-3));
      if (!(ratio <= largest)) largest = ratio;  // keeps NaN
    }
  return largest;
}

template <class S> auto StageSolver<S>::end(Progress progress, SolveEnd ended, int iterations, S residual) -> Progress {
  report_.iterations += iterations;
  report_.residual = static_cast<double>(residual);
  report_.ended = ended;
  return progress;
}

template <class S> void StageSolver<S>::evaluate_right_side(const S* k, S* right) const {
  const int n = stages_;
  for (int i = 0; i < size_; ++i)
    for (int s = 0; s < n; ++s) {
      S sum = S(0);
      for (int j = 0; j < n; ++j) sum += a_[s * n + j] * k[i * n + j];
      right[i * n + s] = known_[i * n + s] + h_s_ * sum;
    }
}

// z <- known + h A k(z). z is computed from the k of the last sweep, so z and k satisfy the equations.
template <class S> auto StageSolver<S>::sweep(S* z, S* k) -> Progress {
  constexpr int max_sweeps = 150;
  S before = kHuge<S>;
  for (int n = 0; n < max_sweeps; ++n) {
    rates_(context_, z, k);
    evaluate_right_side(k, right_.data());
    for (std::size_t i = 0; i < right_.size(); ++i) {
      change_[i] = right_[i] - z[i];
      z[i] = right_[i];
    }
    const S now = relative_size(change_.data(), z);
    if (!(now < kHuge<S>)) return end(Progress::failed, SolveEnd::capped, n + 1, now);
    if (further_changes_are_negligible(now, before))
      return end(Progress::solved, SolveEnd::converged, n + 1, sum_of_further_changes(now, before));
    if (now >= before / S(2)) {
      if (now <= S(256) * real::epsilon<S>()) return end(Progress::solved, SolveEnd::stagnated, n + 1, now);
      if (n > 2) return end(Progress::slow, SolveEnd::capped, n + 1, now);
    }
    before = now;
  }
  return end(Progress::slow, SolveEnd::capped, max_sweeps, before);
}

// Jacobian of z - known - h A k(z): block (s, j) is delta_sj - h a_sj dk_j/dz_j. Differences perturb one component in
// all stages at once.
template <class S> void StageSolver<S>::factor_jacobian(S* z, const S* k) {
  const int n = stages_;
  const S root = real::sqrt(real::epsilon<S>());
  S bulk = S(0);
  for (int i = 0; i < size_; ++i) bulk = real::max(bulk, real::abs(y_[i]) + real::abs(z[i * n]));
  for (int c = 0; c < size_; ++c) {
    const S shift = root * real::max(real::abs(y_[c]) + real::abs(z[c * n]), real::max(bulk * S(1e-3), S(1e-6)));
    for (int s = 0; s < n; ++s) {
      held_[s] = z[c * n + s];
      z[c * n + s] += shift;
    }
    rates_(context_, z, shifted_.data());
    for (int s = 0; s < n; ++s) {
      const S moved = z[c * n + s] - held_[s];
      z[c * n + s] = held_[s];
      for (int i = 0; i < size_; ++i) jacobian_[(i * size_ + c) * n + s] = (shifted_[i * n + s] - k[i * n + s]) / moved;
    }
  }
  for (int i = 0; i < size_; ++i)
    for (int s = 0; s < n; ++s)
      for (int c = 0; c < size_; ++c)
        for (int j = 0; j < n; ++j)
          lu_.at(i * n + s, c * n + j) =
              (i == c && s == j ? S(1) : S(0)) - h_s_ * a_[s * n + j] * jacobian_[(i * size_ + c) * n + j];
  lu_.factor();
}

// At the end k = A^-1 (z - known) / h: a rate evaluated at a stiff stage would multiply the round-off of z by h lambda
// (Shampine, ACM Trans. Math. Softw. 6 (1980) 420).
template <class S> auto StageSolver<S>::newton(S* z, S* k) -> Progress {
  const int n = stages_;
  S before = kHuge<S>, now = before;
  bool solved = false, factor = true;
  int iteration = 0;
  for (; iteration < 80 && !solved; ++iteration) {
    rates_(context_, z, k);
    const bool fresh = factor;
    if (fresh) factor_jacobian(z, k);
    evaluate_right_side(k, right_.data());
    for (std::size_t i = 0; i < right_.size(); ++i) change_[i] = right_[i] - z[i];
    lu_.solve(change_.data());
    for (std::size_t i = 0; i < change_.size(); ++i) z[i] += change_[i];
    now = relative_size(change_.data(), z);
    if (!(now < kHuge<S>)) return end(Progress::failed, SolveEnd::capped, iteration + 1, now);
    const bool converged = further_changes_are_negligible(now, before);
    solved = converged || (now >= before / S(2) && now <= S(4096) * real::epsilon<S>());
    if (converged) end(Progress::solved, SolveEnd::converged, iteration + 1, sum_of_further_changes(now, before));
    else if (solved) end(Progress::solved, SolveEnd::stagnated, iteration + 1, now);
    factor = now > before / S(16);
    if (!solved && !fresh && now > before / S(2))  // the old Jacobian failed: undo the step, continue with a new one
      for (std::size_t i = 0; i < change_.size(); ++i) z[i] -= change_[i];
    else before = now;
  }
  if (!solved) return end(Progress::failed, SolveEnd::capped, iteration, now);
  for (int i = 0; i < size_; ++i)
    for (int s = 0; s < n; ++s) {
      S sum = S(0);
      for (int j = 0; j < n; ++j) sum += a_inverse_[s * n + j] * (z[i * n + j] - known_[i * n + j]);
      k[i * n + s] = sum / h_s_;
    }
  return Progress::solved;
}

template class StageSolver<float>;
template class StageSolver<double>;
template class StageSolver<long double>;
template class StageSolver<Quad>;

}  // namespace atwood
