// The documented ranges of a search, engine by engine.
#include <algorithm>

#include <fmt/format.h>

#include "reports/command_line/tune.hpp"
#include "scene/files.hpp"
#include "scene/split_mix.hpp"

namespace atwood {
namespace {

using Whole = std::int64_t;
using Word = std::string;

// No `substeps` in any range: a step of a preset stays a step, and rows with `{substeps=4}` stand beside for equal
// work.

TuneRanges bullet(const std::string& name) {
  TuneRanges made{name, name + "/default", {}, {}};
  made.ranges = {
      {"contact_processing_threshold_m", {1e18, 0.0}, "0: no speculative contact, which stops a ball above the floor"},
      {"restitution_velocity_threshold_m_per_s",
       {0.2, 1e-6},
       "slower impacts do not bounce; the manual's value, or none"},
      {"split_impulse_penetration_threshold_m",
       {-0.04, 0.0},
       "overlap up to this is taken away by velocity, which adds energy"},
      {"iterations", {Whole{10}, Whole{20}, Whole{50}}, "of the sequential impulses; the manual's range"},
      {"erp", {0.2, 0.1, 0.4}, "share of an overlap that a step takes away"},
      {"contact_breaking_threshold_m", {0.02, 0.002}, "how far a persistent contact point may drift"},
      {"friction_directions", {Whole{1}, Whole{2}}, "of friction's pyramid"},
      {"warm_starting_factor", {0.85, 1.0}, "of the last step's impulses"},
      {"gyroscopic",
       {Word("implicit-body"), Word("implicit-world")},
       "the gyroscopic term; off would be another physics"},
      {"smooth_inner_edges", {false, true}, "normals at the inner edges of a mesh"}};
  // What was the one preset for all scenes: right for bounces, wrong for heaps and for what rolls.
  made.starts = {{{"contact_processing_threshold_m", 0.0},
                  {"restitution_velocity_threshold_m_per_s", 1e-6},
                  {"split_impulse_penetration_threshold_m", 0.0},
                  {"iterations", Whole{50}},
                  {"smooth_inner_edges", true}},
                 {{"smooth_inner_edges", true}}};
  return made;
}

TuneRanges ode() {
  TuneRanges made{"ode", "ode/default", {}, {}};
  made.ranges = {
      {"erp", {0.2, 0.0, 0.1, 0.4, 0.8}, "share of an overlap that a step takes away; the guide's range is 0.1 to 0.8"},
      {"cfm", {1e-10, 1e-7, 1e-5}, "softness of constraints; the guide's range"},
      {"step", {Word("dWorldStep"), Word("dWorldQuickStep")}, "a direct solver, or sweeps"},
      {"iterations", {Whole{20}, Whole{50}, Whole{100}}, "of dWorldQuickStep"},
      {"contact_surface_layer_m", {0.0, 1e-4, 1e-3}, "overlap that is left alone"},
      {"friction_direction",
       {Word("engine"), Word("slip")},
       "friction's pyramid along the engine's axes, or along the slip"},
      {"finite_rotation", {false, true}, "attitude by a rotation of finite angle"},
      {"max_contacts", {Whole{8}, Whole{4}, Whole{16}}, "contact points of a pair"}};
  made.starts = {{{"erp", 0.0}, {"friction_direction", Word("slip")}, {"finite_rotation", true}},
                 {{"friction_direction", Word("slip")}, {"finite_rotation", true}},
                 {{"friction_direction", Word("slip")}}};
  return made;
}

// Joints alone: of contacts nothing. Gaps and momentum errors come from constraints that are not solved to the end.
TuneRanges bullet_mechanisms(const std::string& name) {
  TuneRanges made{name, name + "/default", {}, {}};
  made.ranges = {
      {"iterations", {Whole{10}, Whole{20}, Whole{50}, Whole{100}, Whole{200}}, "of the sequential impulses"},
      {"erp", {0.2, 0.05, 0.1, 0.4, 0.8, 1.0}, "share of a joint's gap that a step takes away"},
      {"warm_starting_factor", {0.85, 0.0, 1.0}, "of the last step's impulses"},
      {"sor", {1.0, 1.3}, "over-relaxation of the sweeps"},
      {"gyroscopic",
       {Word("implicit-body"), Word("implicit-world"), Word("explicit")},
       "the gyroscopic term; off would be another physics"}};
  made.starts = {{{"iterations", Whole{50}}}, {{"iterations", Whole{100}}, {"erp", 0.8}}};
  return made;
}

TuneRanges ode_mechanisms() {
  TuneRanges made{"ode", "ode/default", {}, {}};
  made.ranges = {{"erp", {0.2, 0.05, 0.1, 0.4, 0.8, 1.0}, "share of a joint's gap that a step takes away"},
                 {"cfm", {1e-10, 1e-13, 1e-7}, "softness of constraints; 0 aborts where they depend on each other"},
                 {"finite_rotation", {false, true}, "attitude by a rotation of finite angle"}};
  made.starts = {{{"erp", 0.8}}, {{"erp", 0.8}, {"finite_rotation", true}}};
  return made;
}

// For joints too: one solver takes contacts and constraints.
TuneRanges jolt() {
  TuneRanges made{"jolt", "jolt/default", {}, {}};
  made.ranges = {
      {"velocity_steps", {Whole{10}, Whole{4}, Whole{20}, Whole{50}}, "sweeps of the velocities in a step"},
      {"position_steps", {Whole{2}, Whole{1}, Whole{4}, Whole{10}}, "sweeps of the positions in a step"},
      {"baumgarte", {0.2, 0.1, 0.4, 0.8}, "share of an overlap, or of a gap, that a position sweep takes away"},
      {"penetration_slop_m", {0.02, 0.005, 0.001, 0.0}, "overlap that is left alone"},
      {"speculative_contact_distance_m", {0.02, 0.005, 0.0}, "gap up to which a contact enters the solver"},
      {"min_velocity_for_restitution_m_per_s", {1.0, 0.1, 0.0}, "slower impacts do not bounce"},
      {"convex_radius_m", {0.05, 0.01, 0.0}, "rounding of edges"},
      {"warm_start", {true, false}, "the last step's impulses to begin with"},
      {"enhanced_internal_edge_removal", {false, true}, "normals at the inner edges of a mesh"}};
  made.starts = {{{"penetration_slop_m", 0.0},
                  {"speculative_contact_distance_m", 0.0},
                  {"min_velocity_for_restitution_m_per_s", 0.0}},
                 {{"penetration_slop_m", 0.001}, {"velocity_steps", Whole{20}}, {"position_steps", Whole{4}}}};
  return made;
}

// solver_iterations are substeps of Rapier's own solver: a set with more of them is compared at equal time, as all are.
TuneRanges rapier(rivals::SceneClass scene_class) {
  TuneRanges made{"rapier", "rapier/default", {}, {}};
  made.ranges = {{"solver_iterations", {Whole{4}, Whole{1}, Whole{2}, Whole{8}, Whole{16}}, "substeps of its solver"}};
  if (scene_class == rivals::SceneClass::free_flight) return made;
  made.ranges.push_back({"pgs_iterations", {Whole{1}, Whole{2}, Whole{4}}, "sweeps in each of them"});
  if (scene_class == rivals::SceneClass::mechanism) {
    made.starts = {{{"solver_iterations", Whole{16}}}, {{"pgs_iterations", Whole{4}}}};
    return made;
  }
  for (TuneRange range : {TuneRange{"contact_natural_frequency_Hz",
                                    {30.0, 60.0, 120.0, 240.0},
                                    "of the spring that takes an overlap away; its damping ratio is fixed"},
                          TuneRange{"allowed_linear_error", {0.005, 0.001, 0.0}, "overlap that is left alone"},
                          TuneRange{"prediction_distance", {0.02, 0.002, 0.0}, "gap from which contacts are solved"},
                          TuneRange{"ccd", {false, true}, "fast bodies stop at their first touch"},
                          TuneRange{"smooth_inner_edges", {false, true}, "normals at the inner edges of a mesh"}})
    made.ranges.push_back(std::move(range));
  made.starts = {{{"prediction_distance", 0.0}, {"allowed_linear_error", 0.0}},
                 {{"contact_natural_frequency_Hz", 120.0}, {"allowed_linear_error", 0.001}}};
  return made;
}

// Of MuJoCo 2.2 (`mujoco`) and 3. The starts are a set put together by hand for all scenes, and its integrator alone.
TuneRanges mujoco(const std::string& name, rivals::SceneClass scene_class) {
  using rivals::SceneClass;
  TuneRanges made{name, name + "/default", {}, {}};
  made.ranges = {{"integrator", {Word("Euler"), Word("RK4"), Word("implicit")}, "of a step"}};
  if (name == "mujoco3") made.ranges[0].values.push_back(Word("implicitfast"));
  made.starts = {{{"integrator", Word("RK4")}}};
  if (scene_class == SceneClass::free_flight) return made;
  if (scene_class == SceneClass::mechanism) {
    made.ranges.push_back({"mechanism_tolerance", {1e-8, 0.0}, "improvement at which the solver ends"});
    made.ranges.push_back(
        {"joint_solref_time_constant_steps", {0.0, 2.0, 4.0}, "time constant of constraints; 0: 0.02 s"});
    made.ranges.push_back({"joint_solimp_least", {0.9, 0.99, 0.9999}, "impedance of constraints without violation"});
    made.ranges.push_back({"joint_solimp_most", {0.95, 0.999, 0.9999}, "and at large violations"});
    made.starts.push_back({{"integrator", Word("RK4")},
                           {"mechanism_tolerance", 0.0},
                           {"joint_solref_time_constant_steps", 2.0},
                           {"joint_solimp_least", 0.9999},
                           {"joint_solimp_most", 0.9999}});
    return made;
  }
  for (TuneRange range : {TuneRange{"cone", {Word("pyramidal"), Word("elliptic")}, "model of the friction cone"},
                          TuneRange{"impratio", {1.0, 10.0, 100.0}, "stiffness of friction over the normal's"},
                          TuneRange{"solref_time_constant_s", {0.02, 0.01, 0.005}, "time constant of a contact"},
                          TuneRange{"solimp_least", {0.9, 0.99}, "impedance at no overlap"},
                          TuneRange{"solimp_most", {0.95, 0.999}, "impedance at overlaps beyond the width"},
                          TuneRange{"tolerance", {1e-8, 1e-10}, "improvement at which the solver ends"},
                          TuneRange{"noslip_iterations", {Whole{0}, Whole{10}}, "sweeps against slipping"}})
    made.ranges.push_back(std::move(range));
  made.starts.push_back({{"integrator", Word("RK4")},
                         {"cone", Word("elliptic")},
                         {"impratio", 100.0},
                         {"tolerance", 1e-10},
                         {"solref_time_constant_s", 0.01},
                         {"solimp_least", 0.99},
                         {"solimp_most", 0.999}});
  made.starts.push_back({{"cone", Word("elliptic")}, {"impratio", 10.0}});
  return made;
}

// The start is a set put together by hand for all scenes.
TuneRanges dart(rivals::SceneClass scene_class) {
  TuneRanges made{"dart", "dart/default", {}, {}};
  if (scene_class == rivals::SceneClass::free_flight) return made;  // nothing to set
  made.ranges = {{"erp", {0.01, 0.0, 0.1}, "share of an overlap that a step takes away, by velocity"},
                 {"cfm", {1e-5, 1e-7, 1e-9}, "softness of contacts; 1e-9 is the least that DART admits"},
                 {"friction_direction",
                  {Word("engine"), Word("slip")},
                  "friction's pyramid along the engine's axes, or along the slip"},
                 {"lcp_solver", {Word("dantzig"), Word("pgs")}, "a direct solver, or sweeps"},
                 {"max_erv_m_per_s", {1e-3, 1e-2}, "largest velocity that removes overlap"}};
  made.starts = {{{"erp", 0.0}, {"cfm", 1e-9}, {"friction_direction", Word("slip")}},
                 {{"cfm", 1e-9}, {"friction_direction", Word("slip")}}};
  return made;
}

TuneRanges simbody() {
  TuneRanges made{"simbody", "simbody/default", {}, {}};
  made.ranges = {{"integrator",
                  {Word("RungeKuttaMerson"), Word("RungeKuttaFeldberg"), Word("RungeKutta3"), Word("Verlet")},
                  "of a step"},
                 {"constraint_tolerance", {1e-10, 1e-12}, "error of constraints at which a step projects"},
                 {"project_every_step", {false, true}, "every step ends with a projection"}};
  return made;
}

TuneRanges atwood() {
  TuneRanges made{"atwood", "atwood/symplectic-euler+impulse", {}, {}};
  made.ranges = {{"solver",
                  {Word("auto"), Word("direct"), Word("sequential")},
                  "few contacts at once by Newton's method, many by sweeps"},
                 {"iterations", {Whole{2}, Whole{1}, Whole{4}, Whole{8}}, "sweeps of the velocities in a substep"},
                 {"correction", {0.3, 0.1, 0.6}, "share of an overlap that a substep takes away"},
                 {"warm_start", {true, false}, "the last substep's impulses to begin with"},
                 {"restitution", {Word("newton"), Word("poisson"), Word("stronge")}, "the hypothesis of impact"}};
  return made;
}

}  // namespace

TuneRanges tune_ranges(const std::string& engine, rivals::SceneClass scene_class) {
  if (scene_class == rivals::SceneClass::mechanism) {
    if (engine == "bullet64" || engine == "bullet32") return bullet_mechanisms(engine);
    if (engine == "ode") return ode_mechanisms();
  }
  if (engine == "bullet64" || engine == "bullet32") return bullet(engine);
  if (engine == "ode") return ode();
  if (engine == "jolt") return jolt();
  if (engine == "rapier") return rapier(scene_class);
  if (engine == "mujoco" || engine == "mujoco3") return mujoco(engine, scene_class);
  if (engine == "dart") return dart(scene_class);
  if (engine == "simbody") return simbody();
  if (engine == "atwood") return atwood();
  throw InputError(fmt::format(
      "tune {}: found no ranges for that engine; expected atwood, bullet32, bullet64, dart, jolt, mujoco, mujoco3, ode, "
      "rapier or simbody",
      engine));
}

std::vector<Settings> tune_trials(const TuneRanges& ranges, int count, std::uint64_t seed) {
  std::vector<Settings> trials{{}};
  const auto add = [&](const Settings& changes) {
    if (std::find(trials.begin(), trials.end(), changes) == trials.end()) trials.push_back(changes);
  };
  for (const Settings& start : ranges.starts)
    if (static_cast<int>(trials.size()) < count) add(start);
  SplitMix64 random{seed};
  // Half of the rest: one change at a time, so that each setting is seen alone.
  std::vector<Settings> single;
  for (const TuneRange& range : ranges.ranges)
    for (std::size_t i = 1; i < range.values.size(); ++i) single.push_back({{range.setting, range.values[i]}});
  for (std::size_t i = single.size(); i > 1; --i)
    std::swap(single[i - 1], single[static_cast<std::size_t>(random.next_unit() * static_cast<double>(i))]);
  const int half = (count + static_cast<int>(trials.size())) / 2;
  for (const Settings& changes : single)
    if (static_cast<int>(trials.size()) < half) add(changes);
  for (int tries = 0; tries < 100 * count && static_cast<int>(trials.size()) < count; ++tries) {
    Settings changes;
    for (const TuneRange& range : ranges.ranges) {
      const bool keep = random.next_unit() < 0.5;
      const auto pick = static_cast<std::size_t>(random.next_unit() * static_cast<double>(range.values.size()));
      if (keep || pick == 0) continue;
      changes[range.setting] = range.values[pick];
    }
    add(changes);
  }
  return trials;
}

const std::vector<std::string>& primary_metrics(rivals::SceneClass scene_class) {
  using rivals::SceneClass;
  static const std::vector<std::string> flight{"error-position-max", "error-attitude-max", "energy-max"},
      bounce{"apex-error", "error-position-max", "error-position-end", "energy-gain"},
      friction{"error-position-max", "error-attitude-max", "error-velocity-rms", "energy-max", "penetration-max"},
      stack{"error-position-max", "penetration-max", "penetration-rms", "energy-gain"},
      heap{"penetration-max", "penetration-rms", "energy-gain", "energy-rise"},
      mechanism{"error-position-max", "error-attitude-max", "joint-gap", "energy-max"};
  switch (scene_class) {
    case SceneClass::free_flight: return flight;
    case SceneClass::bounce: return bounce;
    case SceneClass::friction: return friction;
    case SceneClass::stack: return stack;
    case SceneClass::heap: return heap;
    case SceneClass::mechanism: return mechanism;
  }
  return flight;
}

}  // namespace atwood
