#include "ida/ida.hpp"

#include "ida/mechanism.hpp"
#include "ida/solver.hpp"
#include "protocol/printed_setting.hpp"
#include "protocol/refusal.hpp"
#include "protocol/timed_passes.hpp"
#include "sundials/sundials.hpp"

namespace atwood {

namespace {

MethodInfo info() {
  MethodInfo made;
  made.id = "ida/bdf";
  made.doc =
      "IDA's backward differentiation formulas of order 1 to 5, variable step and order, on y' - f(t, y) = 0. "
      "Mechanisms: the index-2 form of Gear, Gupta and Leimkuhler in the coordinates of a spanning tree.";
  made.source = "Hindmarsh et al., SUNDIALS, ACM Trans. Math. Softw. 31 (2005) 363";
  made.adaptive = true;
  declare_settings(made, {printed("rtol", 1e-10, "Relative tolerance where the id has none."),
                          printed("atol", std::string("rtol / 100")),
                          {"max_order", std::int64_t(5), {between(1, 5), "Highest order."}},
                          {"max_steps", std::int64_t(2000000), {between(1, 1e12), "Most steps of a run."}},
                          printed("nonlinear_solver", std::string("Newton")),
                          printed("linear_solver", std::string("dense, difference-quotient Jacobian")),
                          printed("first_derivative", std::string("f(0, y0), exact")),
                          printed("multipliers_atol", 1e8, "Of the multipliers of loops and ropes."),
                          printed("sampling", std::string("stop time at each sample; no interpolation"))});
  return made;
}

Result<ida::Options> read_options(const MethodId& id) {
  const auto input = [](const std::string& why) { return Fault{why}; };
  ida::Options options;
  if (id.scheme != "bdf") return input("ida has no scheme `" + id.scheme + "`; it has bdf");
  if (!id.scalar.empty() && id.scalar != "double") return input("ida runs in double, not " + id.scalar);
  if (!id.response.empty()) return input("ida does not support contacts; found +" + id.response);
  options.rtol = id.rtol.value_or(1e-10);
  options.atol = id.atol.value_or(options.rtol / 100);
  const Result<Settings> settings = merged_settings(info(), id.overrides);
  if (!settings) return settings.fault();
  options.max_order = static_cast<int>(std::get<std::int64_t>(settings->at("max_order")));
  options.max_steps = std::get<std::int64_t>(settings->at("max_steps"));
  return options;
}

Outcome run_method(const MethodId& id, const Scene& scene, const Plan& plan, const Observer& observer, int repeats) {
  const auto options = read_options(id);
  if (!options) return refused(options.fault());
  if (!scene.joints.empty() || !scene.ropes.empty()) {
    if (repeats <= 0) return ida::run_mechanism(scene, plan.t_end_s, plan.samples, *options, observer);
    return timed_passes(repeats, [&](std::chrono::nanoseconds& busy) {
      return ida::run_mechanism(scene, plan.t_end_s, plan.samples, *options, {}, &busy);
    });
  }
  return stepping::run<double>("ida", scene, plan, observer, repeats, true,
                               [&](const stepping::Equations<double>& equations, const std::vector<double>& y, double) {
                                 return ida::make_solver(*options, equations, y);
                               });
}

}  // namespace

Engine ida_engine() {
  Engine engine;
  engine.name = "ida";
  engine.version = sundials::version();
  engine.scalar = "double";
  engine.methods = {info()};
  engine.run = run_method;
  engine.joints = true;
  return engine;
}

}  // namespace atwood
