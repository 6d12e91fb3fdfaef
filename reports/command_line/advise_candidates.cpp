// Candidates for a scene, and the truth that they are compared with.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>

#include "reports/command_line/advise.hpp"
#include "reports/command_line/same_rate.hpp"
#include "scene/files.hpp"
#include "validation/metrics/joints.hpp"
#include "validation/metrics/work_precision.hpp"
#include "validation/study/write_file.hpp"

namespace atwood {
namespace {

bool shaped(const Body& body) { return !std::holds_alternative<std::monostate>(body.shape); }

bool gives_way(const Scene& scene) {
  return std::any_of(scene.pairs.begin(), scene.pairs.end(),
                     [](const PairLaw& law) { return law.contact_law != ContactLaw::rigid; });
}

// The law of a pair of materials that two bodies have, one of them not fixed, loses energy: by restitution, friction or
// damping.
bool contacts_dissipate(const Scene& scene) {
  std::vector<int> bodies(scene.materials.size()), moving(scene.materials.size());
  for (const Body& body : scene.bodies) {
    if (!shaped(body)) continue;
    const auto material = static_cast<std::size_t>(body.material);
    ++bodies[material];
    moving[material] += body.fixed ? 0 : 1;
  }
  return std::any_of(scene.pairs.begin(), scene.pairs.end(), [&](const PairLaw& law) {
    const auto a = static_cast<std::size_t>(law.a), b = static_cast<std::size_t>(law.b);
    const bool meet = a == b ? bodies[a] > 1 : bodies[a] > 0 && bodies[b] > 0;
    if (!meet || moving[a] + moving[b] == 0) return false;
    const bool rigid = law.contact_law == ContactLaw::rigid;
    return law.friction != 0 || law.rolling_friction_m != 0 || (rigid && law.restitution != 1) ||
           law.damping_N_s_per_m != 0 || law.damping_s_per_m != 0;
  });
}

// Gravity of the world, and nothing that changes with place, time or velocity.
bool constant_forces(const Scene& scene) { return scene.forces.empty(); }

// Interleaves the engines in the order in which they are first named: one method of each per round.
std::vector<std::string> in_turns(const std::vector<std::string>& ids) {
  std::vector<std::pair<std::string, std::vector<std::string>>> engines;
  std::size_t rounds = 0;
  for (const std::string& id : ids) {
    const std::string engine = engine_of(id);
    auto known = std::find_if(engines.begin(), engines.end(), [&](const auto& one) { return one.first == engine; });
    if (known == engines.end()) known = engines.insert(engines.end(), {engine, {}});
    known->second.push_back(id);
    rounds = std::max(rounds, known->second.size());
  }
  std::vector<std::string> turns;
  for (std::size_t round = 0; round < rounds; ++round) {
    for (const auto& [engine, own] : engines)
      if (round < own.size()) turns.push_back(own[round]);
  }
  return turns;
}

// Interleaves the first `short_list` ids, then the others. An engine without a method in the short list gets its first
// method into it.
void take_turns(Candidates& chosen, std::size_t short_list) {
  std::vector<std::string> early, late;
  std::set<std::string> engines;
  for (std::size_t i = 0; i < chosen.ids.size(); ++i) {
    const bool first_of_engine = engines.insert(engine_of(chosen.ids[i])).second;
    (i < short_list || first_of_engine ? early : late).push_back(chosen.ids[i]);
  }
  chosen.ids = in_turns(early);
  chosen.firsts = engines.size();
  chosen.short_list = early.size();
  const std::vector<std::string> others = in_turns(late);
  chosen.ids.insert(chosen.ids.end(), others.begin(), others.end());
}

// The methods that are tried first: ours for the kind of motion, rivals, and methods of high order of the large
// libraries. Globs with suffixes; methods that this build does not have are left out.
std::vector<std::string> first_ids(const MotionClass& motion, const Scene& scene) {
  const std::vector<std::string> rivals{"ode/*",    "bullet64/*", "bullet32/*", "dart/*",
                                        "mujoco/*", "simbody/*",  "cvode/*"};
  std::vector<std::string> ids;
  const auto add = [&](const std::vector<std::string>& more) { ids.insert(ids.end(), more.begin(), more.end()); };
  if (motion.contacts) {
    // Locating each event of many bodies takes long; substeps that resolve all contacts together come first there.
    const auto moving = std::count_if(scene.bodies.begin(), scene.bodies.end(),
                                      [](const Body& body) { return shaped(body) && !body.fixed; });
    if (moving >= 8) add({"atwood/symplectic-euler+impulse"});
    // Between impacts a constant force is met exactly by two stages; more of them only cost more.
    if (constant_forces(scene)) add({"atwood/midpoint+event", "atwood/velocity-verlet+event", "atwood/heun+event"});
    add({"atwood/rk4+event"});
    if (moving < 8) add({"atwood/symplectic-euler+impulse"});
    if (gives_way(scene)) add({"atwood/rk4+penalty", "atwood/velocity-verlet+penalty"});
    add(rivals);
    add({"atwood/velocity-verlet+event", "atwood/midpoint+event", "atwood/dopri5+event", "atwood/verner6+event",
         "atwood/verner8+event", "atwood/rk4+impulse"});
    return ids;
  }
  if (motion.mechanism) {
    add({"atwood/dop853", "atwood/rk4", "atwood/radau15", "atwood/verner9", "atwood/verner8", "atwood/dopri5",
         "atwood/verner6", "atwood/tsit5", "atwood/gbs", "atwood/gauss8", "atwood/adams-moulton8"});
    add(rivals);
    add({"ida/*"});
    return ids;
  }
  add({"atwood/rk4", "atwood/dopri5", "atwood/tsit5", "atwood/verner6", "atwood/verner8", "atwood/verner9",
       "atwood/dop853", "atwood/radau15", "atwood/ias15", "atwood/gbs", "atwood/taylor", "atwood/gauss8",
       "atwood/adams-moulton8"});
  if (!motion.rotates && motion.conservative)
    add({"atwood/dprkn12", "atwood/kahan-li8", "atwood/blanes-moan-rkn6", "atwood/leapfrog"});
  if (motion.rotates) add({"atwood/free-top4", "atwood/free-top6", "atwood/lie4", "atwood/rkmk4"});
  if (motion.magnetic) add({"atwood/boris", "atwood/boris4", "atwood/boris6"});
  add(rivals);
  add({"odeint/runge_kutta_dopri5", "odeint/runge_kutta_fehlberg78", "odeint/controlled/*", "odeint/bulirsch*",
       "arkode/erkstep/DORMAND_PRINCE_7_4_5", "arkode/erkstep/VERNER_8_5_6", "arkode/erkstep/FEHLBERG_13_7_8"});
  return ids;
}

// The classes of motion that a method must claim an order for.
std::vector<std::string> needed_claims(const MotionClass& motion) {
  std::vector<std::string> claims;
  if (motion.bare) return claims;
  if (motion.mechanism) return {motion.loop ? "loop" : "mechanism"};
  if (motion.rotates) claims.push_back("rotation");
  if (motion.velocity_dependent) claims.push_back("velocity-dependent");
  if (claims.empty()) claims.push_back("point-mass");
  return claims;
}

std::string missing_claim(const MethodInfo& info, const MotionClass& motion) {
  if (info.claimed_order.empty()) return "";  // claims nothing anywhere: a library's method by tolerance
  for (const std::string& claim : needed_claims(motion)) {
    if (!info.claimed_order.contains(claim)) return "claims no order for this class of motion (" + claim + ")";
  }
  return "";
}

}  // namespace

MotionClass classify(const Scene& scene) {
  MotionClass motion;
  motion.fluids = !scene.fluids.empty();
  motion.bare = !scene.problem.empty();
  motion.mechanism = has_mechanism(scene);
  motion.loop = !scene.ropes.empty() || std::any_of(scene.joints.begin(), scene.joints.end(),
                                                    [](const Joint& joint) { return joint.closes_loop; });
  motion.conservative = !motion.bare;
  int shapes = 0;
  for (const Body& body : scene.bodies) {
    motion.rotates = motion.rotates || (!body.fixed && rotates(body));
    shapes += shaped(body) ? 1 : 0;
  }
  motion.contacts = shapes > 1;
  if (motion.contacts && contacts_dissipate(scene)) motion.conservative = false;
  for (const Force& force : scene.forces) {
    bool depends = std::holds_alternative<LinearDrag>(force) || std::holds_alternative<QuadraticDrag>(force) ||
                   std::holds_alternative<RotatingFrame>(force);
    if (const auto* spring = std::get_if<Spring>(&force)) depends = spring->damping_N_s_per_m != 0;
    if (const auto* lorentz = std::get_if<Lorentz>(&force)) {
      const bool magnetic = lorentz->magnetic_T != Real3{};
      motion.magnetic = motion.magnetic || magnetic;
      depends = magnetic;
    }
    motion.velocity_dependent = motion.velocity_dependent || depends;
    const bool pushed = std::holds_alternative<Drive>(force) || std::holds_alternative<Thruster>(force) ||
                        std::holds_alternative<PointForce>(force);
    if (depends || pushed) motion.conservative = false;
  }
  for (const JointForce& force : scene.joint_forces) {
    const auto* spring = std::get_if<JointSpring>(&force);
    const bool damps = spring != nullptr && spring->damping != 0;
    motion.velocity_dependent = motion.velocity_dependent || damps;
    if (damps || spring == nullptr) motion.conservative = false;
  }
  for (const Joint& joint : scene.joints)
    if (joint.driven_rate || (joint.limits && joint.limits->restitution != 1)) motion.conservative = false;
  return motion;
}

std::string class_words(const MotionClass& motion) {
  if (motion.bare) return "a bare system of equations";
  if (motion.fluids) return "fluids";
  if (motion.mechanism) {
    std::string words = "a mechanism of joints";
    if (motion.contacts) words += ", contacts";
    if (motion.velocity_dependent) words += ", velocity-dependent forces";
    return words + (motion.conservative ? ", conservative" : "");
  }
  std::string words = motion.contacts ? "contacts" : motion.rotates ? "rotation" : "point masses";
  if (motion.contacts && motion.rotates) words += ", rotation";
  if (motion.velocity_dependent) words += ", velocity-dependent forces";
  return words + (motion.conservative ? ", conservative" : "");
}

namespace {

// Ours for fluids: the orders in space that the engine has, its settings for free surfaces, and a cheaper scheme in
// time.
const std::vector<std::string>& fluid_ids() {
  static const std::vector<std::string> ids{"atwood/rk4+polynomial{degree=4}",
                                            "atwood/rk4+sph",
                                            "atwood/rk4+polynomial{degree=2}",
                                            "atwood/rk4+polynomial{degree=2,filter=1,smoothing=1.8}",
                                            "atwood/rk4+sph{kernel=wendland-c4,smoothing=1.6}",
                                            "atwood/leapfrog+sph{density=summation,viscosity=none}"};
  return ids;
}

Candidates fluid_candidates(const std::vector<Worker>& workers, std::size_t own_engines) {
  Candidates chosen;
  std::string without;
  const auto take = [&](const Worker& worker) {
    if (worker.status != Status::ok) {
      chosen.left_out.emplace_back(to_string(worker.status) + ": " + worker.reason,
                                   std::filesystem::path(worker.path).filename().string());
    } else if (!worker.engine.fluids) {
      without += (without.empty() ? "" : ", ") + worker.engine.name;
    } else if (worker.engine.name != "atwood") {
      for (const MethodInfo& info : worker.engine.methods) chosen.ids.push_back(info.id);
    } else {
      chosen.ids.insert(chosen.ids.end(), fluid_ids().begin(), fluid_ids().end());
    }
  };
  for (std::size_t i = workers.size() - own_engines; i < workers.size(); ++i) take(workers[i]);
  for (std::size_t i = 0; i + own_engines < workers.size(); ++i) take(workers[i]);
  if (!without.empty()) chosen.left_out.emplace_back("simulates no fluids", without);
  chosen.left_out.emplace_back("other schemes and settings of ours: not tried unless --method names them",
                               "atwood/SCHEME+sph{...}, atwood/SCHEME+polynomial{...}");
  take_turns(chosen, chosen.ids.size());
  return chosen;
}

}  // namespace

Candidates choose_candidates(const Scene& scene, const std::vector<Worker>& workers, std::size_t own_engines) {
  const MotionClass motion = classify(scene);
  if (motion.fluids) return fluid_candidates(workers, own_engines);
  Candidates chosen;
  std::map<std::string, std::string> out;
  std::set<std::string> known;  // ids without suffixes that are tried or told about
  std::set<std::string> taken;  // ids with theirs that are tried
  const auto leave = [&](const std::string& reason, const std::string& id) {
    out[reason] += (out[reason].empty() ? "" : ", ") + id;
  };
  // Engines that take no joints would refuse the scene by each of their methods.
  const auto serves = [&](const Worker& worker) {
    return worker.status == Status::ok && (!motion.mechanism || worker.engine.joints);
  };
  const auto consider = [&](const MethodInfo& info, const std::string& suffix) {
    const std::string missing = missing_claim(info, motion);
    if (missing.empty()) chosen.ids.push_back(info.id + suffix), taken.insert(info.id + suffix);
    else leave(missing, info.id);
    known.insert(info.id);
  };
  for (std::size_t i = workers.size() - own_engines; i < workers.size(); ++i) {
    if (!serves(workers[i])) continue;
    for (const MethodInfo& info : workers[i].engine.methods) {
      chosen.ids.push_back(info.id);
      known.insert(info.id);
    }
  }
  for (const std::string& pattern : first_ids(motion, scene)) {
    const std::string base = base_of(pattern);
    for (const Worker& worker : workers) {
      if (!serves(worker)) continue;
      for (const MethodInfo& info : worker.engine.methods) {
        const std::string suffix = pattern.substr(base.size());
        const bool again = (known.contains(info.id) && base == pattern) || taken.contains(info.id + suffix);
        if (glob_match(base, info.id) && !again) consider(info, suffix);
      }
    }
  }
  const std::size_t short_list = chosen.ids.size();
  for (const Worker& worker : workers) {
    if (worker.status != Status::ok) {
      leave(to_string(worker.status) + ": " + worker.reason, std::filesystem::path(worker.path).filename().string());
      continue;
    }
    if (!serves(worker)) {
      leave("takes no joints", worker.engine.name);
      continue;
    }
    const bool ours = worker.engine.name == "atwood";
    for (const MethodInfo& info : worker.engine.methods) {
      if (known.contains(info.id)) continue;
      consider(info, ours && motion.contacts ? "+event" : "");
    }
  }
  for (const auto& [reason, ids] : out) chosen.left_out.emplace_back(reason, ids);
  take_turns(chosen, short_list);
  return chosen;
}

Candidates at_same_rate(const Candidates& candidates, const std::vector<Worker>& workers) {
  Candidates same;
  same.left_out = candidates.left_out;
  std::string own;
  for (std::size_t i = 0; i < candidates.ids.size(); ++i) {
    const std::string& id = candidates.ids[i];
    const std::string kept = is_library(engine_of(id)) ? id : same_rate_twin(id, workers);
    if (kept.empty()) {
      own += (own.empty() ? "" : ", ") + id;
      continue;
    }
    same.ids.push_back(kept);
    if (i < candidates.firsts) ++same.firsts;
    if (i < candidates.short_list) ++same.short_list;
  }
  same.firsts = std::max<std::size_t>(same.firsts, 1);
  if (!own.empty()) same.left_out.emplace_back("--same-rate: evaluates only its own rate", own);
  return same;
}

Candidates named_candidates(const std::vector<std::string>& methods, const std::vector<Worker>& workers) {
  Candidates chosen;
  std::vector<std::string> ids;
  for (const Worker& worker : workers) {
    for (const MethodInfo& info : worker.engine.methods) ids.push_back(info.id);
  }
  for (const std::string& method : methods) {
    const std::string base = base_of(method);
    const std::size_t before = chosen.ids.size();
    for (const std::string& id : ids) {
      if (glob_match(base, id)) chosen.ids.push_back(id + method.substr(base.size()));
    }
    if (chosen.ids.size() == before) refuse_unknown_method("--method ", method, workers);
    check_settings("--method ", method, workers);
  }
  take_turns(chosen, chosen.ids.size());
  return chosen;
}

// ---- a truth for a scene that has none ----------------------------------------------------------------------------
namespace {

// Two runs of one method, the finer at twice the steps: the finer is the value, their difference times the safety
// factor of the grid convergence index (Roache 1994) the bar; the method's order makes its true error smaller than
// that.
struct SelfConvergence {
  std::string method;
  std::int64_t steps = 0;
  Recording coarse, fine;
};

constexpr double kRoache = 1.25;

void append_sample(std::string& text, const Scene& scene, const SampleView& coarse, const SampleView& fine) {
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const BodySample &c = coarse.bodies[b], &f = fine.bodies[b];
    text += format_number(fine.t_s, 36) + "," + scene.bodies[b].name;
    const auto group = [&](const auto& x, const auto& y) {  // a vector shares one bar: its largest difference
      double bar = 0;
      for (std::size_t i = 0; i < x.size(); ++i) bar = std::max(bar, std::fabs(static_cast<double>(x[i] - y[i])));
      for (std::size_t i = 0; i < x.size(); ++i)
        text += "," + format_number(x[i], 36) + "," + format_double(kRoache * bar);
    };
    group(f.p_m, c.p_m);
    group(f.q_wxyz, c.q_wxyz);
    group(f.v_m_per_s, c.v_m_per_s);
    group(f.w_rad_per_s, c.w_rad_per_s);
    text += "\n";
  }
}

std::string values_file(const Scene& scene, const SelfConvergence& runs) {
  std::string text = fmt::format("# source: {} at {} and {} steps\nt_s,body", runs.method, runs.steps, 2 * runs.steps);
  for (const char* column : {"px_m", "py_m", "pz_m", "qw", "qx", "qy", "qz", "vx_m_per_s", "vy_m_per_s", "vz_m_per_s",
                             "wx_rad_per_s", "wy_rad_per_s", "wz_rad_per_s"}) {
    text += fmt::format(",{0},{0}_bar", column);
  }
  text += "\n";
  for (std::size_t k = 0; k < runs.fine.values.size(); ++k)
    append_sample(text, scene, runs.coarse.values[k], runs.fine.values[k]);
  return text;
}

double largest_difference(const SelfConvergence& runs) {
  double largest = 0;
  for (std::size_t k = 0; k < runs.fine.values.size(); ++k) {
    for (std::size_t b = 0; b < runs.fine.values[k].bodies.size(); ++b) {
      largest = std::max(largest, position_error_m(runs.coarse.values[k].bodies[b], runs.fine.values[k].bodies[b]));
    }
  }
  return std::isfinite(largest) ? largest : INFINITY;
}

// Refines as long as the difference decreases.
std::optional<SelfConvergence> converge(const Scenario& scenario, const std::string& method, const Worker& worker,
                                        double limit_s) {
  std::optional<SelfConvergence> best;
  Recording last;
  std::int64_t steps = scenario.steps.empty() ? scenario.samples : scenario.steps.front();
  for (int rung = 0; rung < 14; ++rung, steps *= 2) {
    Recording run = run_once(worker, method, scenario.scene, {scenario.t_end_s, steps, scenario.samples}, limit_s);
    if (run.outcome.status != Status::ok) {
      if (best || run.outcome.status == Status::unsupported || run.outcome.status == Status::timeout) break;
      last = {};
      continue;
    }
    if (!last.values.empty() && last.values.size() == run.values.size()) {
      SelfConvergence now{method, steps / 2, last, run};
      if (best && largest_difference(now) > 0.7 * largest_difference(*best)) break;
      best = now;
    }
    last = std::move(run);
  }
  return best;
}

}  // namespace

