// The reports that a run leaves, each under its own name, and the index of reports and runs.
#include <algorithm>
#include <cctype>
#include <filesystem>

#include <fmt/format.h>

#include "reports/command_line/history.hpp"
#include "reports/render/text.hpp"
#include "scene/files.hpp"
#include "validation/study/content_hash.hpp"
#include "validation/study/write_file.hpp"

namespace atwood {
namespace fs = std::filesystem;

namespace {

constexpr std::size_t kLongestName = 60;
constexpr std::int64_t kRunsOfIndex = 200;

// With links to the index and to the study's earlier runs above the heading; their addresses as seen from the page.
std::string with_links(std::string html, const std::string& to_index, const std::string& to_trends) {
  constexpr std::string_view heading = "<header id=\"top\">";
  const std::size_t at = html.find(heading);
  if (at == std::string::npos) throw std::logic_error("a report without a header");
  return html.insert(at + heading.size(), fmt::format("<p class=\"pages\"><a href=\"{}\">All reports and runs</a> "
                                                      "<a href=\"{}\">Earlier runs of this study</a></p>",
                                                      to_index, to_trends));
}

std::string trends_file(const std::string& report) { return report.substr(0, report.size() - 5) + ".trends.html"; }

std::string reports_folder(const Options& options) { return options.out_dir + "/reports"; }

// The reports whose files are not deleted.
std::vector<HistoryReport> reports_there(const Options& options, std::vector<HistoryReport> reports) {
  std::error_code ignored;
  std::erase_if(reports, [&](const HistoryReport& one) {
    return !fs::exists(reports_folder(options) + "/" + one.file, ignored);
  });
  return reports;
}

void write_index(const Options& options, const RunHistory& history) {
  write_file(options.out_dir + "/index.html",
             render_index(reports_there(options, history.reports()), history.runs("", kRunsOfIndex)));
}

void write_trends(const Options& options, const RunHistory& history, const HistoryReport& report) {
  write_file(reports_folder(options) + "/" + trends_file(report.file),
             study_trends(history, report.study, report.selection, report.file));
}

}  // namespace

std::string report_file(const std::string& study, const std::string& selection) {
  std::string name;
  for (const char c : study.substr(0, kLongestName))
    name += std::isalnum(static_cast<unsigned char>(c)) || c == '_' ? c : '-';
  if (name.empty() || name.front() == '-') name = "study" + name;
  // A dot is in no name: it parts the name from hashes, so that two studies or parts never share a file.
  if (name != study) name += ".id-" + content_hash(study).substr(0, 8);
  if (!selection.empty()) name += ".part-" + content_hash(selection).substr(0, 8);
  return name + ".html";
}

std::string write_reports(const Options& options, const Selection& selection, const ReportData& data,
                          const std::string& verdict) {
  HistoryReport report;
  report.study = selection.study;
  report.selection = selection_words(options);
  report.file = report_file(report.study, report.selection);
  report.title = data.title;
  report.verdict = verdict;
  report.cells = static_cast<std::int64_t>(selection.cells.size());
  report.written_ns = now_ns();
  report.shown = true;
  std::vector<HistoryReport> others;
  std::unique_ptr<RunHistory> history;
  try {
    history = std::make_unique<RunHistory>(history_path(options), RunHistory::Mode::write);
    others = history->reports();
  } catch (const std::runtime_error& error) {
    report_history(error, "the index of reports is not renewed");
    history = nullptr;
  }
  const std::string folder = reports_folder(options), page = options.out_dir + "/report.html";
  std::error_code ignored;
  if (fs::exists(page, ignored))
    for (const HistoryReport& other : reports_there(options, others))
      if (other.shown && other.file != report.file && other.cells > report.cells) report.shown = false;
  make_out_dir(folder);
  const std::string html = render_html(data), trends = trends_file(report.file);
  write_file(folder + "/" + report.file, history ? with_links(html, "../index.html", trends) : html);
  if (report.shown) write_file(page, history ? with_links(html, "index.html", "reports/" + trends) : html);
  if (history) {
    try {
      write_trends(options, *history, report);
      history->put_report(report);
      write_index(options, *history);
    } catch (const std::runtime_error& error) {
      report_history(error, "the index of reports is not renewed");
    }
  }
  write_named_outputs(options, data);
  return report.shown ? page : folder + "/" + report.file;
}

void renew_history_pages(const Options& options, const RunHistory& history) {
  for (const HistoryReport& report : reports_there(options, history.reports())) write_trends(options, history, report);
  std::error_code ignored;
  if (fs::exists(options.out_dir + "/index.html", ignored)) write_index(options, history);
}

std::string render_index(const std::vector<HistoryReport>& reports, const std::vector<HistoryRun>& runs) {
  std::string page = page_head("Reports and runs", {});
  page +=
      "<table data-file=\"atwood-reports\"><caption>Reports, the newest first</caption><thead><tr><th>report</th>"
      "<th>over runs</th><th>part of the study</th><th class=\"n\">cells</th><th>written (UTC)</th><th>verdict</th></tr></thead><tbody>\n";
  for (const HistoryReport& report : reports)
    page += fmt::format(
        "<tr><td><a href=\"reports/{}\">{}</a>{}</td><td><a href=\"reports/{}\">earlier runs</a></td><td "
        "data-name=\"part\">{}</td><td class=\"n\" data-name=\"cells\">{}</td><td data-name=\"written\">{}</td><td "
        "data-name=\"verdict\" class=\"{}\">{}</td></tr>\n",
        escape_html(report.file), escape_html(one_line(report.title)),
        report.shown ? " (<a href=\"report.html\">report.html</a>)" : "", escape_html(trends_file(report.file)),
        report.selection.empty() ? "all of it" : escape_html(one_line(report.selection)), report.cells,
        moment_words(report.written_ns), report.verdict == "pass" || report.verdict == "fail" ? report.verdict : "",
        escape_html(report.verdict));
  return page + "</tbody></table>\n" + runs_table(runs, "atwood runs") +
         "<p><code>atwood report --against RUN</code> compares the store with a run; <code>atwood history --metric "
         "METRIC</code> shows a metric over runs.</p>\n" +
         kPageEnd;
}

}  // namespace atwood
