#include "integrators/catalogue.hpp"

#include <stdexcept>

#include "integrators/adaptive.hpp"
#include "integrators/families.hpp"
#include "integrators/formulas.hpp"

namespace atwood {

const std::string embedded_attitude =
    " A rotating body's quaternion is integrated as four numbers, q' = 1/2 q (0, w), beside Euler's equations in body "
    "axes, "
    "and normalised after each step, so that attitude keeps the order.";

std::map<std::string, double> claims_everywhere(double order) {
  return {{"point-mass", order}, {"velocity-dependent", order}, {"rotation", order}};
}

std::map<std::string, double> claims_in_any_coordinates(double order) {
  std::map<std::string, double> claims = claims_everywhere(order);
  claims["mechanism"] = claims["loop"] = order;  // loop: mechanisms with closing joints or ropes
  return claims;
}

MethodInfo fixed_step(const std::string& scheme, std::map<std::string, double> claims, const std::string& doc,
                      const std::string& source) {
  MethodInfo info{"atwood/" + scheme, doc, source, std::move(claims), false, {}};
  declare_settings(
      info,
      {{"scalar",
        std::string("double"),
        {one_of({"float", "double", "long-double", "quad"}), "Scalar type of the state; chosen by @ in the id."}},
       {"compensated",
        false,
        {{},
         "Compensated (Kahan) summation: the rounding error of each step's increment is added to the next increment."}},
       {"gravity",
        std::string("auto"),
        {one_of({"auto", "direct", "tree"}),
         "Sum of mutual gravity: over all pairs (direct), by a Barnes-Hut tree (tree), or chosen by the number of "
         "bodies (auto)."}},
       {"opening",
        GravityOptions{}.opening,
        {strictly_between(0, 1),
         "Opening of the tree: a node replaces its bodies where its radius is less than this times its distance."}},
       {"threads", std::int64_t(1), {between(1, 256), "Threads that share the rates of a step."}}});
  if (info.claimed_order.count("mechanism") > 0 && info.claimed_order.count("rotation") > 0)
    declare_settings(
        info,
        {{"projection",
          std::string("standard"),
          {one_of({"standard", "none"}),
           "After each step of a mechanism with loops or ropes, positions and rates are projected onto the constraints "
           "(standard; a symmetric method is then no longer symmetric), or are not and drift (none)."}},
         {"coordinates",
          std::string("reduced"),
          {one_of({"reduced", "maximal"}),
           "Coordinates of a mechanism: joint coordinates, in which joints have no gap (reduced), or the poses of all "
           "bodies, with each joint a constraint on accelerations (maximal)."}}});
  return info;
}

Setting atol_over_rtol() {
  return {
      "atol_over_rtol",
      0.01,
      {between(1e-20, 1e20), "Ratio of the absolute to the relative tolerance, where the id gives only the latter."}};
}

MethodInfo with_tolerance(const std::string& scheme, std::map<std::string, double> claims, const std::string& doc,
                          const std::string& source) {
  MethodInfo info = fixed_step(scheme, std::move(claims), doc, source);
  info.adaptive = true;
  const StepLimits limits;
  std::vector<Setting> of_steps = {
      atol_over_rtol(),
      {"safety", limits.safety, {between(0.01, 1), "Safety factor on the step that the error estimate allows."}},
      {"beta", limits.beta, {between(0, 1), "Exponent of the last step's error in the PI step control."}},
      {"least_factor",
       limits.least,
       {{1e-3, 1, false, true}, "Smallest ratio of a step to the last one (Hairer's facmin)."}},
      {"most_factor",
       limits.most,
       {{1, 1000, true, false}, "Largest ratio of a step to the last one (Hairer's facmax)."}}};
  for (Setting& setting : of_steps) setting.rule.needs_tolerance = true;
  declare_settings(info, of_steps);
  return info;
}

namespace {

std::vector<MethodInfo> build_catalogue() {
  std::vector<MethodInfo> all;
  for (const auto& family : {explicit_runge_kutta_methods(), nystrom_methods(), partitioned_methods(),
                             composition_methods(), rotation_methods(), implicit_methods(), multistep_methods(),
                             conserving_methods(), high_precision_methods(), constrained_methods()})
    all.insert(all.end(), family.begin(), family.end());
  for (MethodInfo& info : all) info.formula = formula_of(info.id.substr(info.id.find('/') + 1));
  return all;
}

template <class S> StepperResult<S> first_of(const StepperRequest<S>& request) {
  using Maker = StepperResult<S> (*)(const StepperRequest<S>&);
  for (const Maker make :
       {Maker(make_explicit_runge_kutta<S>), Maker(make_nystrom<S>), Maker(make_partitioned<S>),
        Maker(make_composition<S>), Maker(make_rotation<S>), Maker(make_implicit<S>), Maker(make_multistep<S>),
        Maker(make_conserving<S>), Maker(make_high_precision<S>), Maker(make_constrained<S>)}) {
    StepperResult<S> stepper = make(request);
    if (!stepper || *stepper != nullptr) return stepper;
  }
  throw std::logic_error("no family makes the stepper of atwood/" + request.scheme);
}

template <class S>
StepperResult<S> make(const std::string& scheme, System<S>& system, RigidModel<S>* model, const Settings& overrides) {
  const MethodInfo* info = find_integrator(scheme);
  if (info == nullptr) return Fault{"atwood has no method `" + scheme + "`"};
  const Result<Settings> settings = merged_settings(*info, overrides);
  if (!settings) return settings.fault();
  return first_of(StepperRequest<S>{scheme, system, model, *settings});
}

}  // namespace

const std::vector<MethodInfo>& integrator_catalogue() {
  static const std::vector<MethodInfo> all = build_catalogue();
  return all;
}

const MethodInfo* find_integrator(const std::string& scheme) {
  for (const MethodInfo& info : integrator_catalogue())
    if (info.id == "atwood/" + scheme) return &info;
  return nullptr;
}

template <class S>
Result<std::unique_ptr<Stepper<S>>> make_stepper(const std::string& scheme, RigidModel<S>& model,
                                                 const Settings& overrides) {
  return make(scheme, model.system(), &model, overrides);
}

template <class S>
Result<std::unique_ptr<Stepper<S>>> make_stepper(const std::string& scheme, System<S>& system,
                                                 const Settings& overrides) {
  return make<S>(scheme, system, nullptr, overrides);
}

#define ATWOOD_INSTANTIATE(S)                                                                                     \
  template Result<std::unique_ptr<Stepper<S>>> make_stepper(const std::string&, RigidModel<S>&, const Settings&); \
  template Result<std::unique_ptr<Stepper<S>>> make_stepper(const std::string&, System<S>&, const Settings&);
ATWOOD_INSTANTIATE(float)
ATWOOD_INSTANTIATE(double)
ATWOOD_INSTANTIATE(long double)
ATWOOD_INSTANTIATE(Quad)
#undef ATWOOD_INSTANTIATE

}  // namespace atwood
