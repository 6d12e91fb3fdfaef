// Paths of sources and workers, the CPU, the terminal.
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "reports/command_line/build_info.hpp"
#include "reports/command_line/command_line.hpp"
#include "scene/files.hpp"
#include "scene/input_file.hpp"
#include "scene/named_metric.hpp"
#include "scene/printable.hpp"
#include "validation/metrics/metrics.hpp"
#include "validation/study/process.hpp"

namespace atwood {
namespace fs = std::filesystem;

namespace {

std::string cpu_name() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    if (line.rfind("model name", 0) == 0) return line.substr(line.find(':') + 2);
  }
  return "unknown";
}

std::string environment_or(const char* name, const std::string& otherwise) {
  const char* value = std::getenv(name);
  return value && *value ? value : otherwise;
}

// Optional engines: built, or installed as a script, where CMake finds their libraries. `packages`: what a build needs;
// `installed`: how an installation gets it.
struct OptionalEngine {
  const char *name, *library, *packages, *installed;
};
constexpr const char* kNodePackages = "nodejs 18 or newer, npm, and packages of npm in the build's folder";
constexpr const char* kNodeInstalled = "the package atwood-node-engines brings it";
constexpr OptionalEngine kOptionalEngines[] = {
    {"dart", "DART", "libdart-dev, libdart-external-ikfast-dev, libdart-collision-ode-dev",
     "the package atwood-dart brings its worker"},
    {"jolt", "Jolt", kNodePackages, kNodeInstalled},
    {"mujoco", "MuJoCo", "libmujoco-dev", "the package atwood-mujoco brings its worker"},
    {"mujoco3", "MuJoCo 3", kNodePackages, kNodeInstalled},
    {"pysph", "PySPH", "python3-pysph", "it runs only from the project's folder: `ATWOOD_ENGINES=pysph ./atwood run`"},
    {"rapier", "Rapier", kNodePackages, kNodeInstalled},
    {"simbody", "Simbody", "libsimbody-dev", "the package atwood-simbody brings its worker"}};

// What to do about an optional engine whose executable is not there.
void explain_missing(const Place& place, Worker& worker) {
  if (fs::exists(worker.path)) return;
  for (const auto& engine : kOptionalEngines) {
    if (fs::path(worker.path).filename() != fmt::format("atwood-{}", engine.name)) continue;
    if (place.installed) {
      worker.reason = fmt::format("{} is not in this installation; {}", engine.library, engine.installed);
      return;
    }
    worker.reason = fmt::format(
        "{} was not there when this was built; `ATWOOD_ENGINES={} ./atwood run` installs it ({}) and "
        "builds its worker",
        engine.library, engine.name, engine.packages);
  }
}

// Replaces what cannot be printed in the texts of a foreign engine's answer to `hello`. Its ids are sent back to it as
// they are, so one with control characters makes the engine `crashed`.
void make_printable(Worker& worker) {
  Engine& engine = worker.engine;
  for (std::string* text : {&engine.version, &engine.scalar, &worker.reason}) *text = printable(*text);
  bool plain = printable(engine.name) == engine.name;
  for (auto* list : {&engine.methods, &engine.responses}) {
    for (MethodInfo& info : *list) {
      plain = plain && printable(info.id) == info.id;
      for (std::string* text : {&info.doc, &info.source}) *text = printable(*text);
      for (auto& [name, value] : info.settings) {
        plain = plain && printable(name) == name;
        if (auto* text = std::get_if<std::string>(&value)) plain = plain && printable(*text) == *text;
      }
    }
  }
  if (plain || worker.status != Status::ok) return;
  worker.status = Status::crashed;
  worker.reason = "answering `hello`: invalid answer: a name, an id or a setting has control characters";
  engine.methods.clear();
  engine.responses.clear();
}

