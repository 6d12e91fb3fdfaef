// A summary for people who read in a terminal or on the page of a pull request.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "audit_table.hpp"
#include "baseline_table.hpp"
#include "bench_table.hpp"
#include "counts_table.hpp"
#include "figures_table.hpp"
#include "fluid_table.hpp"
#include "markdown_contests.hpp"
#include "ran_methods.hpp"
#include "reports/report.hpp"
#include "solver_table.hpp"
#include "statistics_text.hpp"
#include "text.hpp"

namespace atwood {
namespace {

std::string cell(const std::string& text) { return escape_markdown_cell(text); }

// Inline code may hold anything but its own fence: the fence is one backtick longer than the longest run inside.
std::string code(const std::string& text) {
  const std::string line = one_line(text);
  std::size_t longest = 0, run = 0;
  for (const char c : line) {
    run = c == '`' ? run + 1 : 0;
    longest = std::max(longest, run);
  }
  const std::string fence(longest + 1, '`');
  return longest == 0 ? fence + line + fence : fence + " " + line + " " + fence;
}

// In a table a bar ends the cell even inside code.
std::string table_code(const std::string& text) {
  std::string out;
  for (const char c : code(text)) out += c == '|' ? std::string("\\|") : std::string(1, c);
  return out;
}

// Of a figure that has one.
std::string unit(const std::string& text) { return text.empty() || text == "1" ? "" : " " + cell(text); }

std::string steps_word(std::int64_t steps) { return steps > 0 ? std::to_string(steps) : "-"; }

std::string failing_section(const std::vector<Verdict>& verdicts, std::size_t most) {
  std::string out;
  std::size_t shown = 0;
  for (const Verdict* verdict : failing_first(verdicts)) {
    if (verdict->judgement == Judgement::pass || shown++ >= most) continue;
    if (out.empty()) {
      out =
          "## What did not pass\n\n| verdict | scenario | method | steps | metric | measured | allowed | rerun |\n"
          "| --- | --- | --- | ---: | --- | ---: | --- | --- |\n";
    }
    out += fmt::format("| {} | {} | {} | {} | {} | {}{} | {} | {} |\n", to_string(verdict->judgement),
                       cell(verdict->scenario), cell(verdict->method), steps_word(verdict->steps),
                       cell(verdict->metric), cell(measured_words(*verdict)), unit(verdict->unit),
                       cell(allowed_words(*verdict)), table_code(shell_line(verdict->rerun)));
  }
  if (shown > most) out += fmt::format("\nAnd {} more.\n", shown - most);
  return out.empty() ? out : out + "\n";
}

std::string truths_section(const std::vector<RefusedTruth>& truths) {
  if (truths.empty()) return "";
  std::string out = "## Scenes without a truth\n\n";
  for (const RefusedTruth& refused : truths) out += fmt::format("- **{}**\n", cell(refused_words(refused)));
  return out + "\n";
}

std::string baseline_section(const ReportData& data) {
  if (data.baseline_path.empty()) return "";
  std::string out =
      fmt::format("## Against the baseline\n\n{}.\n\n", cell(change_counts(data.baseline_path, data.baseline)));
  const std::vector<ChangedPair> pairs = changed_pairs(data.baseline);
  if (!pairs.empty()) out += "| scenario | method | became worse | rerun |\n| --- | --- | --- | --- |\n";
  for (const ChangedPair& pair : pairs)
    out += fmt::format("| {} | {} | {} | {} |\n", cell(pair.worst->scenario), cell(pair.worst->method),
                       cell(change_words(pair)), table_code(shell_line(pair.worst->rerun)));
  if (!pairs.empty()) out += "\n";
  std::string counted;
  for (const auto& [kind, word] : {std::pair{BaselineChange::Kind::missing, "missing"},
                                   {BaselineChange::Kind::improvement, "better"},
                                   {BaselineChange::Kind::added, "new"}})
    for (const std::string& line : counted_by_scenario(data.baseline, kind))
      counted += fmt::format("- {}: {}\n", word, cell(line));
  return out + counted + (counted.empty() ? "" : "\n");
}

std::string claims_section(const std::vector<ClaimedOrder>& orders) {
  std::string out;
  for (const ClaimedOrder& order : orders) {
    if (!order.foreign || std::isnan(order.observed)) continue;
    if (out.empty())
      out =
          "## Claimed and observed orders\n\n| scenario | method | quantity | claimed | observed | |\n"
          "| --- | --- | --- | ---: | ---: | --- |\n";
    const std::string words = claim_words(order);
    out += fmt::format("| {} | {} | {} | {} | {:.2f} +/- {:.2g} | {} |\n", cell(order.scenario), cell(order.method),
                       cell(order.metric.substr(order.metric.find('-') + 1)), figure(order.claimed, 3), order.observed,
                       order.half_width_95, words.empty() ? "" : words.substr(words.rfind(": ") + 2));
  }
  return out.empty() ? out : out + "\n";
}

std::string notes_section(const std::vector<std::string>& notes) {
  std::string out;
  for (const std::string& note : notes) out += fmt::format("- {}\n", cell(note));
  return out.empty() ? out : "## Notes\n\n" + out + "\n";
}

std::string heading(const ReportData& data) {
  const JudgementCounts counts = count(data);
  const bool all_pass = counts.fail + counts.unverifiable + counts.not_run == 0;
  const char* verdict = all_pass && counts.pass == 0 ? "No gates" : all_pass ? "Pass" : "Fail";
  std::set<std::string> scenarios;  // `gate` reads cells alone
  for (const CellEnding& ending : data.cells) scenarios.insert(ending.scenario);
  return fmt::format("# {}\n\n**{}.** {}; scenarios: {}, rows: {}.\n\n", cell(data.title), verdict, words(counts),
                     data.scenarios.empty() ? scenarios.size() : data.scenarios.size(), data.rows.size());
}

std::string laws_section(const std::vector<Law>& laws) {
  if (laws.empty()) return "";
  std::string out =
      "## Laws: predicted and measured\n\n| scenario | method | steps | law | predicted | measured |\n"
      "| --- | --- | ---: | --- | ---: | ---: |\n";
  for (const Law& law : laws) {
    out += fmt::format("| {} | {} | {} | {} | {}{} | {}{} |\n", cell(law.scenario), cell(law.method),
                       steps_word(law.steps), cell(law.statement), figure(law.predicted), unit(law.unit),
                       figure(law.measured), unit(law.unit));
  }
  return out + "\n";
}

// Scenario x method for one kind of observed order.
std::string orders_section(const std::vector<Row>& rows, const std::string& metric, const std::string& heading) {
  std::vector<std::string> methods, scenarios;
  std::set<std::string> seen_methods, seen_scenarios;
  std::map<std::pair<std::string, std::string>, std::string> figures;
  for (const Row& row : rows) {
    if (row.metric != metric || !row.body.empty()) continue;
    if (seen_methods.insert(row.method).second) methods.push_back(row.method);
    if (seen_scenarios.insert(row.scenario).second) scenarios.push_back(row.scenario);
    figures[{row.scenario, row.method}] = row.status == Status::ok ? order_words(row.value, row.truth_bar) : "-";
  }
  if (figures.empty()) return "";
  std::string out = "## " + heading + "\n\n| scenario |", rule = "| --- |";
  for (const std::string& method : methods) {
    out += " " + cell(method) + " |";
    rule += " ---: |";
  }
  out += "\n" + rule + "\n";
  for (const std::string& scenario : scenarios) {
    out += "| " + cell(scenario) + " |";
    for (const std::string& method : methods) {
      const auto found = figures.find({scenario, method});
      out += " " + (found == figures.end() ? std::string() : found->second) + " |";
    }
    out += "\n";
  }
  return out + "\n";
}

// Only what ran, each with every setting it ran with.
std::string engines_section(const ReportData& data) {
  std::string out =
      "## Engines and their settings\n\n| engine | version | scalar | method | settings |\n"
      "| --- | --- | --- | --- | --- |\n";
  std::vector<std::pair<std::string, std::string>> docs;
  for (const RanMethod& method : ran_methods(data.engines, data.rows)) {
    const Engine& engine = *method.engine;
    std::string settings = settings_words(method.settings);
    if (method.response != nullptr) {
      settings += settings.empty() ? "" : "; ";
      settings += method.response->id + ": " + settings_words(method.response_settings);
      const std::pair<std::string, std::string> doc{method.response->id, method.response->doc};
      if (std::find(docs.begin(), docs.end(), doc) == docs.end()) docs.push_back(doc);
    }
    out += fmt::format("| {} | {} | {} | {} | {} |\n", cell(engine.name), cell(engine.version), cell(engine.scalar),
                       cell(method.id), settings.empty() ? "-" : cell(settings));
  }
  for (const auto& [name, reason] : data.missing_engines) {
    out += fmt::format("| {} | - | - | - | missing: {} |\n", cell(name), cell(reason));
  }
  out += "\n";
  for (const auto& [id, doc] : docs) out += fmt::format("- {}: {}\n", code(id), cell(doc));
  return docs.empty() ? out : out + "\n";
}

std::string provenance_section(const ReportData& data) {
  const Provenance& from = data.provenance;
  std::string out = "## Provenance\n\n";
  for (const auto& [name, value] :
       std::initializer_list<std::pair<const char*, const std::string&>>{{"command", data.command},
                                                                         {"version", from.engine_version},
                                                                         {"commit", from.commit},
                                                                         {"compiler", from.compiler},
                                                                         {"flags", from.flags},
                                                                         {"CPU", from.cpu},
                                                                         {"run", from.run_id}}) {
    if (!value.empty()) out += fmt::format("- {}: {}\n", name, code(value));
  }
  return out;
}

}  // namespace

std::string render_markdown(const ReportData& data) {
  return heading(data) + failing_section(data.verdicts, data.verdicts.size()) + truths_section(data.refused_truths) +
         baseline_section(data) + claims_section(data.claimed_orders) + audit_section(data.audit) +
         goals_section(data.goals) + tables_section(data.tables) + dominance_section(data.dominance) +
         laws_section(data.laws) + fluid_markdown(data.rows) + solvers_section(data.rows, 200) +
         statistics_section(data.rows) + orders_section(data.rows, "order-position", "Observed order of position") +
         orders_section(data.rows, "order-attitude", "Observed order of attitude") + engines_section(data) +
         notes_section(data.notes) + provenance_section(data);
}

std::string render_step_summary(const ReportData& data) {
  return heading(data) + counts_markdown(data) + failing_section(data.verdicts, 50) +
         truths_section(data.refused_truths) + baseline_section(data) + claims_section(data.claimed_orders) +
         fluid_markdown(data.rows) + solvers_section(data.rows, 10) + notes_section(data.notes);
}

}  // namespace atwood
