// Pages of the history: what they share, and a plot a figure with its values over runs, its levels and where they
// change.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "reports/command_line/history.hpp"
#include "reports/render/assets.hpp"
#include "reports/render/text.hpp"

namespace atwood {
namespace {

constexpr double kWidth = 720, kHeight = 220, kLeft = 124, kRight = 20, kTop = 20, kBottom = 40;

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

const char* const kPageEnd = "</main></body></html>\n";

std::string page_head(const std::string& title, const std::vector<std::pair<std::string, std::string>>& links) {
  constexpr const char* before_title =
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n<meta http-equiv=\"Content-Security-Policy\" "
      "content=\"default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:\">\n"
      "<meta name=\"viewport\" "
      "content=\"width=device-width, initial-scale=1\">\n<meta name=\"color-scheme\" content=\"light dark\">\n<title>";
  constexpr const char* after_title =
      "</title>\n<style>\n:root{color-scheme:light dark;--ink:#1c2330;--paper:#fff;--line:#c3cad5;--value:#1f5fbf;"
      "--bad:#b3261e;--good:#1b7a3d}\n@media(prefers-color-scheme:dark){:root{--ink:#e6e9ef;--paper:#14181f;"
      "--line:#39414f;--value:#8ab4f8;--bad:#ff8a80;--good:#7bd99a}}\n"
      "body{font:16px/1.5 system-ui,sans-serif;color:var(--ink);background:var(--paper);max-width:70rem;margin:1.5rem "
      "auto;padding:0 1rem}h1{font-size:1.6rem}nav a{margin-right:1.2rem}a{color:inherit}\n"
      "table{border-collapse:collapse;width:100%;margin:1rem 0}caption{text-align:left;font-weight:600;padding:.5rem 0}"
      "th,td{text-align:left;padding:.3rem .8rem .3rem 0;border-bottom:1px solid var(--line);vertical-align:top;"
      "overflow-wrap:anywhere}td.n,th.n{text-align:right;white-space:nowrap}.fail{color:var(--bad)}.pass{color:"
      "var(--good)}\nfigure{margin:2rem 0;max-width:60rem;break-inside:avoid}figcaption{font-weight:600;"
      "overflow-wrap:anywhere}svg{width:100%;height:auto;overflow:visible}text{fill:var(--ink);font-size:12px}\n"
      ".axis{stroke:var(--line)}.bar{stroke:var(--value);opacity:.6}.value{fill:var(--value)}.level{stroke:var(--good);"
      "stroke-width:2}.change{stroke:var(--bad);stroke-dasharray:4 3}text.change{fill:var(--bad);stroke:none}\n"
      ".save{display:flex;gap:.4rem;justify-content:flex-end}.save button{font:inherit;font-size:.8rem;color:inherit;"
      "background:none;border:1px solid var(--line);border-radius:5px;padding:.1rem .6rem;cursor:pointer}\n"
      // Narrow: a row of a table is a block, its cells name their columns.
      "@media(max-width:40rem){text{font-size:20px}thead{display:none}table,caption,tbody,tr,td{display:block}td.n{text-align:"
      "left}tr{border-bottom:1px solid var(--line);padding:.4rem 0}td{border:0;padding:.05rem 0}td:empty{display:none}"
      "td[data-name]::before{content:attr(data-name) \": \";opacity:.7}}\n"
      "@media print{:root{color-scheme:light;--ink:#000;--paper:#fff;--line:#999;--value:#1f5fbf;--bad:#b3261e;"
      "--good:#1b7a3d}body{margin:0;max-width:none}nav,.save{display:none}tr{break-inside:avoid}}\n"
      "</style>\n<script>";
  std::string page = before_title + escape_html(one_line(title)) + after_title + std::string(pages_script) +
                     "</script></head>\n<body><main>\n";
  if (!links.empty()) {
    page += "<nav aria-label=\"Other pages\">";
    for (const auto& [words, target] : links)
      page += fmt::format("<a href=\"{}\">{}</a>", escape_html(target), escape_html(words));
    page += "</nav>\n";
  }
  return page + "<h1>" + escape_html(one_line(title)) + "</h1>\n";
}

std::string runs_table(const std::vector<HistoryRun>& runs, const std::string& file) {
  std::string table =
      "<table data-file=\"" + escape_html(one_line(file)) +
      "\"><caption>Runs, the newest first</caption><thead><tr><th class=\"n\">run</th><th>begun (UTC)</th>"
      "<th>study</th><th class=\"n\">cells</th><th>commit</th><th>machine</th><th>verdict</th></tr></thead><tbody>\n";
  for (const HistoryRun& run : runs)
    table += fmt::format(
        "<tr><td class=\"n\" data-name=\"run\">{}</td><td data-name=\"begun\">{}</td><td data-name=\"study\">{}{}</td>"
        "<td class=\"n\" data-name=\"cells\">{}</td><td data-name=\"commit\">{}</td><td data-name=\"machine\">{}</td>"
        "<td data-name=\"verdict\" class=\"{}\">{}</td></tr>\n",
        run.id, moment_words(run.begun_ns), escape_html(one_line(run.study)),
        run.selection.empty() ? "" : " " + escape_html(one_line(run.selection)), run.cells, escape_html(run.commit),
        escape_html(one_line(run.host)), run.verdict == "pass" || run.verdict == "fail" ? run.verdict : "",
        escape_html(verdict_words(run)));
  return table + "</tbody></table>\n";
}

std::string render_trends(const std::vector<Trend>& trends, const std::string& title,
                          const std::vector<std::pair<std::string, std::string>>& links, const std::string& about) {
  std::string page = page_head(title, links) + about;
  if (!trends.empty())
    page += fmt::format(
        "<p>A dashed line marks where the level changes (penalised least squares, exact: optimal partitioning; {} runs "
        "or more are needed). Vertical bars are a figure's own uncertainty.</p>\n",
        kMinRuns);
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
  return page + kPageEnd;
}

}  // namespace atwood
