#include "scene/csv.hpp"

#include <algorithm>
#include <string_view>

#include "scene/files.hpp"

namespace atwood {
namespace {

constexpr std::size_t kMaxComments = 1000;  // that are kept

// Characters of `line` up to the next comma outside quotes go to `cell`; `line` begins behind that comma. False: the
// line has ended.
bool take_cell(std::string_view& line, std::string& cell) {
  bool quoted = false;
  std::size_t kept = 0;  // of the cell, that spaces at its end do not belong to
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (c == ',' && !quoted) {
      cell.resize(kept);
      line.remove_prefix(i + 1);
      return true;
    }
    if (c == '"' && quoted && i + 1 < line.size() && line[i + 1] == '"') cell += line[++i];
    else if (c == '"') quoted = !quoted;
    else if (quoted || c != ' ' || !cell.empty()) cell += c;
    if (quoted || c != ' ') kept = cell.size();
  }
  cell.resize(kept);
  return false;
}

}  // namespace

CsvReader::CsvReader(std::string text, std::string name) : text_(std::move(text)), name_(std::move(name)) {
  if (text_.starts_with("\xEF\xBB\xBF")) at_ = 3;
}

bool CsvReader::next(std::vector<std::string>& cells) {
  cells.clear();
  while (at_ < text_.size()) {
    const std::size_t end = std::min(text_.find('\n', at_), text_.size());
    std::string_view line = std::string_view(text_).substr(at_, end - at_);
    at_ = end + 1;
    ++line_;
    if (line.ends_with('\r')) line.remove_suffix(1);
    if (line.empty()) continue;
    if (line.front() == '#') {
      if (comments_.size() < kMaxComments) comments_.emplace_back(line);
      continue;
    }
    for (bool more = true; more;) {
      if (cells.size() == kMaxCells)
        throw InputError(name_ + ":" + std::to_string(line_) + ":1: found more than " + std::to_string(kMaxCells) +
                         " cells; expected fewer");
      more = take_cell(line, cells.emplace_back());
    }
    return true;
  }
  return false;
}

}  // namespace atwood
