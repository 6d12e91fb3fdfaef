// derivatives: how the accelerations of a scene's mechanisms change with their coordinates, rates and forces, at any
// time of a run, and the errors of differences with each step.
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "reports/command_line/command_line.hpp"
#include "reports/command_line/method_words.hpp"
#include "reports/command_line/one_run.hpp"
#include "reports/command_line/table.hpp"
#include "reports/command_line/units.hpp"
#include "scene/files.hpp"
#include "scene/printable.hpp"
#include "validation/study/process.hpp"
#include "validation/study/worker_client.hpp"

namespace atwood {
namespace {

constexpr int kMaxRates = 200;
constexpr int kStepExponents = 14;  // of the differences: 1e-1 to 1e-14
constexpr const char* kEntryColumns = "t_s,of,of_component,by,by_name,by_component,derivative,difference,error";
constexpr const char* kLadderColumns = "t_s,by,from,step,error";

// Only what the articulated-body algorithm itself computes is differentiated: everything else is refused by name.
void require_tree(const Scenario& scenario) {
  const Scene& scene = scenario.scene;
  const auto refuse = [&](const std::string& what) {
    throw InputError(
        fmt::format("derivatives: `{}`: {}; expected a tree of joints under uniform gravity and forces "
                    "along joints, as double-pendulum-regular",
                    scenario.id, what));
  };
  if (scene.joints.empty()) refuse("the scene has no joint");
  int rates = 0;
  std::vector<char> placed(scene.bodies.size(), 0);
  for (const Joint& joint : scene.joints) {
    if (joint.closes_loop)
      refuse(
          fmt::format("the joint `{}` closes a loop, and the multipliers of loops are not differentiated", joint.name));
    if (joint.limits) refuse(fmt::format("the joint `{}` has limits, and stops are not differentiated", joint.name));
    placed[static_cast<std::size_t>(joint.child)] = 1;
    if (!joint.driven_rate) rates += rate_count(joint.kind);
  }
  if (!scene.ropes.empty())
    refuse(fmt::format("the rope `{}` ties bodies, and the multipliers of ropes are not differentiated",
                       scene.ropes.front().name));
  if (!scene.forces.empty()) refuse("a [[force]] acts on bodies, and those forces are not differentiated");
  if (!scene.fluids.empty()) refuse("the scene has a fluid");
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const Body& body = scene.bodies[i];
    if (body.release_s > 0) refuse(fmt::format("the body `{}` is held until its release_s", body.name));
    if (!body.fixed && !placed[i]) rates += rotates(body) ? 6 : 3;
  }
  if (rates == 0) refuse("no joint of it moves by itself");
  if (rates > kMaxRates) refuse(fmt::format("the mechanisms have {} rates, more than {}", rates, kMaxRates));
}

// ---- the state at the time that is asked for ------------------------------------------------------------------------
template <std::size_t n> std::array<double, n> narrowed(const std::array<Wide, n>& wide) {
  std::array<double, n> narrow{};
  for (std::size_t i = 0; i < n; ++i) narrow[i] = static_cast<double>(wide[i]);
  return narrow;
}

void start_at(const SampleView& sample, Scene& scene) {
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const BodySample& at = checked(sample.bodies, i);
    if (scene.bodies[i].fixed) continue;
    scene.bodies[i].position_m = narrowed(at.p_m);
    scene.bodies[i].orientation_wxyz = narrowed(at.q_wxyz);
    scene.bodies[i].velocity_m_per_s = narrowed(at.v_m_per_s);
    scene.bodies[i].angular_velocity_body_rad_per_s = narrowed(at.w_rad_per_s);
  }
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    scene.joints[j].coordinates = narrowed(checked(sample.joints, j).q);
    scene.joints[j].rates = narrowed(checked(sample.joints, j).u);
  }
}

// The scenario's steps, as far as `t_s`: the step's length is that of the whole run, or a little less.
std::int64_t steps_up_to(double t_s, const Scenario& scenario, std::int64_t steps) {
  return std::max<std::int64_t>(
      1, static_cast<std::int64_t>(std::ceil(static_cast<double>(steps) * t_s / scenario.t_end_s * (1 - 1e-12))));
}

