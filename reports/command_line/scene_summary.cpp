#include "reports/command_line/scene_summary.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "reference/dynamics/invariants.hpp"
#include "reports/command_line/advise.hpp"
#include "reports/command_line/manual.hpp"
#include "reports/command_line/mechanism_summary.hpp"
#include "reports/render/text.hpp"
#include "scene/files.hpp"

namespace atwood {
namespace {

constexpr double kMaxPairs = 1e7;   // in quad, 5 s
constexpr std::size_t kMany = 500;  // with more bodies no engine is asked
constexpr double kAskLimit_s = 5;
constexpr std::size_t kManyParticles = 100'000;

double norm(const Real3& v) { return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }

// Least and largest extent of a body, in metres; 0 of a point or of what is infinite.
struct Extent {
  double least_m = 0, largest_m = 0;
};
Extent extent_of_points(const std::vector<Real3>& points) {
  Extent extent;
  for (std::size_t k = 0; k < 3 && !points.empty(); ++k) {
    double low = INFINITY, high = -INFINITY;
    for (const Real3& point : points) {
      low = std::min(low, point[k]);
      high = std::max(high, point[k]);
    }
    extent.least_m = k == 0 ? high - low : std::min(extent.least_m, high - low);
    extent.largest_m = std::max(extent.largest_m, high - low);
  }
  return extent;
}

Extent extent_of(const Shape& shape) {
  if (const auto* s = std::get_if<Sphere>(&shape)) return {2 * s->radius_m, 2 * s->radius_m};
  if (const auto* s = std::get_if<Box>(&shape)) {
    const auto [low, high] = std::minmax_element(s->half_extents_m.begin(), s->half_extents_m.end());
    return {2 * *low, 2 * *high};
  }
  if (const auto* s = std::get_if<Capsule>(&shape)) return {2 * s->radius_m, 2 * (s->radius_m + s->half_length_m)};
  if (const auto* s = std::get_if<Cylinder>(&shape))
    return {2 * std::min(s->radius_m, s->half_length_m), 2 * std::max(s->radius_m, s->half_length_m)};
  if (const auto* s = std::get_if<Rectangle>(&shape)) {
    const double large = std::max(s->half_extents_m[0], s->half_extents_m[1]);
    return {2 * std::min(s->half_extents_m[0], s->half_extents_m[1]), 2 * large};
  }
  if (const auto* s = std::get_if<Convex>(&shape)) return extent_of_points(s->points_m);
  if (const auto* s = std::get_if<Mesh>(&shape)) return extent_of_points(s->points_m);
  if (const auto* s = std::get_if<Compound>(&shape)) {
    Extent extent;
    for (const auto& part : s->boxes) {
      const Extent box = extent_of(Box{part.half_extents_m});
      extent.least_m = extent.least_m > 0 ? std::min(extent.least_m, box.least_m) : box.least_m;
      extent.largest_m = std::max(extent.largest_m, box.largest_m);
    }
    return extent;
  }
  return {};
}

constexpr const char* kShapes[] = {"point mass", "sphere",   "plane",  "rectangle", "box",
                                   "capsule",    "cylinder", "convex", "mesh",      "compound"};
constexpr const char* kForces[] = {"mutual gravity", "attractor",   "linear drag",    "quadratic drag",
                                   "spring",         "drive",       "lorentz",        "coulomb",
                                   "thruster",       "point force", "rotating frame", "potential"};

// "3 boxes of 1 kg, 1 plane (fixed)".
std::string bodies_words(const Scene& scene) {
  if (!scene.problem.empty()) return "the bare system of equations `" + scene.problem + "`";
  std::vector<std::pair<std::string, int>> groups;
  for (const Body& body : scene.bodies) {
    std::string kind = kShapes[body.shape.index()];
    if (body.shape.index() == 0 && rotates(body)) kind = "body without a shape";
    kind += body.fixed ? " (fixed)" : fmt::format(" of {:.4g} kg", body.mass_kg);
    const auto known =
        std::find_if(groups.begin(), groups.end(), [&](const auto& group) { return group.first == kind; });
    if (known == groups.end()) groups.emplace_back(kind, 1);
    else ++known->second;
  }
  std::string text;
  for (std::size_t i = 0; i < groups.size() && i < 8; ++i)
    text += fmt::format("{}{} x {}", i == 0 ? "" : ", ", groups[i].second, groups[i].first);
  return groups.size() > 8 ? text + fmt::format(" and {} kinds more", groups.size() - 8) : text;
}

std::string forces_words(const Scene& scene) {
  std::vector<std::string> words;
  if (norm(scene.gravity_m_per_s2) > 0)
    words.push_back(fmt::format("gravity of {:.4g} m/s^2", norm(scene.gravity_m_per_s2)));
  std::map<std::size_t, int> counts;
  for (const Force& force : scene.forces) ++counts[force.index()];
  for (const auto& [kind, count] : counts)
    words.push_back(count == 1 ? kForces[kind] : fmt::format("{} x {}", count, kForces[kind]));
  return words.empty() ? "none" : fmt::format("{}", fmt::join(words, ", "));
}

// Whether bodies of these two materials can meet: one of them moves, and they are two.
bool can_meet(const Scene& scene, const PairLaw& law) {
  int a_moving = 0, a_all = 0, b_moving = 0, b_all = 0;
  for (const Body& body : scene.bodies) {
    if (std::holds_alternative<std::monostate>(body.shape)) continue;
    if (body.material == law.a) {
      ++a_all;
      a_moving += body.fixed ? 0 : 1;
    }
    if (body.material == law.b) {
      ++b_all;
      b_moving += body.fixed ? 0 : 1;
    }
  }
  return a_all > 0 && b_all > 0 && a_moving + b_moving > 0 && (law.a != law.b || a_all > 1);
}

std::vector<std::string> laws_words(const Scene& scene) {
  std::vector<std::string> words;
  int more = 0;
  for (const PairLaw& law : scene.pairs) {
    if (!can_meet(scene, law)) continue;
    if (words.size() == 6) {
      ++more;
      continue;
    }
    std::string line = fmt::format(
        "{} on {}: restitution {:.4g}, friction {:.4g}", scene.materials[static_cast<std::size_t>(law.a)].name,
        scene.materials[static_cast<std::size_t>(law.b)].name, law.restitution, law.friction);
    if (law.rolling_friction_m > 0) line += fmt::format(", rolling friction {:.4g} m", law.rolling_friction_m);
    if (law.contact_law == ContactLaw::linear)
      line += fmt::format("; compliant: {:.4g} N/m, {:.4g} N s/m", law.stiffness_N_per_m, law.damping_N_s_per_m);
    if (law.contact_law == ContactLaw::hertz)
      line += fmt::format("; compliant by Hertz's law, {:.4g} Pa", law.modulus_Pa);
    words.push_back(line);
  }
  if (more > 0) words.push_back(fmt::format("and {} pairs of materials more", more));
  return words;
}

// Pairs of bodies whose mutual potentials make up the energy.
double pairs_of_potentials(const Scene& scene) {
  double pairs = 0;
  for (const Force& force : scene.forces) {
    const auto* gravity = std::get_if<MutualGravity>(&force);
    const auto* coulomb = std::get_if<Coulomb>(&force);
    if (gravity == nullptr && coulomb == nullptr) continue;
    const auto n = static_cast<double>(gravity ? gravity->bodies.size() : coulomb->bodies.size());
    pairs += n * (n - 1) / 2;
  }
  return pairs;
}

std::string energy_words(const Scene& scene) {
  if (const double pairs = pairs_of_potentials(scene); pairs > kMaxPairs)
    return fmt::format("not added up: {:.3g} pairs of bodies attract or repel each other", pairs);
  Sample start;
  for (const Body& body : scene.bodies) {
    BodySample sample;
    std::copy(body.position_m.begin(), body.position_m.end(), sample.p_m.begin());
    std::copy(body.orientation_wxyz.begin(), body.orientation_wxyz.end(), sample.q_wxyz.begin());
    std::copy(body.velocity_m_per_s.begin(), body.velocity_m_per_s.end(), sample.v_m_per_s.begin());
    std::copy(body.angular_velocity_body_rad_per_s.begin(), body.angular_velocity_body_rad_per_s.end(),
              sample.w_rad_per_s.begin());
    start.bodies.push_back(sample);
  }
  const dynamics::Energy energy = dynamics::energy(scene, start);
  return fmt::format("{:.6g} J kinetic, {:.6g} J potential at the start", static_cast<double>(energy.kinetic_J),
                     static_cast<double>(energy.potential_J));
}

// ---- what engines and truths say ----------------------------------------------------------------------------------
struct Answers {
  std::vector<std::string> touches, runs, refuses, warnings;
};

std::string name_of(const Scene& scene, int body) { return scene.bodies.at(static_cast<std::size_t>(body)).name; }

void ask_contacts(const Scenario& scenario, const Worker& engine, Answers& out) {
  const Scene& scene = scenario.scene;
  const ContactAnswer now = contacts_once(engine, scene, {false, scenario.t_end_s}, kAskLimit_s);
  std::map<std::pair<int, int>, double> overlaps;
  for (const FoundContact& contact : now.contacts) {
    double& depth = overlaps[{contact.body_a, contact.body_b}];
    depth = std::max(depth, static_cast<double>(contact.depth_m));
  }
  int told = 0;
  for (const auto& [pair, depth] : overlaps) {
    const Extent a = extent_of(scene.bodies[static_cast<std::size_t>(pair.first)].shape),
                 b = extent_of(scene.bodies[static_cast<std::size_t>(pair.second)].shape);
    const double size =
        a.least_m > 0 && b.least_m > 0 ? std::min(a.least_m, b.least_m) : std::max(a.least_m, b.least_m);
    if (depth > 1e-6 * size && ++told <= 3)
      out.warnings.push_back(fmt::format("`{}` and `{}` overlap at the start by {:.3g} m", name_of(scene, pair.first),
                                         name_of(scene, pair.second), depth));
  }
  if (told > 3) out.warnings.push_back(fmt::format("{} pairs more overlap at the start", told - 3));
  if (!overlaps.empty())
    out.touches.push_back(fmt::format("{} pair{} at the start", overlaps.size(), overlaps.size() == 1 ? "" : "s"));
  const Plan coarsest{scenario.t_end_s, scenario.steps.front(), scenario.samples};
  const Recording motion = run_once(engine, "atwood/rk4+event", scene, coarsest, kAskLimit_s);
  if (motion.outcome.status == Status::ok) {
    std::size_t told_events = 0;
    for (const Event& event : motion.events) {
      if (event.kind != EventKind::impact || ++told_events > 3) continue;
      out.touches.push_back(fmt::format("`{}` and `{}` at {:.6g} s", name_of(scene, event.body_a),
                                        name_of(scene, event.body_b), static_cast<double>(event.t_s)));
    }
    if (told_events > 0) out.touches.back() += " (first impacts by atwood/rk4+event)";
    return;
  }
  ContactAnswer swept = contacts_once(engine, scene, {true, scenario.t_end_s}, kAskLimit_s);
  std::erase_if(swept.touches, [](const FoundTouch& touch) { return !(touch.toi_s > 0); });
  std::stable_sort(swept.touches.begin(), swept.touches.end(),
                   [](const FoundTouch& a, const FoundTouch& b) { return a.toi_s < b.toi_s; });
  for (std::size_t i = 0; i < std::min<std::size_t>(3, swept.touches.size()); ++i)
    out.touches.push_back(fmt::format("`{}` and `{}` at {:.6g} s", name_of(scene, swept.touches[i].body_a),
                                      name_of(scene, swept.touches[i].body_b),
                                      static_cast<double>(swept.touches[i].toi_s)));
  if (!swept.touches.empty()) out.touches.back() += " (on straight paths, forces left out)";
  if (now.outcome.status != Status::ok) out.touches.push_back(now.outcome.reason);
}

// One step of one method of each engine; of ours, of each response where bodies may touch.
void ask_engines(const Scenario& scenario, const std::vector<Worker>& workers, bool contacts, Answers& out) {
  const double h_s = scenario.t_end_s / static_cast<double>(std::max<std::int64_t>(1, scenario.steps.back()));
  for (const Worker& worker : workers) {
    if (worker.status != Status::ok || worker.engine.methods.empty()) continue;
    std::vector<std::string> asked;
    const std::string first = worker.engine.name == "atwood" ? "atwood/rk4" : worker.engine.methods.front().id;
    if (!contacts || worker.engine.responses.empty()) asked.push_back(first);
    else
      for (const MethodInfo& response : worker.engine.responses) asked.push_back(first + response.id);
    for (const std::string& method : asked) {
      const Recording run = run_once(worker, method, scenario.scene, {h_s, 1, 1}, kAskLimit_s);
      const std::string name = asked.size() > 1 ? method : worker.engine.name;
      if (run.outcome.status == Status::ok) out.runs.push_back(name);
      else out.refuses.push_back(fmt::format("{}: {}: {}", name, to_string(run.outcome.status), run.outcome.reason));
    }
  }
}

// A foreign engine of fluids is asked for one step, of few particles, where that takes no time. Only a refusal says
// that it does not run the scene: an engine that compiles its code first takes longer than it is asked. Ours runs every
// fluid by one of its responses.
void ask_fluid_engines(const Scenario& scenario, const std::vector<Worker>& workers, Answers& out) {
  std::size_t particles = 0;
  for (const Fluid& fluid : scenario.scene.fluids) particles += fluid.particles.position_m.size();
  const double h_s = scenario.t_end_s / static_cast<double>(std::max<std::int64_t>(1, scenario.steps.back()));
  for (const Worker& worker : workers) {
    if (worker.status != Status::ok || !worker.engine.fluids) continue;
    Outcome outcome;
    if (worker.engine.name != "atwood" && !worker.engine.methods.empty() && particles <= kManyParticles)
      outcome = run_once(worker, worker.engine.methods.front().id, scenario.scene, {h_s, 1, 1}, kAskLimit_s).outcome;
    if (outcome.status != Status::unsupported) out.runs.push_back(worker.engine.name);
    else out.refuses.push_back(fmt::format("{}: {}", worker.engine.name, outcome.reason));
  }
}

std::string truth_answer(const Place& place, const Scenario& scenario) {
  const std::string words = truth_words(scenario.truth);
  if (scenario.truth.kind == TruthKind::none)
    return "the scene names none: engines can only be compared with each other";
  const Truth truth = truth_once(place.truth_worker, scenario, scenario.samples, kAskLimit_s);
  if (truth.outcome.status == Status::timeout) return words + fmt::format("; not solved within {:g} s", kAskLimit_s);
  if (truth.outcome.status != Status::ok) return words + "; it does not cover this scene: " + truth.outcome.reason;
  double bar = 0;
  for (const BodySample& body : truth.bars.back().bodies)
    for (const Wide value : body.p_m) bar = std::max(bar, static_cast<double>(value));
  return words + fmt::format("; its positions at the end are known within {:.1g} m", bar);
}

std::string item(const std::string& name, const std::string& words, std::size_t width) {
  std::string text = wrapped(words, 13, width);
  if (text.size() > 13) text.replace(2, name.size(), name);
  return text;
}

std::string fluid_words(const Scenario& scenario, const Fluid& fluid) {
  static const char* const arrangements[] = {"a lattice", "a disturbed lattice", "rings", "points of a file"};
  std::string words = fmt::format(
      "`{}`: {} particles on {}, spacing {} m, rho0 {} kg/m^3, sound speed {} m/s, {}", fluid.name,
      fluid.particles.position_m.size(), arrangements[static_cast<std::size_t>(fluid.arrangement)],
      format_double(fluid.spacing_m), format_double(fluid.density_kg_per_m3), format_double(fluid.sound_speed_m_per_s),
      fluid.equation_of_state == EquationOfState::linear
          ? std::string("linear equation of state")
          : fmt::format("Tait with exponent {}", format_double(fluid.tait_exponent)));
  if (fluid.viscosity_m2_per_s > 0)
    words += fmt::format(", viscosity {} m^2/s", format_double(fluid.viscosity_m2_per_s));
  if (fluid.heat_capacity_J_per_kg_K > 0)
    words += fmt::format(", heat capacity {} J/(kg K), conductivity {} W/(m K)",
                         format_double(fluid.heat_capacity_J_per_kg_K), format_double(fluid.conductivity_W_per_m_K));
  if (!fluid.initial.name.empty()) words += fmt::format(", starts as `{}`", fluid.initial.name);
  const auto ladder = [&](const char* name, const std::vector<double>& values) {
    if (values.size() < 2) return;
    words += fmt::format("; {}", name);
    for (const double value : values) words += " " + format_double(value);
  };
  ladder("spacings [m]", scenario.spacings_m);
  ladder("sound speeds [m/s]", scenario.sound_speeds_m_per_s);
  return words;
}

std::string domain_words(const Scene& scene) {
  std::string words = scene.domain.dimensions == 2 ? "the plane z = 0" : "three dimensions";
  for (std::size_t i = 0; i < 3; ++i)
    if (scene.domain.periodic_m[i] > 0)
      words += fmt::format(", period {} m along {}", format_double(scene.domain.periodic_m[i]), "xyz"[i]);
  for (const FluidBoundary& boundary : scene.fluid_boundaries)
    words += fmt::format(", {} boundary `{}`", boundary.slip == Slip::no_slip ? "no-slip" : "free-slip",
                         scene.bodies[static_cast<std::size_t>(boundary.body)].name);
  const auto moves = [](const Body& body) {
    return !body.fixed && !std::holds_alternative<std::monostate>(body.shape);
  };
  if (std::any_of(scene.bodies.begin(), scene.bodies.end(), moves))
    words += "; bodies have no contact with each other (a run ends where one begins to overlap a boundary or a body)";
  return words;
}

}  // namespace

std::vector<std::string> scene_warnings(const Scenario& scenario) {
  std::vector<std::string> warnings = scenario.notes;
  const Body *smallest = nullptr, *largest = nullptr;
  double least = INFINITY, most = 0;
  const double h_s = scenario.steps.empty() ? 0 : scenario.t_end_s / static_cast<double>(scenario.steps.front());
  const auto shaped = std::count_if(scenario.scene.bodies.begin(), scenario.scene.bodies.end(), [](const Body& body) {
    return !std::holds_alternative<std::monostate>(body.shape);
  });
  int fast = 0;
  for (const Body& body : scenario.scene.bodies) {
    const Extent extent = extent_of(body.shape);
    if (!(extent.largest_m > 0)) continue;
    if (extent.largest_m < least) {
      least = extent.largest_m;
      smallest = &body;
    }
    if (extent.largest_m > most) {
      most = extent.largest_m;
      largest = &body;
    }
    const double way_m = norm(body.velocity_m_per_s) * h_s;
    if (shaped > 1 && !body.fixed && way_m > extent.least_m && extent.least_m > 0 && ++fast == 1)
      warnings.push_back(
          fmt::format("`{}` moves {:.3g} m in a step of the coarsest rung, more than its {:.3g} m: an engine "
                      "may not see what it passes through",
                      body.name, way_m, extent.least_m));
  }
  if (fast > 1) warnings.push_back(fmt::format("{} bodies more do the same", fast - 1));
  if (most >= 1000 * least)
    warnings.push_back(fmt::format("sizes are {:.3g} times apart: `{}` is {:.3g} m, `{}` {:.3g} m", most / least,
                                   smallest->name, least, largest->name, most));
  double light = INFINITY, heavy = 0;
  for (const Body& body : scenario.scene.bodies) {
    if (body.fixed || !(body.mass_kg > 0) || std::holds_alternative<std::monostate>(body.shape)) continue;
    light = std::min(light, body.mass_kg);
    heavy = std::max(heavy, body.mass_kg);
  }
  if (heavy >= 1e4 * light && shaped > 1)
    warnings.push_back(fmt::format("masses of bodies that may touch are {:.3g} times apart", heavy / light));
  return warnings;
}

std::string scene_summary(const Place& place, const Scenario& scenario, const std::vector<Worker>& workers,
                          int columns) {
  const auto width = static_cast<std::size_t>(std::clamp(columns, 50, 110));
  const Scene& scene = scenario.scene;
  const MotionClass motion = classify(scene);
  Answers answers;
  const bool fluid = !scene.fluids.empty();
  const bool small = scene.bodies.size() <= kMany && !fluid;
  if (small && motion.contacts) {
    for (const Worker& worker : workers) {
      if (worker.status == Status::ok && worker.engine.name == "atwood") ask_contacts(scenario, worker, answers);
    }
  }
  if (small) ask_engines(scenario, workers, motion.contacts, answers);
  if (fluid) ask_fluid_engines(scenario, workers, answers);
  std::string text = wrapped(scenario.id + ": " + scenario.title, 0, width);
  const auto line = [&](const std::string& name, const std::string& words) {
    if (!words.empty()) text += item(name, words, width);
  };
  line("claim", scenario.claim);
  line("source", scenario.source);
  line("tags", fmt::format("{}", fmt::join(scenario.tags, " ")));
  line("run", fmt::format("{} s, {} samples, steps {}", format_double(scenario.t_end_s), scenario.samples,
                          fmt::join(scenario.steps, " ")));
  line("motion", class_words(motion));
  for (const Fluid& each : scene.fluids) line("fluid", fluid_words(scenario, each));
  if (!scene.fluids.empty()) line("space", domain_words(scene));
  if (scene.fluids.empty() || !scene.bodies.empty()) line("bodies", bodies_words(scene));
  for (const std::string& words : joints_words(scene)) line("joint", words);
  for (const std::string& words : ropes_words(scene)) line("rope", words);
  if (scene.problem.empty()) line("forces", forces_words(scene));
  if (motion.contacts)
    for (const std::string& words : laws_words(scene)) line("contact", words);
  if (motion.contacts && small)
    line("touches", answers.touches.empty() ? "none found" : fmt::format("{}", fmt::join(answers.touches, "; ")));
  if (scene.problem.empty() && !fluid) line("energy", energy_words(scene));
  if (small) {
    line("runs in", answers.runs.empty() ? "no engine that is here" : fmt::format("{}", fmt::join(answers.runs, ", ")));
    for (const std::string& refusal : answers.refuses) line("not in", refusal);
    line("truth", truth_answer(place, scenario));
  } else {
    line("runs in", !fluid                 ? fmt::format("not asked of the engines: {} bodies", scene.bodies.size())
                    : answers.runs.empty() ? "no engine that is here simulates this fluid"
                                           : fmt::format("{}", fmt::join(answers.runs, ", ")));
    for (const std::string& refusal : answers.refuses) line("not in", refusal);
    line("truth", truth_words(scenario.truth));
  }
  std::vector<std::string> warnings = scene_warnings(scenario);
  warnings.insert(warnings.end(), answers.warnings.begin(), answers.warnings.end());
  for (const std::string& warning : warnings) line("warning", warning);
  return text;
}

}  // namespace atwood
