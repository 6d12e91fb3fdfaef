// Suggestions for a name that does not exist: known names that differ from it by few letters.
#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "reports/command_line/command_line.hpp"

namespace atwood {
namespace {

// Edit distance: letters inserted, deleted or substituted (Levenshtein, Sov. Phys. Dokl. 10 (1966) 707), and
// neighbours exchanged (Damerau, Comm. ACM 7 (1964) 171).
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) d[i][0] = i;
  for (std::size_t j = 0; j <= b.size(); ++j) d[0][j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    for (std::size_t j = 1; j <= b.size(); ++j) {
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
    }
  }
  return d[a.size()][b.size()];
}

std::size_t common_prefix(const std::string& a, const std::string& b) {
  return static_cast<std::size_t>(std::mismatch(a.begin(), a.end(), b.begin(), b.end()).first - a.begin());
}

// One of the two names begins with the other.
bool is_beginning(const std::string& a, const std::string& b) {
  return !a.empty() && !b.empty() && (a.starts_with(b) || b.starts_with(a));
}

// Whether `name` may be meant by `word`: one begins with the other, at most a third of the word's letters is wrong, or
// at least three letters and more than half of the word are the name's beginning. What both have up to a `/` (the
// engine of a method id) does not count.
bool is_similar(std::string word, std::string name) {
  const std::size_t slash = word.rfind('/') + 1;
  if (slash > 0 && name.compare(0, slash, word, 0, slash) == 0) word.erase(0, slash), name.erase(0, slash);
  const std::size_t allowed = std::max<std::size_t>(1, (word.size() + 1) / 3), same = common_prefix(word, name);
  return is_beginning(word, name) || (word.size() > 1 && edit_distance(word, name) <= allowed) ||
         (same >= 3 && 2 * same > word.size());
}

}  // namespace

std::vector<std::string> nearest(const std::string& word, std::vector<std::string> known, std::size_t count) {
  // First those of which one begins with the other; then by edit distance less the length of the common prefix.
  const auto distance = [&](const std::string& name) {
    return static_cast<std::ptrdiff_t>(edit_distance(word, name)) -
           static_cast<std::ptrdiff_t>(common_prefix(word, name));
  };
  std::erase_if(known, [&](const std::string& name) { return !is_similar(word, name); });
  std::stable_sort(known.begin(), known.end(), [&](const auto& a, const auto& b) {
    const bool begins_a = is_beginning(a, word), begins_b = is_beginning(b, word);
    return begins_a != begins_b ? begins_a : distance(a) < distance(b);
  });
  if (known.size() > count) known.resize(count);
  return known;
}

std::string nearest_hint(const std::string& word, const std::vector<std::string>& known, std::size_t count) {
  const std::vector<std::string> near = nearest(word, known, count);
  return near.empty() ? "" : fmt::format("; nearest: {}", fmt::join(near, ", "));
}

}  // namespace atwood
