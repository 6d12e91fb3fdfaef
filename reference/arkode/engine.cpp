#include <algorithm>

#include "arkode/arkode.hpp"
#include "arkode/solver.hpp"
#include "sundials/sundials.hpp"

namespace atwood {

namespace {

using arkode::Module;
using arkode::Scheme;

bool is_implicit(const Scheme& scheme) {
  return scheme.module == Module::arkstep_implicit || scheme.module == Module::arkstep_imex;
}

Settings settings(const Scheme& scheme) {
  Settings all;
  if (!scheme.explicit_table.empty()) all["explicit_table"] = scheme.explicit_table;
  if (!scheme.implicit_table.empty()) all["implicit_table"] = scheme.implicit_table;
  all["module"] = std::string(scheme.module == Module::erkstep ? "ERKStep" : "ARKStep");
  all["table_order"] = std::int64_t(scheme.q);
  all["table_embedding_order"] = std::int64_t(scheme.p);
  all["table_stages"] = std::int64_t(scheme.stages);
  all["table_order_by_its_coefficients"] = std::int64_t(scheme.checked_order);  // the library's check ends at 6
  all["table_last_node_is_one"] = scheme.last_node_is_one;
  all["table_first_same_as_last"] = scheme.first_same_as_last;
  all["max_steps"] = std::int64_t(2000000);
  all["rate"] = std::string("the reference's");
  all["rate_repeats"] = std::int64_t(1);
  all["sampling"] = std::string("whole steps (equal steps), stop time at each sample (tolerance); no interpolation");
  all["adaptivity"] = std::string("ARKODE's default controller, with a tolerance alone");
  if (!is_implicit(scheme)) return all;
  all["nonlinear_solver"] = std::string("Newton");
  all["nonlinear_coefficient"] = 0.1;
  all["nonlinear_iterations"] = std::string("20 at equal steps; ARKODE's default (3) otherwise");
  all["nonlinear_crdown"] = 0.3;
  all["nonlinear_weights"] = std::string("rtol 1e-13, atol 1e-15 at equal steps; the asked tolerance otherwise");
  all["newton_matrix"] = std::string("set up every step at equal steps; ARKODE's default otherwise");
  all["linear_solver"] = std::string("dense, difference-quotient Jacobian");
  all["predictor"] = std::string("trivial");
  if (scheme.module == Module::arkstep_imex)
    all["split"] = std::string("positions (bare problem: even components) explicit, velocities (odd) implicit");
  return all;
}

std::string doc(const Scheme& scheme) {
  const std::string table =
      scheme.name + ": " + std::to_string(scheme.stages) + " stages, order " + std::to_string(scheme.q) +
      (scheme.p > 0 ? " with an embedded method of order " + std::to_string(scheme.p) : ", no embedding");
  switch (scheme.module) {
    case Module::erkstep: return "ARKODE's ERKStep with its packaged explicit table " + table + ".";
    case Module::arkstep_explicit:
      return "ARKODE's ARKStep, all of the rate explicit, with its packaged explicit table " + table + ".";
    case Module::arkstep_implicit:
      return "ARKODE's ARKStep, all of the rate implicit, with its packaged diagonally implicit table " + table + ".";
    case Module::arkstep_imex: return "ARKODE's ARKStep with its packaged additive pair " + table + ".";
  }
  return "";
}

MethodInfo info(const Scheme& scheme) {
  MethodInfo made;
  made.id = "arkode/" + to_string(scheme.module) + "/" + scheme.name;
  made.doc = doc(scheme);
  made.source =
      "Reynolds, Gardner, Woodward and Chinomona, ARKODE, ACM Trans. Math. Softw. 49 (2023) 19; order: the table's q";
  made.adaptive = scheme.p > 0;
  for (const char* motion : {"point-mass", "velocity-dependent", "rotation"}) made.claimed_order[motion] = scheme.q;
  made.settings = settings(scheme);
  return made;
}

std::string read_options(const MethodId& id, arkode::Options& options) {
  const auto& all = arkode::schemes();
  const auto found = std::find_if(all.begin(), all.end(),
                                  [&](const Scheme& s) { return to_string(s.module) + "/" + s.name == id.scheme; });
  if (found == all.end())
    return "arkode has no scheme `" + id.scheme + "`; expected one of its tables (`atwood list methods`)";
  options.scheme = *found;
  if (!id.scalar.empty() && id.scalar != "double")
    return "arkode computes in double; found the scalar `" + id.scalar + "`";
  if (!id.response.empty()) return "arkode does not support contacts; found +" + id.response;
  options.by_tolerance = id.rtol.has_value();
  if (options.by_tolerance && found->p == 0)
    return "arkode: the table " + found->name + " has no embedded method: expected equal steps without a tolerance";
  options.rtol = id.rtol.value_or(arkode::kFixedRtol);
  options.atol = id.atol.value_or(options.by_tolerance ? options.rtol / 100 : arkode::kFixedAtol);
  for (const auto& [key, value] : id.overrides) {
    const auto* number = std::get_if<std::int64_t>(&value);
    const auto* real = std::get_if<double>(&value);
    if (key == "max_steps" && number && *number >= 1) options.max_steps = *number;
    else if (key == "nonlinear_iterations" && is_implicit(*found) && number && *number >= 1)
      options.nonlinear_iterations = static_cast<int>(*number);
    else if (key == "nonlinear_coefficient" && is_implicit(*found) && real && *real > 0)
      options.nonlinear_coefficient = *real;
    else if (key == "nonlinear_crdown" && is_implicit(*found) && real && *real > 0) options.nonlinear_crdown = *real;
    else
      return "arkode does not accept this value of the setting `" + key + "`, or does not have it; expected max_steps" +
             (is_implicit(*found) ? ", nonlinear_iterations, nonlinear_coefficient, nonlinear_crdown" : "");
  }
  return "";
}

Outcome run_method(const MethodId& asked, const Scene& scene, const Plan& plan, const Observer& observer, int repeats) {
  MethodId id = asked;
  int rate_repeats = 1;
  if (const std::string why = stepping::take_rate_repeats(id, rate_repeats); !why.empty())
    return stepping::refusal(why);
  arkode::Options options;
  if (const std::string why = read_options(id, options); !why.empty()) return stepping::refusal(why);
  return stepping::run<double>(
      "arkode", scene, plan, observer, repeats, options.by_tolerance,
      [&](const stepping::Equations<double>& equations, const std::vector<double>& y, double h_s) {
        return arkode::make_solver(options, equations, y, h_s);
      },
      rate_repeats);
}

}  // namespace

Engine arkode_engine() {
  Engine engine;
  engine.name = "arkode";
  engine.version = sundials::version();
  engine.scalar = "double";
  for (const Scheme& scheme : arkode::schemes()) engine.methods.push_back(info(scheme));
  engine.run = run_method;
  return engine;
}

}  // namespace atwood
