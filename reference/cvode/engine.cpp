#include "cvode/cvode.hpp"
#include "cvode/mechanism.hpp"
#include "cvode/run.hpp"
#include "protocol/printed_setting.hpp"
#include "protocol/refusal.hpp"
#include "protocol/timed_passes.hpp"

namespace atwood {

namespace {

std::vector<Setting> settings(bool adams) {
  const int highest = adams ? 12 : 5;
  return {printed("rtol", 1e-10, "Relative tolerance where the id has none."),
          printed("atol", std::string("rtol / 100")),
          printed("linear_multistep", std::string(adams ? "Adams-Moulton, variable order" : "BDF, variable order")),
          {"max_order", std::int64_t(highest), {between(1, highest), "Highest order."}},
          {"max_steps", std::int64_t(2000000), {between(1, 1e12), "Most steps of a run."}},
          printed("nonlinear_solver", std::string(adams ? "fixed point" : "Newton")),
          printed("linear_solver", std::string(adams ? "none" : "dense, difference-quotient Jacobian")),
          printed("first_step", std::string("CVODE's estimate")),
          printed("impacts", std::string("root functions, restart")),
          printed("quaternion_normalised", false),
          printed("rate", std::string("the reference's")),
          {"rate_repeats", std::int64_t(1), {between(1, 1000), "How often each rate is evaluated; it counts once."}}};
}

MethodInfo info(bool adams) {
  MethodInfo made;
  made.id = adams ? "cvode/adams" : "cvode/bdf";
  made.doc = adams
                 ? "CVODE's Adams-Moulton methods of order 1 to 12 with functional iteration, variable step and order."
                 : "CVODE's backward differentiation formulas of order 1 to 5 with Newton iteration, variable step and "
                   "order.";
  made.source = "Hindmarsh et al., SUNDIALS, ACM Trans. Math. Softw. 31 (2005) 363";
  made.adaptive = true;
  declare_settings(made, settings(adams));
  return made;
}

Result<cvode::Options> read_options(const MethodId& id) {
  const auto input = [](const std::string& why) { return Fault{why}; };
  cvode::Options options;
  if (id.scheme != "adams" && id.scheme != "bdf")
    return input("cvode has no scheme `" + id.scheme + "`; expected adams or bdf");
  if (!id.scalar.empty() && id.scalar != "double")
    return input("cvode computes in double; found the scalar `" + id.scalar + "`");
  if (!id.response.empty() && id.response != "event")
    return input("cvode locates impacts (+event); found +" + id.response);
  options.family = id.scheme == "adams" ? cvode::Family::adams : cvode::Family::bdf;
  options.rtol = id.rtol.value_or(1e-10);
  options.atol = id.atol.value_or(options.rtol / 100);
  if (!(options.rtol > 0) || !(options.atol >= 0))
    return input("cvode: expected rtol > 0 and atol >= 0; found " + format_double(options.rtol) + " and " +
                 format_double(options.atol));
  const Result<Settings> settings = merged_settings(info(id.scheme == "adams"), id.overrides);
  if (!settings) return settings.fault();
  options.max_order = static_cast<int>(std::get<std::int64_t>(settings->at("max_order")));
  options.max_steps = std::get<std::int64_t>(settings->at("max_steps"));
  options.rate_repeats = static_cast<int>(std::get<std::int64_t>(settings->at("rate_repeats")));
  return options;
}

Outcome run_method(const MethodId& id, const Scene& scene, const Plan& plan, const Observer& observer, int repeats) {
  const auto options = read_options(id);
  if (!options) return refused(options.fault());
  if (!scene.joints.empty() || !scene.ropes.empty()) {
    if (repeats <= 0) return cvode::run_mechanism(scene, plan.t_end_s, plan.samples, *options, observer);
    return timed_passes(repeats, [&](std::chrono::nanoseconds& busy) {
      return cvode::run_mechanism(scene, plan.t_end_s, plan.samples, *options, {}, &busy);
    });
  }
  if (repeats <= 0) return cvode::run(scene, plan.t_end_s, plan.samples, *options, observer);
  return timed_passes(repeats, [&](std::chrono::nanoseconds& busy) {
    return cvode::run(scene, plan.t_end_s, plan.samples, *options, {}, nullptr, &busy);
  });
}

}  // namespace

Engine cvode_engine() {
  Engine engine;
  engine.name = "cvode";
  engine.version = cvode::version();
  engine.scalar = "double";
  engine.methods = {info(true), info(false)};
  engine.run = run_method;
  engine.joints = true;  // trees of joints
  engine.frames = true;  // its steps do not depend on the frames
  return engine;
}

}  // namespace atwood
