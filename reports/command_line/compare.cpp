// compare: methods side by side on each scenario: error, order, cost; who is cheapest, what a budget buys, what is
// stable.
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include <fmt/format.h>

#include "reports/command_line/command_line.hpp"
#include "reports/command_line/compare_text.hpp"
#include "reports/command_line/stopwatch.hpp"
#include "scene/files.hpp"
#include "validation/study/process.hpp"

namespace atwood {

namespace {

constexpr int kPairs = 15;

const Cell* find_cell(const Selection& selection, const std::string& scenario, const Reached& reached) {
  for (const auto& cell : selection.cells) {
    if (cell.worker >= 0 && cell.scenario.id == scenario && cell.method == reached.method &&
        cell.plan.steps == reached.steps)
      return &cell;
  }
  return nullptr;
}

double rung_seconds(const std::vector<Row>& rows, const Cell& cell) {
  for (const Row& row : rows) {
    if (row.metric == "run-time" && row.scenario == cell.scenario.id && row.method == cell.method &&
        row.steps == cell.plan.steps)
      return row.value;
  }
  return 0;
}

// The second against the first of each error level, timed in turns at the rungs they stand on; where a cost lies
// between two rungs, its share of its rung's cost goes with it.
class PairedTimes {
 public:
  PairedTimes(const Selection& selection, const std::vector<Row>& rows, double limit_s)
      : selection_(selection), rows_(rows), stopwatch_(limit_s) {}

  void fill(Dominance& table) {
    for (Contest& contest : table.by_error) {
      if (contest.ranked.size() < 2) continue;
      const Reached &first = contest.ranked[0], &second = contest.ranked[1];
      const Cell *a = find_cell(selection_, table.scenario, first), *b = find_cell(selection_, table.scenario, second);
      if (a == nullptr || b == nullptr) continue;
      const double a_s = rung_seconds(rows_, *a), b_s = rung_seconds(rows_, *b);
      if (!(a_s > 0) || !(b_s > 0) || a_s + b_s > 1) continue;  // thirty runs of a second each are too many
      const PairedRatio& ratio = measured(*a, *b, a_s, b_s);
      const double part = (second.cost / b_s) / (first.cost / a_s);
      if (std::isfinite(ratio.ratio))
        contest.to_next = TimedRatio{part * ratio.ratio, part * ratio.low, part * ratio.high, kPairs};
    }
  }

 private:
  const PairedRatio& measured(const Cell& a, const Cell& b, double a_s, double b_s) {
    const auto [place, fresh] = known_.try_emplace({&a, &b});
    if (!fresh) return place->second;
    const std::vector<Contender> pair{contender(a, a_s), contender(b, b_s)};
    std::vector<double> first, second;
    for (const auto& round : stopwatch_.in_turns(pair, kPairs)) {
      if (!std::isfinite(round[0]) || !std::isfinite(round[1])) continue;
      first.push_back(round[0]);
      second.push_back(round[1]);
    }
    if (first.size() >= 5) place->second = paired_ratio(second, first);
    else place->second.ratio = std::nan("");
    return place->second;
  }
  Contender contender(const Cell& cell, double seconds) const {
    return {&selection_.workers[static_cast<std::size_t>(cell.worker)],
            cell.method,
            &cell.scenario.scene,
            cell.plan,
            seconds,
            0};
  }

