// Methods for round-off accuracy: their ids, documentation and steppers.
#include "integrators/extrapolation.hpp"
#include "integrators/families.hpp"
#include "integrators/radau15.hpp"
#include "integrators/taylor.hpp"

namespace atwood {
namespace {

MethodInfo of_tolerance(const std::string& scheme, std::map<std::string, double> claims, const std::string& doc,
                        const std::string& source) {
  MethodInfo info = fixed_step(scheme, std::move(claims), doc, source);
  info.adaptive = true;
  declare_settings(info, {atol_over_rtol()});
  return info;
}

}  // namespace

std::vector<MethodInfo> high_precision_methods() {
  const std::string sweeps =
      " Positions are integrated twice from the accelerations. The first iterate extrapolates the rates of the step "
      "before. Without a tolerance: equal steps, sweeps to round-off. With one: steps are chosen such that the local "
      "error, estimated by the last coefficient of the rates' polynomial, meets the tolerance; sweeps end when the "
      "remaining change is a small part of it. Samples by a shorter step.";
  std::vector<MethodInfo> methods{
      of_tolerance(
          "radau15", claims_in_any_coordinates(15),
          "Collocation at the eight Radau nodes that include the start of the step, order 15, solved by sweeps that "
          "evaluate all nodes as one batch of eight states. Of ten or fewer point masses under gravity alone each sweep is "
          "corrected with the gradient of gravity, by two terms of the Neumann series of Newton's method; these products "
          "are not counted as evaluations." +
              sweeps + embedded_attitude,
          "Everhart, in: Dynamics of Comets (1985) 185; Hairer, Norsett, Wanner, Solving ODEs I, theorem II.7.7"),
      of_tolerance(
          "ias15", claims_in_any_coordinates(15),
          "Collocation at the eight Radau nodes that include the start of the step, order 15, solved node after "
          "node, each with the newest rates, with compensated summation: few evaluations. The method is sequential by "
          "definition, since the state at a node needs the new rates at all nodes before it, so that its evaluations "
          "cannot stand side by side in a register as those of radau15 do: of seven bodies in a plane one takes 190 ns, "
          "and 60 ns in radau15 (AVX-512, 4.2 GHz). A tolerance of 1e-16 or "
          "less corresponds to IAS15's epsilon of 1e-7 or less, by epsilon^2 = 100 rtol." +
              sweeps + embedded_attitude,
          "Rein, Spiegel, MNRAS 446 (2015) 1424, eq. 4 to 11; Everhart (1985)")};
  for (MethodInfo& info : methods) info.settings["compensated"] = true;
  declare_settings(
      methods.back(),
      {{"criterion",
        std::string("tolerance"),
        {one_of({"tolerance", "rein-spiegel", "prs23"}),
         "What chooses the steps of a run with a tolerance: the tolerance, or the authors' criterion with `epsilon`, by "
         "the last coefficient (rein-spiegel: their equation 11) or by the timescale of acceleration, jerk and snap "
         "(prs23: Pham, Rein, Spiegel, Open J. Astrophys. 7 (2024)); the tolerance then only ends the sweeps. The timescale of prs23 is 0 for a body "
         "on which no force acts at the end of a step: steps cannot pass a point where the forces on a body cancel.",
         "", true}},
       {"epsilon", 1e-9, {strictly_between(0, 1), "Accuracy parameter of `rein-spiegel` and `prs23`.", "", true}}});
  MethodInfo gbs = with_tolerance(
      "gbs", claims_in_any_coordinates(12),
      "Extrapolation of Gragg's midpoint rule with 2, 4, 6, ... substeps. Without a tolerance: equal "
      "steps with a fixed number of columns, order twice that, the order-12 default with 37 "
      "evaluations per step. With one: each step takes as many columns as cost the fewest evaluations "
      "for its length, by the differences of successive columns (`order=fixed`: the fixed number, and "
      "PI step control by the last difference); samples by a shorter step. Quaternions, loops and ropes are "
      "projected after the extrapolation, never before it." +
          embedded_attitude,
      "Gragg, SIAM J. Numer. Anal. 2 (1965) 384; Bulirsch, Stoer, Numer. Math. 8 (1966) 1; "
      "Hairer, Norsett, Wanner, Solving ODEs I, section II.9");
  declare_settings(gbs,
                   {{"columns",
                     std::int64_t(6),
                     {between(2, kMaxColumns),
                      "Columns of the extrapolation, half its order, in equal steps and where `order=fixed` (with a "
                      "tolerance at most " +
                          std::to_string(kMaxFixedColumns) + ")."}},
                    {"order",
                     std::string("chosen"),
                     {one_of({"chosen", "fixed"}),
                      "With a tolerance: the order of each step is chosen, or half of it is `columns`."}}});
  methods.push_back(gbs);
  methods.push_back(taylor_method());
  return methods;
}

template <class S> StepperResult<S> make_high_precision(const StepperRequest<S>& request) {
  if (request.scheme == "radau15" || request.scheme == "ias15") {
    const bool sequential = request.scheme == "ias15";
    RadauOptions options{sequential, request.flag("compensated")};
    if (sequential) {
      const auto& criterion = std::get<std::string>(request.settings.at("criterion"));
      if (criterion == "rein-spiegel") options.criterion = StepCriterion::rein_spiegel;
      else if (criterion == "prs23") options.criterion = StepCriterion::prs23;
      options.epsilon = request.number("epsilon");
    }
    options.fused = std::get<std::string>(request.settings.at("gravity")) != "tree";
    return StepperPointer<S>(std::make_unique<Radau15<S>>(request.system, request.model, options));
  }
  if (request.scheme == "gbs") {
    ExtrapolationOptions options{static_cast<int>(request.count("columns")), request.flag("compensated")};
    options.choose_order = std::get<std::string>(request.settings.at("order")) == "chosen";
    options.limits = {request.number("safety"), request.number("beta"), request.number("least_factor"),
                      request.number("most_factor")};
    return StepperPointer<S>(std::make_unique<Extrapolation<S>>(request.system, options));
  }
  if (request.scheme == "taylor") return make_taylor<S>(request);
  return StepperPointer<S>{};
}

template StepperResult<float> make_high_precision(const StepperRequest<float>&);
template StepperResult<double> make_high_precision(const StepperRequest<double>&);
template StepperResult<long double> make_high_precision(const StepperRequest<long double>&);
template StepperResult<Quad> make_high_precision(const StepperRequest<Quad>&);

}  // namespace atwood
