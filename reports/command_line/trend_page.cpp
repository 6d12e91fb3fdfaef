// The page of `history --metric`: a plot a figure, its values over runs, its levels and where they change.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "reports/command_line/history.hpp"
#include "reports/render/text.hpp"

namespace atwood {
namespace {

constexpr double kWidth = 720, kHeight = 220, kLeft = 90, kRight = 20, kTop = 20, kBottom = 40;

constexpr const char* kHead =
    "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n<meta http-equiv=\"Content-Security-Policy\" "
    "content=\"default-src 'none'; style-src 'unsafe-inline'\">\n<meta name=\"viewport\" "
    "content=\"width=device-width, initial-scale=1\">\n<meta name=\"color-scheme\" content=\"light dark\">\n<title>";
constexpr const char* kStyle =
    "</title>\n<style>\n:root{color-scheme:light dark;--ink:#1c2330;--paper:#fff;--line:#c3cad5;--value:#1f5fbf;"
    "--level:#1b7a3d;--change:#b3261e}\n@media(prefers-color-scheme:dark){:root{--ink:#e6e9ef;--paper:#14181f;"
    "--line:#39414f;--value:#8ab4f8;--level:#7bd99a;--change:#ff8a80}}\nbody{font:16px/1.5 system-ui,sans-serif;"
    "color:var(--ink);background:var(--paper);max-width:60rem;margin:2rem auto;padding:0 1rem}\nfigure{margin:2rem 0}"
    "svg{width:100%;height:auto}text{fill:var(--ink);font-size:12px}figcaption{font-weight:600}\n.axis,.bar{stroke:"
    "var(--line)}.bar{stroke:var(--value);opacity:.6}.value{fill:var(--value)}.level{stroke:var(--level);"
    "stroke-width:2}.change{stroke:var(--change);stroke-dasharray:4 3}text.change{fill:var(--change);stroke:none}\n"
    "</style></head>\n<body><main>\n";

// From values to heights: logarithmic where all values are positive and span more than a factor of two.
struct Axis {
  double low = 0, high = 1;
  bool logarithmic = false;
  double at(double value) const {
    const double x = logarithmic ? std::log(std::max(value, std::exp(low))) : value;
    return kTop + (kHeight - kTop - kBottom) * (1 - std::clamp((x - low) / (high - low), 0.0, 1.0));
  }
};

Axis axis_of(const Trend& trend) {
  double low = HUGE_VAL, high = -HUGE_VAL;
  for (const TrendPoint& p : trend.points) low = std::min(low, p.value), high = std::max(high, p.value);
  Axis axis;
  axis.logarithmic = low > 0 && high > 2 * low;
  axis.low = axis.logarithmic ? std::log(low) : low;
  axis.high = axis.logarithmic ? std::log(high) : high;
  const double margin =
      axis.high > axis.low ? 0.08 * (axis.high - axis.low) : std::max(std::fabs(axis.low) * 0.1, 1e-300);
  axis.low -= margin, axis.high += margin;
  return axis;
}

std::string plot(const Trend& trend, const std::string& name) {
  const Axis axis = axis_of(trend);
  const std::size_t n = trend.points.size();
  const auto across = [&](double i) {
    return n < 2 ? (kLeft + kWidth - kRight) / 2 : kLeft + (kWidth - kLeft - kRight) * i / static_cast<double>(n - 1);
  };
  const auto x_of = [&](std::size_t i) { return across(static_cast<double>(i)); };
  std::string svg = fmt::format("<svg viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{}\">", kWidth, kHeight, name);
  svg += fmt::format("<path class=\"axis\" fill=\"none\" d=\"M{0} {1}V{2}H{3}\"/>", kLeft, kTop, kHeight - kBottom,
                     kWidth - kRight);
  const auto [least, most] = std::minmax_element(trend.points.begin(), trend.points.end(),
                                                 [](const auto& a, const auto& b) { return a.value < b.value; });
  for (const double value : {least->value, most->value}) {
    svg += fmt::format("<text x=\"{}\" y=\"{:.1f}\" text-anchor=\"end\">{}</text>", kLeft - 8, axis.at(value) + 4,
                       figure(value, 4));
    if (least->value == most->value) break;
  }
  svg += fmt::format("<text x=\"{:.1f}\" y=\"{}\">run {}</text>", x_of(0), kHeight - kBottom + 18,
                     trend.points.front().run);
  if (n > 1)
    svg += fmt::format("<text x=\"{:.1f}\" y=\"{}\" text-anchor=\"end\">run {}</text>", x_of(n - 1),
                       kHeight - kBottom + 18, trend.points.back().run);
  std::vector<std::size_t> ends = trend.changes.starts;
  ends.push_back(n);
  std::size_t from = 0;
  for (const std::size_t to : ends) {
    const double level = trend.changes.enough ? axis.at(level_of(trend, from, to)) : 0;
    if (trend.changes.enough)
      svg += fmt::format("<path class=\"level\" d=\"M{:.1f} {:.1f}H{:.1f}\"/>", x_of(from), level, x_of(to - 1));
    if (to < n)
      svg += fmt::format(
          "<path class=\"change\" d=\"M{0:.1f} {1}V{2}\"/><text class=\"change\" x=\"{0:.1f}\" y=\"{3}\" "
          "text-anchor=\"middle\">run {4}</text>",
          across(static_cast<double>(to) - 0.5), kTop, kHeight - kBottom, kTop - 6, trend.points[to].run);
    from = to;
  }
  for (std::size_t i = 0; i < n; ++i) {
    const TrendPoint& p = trend.points[i];
    if (p.bar > 0)
      svg += fmt::format("<path class=\"bar\" d=\"M{:.1f} {:.1f}V{:.1f}\"/>", x_of(i), axis.at(p.value - p.bar),
                         axis.at(p.value + p.bar));
    svg += fmt::format(
        "<circle class=\"value\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3\"><title>run {}, {} UTC, {}: {}</title></circle>",
        x_of(i), axis.at(p.value), p.run, moment_words(p.begun_ns), escape_html(one_line(p.commit)), figure(p.value));
  }
  return svg + "</svg>";
}

}  // namespace

std::string render_trends(const std::vector<Trend>& trends, const std::string& title) {
  std::string page = kHead + escape_html(one_line(title)) + " over runs" + kStyle;
  page += fmt::format(
      "<h1>{} over runs</h1>\n<p>A dashed line marks where the level changes (penalised least squares, exact: optimal "
      "partitioning; {} runs or more are needed). Vertical bars are a figure's own uncertainty.</p>\n",
      escape_html(one_line(title)), kFewestRuns);
  for (const Trend& trend : trends) {
    const std::string name =
        escape_html(one_line(fmt::format("{}, {}, {}{}{}{}", trend.scenario, trend.method, trend.metric,
                                         trend.steps > 0 ? fmt::format(" at {} steps", trend.steps) : "",
                                         trend.unit.empty() || trend.unit == "1" ? "" : " [" + trend.unit + "]",
                                         trend.host.empty() ? "" : ", on " + trend.host)));
    const std::string what =
        !trend.changes.enough          ? fmt::format("{} runs: too few for change points.", trend.points.size())
        : trend.changes.starts.empty() ? "One level: no change point."
                                       : fmt::format("{} levels.", trend.changes.starts.size() + 1);
    page += fmt::format("<figure>{}<figcaption>{}</figcaption><p>{}</p></figure>\n", plot(trend, name), name, what);
  }
  return page + "</main></body></html>\n";
}

}  // namespace atwood
