// The cells of a call of the program: its study, narrowed by its options.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <thread>

#include <fmt/ranges.h>

#include "reports/command_line/command_line.hpp"
#include "reports/command_line/contest.hpp"
#include "reports/command_line/method_words.hpp"
#include "reports/command_line/units.hpp"
#include "scene/files.hpp"
#include "validation/gates/gates.hpp"
#include "validation/metrics/work_precision.hpp"
#include "validation/study/check_fluids.hpp"

namespace atwood {
namespace fs = std::filesystem;

namespace {

// InputError where two files have one id: store, gates and baselines could not distinguish them.
void require_one_file_each(const std::vector<Scenario>& scenarios) {
  std::map<std::string, std::string> files;
  for (const auto& scenario : scenarios) {
    const auto [first, inserted] = files.emplace(scenario.id, scenario.path);
    std::error_code error;
    if (!inserted && first->second != scenario.path && !fs::equivalent(first->second, scenario.path, error))
      throw InputError(fmt::format("two files have the id `{}`: {} and {}; expected an id of its own in each",
                                   scenario.id, first->second, scenario.path));
  }
}

// The scenarios named on the command line: globs over those that are known, ids, families (`cradle` for `cradle-*`), or
// files of the user's own.
std::vector<Scenario> choose_scenarios(const Place& place, const std::vector<std::string>& wanted,
                                       const std::vector<Scenario>& known) {
  if (wanted.empty()) return known;
  std::vector<Scenario> chosen;
  for (const auto& name : wanted) {
    const auto before = chosen.size();
    for (const auto& scenario : known) {
      if (glob_match(name, scenario.id)) chosen.push_back(scenario);
    }
    if (chosen.size() == before && !fs::exists(name)) {
      for (const auto& scenario : known) {
        if (scenario.id.starts_with(name + "-")) chosen.push_back(scenario);
      }
    }
    if (chosen.size() == before) {
      if (name.find_first_of("*?") != std::string::npos)
        throw InputError(fmt::format("no scenario matches `{}`", name));
      chosen.push_back(read_scene_argument(place, name));
      require_own_id(place, chosen.back());
    }
  }
  require_one_file_each(chosen);
  std::set<std::string> seen;
  std::erase_if(chosen, [&](const Scenario& scenario) { return !seen.insert(scenario.id).second; });
  return chosen;
}

// Scenes that a study names by their files: read once each, and named by their ids from here on.
std::vector<Scenario> read_own_scenes(const Place& place, Study& study) {
  std::map<std::string, std::string> ids;  // by path
  std::vector<Scenario> own;
  for (StudyCells& cells : study.cells) {
    for (std::string& name : cells.scenarios) {
      const bool file = name.rfind("tag:", 0) != 0 && (name.find('/') != std::string::npos || name.ends_with(".toml"));
      if (!file) continue;
      if (!ids.contains(name)) {
        Scenario scenario = read_scene_argument(place, name);
        ids[name] = scenario.id;
        require_own_id(place, scenario);
        if (!own_file(place, scenario).empty()) own.push_back(std::move(scenario));
      }
      name = ids[name];
    }
  }
  require_one_file_each(own);
  return own;
}

void check_steps(const Scenario& scenario, const std::vector<std::int64_t>& steps) {
  for (const auto n : steps) {
    if (n <= 0 || n % scenario.samples != 0) {
      throw InputError(
          fmt::format("--steps {}: expected a multiple of the {} samples of `{}`", n, scenario.samples, scenario.id));
    }
  }
}

// What was expected instead: all of a short list, the similar ids of a long one.
std::string expected_ids(const std::string& id, const std::vector<MethodInfo>& known) {
  std::vector<std::string> ids;
  for (const auto& info : known) ids.push_back(info.id);
  if (ids.size() <= 12) return fmt::format("; expected one of {}", fmt::join(ids, ", "));
  return nearest_hint(id, ids, 6) + "; `atwood list methods` shows all";
}

// Methods that answer contact queries and integrate no motion: sweeps of poses ask them.
bool is_contact_test(const std::string& scheme) {
  return scheme == "contacts" || scheme == "box-edges" || scheme == "unit-size" || scheme == "closest-points";
}

// Whether the worker is the engine of this name, or would be if it were built.
bool is_named(const Worker& worker, const std::string& engine) {
  const std::string file = fs::path(worker.path).filename().string();
  return worker.status == Status::ok
             ? glob_match(engine, worker.engine.name)
             : glob_match("atwood-" + engine, file) || (engine == "atwood" && file == "atwood-engine");
}

// Why a known engine has no adapter; empty for any other name.
std::string why_left_out(const std::string& engine) {
  if (engine != "physx") return "";
  return " (PhysX's package for JavaScript, physx-js-webidl, is built only for browsers and does not load under Node.js)";
}

// InputError unless some available engine provides the method, or its engine is known and not built. `who` says where
// the method is named: "--method ".
void check_method(const std::string& who, const std::string& text, const std::vector<Worker>& workers) {
  const bool glob = text.find_first_of("*?") != std::string::npos;
  const std::string base = text.substr(0, text.find_first_of(":+@{"));
  const std::size_t slash = base.find('/');
  if (!glob) {
    try {
      parse_method_id(text);
    } catch (const std::invalid_argument& error) {
      throw InputError(fmt::format("{}{}: {}", who, text, without_id(error, text)));
    }
  } else if (slash == std::string::npos) {
    return;  // the glob is over whole ids, of engines that are not built too
  }
  const std::string engine = base.substr(0, slash);
  std::string names;
  bool engine_found = false, method_found = false;
  std::vector<MethodInfo> known;
  for (const Worker& worker : workers) {
    if (worker.status == Status::ok) names += (names.empty() ? "" : ", ") + worker.engine.name;
    if (!is_named(worker, engine)) continue;
    engine_found = true;
    if (worker.status != Status::ok) method_found = true;  // unknown
    for (const MethodInfo& info : worker.engine.methods) method_found = method_found || glob_match(base, info.id);
    known.insert(known.end(), worker.engine.methods.begin(), worker.engine.methods.end());
  }
  if (text == "truth") return;
  if (!engine_found)
    throw InputError(fmt::format("{}{}: no engine `{}` is available{}; expected one of {}, or --engine FILE", who, text,
                                 engine, why_left_out(engine), names));
  if (method_found || (!glob && is_contact_test(base.substr(slash + 1)))) return;
  if (glob)
    throw InputError(fmt::format("{}{}: no method of {} matches{}", who, text, engine, expected_ids(base, known)));
  throw InputError(fmt::format("{}{}: {} has no method `{}`{}", who, text, engine, base.substr(slash + 1),
                               expected_ids(base, known)));
}

// What a study names, cell by cell of the file: methods, and scenarios of the catalogue or of the command line.
void check_study(const Study& study, const std::vector<Scenario>& catalogue, const std::vector<Worker>& workers) {
  for (const StudyCells& cells : study.cells) {
    for (const std::string& method : cells.methods)
      check_method(fmt::format("study `{}`: ", study.id), method, workers);
    for (const std::string& name : cells.scenarios) {
      if (std::any_of(catalogue.begin(), catalogue.end(), [&](const Scenario& s) { return names_scenario(name, s); }))
        continue;
      throw InputError(fmt::format(
          "study `{}`: scenarios: the catalogue has no scenario `{}`; expected ids, globs over ids, tag:NAME (`atwood "
          "list scenarios` shows ids and tags) or files, as in scenes/mine.toml",
          study.id, name));
    }
  }
}

// The file of a study: a path that exists, or the id of a study of the catalogue. InputError where it is neither.
std::string study_path(const Place& place, const std::string& study) {
  const std::string folder = place.source_dir + "/validation/study/";
  if (study.empty()) return folder + "default.toml";
  if (fs::exists(study)) return study;
  const bool looks_like_file = study.find('/') != std::string::npos || study.ends_with(".toml");
  if (!looks_like_file && fs::exists(folder + study + ".toml")) return folder + study + ".toml";
  if (looks_like_file) return study;
  std::set<std::string> known;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == ".toml") known.insert(entry.path().stem().string());
  }
  throw InputError(fmt::format("no study `{}` in the catalogue and no file of that name; expected a file or one of {}",
                               study, fmt::join(known, ", ")));
}

