// Rows of values, one row after the other in one list. Where each row ends is stored only once rows differ in length.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace atwood {

template <class T> class RaggedArray {
 public:
  RaggedArray() = default;
  RaggedArray(std::size_t rows, std::size_t length) : values_(rows * length), rows_(rows), length_(length) {}

  std::size_t size() const { return rows_; }
  std::span<const T> operator[](std::size_t row) const {
    return {values_.data() + begin(row), begin(row + 1) - begin(row)};
  }
  std::span<T> operator[](std::size_t row) { return {values_.data() + begin(row), begin(row + 1) - begin(row)}; }
  void reserve(std::size_t rows, std::size_t each) { values_.reserve(rows * each); }
  void push_back(std::span<const T> row) {  // of another array
    values_.insert(values_.end(), row.begin(), row.end());
    if (rows_ == 0) length_ = row.size();
    else if (ends_.empty() && row.size() != length_)
      for (std::size_t k = 1; k <= rows_; ++k) ends_.push_back(k * length_);
    ++rows_;
    if (!ends_.empty()) ends_.push_back(values_.size());
  }
  void clear() { *this = {}; }       // and gives its memory back
  void truncate(std::size_t rows) {  // to the first rows
    values_.erase(values_.begin() + static_cast<std::ptrdiff_t>(begin(rows)), values_.end());
    if (!ends_.empty()) ends_.resize(rows);
    rows_ = rows;
  }

 private:
  std::size_t begin(std::size_t row) const { return row == 0 ? 0 : ends_.empty() ? row * length_ : ends_[row - 1]; }

  std::vector<T> values_;
  std::vector<std::size_t> ends_;  // empty: every row has length_ values
  std::size_t rows_ = 0, length_ = 0;
};

}  // namespace atwood
