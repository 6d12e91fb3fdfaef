#include "scene/least_change.hpp"

namespace atwood {

using quad::Real;

namespace {

using Column = std::vector<Real>;

Real dot(const Column& a, const Column& b) {
  Real sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (a[i] != 0 && b[i] != 0) sum += a[i] * b[i];
  return sum;
}

// Cholesky's decomposition in place. A pivot of 0 (a freedom without mass) becomes 1: the freedom then is as heavy as a
// unit of its own.
void decompose(SymmetricMatrix& m) {
  for (std::size_t i = 0; i < m.size(); ++i)
    for (std::size_t j = 0; j <= i; ++j) {
      Real sum = m.at(i, j);
      for (std::size_t k = 0; k < j; ++k)
        if (m.at(i, k) != 0) sum -= m.at(i, k) * m.at(j, k);
      if (i == j) m.at(i, i) = sum > 0 ? sqrtq(sum) : Real(1);
      else m.at(i, j) = sum == 0 ? Real(0) : sum / m.at(j, j);
    }
}

void solve_lower(const SymmetricMatrix& l, Column& x) {
  for (std::size_t i = 0; i < l.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k)
      if (x[k] != 0) x[i] -= l.at(i, k) * x[k];
    x[i] /= l.at(i, i);
  }
}
void solve_upper(const SymmetricMatrix& l, Column& x) {
  for (std::size_t i = l.size(); i-- > 0;) {
    x[i] /= l.at(i, i);
    for (std::size_t k = 0; k < i; ++k) x[k] -= l.at(i, k) * x[i];
  }
}

}  // namespace

LeastChange::LeastChange(SymmetricMatrix mass, const std::vector<std::vector<Real>>& rows, double rank_tolerance)
    : lower_(std::move(mass)) {
  decompose(lower_);
  std::vector<Column> columns = rows;  // reduced by the basis as it grows
  std::vector<Real> squares;
  Real most = 0;
  for (Column& column : columns) {
    solve_lower(lower_, column);
    squares.push_back(dot(column, column));
    most = fmaxq(most, squares.back());
  }
  const std::vector<Column> whole = columns;
  std::vector<bool> used(columns.size());
  const Real least = most * Real(rank_tolerance) * rank_tolerance;
  while (basis_.size() < lower_.size()) {
    std::size_t pivot = columns.size();
    for (std::size_t c = 0; c < columns.size(); ++c)
      if (!used[c] && squares[c] > least && (pivot == columns.size() || squares[c] > squares[pivot])) pivot = c;
    if (pivot == columns.size()) break;
    used[pivot] = true;
    Column next = columns[pivot];
    for (const Column& q : basis_) {  // the second time
      const Real part = dot(q, next);
      for (std::size_t i = 0; i < next.size(); ++i) next[i] -= part * q[i];
    }
    const Real length = sqrtq(dot(next, next));
    for (Real& x : next) x /= length;
    Column r;
    for (const Column& q : basis_) r.push_back(dot(q, whole[pivot]));
    r.push_back(dot(next, whole[pivot]));
    basis_.push_back(next);
    upper_.push_back(std::move(r));
    pivots_.push_back(pivot);
    for (std::size_t c = 0; c < columns.size(); ++c) {
      if (used[c] || squares[c] == 0) continue;
      const Real part = dot(next, columns[c]);
      if (part == 0) continue;
      for (std::size_t i = 0; i < next.size(); ++i) columns[c][i] -= part * next[i];
      squares[c] = dot(columns[c], columns[c]);
    }
  }
}

std::vector<Real> LeastChange::change(const std::vector<Real>& residuals) const {
  // R^T z = -P^T r, dx = L^-T Q z.
  Column z(basis_.size()), out(lower_.size());
  for (std::size_t k = 0; k < z.size(); ++k) {
    Real sum = -residuals[pivots_[k]];
    for (std::size_t i = 0; i < k; ++i) sum -= upper_[k][i] * z[i];
    z[k] = sum / upper_[k][k];
    for (std::size_t i = 0; i < out.size(); ++i) out[i] += z[k] * basis_[k][i];
  }
  solve_upper(lower_, out);
  return out;
}

}  // namespace atwood
