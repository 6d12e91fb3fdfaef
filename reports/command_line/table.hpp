// A table on standard output as other programs read it.
#pragma once

#include <string>
#include <vector>

namespace atwood {

// A field of CSV, in quotes where it needs them (RFC 4180), with an apostrophe in front where a spreadsheet would take
// it for a formula.
std::string quoted(const std::string& text);

// CSV lines, or with `json` one array of objects with the columns as keys. A column of names or words holds strings; in
// the others a number is a JSON number with all its digits (of a truth up to 36), and what is not a number within the
// range of double is the string that CSV has: `nan`, `inf`, `not unique`, nothing.
class Table {
 public:
  Table(const std::string& columns, bool json);
  ~Table();
  Table(const Table&) = delete;
  Table& operator=(const Table&) = delete;

  void row(const std::string& line);  // CSV

 private:
  bool json_, first_ = true;
  std::vector<std::string> columns_;
};

}  // namespace atwood