// Of a study's cells those of the wanted methods, by the whole id or by the part before tolerance and suffixes.
std::vector<Cell> cells_of_methods(const std::vector<Cell>& cells, const std::vector<std::string>& wanted) {
  std::vector<Cell> left;
  for (const Cell& cell : cells) {
    const std::string base = cell.method.substr(0, cell.method.find_first_of(":+@{"));
    if (std::any_of(wanted.begin(), wanted.end(), [&](const std::string& method) {
          return method == cell.method || glob_match(method, cell.method) || glob_match(method, base);
        }))
      left.push_back(cell);
  }
  return left;
}

std::vector<std::string> engine_methods(const Worker& worker) {
  std::vector<std::string> ids;
  for (const auto& info : worker.engine.methods) ids.push_back(info.id);
  return ids;
}

bool names_scenario(const Study& study, const std::string& id) {
  return std::any_of(study.cells.begin(), study.cells.end(), [&](const StudyCells& cells) {
    return std::any_of(cells.scenarios.begin(), cells.scenarios.end(),
                       [&](const std::string& name) { return glob_match(name, id); });
  });
}

// Why the filters left no cell, and what would leave some: a scene of the catalogue that other studies have.
std::string nothing_to_run(const Place& place, const Options& options, const Study& study,
                           const std::vector<Scenario>& chosen) {
  if (options.scenarios.empty() || chosen.empty() || !options.methods.empty())
    return "nothing to run: the filters leave no cell of this study; `atwood list` shows scenarios and methods";
  const Scenario& scenario = chosen.front();
  std::string studies;
  const std::string folder = place.source_dir + "/validation/study";
  for (const std::string& id : file_stems(folder)) {
    const Study other = read_study(folder + "/" + id + ".toml");
    const bool has = std::any_of(other.cells.begin(), other.cells.end(), [&](const StudyCells& cells) {
      return std::any_of(cells.scenarios.begin(), cells.scenarios.end(),
                         [&](const std::string& name) { return names_scenario(name, scenario); });
    });
    if (has) studies += (studies.empty() ? "" : ", ") + other.id;
  }
  const char* method = scenario.scene.fluids.empty() ? "atwood/rk4" : "atwood/rk4+sph";
  return fmt::format("nothing to run: the {} `{}` has no cell of `{}`; expected {}--method METHOD, as in --method {}",
                     options.study.empty() ? "default study" : "study", study.id, scenario.id,
                     studies.empty() ? "" : "a study that has one (" + studies + ") or ", method);
}