// Moves the scene's start to the state at `t_s`; an exit code where the run does not get there.
int move_start(const Place& place, const Options& options, std::int64_t steps, Scenario& scenario) {
  const std::string method = options.methods.empty() ? "atwood/dop853" : options.methods.front();
  Scenario until = scenario;
  if (method != "truth" && !scenario.frame_ends_s.empty())
    throw InputError(
        fmt::format("derivatives: the steps of `{}` are recorded frames, and methods are sampled only at its end; "
                    "expected --method truth",
                    scenario.id));
  until.frame_ends_s.clear();  // a truth does not depend on the steps
  until.t_end_s = options.at_s;
  until.samples = 1;
  SampleSeries values;
  Outcome outcome;
  if (method == "truth") {
    Truth truth = truth_once(place.truth_worker, until, 1, options.limit_given ? options.cell_limit_s : 120.0);
    outcome = truth.outcome;
    values = std::move(truth.values);
  } else {
    const auto workers = require_workers(place, options, nullptr, {method});
    require_answers(workers);
    const Worker& worker = worker_of(workers, method);
    check_settings("--method ", method, workers);
    Recording run = recorded(worker, method, until, steps_up_to(options.at_s, scenario, steps), options.cell_limit_s);
    outcome = run.outcome;
    values = std::move(run.values);
  }
  if (outcome.status != Status::ok) {
    const int code = status_exit(outcome);
    return code == exit_pass ? static_cast<int>(exit_gate) : code;
  }
  if (values.empty() || values.back().joints.size() != scenario.scene.joints.size())
    throw InputError(
        fmt::format("--method {}: the method reports no joints; expected one that does, as atwood/dop853", method));
  start_at(values.back(), scenario.scene);
  return exit_pass;
}

// ---- the programs beside this one -----------------------------------------------------------------------------------
struct Said {
  std::vector<std::vector<std::string>> lines;  // fields
  std::string refusal;                          // empty: none
};

// Asks a program that reads the scene and prints CSV. It is confined as workers are.
Said ask(const std::vector<std::string>& command, const Scene& scene, const Options& options) {
  constexpr std::size_t longest = 1000;
  const double limit_s = options.cell_limit_s;
  Process process(command, false, {.memory_bytes = memory_limit_of(options)});
  process.send(scene_to_json(scene));
  const auto deadline =
      Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(limit_s));
  Said said;
  std::string line;
  for (;;) {
    const Wait wait = process.next_line(line, deadline, longest);
    if (wait == Wait::end_of_output) break;
    if (wait == Wait::interrupted) return said;
    if (wait == Wait::timeout)
      throw WorkerFailure(fmt::format("{} did not end within {} s (--limit)", command.front(), limit_s));
    if (wait == Wait::too_long) throw WorkerFailure(command.front() + " sent an invalid answer");
    std::vector<std::string> fields(1);
    for (const char c : line)
      if (c == ',') fields.emplace_back();
      else fields.back() += c;
    said.lines.push_back(std::move(fields));
  }
  if (process.succeeded()) return said;
  if (const std::string ending = process.ending(); ending != "exited with code 2")
    throw WorkerFailure(fmt::format("{} failed ({})", command.front(), ending));
  said.refusal = printable(process.error_text());
  if (said.refusal.empty()) throw WorkerFailure(command.front() + " failed without a word");
  return said;
}

// ---- what is printed ------------------------------------------------------------------------------------------------
void print_entries(const Said& said, const Scene& scene, double t_s, bool json) {
  struct Name {
    std::string text, component;
  };
  std::vector<Name> names;
  Table table(kEntryColumns, json);
  for (const auto& field : said.lines) {
    if (field.front() == "unknown") {
      const auto index = static_cast<std::size_t>(std::stoul(field.at(3)));
      names.push_back(
          {field.at(2) == "joint" ? scene.joints.at(index).name : scene.bodies.at(index).name, field.at(4)});
    }
    if (field.front() != "derivative") continue;
    const Name &of = names.at(std::stoul(field.at(2))), &by = names.at(std::stoul(field.at(3)));
    const Wide error = parse_wide(field.at(4)) - parse_wide(field.at(5));
    table.row(fmt::format("{},{},{},{},{},{},{},{},{}", format_double(t_s), quoted(of.text), of.component, field.at(1),
                          quoted(by.text), by.component, field.at(4), field.at(5),
                          format_double(std::fabs(static_cast<double>(error)))));
  }
}

