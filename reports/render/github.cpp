// What GitHub Actions shows beside a change: workflow commands, ::error file=...,line=...,title=...::message. At most
// ten are shown of a step, so that the tenth counts the rest.
#include <fmt/format.h>

#include <algorithm>

#include "baseline_table.hpp"
#include "counts_table.hpp"
#include "figures_table.hpp"
#include "text.hpp"

namespace atwood {
namespace {

constexpr std::size_t kMaxLines = 10;

// The rules of @actions/core: % and line ends everywhere, colons and commas in properties as well.
std::string escaped(std::string_view text, bool property) {
  std::string out;
  for (const char c : clean_text(text)) {
    if (c == '%') out += "%25";
    else if (c == '\r') out += "%0D";
    else if (c == '\n') out += "%0A";
    else if (c == ':' && property) out += "%3A";
    else if (c == ',' && property) out += "%2C";
    else out += c;
  }
  return out;
}

// Where a gate of the user's stands, as a file of the workspace: nothing else can be shown beside the code.
std::string place_of(const Gate& gate, const std::string& workspace) {
  const std::size_t colon = gate.origin.rfind(':');
  if (!gate.named || colon == std::string::npos) return "";
  std::string file = gate.origin.substr(0, colon);
  const std::string line = gate.origin.substr(colon + 1);
  if (line.empty() || !std::all_of(line.begin(), line.end(), [](char c) { return c >= '0' && c <= '9'; })) return "";
  if (!workspace.empty() && file.starts_with(workspace + "/")) file = file.substr(workspace.size() + 1);
  if (file.empty() || file.front() == '/') return "";
  return fmt::format("file={},line={},", escaped(file, true), line);
}

std::string command(const char* level, const std::string& place, const std::string& title, const std::string& message) {
  return fmt::format("::{} {}title={}::{}\n", level, place, escaped(one_line(title), true), escaped(message, false));
}

// Gates and the baseline in turn, so that neither keeps the other out of the few that are shown.
std::vector<const Verdict*> in_turn(const std::vector<Verdict>& verdicts) {
  std::vector<const Verdict*> gates, baseline, all;
  for (const Verdict* v : failing_first(verdicts)) (v->of_baseline ? baseline : gates).push_back(v);
  for (std::size_t i = 0; i < std::max(gates.size(), baseline.size()); ++i) {
    if (i < gates.size()) all.push_back(gates[i]);
    if (i < baseline.size()) all.push_back(baseline[i]);
  }
  return all;
}

}  // namespace

std::string render_github_annotations(const ReportData& data, const std::string& workspace) {
  std::vector<std::string> lines;
  for (const Verdict* v : in_turn(data.verdicts)) {
    if (v->judgement == Judgement::pass) continue;
    const std::string steps = v->steps > 0 ? fmt::format(" at {} steps", v->steps) : "";
    const std::string rerun = v->rerun.empty() ? "" : "\nrerun: " + shell_line(v->rerun);
    lines.push_back(
        command("error", place_of(v->gate, workspace),
                fmt::format("atwood {}: {} {} {}{}", to_string(v->judgement), v->scenario, v->method, v->metric, steps),
                v->text + rerun));
  }
  for (const RefusedTruth& refused : data.refused_truths)
    lines.push_back(command("warning", "", "atwood: no truth for " + refused.scenario, refused_words(refused)));
  for (const ClaimedOrder& order : data.claimed_orders)
    if (order.foreign && !claim_words(order).empty())
      lines.push_back(command("warning", "",
                              fmt::format("atwood: {} {} {}", order.scenario, order.method, order.metric),
                              claim_words(order)));
  if (lines.size() > kMaxLines) {
    const std::size_t more = lines.size() - (kMaxLines - 1);
    lines.resize(kMaxLines - 1);
    lines.push_back(command("error", "", "atwood", fmt::format("and {} more: {}", more, words(count(data)))));
  }
  std::string out;
  for (const std::string& line : lines) out += line;
  return out;
}

}  // namespace atwood