// Only the scenarios that have cells.
void keep_used(Selection& selection) {
  std::set<std::string> used;
  for (const auto& cell : selection.cells) used.insert(cell.scenario->id);
  std::erase_if(selection.scenarios, [&](const Scenario& scenario) { return !used.contains(scenario.id); });
}

}  // namespace

void require_answers(const std::vector<Worker>& workers, const Study* study) {
  for (const Worker& worker : workers) {
    if (!worker.foreign || worker.status == Status::ok) continue;
    const bool of_study =
        study && std::find(study->engines.begin(), study->engines.end(), worker.command) != study->engines.end();
    const std::string words =
        fmt::format("{}{}: {}: {}", of_study ? fmt::format("study `{}`: engines: ", study->id) : "--engine ",
                    fmt::join(worker.command, " "), to_string(worker.status), worker.reason);
    if (worker.status == Status::not_built) throw InputError(words);  // it cannot be started
    throw WorkerFailure(words);
  }
}

void refuse_unknown_method(const std::string& option, const std::string& method, const std::vector<Worker>& workers,
                           const std::vector<std::string>& others) {
  const std::string base = base_of(method), engine = engine_of(method);
  if (const Worker* worker = unanswered(workers, engine)) {
    const std::string words = fmt::format("{}{}: the engine {} is not available: {}: {}", option, method, engine,
                                          to_string(worker->status), worker->reason);
    if (worker->status == Status::not_built) throw InputError(words);
    throw WorkerFailure(words);
  }
  std::vector<std::string> known = others;
  for (const Worker& worker : workers)
    for (const MethodInfo& info : worker.engine.methods)
      if (worker.status == Status::ok) known.push_back(info.id);
  throw InputError(fmt::format("{}{}: no available engine provides this method{}; `atwood list methods` shows all",
                               option, method, nearest_hint(base, known, 3)));
}

