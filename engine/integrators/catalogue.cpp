#include "integrators/catalogue.hpp"

#include <array>

#include "integrators/adaptive.hpp"
#include "integrators/families.hpp"

namespace atwood {

const std::string embedded_attitude =
    " A rotating body's quaternion is integrated as four numbers, q' = 1/2 q (0, w), beside Euler's equations in body "
    "axes, "
    "and normalised after each step, so that attitude keeps the order.";

std::map<std::string, double> claims_everywhere(double order) {
  return {{"point-mass", order}, {"velocity-dependent", order}, {"rotation", order}};
}

MethodInfo fixed_step(const std::string& scheme, std::map<std::string, double> claims, const std::string& doc,
                      const std::string& source) {
  MethodInfo info{"atwood/" + scheme, doc, source, std::move(claims), false, {}};
  declare_settings(
      info,
      {{"scalar", std::string("double"), {{}, "Scalar type of the state; chosen by @ in the id."}},
       {"compensated", false, {{}, "Compensated summation of the state: the round-off of each step enters the next."}},
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
  return info;
}

Setting atol_over_rtol() {
  return {"atol_over_rtol",
          0.01,
          {above(0), "Ratio of the absolute to the relative tolerance, where the id gives only the latter."}};
}

MethodInfo with_tolerance(const std::string& scheme, std::map<std::string, double> claims, const std::string& doc,
                          const std::string& source) {
  MethodInfo info = fixed_step(scheme, std::move(claims), doc, source);
  info.adaptive = true;
  const StepLimits limits;
  declare_settings(
      info, {atol_over_rtol(),
             {"safety", limits.safety, {above(0), "Safety factor on the step that the error estimate allows."}},
             {"beta", limits.beta, {at_least(0), "Exponent of the last step's error in the PI step control."}},
             {"least_factor", limits.least, {strictly_between(0, 1), "Least ratio of a step to the one before."}},
             {"most_factor", limits.most, {above(1), "Largest ratio of a step to the one before."}}});
  return info;
}

namespace {

std::vector<MethodInfo> build_catalogue() {
  std::vector<MethodInfo> all;
  for (const auto& family :
       {explicit_runge_kutta_methods(), nystrom_methods(), partitioned_methods(), composition_methods(),
        rotation_methods(), implicit_methods(), multistep_methods(), conserving_methods(), high_precision_methods()})
    all.insert(all.end(), family.begin(), family.end());
  return all;
}

template <class S> StepperPointer<S> first_of(StepperRequest<S>& request) {
  using Maker = StepperPointer<S> (*)(StepperRequest<S>&);
  for (const Maker make : {Maker(make_explicit_runge_kutta<S>), Maker(make_nystrom<S>), Maker(make_partitioned<S>),
                           Maker(make_composition<S>), Maker(make_rotation<S>), Maker(make_implicit<S>),
                           Maker(make_multistep<S>), Maker(make_conserving<S>), Maker(make_high_precision<S>)}) {
    StepperPointer<S> stepper = make(request);
    if (stepper != nullptr || !request.why.empty()) return stepper;
  }
  return nullptr;
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
std::unique_ptr<Stepper<S>> make_stepper(const std::string& scheme, RigidModel<S>& model, std::string& why,
                                         const Settings& overrides) {
  const MethodInfo* info = find_integrator(scheme);
  if (info == nullptr) {
    why = "atwood has no method `" + scheme + "`";
    return nullptr;
  }
  const Result<Settings> settings = merged_settings(*info, overrides);
  if (!settings) {
    why = settings.fault().reason;
    return nullptr;
  }
  StepperRequest<S> request{scheme, model, *settings, ""};
  auto stepper = first_of(request);
  if (stepper == nullptr) why = request.why;
  return stepper;
}

template std::unique_ptr<Stepper<float>> make_stepper(const std::string&, RigidModel<float>&, std::string&,
                                                      const Settings&);
template std::unique_ptr<Stepper<double>> make_stepper(const std::string&, RigidModel<double>&, std::string&,
                                                       const Settings&);
template std::unique_ptr<Stepper<long double>> make_stepper(const std::string&, RigidModel<long double>&, std::string&,
                                                            const Settings&);
template std::unique_ptr<Stepper<Quad>> make_stepper(const std::string&, RigidModel<Quad>&, std::string&,
                                                     const Settings&);

}  // namespace atwood
