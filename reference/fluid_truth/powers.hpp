// Power of the terms of `+sph` (docs/fluids.md) that give or take energy, in one state of the particles.
//
// With E = sum m (v^2 / 2 + e(rho) + C T - g . x), e' = p / rho^2, the rate f of the particles' equations changes E by
// grad E . f. The power of a term is the difference of this number with and without the term, taken away in this order:
//   diffusion   density_diffusion
//   shift       the motion relative to the fluid and its fluxes
//   viscosity   fluid and walls, less the heat that `viscous_heat` makes of it; of walls that move, what they drag
//   bodies      what is left of the boundaries that can move: their pressure and their heat
//   walls       the same of the others
//   sources     the body acceleration of a manufactured field, and buoyancy, -expansion (T - T0) g
// The sums of pairs that remain keep the energy, so that the six are the whole of dE / dt. E is of the particles alone:
// what bodies gain, the fluid loses. A density by summation changes as the sum of continuity says, without diffusion.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "protocol/sample.hpp"
#include "scene/scene.hpp"

namespace atwood {

// [W]; in two dimensions per metre of depth. Positive: the fluid's energy grows.
struct FluidPowers {
  double diffusion = 0, shift = 0, viscosity = 0, bodies = 0, walls = 0, sources = 0;
};

class FluidPowersOf {
 public:
  // `response`: "sph{...}" with all settings. `unsupported` says why there are no powers: another response, a density
  // by summation with shift or with a wall that slides in itself, and what the semi-discrete truth does not cover, but
  // for bodies that move.
  FluidPowersOf(const Scene& scene, const std::string& response);
  ~FluidPowersOf();
  const std::string& unsupported() const { return unsupported_; }
  // Of the particles and bodies of a sample at t.
  FluidPowers at(double t_s, std::span<const ParticleSample> particles, std::span<const BodySample> bodies) const;

 private:
  struct Systems;
  std::unique_ptr<Systems> systems_;
  std::string unsupported_;
};

}  // namespace atwood
