#include "audit_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "json_parts.hpp"
#include "text.hpp"

namespace atwood {
namespace {

constexpr std::array kVerdicts{AuditVerdict::lower, AuditVerdict::higher, AuditVerdict::inconclusive,
                               AuditVerdict::as_claimed, AuditVerdict::unsupported};

std::vector<std::string> scenarios_of(const std::vector<AuditFinding>& findings) {
  std::vector<std::string> all;
  for (const AuditFinding& finding : findings)
    for (const AuditProblem& problem : finding.problems)
      if (std::find(all.begin(), all.end(), problem.scenario) == all.end()) all.push_back(problem.scenario);
  std::sort(all.begin(), all.end());
  return all;
}

std::string order_text(const AuditFinding& finding, const std::string& scenario, bool with_interval) {
  for (const AuditProblem& problem : finding.problems) {
    if (problem.scenario != scenario) continue;
    if (problem.verdict == AuditVerdict::unsupported) return "unsupported";
    if (!std::isfinite(problem.order)) return "?";
    const double shown = std::fabs(problem.order) < 0.005 ? 0.0 : problem.order;  // no -0.00
    const char* mark = problem.verdict == AuditVerdict::inconclusive ? "?" : problem.quantity == "velocity" ? " v" : "";
    return with_interval && problem.half_width_95 > 0
               ? fmt::format("{:.2f} \u00b1 {:.2g}{}", shown, problem.half_width_95, mark)
               : fmt::format("{:.2f}{}", shown, mark);
  }
  return "";
}

int count_of(const std::vector<AuditFinding>& findings, AuditVerdict verdict) {
  return static_cast<int>(
      std::count_if(findings.begin(), findings.end(), [&](const AuditFinding& f) { return f.verdict == verdict; }));
}

std::string counts_text(const std::vector<AuditFinding>& findings) {
  std::string text = fmt::format("{} methods", findings.size());
  const char* before = ": ";
  for (const AuditVerdict verdict : kVerdicts) {
    if (const int n = count_of(findings, verdict)) {
      text += fmt::format("{}{} {}", before, n, to_string(verdict));
      before = ", ";
    }
  }
  return text;
}

std::string quoted(const std::string& given) {
  std::string method = given;
  if (const auto at = method.find(":tol"); at != std::string::npos) method.replace(at, 4, ":1e-8");
  return shell_line(std::vector{method});
}

constexpr const char* kLegend =
    "?: inconclusive (the row's reason says why); v: from velocity, position being inconclusive. A whole order within "
    "0.25. "
    ":tol: exponent of error over tolerance, lower under 0.5 or where error / tolerance varies 1000-fold.";

}  // namespace

std::string render_audit_table(const std::vector<AuditFinding>& findings, bool colour, int width) {
  const char *bold = colour ? "\x1b[1m" : "", *dim = colour ? "\x1b[2m" : "", *red = colour ? "\x1b[31m" : "",
             *off = colour ? "\x1b[0m" : "";
  const std::vector<std::string> scenarios = scenarios_of(findings);
  std::size_t name_width = 6;
  for (const AuditFinding& f : findings)
    if (f.verdict != AuditVerdict::as_claimed) name_width = std::max(name_width, display_width(f.method));
  name_width = std::min<std::size_t>(name_width, width > 120 ? 64 : 56);
  std::string out = fmt::format("{}{:<{}}  claimed", bold, "method", name_width);
  for (const std::string& scenario : scenarios)
    out += fmt::format("  {:>{}}", scenario, std::max<std::size_t>(scenario.size(), 11));
  out += fmt::format("  verdict{}\n", off);
  const AuditFinding* last = nullptr;
  for (const AuditVerdict verdict : kVerdicts) {
    if (verdict == AuditVerdict::as_claimed || verdict == AuditVerdict::unsupported) continue;
    for (const AuditFinding& finding : findings) {
      if (finding.verdict != verdict) continue;
      out += fmt::format("{:<{}}  {:>7}", fit(finding.method, name_width), name_width, finding.claimed);
      for (const std::string& scenario : scenarios)
        out +=
            fmt::format("  {:>{}}", order_text(finding, scenario, false), std::max<std::size_t>(scenario.size(), 11));
      out += fmt::format("  {}{}{}\n", verdict == AuditVerdict::lower ? red : "", to_string(verdict), off);
      if (!last) last = &finding;
    }
  }
  out += fmt::format("{}{}{}\n{}\n", dim, kLegend, off, counts_text(findings));
  if (last)
    out += fmt::format("evidence, a program of one page without Atwood: ./atwood describe {} --program\n",
                       quoted(last->method));
  return out;
}

std::string audit_section(const std::vector<AuditFinding>& findings) {
  if (findings.empty()) return "";
  const std::vector<std::string> scenarios = scenarios_of(findings);
  std::string out =
      fmt::format("## Library audit: claimed beside executed order\n\n{}. {}\n\n| method | claimed | claim |",
                  counts_text(findings), kLegend);
  for (const std::string& scenario : scenarios) out += " " + scenario + " |";
  out += " verdict |\n| --- | ---: | --- |";
  for (std::size_t i = 0; i < scenarios.size(); ++i) out += " ---: |";
  out += " --- |\n";
  for (const AuditVerdict verdict : kVerdicts) {
    for (const AuditFinding& finding : findings) {
      if (finding.verdict != verdict) continue;
      out += fmt::format("| `{}` | {} | {} |", finding.method, finding.claimed, finding.claim);
      for (const std::string& scenario : scenarios) out += " " + order_text(finding, scenario, true) + " |";
      out += " " + to_string(verdict) + " |\n";
    }
  }
  out +=
      "\nEvidence without Atwood: `./atwood describe METHOD --program` prints a program with nothing of Atwood in "
      "it.\n\n";
  return out;
}

void append_audit(JsonText& json, const std::vector<AuditFinding>& findings) {
  json.begin_array();
  for (const AuditFinding& finding : findings) {
    json.begin_object()
        .member("method", finding.method)
        .member("claim", finding.claim)
        .member_number("claimed", finding.claimed);
    json.member("verdict", to_string(finding.verdict)).key("problems").begin_array();
    for (const AuditProblem& problem : finding.problems) {
      json.begin_object()
          .inline_from_here()
          .member("scenario", problem.scenario)
          .member("verdict", to_string(problem.verdict));
      json.member_number("order", problem.order).member_number("half_width_95", problem.half_width_95);
      json.member("quantity", problem.quantity).member("reason", problem.reason).end_object();
    }
    json.end_array().end_object();
  }
  json.end_array();
}

}  // namespace atwood
