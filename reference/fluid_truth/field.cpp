#include "fluid_truth/field.hpp"

#include <algorithm>
#include <limits>
#include <memory>
#include <stdexcept>

#include "fluid_truth/literature.hpp"
#include "fluid_truth/solution.hpp"
#include "fluid_truth/weakly_compressible.hpp"
#include "protocol/refusal.hpp"

namespace atwood {

using namespace fluid_truth;

namespace {

const std::vector<Solution>& catalogue() {
  static const std::vector<Solution> all{
      taylor_green(),    shear(),           poiseuille(),    couette(),     heat_sine(),    heat_step(),
      heat_flux(),       standing_wave(),   elliptic_drop(), hydrostatic(), square_patch(), fluid_truth::ritter(),
      couette_thermal(), viscous_heating(), mms_2d(),        mms_3d(),      floating()};
  return all;
}

// As in closed_form/closed_form.cpp: the difference between the two evaluations of the same formulas, divided by 2^49,
// estimates the round-off error of quad. The largest difference over the positions of one call, a factor of 32, and at
// least 32 units in the last place of the scale.
constexpr double kSafety = 32;
const Wide kRoundOff = unit_round_off<Wide>();
const Wide kRatio = unit_round_off<Wide>() / unit_round_off<Narrow>();

struct Spread {  // one quantity, over the positions
  Wide difference = 0, scale = 0;
  void include(Wide wide, Wide narrow) {
    difference = larger(difference, magnitude(wide - narrow));
    if (!is_finite(wide) || !is_finite(narrow)) difference = std::numeric_limits<double>::infinity();
    scale = larger(scale, magnitude(wide));
  }
  Wide bar() const { return kSafety * (kRatio * difference + kRoundOff * scale); }
};

struct Both {
  Field<Wide> wide;
  Field<Narrow> narrow;
};

std::vector<std::optional<ProbeValue>> probes_at(const Both& both, const Scene& scene, Wide t_s) {
  std::vector<std::optional<ProbeValue>> made;
  for (const FluidProbe& probe : scene.probes) {
    auto& to = made.emplace_back();
    if (!both.wide.probe) continue;
    const auto wide = both.wide.probe(t_s, probe);
    const auto narrow = both.narrow.probe(static_cast<Narrow>(t_s), probe);
    if (!wide || !narrow) continue;
    Spread spread;
    spread.include(wide->value, Wide(narrow->value));
    to = ProbeValue{wide->value, spread.bar() + wide->neglected};
    if (!both.wide.bounded) to->bar = std::numeric_limits<double>::infinity();
  }
  return made;
}

FieldSample evaluate(const Both& both, const Scene& scene, Wide t_s, const std::vector<FieldPosition>& positions) {
  if (!(t_s >= 0) || !is_finite(t_s)) throw std::invalid_argument("a field is asked for at a time before 0");
  if (both.wide.undefined)
    if (const std::string why = both.wide.undefined(t_s); !why.empty())
      throw std::invalid_argument("at t = " + format_double(static_cast<double>(t_s)) + " s: " + why);
  const FieldAt<Wide> wide = both.wide.at(t_s);
  const FieldAt<Narrow> narrow = both.narrow.at(static_cast<Narrow>(t_s));
  FieldSample made;
  made.t_s = t_s;
  Spread v, density, p, T;
  made.values.reserve(positions.size());
  made.bars.reserve(positions.size());
  for (const FieldPosition& x : positions) {
    const Point<Wide> w = wide(x);
    const Point<Narrow> n = narrow({static_cast<Narrow>(x[0]), static_cast<Narrow>(x[1]), static_cast<Narrow>(x[2])});
    for (int i = 0; i < 3; ++i) v.include(w.v[i], Wide(n.v[i]));
    density.include(w.density, Wide(n.density));
    p.include(w.p, Wide(n.p));
    T.include(w.T, Wide(n.T));
    made.values.push_back({x, w.v, w.density, w.p, w.T});
    made.bars.push_back(
        {{}, {w.neglected_v, w.neglected_v, w.neglected_v}, w.neglected_density, w.neglected_p, w.neglected_T});
  }
  for (ParticleSample& bar : made.bars) {
    for (Wide& part : bar.v_m_per_s) part += v.bar();
    bar.density_kg_per_m3 += density.bar();
    bar.pressure_Pa += p.bar();
    bar.temperature_K += T.bar();
    if (both.wide.bounded) continue;
    const Wide infinite = std::numeric_limits<double>::infinity();
    bar = {{}, {infinite, infinite, infinite}, infinite, infinite, infinite};
  }
  made.probes = probes_at(both, scene, t_s);
  return made;
}

FluidField closed_form_field(const Scenario& given, const std::string& response) {
  const std::string name = "fluid field `" + given.truth.solution + "`: ";
  const auto found = std::find_if(catalogue().begin(), catalogue().end(),
                                  [&](const Solution& s) { return s.id == given.truth.solution; });
  if (found == catalogue().end()) {
    std::string known;
    for (const Solution& each : catalogue()) known += (known.empty() ? "" : ", ") + std::string(each.id);
    return refused<FluidField>(name + "no such solution; expected one of " + known);
  }
  const auto scenario = std::make_shared<const Scenario>(given);
  const auto equations = std::make_shared<const std::string>(response);
  const auto both = std::make_shared<Both>();
  try {
    both->wide = found->wide({*scenario, *equations});
    both->narrow = found->narrow({*scenario, *equations});
  } catch (const Refused& refusal) {
    return refused<FluidField>(name + refusal.why);
  }
  FluidField made;
  made.source = std::string("closed form: ") + found->citation;
  made.note = both->wide.note;
  made.known = found->known;
  made.at = [scenario, equations, both](Wide t_s, const std::vector<FieldPosition>& positions) {
    return evaluate(*both, scenario->scene, t_s, positions);
  };
  return made;
}

}  // namespace

std::vector<std::string> fluid_solution_ids() {
  std::vector<std::string> ids;
  for (const Solution& solution : catalogue()) ids.push_back(solution.id);
  return ids;
}

FluidField fluid_field_of(const Scenario& scenario, const std::string& response) {
  if (scenario.truth.kind == TruthKind::closed_form) return closed_form_field(scenario, response);
  if (scenario.truth.kind == TruthKind::weakly_compressible) return weakly_compressible_field(scenario, response);
  if (scenario.truth.kind == TruthKind::literature) return literature_field(scenario);
  return refused<FluidField>(
      "the truth of this scenario is not a field; expected closed-form, weakly-compressible or literature");
}

}  // namespace atwood
