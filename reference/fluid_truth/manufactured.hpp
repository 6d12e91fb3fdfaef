// Manufactured solutions: a field, and the acceleration that makes it one of the equations
//   rho_t + div(rho u) = 0,   u_t + u.grad u = -grad p(rho) / rho + rho0 nu / rho lap u + s
// P. J. Roache, J. Fluids Eng. 124 (2002) 4; K. Salari and P. Knupp, SAND2000-1444.
#pragma once

#include "fluid_truth/number.hpp"
#include "scene/fluid.hpp"
#include "scene/scene.hpp"

namespace atwood::fluid_truth {

// "mms-2d", with the parameters of the field (k = 2 pi / length, W = cos(w t), s_i = sin k x_i, c_i = cos k x_i):
//   u = U W (sx cy, -cx sy),   rho = rho0 (1 + a sx sy)
// "mms-3d":
//   u = U W (sx (cz sy^2 - cy sz^2), sy (cx sz^2 - cz sx^2), sz (cy sx^2 - cx sy^2)),   rho = rho0 (1 + a sx sy sz)
// Both have div u = 0 and u.grad rho = 0, so that the density does not change. The second is
// grad f x grad(cx + cy + cz) / k^2 with f = sx sy sz.
template <class S> struct Manufactured {
  int dimensions = 2;
  S k{}, U{}, w{}, a{};
  S rho0{}, c{}, gamma{}, nu{};  // gamma = 1: linear equation of state

  Vec<S> velocity(S t, const Vec<S>& x) const;
  S density(const Vec<S>& x) const;
  // The derivation by hand: s = u_t + u.grad u + c^2 (rho / rho0)^(gamma - 1) grad rho / rho - rho0 nu / rho lap u.
  Vec<S> source(S t, const Vec<S>& x) const;
};

// The field of this name with the parameters of `field`; throws Refused for another name.
template <class S> Manufactured<S> manufactured_of(const Scene& scene, const Fluid& fluid, const InitialField& field);
template <> Manufactured<double> manufactured_of(const Scene& scene, const Fluid& fluid, const InitialField& field);

}  // namespace atwood::fluid_truth
