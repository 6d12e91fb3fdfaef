// contacts: where a scene's bodies touch in the initial pose, or when they first would, as CSV.
#include <unistd.h>

#include <algorithm>
#include <filesystem>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "reports/command_line/command_line.hpp"
#include "reports/command_line/table.hpp"
#include "scene/files.hpp"
#include "scene/printable.hpp"

namespace atwood {
namespace fs = std::filesystem;

namespace {

constexpr const char* kContactColumns = "body_a,body_b,x_m,y_m,z_m,nx,ny,nz,depth_m";
constexpr const char* kTouchColumns = "body_a,body_b,toi_s,x_m,y_m,z_m,nx,ny,nz";

// Engines with questions about contacts, and the end of their worker's name.
struct Known {
  const char* name;
  const char* worker;
};
constexpr Known kKnownEngines[] = {{"atwood", "engine"},     {"truth", "truth"}, {"bullet64", "bullet64"},
                                   {"bullet32", "bullet32"}, {"ode", "ode"},     {"fcl", "fcl"},
                                   {"libccd", "libccd"},     {"jolt", "jolt"},   {"mujoco3", "mujoco3"},
                                   {"rapier", "rapier"}};

// "bullet64/unit-size", "atwood/box-edges": another test of contacts that an engine's worker offers, as sweeps name it.
// "box-edges" alone is ours, too.
struct Asked {
  std::string engine, test;
};
Asked asked_of(const std::string& words) {
  if (words == "box-edges") return {"atwood", "box-edges"};
  const std::size_t slash = words.find('/');
  const std::string engine = words.substr(0, slash);
  const bool known =
      std::any_of(std::begin(kKnownEngines), std::end(kKnownEngines), [&](const Known& k) { return engine == k.name; });
  if (slash == std::string::npos || !known) return {words, ""};
  return {engine, words.substr(slash + 1)};
}

std::string worker_path(const Place& place, const std::string& engine) {
  std::vector<std::string> names;
  for (const Known& known : kKnownEngines) {
    if (engine == known.name) return fmt::format("{}/atwood-{}", place.worker_dir, known.worker);
    names.emplace_back(known.name);
  }
  for (const char* other : {"cvode", "arkode", "ida", "odeint", "dart", "mujoco", "pysph", "simbody"}) {
    if (engine == other)
      throw InputError(fmt::format("--engine {}: {} answers no questions about contacts; expected one of {}, box-edges",
                                   engine, engine, fmt::join(names, ", ")));
  }
  if (!fs::exists(engine))
    throw InputError(
        fmt::format("--engine {}: no such engine or file; expected a worker's path or one of {}, box-edges", engine,
                    fmt::join(names, ", ")));
  if (!fs::is_regular_file(engine)) throw InputError(fmt::format("--engine {}: not a file", engine));
  if (access(engine.c_str(), X_OK) != 0)
    throw InputError(fmt::format("--engine {}: it is not executable; `chmod +x` makes it so", engine));
  return fs::absolute(engine).string();
}

template <class Values> std::string joined(const Values& values, int digits) {
  std::string text;
  for (const Wide value : values) text += "," + format_number(value, digits);
  return text;
}

int exit_of(const Outcome& outcome) {
  if (outcome.status == Status::ok) return exit_pass;
  fmt::print(stderr, "atwood: {}: {}\n", to_string(outcome.status), printable(outcome.reason));
  return outcome.status == Status::unsupported || outcome.status == Status::not_built ? exit_pass : exit_cell;
}

}  // namespace

int command_contacts(const Place& place, const Options& options) {
  const Scenario scenario = read_scene_argument(place, options.input);
  note_shared_id(place, scenario);
  if (!scenario.scene.problem.empty())
    throw InputError(
        fmt::format("{}: the bare system `{}` has no bodies that could touch", options.input, scenario.scene.problem));
  const Asked asked = asked_of(options.engines.empty() ? "atwood" : options.engines.front());
  const Worker worker = find_workers({worker_path(place, asked.engine)}).front();
  if (worker.status != Status::ok) return exit_of({worker.status, worker.reason, 0, 0, {}});
  const ContactAnswer answer =
      contacts_once(worker, scenario.scene, {options.swept, scenario.t_end_s}, options.cell_limit_s, asked.test);
  if (answer.outcome.status != Status::ok) return exit_of(answer.outcome);

  const int digits = worker.engine.name == "truth" ? 21 : 17;
  const auto pair = [&](int a, int b) {
    const auto name = [&](int i) { return quoted(scenario.scene.bodies.at(static_cast<std::size_t>(i)).name); };
    return name(a) + "," + name(b);
  };
  Table table(options.swept ? kTouchColumns : kContactColumns, options.json);
  for (const FoundContact& c : answer.contacts)
    table.row(pair(c.body_a, c.body_b) + joined(c.x_m, digits) + joined(c.normal, digits) + "," +
              format_number(c.depth_m, digits));
  for (const FoundTouch& t : answer.touches)
    table.row(pair(t.body_a, t.body_b) + "," + format_number(t.toi_s, digits) + joined(t.x_m, digits) +
              joined(t.normal, digits));
  const auto& bodies = scenario.scene.bodies;
  if (std::count_if(bodies.begin(), bodies.end(),
                    [](const Body& body) { return !std::holds_alternative<std::monostate>(body.shape); }) < 2)
    fmt::print(stderr, "atwood: {}: fewer than two bodies of this scene have a shape\n", options.input);
  for (const auto& [solver, tally] : answer.outcome.solvers) {
    if (tally.capped == 0) continue;
    fmt::print(stderr, "atwood: {}: {} of {} solves ended above their tolerance, with a residual of up to {}\n", solver,
               tally.capped, tally.solves(), format_double(tally.residual_max));
  }
  return exit_pass;
}

}  // namespace atwood
