// Names near to one that does not exist: what the writer may have meant.
#include <algorithm>

#include "reports/command_line/command_line.hpp"

namespace atwood {
namespace {

// How many letters apart two words are (Levenshtein, Sov. Phys. Dokl. 10 (1966) 707).
std::size_t letters_apart(const std::string& a, const std::string& b) {
  std::vector<std::size_t> before(b.size() + 1), now(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) before[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    now[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      now[j] = std::min({before[j] + 1, now[j - 1] + 1, before[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
    }
    before.swap(now);
  }
  return before[b.size()];
}

}  // namespace

std::vector<std::string> nearest(const std::string& word, std::vector<std::string> known, std::size_t count) {
  // Names that begin with the word, or the word with one of them, are meant rather than those that are a few letters
  // off; among the latter, each letter that they begin with in common counts for one that is off.
  const auto begins = [&](const std::string& name) { return name.starts_with(word) || word.starts_with(name); };
  const auto distance = [&](const std::string& name) {
    const auto common = std::mismatch(word.begin(), word.end(), name.begin(), name.end()).first - word.begin();
    return static_cast<std::ptrdiff_t>(letters_apart(word, name)) - common;
  };
  std::stable_sort(known.begin(), known.end(), [&](const auto& a, const auto& b) {
    return begins(a) != begins(b) ? begins(a) : distance(a) < distance(b);
  });
  if (known.size() > count) known.resize(count);
  return known;
}

}  // namespace atwood