// Of each of MuJoCo's matrices the largest error over the largest entry.
void print_mujoco(const Said& mujoco, const Said& exact_lines, double t_s, Table& table) {
  std::map<std::pair<std::string, std::string>, double> exact;
  double largest = 0;
  for (const auto& field : exact_lines.lines)
    if (field.front() == "transition") {
      const auto value = static_cast<double>(parse_wide(field.at(3)));
      exact[{field.at(1), field.at(2)}] = value;
      largest = std::max(largest, std::fabs(value));
    }
  double worst = 0;
  for (std::size_t i = 0; i < mujoco.lines.size(); ++i) {
    const auto& field = mujoco.lines[i];
    const double off = std::fabs(static_cast<double>(parse_wide(field.at(4))) - exact.at({field.at(2), field.at(3)}));
    if (!(off <= worst) && !std::isnan(worst)) worst = off;
    const bool last = i + 1 == mujoco.lines.size() || mujoco.lines[i + 1].at(0) != field.at(0) ||
                      mujoco.lines[i + 1].at(1) != field.at(1);
    if (!last) continue;
    table.row(fmt::format("{},transition,mujoco {},{},{}", format_double(t_s), field.at(0), field.at(1),
                          format_double(worst / largest)));
    worst = 0;
  }
}

int print_ladder(const Place& place, const Options& options, const Said& said, const Scene& scene, double h_s) {
  Table table(kLadderColumns, options.json);
  for (const auto& field : said.lines)
    if (field.front() == "ladder")
      table.row(fmt::format("{},{},{},{},{}", format_double(options.at_s), field.at(1), field.at(2), field.at(3),
                            field.at(4)));
  const std::string program = place.worker_dir + "/atwood-mujoco-derivatives";
  if (access(program.c_str(), X_OK) != 0) {
    fmt::print(stderr, "atwood: mujoco: not built\n");
    return exit_pass;
  }
  std::vector<std::string> command{program, format_double(h_s)};
  for (int power = 1; power <= kStepExponents; ++power) command.push_back(format_double(std::pow(10.0, -power)));
  const Said mujoco = ask(command, scene, options);
  if (interrupt_signal() != 0) return 128 + interrupt_signal();
  if (!mujoco.refusal.empty()) fmt::print(stderr, "atwood: mujoco: unsupported: {}\n", mujoco.refusal);
  else print_mujoco(mujoco, said, options.at_s, table);
  return exit_pass;
}

}  // namespace

int command_derivatives(const Place& place, const Options& options) {
  Scenario scenario = read_scene_argument(place, options.input);
  note_shared_id(place, scenario);
  set_frequency(scenario, options.hz);
  require_tree(scenario);
  if (!(options.at_s >= 0) || !(options.at_s <= scenario.t_end_s))
    throw InputError(
        fmt::format("--at {}: expected a time of the run, 0 to {} s", options.at_s, format_double(scenario.t_end_s)));
  if (options.at_s == 0 && !options.methods.empty())
    throw InputError(
        "--method: at --at 0 the state is the scene's own; expected a later time, up to which the method runs");
  if (options.steps.size() > 1) throw InputError("--steps: expected one count");
  if (options.hz.size() > 1) throw InputError("--hz: expected one count");
  const std::int64_t steps = options.steps.empty() ? scenario.steps.back() : options.steps.front();
  if (steps <= 0) throw InputError(fmt::format("--steps {}: expected a positive count", steps));
  const std::string program = place.worker_dir + "/atwood-derivatives";
  if (access(program.c_str(), X_OK) != 0)
    throw std::runtime_error(program + " is not there: the installation is incomplete");
  if (options.at_s > 0)
    if (const int code = move_start(place, options, steps, scenario); code != exit_pass) return code;

  const InterruptGuard guard;
  const double h_s = scenario.t_end_s / static_cast<double>(steps);
  std::vector<std::string> command{program, format_double(options.at_s)};
  if (options.ladder) command.push_back(format_double(h_s));
  const Said said = ask(command, scenario.scene, options);
  if (interrupt_signal() != 0) return 128 + interrupt_signal();
  if (!said.refusal.empty()) throw InputError(fmt::format("derivatives: `{}`: {}", scenario.id, said.refusal));
  const auto& bodies = scenario.scene.bodies;
  if (std::count_if(bodies.begin(), bodies.end(),
                    [](const Body& body) { return !std::holds_alternative<std::monostate>(body.shape); }) > 1)
    fmt::print(stderr, "atwood: contacts are not differentiated\n");
  if (options.ladder) return print_ladder(place, options, said, scenario.scene, h_s);
  print_entries(said, scenario.scene, options.at_s, options.json);
  return exit_pass;
}

}  // namespace atwood