namespace {

// The scenarios that the blocks of a study name, without probes.
std::vector<std::string> scenarios_of(const Study& study) {
  std::vector<std::string> names;
  std::set<std::string> seen;
  for (const StudyCells& cells : study.cells)
    for (const std::string& name : cells.scenarios)
      if (cells.probe == Probe::none && seen.insert(name).second) names.push_back(name);
  return names;
}

// Whether words of the command line or of a study name this engine's methods.
bool names_engine(const std::vector<std::string>& methods, const Worker& worker) {
  return std::any_of(methods.begin(), methods.end(), [&](const std::string& method) {
    return glob_match(method.substr(0, method.find('/')), worker.engine.name);
  });
}

// Engines of --engine: alone where neither a study nor a method was named; otherwise beside what was, unless that names
// their methods.
void add_engines(Study& study, const Options& options, const std::vector<Worker>& workers) {
  if (options.engines.empty()) return;
  const bool alone = options.study.empty() && options.methods.empty();
  std::vector<std::string> scenarios = scenarios_of(study);
  if (!options.scenarios.empty() || scenarios.empty()) scenarios = {"*"};
  if (alone) study.cells.clear();
  for (const Worker& worker : workers) {
    const bool of_study = std::find(study.engines.begin(), study.engines.end(), worker.command) != study.engines.end();
    if (!worker.foreign || of_study) continue;
    const bool named = std::any_of(study.cells.begin(), study.cells.end(),
                                   [&](const StudyCells& cells) { return names_engine(cells.methods, worker); });
    if (!alone && (named || options.named_methods_only)) continue;
    study.cells.push_back(
        {.scenarios = scenarios, .methods = engine_methods(worker), .steps = {}, .repeats = 5, .sweep = {}});
  }
}

// A scene of the user's own that the study does not name: it gets what the study's smooth scenes get.
void add_own_scenes(Study& study, const Options& options, const std::vector<Scenario>& chosen) {
  std::vector<std::string> methods;
  std::set<std::string> seen, named;
  for (const StudyCells& cells : study.cells) {
    named.insert(cells.scenarios.begin(), cells.scenarios.end());
    for (const std::string& method : cells.methods)
      if (seen.insert(method).second) methods.push_back(method);
  }
  for (const std::string& name : options.scenarios) {
    if (!fs::is_regular_file(name)) continue;
    for (const Scenario& scenario : chosen) {
      std::error_code error;
      if (named.contains(scenario.id) || !fs::equivalent(scenario.path, name, error)) continue;
      study.cells.push_back({.scenarios = {scenario.id}, .methods = methods, .steps = {}, .repeats = 5, .sweep = {}});
    }
  }
}

// The methods of this call: those of the command line, and the study's where it was named or where it alone has any.
// Empty: a part of the study takes all methods there are.
std::vector<std::string> methods_of_call(const Options& options, const Study& study) {
  std::vector<std::string> methods = options.methods;
  if (!options.study.empty() || options.methods.empty()) {
    for (const StudyCells& cells : study.cells) {
      if (cells.methods.empty() && study.engines.empty()) return {};
      methods.insert(methods.end(), cells.methods.begin(), cells.methods.end());
    }
  }
  return methods;
}

// The study of this call: its engines answered, its scenes read, all of their methods where a block names none.
Study open_study(const Place& place, const Options& options, Selection& selection, std::vector<Scenario>& known) {
  Study study = read_study(study_path(place, options.study));
  const std::vector<Scenario> own = read_own_scenes(place, study);
  known = read_catalogue(place);
  known.insert(known.end(), own.begin(), own.end());
  selection.study = study.id;
  selection.tolerances = options.tolerances.empty() ? study.tolerances : options.tolerances;
  selection.baseline = options.baseline.empty() ? study.baseline : options.baseline;
  selection.workers = require_workers(place, options, &study, methods_of_call(options, study));
  require_answers(selection.workers, &study);
  for (StudyCells& cells : study.cells) {
    if (options.limit_given) cells.limit_s = 0;
    if (!cells.methods.empty()) continue;
    for (const Worker& worker : selection.workers) {
      if (std::find(study.engines.begin(), study.engines.end(), worker.command) == study.engines.end()) continue;
      const auto ids = engine_methods(worker);
      cells.methods.insert(cells.methods.end(), ids.begin(), ids.end());
    }
  }
  return study;
}

}  // namespace

namespace {

// --spacing and --sound-speed: fluids at these alone.
void take_resolutions(const Options& options, Study& study) {
  for (const auto* values : {&options.spacings, &options.sound_speeds})
    for (const double value : *values)
      if (!(value > 0) || !std::isfinite(value))
        throw InputError(fmt::format("{} {}: expected a number above 0",
                                     values == &options.spacings ? "--spacing" : "--sound-speed", value));
  for (StudyCells& cells : study.cells) {
    if (!options.spacings.empty()) cells.spacings_m = options.spacings;
    if (!options.sound_speeds.empty()) cells.sound_speeds_m_per_s = options.sound_speeds;
  }
}

}  // namespace

