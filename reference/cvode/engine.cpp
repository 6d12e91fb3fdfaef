#include <chrono>

#include "cvode/cvode.hpp"
#include "cvode/run.hpp"

namespace atwood {

namespace {

Settings settings(bool adams) {
  Settings all;
  all["rtol"] = 1e-10;
  all["atol"] = std::string("rtol / 100");
  all["linear_multistep"] = std::string(adams ? "Adams-Moulton, variable order" : "BDF, variable order");
  all["max_order"] = std::int64_t(adams ? 12 : 5);
  all["max_steps"] = std::int64_t(2000000);
  all["nonlinear_solver"] = std::string(adams ? "fixed point" : "Newton");
  all["linear_solver"] = std::string(adams ? "none" : "dense, difference-quotient Jacobian");
  all["first_step"] = std::string("CVODE's estimate");
  all["impacts"] = std::string("root functions, restart");
  all["quaternion_normalised"] = false;
  all["rate"] = std::string("the reference's");
  all["rate_repeats"] = std::int64_t(1);
  return all;
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
  made.settings = settings(adams);
  return made;
}

Outcome refusal(const std::string& reason) {
  Outcome made;
  made.status = Status::unsupported;
  made.reason = reason;
  return made;
}

std::string read_options(const MethodId& id, cvode::Options& options) {
  if (id.scheme != "adams" && id.scheme != "bdf")
    return "cvode has no scheme `" + id.scheme + "`; expected adams or bdf";
  if (!id.scalar.empty() && id.scalar != "double")
    return "cvode computes in double; found the scalar `" + id.scalar + "`";
  if (!id.response.empty() && id.response != "event") return "cvode locates impacts (+event); found +" + id.response;
  options.family = id.scheme == "adams" ? cvode::Family::adams : cvode::Family::bdf;
  const int highest = id.scheme == "adams" ? 12 : 5;
  options.max_order = highest;
  options.rtol = id.rtol.value_or(1e-10);
  options.atol = id.atol.value_or(options.rtol / 100);
  if (!(options.rtol > 0) || !(options.atol >= 0))
    return "cvode: expected rtol > 0 and atol >= 0; found " + format_double(options.rtol) + " and " +
           format_double(options.atol);
  for (const auto& [key, value] : id.overrides) {
    const auto* number = std::get_if<std::int64_t>(&value);
    if (key == "max_order" && number && *number >= 1 && *number <= highest)
      options.max_order = static_cast<int>(*number);
    else if (key == "max_steps" && number && *number >= 1) options.max_steps = *number;
    else if (key == "rate_repeats" && number && *number >= 1 && *number <= 1000)
      options.rate_repeats = static_cast<int>(*number);
    else
      return "cvode does not accept this value of the setting `" + key +
             "`, or does not have it; expected max_order (1 to " + std::to_string(highest) +
             "), max_steps (at least 1) or rate_repeats (1 to 1000)";
  }
  return "";
}

Outcome run_method(const MethodId& id, const Scene& scene, const Plan& plan, const Observer& observer, int repeats) {
  cvode::Options options;
  if (const std::string why = read_options(id, options); !why.empty()) return refusal(why);
  if (repeats <= 0) return cvode::run(scene, plan.t_end_s, plan.samples, options, observer);
  Outcome outcome;
  std::vector<std::int64_t> busy_ns;
  for (int k = 0; k <= repeats; ++k) {  // the first run is a warm-up and is not timed
    std::chrono::nanoseconds busy{};
    outcome = cvode::run(scene, plan.t_end_s, plan.samples, options, {}, nullptr, &busy);
    if (outcome.status != Status::ok) break;
    if (k > 0) busy_ns.push_back(busy.count());
  }
  outcome.busy_ns = busy_ns;
  return outcome;
}

}  // namespace

Engine cvode_engine() {
  Engine engine;
  engine.name = "cvode";
  engine.version = cvode::version();
  engine.scalar = "double";
  engine.methods = {info(true), info(false)};
  engine.run = run_method;
  engine.frames = true;  // its steps do not depend on the frames
  return engine;
}

}  // namespace atwood
