// Reading of comma-separated tables: quotes as in RFC 4180, no line breaks inside cells.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace atwood {

// The lines of a table, one after another. Empty lines are left out, and so are comments, which begin with #. Spaces
// around a cell do not count unless they stand in quotes. A byte order mark in UTF-8 at the beginning is left out.
class CsvReader {
 public:
  static constexpr std::size_t kMaxCells = 4096;
  // `name` stands for the file in messages.
  CsvReader(std::string text, std::string name);

  // False: the table has ended, and `cells` is empty. InputError: a row of more than kMaxCells.
  bool next(std::vector<std::string>& cells);
  int line() const { return line_; }                                      // of the last cells, from 1
  const std::vector<std::string>& comments() const { return comments_; }  // up to here, with their #; the first 1000

 private:
  std::string text_, name_;
  std::size_t at_ = 0;
  int line_ = 0;
  std::vector<std::string> comments_;
};

}  // namespace atwood
