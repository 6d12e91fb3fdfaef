#include "integrators/tableaux.hpp"

#include <quadmath.h>

#include <cstring>
#include <stdexcept>
#include <string>

namespace atwood {
namespace {

// "-8/27", "1/6", "2", "-0.0389": read in quad, so a ratio is off by a unit in quad's last place at most.
Quad read_coefficient(const std::string& text) {
  const auto number = [&](const std::string& digits) {
    char* end = nullptr;
    const Quad value = strtoflt128(digits.c_str(), &end);
    if (digits.empty() || *end != '\0') throw std::logic_error("a tableau holds `" + text + "`, which is not a number");
    return value;
  };
  const std::size_t slash = text.find('/');
  if (slash == std::string::npos) return number(text);
  return number(text.substr(0, slash)) / number(text.substr(slash + 1));
}

TableauRow minus(const TableauRow& x, const TableauRow& y) {
  TableauRow z;
  for (std::size_t i = 0; i < x.size(); ++i) z.push_back(x[i] - y[i]);
  return z;
}

}  // namespace

TableauRow read_row(const char* text) {
  TableauRow row;
  for (const char* at = text; at != nullptr && *(at += std::strspn(at, " \n")) != '\0';) {
    const std::size_t size = std::strcspn(at, " \n");
    row.push_back(read_coefficient(std::string(at, size)));
    at += size;
  }
  return row;
}

TableauRow read_row(const char* text, int length) {
  TableauRow row = read_row(text);
  if (static_cast<int>(row.size()) > length)
    throw std::logic_error(std::string("a tableau's row is too long: ") + text);
  row.resize(static_cast<std::size_t>(length));
  return row;
}

Coefficients read_coefficients(const Tableau& tableau) {
  const int length = tableau.stages + tableau.dense_stages;
  Coefficients read;
  for (int i = 0; i < length; ++i) read.a.push_back(read_row(tableau.a[static_cast<std::size_t>(i)], length));
  read.b = read_row(tableau.b, length);
  read.c = read_row(tableau.c, length);
  read.error = read.companion_error = TableauRow(static_cast<std::size_t>(length));
  if (tableau.embedded_order > 0) {
    read.error = minus(read.b, read_row(tableau.embedded, length));
    read.estimate_order = tableau.order < tableau.embedded_order ? tableau.order : tableau.embedded_order;
  }
  if (tableau.companion_order > 0) {  // estimate e_embedded^2 / e_companion; of 8(5,3) O(h^12 / h^4)
    read.companion_error = minus(read.b, read_row(tableau.companion, length));
    read.estimate_order = 2 * tableau.embedded_order - tableau.companion_order;
  }
  for (const char* row : tableau.dense)
    if (row != nullptr) read.dense.push_back(read_row(row, length));
  return read;
}

}  // namespace atwood