Selection select_cells(const Place& place, const Options& options) {
  Selection selection;
  std::vector<Scenario> known;
  Study study = open_study(place, options, selection, known);
  take_resolutions(options, study);
  selection.narrowed = !options.spacings.empty() || !options.sound_speeds.empty() || !options.scenarios.empty() ||
                       !options.methods.empty() || !options.steps.empty() || !options.hz.empty() ||
                       !options.study.empty() || !options.engines.empty();
  for (const std::string& method : options.methods) check_method("--method ", method, selection.workers);
  selection.scenarios = choose_scenarios(place, options.scenarios, known);
  known.insert(known.end(), selection.scenarios.begin(), selection.scenarios.end());
  if (!options.study.empty()) check_study(study, known, selection.workers);
  const std::string of_study = fmt::format("study `{}`: ", study.id);
  const std::map<std::string, std::string> unfit = set_frequencies(selection.scenarios, options.hz, study);
  const auto planned = [&] {
    for (StudyCells& cells : study.cells) cells.whole_ladder = options.whole_ladders;
    return plan_cells(study, selection.scenarios, selection.workers, place.provenance.cpu, options.max_cells);
  };

  if (!options.methods.empty() && !options.study.empty()) {  // a part of the study that was named, as the study has it
    if (!options.steps.empty()) {
      for (auto& cells : study.cells) cells.only_steps = options.steps;
    }
    selection.cells = cells_of_methods(planned(), options.methods);
    require_frequencies(selection.cells, unfit);
    if (!selection.cells.empty()) {
      check_settings(of_study, selection.cells, selection.workers);
      check_fluids(of_study, selection.cells, selection.workers);
      keep_used(selection);
      return selection;
    }
  }
  if (!options.methods.empty()) {  // the command line's methods on its scenarios, whatever the study pairs
    study.cells = {{.scenarios = {"*"}, .methods = options.methods, .steps = {}, .repeats = 5, .sweep = {}}};
  } else {
    add_own_scenes(study, options, selection.scenarios);
  }
  add_engines(study, options, selection.workers);
  if (!options.steps.empty()) {
    for (const auto& scenario : selection.scenarios)
      if (names_scenario(study, scenario.id)) check_steps(scenario, options.steps);
    for (auto& cells : study.cells) cells.only_steps = options.steps;
  }
  take_resolutions(options, study);  // blocks may be new
  selection.cells = planned();
  require_frequencies(selection.cells, unfit);
  if (selection.cells.empty()) throw InputError(nothing_to_run(place, options, study, selection.scenarios));
  if ((!options.spacings.empty() || !options.sound_speeds.empty()) &&
      std::ranges::all_of(selection.cells, [](const Cell& cell) { return cell.scenario->scene.fluids.empty(); }))
    throw InputError(
        fmt::format("{}: no scene of this run has a fluid", options.spacings.empty() ? "--sound-speed" : "--spacing"));
  const std::string who = options.methods.empty() ? of_study : "--method ";
  check_settings(who, selection.cells, selection.workers);
  check_fluids(who, selection.cells, selection.workers);
  keep_used(selection);
  return selection;
}

Selection without_cells(const Selection& selection) {
  return {selection.scenarios, selection.workers, {}, selection.study, selection.tolerances,
          selection.baseline,  selection.narrowed};
}

std::string own_file(const Place& place, const Scenario& scenario) {
  if (scenario.path.empty()) return "";
  const fs::path folder = fs::weakly_canonical(fs::path(scenario.path).parent_path());
  for (const std::string& ours : catalogue_folders(place))
    if (folder == fs::weakly_canonical(ours)) return "";
  return scenario.path;
}

std::int64_t memory_limit_of(const Options& options) {
  const double gibibytes = options.memory_GiB;
  if (!(gibibytes == 0 || (gibibytes >= 0.0625 && gibibytes <= 1e6)))
    throw InputError(fmt::format("--memory {:g}: expected GiB from 0.0625 to 1e6, or 0 for no limit", gibibytes));
  return static_cast<std::int64_t>(gibibytes * (1 << 30));
}

StudyOptions study_options(const Place& place, const Options& options) {
  StudyOptions how;
  how.store_path = options.out_dir + "/store.db";
  how.truth_worker = place.truth_worker;
  how.truth_confinement.memory_bytes = memory_limit_of(options);
  how.jobs = options.jobs > 0 ? options.jobs : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  how.cell_limit_s = options.cell_limit_s;
  // A truth is solved several times in quad.
  how.truth_limit_s = options.limit_given ? 6 * options.cell_limit_s : std::max(120.0, 6 * options.cell_limit_s);
  how.timing = !options.no_timing;
  how.fresh = options.fresh;
  how.reuse = options.reuse;
  how.purpose = options.purpose;
  how.keep = options.keep == "none" ? Keep::none : options.keep == "worst" ? Keep::worst : Keep::all;
  how.notice = [](const std::string& text) { std::fputs(("atwood: " + text + "\n").c_str(), stderr); };
  how.provenance = place.provenance;
  return how;
}

}  // namespace atwood