  const Selection& selection_;
  const std::vector<Row>& rows_;
  Stopwatch stopwatch_;
  std::map<std::pair<const Cell*, const Cell*>, PairedRatio> known_;
};

// The rungs of one half of a method's ladders: equal steps, or tolerances.
struct Half {
  bool runs = false;
  std::int64_t fewest_steps = 0, most_steps = 0;
  double fewest_evaluations = 0, most_evaluations = 0;
  // Four times the steps, and hardly more work: they were not its steps.
  bool idle() const {
    return most_steps >= 4 * fewest_steps && most_evaluations > 0 && most_evaluations < 1.5 * fewest_evaluations;
  }
};

// A method that takes a tolerance was run both ways. A half that it refuses is no failure of it, and where equal steps
// change nothing (it chooses its own, at a tolerance of its own) they are no ladder: the other half stands for it.
std::vector<Row> without_idle_halves(const std::vector<Row>& rows, const std::vector<std::string>& asked,
                                     std::vector<std::string>& notes) {
  std::map<std::pair<std::string, std::string>, Half> halves;  // scenario, family
  for (const Row& row : rows) {
    if (row.steps == 0 || row.status != Status::ok || !row.body.empty() || row.t_s) continue;
    Half& half = halves[{row.scenario, method_family(row.method)}];
    half.runs = true;
    if (row.metric != "rate-evaluations") continue;
    half.fewest_steps = half.fewest_steps == 0 ? row.steps : std::min(half.fewest_steps, row.steps);
    half.most_steps = std::max(half.most_steps, row.steps);
    half.fewest_evaluations = half.fewest_evaluations == 0 ? row.value : std::min(half.fewest_evaluations, row.value);
    half.most_evaluations = std::max(half.most_evaluations, row.value);
  }
  const auto is_idle = [&](const Row& row) {
    const std::string family = method_family(row.method);
    const bool tolerance = family != row.method;
    if (tolerance && std::find(asked.begin(), asked.end(), row.method) != asked.end()) return false;
    const std::size_t at = tolerance ? family.find(":tol") : std::min(family.find_first_of("+@{"), family.size());
    const std::string other =
        tolerance ? family.substr(0, at) + family.substr(at + 4) : family.substr(0, at) + ":tol" + family.substr(at);
    const auto twin = halves.find({row.scenario, other});
    if (twin == halves.end() || !twin->second.runs) return false;
    const auto own = halves.find({row.scenario, family});
    return own == halves.end() || !own->second.runs || (!tolerance && own->second.idle());
  };
  std::vector<Row> kept;
  std::set<std::string> said;
  for (const Row& row : rows) {
    if (!is_idle(row)) kept.push_back(row);
    else if (method_family(row.method) == row.method && said.insert(row.method).second)
      notes.push_back(row.method + " chooses its own steps: run at a ladder of tolerances instead of equal steps.");
  }
  return kept;
}

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
  Options chosen = options;
  chosen.purpose = "compare";
  if (chosen.scenarios.empty()) chosen.scenarios = {"kepler-e0.6"};
  chosen.whole_ladders = chosen.steps.empty();
  chosen.named_methods_only = true;
  const std::vector<Worker> workers = require_workers(place, options);
  std::vector<std::string> notes;
  chosen.methods = with_tolerances(options.methods, workers, notes);
  std::set<std::string> families;
  for (const std::string& method : chosen.methods) families.insert(method.substr(0, method.find(':')));
  if (families.size() < 2 && options.methods.size() < 2)
    throw InputError(fmt::format("compare {}: expected two methods or more, or a glob over them; of one method alone "
                                 "`atwood run --method {}` tells all", options.methods.front(), options.methods.front()));
  const Selection selection = select_cells(place, chosen);
  make_out_dir(options.out_dir);
  StudyOptions how = study_options(place, chosen);
  how.progress = progress_printer();
  StudyResult result = run_study(selection.cells, selection.workers, how);
  end_progress();
  if (result.interrupted) return 128 + result.signal;
  note_tolerances(options.methods, chosen.methods, notes);
  result.rows = without_idle_halves(result.rows, options.methods, notes);
  ReportData data = assemble_report(place, chosen, selection, result, {});
  data.title = "Atwood: methods compared";
  data.bench.clear();
  data.goals.clear();
  data.notes = notes;
  data.compared = true;
  if (!options.no_timing) {
    const InterruptGuard guard;
    try {
      fmt::print(stderr, "atwood: first and second in turns, {} pairs each\n", kPairs);
      PairedTimes times(selection, result.rows, options.cell_limit_s);
      for (Dominance& table : data.dominance) {
        if (table.cost == Cost::seconds) times.fill(table);
      }
    } catch (const Interrupted&) {
      return 128 + interrupt_signal();
    }
  }
  if (options.json) {
    fmt::print("{}\n", render_json(data));
  } else {
    for (const auto& scenario : selection.scenarios) fmt::print("{}", compare_text(data, scenario, terminal_width()));
    for (const auto& note : data.notes) fmt::print("{}\n", note);
  }
  write_documents(options, data);
  return result.failed_cells > 0 ? exit_cell : exit_pass;
}

}  // namespace atwood
