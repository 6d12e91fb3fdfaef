// Flow between two parallel plates that starts from rest: driven by a uniform body force (Poiseuille), by the motion of
// the plates (Couette), or both. J. P. Morris, P. J. Fox and Y. Zhu, J. Comput. Phys. 136 (1997) 214, eq. 22 and 24;
// G. K. Batchelor, An Introduction to Fluid Dynamics (1967), 4.3. Each component along the plates obeys
//   w_t = nu w_ss + g,   w = the plates' velocities at s = 0 and s = L,   w = 0 at t = 0
// Nothing depends on the directions along the plates, so that the density stays uniform: the same field solves the
// compressible equations.
#include "fluid_truth/slab.hpp"
#include "fluid_truth/solution.hpp"

namespace atwood::fluid_truth {

namespace {

template <class S> void require_plain_viscosity(const Scene& scene, const Channel<S>& walls) {
  const Fluid& fluid = only_fluid(scene);
  require(walls.no_slip, "a boundary is free-slip");
  require(fluid.viscosity_m2_per_s > 0, "the fluid has no viscosity");
  require(fluid.viscosity_decay_per_K == 0 && fluid.expansion_per_K == 0,
          "viscosity or density depends on the temperature");
  require(scene.gravity_m_per_s2[walls.axis] == 0, "gravity has a component across the channel");
  require(fluid.source.name.empty(), "expected no source");
}

template <class S> Field<S> solve_channel_flows(const Asked& asked) {
  const Scene& scene = asked.scene;
  const Fluid& fluid = only_fluid(scene);
  const Channel<S> walls = channel_of<S>(scene);
  require_plain_viscosity(scene, walls);
  require(fluid.initial.name.empty() && fluid.initial.velocity_m_per_s == Real3{} &&
              fluid.initial.velocity_gradient_per_s == std::array<double, 9>{},
          "expected a fluid at rest at t = 0");
  const Vec<S> g = vec<S>(scene.gravity_m_per_s2);
  const S nu = fluid.viscosity_m2_per_s, rho0 = fluid.density_kg_per_m3;
  Field<S> made;
  made.at = [=](S t) -> FieldAt<S> {
    return [=](const Vec<S>& x) {
      Point<S> at;
      at.density = rho0;
      for (int i = 0; i < 3; ++i) {
        if (i == walls.axis || (g[i] == 0 && walls.v_low[i] == 0 && walls.v_high[i] == 0)) continue;
        const Slab<S> slab{walls.high - walls.low, nu, g[i], walls.v_low[i], walls.v_high[i], S(0)};
        const SlabValue<S> now = slab_at(slab, x[walls.axis] - walls.low, t);
        at.v[i] = now.w;
        at.neglected_v = larger(at.neglected_v, now.neglected);
      }
      return at;
    };
  };
  return made;
}

// Couette flow that is fully developed at t = 0, whose dissipation nu rho0 (U / L)^2 heats a fluid of uniform
// temperature between walls at given temperatures. H. C. Brinkman, Appl. Sci. Res. A 2 (1951) 120 (in a capillary);
// between plates R. B. Bird, W. E. Stewart and E. N. Lightfoot, Transport Phenomena (1960), 9.4.
//   T_t = alpha T_ss + nu (U / L)^2 / c,   T = T0 at t = 0
template <class S> Field<S> solve_viscous_heating(const Asked& asked) {
  const Scene& scene = asked.scene;
  const Fluid& fluid = only_fluid(scene);
  const Channel<S> walls = channel_of<S>(scene);
  require_plain_viscosity(scene, walls);
  require(scene.gravity_m_per_s2 == Real3{}, "expected no gravity");
  require(fluid.viscous_heat, "the fluid has no viscous heat");
  require(walls.T_low && walls.T_high, "expected a temperature on each boundary");
  require(fluid.initial.name.empty(), "expected a linear velocity at t = 0");
  const S alpha = thermal_diffusivity<S>(fluid), L = walls.high - walls.low, nu = fluid.viscosity_m2_per_s,
          rho0 = fluid.density_kg_per_m3, T0 = fluid.temperature_K;
  const Vec<S> jump = walls.v_high - walls.v_low;
  S away = 0, speed = 0;  // of the initial field from the developed flow, at the two walls
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j)
      require(j == walls.axis || fluid.initial.velocity_gradient_per_s[3 * i + j] == 0,
              "the velocity at t = 0 changes along the walls");
    const S slope = fluid.initial.velocity_gradient_per_s[3 * i + walls.axis], from = fluid.initial.velocity_m_per_s[i];
    away = larger(away, larger(magnitude(from + slope * walls.low - walls.v_low[i]),
                               magnitude(from + slope * walls.high - walls.v_high[i])));
    speed = larger(speed, larger(magnitude(walls.v_low[i]), magnitude(walls.v_high[i])));
  }
  require(away <= S(1e-12) * speed, "the velocity at t = 0 is not that of the developed Couette flow");
  const S heat = nu * dot(jump, jump) / (L * L) / S(fluid.heat_capacity_J_per_kg_K);
  Field<S> made;
  made.at = [=](S t) -> FieldAt<S> {
    return [=](const Vec<S>& x) {
      Point<S> at;
      const S s = x[walls.axis] - walls.low;
      const SlabValue<S> T = slab_at(Slab<S>{L, alpha, heat, S(*walls.T_low), S(*walls.T_high), T0}, s, t);
      at.v = walls.v_low + (s / L) * jump;
      at.density = rho0;
      at.T = T.w;
      at.neglected_T = T.neglected + 2 * t * heat * away / larger(speed, S(1e-300));
      at.neglected_v = away;
      return at;
    };
  };
  return made;
}