// InputError, before anything runs, where `solution` names no closed form. The worker of truths lists the names.
void require_known_solution(const Place& place, const Scenario& scenario) {
  if (scenario.truth.kind != TruthKind::closed_form || !fs::exists(place.truth_worker)) return;
  std::istringstream lines(capture({place.truth_worker, "--solutions"}));
  std::vector<std::string> known;
  for (std::string id; std::getline(lines, id);) known.push_back(id);
  if (std::find(known.begin(), known.end(), scenario.truth.solution) != known.end()) return;
  const std::vector<std::string> near = nearest(scenario.truth.solution, known, 1);
  throw InputError(fmt::format("{}: `solution` in [truth] is \"{}\"; expected one of {}{}",
                               place_of_key(scenario.path, "truth", "solution"), scenario.truth.solution,
                               fmt::join(known, ", "), near.empty() ? "" : " (did you mean " + near.front() + "?)"));
}

// The scene's reader knows no metrics, so that the name of its own is looked up here.
void require_known_metric(const Scenario& scenario) {
  const std::string metric = named_metric(scenario);
  std::vector<std::string> known;
  for (const MetricInfo& info : all_metrics()) known.push_back(info.name);
  if (metric.empty() || std::find(known.begin(), known.end(), metric) != known.end()) return;
  throw InputError(fmt::format("{}: `metric` is \"{}\"; expected a metric of `atwood list metrics`{}",
                               place_of_key(scenario.path, "", "metric"), metric, nearest_hint(metric, known, 1)));
}

}  // namespace

Place find_place() {
  Place place;
  const fs::path bin = fs::read_symlink("/proc/self/exe").parent_path();
  place.installed = fs::is_directory(bin / "../libexec/atwood");
  place.worker_dir = place.installed ? fs::canonical(bin / "../libexec/atwood").string() : bin.string();
  place.source_dir = environment_or("ATWOOD_ROOT", fs::weakly_canonical(bin / "../share/atwood").string());
  place.truth_worker = place.worker_dir + "/atwood-truth";
  const auto now = std::chrono::system_clock::now();
  place.provenance = {
      .engine_version = "",
      .commit = build_info::commit,
      .compiler = build_info::compiler,
      .flags = build_info::flags,
      .cpu = cpu_name(),
      .run_id = fmt::format("{:%Y%m%dT%H%M%SZ}-{}", fmt::gmtime(std::chrono::system_clock::to_time_t(now)), getpid()),
      .cpu_features = processor_features(),
      .libm = libm_version()};
  return place;
}

std::vector<std::string> catalogue_folders(const Place& place) {
  const std::string folder = place.source_dir + "/validation/scenarios";
  return {folder, folder + "/fluid"};
}

std::string catalogue_file(const Place& place, const std::string& id) {
  const std::vector<std::string> folders = catalogue_folders(place);
  for (const std::string& folder : folders)
    if (fs::exists(folder + "/" + id + ".toml")) return folder + "/" + id + ".toml";
  return folders.front() + "/" + id + ".toml";
}

std::vector<Scenario> read_catalogue(const Place& place) {
  std::vector<std::string> paths;
  for (const std::string& folder : catalogue_folders(place)) {
    if (!fs::is_directory(folder))
      throw InputError(fmt::format(
          "no catalogue at {} (set ATWOOD_ROOT to the project's root, or to share/atwood of an installation)", folder));
    for (const auto& entry : fs::directory_iterator(folder))
      if (entry.path().extension() == ".toml") paths.push_back(entry.path().string());
  }
  std::sort(paths.begin(), paths.end());
  std::vector<Scenario> catalogue;
  for (const auto& path : paths) {
    catalogue.push_back(read_scenario(path));
    require_known_metric(catalogue.back());
  }
  return catalogue;
}

namespace {

// The message of a missing file, with the most similar name of the scenes in its folder.
InputError no_such_scene(const std::string& file) {
  std::vector<std::string> beside;
  std::error_code error;
  const fs::path folder = fs::path(file).parent_path();
  for (fs::directory_iterator entry(folder.empty() ? fs::path(".") : folder, error), end; !error && entry != end;
       entry.increment(error)) {
    if (entry->path().extension() == ".toml") beside.push_back((folder / entry->path().filename()).string());
  }
  std::sort(beside.begin(), beside.end());
  return InputError(
      fmt::format("{}: no such file; expected a scenario file (TOML){}", file, nearest_hint(file, beside, 1)));
}

}  // namespace

