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
  return {"atwood/" + scheme,
          doc,
          source,
          std::move(claims),
          false,
          {{"scalar", std::string("double")},
           {"compensated", false},
           {"gravity", std::string("auto")},
           {"opening", GravityOptions{}.opening},
           {"threads", std::int64_t(1)}}};
}

MethodInfo with_tolerance(const std::string& scheme, std::map<std::string, double> claims, const std::string& doc,
                          const std::string& source) {
  MethodInfo info = fixed_step(scheme, std::move(claims), doc, source);
  info.adaptive = true;
  const StepLimits limits;
  info.settings.insert({{"atol_over_rtol", 0.01},
                        {"safety", limits.safety},
                        {"beta", limits.beta},
                        {"least_factor", limits.least},
                        {"most_factor", limits.most}});
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

namespace {

std::string kind_of(const SettingValue& value) {
  constexpr std::array kinds{"true or false", "a whole number", "a number", "a word"};
  return kinds[value.index()];
}

}  // namespace

Settings merged_settings(const MethodInfo& info, const Settings& overrides, std::string& why) {
  Settings merged = info.settings;
  for (const auto& [name, value] : overrides) {
    const auto known = merged.find(name);
    if (known == merged.end() || name == "scalar") {
      why = info.id + " has no setting `" + name + "` to change";
    } else if (known->second.index() == value.index()) {
      known->second = value;
    } else if (std::holds_alternative<double>(known->second) && std::holds_alternative<std::int64_t>(value)) {
      known->second = static_cast<double>(std::get<std::int64_t>(value));
    } else {
      why = info.id + ": setting `" + name + "` takes " + kind_of(known->second) + ", not " + kind_of(value);
    }
  }
  return merged;
}

template <class S>
std::unique_ptr<Stepper<S>> make_stepper(const std::string& scheme, RigidModel<S>& model, std::string& why,
                                         const Settings& overrides) {
  const MethodInfo* info = find_integrator(scheme);
  if (info == nullptr) {
    why = "atwood has no method `" + scheme + "`";
    return nullptr;
  }
  StepperRequest<S> request{scheme, model, merged_settings(*info, overrides, why), ""};
  if (!why.empty()) return nullptr;
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