// Steady Couette flow with the viscosity nu exp(-beta (T - T_ref)) between walls at different temperatures, without
// viscous heat: R. B. Bird, W. E. Stewart and E. N. Lightfoot, Transport Phenomena (1960), problem 9.H. T is linear in
// the distance s, the shear stress is uniform, so u' is proportional to exp(beta T):
//   u = v_low + (v_high - v_low) expm1(b s / L) / expm1(b),   b = beta (T_high - T_low)
template <class S> Field<S> solve_couette_thermal(const Asked& asked) {
  const Scene& scene = asked.scene;
  const Fluid& fluid = only_fluid(scene);
  const Channel<S> walls = channel_of<S>(scene);
  require(walls.no_slip && walls.T_low && walls.T_high, "expected no-slip boundaries, each with a temperature");
  require(fluid.initial.name == "couette-thermal", "expected the initial field `couette-thermal`");
  require(!fluid.viscous_heat && fluid.expansion_per_K == 0 && scene.gravity_m_per_s2 == Real3{},
          "expected no gravity, no viscous heat and no expansion");
  const S L = walls.high - walls.low, T_low = *walls.T_low, T_high = *walls.T_high, rho0 = fluid.density_kg_per_m3,
          b = S(fluid.viscosity_decay_per_K) * (T_high - T_low);
  const Vec<S> jump = walls.v_high - walls.v_low;
  thermal_diffusivity<S>(fluid);
  Field<S> made;
  made.at = [=](S) -> FieldAt<S> {
    return [=](const Vec<S>& x) {
      Point<S> at;
      const S s = (x[walls.axis] - walls.low) / L;
      at.v = walls.v_low + (b == 0 ? s : expm1(b * s) / expm1(b)) * jump;
      at.T = T_low + s * (T_high - T_low);
      at.density = rho0;
      return at;
    };
  };
  return made;
}

}  // namespace

Solution poiseuille() {
  return {"poiseuille",
          "start-up of Poiseuille's flow: Morris, Fox and Zhu, J. Comput. Phys. 136 (1997) 214, eq. 22",
          {true, true, true, false},
          solve_channel_flows<Narrow>,
          solve_channel_flows<Wide>};
}

Solution couette() {
  return {"couette",
          "start-up of Couette's flow: Morris, Fox and Zhu, J. Comput. Phys. 136 (1997) 214, eq. 24",
          {true, true, true, false},
          solve_channel_flows<Narrow>,
          solve_channel_flows<Wide>};
}

Solution viscous_heating() {
  return {"viscous-heating",
          "Couette flow heated by its viscosity: Bird, Stewart and Lightfoot (1960), 9.4; Brinkman 1951",
          {true, true, true, true},
          solve_viscous_heating<Narrow>,
          solve_viscous_heating<Wide>};
}

Solution couette_thermal() {
  return {"couette-thermal",
          "Couette flow with a viscosity exponential in temperature: Bird, Stewart and Lightfoot (1960), 9",
          {true, true, true, true},
          solve_couette_thermal<Narrow>,
          solve_couette_thermal<Wide>};
}

}  // namespace atwood::fluid_truth
