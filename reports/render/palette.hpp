// Colours of the terminal, or none; columns.
#pragma once

#include <algorithm>
#include <string>

#include "text.hpp"

namespace atwood {

struct Palette {
  const char *red, *green, *yellow, *dim, *bold, *off;
};
constexpr Palette kColours{"\x1b[31m", "\x1b[32m", "\x1b[33m", "\x1b[2m", "\x1b[1m", "\x1b[0m"};
constexpr Palette kPlain{"", "", "", "", "", ""};

inline std::string padded(const std::string& text, std::size_t width) {
  return text + std::string(width - std::min(width, display_width(text)), ' ');
}
inline std::string right(const std::string& text, std::size_t width) {
  return std::string(width - std::min(width, display_width(text)), ' ') + text;
}

}  // namespace atwood