Scenario read_scene_argument(const Place& place, const std::string& id_or_file) {
  const fs::path in_catalogue = catalogue_file(place, id_or_file);
  const bool looks_like_file =
      id_or_file.find('/') != std::string::npos || id_or_file.find(".toml") != std::string::npos;
  if (!looks_like_file && fs::exists(in_catalogue)) {
    Scenario scenario = read_scenario(in_catalogue.string());
    require_known_metric(scenario);
    return scenario;
  }
  if (!looks_like_file && !fs::exists(id_or_file)) {
    std::vector<std::string> ids;
    for (const auto& scenario : read_catalogue(place)) ids.push_back(scenario.id);
    throw InputError(fmt::format(
        "no scenario `{}` in the catalogue, and no file has this name{}; `atwood list scenarios` shows the ids",
        id_or_file, nearest_hint(id_or_file, ids, 3)));
  }
  if (!fs::exists(id_or_file)) throw no_such_scene(id_or_file);
  Scenario scenario = read_scenario(id_or_file);
  require_known_solution(place, scenario);
  require_known_metric(scenario);
  for (const std::string& note : scenario.notes) fmt::print(stderr, "atwood: {}\n", printable(note));
  return scenario;
}

namespace {

// The catalogue's file with this scenario's id, where the scenario is read from another one; empty otherwise.
std::string file_of_same_id(const Place& place, const Scenario& scenario) {
  const fs::path in_catalogue = catalogue_file(place, scenario.id);
  std::error_code error;
  if (scenario.path.empty() || !fs::exists(in_catalogue, error) || fs::equivalent(scenario.path, in_catalogue, error))
    return "";
  return in_catalogue.string();
}

}  // namespace

void require_own_id(const Place& place, const Scenario& scenario) {
  const std::string other = file_of_same_id(place, scenario);
  if (other.empty()) return;
  throw InputError(fmt::format(
      "{}: its id `{}` is that of the catalogue's {}; expected an id of its own: gates, rows and baselines go by ids",
      scenario.path, scenario.id, other));
}

void note_shared_id(const Place& place, const Scenario& scenario) {
  if (file_of_same_id(place, scenario).empty()) return;
  fmt::print(stderr, "atwood: {}: its id `{}` is that of the catalogue's scenario; what is printed is of the file\n",
             printable(scenario.path), printable(scenario.id));
}

namespace {

// The engines that stand before the slash of these methods; empty: some method may be of any engine.
std::set<std::string> engines_of(const std::vector<std::string>& methods) {
  std::set<std::string> engines;
  for (const std::string& method : methods) {
    const std::size_t slash = method.find('/');
    const std::string engine = method.substr(0, slash);
    if (slash == std::string::npos || engine.find_first_of("*?[{:+@") != std::string::npos) return {};
    engines.insert(engine);
  }
  return engines;
}

struct ForeignEngine {
  std::vector<std::string> command;
  bool sandbox = true;
};

// Of each command; the first `own` are this project's. PySPH compiles schemes when they are first used, and keeps them.
std::vector<Confinement> confinements(const Place& place, const std::vector<std::vector<std::string>>& commands,
                                      const std::vector<ForeignEngine>& foreign, std::int64_t memory_bytes) {
  const std::size_t own = commands.size() - foreign.size();
  std::vector<Confinement> all(commands.size());
  for (std::size_t i = 0; i < commands.size(); ++i) {
    all[i].memory_bytes = memory_bytes;
    if (i >= own) all[i].sandbox = foreign[i - own].sandbox;
    else if (fs::path(commands[i].front()).filename() == "atwood-pysph")
      all[i].writable = {place.worker_dir + "/../reference/pysph/cache"};
  }
  return all;
}

// Starts our own engines and the rivals with these names, all of them where `names` is empty, and foreign engines.
std::vector<Worker> start_workers(const Place& place, const std::set<std::string>& names,
                                  const std::vector<ForeignEngine>& foreign, const Options& options) {
  std::vector<std::vector<std::string>> commands;
  std::set<std::string> not_started;
  const auto add_own = [&](const std::string& name, const std::string& program) {
    if (!names.empty() && !names.contains(name)) not_started.insert(name);
    else commands.push_back({fmt::format("{}/{}", place.worker_dir, program)});
  };
  add_own("atwood", "atwood-engine");
  for (const std::string name : {"cvode", "bullet64", "bullet32", "ode", "arkode", "ida", "odeint", "fcl", "libccd"})
    add_own(name, "atwood-" + name);
  for (const auto& engine : kOptionalEngines) add_own(engine.name, fmt::format("atwood-{}", engine.name));
  if (options.with_same_rate) commands.push_back({place.worker_dir + "/atwood-same-rate"});
  const std::size_t own = commands.size();
  for (const ForeignEngine& engine : foreign) commands.push_back(engine.command);
  std::vector<Worker> workers =
      find_workers_by_argv(commands, confinements(place, commands, foreign, memory_limit_of(options)));
  for (std::size_t i = 0; i < workers.size(); ++i) {
    workers[i].foreign = i >= own;
    if (workers[i].foreign) make_printable(workers[i]);
    // A part of the version is in the hashes, in each row, and wherever the engine is named.
    if (!workers[i].confinement.sandbox) workers[i].engine.version += kUnconfined;
    if (workers[i].foreign && workers[i].status == Status::ok && not_started.contains(workers[i].engine.name)) {
      workers[i].status = Status::crashed;
      workers[i].reason = fmt::format(
          "answering `hello`: invalid answer: its name is `{}`, which is already the name of an engine of this program; "
          "expected a name that no other engine has",
          workers[i].engine.name);
    }
    if (workers[i].status == Status::not_built) explain_missing(place, workers[i]);
  }
  return workers;
}

// Does one of the workers bear each of these names?
bool all_there(const std::set<std::string>& names, const std::vector<Worker>& workers) {
  return std::ranges::all_of(names, [&](const std::string& name) {
    return std::ranges::any_of(workers, [&](const Worker& worker) {
      return worker.status == Status::ok
                 ? worker.engine.name == name
                 : fs::path(worker.path).filename() == "atwood-" + name ||
                       (name == "atwood" && fs::path(worker.path).filename() == "atwood-engine");
    });
  });
}

}  // namespace

