#include "scene/printable.hpp"

#include <algorithm>

namespace atwood {
namespace {

// Length of the well-formed UTF-8 sequence at the front of `text`, 0 if there is none (RFC 3629).
std::size_t utf8_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u; };
  const auto follows = [&](std::size_t i) { return (byte(i) & 0xC0u) == 0x80u; };
  const unsigned first = byte(0);
  if (first < 0x80) return 1;
  if (first >= 0xC2 && first <= 0xDF && follows(1)) return 2;
  const bool overlong3 = first == 0xE0 && byte(1) < 0xA0, surrogate = first == 0xED && byte(1) >= 0xA0;
  if (first >= 0xE0 && first <= 0xEF && follows(1) && follows(2) && !overlong3 && !surrogate) return 3;
  const bool overlong4 = first == 0xF0 && byte(1) < 0x90, beyond = first == 0xF4 && byte(1) >= 0x90;
  if (first >= 0xF0 && first <= 0xF4 && follows(1) && follows(2) && follows(3) && !overlong4 && !beyond) return 4;
  return 0;
}

// Control characters of one and of two bytes (C0, DEL, C1), and those that turn the direction of writing
// (U+202A to U+202E, U+2066 to U+2069).
bool acts(std::string_view sequence) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(sequence[i]); };
  if (sequence.size() == 1) return byte(0) < 0x20 || byte(0) == 0x7f;
  if (sequence.size() == 2) return byte(0) == 0xC2 && byte(1) < 0xA0;
  if (sequence.size() != 3 || byte(0) != 0xE2) return false;
  return (byte(1) == 0x80 && byte(2) >= 0xAA && byte(2) <= 0xAE) ||
         (byte(1) == 0x81 && byte(2) >= 0xA6 && byte(2) <= 0xA9);
}

// The length of the escape sequence at the front (ECMA-48): CSI with its parameters and final byte; OSC and the other
// strings to their end, BEL or ESC \; 0 when there is none.
std::size_t escape_length(std::string_view text) {
  if (text.size() < 2 || text[0] != '\x1b') return 0;
  std::size_t i = 2;
  if (text[1] == '[') {
    while (i < text.size() && text[i] >= 0x20 && text[i] < 0x40) ++i;
    return i < text.size() && text[i] >= '@' && text[i] <= '~' ? i + 1 : i;
  }
  if (std::string_view("]PX^_").find(text[1]) == std::string_view::npos) return 0;
  while (i < text.size() && text[i] != '\n' && text[i] != '\a' && text[i] != '\x1b') ++i;
  if (i < text.size() && text[i] == '\a') return i + 1;
  return i + 1 < text.size() && text[i] == '\x1b' && text[i + 1] == '\\' ? i + 2 : i;
}

std::string cleaned(std::string_view text, const char* line_break) {
  std::string out;
  while (!text.empty()) {
    if (const std::size_t length = escape_length(text); length > 0) {
      text.remove_prefix(length);
      continue;
    }
    const std::size_t length = utf8_length(text);
    const std::string_view sequence = text.substr(0, std::max<std::size_t>(length, 1));
    if (text.front() == '\n') out += line_break;
    else if (text.front() == '\t') out += ' ';
    else if (length == 0) out += "\xEF\xBF\xBD";
    else if (!acts(sequence)) out += sequence;
    text.remove_prefix(sequence.size());
  }
  return out;
}

}  // namespace

std::string printable(std::string_view text) {
  const std::string out = cleaned(text, " | ");
  const std::size_t last = out.find_last_not_of(" |");
  return last == std::string::npos ? "" : out.substr(0, last + 1);
}

namespace {

bool reads_as_formula(const std::string& text) {
  const std::size_t first = text.find_first_not_of('\'');
  return first != std::string::npos && std::string_view("=+-@\t\r").find(text[first]) != std::string_view::npos;
}

}  // namespace

std::string guarded_cell(const std::string& text) { return reads_as_formula(text) ? "'" + text : text; }

std::string unguarded_cell(const std::string& cell) {
  return !cell.empty() && cell.front() == '\'' && reads_as_formula(cell) ? cell.substr(1) : cell;
}

std::string printable_lines(std::string_view text) { return cleaned(text, "\n"); }

bool is_printable(std::string_view text) {
  std::string with_spaces(text);
  std::replace(with_spaces.begin(), with_spaces.end(), '\t', ' ');
  return printable_lines(with_spaces) == with_spaces;
}

}  // namespace atwood
