// compare: methods side by side on each scenario: error, order and cost, the cheapest for each error, the most accurate
// within each budget, stable steps.
#include <unistd.h>

#include <algorithm>
#include <set>

#include <fmt/format.h>

#include "benchmarks/overheads.hpp"
#include "reports/command_line/command_line.hpp"
#include "reports/command_line/compare_text.hpp"
#include "reports/command_line/contest.hpp"
#include "reports/command_line/fluid_question.hpp"
#include "reports/command_line/joint_question.hpp"
#include "reports/command_line/same_rate.hpp"
#include "reports/command_line/spread.hpp"
#include "reports/command_line/units.hpp"
#include "scene/files.hpp"
#include "validation/study/process.hpp"
#include "validation/study/write_file.hpp"

namespace atwood {

namespace {

// What was added to what was asked for.
void note_tolerances(const std::vector<std::string>& asked, const std::vector<std::string>& run,
                     std::vector<std::string>& notes) {
  std::set<std::string> seen;
  std::string families;
  for (const auto& method : run) {
    const std::string family = method_family(method);
    if (family == method || std::find(asked.begin(), asked.end(), method) != asked.end() || !seen.insert(family).second)
      continue;
    families += (families.empty() ? "" : ", ") + family;
  }
  if (!families.empty())
    notes.push_back(families + ": named without a tolerance and taking one; run at 1e-4, 1e-5 .. 1e-13 each.");
}

// A metric of attitudes needs a scene where something turns.
void require_attitudes(const Selection& selection, const std::string& metric) {
  if (metric.find("attitude") == std::string::npos && metric.find("body-rate") == std::string::npos) return;
  std::string still;
  for (const Scenario& scenario : selection.scenarios) {
    if (std::any_of(scenario.scene.bodies.begin(), scenario.scene.bodies.end(),
                    [](const Body& body) { return !body.fixed && rotates(body); }))
      return;
    still += (still.empty() ? "" : ", ") + scenario.id;
  }
  throw InputError(fmt::format("compare: the bodies of {} do not turn: there is no {}", still,
                               metric.find("attitude") != std::string::npos ? "attitude" : "body rate"));
}

// A figure that was asked for and that no cell has, although some ran.
void require_figure(const std::vector<Row>& rows, const std::string& metric) {
  std::set<std::string> present;
  for (const Row& row : rows)
    if (row.status == Status::ok) present.insert(row.metric);
  if (metric.empty() || present.empty() || present.contains(metric)) return;
  throw InputError(fmt::format("compare --metric {}: no method has this figure here; there are {}", metric,
                               fmt::join(present, ", ")));
}

void write_documents(const Options& options, const ReportData& data) {
  const bool html = std::any_of(options.outputs.begin(), options.outputs.end(),
                                [](const auto& o) { return o.rfind("html:", 0) == 0; });
  write_named_outputs(options, data);
  const std::string standard = options.out_dir + "/compare.html";
  if (!html) write_file(standard, render_html(data));
  for (const auto& output : options.outputs)
    fmt::print(stderr, "{}: {}\n", output.substr(0, output.find(':')), output.substr(output.find(':') + 1));
  if (!html) fmt::print(stderr, "report: {}\n", standard);
}

}  // namespace

int command_compare(const Place& place, const Options& options) {
  require_outputs_make_sense(options);
  Question question = read_question(options);
  Options chosen = options;
  chosen.purpose = "compare";
  if (chosen.scenarios.empty()) chosen.scenarios = {"kepler-e0.6"};
  chosen.whole_ladders = chosen.steps.empty() && chosen.hz.empty();
  chosen.named_methods_only = true;
  chosen.with_same_rate = true;
  const std::vector<Worker> workers = require_workers(place, chosen, nullptr, options.methods);
  std::vector<std::string> notes;
  chosen.methods = with_tolerances(options.methods, without_same_rate(workers), notes);
  const std::vector<std::string> named = chosen.methods;
  const RankedRates rates = choose_rates(options, named, workers);
  chosen.methods.insert(chosen.methods.end(), rates.twins.begin(), rates.twins.end());
  std::set<std::string> families;
  for (const std::string& method : named) families.insert(method.substr(0, method.find(':')));
  if (families.size() < 2 && options.methods.size() < 2)
    throw InputError(
        fmt::format("compare {}: expected two methods or more, or a glob over them; a single method is "
                    "measured by `{}`",
                    options.methods.front(),
                    shell_line(std::vector<std::string>{"atwood", "run", "--method", options.methods.front()})));
  const Selection selection = select_cells(place, chosen);
  require_attitudes(selection, question.metric);
  std::vector<const Scenario*> scenes;
  for (const Scenario& scenario : selection.scenarios) scenes.push_back(&scenario);
  question = fluid_question("compare", options, question, scenes);
  make_out_dir(options.out_dir);
  StudyOptions how = study_options(place, chosen);
  how.progress = progress_printer(options);
  StudyResult result = run_study(selection.cells, selection.workers, how);
  end_progress();
  if (result.interrupted) return 128 + result.signal;
  require_figure(result.rows, question.metric);
  note_tolerances(options.methods, named, notes);
  result.rows = without_idle_halves(result.rows, options.methods, notes);
  ReportData data = assemble_report(place, chosen, selection, result, {});
  data.title = "Atwood: methods compared";
  if (const std::string note = under_wasm_note(result.rows); !note.empty()) notes.push_back(note);
  data.bench.clear();
  data.goals.clear();
  data.compared = true;
  data.rates = rates.words;
  data.same_rate = rates.same;
  const std::vector<Row> ranked = rates.same ? ranked_rows(data.rows, notes) : data.rows;
  data.dominance = find_dominance(ranked, question);
  if (!rates.words.empty()) notes.insert(notes.begin(), rates.words);
  for (const Scenario& scenario : selection.scenarios)
    if (const std::string note = unjudged_note(ranked, question.metric, scenario.id); !note.empty())
      notes.push_back(note);
  data.notes.insert(data.notes.end(), notes.begin(), notes.end());
  if (!options.no_timing) {
    const InterruptGuard guard;
    try {
      TurnTimes times(selection.cells, selection.workers, result.rows, options.cell_limit_s);
      for (Dominance& table : data.dominance) {
        if (table.cost != Cost::seconds) continue;
        for (Contest& contest : table.by_error) times.settle(contest, table.scenario, true);
      }
      if (rates.same)
        data.overheads = measure_overheads(selection.cells, selection.workers, ranked, options.cell_limit_s);
    } catch (const Interrupted&) {
      return 128 + interrupt_signal();
    }
  }
  for (const Scenario& scenario : selection.scenarios) {
    if (!scenario.scene.fluids.empty()) continue;
    const bool judged = std::any_of(data.rows.begin(), data.rows.end(), [&](const Row& row) {
      return row.scenario == scenario.id && row.metric.rfind("error-", 0) == 0;
    });
    if (judged) continue;
    const auto runs = run_finest(selection.cells, scenario.id, data.rows, selection.workers, options.cell_limit_s);
    if (scenario.truth.kind != TruthKind::none && runs.size() < 2) continue;  // its rows say why
    for (const std::string& line : spread_lines(runs)) data.notes.push_back(scenario.id + ": " + line);
  }
  if (options.json) {
    fmt::print("{}\n", render_json(data));
  } else {
    for (const auto& scenario : selection.scenarios)
      fmt::print("{}", compare_text(data, scenario, question, terminal_width()));
    for (const auto& note : data.notes)
      if (note != data.rates) fmt::print("{}\n", note);  // it heads every scenario
  }
  write_documents(options, data);
  return result.failed_cells > 0 ? exit_cell : exit_pass;
}

}  // namespace atwood