std::vector<Worker> require_workers(const Place& place, const Options& options, const Study* study,
                                    const std::vector<std::string>& methods) {
  std::vector<ForeignEngine> foreign;
  if (study)
    for (const auto& command : study->engines) foreign.push_back({command, !study->unconfined.contains(command)});
  for (const auto& path : options.engines) {
    if (!fs::exists(path)) throw InputError(fmt::format("--engine {}: no such file", path));
    if (!fs::is_regular_file(path)) throw InputError(fmt::format("--engine {}: not a file", path));
    if (access(path.c_str(), X_OK) != 0)
      throw InputError(fmt::format("--engine {}: it is not executable; `chmod +x` makes it so", path));
    const auto same = [&](const ForeignEngine& known) {
      std::error_code error;
      return known.command.size() == 1 && fs::equivalent(known.command.front(), path, error);
    };
    if (std::none_of(foreign.begin(), foreign.end(), same)) foreign.push_back({{path}, !options.no_sandbox});
  }
  const std::set<std::string> names = engines_of(methods);
  std::vector<Worker> workers = start_workers(place, names, foreign, options);
  const bool failed = std::ranges::any_of(workers, [](const Worker& w) { return w.foreign && w.status != Status::ok; });
  if (failed || all_there(names, workers)) return workers;
  return start_workers(place, {}, foreign, options);  // a message names all that there are
}

std::vector<std::string> unconfined_engines(const std::vector<Worker>& workers) {
  std::vector<std::string> sentences;
  for (const Worker& worker : workers)
    if (worker.status == Status::ok && !worker.confinement.sandbox)
      sentences.push_back(fmt::format(
          "The engine `{}` runs without confinement (sandbox = false): it may use the network and write anywhere.",
          worker.engine.name));
  return sentences;
}

bool is_terminal(int fd) { return isatty(fd) == 1; }

int terminal_width() {
  winsize size{};
  if (ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0) return size.ws_col;
  return 100;
}

bool use_colour(int fd) {
  const char* no_colour = std::getenv("NO_COLOR");
  return is_terminal(fd) && !(no_colour && *no_colour) && environment_or("TERM", "") != "dumb";
}

std::string join(const std::vector<std::string>& words, const char* between) {
  return fmt::format("{}", fmt::join(words, between));
}

}  // namespace atwood
