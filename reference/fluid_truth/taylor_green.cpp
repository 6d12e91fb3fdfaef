// Decay of a doubly periodic array of vortices, incompressible. G. I. Taylor and A. E. Green, Proc. R. Soc. Lond. A 158
// (1937) 499; in this form A. J. Chorin, Math. Comp. 22 (1968) 745. With k = 2 pi mode / L and the decay e = exp(-2 nu
// k^2 t):
//   u = -U cos(kx) sin(ky) e,   v = U sin(kx) cos(ky) e,   p = -rho0 U^2 / 4 (cos(2kx) + cos(2ky)) e^2
// The convection u.grad u = -(k U^2 e^2 / 2) (sin 2kx, sin 2ky) is balanced by the gradient of p, and lap u = -2 k^2 u.
#include "fluid_truth/solution.hpp"

namespace atwood::fluid_truth {

namespace {

template <class S> Field<S> solve_taylor_green(const Asked& asked) {
  const Scene& scene = asked.scene;
  const Fluid& fluid = only_fluid(scene);
  require(scene.domain.dimensions == 2, "expected two dimensions");
  require(fluid.initial.name == "taylor-green", "expected the initial field `taylor-green`");
  require(!has_boundaries(scene) && scene.gravity_m_per_s2 == Real3{} && fluid.source.name.empty(),
          "expected no boundary, no gravity and no source");
  const S k = wave_number<S>(scene, fluid.initial, 0), U = parameter(fluid.initial, "speed_m_per_s", 1),
          rho0 = fluid.density_kg_per_m3, nu = fluid.viscosity_m2_per_s;
  require_period<S>(scene, k, 0);
  require_period<S>(scene, k, 1);
  Field<S> made;
  made.at = [=](S t) -> FieldAt<S> {
    const S e = exp(-2 * nu * k * k * t);
    return [=](const Vec<S>& x) {
      Point<S> at;
      const S sx = sin(k * x[0]), cx = cos(k * x[0]), sy = sin(k * x[1]), cy = cos(k * x[1]);
      at.v = {-U * cx * sy * e, U * sx * cy * e, S(0)};
      // cos(2a) + cos(2b) = 2 (1 - sin^2 a - sin^2 b)
      at.p = -rho0 * U * U / 2 * (1 - sx * sx - sy * sy) * e * e;
      at.density = rho0;
      return at;
    };
  };
  return made;
}

// One row of parallel streams, u = U sin(ky) exp(-nu k^2 t), v = 0: no convection, no pressure, and no change of
// density, so that the compressible equations have the same solution (Batchelor, An Introduction to Fluid Dynamics,
// 4.3).
template <class S> Field<S> solve_shear(const Asked& asked) {
  const Scene& scene = asked.scene;
  const Fluid& fluid = only_fluid(scene);
  require(fluid.initial.name == "shear", "expected the initial field `shear`");
  require(!has_boundaries(scene) && scene.gravity_m_per_s2 == Real3{} && fluid.source.name.empty(),
          "expected no boundary, no gravity and no source");
  const S k = wave_number<S>(scene, fluid.initial, 1), U = parameter(fluid.initial, "speed_m_per_s", 1),
          rho0 = fluid.density_kg_per_m3, nu = fluid.viscosity_m2_per_s;
  require_period<S>(scene, k, 1);
  Field<S> made;
  made.at = [=](S t) -> FieldAt<S> {
    const S now = U * exp(-nu * k * k * t);
    return [=](const Vec<S>& x) {
      Point<S> at;
      at.v = {now * sin(k * x[1]), S(0), S(0)};
      at.density = rho0;
      return at;
    };
  };
  return made;
}

}  // namespace

Solution shear() {
  return {"shear",
          "parallel streams that decay by viscosity: Batchelor, An Introduction to Fluid Dynamics (1967), 4.3",
          {true, true, true, false},
          solve_shear<Narrow>,
          solve_shear<Wide>};
}

Solution taylor_green() {
  return {"taylor-green",
          "Taylor and Green, Proc. R. Soc. Lond. A 158 (1937) 499: decaying vortices, incompressible",
          {true, true, true, false},
          solve_taylor_green<Narrow>,
          solve_taylor_green<Wide>};
}

}  // namespace atwood::fluid_truth
