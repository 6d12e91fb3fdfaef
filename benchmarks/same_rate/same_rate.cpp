#include "benchmarks/same_rate/same_rate.hpp"

#include <memory>

#include "integrators/adaptive.hpp"
#include "integrators/catalogue.hpp"
#include "math/scalar.hpp"
#include "protocol/printed_setting.hpp"
#include "protocol/refusal.hpp"
#include "stepping/stepping.hpp"
#include "version.hpp"

namespace atwood {
namespace {

constexpr const char* kName = "atwood-same-rate";

template <class S> System<S> system_of(const stepping::Equations<S>& equations) {
  System<S> system;
  system.size = equations.size;
  system.context = const_cast<stepping::Equations<S>*>(&equations);  // the rate is only called
  system.rate_of = [](void* context, S t_s, const S* y, S* dydt) {
    static_cast<const stepping::Equations<S>*>(context)->rate(t_s, y, dydt);
  };
  return system;
}

struct Tolerance {
  double rtol = 0, atol = 0;
};

// Our stepper behind the interface by which reference/stepping calls those of libraries.
template <class S> class Joined : public stepping::Stepper<S> {
 public:
  Joined(const MethodId& id, const Scene& scene, const stepping::Equations<S>& equations, S h_s,
         const StepLimits& limits)
      : system_(system_of(equations)), y_new_(static_cast<std::size_t>(equations.size)), guess_s_(h_s),
        limits_(limits) {
    if (const std::string why = RigidModel<S>(scene).unsupported(); !why.empty())
      throw stepping::Failure(Status::unsupported, why);
    Result<std::unique_ptr<atwood::Stepper<S>>> stepper = make_stepper(id.scheme, system_, id.overrides);
    if (!stepper) throw stepping::Failure(Status::unsupported, stepper.fault().reason);
    stepper_ = std::move(*stepper);
    if (!id.rtol) return;
    tolerance_ = {*id.rtol, id.atol.value_or(*id.rtol / 100)};
    stepper_->set_tolerance(S(tolerance_.rtol), S(tolerance_.atol));
    control_ = std::make_unique<StepControl<S>>(stepper_->estimate_order(), limits_);
  }

  void step(S t_s, S h_s, std::vector<S>& y) override {
    if (!stepper_->step(t_s, h_s, y.data(), y_new_.data())) fail_unsolved(t_s);
    y.swap(y_new_);
  }

  // The engine's adaptive run (smooth/run.cpp) without dense output: the last step is shortened to end at `to_s`.
  std::int64_t advance(S t_s, S to_s, std::vector<S>& y) override {
    std::int64_t steps = 0;
    bool unsolved = false;
    while (t_s < to_s) {
      const bool last = t_s + guess_s_ * S(1.0000001) >= to_s;
      const S step_s = last ? to_s - t_s : guess_s_;
      if (!(step_s > S(4) * real::epsilon<S>() * t_s)) {
        if (unsolved) fail_unsolved(t_s);
        throw stepping::Failure(Status::diverged, "the step size fell to nothing at t = " + at(t_s));
      }
      if (!stepper_->step(t_s, step_s, y.data(), y_new_.data())) {  // a shorter step's equations may converge
        guess_s_ = step_s / S(4);
        unsolved = true;
        continue;
      }
      unsolved = false;
      const auto [accepted, next_s] = judge(step_s);
      if (!accepted) {
        guess_s_ = next_s;
        continue;
      }
      guess_s_ = last ? real::max(guess_s_, next_s) : next_s;  // a shortened last step does not reduce the guess
      y.swap(y_new_);
      t_s = last ? to_s : t_s + step_s;
      ++steps;
    }
    return steps;
  }

 private:
  static std::string at(S t_s) { return format_double(static_cast<double>(t_s)) + " s"; }
  [[noreturn]] static void fail_unsolved(S t_s) {
    throw stepping::Failure(Status::diverged,
                            "the implicit equations of the step at t = " + at(t_s) + " were not solved");
  }
  typename atwood::Stepper<S>::Advice judge(S h_s) {
    if (stepper_->chooses_steps()) return stepper_->advise(S(tolerance_.rtol), S(tolerance_.atol));
    const S next_s = control_->next_step(h_s, stepper_->error_norm(S(tolerance_.rtol), S(tolerance_.atol)));
    return {control_->accepted(), next_s};
  }

  System<S> system_;
  std::unique_ptr<atwood::Stepper<S>> stepper_;
  std::vector<S> y_new_;
  S guess_s_;
  StepLimits limits_;
  Tolerance tolerance_;
  std::unique_ptr<StepControl<S>> control_;
};

double number_or(const Settings& settings, const char* name, double otherwise) {
  const auto found = settings.find(name);
  return found == settings.end() ? otherwise : std::get<double>(found->second);
}

StepLimits limits_of(const Settings& settings) {
  const StepLimits standard;
  return {number_or(settings, "safety", standard.safety), number_or(settings, "beta", standard.beta),
          number_or(settings, "least_factor", standard.least), number_or(settings, "most_factor", standard.most)};
}

template <class S>
Outcome run_in(const MethodId& id, const Scene& scene, const Plan& plan, const Observer& observer, int repeats,
               int rate_repeats, const StepLimits& limits) {
  return stepping::run<S>(
      kName, scene, plan, observer, repeats, id.rtol.has_value(),
      [&](const stepping::Equations<S>& equations, const std::vector<S>&, S h_s) {
        return std::make_unique<Joined<S>>(id, scene, equations, h_s, limits);
      },
      rate_repeats);
}

// Whether the method steps a bare system of equations. Radau 15 and generalised alpha do, but are other methods with a
// model, which says what unknowns are positions; they are excluded here.
bool takes_a_bare_rate(const std::string& scheme) {
  for (const char* other : {"radau15", "ias15", "generalised-alpha", "generalized-alpha"})
    if (scheme == other) return false;
  System<double> system;
  system.size = 1;
  return static_cast<bool>(make_stepper(scheme, system));
}

MethodInfo described(const MethodInfo& info) {
  MethodInfo made = info;
  made.id = std::string(kName) + info.id.substr(info.id.find('/'));
  made.doc = info.id + " on the reference's rate, as libraries evaluate it. " + info.doc;
  for (const char* of_the_model : {"gravity", "opening", "threads"})
    made.settings.erase(of_the_model), made.rules.erase(of_the_model);
  declare_settings(made, {printed("rate", std::string("the reference's")), stepping::rate_repeats_setting(),
                          printed("quaternion_normalised", false)});
  return made;
}

Outcome run(const MethodId& asked, const Scene& scene, const Plan& plan, const Observer& observer, int repeats) {
  MethodId id = asked;
  const MethodInfo* info = find_integrator(id.scheme);
  if (info != nullptr && !takes_a_bare_rate(id.scheme))
    return refused(info->id + " needs more than a rate: it is not offered at the reference's");
  if (info == nullptr) return refused(std::string(kName) + " has no method `" + id.scheme + "`");
  if (id.rtol && !info->adaptive) return refused(asked.engine + "/" + id.scheme + " takes equal steps, no tolerance");
  if (id.rtol && !(*id.rtol > 0)) return refused("a tolerance must be above 0");
  if (!id.response.empty()) return refused(std::string(kName) + " has no contacts: no +" + id.response);
  const Result<Settings> settings = merged_settings(described(*info), id.overrides);
  if (!settings) return refused(settings.fault().reason);
  const int rate_repeats = stepping::rate_repeats(*settings);
  id.overrides.erase("rate_repeats");
  const StepLimits limits = limits_of(*settings);
  if (id.scalar == "long-double") return run_in<long double>(id, scene, plan, observer, repeats, rate_repeats, limits);
  if (!id.scalar.empty() && id.scalar != "double")
    return refused(std::string(kName) + " runs in double and long-double, not " + id.scalar);
  return run_in<double>(id, scene, plan, observer, repeats, rate_repeats, limits);
}

}  // namespace

Engine same_rate_engine() {
  Engine engine;
  engine.name = kName;
  engine.version = kVersion;
  engine.scalar = "double";
  const std::string own = "atwood/";
  for (const MethodInfo& info : integrator_catalogue()) {
    const std::string scheme = info.id.substr(own.size());
    if (!takes_a_bare_rate(scheme)) continue;
    engine.methods.push_back(described(info));
  }
  engine.run = run;
  return engine;
}

}  // namespace atwood
