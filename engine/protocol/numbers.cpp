// Conversion of numbers to text and back, without loss.
//
// A decimal of at most 17 significant digits names the nearest double, one of at most 21 the nearest long double, a
// longer one the nearest quad: the shortest text of a double then reads back as that double, not as its decimal.
#include <quadmath.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <stdexcept>

#include "protocol/sample.hpp"

namespace atwood {
namespace {

std::string print(const char* format, int digits, Wide value) {
  std::array<char, 128> text{};
  const int length = quadmath_snprintf(text.data(), text.size(), format, digits, value);
  return {text.data(), static_cast<std::size_t>(length)};
}

// Number of written digits without leading zeros. Trailing zeros count: 1.000...0 is wider than 1.
int significant_digits(const std::string& text) {
  int digits = 0;
  for (const char c : text) {
    if (c == 'e' || c == 'E') break;
    if (c >= '0' && c <= '9' && (digits > 0 || c != '0')) ++digits;
  }
  return digits;
}

template <class Real, class Read> Real read(const std::string& text, Read from_text) {
  char* end = nullptr;
  errno = 0;
  const Real value = from_text(text.c_str(), &end);
  if (end == text.c_str() || *end != '\0') throw std::invalid_argument("not a number: `" + text + "`");
  return value;
}

}  // namespace

std::string format_double(double value) {
  if (std::isnan(value)) return "nan";
  if (std::isinf(value)) return value > 0 ? "inf" : "-inf";
  std::array<char, 32> text{};
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), value);
  return {text.data(), end};
}

std::string format_number(Wide value, int digits) {
  if (digits <= 17 || value == 0 || !finiteq(value)) return format_double(static_cast<double>(value));
  std::string text = print("%.*Qg", digits, value);  // drops trailing zeros
  if (parse_wide(text) != value) {
    const std::string full = print("%.*Qe", digits - 1, value);  // keeps them, and with them the precision
    if (significant_digits(text) < digits) text = full;
  }
  return text;
}

Wide parse_wide(const std::string& text) {
  if (text.empty() || text.front() == ' ' || text.find_first_of("xXpP(") != std::string::npos) {
    throw std::invalid_argument("not a number: `" + text + "`");
  }
  const int digits = significant_digits(text);
  if (digits <= 17) {
    const double value = read<double>(text, std::strtod);
    // Outside of double's range the wider types may represent it; a subnormal is in range.
    if (errno != ERANGE || (value != 0 && std::isfinite(value))) return value;
  } else if (digits <= 21) {
    const long double value = read<long double>(text, std::strtold);
    if (errno != ERANGE || (value != 0 && std::isfinite(value))) return value;
  }
  return read<Wide>(text, strtoflt128);
}

}  // namespace atwood
