#include "reports/command_line/one_run.hpp"

#include <cmath>

#include <fmt/format.h>

#include "reports/command_line/method_words.hpp"
#include "reports/command_line/verdicts.hpp"
#include "scene/files.hpp"
#include "scene/fluid_points.hpp"
#include "scene/printable.hpp"
#include "validation/study/worker_client.hpp"

namespace atwood {

const Worker& worker_of(const std::vector<Worker>& workers, const std::string& method) {
  MethodId id;
  try {
    id = parse_method_id(method);
  } catch (const std::invalid_argument& error) {
    throw InputError(fmt::format("--method {}: {}", method, without_id(error, method)));
  }
  if (method.find_first_of("*?") != std::string::npos)
    throw InputError(fmt::format("--method {}: found a glob; expected the id of one method, or truth", method));
  for (const Worker& worker : workers)
    for (const MethodInfo& info : worker.engine.methods)
      if (worker.status == Status::ok && info.id == id.engine + "/" + id.scheme) return worker;
  refuse_unknown_method("--method ", method, workers, {"truth"});
}

void refine(const Options& options, Scenario& scenario) {
  if (options.spacings.size() > 1 || options.sound_speeds.size() > 1)
    throw InputError("--spacing and --sound-speed: expected one of each");
  const Fluid first = scenario.scene.fluids.front();
  const double spacing = options.spacings.empty() ? 0 : options.spacings.front();
  const double speed = options.sound_speeds.empty() ? 0 : options.sound_speeds.front();
  for (const auto& [name, values] :
       {std::pair("--spacing", &options.spacings), {"--sound-speed", &options.sound_speeds}})
    for (const double given : *values)
      if (!(given > 0) || !std::isfinite(given))
        throw InputError(fmt::format("{} {}: expected a number above 0", name, given));
  if (spacing == 0 && speed == 0) return;
  scenario.scene = at_resolution(scenario, spacing, speed);
  const double refinement =
      (spacing > 0 ? first.spacing_m / spacing : 1) * (speed > 0 ? speed / first.sound_speed_m_per_s : 1);
  for (std::int64_t& steps : scenario.steps) {
    const double samples = static_cast<double>(scenario.samples);
    steps = static_cast<std::int64_t>(std::ceil(static_cast<double>(steps) * refinement / samples * (1 - 1e-12))) *
            scenario.samples;
  }
}

Recording recorded(const Worker& worker, const std::string& method, const Scenario& scenario, std::int64_t steps,
                   double limit_s) {
  const Scene& scene = scenario.scene;
  Recording run;
  run.outcome.status = Status::unsupported;
  if (!scene.fluids.empty() && !worker.engine.fluids) {
    run.outcome.reason = worker.engine.name + " simulates no fluids";
    return run;
  }
  if ((!scene.joints.empty() || !scene.ropes.empty()) && !worker.engine.joints) {
    run.outcome.reason = worker.engine.name + " simulates no joints";
    return run;
  }
  run = run_once(worker, method, scene, {scenario.t_end_s, steps, scenario.samples, scenario.frame_ends_s}, limit_s);
  if (std::string words = not_finite_words(run, scene); run.outcome.status == Status::ok && !words.empty())
    run.outcome = {Status::not_finite, std::move(words), 0, 0, {}};
  return run;
}

int status_exit(const Outcome& outcome) {
  if (outcome.status == Status::ok) return exit_pass;
  fmt::print(stderr, "atwood: {}: {}\n", to_string(outcome.status), printable(outcome.reason));
  return outcome.status == Status::crashed || outcome.status == Status::timeout ? exit_cell : exit_gate;
}

}  // namespace atwood
