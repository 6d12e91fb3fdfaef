#include "reports/command_line/play.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "reports/command_line/one_run.hpp"
#include "reports/command_line/units.hpp"
#include "reports/render/playback.hpp"
#include "scene/files.hpp"
#include "validation/metrics/fluid.hpp"
#include "validation/metrics/measurements.hpp"
#include "validation/study/check_fluids.hpp"
#include "validation/study/write_file.hpp"

namespace atwood {
namespace {

// Enough for motion that flows; fewer for many bodies, whose poses would fill the page.
std::int64_t most_samples(const Scene& scene, std::size_t runs) {
  const double bodies = static_cast<double>(std::max<std::size_t>(scene.bodies.size(), 1));
  return std::clamp<std::int64_t>(std::llround(900'000 / (7 * bodies * static_cast<double>(runs))), 32, 600);
}

// The largest count up to `most` that divides all of these.
std::int64_t common_samples(const std::vector<std::int64_t>& steps, std::int64_t most) {
  std::int64_t all = 0;
  for (const std::int64_t n : steps) all = std::gcd(all, n);
  for (std::int64_t k = std::min(all, most); k > 1; --k)
    if (all % k == 0) return k;
  return 1;
}

std::int64_t samples_of(const Options& options, const Scenario& scenario, const std::vector<std::int64_t>& steps,
                        std::size_t runs) {
  if (!options.samples) {
    const std::int64_t most = most_samples(scenario.scene, runs);
    if (steps.empty()) return most;
    const std::int64_t count = common_samples(steps, most);
    if (count == 1 && *std::min_element(steps.begin(), steps.end()) > 1)
      fmt::print(
          stderr,
          "atwood: play: warning: no number from 2 to {} divides the --steps of all runs, so that only the start and "
          "the end are drawn; choose --steps with small factors\n",
          most);
    return count;
  }
  if (*options.samples <= 0) throw InputError(fmt::format("--samples {}: expected a positive count", *options.samples));
  for (const std::int64_t n : steps)
    if (n % *options.samples != 0)
      throw InputError(fmt::format("--steps {}: expected a multiple of the {} samples", n, *options.samples));
  return *options.samples;
}

// Errors up to where the run or the truth ends.
void compare_with(const Truth& truth, PlayedRun& run) {
  for (std::size_t k = 0; k < std::min(truth.values.size(), run.values.size()); ++k) {
    double position = 0, attitude = 0;
    for (std::size_t i = 0; i < std::min(run.values[k].bodies.size(), truth.values[k].bodies.size()); ++i) {
      position = std::max(position, position_error_m(run.values[k].bodies[i], truth.values[k].bodies[i]));
      attitude = std::max(attitude, attitude_error_rad(run.values[k].bodies[i], truth.values[k].bodies[i]));
    }
    run.position_error_m.push_back(position);
    run.attitude_error_rad.push_back(attitude);
  }
}

// The largest bars of all bodies: of an attitude, twice the norm of those of the quaternion's components.
void add_bars(const Truth& truth, PlayedRun& run) {
  const auto norm = [](const auto& values) {
    double sum = 0;
    for (const Wide x : values) sum = std::hypot(sum, static_cast<double>(x));
    return sum;
  };
  for (const SampleView sample : truth.bars) {
    double position = 0, attitude = 0;
    for (const BodySample& body : sample.bodies) {
      position = std::max(position, norm(body.p_m));
      attitude = std::max(attitude, 2 * norm(body.q_wxyz));
    }
    run.position_bar_m.push_back(position);
    run.attitude_bar_rad.push_back(attitude);
  }
}

std::string output_path(const Options& options, const Scenario& scenario) {
  if (options.outputs.size() > 1) throw InputError("-o: expected one file");
  if (options.outputs.empty()) return options.out_dir + "/play-" + scenario.id + ".html";
  const std::string& output = options.outputs.front();
  if (!output.starts_with("html:") || output.size() == 5)
    throw InputError(fmt::format("-o {}: expected html:FILE", output));
  require_output(output.substr(5));
  return output.substr(5);
}

PlayedRun played_truth(const Truth& truth) {
  PlayedRun run;
  run.name = "truth", run.source = truth.source;
  run.values = truth.values, run.events = truth.events, run.outcome = truth.outcome;
  add_bars(truth, run);
  return run;
}

void say(const Playback& playback, const PlaybackPage& page, const std::string& path, bool json) {
  if (!json) {
    fmt::print("{}: {:.0f} kB, {} frames, {} run{}\n", path, static_cast<double>(page.html.size()) / 1000, page.frames,
               playback.runs.size(), playback.runs.size() == 1 ? "" : "s");
    return;
  }
  nlohmann::ordered_json told{{"file", path}, {"bytes", page.html.size()}, {"frames", page.frames}};
  for (const PlayedRun& run : playback.runs)
    told["runs"].push_back({{"name", run.name},
                            {"steps", run.steps},
                            {"samples", run.values.size()},
                            {"status", to_string(run.outcome.status)},
                            {"reason", run.outcome.reason}});
  fmt::print("{}\n", told.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
}

// The change of energy where the scene conserves it; elsewhere the difference from the truth's, or the change of what
// is mechanical energy, or of what is a fluid's kinetic energy. A bare system has none.
void add_energies(Playback& playback, const Scenario& scenario, const Truth& truth) {
  const bool fluid = !scenario.scene.fluids.empty();
  if (!scenario.scene.problem.empty()) return;
  const metrics::EnergyScale scale = fluid ? metrics::EnergyScale{} : metrics::energy_scale(scenario, truth);
  if (!(scale.joules > 0)) playback.energy_unit = "J";
  playback.energy_title = "change of energy";
  for (PlayedRun& run : playback.runs)
    if (!fluid) run.energy = metrics::energy_change(scenario, {run.values, run.events, run.outcome}, scale);
  if (!playback.runs.front().energy.empty()) return;
  playback.energy_unit = "J";
  std::vector<std::vector<Wide>> energies;
  for (const PlayedRun& run : playback.runs)
    energies.push_back(fluid ? fluid_kinetic_energy(scenario.scene, run.values)
                             : metrics::mechanical_energy(scenario.scene, {run.values, run.events, run.outcome}));
  const bool compared = playback.truth && !fluid;
  playback.energy_title = fluid      ? "change of kinetic energy"
                          : compared ? "mechanical energy, difference from the truth's"
                                     : "change of mechanical energy";
  for (std::size_t r = compared ? 1 : 0; r < playback.runs.size(); ++r) {
    const std::size_t count = compared ? std::min(energies[0].size(), energies[r].size()) : energies[r].size();
    for (std::size_t k = 0; k < count; ++k)
      playback.runs[r].energy.push_back(
          static_cast<double>(energies[r][k] - (compared ? energies[0][k] : energies[r][0])));
  }
}

}  // namespace

int command_play(const Place& place, const Options& options) {
  Scenario scenario = read_scene_argument(place, options.input);
  note_shared_id(place, scenario);
  const bool fluid = !scenario.scene.fluids.empty();
  if (fluid) refine(options, scenario);
  else if (!options.spacings.empty() || !options.sound_speeds.empty())
    throw InputError(fmt::format("--spacing, --sound-speed: `{}` has no fluid", scenario.id));
  set_frequency(scenario, options.hz);
  std::vector<std::string> methods;
  for (const std::string& method : options.methods)
    if (method != "truth" && std::find(methods.begin(), methods.end(), method) == methods.end())
      methods.push_back(method);
  const bool has_truth = scenario.truth.kind != TruthKind::none && !fluid;
  if (methods.empty() && !has_truth)
    throw InputError(fmt::format("play: `{}` has no truth whose particles or bodies could be drawn; expected --method",
                                 scenario.id));
  if (!methods.empty() && !scenario.frame_ends_s.empty())
    throw InputError(
        fmt::format("play: the steps of `{}` are recorded frames, and methods are sampled only at its end; "
                    "expected no --method",
                    scenario.id));
  scenario.frame_ends_s.clear();  // a truth does not depend on the steps
  const std::string path = output_path(options, scenario);
  const std::int64_t steps = options.steps.empty() ? scenario.steps.back() : options.steps.front();
  if (options.steps.size() > 1) throw InputError("--steps: expected one count");
  if (steps <= 0) throw InputError(fmt::format("--steps {}: expected a positive count", steps));
  scenario.samples = samples_of(options, scenario, methods.empty() ? std::vector<std::int64_t>{} : std::vector{steps},
                                methods.size() + 1);
  scenario.steps = {methods.empty() ? scenario.samples : steps};  // the only ones that run
  const std::vector<Worker> workers =
      methods.empty() ? std::vector<Worker>{} : require_workers(place, options, nullptr, methods);
  require_answers(workers);
  for (const std::string& method : methods) {
    const Worker& worker = worker_of(workers, method);
    check_settings("--method ", method, workers);
    check_fluids("--method ", method, worker, scenario);
  }

  Playback playback;
  playback.samples = scenario.samples, playback.command = options.program;
  Truth truth;
  int code = exit_pass;
  if (has_truth) {
    truth =
        truth_once(place.truth_worker, scenario, scenario.samples, options.limit_given ? options.cell_limit_s : 120.0);
    if (truth.outcome.status != Status::ok) code = status_exit(truth.outcome);
    if (truth.values.size() > 1) {
      playback.runs.push_back(played_truth(truth));
      playback.truth = true;
    } else {
      truth = {};
    }
  }
  for (const std::string& method : methods) {
    Recording recording = recorded(worker_of(workers, method), method, scenario, steps, options.cell_limit_s);
    PlayedRun run;
    run.name = method, run.steps = steps;
    if (recording.outcome.status != Status::ok) {
      Outcome named = recording.outcome;
      named.reason = method + ": " + named.reason;
      code = std::max(code, status_exit(named));
    }
    run.values = std::move(recording.values), run.events = std::move(recording.events);
    run.outcome = std::move(recording.outcome);
    if (playback.truth) compare_with(truth, run);
    playback.runs.push_back(std::move(run));
  }
  std::stable_partition(playback.runs.begin(), playback.runs.end(),
                        [](const PlayedRun& run) { return run.values.size() > 1; });
  if (playback.runs.empty() || playback.runs.front().values.size() < 2) {
    fmt::print(stderr, "atwood: play: no run has two samples, so nothing was written\n");
    return code == exit_pass ? static_cast<int>(exit_gate) : code;
  }
  add_energies(playback, scenario, truth);
  playback.scenario = std::move(scenario);
  const PlaybackPage page = render_playback(playback);
  if (options.outputs.empty()) make_out_dir(options.out_dir);
  write_file(path, page.html);
  say(playback, page, path, options.json);
  if (page.particles_drawn < page.particles)
    fmt::print(stderr, "atwood: {} of the {} particles are drawn\n", page.particles_drawn, page.particles);
  return code;
}

}  // namespace atwood
