// The least change that satisfies linear equations, in __float128: minimise dx^T M dx subject to A dx = -r.
#pragma once

#include <vector>

#include "scene/quad_vectors.hpp"

namespace atwood {

// The lower triangle by rows.
class SymmetricMatrix {
 public:
  explicit SymmetricMatrix(std::size_t size) : size_(size), entries_(size * (size + 1) / 2) {}
  std::size_t size() const { return size_; }
  quad::Real& at(std::size_t i, std::size_t j) { return entries_[i * (i + 1) / 2 + j]; }  // j <= i
  quad::Real at(std::size_t i, std::size_t j) const { return entries_[i * (i + 1) / 2 + j]; }

 private:
  std::size_t size_;
  std::vector<quad::Real> entries_;
};

// With M = L L^T and B = L^-1 A^T = Q R P^T (Gram-Schmidt, twice, with column pivoting): dx = -L^-T Q R^-T P^T r.
// Columns that are left with less than `rank_tolerance` of the largest one's length are dependent and their equations
// left out.
class LeastChange {
 public:
  // `rows` of A, each with the size of M, which is symmetric and positive definite.
  LeastChange(SymmetricMatrix mass, const std::vector<std::vector<quad::Real>>& rows, double rank_tolerance);
  std::vector<quad::Real> change(const std::vector<quad::Real>& residuals) const;
  std::size_t rank() const { return basis_.size(); }

 private:
  SymmetricMatrix lower_;                       // L
  std::vector<std::vector<quad::Real>> basis_;  // orthonormal columns of Q
  std::vector<std::vector<quad::Real>> upper_;  // column k of R: its entries 0 to k
  std::vector<std::size_t> pivots_;             // the row of A behind column k
};

}  // namespace atwood
