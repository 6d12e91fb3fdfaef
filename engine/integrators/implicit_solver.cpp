#include "integrators/implicit_solver.hpp"

#include <algorithm>

namespace atwood {

template <class S>
ImplicitSolver<S>::ImplicitSolver(int size) : size_(size), g_(size), change_(size), shifted_(size), lu_(size) {}

// Largest change of a component, relative to it or to a thousandth of the largest component.
template <class S> S ImplicitSolver<S>::relative_size(const S* change, const S* z) const {
  S bulk = S(0);
  for (int i = 0; i < size_; ++i) bulk = real::max(bulk, real::abs(z[i]));
  if (bulk == S(0)) bulk = S(1);
  S largest = S(0);
  for (int i = 0; i < size_; ++i) {
    const S ratio = real::abs(change[i]) / (real::abs(z[i]) + bulk * S(1e-3));
    if (!(ratio <= largest)) largest = ratio;  // keeps NaN
  }
  return largest;
}

template <class S> bool ImplicitSolver<S>::solve(Function g, void* context, S t_s, S c_s, const S* y0, S* z) {
  report_ = {};
  return sweep(g, context, t_s, c_s, y0, z) == Progress::solved || newton(g, context, t_s, c_s, y0, z);
}

template <class S> bool ImplicitSolver<S>::end(SolveEnd ended, int iterations, S residual) {
  report_.iterations += iterations;
  report_.residual = static_cast<double>(residual);
  report_.ended = ended;
  return ended != SolveEnd::capped;
}

// z <- y0 + c g(z). Converged when a sweep changes only the last digits, stagnated when the changes no longer shrink.
template <class S>
auto ImplicitSolver<S>::sweep(Function g, void* context, S t_s, S c_s, const S* y0, S* z) -> Progress {
  constexpr int max_iterations = 40;
  S before = S(1e30f);
  for (int k = 0; k < max_iterations; ++k) {
    g(context, t_s, z, g_.data());
    for (int i = 0; i < size_; ++i) {
      const S next = y0[i] + c_s * g_[i];
      change_[i] = next - z[i];
      z[i] = next;
    }
    const S now = relative_size(change_.data(), z);
    const bool converged = now <= real::epsilon<S>();
    if (converged || (now <= S(64) * real::epsilon<S>() && now >= before / S(2))) {
      end(converged ? SolveEnd::converged : SolveEnd::stagnated, k + 1, now);
      return Progress::solved;
    }
    if (!(now < S(1e30f)) || (k > 2 && now > before / S(4)) || k + 1 == max_iterations) {
      end(SolveEnd::capped, k + 1, now);
      return Progress::slow;
    }
    before = now;
  }
  return Progress::slow;
}

template <class S> void ImplicitSolver<S>::factor_jacobian(Function g, void* context, S t_s, S c_s, S* z) {
  const S root = real::sqrt(real::epsilon<S>());
  S bulk = S(0);
  for (int i = 0; i < size_; ++i) bulk = real::max(bulk, real::abs(z[i]));
  g(context, t_s, z, g_.data());
  for (int j = 0; j < size_; ++j) {
    const S here = z[j];
    z[j] = here + root * real::max(real::abs(here), real::max(bulk * S(1e-3), S(1e-6)));
    const S step = z[j] - here;
    g(context, t_s, z, shifted_.data());
    z[j] = here;
    for (int i = 0; i < size_; ++i) lu_.at(i, j) = (i == j ? S(1) : S(0)) - c_s * (shifted_[i] - g_[i]) / step;
  }
  lu_.factor();
}

// Simplified Newton iteration from y0: the Jacobian is formed again when the iteration contracts too slowly.
template <class S> bool ImplicitSolver<S>::newton(Function g, void* context, S t_s, S c_s, const S* y0, S* z) {
  std::copy(y0, y0 + size_, z);
  factor_jacobian(g, context, t_s, c_s, z);
  constexpr int max_iterations = 60;
  S before = S(1e30f);
  for (int k = 0; k < max_iterations; ++k) {
    g(context, t_s, z, g_.data());
    for (int i = 0; i < size_; ++i) change_[i] = y0[i] + c_s * g_[i] - z[i];
    lu_.solve(change_.data());
    for (int i = 0; i < size_; ++i) z[i] += change_[i];
    const S now = relative_size(change_.data(), z);
    if (!(now < S(1e30f))) return end(SolveEnd::capped, k + 1, now);
    if (now <= S(2) * real::epsilon<S>()) return end(SolveEnd::converged, k + 1, now);
    if (now <= S(1024) * real::epsilon<S>() && now >= before / S(2)) return end(SolveEnd::stagnated, k + 1, now);
    if (k + 1 == max_iterations) return end(SolveEnd::capped, max_iterations, now);
    if (now > before / S(10)) factor_jacobian(g, context, t_s, c_s, z);
    before = now;
  }
  return false;
}

template class ImplicitSolver<float>;
template class ImplicitSolver<double>;
template class ImplicitSolver<long double>;
template class ImplicitSolver<Quad>;

}  // namespace atwood
