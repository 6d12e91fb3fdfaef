#include <algorithm>
#include <boost/version.hpp>

#include "odeint/catalogue.hpp"
#include "odeint/odeint.hpp"

namespace atwood {

namespace {

using odeint::Choice;
using odeint::Entry;

const std::vector<Entry>& entries() {
  static const std::vector<Entry> all = [] {
    std::vector<Entry> made;
    odeint::add_runge_kutta(made);
    odeint::add_adams_bashforth(made);
    odeint::add_adams_moulton(made);
    odeint::add_symplectic(made);
    odeint::add_controlled(made);
    odeint::add_implicit(made);
    return made;
  }();
  return all;
}

Settings settings(const Entry& entry) {
  Settings all;
  all["stepper"] = entry.type;
  all["claim"] = entry.claim;
  if (entry.has_in_place) all["in_place"] = false;
  all["rate"] = std::string("the reference's");
  all["rate_repeats"] = std::int64_t(1);
  if (entry.has_epsilon) all["epsilon"] = 1e-6;
  if (entry.by_tolerance) all["rtol"] = 1e-8;
  if (entry.by_tolerance) all["atol"] = std::string("rtol / 100");
  all["sampling"] = std::string(entry.form == Entry::Form::dense ? "odeint's own dense output"
                                : entry.by_tolerance ? "the last step before a sample is cut; no interpolation"
                                                     : "whole steps");
  const bool solves = entry.type.find("rosenbrock") != std::string::npos || entry.has_epsilon;
  if (solves) all["jacobian"] = std::string("differences of order 4 in long double");
  return all;
}

MethodInfo info(const Entry& entry) {
  MethodInfo made;
  made.id = "odeint/" + entry.name;
  made.doc = entry.doc;
  made.source = "Ahnert and Mulansky, Odeint, AIP Conf. Proc. 1389 (2011) 1586; order: " + entry.claim;
  made.adaptive = entry.by_tolerance;
  if (entry.order > 0) {
    made.claimed_order["point-mass"] = entry.order;
    if (entry.form != Entry::Form::symplectic) made.claimed_order["velocity-dependent"] = entry.order;
    if (entry.form != Entry::Form::symplectic && entry.form != Entry::Form::verlet)
      made.claimed_order["rotation"] = entry.order;
  }
  made.settings = settings(entry);
  return made;
}

std::string read_choice(const MethodId& id, const Entry& entry, Choice& choice) {
  if (!id.scalar.empty() && id.scalar != "double" && id.scalar != "long-double")
    return "odeint runs here in double and long-double, not " + id.scalar;
  if (!id.response.empty()) return "odeint has no contacts: no +" + id.response;
  if (id.rtol && !entry.by_tolerance)
    return "odeint's " + entry.name + " has no error control: it takes equal steps, no tolerance";
  choice.rtol = id.rtol.value_or(1e-8);
  choice.atol = id.atol.value_or(choice.rtol / 100);
  for (const auto& [key, value] : id.overrides) {
    const auto* flag = std::get_if<bool>(&value);
    const auto* real = std::get_if<double>(&value);
    if (key == "in_place" && entry.has_in_place && flag) choice.in_place = *flag;
    else if (key == "epsilon" && entry.has_epsilon && real && *real > 0) choice.epsilon = *real;
    else
      return "odeint's " + entry.name + " has no setting `" + key + "` of that value; it has " +
             (entry.has_in_place  ? "in_place"
              : entry.has_epsilon ? "epsilon"
                                  : "none");
  }
  return "";
}

Outcome run_method(const MethodId& asked, const Scene& scene, const Plan& plan, const Observer& observer, int repeats) {
  MethodId id = asked;
  int rate_repeats = 1;
  if (const std::string why = stepping::take_rate_repeats(id, rate_repeats); !why.empty())
    return stepping::refusal(why);
  const auto found =
      std::find_if(entries().begin(), entries().end(), [&](const Entry& entry) { return entry.name == id.scheme; });
  if (found == entries().end())
    return stepping::refusal("odeint has no stepper `" + id.scheme + "`; `atwood list methods` shows them");
  Choice choice;
  if (const std::string why = read_choice(id, *found, choice); !why.empty()) return stepping::refusal(why);
  const auto with = [&]<class S>(odeint::Make<S> make) {
    return stepping::run<S>(
        "odeint", scene, plan, observer, repeats, found->by_tolerance,
        [&](const stepping::Equations<S>& equations, const std::vector<S>& y, S h_s) {
          return make(equations, y, h_s, choice);
        },
        rate_repeats);
  };
  return id.scalar == "long-double" ? with(found->in_long_double) : with(found->in_double);
}

}  // namespace

Engine odeint_engine() {
  Engine engine;
  engine.name = "odeint";
  engine.version = "Boost " + std::to_string(BOOST_VERSION / 100000) + "." +
                   std::to_string(BOOST_VERSION / 100 % 1000) + "." + std::to_string(BOOST_VERSION % 100);
  engine.scalar = "double";
  for (const Entry& entry : entries()) engine.methods.push_back(info(entry));
  engine.run = run_method;
  return engine;
}

}  // namespace atwood
