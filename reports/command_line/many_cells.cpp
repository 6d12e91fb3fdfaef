#include "reports/command_line/many_cells.hpp"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <set>

#include <fmt/format.h>

#include "scene/files.hpp"
#include "scene/printable.hpp"
#include "validation/study/load_rows.hpp"
#include "validation/study/write_file.hpp"

namespace atwood {
namespace fs = std::filesystem;

namespace {

constexpr std::size_t kMany = 20'000;    // cells
constexpr std::size_t kKept = 200;       // ladders of each kind, shared by the scenes
constexpr std::size_t kListed = 50;      // verdicts on the terminal
constexpr std::size_t kVerdicts = 1000;  // of each kind that is not a pass, with their texts

// The ladders of a scene that documents show.
struct Shown {
  struct Ladder {
    std::vector<std::size_t> which;
    std::vector<Row> rows;
    std::vector<Verdict> verdicts;
  };
  std::multimap<double, Ladder> best, worst;  // by the error of the finest rung
  std::vector<Ladder> bad;
};

std::size_t& counter(SceneCounts& counts, Judgement judgement) {
  switch (judgement) {
    case Judgement::pass: return counts.pass;
    case Judgement::fail: return counts.fail;
    case Judgement::unverifiable: return counts.unverifiable;
    case Judgement::not_run: break;
  }
  return counts.not_run;
}

// What tells a gate from the others.
std::string name_of(const Gate& gate) {
  std::string name;
  for (const std::string* part :
       {&gate.origin, &gate.scenario, &gate.method, &gate.metric, &gate.claim, &gate.ratio_to})
    name += *part + "\n";
  return name + std::to_string(gate.steps.value_or(0));
}

bool passed(const Verdict& verdict) { return verdict.judgement == Judgement::pass; }

// The position's error at the end of the finest rung; NaN where there is none.
double figure_of(const std::vector<Row>& rows) {
  double figure = std::nan("");
  std::int64_t steps = 0;
  for (const Row& row : rows)
    if (row.metric == "error-position-end" && row.status == Status::ok && row.body.empty() && !row.t_s &&
        row.steps > steps)
      figure = row.value, steps = row.steps;
  return figure;
}

void keep(Shown& shown, Shown::Ladder ladder, bool bad, std::size_t most) {
  if (ladder.rows.empty()) return;
  if (bad && shown.bad.size() < most) {
    shown.bad.push_back(std::move(ladder));
    return;
  }
  const double error = figure_of(ladder.rows);
  const double key = std::isnan(error) ? HUGE_VAL : std::fabs(error);
  if (shown.best.size() < most || key < std::prev(shown.best.end())->first) {
    shown.best.emplace(key, std::move(ladder));
    if (shown.best.size() <= most) return;
    ladder = std::move(std::prev(shown.best.end())->second);  // it may be one of the worst
    const double last = std::prev(shown.best.end())->first;
    shown.best.erase(std::prev(shown.best.end()));
    shown.worst.emplace(last, std::move(ladder));
  } else {
    shown.worst.emplace(key, std::move(ladder));
  }
  if (shown.worst.size() > most) shown.worst.erase(shown.worst.begin());
}

// The rows of the methods that ratios are taken to.
std::vector<Row> rival_rows(const Options& options, const Selection& selection, const std::vector<Gate>& gates) {
  std::set<std::string> methods;
  for (const Gate& gate : gates)
    if (gate.kind == Gate::Kind::max_ratio) methods.insert(gate.ratio_to);
  std::vector<Cell> cells;
  for (const Cell& cell : selection.cells)
    if (methods.contains(cell.method)) cells.push_back(cell);
  return cells.empty() ? std::vector<Row>() : load_rows(options.out_dir + "/store.db", cells, options.purpose).rows;
}

std::size_t not_ok(const std::vector<CellEnding>& endings) {
  return static_cast<std::size_t>(std::count_if(
      endings.begin(), endings.end(), [](const CellEnding& one) { return one.there && one.status != Status::ok; }));
}

// A command that prints what is left out.
std::string command_for_one(const Options& options) {
  return same_call(options, "report") + " --method METHOD -o csv:rows.csv";
}

void add_counts(const Place& place, const Options& options, const Selection& selection, const Condensed& condensed,
                ReportData& data) {
  data.counted_in_all = condensed.all;
  for (const auto& [scene, counts] : condensed.scenes) {
    Options alone = options;
    alone.scenarios = {scene};
    for (const Scenario& scenario : selection.scenarios)
      if (scenario.id == scene && !own_file(place, scenario).empty()) alone.scenarios = {scenario.path};
    data.counted.push_back({scene, counts, same_call(alone, "report")});
  }
}

std::string plural(std::size_t count, const char* word) {
  return fmt::format("{} {}{}", count, word, count == 1 ? "" : "s");
}

std::string scene_table(const Condensed& condensed) {
  std::size_t width = 8;
  for (const auto& [scene, counts] : condensed.scenes) width = std::max(width, scene.size());
  std::string out = fmt::format("{:<{}}  {:>8} {:>8} {:>8} {:>8}  {:>8} {:>8} {:>8} {:>8}\n", "scenario", width,
                                "ladders", "cells", "not ok", "missing", "pass", "fail", "unver.", "not run");
  for (const auto& [scene, c] : condensed.scenes)
    out += fmt::format("{:<{}}  {:>8} {:>8} {:>8} {:>8}  {:>8} {:>8} {:>8} {:>8}\n", scene, width, c.ladders, c.cells,
                       c.not_ok, c.missing, c.pass, c.fail, c.unverifiable, c.not_run);
  return out;
}

std::string verdict_line(const Condensed& condensed) {
  const SceneCounts& all = condensed.all;
  const std::size_t verdicts = all.pass + all.fail + all.unverifiable + all.not_run;
  return fmt::format("{}  {}: {} pass, {} fail, {} unverifiable, {} not run\n",
                     verdicts == 0      ? "NO GATES"
                     : condensed.passes ? "PASS"
                                        : "FAIL",
                     plural(verdicts, "gate"), all.pass, all.fail, all.unverifiable, all.not_run);
}

std::string bad_verdicts(const Condensed& condensed) {
  std::string out;
  std::size_t listed = 0;
  const SceneCounts& all = condensed.all;
  for (const Verdict& v : condensed.judged.verdicts) {
    if (passed(v) || listed == kListed) continue;
    ++listed;
    out += fmt::format("{:<12}  {}  {}  {}{}\n              {}\n", to_string(v.judgement), printable(v.scenario),
                       printable(v.method), v.metric, v.steps > 0 ? fmt::format(" at {} steps", v.steps) : "",
                       printable(v.text));
    if (!v.rerun.empty()) out += "              " + shell_line(v.rerun) + "\n";
  }
  const std::size_t bad = all.fail + all.unverifiable + all.not_run;
  if (bad > listed) out += fmt::format("... and {} more that did not pass\n", bad - listed);
  return out;
}

void print_condensed(const Options& options, const Condensed& condensed, const std::string& tail) {
  std::string out = bad_verdicts(condensed);
  if (!options.quiet) {
    out += (out.empty() ? "" : "\n") + scene_table(condensed) + "\n";
    for (const std::string& note : condensed.judged.notes) out += printable(note) + "\n";
  }
  fmt::print("{}{}{}\n", out, verdict_line(condensed), tail);
}

}  // namespace

bool has_many_cells(const Options& options, const Selection& selection, const Standards& standards) {
  const char* given = std::getenv("ATWOOD_MANY_CELLS");
  const std::size_t many = given ? std::strtoull(given, nullptr, 10) : kMany;
  return selection.cells.size() >= many && options.outputs.empty() && options.junit.empty() && !options.json &&
         !standards.baseline;
}

Condensed condense(const Place& place, const Options& options, const Selection& selection, const Standards& standards) {
  Condensed condensed;
  StudyResult& result = condensed.result;
  Judged& judged = condensed.judged;
  const SiftedGates sifted = asked_gates(place, options, selection, standards.gates, judged.notes);
  LadderJudge judge(sifted.judged, rival_rows(options, selection, sifted.judged));
  const std::size_t most = std::max<std::size_t>(2, kKept / std::max<std::size_t>(1, selection.scenarios.size()));
  Selection part = without_cells(selection);
  std::map<std::string, Shown> shown;
  std::vector<Verdict> bad_ones;
  std::map<Judgement, std::size_t> kept_bad;
  std::set<std::string> told_truths;
  Refusals refusals;
  std::map<std::string, std::map<std::string, SceneCounts>> of_gates;  // by gate and scene
  const auto take = [&](const std::string& scene, std::vector<Verdict>& verdicts) {
    for (Verdict& verdict : verdicts) {
      if (passed(verdict) || kept_bad[verdict.judgement] >= kVerdicts) continue;
      ++kept_bad[verdict.judgement];
      if (!verdict.of_cell) verdict.rerun = with_own_files(place, options, selection, verdict.scenario, verdict.rerun);
      bad_ones.push_back(verdict);
    }
    for (const Verdict& verdict : verdicts) {
      ++counter(condensed.all, verdict.judgement);
      if (scene.empty()) continue;
      ++counter(condensed.scenes[scene], verdict.judgement);
      if (!verdict.of_cell) ++counter(of_gates[name_of(verdict.gate)][scene], verdict.judgement);
    }
  };
  std::size_t visited = 0;
  visit_ladders(
      options.out_dir + "/store.db", selection.cells,
      [&](const std::vector<std::size_t>& which, StudyResult& rows) {
        visited += which.size();
        const std::string& scene = selection.cells[which.front()].scenario->id;
        SceneCounts& counts = condensed.scenes[scene];
        ++counts.ladders, counts.cells += which.size(), counts.missing += rows.missing.size();
        result.skipped += rows.skipped, result.failed_cells += rows.failed_cells;
        result.hosts.merge(rows.hosts);
        result.missing.insert(result.missing.end(), rows.missing.begin(), rows.missing.end());
        condensed.rows += rows.rows.size();
        part.cells.clear();
        for (const std::size_t i : which) part.cells.push_back(selection.cells[i]);
        Judged of_cells;
        of_cells.cells = endings_of(part, rows.rows);
        const std::size_t bad_cells = not_ok(of_cells.cells);
        counts.not_ok += bad_cells;
        refusals.add(part, of_cells.cells);
        append_failed_cells(place, options, part, rows.rows, of_cells, told_truths);
        std::vector<Verdict> verdicts = judge.add(rows.rows);
        for (Verdict& verdict : of_cells.verdicts) verdicts.push_back(std::move(verdict));
        take(scene, verdicts);
        const bool bad = bad_cells > 0 || !std::all_of(verdicts.begin(), verdicts.end(), passed) ||
                         std::any_of(rows.rows.begin(), rows.rows.end(),
                                     [](const Row& row) { return row.metric == "truth" && row.status != Status::ok; });
        keep(shown[scene], {which, std::move(rows.rows), std::move(verdicts)}, bad, most);
      },
      options.purpose);
  if (visited == 0)
    for (std::size_t i = 0; i < selection.cells.size(); ++i)
      if (selection.cells[i].worker >= 0) result.missing.push_back(i);
  result.cells = static_cast<int>(selection.cells.size());
  std::sort(result.missing.begin(), result.missing.end());
  std::vector<Verdict> rest = judge.rest();
  std::set<std::string> without_cells_of;  // gates, of which only what fails stays beside the verdict on missing cells
  if (!result.missing.empty()) {
    std::vector<Verdict> lost;
    judge_missing(selection, sifted.judged, result, same_call_words(options, "run"), lost);
    for (const Verdict& verdict : lost) without_cells_of.insert(name_of(verdict.gate));
    std::erase_if(rest, [&](const Verdict& verdict) { return without_cells_of.contains(name_of(verdict.gate)); });
    rest.insert(rest.end(), lost.begin(), lost.end());
  }
  const auto dropped = [&](const Verdict& verdict) {
    return !verdict.of_cell && verdict.judgement != Judgement::fail && without_cells_of.contains(name_of(verdict.gate));
  };
  std::erase_if(bad_ones, dropped);
  for (const std::string& gate : without_cells_of)
    for (auto& [scene, counts] : of_gates[gate])
      for (const Judgement judgement : {Judgement::pass, Judgement::unverifiable, Judgement::not_run}) {
        counter(condensed.all, judgement) -= counter(counts, judgement);
        counter(condensed.scenes[scene], judgement) -= counter(counts, judgement);
      }
  rest.insert(rest.end(), sifted.unmatched.begin(), sifted.unmatched.end());
  take("", rest);
  for (auto& [scene, ladders] : shown) {
    SceneCounts& counts = condensed.scenes[scene];
    const auto add = [&](Shown::Ladder& ladder) {
      ++counts.shown;
      std::move(ladder.rows.begin(), ladder.rows.end(), std::back_inserter(result.rows));
      for (Verdict& verdict : ladder.verdicts)
        if (passed(verdict) && !dropped(verdict)) judged.verdicts.push_back(std::move(verdict));
    };
    for (Shown::Ladder& ladder : ladders.bad) add(ladder);
    for (auto& [error, ladder] : ladders.best) add(ladder);
    for (auto& [error, ladder] : ladders.worst) add(ladder);
  }
  const auto rank = [](Judgement judgement) {
    return judgement == Judgement::fail ? 0 : judgement == Judgement::unverifiable ? 1 : 2;
  };
  std::stable_sort(bad_ones.begin(), bad_ones.end(),
                   [&](const Verdict& a, const Verdict& b) { return rank(a.judgement) < rank(b.judgement); });
  judged.verdicts.insert(judged.verdicts.begin(), std::make_move_iterator(bad_ones.begin()),
                         std::make_move_iterator(bad_ones.end()));
  refusals.append_to(judged.notes);
  const SceneCounts& all = condensed.all;
  condensed.passes = all.pass > 0 && all.fail + all.unverifiable + all.not_run == 0;
  if (result.hosts.size() > 1)
    judged.notes.push_back(fmt::format(
        "Times of these cells are of {} hosts: those of a scenario are ranked only where one host measured them all.",
        result.hosts.size()));
  judged.refused = refused_truths(place, selection.scenarios, result.rows, false);
  for (const auto& [scene, counts] : condensed.scenes)
    if (counts.shown < counts.ladders)
      judged.notes.push_back(fmt::format(
          "{}: {} ladders ({} cells: {} gates pass, {} do not); documents show {} of them, the most and the least "
          "accurate at the finest rung and those where something did not pass. `{}` writes every row of a method.",
          scene, counts.ladders, counts.cells, counts.pass, counts.fail + counts.unverifiable + counts.not_run,
          counts.shown, command_for_one(options)));
  if (const std::string missing = missing_words(selection, result); !missing.empty())
    judged.notes.push_back(fmt::format("{}: `{}` makes them.", missing, same_call(options, "run")));
  return condensed;
}

namespace {

int exit_of(const Condensed& condensed) {
  if (condensed.result.failed_cells > 0) return exit_cell;
  const SceneCounts& all = condensed.all;
  const bool unjudged = all.pass == 0 && !condensed.result.missing.empty();
  return all.fail + all.unverifiable + all.not_run == 0 && !unjudged ? exit_pass : exit_gate;
}

// What the history keeps of so many cells.
std::vector<Row> counts_of_scenes(const Condensed& condensed) {
  std::vector<Row> rows;
  for (const auto& [scene, c] : condensed.scenes)
    for (Row& row : count_rows(scene, {{"cells", c.cells},
                                       {"cells-not-ok", c.not_ok},
                                       {"cells-missing", c.missing},
                                       {"gates-pass", c.pass},
                                       {"gates-fail", c.fail},
                                       {"gates-unverifiable", c.unverifiable},
                                       {"gates-not-run", c.not_run}}))
      rows.push_back(std::move(row));
  return rows;
}

}  // namespace

int gate_many(const Place& place, const Options& options, const Selection& selection, const Standards& standards) {
  const Condensed condensed = condense(place, options, selection, standards);
  print_condensed(options, condensed, "store: " + options.out_dir + "/store.db");
  if (options.github) {
    ReportData data;
    data.verdicts = condensed.judged.verdicts;
    add_counts(place, options, selection, condensed, data);
    report_to_github(options, data);
  }
  return exit_of(condensed);
}

int report_many(const Place& place, const Options& options, const Selection& selection, const Standards& standards,
                const StudyResult* ran, std::optional<HistoryRun>* kept_run) {
  const Condensed condensed = condense(place, options, selection, standards);
  const StudyResult& result = condensed.result;
  if (result.skipped == 0)
    throw InputError(fmt::format(
        "{}/store.db has none of these cells: they were never run, or were run by an earlier build; `{}` runs them",
        options.out_dir, same_call(options, "run")));
  Selection part = without_cells(selection);  // the cells whose rows are shown
  std::set<std::pair<std::string, std::string>> kept;
  for (const Row& row : result.rows) kept.insert({row.scenario, row.method});
  for (const Cell& cell : selection.cells)
    if (kept.contains({cell.scenario->id, cell.method})) part.cells.push_back(cell);
  ReportData data = assemble_report(place, options, part, result, {});
  add_judged(data, part, condensed.judged);
  add_counts(place, options, selection, condensed, data);
  const int code = ran != nullptr && ran->failed_cells > 0 ? static_cast<int>(exit_cell) : exit_of(condensed);
  const std::string verdict = code != exit_pass ? "fail" : condensed.all.pass == 0 ? "no gates" : "pass";
  std::optional<HistoryRun> entry = kept_run != nullptr ? *kept_run : merged_entry(options, selection);
  if (kept_run != nullptr || result.missing.empty()) {
    const auto whole = [](std::size_t n) { return static_cast<std::int64_t>(n); };
    const SceneCounts& all = condensed.all;
    end_history(place, options, entry, counts_of_scenes(condensed),
                {whole(all.pass), whole(all.fail), whole(all.unverifiable), whole(all.not_run)}, verdict);
    if (kept_run != nullptr) *kept_run = entry;
  }
  const std::string report = write_reports(options, selection, data, verdict);
  print_condensed(options, condensed,
                  fmt::format("{}, {}; report: {}", plural(static_cast<std::size_t>(result.cells), "cell"),
                              plural(condensed.rows, "row"), report));
  if (ran == nullptr) return exit_pass;
  report_to_github(options, data);
  return code;
}

}  // namespace atwood
