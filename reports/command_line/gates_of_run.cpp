// The gates that judge a run, and the verdicts of gates that match no cell.
#include <algorithm>
#include <filesystem>
#include <limits>
#include <set>

#include <fmt/ranges.h>

#include "reports/command_line/verdicts.hpp"
#include "scene/files.hpp"
#include "validation/metrics/metrics.hpp"

namespace atwood {
namespace fs = std::filesystem;

namespace {

// The command line names rungs of the ladders, by count or by frequency: figures of whole ladders are then not judged.
bool rungs_chosen(const Options& options) { return !options.steps.empty() || !options.hz.empty(); }

bool filtered(const Options& options) {
  return !options.scenarios.empty() || !options.methods.empty() || rungs_chosen(options);
}

bool of_ladder(const std::string& metric) { return metric.starts_with("order-") || metric.starts_with("growth-"); }

bool method_matches(const std::string& pattern, const CellName& cell) {
  return glob_match(pattern, cell.method) || (cell.absent && glob_match(cell.method, pattern));
}

bool matches(const Gate& gate, const CellName& cell) {
  return glob_match(gate.scenario, cell.scenario) && method_matches(gate.method, cell) &&
         (!gate.steps || *gate.steps == cell.steps) &&
         (gate.kind != Gate::Kind::within_claim || gate.claim == cell.claim);
}

bool any_matches(const Gate& gate, const std::vector<CellName>& cells) {
  return std::any_of(cells.begin(), cells.end(), [&](const CellName& cell) { return matches(gate, cell); });
}

// Whether the gate needs no second method, or the study has the method that its ratio is taken to.
bool has_rival(const Gate& gate, const std::vector<CellName>& cells) {
  return gate.kind != Gate::Kind::max_ratio || std::any_of(cells.begin(), cells.end(), [&](const CellName& cell) {
           return glob_match(gate.scenario, cell.scenario) && cell.method == gate.ratio_to;
         });
}

std::string nearest_words(const std::string& word, const std::set<std::string>& known) {
  const std::string hint = nearest_hint(word, std::vector<std::string>(known.begin(), known.end()), 3);
  return !hint.empty() || known.empty() || known.size() > 4 ? hint
                                                            : fmt::format("; the study has {}", fmt::join(known, ", "));
}

// Which part of the gate matches nothing: the scenario, the method on it, the count of steps, the claim.
std::string what_matches_nothing(const Gate& gate, const std::vector<CellName>& cells, const std::string& study) {
  std::set<std::string> scenarios, methods, here;
  std::set<std::int64_t> steps;
  bool elsewhere = false;
  for (const CellName& cell : cells) {
    scenarios.insert(cell.scenario);
    methods.insert(cell.method);
    elsewhere = elsewhere || method_matches(gate.method, cell);
    if (!glob_match(gate.scenario, cell.scenario)) continue;
    here.insert(cell.method);
    if (method_matches(gate.method, cell)) steps.insert(cell.steps);
  }
  if (here.empty())
    return fmt::format("scenario `{}` matches no scenario of the study `{}`{}", gate.scenario, study,
                       nearest_words(gate.scenario, scenarios));
  if (steps.empty() && !elsewhere)
    return fmt::format("method `{}` matches no method of the study `{}`{}", gate.method, study,
                       nearest_words(gate.method, methods));
  if (steps.empty())
    return fmt::format("method `{}` does not run on `{}` in the study `{}`{}", gate.method, gate.scenario, study,
                       nearest_words(gate.method, here));
  if (gate.steps && !steps.contains(*gate.steps)) {
    const auto above = steps.lower_bound(*gate.steps);
    const std::int64_t near = above == steps.end()                                     ? *steps.rbegin()
                              : above == steps.begin()                                 ? *above
                              : *above - *gate.steps < *gate.steps - *std::prev(above) ? *above
                                                                                       : *std::prev(above);
    return fmt::format("steps = {} matches nothing: `{}` runs `{}` with {} steps; nearest: {}", *gate.steps,
                       gate.method, gate.scenario, fmt::join(steps, ", "), near);
  }
  if (gate.kind == Gate::Kind::within_claim)
    return fmt::format(
        "no [[cells]] of the study `{}` has claim = \"{}\": no ladder measures the claimed order of that motion", study,
        gate.claim);
  return fmt::format("no cell of the study `{}` has this scenario, method and count of steps together", study);
}

// What is wrong where the gate's metric does not exist; empty otherwise.
std::string unknown_metric(const Gate& gate) {
  std::set<std::string> known;
  for (const MetricInfo& metric : all_metrics()) known.insert(metric.name);
  if (std::any_of(known.begin(), known.end(), [&](const std::string& name) { return glob_match(gate.metric, name); }))
    return "";
  return fmt::format("no metric has the name `{}`{}", gate.metric, nearest_words(gate.metric, known));
}

Verdict not_run(const Gate& gate, const std::string& why) {
  Verdict verdict;
  verdict.gate = gate;
  verdict.scenario = gate.scenario;
  verdict.method = gate.method;
  verdict.metric = gate.metric;
  verdict.steps = gate.steps.value_or(0);
  verdict.judgement = Judgement::not_run;
  verdict.value = std::numeric_limits<double>::quiet_NaN();
  verdict.margin = -std::numeric_limits<double>::infinity();
  verdict.text = fmt::format("{}: {}", gate.origin, why);
  return verdict;
}

std::set<std::string> study_ids(const Place& place, const std::string& own) {
  std::set<std::string> ids{own};
  for (const auto& entry : fs::directory_iterator(place.source_dir + "/validation/study"))
    if (entry.path().extension() == ".toml") ids.insert(entry.path().stem().string());
  return ids;
}

std::string another_study(const Place& place, const Gate& gate, const std::string& study) {
  const std::set<std::string> ids = study_ids(place, study);
  return fmt::format("its file is about the study `{}`, and this is `{}`{}", gate.study, study,
                     ids.contains(gate.study) ? "" : nearest_words(gate.study, ids));
}

// Gates of the catalogue: a narrowed run drops those that it leaves without cells, and with --steps those of a whole
// ladder. Gates of a study judge its runs alone; they stay when they have no cells, unless the command line narrowed
// the run.
bool left_out_of_catalogue(const Options& options, const Selection& selection, const std::vector<CellName>& cells,
                           const Gate& gate) {
  if (!gate.study.empty() && gate.study != selection.study) return true;
  if (!selection.narrowed) return false;
  if (of_ladder(gate.metric) && rungs_chosen(options)) return true;
  if (!filtered(options) && !gate.study.empty()) return false;
  if (!has_rival(gate, cells)) return true;
  return std::none_of(cells.begin(), cells.end(), [&](const CellName& cell) {
    if (cell.probe && gate.study.empty()) return false;  // probes are judged only by gates of their study
    return glob_match(gate.scenario, cell.scenario) && glob_match(gate.method, cell.method) &&
           (!gate.steps || *gate.steps == cell.steps);
  });
}

bool judges(const Gate& gate, const CellName& cell) {
  return matches(gate, cell) || (gate.kind == Gate::Kind::max_ratio && glob_match(gate.scenario, cell.scenario) &&
                                 cell.method == gate.ratio_to && (!gate.steps || *gate.steps == cell.steps));
}

bool same_gate(const Gate& a, const Gate& b) {
  return a.origin == b.origin && a.kind == b.kind && a.scenario == b.scenario && a.method == b.method &&
         a.metric == b.metric && a.steps == b.steps && a.claim == b.claim && a.ratio_to == b.ratio_to;
}

const char* is_or_are(std::size_t count) { return count == 1 ? "is" : "are"; }

}  // namespace

std::string missing_words(const Selection& selection, const StudyResult& result) {
  if (result.missing.empty()) return "";
  const Cell& first = selection.cells[result.missing.front()];
  return fmt::format("{} of {} planned cells {} not in the store (the first: {}, {}, {} steps)", result.missing.size(),
                     selection.cells.size(), is_or_are(result.missing.size()), first.scenario->id, first.method,
                     first.plan.steps);
}

void judge_missing(const Selection& selection, const std::vector<Gate>& gates, const StudyResult& result,
                   const std::vector<std::string>& run_words, std::vector<Verdict>& verdicts) {
  if (result.missing.empty()) return;
  const std::vector<CellName> cells = names_of(selection.cells);
  for (const Gate& gate : gates) {
    const auto of_gate = static_cast<std::size_t>(
        std::count_if(cells.begin(), cells.end(), [&](const CellName& cell) { return judges(gate, cell); }));
    const auto missing = static_cast<std::size_t>(std::count_if(result.missing.begin(), result.missing.end(),
                                                                [&](std::size_t i) { return judges(gate, cells[i]); }));
    if (missing == 0) continue;
    std::erase_if(verdicts, [&](const Verdict& verdict) {
      return verdict.judgement != Judgement::fail && same_gate(verdict.gate, gate);
    });
    Verdict verdict =
        not_run(gate, fmt::format("{} of its {} cells {} not in the store", missing, of_gate, is_or_are(missing)));
    verdict.rerun = run_words;
    verdicts.push_back(std::move(verdict));
  }
}

std::vector<CellName> names_of(const std::vector<Cell>& cells) {
  std::vector<CellName> names;
  for (const Cell& cell : cells)
    names.push_back({cell.scenario->id, cell.method, cell.claim, cell.plan.steps, cell.probe != Probe::none,
                     cell.worker < 0 && has_glob(cell.method), resolution_text(resolution_of(cell))});
  return names;
}

std::vector<CellName> unfiltered_cells(const Place& place, const Options& options, const Selection& selection) {
  std::vector<CellName> names = names_of(selection.cells);
  if (!filtered(options) && options.spacings.empty() && options.sound_speeds.empty()) return names;
  const auto add = [&](const Options& wide) {
    try {
      for (const CellName& name : names_of(select_cells(place, wide).cells)) names.push_back(name);
    } catch (const InputError&) {  // nothing to run without the filter: then the filter's own cells are all there is
    }
  };
  Options wide = options;
  wide.methods.clear();
  wide.steps.clear();
  wide.hz.clear();
  wide.spacings.clear();
  wide.sound_speeds.clear();
  wide.scenarios.clear();
  add(wide);
  for (const std::string& name : options.scenarios) {
    std::error_code ignored;
    if (fs::is_regular_file(name, ignored)) wide.scenarios.push_back(name);
  }
  if (!wide.scenarios.empty()) add(wide);
  return names;
}

SiftedGates sift_gates(const Place& place, const Options& options, const Selection& selection,
                       const std::vector<Gate>& gates) {
  SiftedGates sifted;
  const std::vector<CellName> kept = names_of(selection.cells);
  std::optional<std::vector<CellName>> whole;  // planned when the first gate asks
  for (const Gate& gate : gates) {
    // A trace that is checked belongs to no study: gates that do not match it are left out.
    if (!gate.named || selection.study.empty()) {
      if (left_out_of_catalogue(options, selection, kept, gate)) continue;
      sifted.judged.push_back(gate);
      sifted.judged.back().partial = selection.narrowed && (has_glob(gate.scenario) || has_glob(gate.method));
      continue;
    }
    if (!gate.study.empty() && gate.study != selection.study) {
      sifted.unmatched.push_back(not_run(gate, another_study(place, gate, selection.study)));
      continue;
    }
    if (const std::string words = unknown_metric(gate); !words.empty()) {
      sifted.unmatched.push_back(not_run(gate, words));
      continue;
    }
    const bool here = any_matches(gate, kept);
    if (here && has_rival(gate, kept) && !(of_ladder(gate.metric) && rungs_chosen(options))) {
      sifted.judged.push_back(gate);
      continue;
    }
    if (!whole) whole = unfiltered_cells(place, options, selection);
    if (!any_matches(gate, *whole))
      sifted.unmatched.push_back(not_run(gate, what_matches_nothing(gate, *whole, selection.study)));
    else if (!has_rival(gate, *whole)) {
      std::set<std::string> methods;
      for (const CellName& cell : *whole)
        if (glob_match(gate.scenario, cell.scenario)) methods.insert(cell.method);
      sifted.unmatched.push_back(not_run(gate, fmt::format("max_ratio: `{}` does not run on `{}`{}", gate.ratio_to,
                                                           gate.scenario, nearest_words(gate.ratio_to, methods))));
    } else {
      ++sifted.left_out;
    }
  }
  return sifted;
}

}  // namespace atwood
