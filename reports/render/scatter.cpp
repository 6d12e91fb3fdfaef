#include "scatter.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace atwood {
namespace {

struct Range {
  double low = std::numeric_limits<double>::infinity(), high = -std::numeric_limits<double>::infinity();
};

void widen(Range& range, double log) {
  range.low = std::min(range.low, log);
  range.high = std::max(range.high, log);
}

bool drawable(double x, double y) { return x > 0 && y > 0 && std::isfinite(x) && std::isfinite(y); }

// The plotting area, in cells; row 0 is the top.
struct Field {
  Range x, y;
  int columns, rows;
  std::vector<std::string> cells;

  double column(double log_x) const { return (log_x - x.low) / (x.high - x.low) * (columns - 1); }
  double row(double log_y) const { return (y.high - log_y) / (y.high - y.low) * (rows - 1); }
  char& at(double r, double c) {
    const int i = std::clamp(static_cast<int>(std::lround(r)), 0, rows - 1),
              j = std::clamp(static_cast<int>(std::lround(c)), 0, columns - 1);
    return cells[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
  }
};

void join(Field& field, double x0, double y0, double x1, double y1) {
  const double r0 = field.row(y0), c0 = field.column(x0), r1 = field.row(y1), c1 = field.column(x1);
  const int n = static_cast<int>(std::max(std::fabs(r1 - r0), std::fabs(c1 - c0)));
  for (int i = 1; i < n; ++i) {
    const double part = static_cast<double>(i) / n;
    char& cell = field.at(r0 + part * (r1 - r0), c0 + part * (c1 - c0));
    if (cell == ' ') cell = '.';
  }
}

void draw(Field& field, const ScatterCurve& curve) {
  double last_x = 0, last_y = 0;
  bool has_last = false;
  for (std::size_t i = 0; i < curve.x.size(); ++i) {
    if (!drawable(curve.x[i], curve.y[i])) continue;
    const double x = std::log10(curve.x[i]), y = std::log10(curve.y[i]);
    if (has_last) join(field, last_x, last_y, x, y);
    last_x = x;
    last_y = y;
    has_last = true;
  }
}

void mark(Field& field, const ScatterCurve& curve) {
  for (std::size_t i = 0; i < curve.x.size(); ++i) {
    if (!drawable(curve.x[i], curve.y[i])) continue;
    char& cell = field.at(field.row(std::log10(curve.y[i])), field.column(std::log10(curve.x[i])));
    cell = cell == ' ' || cell == '.' || cell == curve.letter ? curve.letter : '*';
  }
}

std::string power(double log) { return fmt::format("1e{:.0f}", log); }

// Whole decades, as many as have room.
std::vector<double> ticks(const Range& range, int room) {
  const double first = std::ceil(range.low - 1e-9), last = std::floor(range.high + 1e-9);
  const int step = std::max(1, static_cast<int>(std::ceil((last - first + 1) / std::max(1, room))));
  std::vector<double> found;
  for (double at = first; at <= last + 1e-9; at += step) found.push_back(at);
  return found;
}

void round_out(Range& range) {
  range.low = std::floor(range.low + 1e-9);
  range.high = std::ceil(range.high - 1e-9);
  if (range.high <= range.low) range.high = range.low + 1;
}

std::string axis_below(const Field& field, int margin, const std::string& label) {
  std::string rule(static_cast<std::size_t>(field.columns), '-'),
      numbers(static_cast<std::size_t>(margin + field.columns), ' ');
  for (const double tick : ticks(field.x, field.columns / 9)) {
    const int c = static_cast<int>(std::lround(field.column(tick)));
    rule[static_cast<std::size_t>(c)] = '+';
    const std::string word = power(tick);
    const int from =
        std::clamp(margin + c - static_cast<int>(word.size()) / 2, 0, static_cast<int>(numbers.size() - word.size()));
    numbers.replace(static_cast<std::size_t>(from), word.size(), word);
  }
  while (!numbers.empty() && numbers.back() == ' ') numbers.pop_back();
  const int middle = std::max(0, margin + (field.columns - static_cast<int>(label.size())) / 2);
  return std::string(static_cast<std::size_t>(margin - 1), ' ') + "+" + rule + "\n" + numbers + "\n" +
         std::string(static_cast<std::size_t>(middle), ' ') + label + "\n";
}

}  // namespace

std::string render_scatter(const Scatter& scatter) {
  Range x, y;
  for (const ScatterCurve& curve : scatter.curves) {
    for (std::size_t i = 0; i < curve.x.size(); ++i) {
      if (!drawable(curve.x[i], curve.y[i])) continue;
      widen(x, std::log10(curve.x[i]));
      widen(y, std::log10(curve.y[i]));
    }
  }
  if (!(x.low <= x.high)) return "(nothing to draw: no run has both figures)\n";
  round_out(x);
  round_out(y);
  constexpr int margin = 8;  // "  1e-12 |"
  Field field{x, y, std::max(20, scatter.width - margin - 1), std::max(6, scatter.height - 4), {}};
  field.cells.assign(static_cast<std::size_t>(field.rows), std::string(static_cast<std::size_t>(field.columns), ' '));
  for (const ScatterCurve& curve : scatter.curves) draw(field, curve);
  for (const ScatterCurve& curve : scatter.curves) mark(field, curve);
  std::vector<std::string> labels(static_cast<std::size_t>(field.rows));
  for (const double tick : ticks(y, field.rows / 2))
    labels[static_cast<std::size_t>(std::lround(field.row(tick)))] = power(tick);
  std::string out = scatter.y_label + "\n";
  for (int r = 0; r < field.rows; ++r) {
    std::string line =
        fmt::format("{:>{}} {}{}", labels[static_cast<std::size_t>(r)], margin - 2,
                    labels[static_cast<std::size_t>(r)].empty() ? '|' : '+', field.cells[static_cast<std::size_t>(r)]);
    while (line.back() == ' ') line.pop_back();
    out += line + "\n";
  }
  return out + axis_below(field, margin, scatter.x_label);
}

}  // namespace atwood
