// Shortens text of other programs for messages.
#pragma once

#include <string>

namespace atwood {

inline constexpr std::size_t kLongestReason = 2000;

// At most about `most` bytes: the beginning and the end of the text, with the number of omitted bytes between them.
// UTF-8 characters are not cut.
inline std::string shortened(const std::string& text, std::size_t most) {
  if (text.size() <= most) return text;
  const auto continues = [&](std::size_t i) { return (static_cast<unsigned char>(text[i]) & 0xC0u) == 0x80u; };
  std::size_t begin = most / 2, end = text.size() - most / 2;
  while (begin > 0 && continues(begin)) --begin;
  while (end < text.size() && continues(end)) ++end;
  return text.substr(0, begin) + " [... " + std::to_string(end - begin) + " bytes ...] " + text.substr(end);
}

}  // namespace atwood
