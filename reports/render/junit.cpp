// Verdicts as JUnit XML: one suite a scenario, one case a verdict. What could not be judged counts as a failure: a gate
// that did not run has not passed.
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
  const std::string steps = verdict.steps > 0 ? fmt::format(" at {} steps", verdict.steps) : "";
  return verdict.method + " " + verdict.metric + steps;
}

void append_case(pugi::xml_node suite, const Verdict& verdict) {
  pugi::xml_node test = suite.append_child("testcase");
  set(test, "classname", verdict.scenario);
  set(test, "name", case_name(verdict));
  if (verdict.judgement == Judgement::pass) return;
  pugi::xml_node failure = test.append_child("failure");
  set(failure, "type", to_string(verdict.judgement));
  set(failure, "message", one_line(verdict.text));
  const std::string body = fmt::format("{}\nreason: {}\ngate: {}\nrerun: {}\n", verdict.text, verdict.gate.reason,
                                       origin_words(verdict.gate.origin), verdict.rerun);
  failure.append_child(pugi::node_pcdata).set_value(clean_text(body).c_str());
}

}  // namespace

std::string render_junit(const std::vector<Verdict>& verdicts) {
  std::vector<std::string> order;
  std::map<std::string, std::vector<const Verdict*>> by_scenario;
  for (const Verdict& verdict : verdicts) {
    auto& group = by_scenario[verdict.scenario];
    if (group.empty()) order.push_back(verdict.scenario);
    group.push_back(&verdict);
  }
  pugi::xml_document document;
  pugi::xml_node declaration = document.append_child(pugi::node_declaration);
  declaration.append_attribute("version") = "1.0";
  declaration.append_attribute("encoding") = "UTF-8";
  pugi::xml_node root = document.append_child("testsuites");
  const JudgementCounts all = count(verdicts);
  set(root, "name", "atwood gates");
  root.append_attribute("tests") = static_cast<unsigned long long>(verdicts.size());
  root.append_attribute("failures") = static_cast<long long>(all.fail + all.unverifiable + all.not_run);
  for (const std::string& scenario : order) {
    pugi::xml_node suite = root.append_child("testsuite");
    const auto& group = by_scenario[scenario];
    long long failures = 0;
    for (const Verdict* verdict : group) failures += verdict->judgement != Judgement::pass;
    set(suite, "name", scenario);
    suite.append_attribute("tests") = static_cast<unsigned long long>(group.size());
    suite.append_attribute("failures") = failures;
    for (const Verdict* verdict : group) append_case(suite, *verdict);
  }
  std::ostringstream out;
  document.save(out, "  ");
  return out.str();
}

}  // namespace atwood
