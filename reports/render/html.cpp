// One file that opens from disk without a network. The verdict is plain HTML, so it shows even where scripts are off;
// everything else is drawn from the embedded data, which is base64 and therefore cannot close its own element.
#include <fmt/format.h>

#include <set>
#include <tuple>

#include "assets.hpp"
#include "counts_table.hpp"
#include "embedded_data.hpp"
#include "fluid_table.hpp"
#include "reports/report.hpp"
#include "text.hpp"

namespace atwood {
namespace {

constexpr std::size_t kFileLimit = 3'000'000;  // bytes
constexpr const char* kPolicy =
    "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:";

std::string tile(const char* kind, const char* name, std::int64_t number) {
  return fmt::format("<li class=\"tile {}{}\"><b>{}</b> <span>{}</span></li>", kind, number == 0 ? " none" : "", number,
                     name);
}

// Cells whose engine crashed or did not answer in time, in words; empty when none did.
std::string broken_cells(const std::vector<Row>& rows, bool some_ladders) {
  using Cells = std::set<std::tuple<std::string, std::string, std::int64_t, Resolution>>;
  Cells crashed, late;
  for (const Row& row : rows) {
    if (row.status == Status::crashed) crashed.emplace(row.scenario, row.method, row.steps, resolution_of(row));
    if (row.status == Status::timeout) late.emplace(row.scenario, row.method, row.steps, resolution_of(row));
  }
  const auto words = [&](const Cells& cells, const char* what) {
    return cells.empty() ? std::string()
                         : fmt::format(" In {} {}{} an engine {}.", cells.size(), cells.size() == 1 ? "cell" : "cells",
                                       some_ladders ? " shown here" : "", what);
  };
  return words(crashed, "crashed") + words(late, "did not answer in time");
}

std::string header(const ReportData& data) {
  const JudgementCounts counts = count(data);
  const std::int64_t bad = counts.fail + counts.unverifiable + counts.not_run, all = counts.pass + bad;
  const char* state = all == 0 ? "empty" : bad == 0 ? "pass" : counts.fail == 0 ? "warn" : "fail";
  const std::string sentence = data.compared
                                   ? fmt::format("{} scenario{}, methods side by side; nothing is judged here.",
                                                 data.scenarios.size(), data.scenarios.size() == 1 ? "" : "s")
                               : all == 0 ? "Nothing was judged: the report holds no gates."
                               : bad == 0 ? fmt::format("All {} gates pass.", counts.pass)
                                          : fmt::format("{} of {} gates did not pass.", bad, all);
  const char* word = data.compared ? "Compared" : all == 0 ? "No gates" : bad == 0 ? "Pass" : "Fail";
  const std::string tiles = data.compared ? ""
                                          : tile("pass", "pass", counts.pass) + tile("fail", "fail", counts.fail) +
                                                tile("unverifiable", "unverifiable", counts.unverifiable) +
                                                tile("not-run", "not run", counts.not_run);
  return fmt::format(
             "<header id=\"top\"><div class=\"masthead\"><h1>{}</h1><div id=\"tools\"></div></div>"
             "<section id=\"verdict\" class=\"{}\" aria-label=\"Verdict\"><p class=\"word\">{}</p><p>{}</p>"
             "<ul class=\"tiles\">",
             escape_html(data.title), state, word, sentence + broken_cells(data.rows, !data.counted.empty())) +
         tiles + "</ul></section></header>";
}

}  // namespace

std::string render_html(const ReportData& data) {
  std::string page = fmt::format(
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"{}\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<meta name=\"color-scheme\" content=\"light dark\">\n<title>{}</title>\n<style>",
      kPolicy, escape_html(one_line(data.title)));
  page += report_style;
  page += "</style></head>\n<body>\n" + header(data) + "\n" + counts_html(data) + fluid_html(data.rows) +
          "<main id=\"app\"><noscript><p>Tables and plots need JavaScript; the verdict above does not.</p></noscript>"
          "</main>\n<script type=\"text/plain\" id=\"data\">";
  const std::string end = "</script>\n<script>" + std::string(report_script) + "</script>\n</body></html>\n";
  const std::size_t used = page.size() + end.size();
  page += embedded_data(data, kFileLimit > used ? kFileLimit - used : 0);
  page += end;
  return page;
}

}  // namespace atwood
