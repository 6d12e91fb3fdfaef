// Verdicts as JUnit XML: one suite a scenario, one case a verdict and one a cell. What could not be judged counts as a
// failure: a gate that did not run has not passed. A cell that an engine cannot do is skipped.
#include <fmt/format.h>

#include <map>
#include <pugixml.hpp>
#include <sstream>

#include "reports/report.hpp"
#include "text.hpp"

namespace atwood {
namespace {

void set(pugi::xml_node node, const char* name, const std::string& value) {
  node.append_attribute(name).set_value(clean_text(value).c_str());
}

std::string case_name(const Verdict& verdict) {
  if (verdict.of_baseline) return verdict.method + " against the baseline";  // whichever figure is the worst
  const std::string steps = verdict.steps > 0 ? fmt::format(" at {} steps", verdict.steps) : "";
  return verdict.method + " " + verdict.metric + steps;
}

// Attributes with counts come before the cases.
struct Suite {
  std::vector<const Verdict*> verdicts;
  std::vector<const CellEnding*> cells;
};

void append_case(pugi::xml_node suite, const Verdict& verdict) {
  pugi::xml_node test = suite.append_child("testcase");
  set(test, "classname", verdict.scenario);
  set(test, "name", case_name(verdict));
  if (verdict.judgement == Judgement::pass) return;
  pugi::xml_node failure = test.append_child("failure");
  set(failure, "type", to_string(verdict.judgement));
  set(failure, "message", one_line(verdict.text));
  std::string body =
      fmt::format("{}\nreason: {}\ngate: {}\n", verdict.text, verdict.gate.reason, origin_words(verdict.gate.origin));
  if (!verdict.rerun.empty()) body += "rerun: " + shell_line(verdict.rerun) + "\n";
  failure.append_child(pugi::node_pcdata).set_value(clean_text(body).c_str());
}

bool skipped(const CellEnding& cell) { return !cell.fails && (!cell.there || cell.status != Status::ok); }

void append_cell(pugi::xml_node suite, const CellEnding& cell, const std::vector<const Verdict*>& verdicts) {
  pugi::xml_node test = suite.append_child("testcase");
  set(test, "classname", cell.scenario);
  set(test, "name", fmt::format("{} runs at {} steps", cell.method, cell.steps));
  const std::string words = cell.there ? to_string(cell.status) + (cell.reason.empty() ? "" : ": " + cell.reason)
                                       : "the store does not have it";
  if (skipped(cell)) set(test.append_child("skipped"), "message", one_line(words));
  if (!cell.fails) return;
  pugi::xml_node failure = test.append_child("failure");
  set(failure, "type", to_string(cell.status));
  set(failure, "message", one_line(words));
  std::string body = words + "\n";
  for (const Verdict* v : verdicts)
    if (v->of_cell && v->method == cell.method && v->steps == cell.steps)
      body += "rerun: " + shell_line(v->rerun) + "\n";
  failure.append_child(pugi::node_pcdata).set_value(clean_text(body).c_str());
}

void set_counts(pugi::xml_node node, std::size_t tests, std::size_t failures, std::size_t skips, bool cells) {
  node.append_attribute("tests") = static_cast<unsigned long long>(tests);
  node.append_attribute("failures") = static_cast<unsigned long long>(failures);
  if (cells) node.append_attribute("skipped") = static_cast<unsigned long long>(skips);
}

}  // namespace

std::string render_junit(const std::vector<Verdict>& verdicts, const std::vector<CellEnding>& cells) {
  std::vector<std::string> order;
  std::map<std::string, Suite> by_scenario;
  const auto suite_of = [&](const std::string& scenario) -> Suite& {
    const auto [place, is_new] = by_scenario.try_emplace(scenario);
    if (is_new) order.push_back(scenario);
    return place->second;
  };
  for (const Verdict& verdict : verdicts) suite_of(verdict.scenario).verdicts.push_back(&verdict);
  for (const CellEnding& cell : cells) suite_of(cell.scenario).cells.push_back(&cell);
  // A cell that failed is a case of its own: its verdict is not told twice.
  const auto is_case = [&](const Verdict* verdict) {
    return cells.empty() || !verdict->of_cell || verdict->metric != "status";
  };
  const auto counts = [&](const Suite& suite, std::size_t& tests, std::size_t& failures, std::size_t& skips) {
    for (const Verdict* verdict : suite.verdicts) {
      if (!is_case(verdict)) continue;
      ++tests;
      failures += verdict->judgement != Judgement::pass;
    }
    tests += suite.cells.size();
    for (const CellEnding* cell : suite.cells) {
      failures += cell->fails;
      skips += skipped(*cell);
    }
  };
  pugi::xml_document document;
  pugi::xml_node declaration = document.append_child(pugi::node_declaration);
  declaration.append_attribute("version") = "1.0";
  declaration.append_attribute("encoding") = "UTF-8";
  pugi::xml_node root = document.append_child("testsuites");
  std::size_t tests = 0, failures = 0, skips = 0;
  for (const auto& [scenario, suite] : by_scenario) counts(suite, tests, failures, skips);
  set(root, "name", "atwood gates");
  set_counts(root, tests, failures, skips, !cells.empty());
  for (const std::string& scenario : order) {
    const Suite& group = by_scenario[scenario];
    pugi::xml_node suite = root.append_child("testsuite");
    set(suite, "name", scenario);
    tests = failures = skips = 0;
    counts(group, tests, failures, skips);
    set_counts(suite, tests, failures, skips, !cells.empty());
    for (const Verdict* verdict : group.verdicts)
      if (is_case(verdict)) append_case(suite, *verdict);
    for (const CellEnding* cell : group.cells) append_cell(suite, *cell, group.verdicts);
  }
  std::ostringstream out;
  document.save(out, "  ");
  return out.str();
}

}  // namespace atwood
