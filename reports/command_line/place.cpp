// Where things are on this machine: sources, workers, the CPU, the terminal.
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <fmt/chrono.h>
#include <fmt/format.h>

#include "reports/command_line/build_info.hpp"
#include "reports/command_line/command_line.hpp"
#include "scene/files.hpp"

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

// Engines that the default set-up does without: found when configuring, or not built.
struct OptionalEngine { const char *name, *library, *packages; };
constexpr OptionalEngine optional_engines[] = {
    {"dart", "DART", "libdart-dev, libdart-external-ikfast-dev, libdart-collision-ode-dev"},
    {"mujoco", "MuJoCo", "libmujoco-dev"},
    {"simbody", "Simbody", "libsimbody-dev"}};

// What to do about an optional engine whose executable is not there.
void explain_missing(Worker& worker) {
  if (fs::exists(worker.path)) return;
  for (const auto& engine : optional_engines) {
    if (fs::path(worker.path).filename() != fmt::format("atwood-{}", engine.name)) continue;
    worker.reason = fmt::format(
        "{} was not there when this was built; `ATWOOD_ENGINES={} ./atwood run` installs it ({}) and "
        "builds its worker",
        engine.library, engine.name, engine.packages);
  }
}

}  // namespace

Place find_place() {
  Place place;
  place.bin_dir = fs::read_symlink("/proc/self/exe").parent_path().string();
  place.source_dir = environment_or("ATWOOD_ROOT", build_info::source_dir);
  place.truth_worker = place.bin_dir + "/atwood-truth";
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

std::vector<Scenario> read_catalogue(const Place& place) {
  const fs::path folder = fs::path(place.source_dir) / "validation/scenarios";
  if (!fs::is_directory(folder)) {
    throw InputError(fmt::format("no catalogue at {} (set ATWOOD_ROOT to the project's root)", folder.string()));
  }
  std::vector<std::string> paths;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == ".toml") paths.push_back(entry.path().string());
  }
  std::sort(paths.begin(), paths.end());
  std::vector<Scenario> catalogue;
  for (const auto& path : paths) catalogue.push_back(read_scenario(path));
  return catalogue;
}

Scenario read_scene_argument(const Place& place, const std::string& id_or_file) {
  const fs::path in_catalogue = fs::path(place.source_dir) / "validation/scenarios" / (id_or_file + ".toml");
  const bool looks_like_file =
      id_or_file.find('/') != std::string::npos || id_or_file.find(".toml") != std::string::npos;
  if (!looks_like_file && fs::exists(in_catalogue)) return read_scenario(in_catalogue.string());
  if (!looks_like_file && !fs::exists(id_or_file)) {
    std::vector<std::string> ids;
    for (const auto& scenario : read_catalogue(place)) ids.push_back(scenario.id);
    std::string names;
    for (const auto& id : nearest(id_or_file, ids, 3)) names += (names.empty() ? "" : ", ") + id;
    throw InputError(fmt::format(
        "no scenario `{}` in the catalogue and no file of that name; nearest: {}; `atwood list` shows the ids",
        id_or_file, names));
  }
  return read_scenario(id_or_file);
}

std::vector<Worker> start_workers(const Place& place, const std::vector<std::string>& extra) {
  std::vector<std::string> paths;
  for (const char* name :
       {"engine", "cvode", "bullet64", "bullet32", "ode", "arkode", "ida", "odeint", "fcl", "libccd"}) {
    paths.push_back(fmt::format("{}/atwood-{}", place.bin_dir, name));
  }
  for (const auto& engine : optional_engines) paths.push_back(fmt::format("{}/atwood-{}", place.bin_dir, engine.name));
  const std::size_t built_in = paths.size();
  for (const auto& path : extra) paths.push_back(path);
  std::vector<Worker> workers = find_workers(paths);
  for (std::size_t i = built_in; i < workers.size(); ++i) workers[i].foreign = true;
  for (auto& worker : workers) {
    if (worker.status == Status::not_built) explain_missing(worker);
  }
  return workers;
}

std::vector<Worker> require_workers(const Place& place, const Options& options) {
  for (const auto& path : options.engines) {
    if (!fs::exists(path)) throw InputError(fmt::format("--engine {}: no such file", path));
    if (!fs::is_regular_file(path)) throw InputError(fmt::format("--engine {}: not a file", path));
    if (access(path.c_str(), X_OK) != 0) throw InputError(fmt::format("--engine {}: not executable (chmod +x?)", path));
  }
  return start_workers(place, options.engines);
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

}  // namespace atwood