AdviceTruth find_truth(const Place& place, const Scenario& scenario, const std::vector<Worker>& workers,
                       const Candidates& candidates, const std::string& folder, double limit_s) {
  AdviceTruth found{scenario, ""};
  std::string why;
  for (const TruthKind kind : {TruthKind::extended, TruthKind::cvode}) {
    if (kind == scenario.truth.kind) continue;
    found.scenario.truth = {kind, "", ""};
    const Truth truth = truth_once(place.truth_worker, found.scenario, scenario.samples, limit_s);
    if (truth.outcome.status == Status::ok) {
      found.words = kind == TruthKind::extended
                        ? "extended precision by two methods (the scene names no truth that could be had)"
                        : "CVODE, two methods and two tolerances (the scene names no truth that could be had)";
      return found;
    }
    why += (why.empty() ? "" : "; ") + truth.outcome.reason;
  }
  for (const char* scheme : {"verner8", "dop853", "verner6", "dopri5", "rk4"}) {
    for (const std::string& id : candidates.ids) {
      const std::string base = base_of(id);
      if (base != std::string("atwood/") + scheme) continue;
      const std::size_t plus = id.find('+');
      const std::string method = base + (plus == std::string::npos ? "" : id.substr(plus));
      for (const Worker& worker : workers) {
        if (worker.status != Status::ok || worker.engine.name != "atwood") continue;
        const auto runs = converge(scenario, method, worker, limit_s / 10);
        if (!runs) continue;
        const std::string path = std::filesystem::absolute(folder).string() + "/advise-" + scenario.id + "-values.csv";
        write_file(path, values_file(scenario.scene, *runs));
        found.scenario.truth = {TruthKind::values, "", path};
        found.words = fmt::format(
            "none: self-convergence of {} at {} and {} steps (positions {:.2g} m apart). An error that all runs share "
            "does not show",
            method, runs->steps, 2 * runs->steps, largest_difference(*runs));
        return found;
      }
    }
  }
  throw InputError(fmt::format("advise: `{}` has no truth, and none could be computed: {}", scenario.id, why));
}

}  // namespace atwood
