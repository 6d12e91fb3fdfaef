#include <algorithm>

#include "arkode/arkode.hpp"
#include "arkode/solver.hpp"
#include "protocol/printed_setting.hpp"
#include "protocol/refusal.hpp"
#include "sundials/sundials.hpp"

namespace atwood {

namespace {

using arkode::Module;
using arkode::Scheme;

bool is_implicit(const Scheme& scheme) {
  return scheme.module == Module::arkstep_implicit || scheme.module == Module::arkstep_imex;
}

std::vector<Setting> settings(const Scheme& scheme) {
  std::vector<Setting> all;
  if (!scheme.explicit_table.empty()) all.push_back(printed("explicit_table", scheme.explicit_table));
  if (!scheme.implicit_table.empty()) all.push_back(printed("implicit_table", scheme.implicit_table));
  for (const Setting& setting :
       {printed("module", std::string(scheme.module == Module::erkstep ? "ERKStep" : "ARKStep")),
        printed("table_order", std::int64_t(scheme.q)), printed("table_embedding_order", std::int64_t(scheme.p)),
        printed("table_stages", std::int64_t(scheme.stages)),
        printed("table_order_by_its_coefficients", std::int64_t(scheme.checked_order),
                "The library's check ends at 6."),
        printed("table_last_node_is_one", scheme.last_node_is_one),
        printed("table_first_same_as_last", scheme.first_same_as_last),
        Setting{"max_steps", std::int64_t(2000000), {between(1, 1e12), "Most steps of a run."}},
        printed("rate", std::string("the reference's")), stepping::rate_repeats_setting(),
        printed("sampling",
                std::string("whole steps (equal steps), stop time at each sample (tolerance); no interpolation")),
        printed("adaptivity", std::string("ARKODE's default controller, used only with a tolerance"))})
    all.push_back(setting);
  if (!is_implicit(scheme)) return all;
  for (const Setting& setting :
       {printed("nonlinear_solver", std::string("Newton")),
        Setting{"nonlinear_coefficient", 0.1, {{0, 1, true, false}, "Factor of the nonlinear solver's stopping test."}},
        Setting{
            "nonlinear_iterations",
            std::int64_t(0),
            {between(0, 1000), "Most iterations of a solve; 0: 20 at equal steps, ARKODE's default (3) otherwise."}},
        Setting{"nonlinear_crdown",
                0.3,
                {{0, 1, true, false}, "How fast the estimated rate of convergence forgets the last solve's."}},
        printed("nonlinear_weights",
                std::string("rtol 1e-13, atol 1e-15 at equal steps; the asked tolerance otherwise")),
        printed("newton_matrix", std::string("set up every step at equal steps; ARKODE's default otherwise")),
        printed("linear_solver", std::string("dense, difference-quotient Jacobian")),
        printed("predictor", std::string("trivial"))})
    all.push_back(setting);
  if (scheme.module == Module::arkstep_imex)
    all.push_back(
        printed("split", std::string("positions (bare problem: even components) explicit, velocities (odd) implicit")));
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
  declare_settings(made, settings(scheme));
  return made;
}

Result<arkode::Options> read_options(const MethodId& id) {
  const auto input = [](const std::string& why) { return Fault{why}; };
  arkode::Options options;
  const auto& all = arkode::schemes();
  const auto found = std::find_if(all.begin(), all.end(),
                                  [&](const Scheme& s) { return to_string(s.module) + "/" + s.name == id.scheme; });
  if (found == all.end())
    return input("arkode has no scheme `" + id.scheme + "`; expected one of its tables (`atwood list methods`)");
  options.scheme = *found;
  if (!id.scalar.empty() && id.scalar != "double")
    return input("arkode computes in double; found the scalar `" + id.scalar + "`");
  if (!id.response.empty()) return input("arkode does not support contacts; found +" + id.response);
  options.by_tolerance = id.rtol.has_value();
  if (options.by_tolerance && found->p == 0)
    return input("arkode: the table " + found->name +
                 " has no embedded method: expected equal steps without a tolerance");
  options.rtol = id.rtol.value_or(arkode::kFixedRtol);
  options.atol = id.atol.value_or(options.by_tolerance ? options.rtol / 100 : arkode::kFixedAtol);
  const Result<Settings> settings = merged_settings(info(*found), id.overrides);
  if (!settings) return settings.fault();
  options.max_steps = std::get<std::int64_t>(settings->at("max_steps"));
  options.rate_repeats = stepping::rate_repeats(*settings);
  if (!is_implicit(*found)) return options;
  options.nonlinear_iterations = static_cast<int>(std::get<std::int64_t>(settings->at("nonlinear_iterations")));
  options.nonlinear_coefficient = std::get<double>(settings->at("nonlinear_coefficient"));
  options.nonlinear_crdown = std::get<double>(settings->at("nonlinear_crdown"));
  return options;
}

Outcome run_method(const MethodId& id, const Scene& scene, const Plan& plan, const Observer& observer, int repeats) {
  const auto options = read_options(id);
  if (!options) return refused(options.fault());
  return stepping::run<double>(
      "arkode", scene, plan, observer, repeats, options->by_tolerance,
      [&](const stepping::Equations<double>& equations, const std::vector<double>& y, double h_s) {
        return arkode::make_solver(*options, equations, y, h_s);
      },
      options->rate_repeats);
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
