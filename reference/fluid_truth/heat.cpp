// Conduction in a fluid at rest, T_t = alpha lap T, alpha = conductivity / (rho0 heat capacity). H. S. Carslaw and J.
// C. Jaeger, Conduction of Heat in Solids, 2nd ed. (1959), 2.4, 3.3, 3.4 and 3.8.
#include "fluid_truth/slab.hpp"
#include "fluid_truth/solution.hpp"

namespace atwood::fluid_truth {

namespace {

void require_rest(const Scene& scene) {
  const Fluid& fluid = only_fluid(scene);
  require(scene.gravity_m_per_s2 == Real3{} && fluid.source.name.empty(), "expected no gravity and no source");
  require(fluid.initial.velocity_m_per_s == Real3{} && fluid.initial.velocity_gradient_per_s == std::array<double, 9>{},
          "expected a fluid at rest at t = 0");
}

// T = T0 + A sin(kx) exp(-alpha k^2 t)
template <class S> Field<S> solve_sine(const Asked& asked) {
  const Scene& scene = asked.scene;
  const Fluid& fluid = only_fluid(scene);
  require_rest(scene);
  require(fluid.initial.name == "heat-sine", "expected the initial field `heat-sine`");
  require(!has_boundaries(scene), "expected no boundary");
  const S k = wave_number<S>(scene, fluid.initial, 0), A = parameter(fluid.initial, "amplitude_K", 1),
          alpha = thermal_diffusivity<S>(fluid), T0 = fluid.temperature_K, rho0 = fluid.density_kg_per_m3;
  require_period<S>(scene, k, 0);
  Field<S> made;
  made.at = [=](S t) -> FieldAt<S> {
    const S now = A * exp(-alpha * k * k * t);
    return [=](const Vec<S>& x) {
      Point<S> at;
      at.T = T0 + now * sin(k * x[0]);
      at.density = rho0;
      return at;
    };
  };
  return made;
}

// T0 + A where x < position, T0 beyond, in a period of x or between insulated ends, whose images make the period twice
// as long.
template <class S> Field<S> solve_jump(const Scene& scene, const Fluid& fluid) {
  require(!has_boundaries(scene), "expected no boundary with the initial field `heat-step`");
  const auto* box = std::get_if<BoxRegion>(&fluid.region);
  require(box != nullptr, "expected the region of a box");
  const S low = box->min_m[0], high = box->max_m[0], T0 = fluid.temperature_K, rho0 = fluid.density_kg_per_m3,
          at_x = parameter(fluid.initial, "position_m", (box->min_m[0] + box->max_m[0]) / 2);
  const S period = scene.domain.periodic_m[0];
  require(period == 0 || magnitude(high - low - period) <= S(1e-12) * period,
          "the region does not fill the period of x");
  require(low < at_x && at_x < high, "the step is outside of the region");
  PeriodicStep<S> step;
  step.D = thermal_diffusivity<S>(fluid);
  step.height = parameter(fluid.initial, "amplitude_K", 1);
  if (period > 0) step.P = period, step.centre = (low + at_x) / 2, step.width = at_x - low;
  else step.P = 2 * (high - low), step.centre = low, step.width = 2 * (at_x - low);
  Field<S> made;
  made.at = [=](S t) -> FieldAt<S> {
    return [=](const Vec<S>& x) {
      Point<S> at;
      const SlabValue<S> now = step_at(step, x[0], t);
      at.T = T0 + now.w;
      at.neglected_T = now.neglected;
      at.density = rho0;
      return at;
    };
  };
  return made;
}

// A fluid of uniform temperature between walls of which one or both have another one: erfc at the wall, with images. An
// insulated wall is the middle of a channel of twice the width.
template <class S> Field<S> solve_walls(const Scene& scene, const Fluid& fluid) {
  const Channel<S> walls = channel_of<S>(scene);
  require(walls.T_low || walls.T_high, "expected a temperature on a boundary");
  const S T0 = fluid.temperature_K, alpha = thermal_diffusivity<S>(fluid), rho0 = fluid.density_kg_per_m3,
          L = walls.high - walls.low;
  const bool both = walls.T_low && walls.T_high;
  const S T_low = walls.T_low ? *walls.T_low : *walls.T_high, T_high = walls.T_high ? *walls.T_high : *walls.T_low;
  const S from = !both && !walls.T_low ? walls.low - L : walls.low;
  const Slab<S> slab{both ? L : 2 * L, alpha, S(0), T_low, T_high, T0};
  Field<S> made;
  made.at = [=](S t) -> FieldAt<S> {
    return [=](const Vec<S>& x) {
      Point<S> at;
      const SlabValue<S> now = slab_at(slab, x[walls.axis] - from, t);
      at.T = now.w;
      at.neglected_T = now.neglected;
      at.density = rho0;
      return at;
    };
  };
  return made;
}

template <class S> Field<S> solve_step(const Asked& asked) {
  const Fluid& fluid = only_fluid(asked.scene);
  require_rest(asked.scene);
  if (fluid.initial.name == "heat-step") return solve_jump<S>(asked.scene, fluid);
  require(fluid.initial.name.empty(), "expected the initial field `heat-step`, or a uniform temperature between walls");
  return solve_walls<S>(asked.scene, fluid);
}

// A fluid of uniform temperature between walls through which given fluxes enter.
template <class S> Field<S> solve_flux(const Asked& asked) {
  const Scene& scene = asked.scene;
  const Fluid& fluid = only_fluid(scene);
  require_rest(scene);
  require(fluid.initial.name.empty(), "expected a uniform temperature between walls");
  require(!fluid.viscous_heat, "the fluid has viscous heat");
  const Channel<S> walls = channel_of<S>(scene, true);
  require(!walls.T_low && !walls.T_high, "a boundary has a temperature; expected fluxes or insulation");
  require(fluid.conductivity_W_per_m_K > 0, "the fluid has no conductivity");
  const S T0 = fluid.temperature_K, D = thermal_diffusivity<S>(fluid), rho0 = fluid.density_kg_per_m3,
          L = walls.high - walls.low, k = fluid.conductivity_W_per_m_K;
  const HeatedSlab<S> low{L, D, S(walls.q_low) / k}, high{L, D, S(walls.q_high) / k};
  Field<S> made;
  made.at = [=](S t) -> FieldAt<S> {
    return [=](const Vec<S>& x) {
      const SlabValue<S> from_low = heated_slab_at(low, x[walls.axis] - walls.low, t),
                         from_high = heated_slab_at(high, walls.high - x[walls.axis], t);
      Point<S> at;
      at.T = T0 + from_low.w + from_high.w;
      at.neglected_T = from_low.neglected + from_high.neglected;
      at.density = rho0;
      return at;
    };
  };
  return made;
}

}  // namespace

Solution heat_sine() {
  return {"heat-sine",
          "decay of a sine by conduction: Carslaw and Jaeger, Conduction of Heat in Solids (1959), 3.3",
          {true, true, true, true},
          solve_sine<Narrow>,
          solve_sine<Wide>};
}

Solution heat_step() {
  return {"heat-step",
          "conduction from a step (erf) or a wall (erfc): Carslaw and Jaeger (1959), 2.4, 3.4",
          {true, true, true, true},
          solve_step<Narrow>,
          solve_step<Wide>};
}

Solution heat_flux() {
  return {"heat-flux",
          "conduction from walls with given fluxes: Carslaw and Jaeger (1959), 3.8",
          {true, true, true, true},
          solve_flux<Narrow>,
          solve_flux<Wide>};
}

}  // namespace atwood::fluid_truth
