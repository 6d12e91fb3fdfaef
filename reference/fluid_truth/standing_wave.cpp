// A standing sound wave of small amplitude, damped by viscosity. H. Lamb, Hydrodynamics, 6th ed. (1932), art. 277 and
// 360. With rho = rho0 (1 + a cos(kx) f(t)) the linear equations are u = -(a / k) f' sin(kx) and
//   f'' + nu_L k^2 f' + c^2 k^2 f = 0,   f(0) = 1, f'(0) = 0:   f = exp(-d t) (cos w t + (d / w) sin w t),
//   d = nu_L k^2 / 2,   w^2 = c^2 k^2 - d^2
// nu_L is nu for Morris's term and 3 nu for Monaghan and Gingold's (lap u = grad div u in one dimension).
#include "fluid_truth/response.hpp"
#include "fluid_truth/solution.hpp"

namespace atwood::fluid_truth {

namespace {

template <class S> Field<S> solve_standing_wave(const Asked& asked) {
  const Scene& scene = asked.scene;
  const Fluid& fluid = only_fluid(scene);
  require(fluid.initial.name == "standing-wave", "expected the initial field `standing-wave`");
  require(!has_boundaries(scene) && scene.gravity_m_per_s2 == Real3{} && fluid.source.name.empty(),
          "expected no boundary, no gravity and no source");
  const S k = wave_number<S>(scene, fluid.initial, 0), a = parameter(fluid.initial, "amplitude", 1e-4),
          c = fluid.sound_speed_m_per_s, rho0 = fluid.density_kg_per_m3;
  require_period<S>(scene, k, 0);
  const ViscousTerm term = viscous_term_of(asked.response);
  const S factor = term == ViscousTerm::none ? 0 : term == ViscousTerm::monaghan_gingold ? 3 : 1;
  const S d = factor * S(fluid.viscosity_m2_per_s) * k * k / 2;
  require(d < c * k, "the wave is overdamped");
  const S w = sqrt((c * k - d) * (c * k + d));
  // The largest term that is left out is of the amplitude's square. The second harmonic grows as that of a simple wave,
  // a^2 (gamma + 1) / 4 c k t (Hamilton and Blackstock, Nonlinear Acoustics, 4.2); a constant part of some a^2 comes
  // with it.
  const bool tait = fluid.equation_of_state == EquationOfState::tait;
  const S steepening = ((tait ? S(fluid.tait_exponent) : S(1)) + 1) / 2;
  Field<S> made;
  made.note = "linear: the bars estimate what the square of the amplitude changes; they do not bound it";
  made.at = [=](S t) -> FieldAt<S> {
    const S decay = exp(-d * t), f = decay * (cos(w * t) + d / w * sin(w * t)),
            slope = -decay * (d * d + w * w) / w * sin(w * t), second = a * a * (1 + steepening) * (1 + c * k * t);
    return [=](const Vec<S>& x) {
      Point<S> at;
      at.v = {-a / k * slope * sin(k * x[0]), S(0), S(0)};
      at.density = rho0 * (1 + a * f * cos(k * x[0]));
      at.p = rho0 * c * c * a * f * cos(k * x[0]);
      at.neglected_v = second * c;
      at.neglected_density = second * rho0;
      at.neglected_p = second * rho0 * c * c;
      return at;
    };
  };
  return made;
}

}  // namespace

Solution standing_wave() {
  return {"standing-wave",
          "a standing sound wave, linear: Lamb, Hydrodynamics (1932), art. 277, 360",
          {true, true, true, false},
          solve_standing_wave<Narrow>,
          solve_standing_wave<Wide>};
}

}  // namespace atwood::fluid_truth
