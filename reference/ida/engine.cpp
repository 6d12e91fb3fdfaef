#include "ida/ida.hpp"

#include "ida/solver.hpp"
#include "sundials/sundials.hpp"

namespace atwood {

namespace {

MethodInfo info() {
  MethodInfo made;
  made.id = "ida/bdf";
  made.doc = "IDA's backward differentiation formulas of order 1 to 5, variable step and order, on y' - f(t, y) = 0.";
  made.source = "Hindmarsh et al., SUNDIALS, ACM Trans. Math. Softw. 31 (2005) 363";
  made.adaptive = true;
  made.settings["rtol"] = 1e-10;
  made.settings["atol"] = std::string("rtol / 100");
  made.settings["max_order"] = std::int64_t(5);
  made.settings["max_steps"] = std::int64_t(2000000);
  made.settings["nonlinear_solver"] = std::string("Newton");
  made.settings["linear_solver"] = std::string("dense, difference-quotient Jacobian");
  made.settings["first_derivative"] = std::string("f(0, y0), exact");
  made.settings["sampling"] = std::string("stop time at each sample; no interpolation");
  return made;
}

std::string read_options(const MethodId& id, ida::Options& options) {
  if (id.scheme != "bdf") return "ida has no scheme `" + id.scheme + "`; it has bdf";
  if (!id.scalar.empty() && id.scalar != "double") return "ida runs in double, not " + id.scalar;
  if (!id.response.empty()) return "ida does not support contacts; found +" + id.response;
  options.rtol = id.rtol.value_or(1e-10);
  options.atol = id.atol.value_or(options.rtol / 100);
  for (const auto& [key, value] : id.overrides) {
    const auto* number = std::get_if<std::int64_t>(&value);
    if (key == "max_order" && number && *number >= 1 && *number <= 5) options.max_order = static_cast<int>(*number);
    else if (key == "max_steps" && number && *number >= 1) options.max_steps = *number;
    else
      return "ida does not accept this value of the setting `" + key +
             "`, or does not have it; expected max_order (1 to 5) or max_steps";
  }
  return "";
}

Outcome run_method(const MethodId& id, const Scene& scene, const Plan& plan, const Observer& observer, int repeats) {
  ida::Options options;
  if (const std::string why = read_options(id, options); !why.empty()) return stepping::refusal(why);
  return stepping::run<double>("ida", scene, plan, observer, repeats, true,
                               [&](const stepping::Equations<double>& equations, const std::vector<double>& y, double) {
                                 return ida::make_solver(options, equations, y);
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
  return engine;
}

}  // namespace atwood
