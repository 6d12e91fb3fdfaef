// The command that reruns a cell: words first, a shell's line where it is printed.
#include <algorithm>
#include <cctype>

#include "validation/gates/gates.hpp"

namespace atwood {
namespace {

bool plain(const std::string& word) {
  return !word.empty() && std::all_of(word.begin(), word.end(), [](unsigned char c) {
    return c < 0x80 &&
           (std::isalnum(c) || std::string_view("/.:,+-_@=%").find(static_cast<char>(c)) != std::string::npos);
  });
}

// Bytes of the character that begins at `at`: 0 where it is broken UTF-8, a C1 control, or one that turns the direction of
// text around.
std::size_t printable_character(std::string_view text, std::size_t at) {
  const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u; };
  const unsigned first = byte(at);
  if (first < 0x80) return first >= 0x20 && first != 0x7f ? 1 : 0;
  const std::size_t length = first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : first >= 0xc2 ? 2 : 0;
  if (length == 0 || first > 0xf4) return 0;
  unsigned code = first & (0x7fu >> length);
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(at + i) & 0xc0u) != 0x80) return 0;
    code = (code << 6) | (byte(at + i) & 0x3fu);
  }
  const bool overlong = (length == 3 && code < 0x800) || (length == 4 && code < 0x10000);
  const bool unwelcome = code < 0xa0 || (code >= 0xd800 && code < 0xe000) || code > 0x10ffff || code == 0x2028 ||
                         code == 0x2029 || (code >= 0x202a && code <= 0x202e) || (code >= 0x2066 && code <= 0x2069);
  return overlong || unwelcome ? 0 : length;
}

bool printable(std::string_view word) {
  for (std::size_t at = 0; at < word.size();) {
    const std::size_t length = printable_character(word, at);
    if (length == 0) return false;
    at += length;
  }
  return true;
}

// printf's format: octal for what is not printable, for the quote, the backslash and the percent sign.
std::string printf_format(std::string_view word) {
  std::string format;
  for (std::size_t at = 0; at < word.size();) {
    const std::size_t length = printable_character(word, at);
    const auto byte = static_cast<unsigned char>(word[at]);
    if (length == 0 || byte == '\'' || byte == '\\' || byte == '%') {
      format += '\\';
      for (const int shift : {6, 3, 0}) format += static_cast<char>('0' + ((byte >> shift) & 7));
      ++at;
    } else {
      format += word.substr(at, length);
      at += length;
    }
  }
  return format;
}

std::string shell_word(const std::string& word) {
  if (plain(word)) return word;
  if (!printable(word)) {
    // A command substitution drops line feeds at its end: they stand behind it, as they are.
    const std::size_t end = word.find_last_not_of('\n') == std::string::npos ? 0 : word.find_last_not_of('\n') + 1;
    const std::string rest = word.substr(end);
    return "\"$(printf '" + printf_format(std::string_view(word).substr(0, end)) + "')\"" +
           (rest.empty() ? "" : "'" + rest + "'");
  }
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

}  // namespace

std::vector<std::string> rerun_words(const std::string& scenario, const std::string& method, std::int64_t steps,
                                     const Resolution& at) {
  std::vector<std::string> words{"atwood", "run", "--scenario", scenario, "--method", method};
  if (steps > 0) words.insert(words.end(), {"--steps", std::to_string(steps)});
  if (at.first) words.insert(words.end(), {"--spacing", format_double(*at.first)});
  if (at.second) words.insert(words.end(), {"--sound-speed", format_double(*at.second)});
  return words;
}

std::string shell_line(std::span<const std::string> words) {
  std::string line;
  for (const std::string& word : words) {
    // A first word with `=` would be an assignment.
    const bool assignment = line.empty() && plain(word) && word.find('=') != std::string::npos;
    line += (line.empty() ? "" : " ") + (assignment ? "'" + word + "'" : shell_word(word));
  }
  return line;
}

}  // namespace atwood
