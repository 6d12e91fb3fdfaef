// trace: one run's motion or contacts as CSV, in the precision it was computed in.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "reports/command_line/command_line.hpp"
#include "reports/command_line/method_words.hpp"
#include "reports/command_line/one_run.hpp"
#include "reports/command_line/table.hpp"
#include "reports/command_line/trace_fluid.hpp"
#include "reports/command_line/trace_joints.hpp"
#include "reports/command_line/units.hpp"
#include "reports/command_line/verdicts.hpp"
#include "scene/files.hpp"
#include "scene/fluid_points.hpp"
#include "scene/printable.hpp"
#include "scene/scenario_keys.hpp"
#include "validation/study/check_fluids.hpp"
#include "validation/study/worker_client.hpp"

namespace atwood {

namespace {

constexpr const char* kMotionColumns =
    "t_s,body,px_m,py_m,pz_m,qw,qx,qy,qz,vx_m_per_s,vy_m_per_s,vz_m_per_s,wx_rad_per_s,wy_rad_per_s,wz_rad_per_s";
constexpr const char* kBarColumns =
    ",px_m_bar,py_m_bar,pz_m_bar,qw_bar,qx_bar,qy_bar,qz_bar,vx_m_per_s_bar,vy_m_per_s_bar,vz_m_per_s_bar,wx_rad_per_s_"
    "bar,"
    "wy_rad_per_s_bar,wz_rad_per_s_bar,source";
constexpr const char* kEventColumns =
    "t_s,kind,body_a,body_b,x_m,y_m,z_m,nx,ny,nz,impulse_n_N_s,impulse_t_N_s,vn_before_m_per_s,vn_after_m_per_s";

template <std::size_t n> void append(std::string& line, const std::array<Wide, n>& values, int digits) {
  for (const auto& value : values) line += "," + format_number(value, digits);
}

void append_body(std::string& line, const BodySample& body, int digits) {
  append(line, body.p_m, digits);
  append(line, body.q_wxyz, digits);
  append(line, body.v_m_per_s, digits);
  append(line, body.w_rad_per_s, digits);
}

std::string body_name(const Scene& scene, std::size_t i) {
  return i < scene.bodies.size() ? quoted(scene.bodies[i].name) : quoted(scene.problem);
}

// -1, the world, at the stop of a joint.
std::string event_body(const Scene& scene, int body) {
  return body < 0 ? "world" : body_name(scene, static_cast<std::size_t>(body));
}

void print_motion(const Scene& scene, const SampleSeries& values, const Truth* truth, int digits, bool json) {
  Table table(fmt::format("{}{}", kMotionColumns, truth ? kBarColumns : ""), json);
  for (std::size_t k = 0; k < values.size(); ++k) {
    for (std::size_t i = 0; i < values[k].bodies.size(); ++i) {
      std::string line = format_number(values[k].t_s, digits) + "," + body_name(scene, i);
      append_body(line, values[k].bodies[i], digits);
      if (truth) {
        append_body(line, truth->bars[k].bodies[i], 17);
        line += "," + quoted(truth->source);
      }
      table.row(line);
    }
  }
}

void print_events(const Scene& scene, const std::vector<Event>& events, const Truth* truth, int digits, bool json) {
  Table table(fmt::format("{}{}", kEventColumns, truth ? ",t_s_bar" : ""), json);
  for (std::size_t k = 0; k < events.size(); ++k) {
    const Event& e = events[k];
    std::string line = fmt::format("{},{},{},{}", format_number(e.t_s, digits), to_string(e.kind),
                                   event_body(scene, e.body_a), event_body(scene, e.body_b));
    append(line, e.x_m, digits);
    append(line, e.normal, digits);
    append(line, std::array<Wide, 4>{e.impulse_n_N_s, e.impulse_t_N_s, e.vn_before_m_per_s, e.vn_after_m_per_s},
           digits);
    if (truth) line += "," + format_double(k < truth->event_bar_s.size() ? truth->event_bar_s[k] : 0);
    table.row(line);
  }
}

int digits_of(const std::string& scalar) {
  if (scalar == "quad") return 36;
  if (scalar == "long-double") return 21;
  return 17;
}

// With recorded frames: an engine that takes them, whole frames, and the start and the end alone.
void require_frames(const Scenario& scenario, const Worker& worker, std::int64_t steps, std::int64_t samples) {
  const auto frames = static_cast<std::int64_t>(scenario.frame_ends_s.size());
  if (frames == 0) return;
  if (!worker.engine.frames)
    throw InputError(fmt::format("{} takes equal steps; it cannot follow recorded frames", worker.engine.name));
  if (samples != 1)
    throw InputError(fmt::format("--samples {}: expected 1 with recorded frames: the start and the end", samples));
  if (steps % frames != 0)
    throw InputError(fmt::format("--steps {}: expected a multiple of the {} recorded frames", steps, frames));
}

// What the options ask for: events, joints, ropes, or the motion of the bodies.
void print_values(const Options& options, const Scene& scene, const SampleSeries& values,
                  const std::vector<Event>& events, const Truth* truth, int digits) {
  if (options.events) return print_events(scene, events, truth, digits, options.json);
  if (options.joints) print_joints(scene, values, truth, digits, options.json);
  else if (options.ropes) print_ropes(scene, values, truth, digits, options.json);
  else return print_motion(scene, values, truth, digits, options.json);
  const bool reported =
      !values.empty() && !(options.joints ? values.back().joints.empty() : values.back().ropes.empty());
  if (!reported) fmt::print(stderr, "atwood: the method reports no {}\n", options.joints ? "joints" : "ropes");
}

// The scenario at the spacing and the sound speed of the options; its steps grow as those of a run do.
void take_resolution(const Options& options, Scenario& scenario) {
  const bool asked = options.particles || options.probes || !options.outputs.empty() || !options.spacings.empty() ||
                     !options.sound_speeds.empty();
  if (!asked) return;
  if (scenario.scene.fluids.empty()) {
    const std::string given = options.particles               ? "--particles"
                              : options.probes                ? "--probes"
                              : !options.spacings.empty()     ? "--spacing"
                              : !options.sound_speeds.empty() ? "--sound-speed"
                                                              : "-o " + options.outputs.front();
    throw InputError(
        fmt::format("{}: `{}` has no fluid; expected a scene with fluids, as taylor-green", given, scenario.id));
  }
  if (options.events && (options.particles || options.probes))
    throw InputError("--events prints contacts; expected it without --particles and --probes");
  for (const std::string& output : options.outputs)
    if (!output.starts_with("vtk:") || output.size() == 4)
      throw InputError(fmt::format("-o {}: expected vtk:DIR, with the name of a folder", output));
  if (options.probes && scenario.scene.probes.empty())
    throw InputError(fmt::format("--probes: `{}` has no [[probe]]", scenario.id));
  refine(options, scenario);
}

// Particles or probes, and files for ParaView. False: the bodies are asked for.
bool print_fluid(const Options& options, const Scenario& scenario, const SampleSeries& values, int digits) {
  for (const std::string& output : options.outputs) write_vtk(output.substr(4), scenario.id, scenario.scene, values);
  if (options.particles) print_particles(scenario.scene, values, nullptr, "", digits, options.json);
  if (options.probes) print_probes(scenario.scene, values, options.json);
  return options.particles || options.probes || !options.outputs.empty();
}

// The exact field of a fluid at the places where its particles start, at every sample.
int trace_field(const Place& place, const Options& options, const Scenario& scenario) {
  if (!options.particles)
    throw InputError("the truth of a fluid is a field; expected --particles: its values where the particles start");
  std::vector<FieldPosition> start;
  for (const Fluid& fluid : scenario.scene.fluids)
    for (const Real3& x : fluid.particles.position_m) start.push_back({Wide(x[0]), Wide(x[1]), Wide(x[2])});
  std::vector<Wide> t_s;
  for (std::int64_t k = 0; k <= scenario.samples; ++k)
    t_s.push_back(Wide(scenario.t_end_s) * Wide(k) / Wide(scenario.samples));
  const FieldAtParticles field = field_once(place.truth_worker, scenario, t_s, {t_s.size(), start},
                                            options.limit_given ? options.cell_limit_s : 120.0);
  if (field.outcome.status != Status::ok) {
    const int code = status_exit(field.outcome);
    return code == exit_pass ? static_cast<int>(exit_gate) : code;
  }
  if (const FieldKnown& known = field.known; !known.velocity && !known.density && !known.pressure && !known.temperature)
    throw InputError(
        fmt::format("trace: the truth of `{}` gives figures of probes and no field; expected a scene whose "
                    "truth is a field",
                    scenario.id));
  SampleSeries values, bars;
  for (const FieldSample& at : field.samples) {
    values.push_back(Sample{at.t_s, {}, {}, at.values});
    bars.push_back(Sample{at.t_s, {}, {}, at.bars});
    for (std::size_t i = 0; i < start.size(); ++i) values.back().particles[i].p_m = start[i];
  }
  print_particles(scenario.scene, values, &bars, field.source, 36, options.json);
  const FieldKnown& known = field.known;
  fmt::print(stderr, "atwood: the field at the places where the particles start; known:{}{}{}{}{}\n",
             known.velocity ? " velocity" : "", known.density ? " density" : "", known.pressure ? " pressure" : "",
             known.temperature ? " temperature" : "", field.note.empty() ? "" : "; " + printable(field.note));
  return exit_pass;
}

}  // namespace

int command_trace(const Place& place, const Options& options) {
  Scenario scenario = read_scene_argument(place, options.input);
  note_shared_id(place, scenario);
  const std::string& method = options.methods.front();
  const std::int64_t samples = options.samples.value_or(scenario.samples);
  if (samples <= 0) throw InputError(fmt::format("--samples {}: expected a positive count", samples));
  if (samples > kMaxSamples) throw InputError(fmt::format("--samples {}: expected at most {}", samples, kMaxSamples));
  scenario.samples = samples;
  take_resolution(options, scenario);
  set_frequency(scenario, options.hz);
  if (method == "truth") {  // a motion, or a field, without steps: any number of samples divides it
    scenario.steps = {samples};
    scenario.frame_ends_s.clear();
  }
  require_mechanism(scenario.scene, scenario.id, options.joints, options.ropes);
  if (options.events && (options.joints || options.ropes))
    throw InputError("--events prints contacts and stops; expected it without --joints and --ropes");
  if (method == "truth" && !scenario.scene.fluids.empty() && scenario.truth.kind != TruthKind::none)
    return trace_field(place, options, scenario);

  if (method == "truth") {
    const Truth truth =
        truth_once(place.truth_worker, scenario, samples, options.limit_given ? options.cell_limit_s : 120.0);
    if (truth.values.size() > 1 && truth.outcome.status == Status::unsupported) {  // good up to where it ends
      print_values(options, scenario.scene, truth.values, truth.events, &truth, 36);
      fmt::print(stderr, "atwood: certified up to t = {} s, where the truth ends\n",
                 format_double(static_cast<double>(truth.values.back().t_s)));
    }
    if (truth.outcome.status != Status::ok) {
      const int code = status_exit(truth.outcome);
      if (truth.outcome.status == Status::unsupported && scenario.truth.kind != TruthKind::none)
        fmt::print(stderr, "atwood: {}\n", other_truths(place, scenario, 5));
      return code;
    }
    print_values(options, scenario.scene, truth.values, truth.events, &truth, 36);
    if (truth.condition > 0)
      fmt::print(stderr, "atwood: condition {:.1e}: how much the motion grows a relative perturbation of its start\n",
                 truth.condition);
    else if (scenario.truth.kind == TruthKind::extended) fmt::print(stderr, "atwood: condition not computed\n");
    if (!truth.note.empty()) fmt::print(stderr, "atwood: {}\n", printable(truth.note));
    return exit_pass;
  }

  const std::int64_t steps = options.steps.empty() ? scenario.steps.back() : options.steps.front();
  if (steps <= 0 || steps % samples != 0) {
    throw InputError(fmt::format("--steps {}: expected a multiple of the {} samples of the scenario", steps, samples));
  }
  const auto workers = require_workers(place, options, nullptr, {method});
  require_answers(workers);
  const Worker& worker = worker_of(workers, method);
  check_settings("--method ", method, workers);
  require_frames(scenario, worker, steps, samples);
  check_fluids("--method ", method, worker, scenario);
  const MethodId id = parse_method_id(method);
  Recording run = recorded(worker, method, scenario, steps, options.cell_limit_s);
  const int digits = digits_of(id.scalar.empty() ? worker.engine.scalar : id.scalar);
  if (run.outcome.status != Status::unsupported || !run.values.empty()) {  // up to where the run ended
    if (options.events || !print_fluid(options, scenario, run.values, digits)) {
      print_values(options, scenario.scene, run.values, run.events, nullptr, digits);
      if (scenario.scene.bodies.empty())
        fmt::print(stderr, "atwood: the scene has fluids and no bodies: --particles prints the particles\n");
    }
  }
  return status_exit(run.outcome);
}

}  // namespace atwood
