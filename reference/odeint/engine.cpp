#include <algorithm>
#include <boost/version.hpp>

#include "odeint/catalogue.hpp"
#include "odeint/odeint.hpp"
#include "protocol/printed_setting.hpp"
#include "protocol/refusal.hpp"

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

std::vector<Setting> settings(const Entry& entry) {
  std::vector<Setting> all{printed("stepper", entry.type), printed("claim", entry.claim),
                           printed("rate", std::string("the reference's")), stepping::rate_repeats_setting()};
  if (entry.has_in_place) all.push_back({"in_place", false, {{}, "The step replaces its argument: do_step(x)."}});
  if (entry.has_epsilon) all.push_back({"epsilon", 1e-6, {{0, 1, true, false}, "Newton's stopping tolerance."}});
  if (entry.by_tolerance) all.push_back(printed("rtol", 1e-8, "Relative tolerance where the id has none."));
  if (entry.by_tolerance) all.push_back(printed("atol", std::string("rtol / 100")));
  all.push_back(
      printed("sampling", std::string(entry.form == Entry::Form::dense ? "odeint's own dense output"
                                      : entry.by_tolerance ? "the last step before a sample is cut; no interpolation"
                                                           : "whole steps")));
  const bool solves = entry.type.find("rosenbrock") != std::string::npos || entry.has_epsilon;
  if (solves) all.push_back(printed("jacobian", std::string("differences of order 4 in long double")));
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
  declare_settings(made, settings(entry));
  return made;
}

Result<Choice> read_choice(const MethodId& id, const Entry& entry, const Settings& settings) {
  const auto input = [](const std::string& why) { return Fault{why}; };
  if (!id.scalar.empty() && id.scalar != "double" && id.scalar != "long-double")
    return input("odeint runs here in double and long-double, not " + id.scalar);
  if (!id.response.empty()) return input("odeint has no contacts: no +" + id.response);
  if (id.rtol && !entry.by_tolerance)
    return input("odeint's " + entry.name + " has no error control: it takes equal steps; found a tolerance");
  Choice choice;
  choice.rtol = id.rtol.value_or(1e-8);
  choice.atol = id.atol.value_or(choice.rtol / 100);
  if (entry.has_in_place) choice.in_place = std::get<bool>(settings.at("in_place"));
  if (entry.has_epsilon) choice.epsilon = std::get<double>(settings.at("epsilon"));
  return choice;
}

Outcome run_method(const MethodId& id, const Scene& scene, const Plan& plan, const Observer& observer, int repeats) {
  const auto found =
      std::find_if(entries().begin(), entries().end(), [&](const Entry& entry) { return entry.name == id.scheme; });
  if (found == entries().end())
    return refused("odeint has no stepper `" + id.scheme + "`; `atwood list methods` shows them");
  const Result<Settings> settings = merged_settings(info(*found), id.overrides);
  if (!settings) return refused(settings.fault());
  const Result<Choice> choice = read_choice(id, *found, *settings);
  if (!choice) return refused(choice.fault());
  const auto with = [&]<class S>(odeint::Make<S> make) {
    return stepping::run<S>(
        "odeint", scene, plan, observer, repeats, found->by_tolerance,
        [&](const stepping::Equations<S>& equations, const std::vector<S>& y, S h_s) {
          return make(equations, y, h_s, *choice);
        },
        stepping::rate_repeats(*settings));
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
