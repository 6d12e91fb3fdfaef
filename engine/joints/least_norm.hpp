// The smallest z that satisfies dependent or independent equations A^T z = b: QR factorisation with column pivoting.
//
// The columns of A, one an equation, are scaled so that their length is 1 where nothing cancels. A Pi = Q R with the
// largest remaining column first (Businger and Golub, Numer. Math. 7 (1965) 269; Golub and Van Loan, Matrix
// Computations, 4th ed., section 5.4.2); a column whose remainder is below tolerance * max(1, its norm) is treated as
// dependent on those before it, and its equation is not used. With R1 the leading block of size rank, z = Q (R1^-T b1,
// 0). Nothing like A^T A is formed, so the condition of A is not squared. A multiplier of each used equation, x with A
// x = z, follows as x = R1^-1 R1^-T b1; the others get 0.
#pragma once

#include <cmath>
#include <utility>
#include <vector>

#include "math/scalar.hpp"

namespace atwood {

template <class S> class LeastNorm {
 public:
  // Room for `rows` x `columns`.
  void resize(int rows, int columns) {
    rows_ = rows;
    columns_ = columns;
    a_.resize(static_cast<std::size_t>(rows) * columns);
    for (auto* room : {&square_, &length_, &scale_, &diagonal_, &y_}) room->resize(columns);
    order_.resize(columns);
  }
  int rows() const { return rows_; }
  int columns() const { return columns_; }
  S* column(int j) { return a_.data() + static_cast<std::size_t>(j) * rows_; }  // to be filled before factor()

  // Overwrites the columns.
  void factor(S tolerance) {
    for (int j = 0; j < columns_; ++j) {
      order_[j] = j;
      square_[j] = square_from(j, 0);
      length_[j] = real::max(S(1), real::sqrt(square_[j]));
    }
    const int most = rows_ < columns_ ? rows_ : columns_;
    for (rank_ = 0; rank_ < most; ++rank_) {
      const int k = rank_;
      int best = -1;
      for (int j = k; j < columns_; ++j) {
        const S least = tolerance * length_[j];
        if (square_[j] > least * least && (best < 0 || square_[j] > square_[best])) best = j;
      }
      if (best < 0) return;
      exchange(k, best);
      const S length = real::sqrt(square_from(k, k));
      reflect(k, length);
    }
  }
  int rank() const { return rank_; }
  // The equation that came k-th, and the size of its pivot: the norm of its column's remainder after those before it.
  int equation(int k) const { return order_[k]; }
  S pivot(int k) const { return real::abs(diagonal_[k]); }

  // z: rows() scalars; b: columns() scalars.
  void solve(const S* b, S* z) {
    for (int k = 0; k < rank_; ++k) {
      const S* c = column(k);
      S left = b[order_[k]];
      for (int i = 0; i < k; ++i) left -= c[i] * y_[i];
      y_[k] = left / diagonal_[k];
    }
    for (int i = 0; i < rows_; ++i) z[i] = i < rank_ ? y_[i] : S(0);
    for (int k = rank_ - 1; k >= 0; --k) apply(k, z);
  }
  // Of the last solve(); x: columns() scalars.
  void multipliers(S* x) {
    for (int j = 0; j < columns_; ++j) x[j] = S(0);
    for (int k = rank_ - 1; k >= 0; --k) {
      S left = y_[k];
      for (int j = k + 1; j < rank_; ++j) left -= column(j)[k] * x[order_[j]];
      x[order_[k]] = left / diagonal_[k];
    }
  }
  // What each equation beyond the rank takes of those before it: equation(j) = sum over k < rank of w_k equation(k).
  void dependence(int j, S* w) {
    for (int k = rank_ - 1; k >= 0; --k) {
      S left = column(j)[k];
      for (int i = k + 1; i < rank_; ++i) left -= column(i)[k] * w[i];
      w[k] = left / diagonal_[k];
    }
  }

 private:
  S square_from(int j, int from) {
    const S* c = column(j);
    S sum = S(0);
    for (int i = from; i < rows_; ++i) sum += c[i] * c[i];
    return sum;
  }
  void exchange(int k, int best) {
    if (k == best) return;
    S *a = column(k), *b = column(best);
    for (int i = 0; i < rows_; ++i) std::swap(a[i], b[i]);
    std::swap(order_[k], order_[best]);
    square_[best] = square_[k];
    std::swap(length_[k], length_[best]);
  }
  // The reflection I - v v^T / scale that turns what is left of column k into a multiple of its first component; v
  // stays in the column from its row k on, R's diagonal apart.
  void reflect(int k, S length) {
    S* v = column(k);
    const S first = v[k];
    diagonal_[k] = first > S(0) ? -length : length;
    v[k] = first - diagonal_[k];
    scale_[k] = -diagonal_[k] * v[k];  // |v|^2 / 2
    for (int j = k + 1; j < columns_; ++j) {
      S* c = column(j);
      apply(k, c);
      const S before = square_[j], after = before - c[k] * c[k];
      square_[j] = after > S(0.01) * before ? after : square_from(j, k + 1);
    }
  }
  void apply(int k, S* c) {
    const S* v = column(k);
    S sum = S(0);
    for (int i = k; i < rows_; ++i) sum += v[i] * c[i];
    sum /= scale_[k];
    for (int i = k; i < rows_; ++i) c[i] -= sum * v[i];
  }

  int rows_ = 0, columns_ = 0, rank_ = 0;
  std::vector<S> a_, square_, length_, scale_, diagonal_, y_;
  std::vector<int> order_;
};

}  // namespace atwood
