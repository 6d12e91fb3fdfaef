// The metrics of fluids: name, unit and definition. Fields are compared at the particles, weighted by their masses.
#include "validation/metrics/fluid_parts.hpp"

namespace atwood {

std::vector<MetricInfo> fluid_metrics() {
  std::vector<MetricInfo> all;
  // m is a particle's mass.
  const struct {
    const char *name, *formula;
  } norms[] = {{"l1", "the sum of m |error| over the sum of m |exact|"},
               {"l2", "the root of the sum of m |error|^2 over the sum of m |exact|^2"},
               {"linf", "the largest |error| over the largest |exact|"}};
  for (const char* field : {"velocity", "pressure", "density", "temperature"})
    for (const auto& norm : norms)
      all.push_back(
          {std::string(field) + "-" + norm.name, "1",
           "Error of the " + std::string(field) + " against the exact field at the particles: " + norm.formula +
               (norm.name == std::string("linf") ? "" : ", with the particles' masses m") +
               ". One row at the end, and one with a time at every sample; the reason has the norm of the exact "
               "field."});
  for (const char* field : {"velocity", "pressure", "density", "temperature"})
    for (const char* norm : {"l1", "l2", "linf"})
      all.push_back(
          {std::string(field) + "-grid-" + norm, "1",
           "Error of the " + std::string(field) +
               " on a regular grid of the fluid's spacing at the end, where the fluid fills a domain that is periodic "
               "along every axis. Values of the particles are interpolated by moving least squares of degree 4 "
               "(neighbours within three spacings, weights (1 - s)^4 (1 + 4 s)). Norm of the error over the grid "
               "points, divided by that of the exact field. The bar is the same norm of the interpolation error, found by "
               "interpolating the exact field from the particles."});
  const std::vector<MetricInfo> others = {
      {"model-error", "1",
       "Error due to compressibility: u_c - u at the particles' positions. u is the exact velocity of the "
       "incompressible equations, u_c that of the weakly compressible ones. l1 norm, over that of u; the l2 and linf "
       "norms stand in rows whose `body` is l2 or linf."},
      {"space-error", "1",
       "Error of the spatial discretisation: V - u_c(X). X and V are the positions and velocities that solve the particles' "
       "own equations of motion exactly in time, u_c the exact velocity of the weakly compressible equations. "
       "Where X and V are not known, they are replaced by those of the run, and the reason says so. l1 norm, over that of the "
       "exact velocity; l2 and linf as in model-error."},
      {"time-error", "1",
       "The error of the steps: (v - u_c(x)) - (V - u_c(X)). x and v are the run's positions and velocities, X and V those "
       "of the particles' own equations of motion, u_c the exact velocity of the weakly compressible equations. Where no "
       "field is known, v - V. l1 norm, over that of the exact velocity (of V); l2 and linf as in model-error."},
      {"closing-residual", "1",
       "Residual of the split into model, space and time error: largest |total - model - space - time| of a particle, over the largest exact velocity. It is round-off."},
      {"order-space", "1",
       "Observed order of the space-error along the ladder of spacings at one sound speed, each with its finest steps."},
      {"order-time", "1", "Observed order of the time-error along the ladder of steps at one spacing and sound speed."},
      {"order-model", "1",
       "Observed order of the model-error in the Mach number, along the ladder of sound speeds at one spacing."},
      {"kinetic-energy-error", "1",
       "Kinetic energy of the particles minus that of the exact field at the particles, at the end, over the largest "
       "kinetic energy of the exact field."},
      {"energy-budget", "1",
       "Largest |E - E0| over the samples. E is the sum of kinetic energy, elastic energy (the integral of p / rho^2), "
       "potential energy and heat. Divided by the largest kinetic energy plus the largest change of potential and elastic "
       "energy. Only where nothing else takes or gives energy."},
      {"heat-entered-error", "1",
       "Heat that the fluid gained, the sum of m C (T - T at the start), minus the given fluxes times the areas of their "
       "walls times the time, at the end, over the sum of |flux| area time. Only where one box of fluid fills the space "
       "between fixed planes and periods, every plane has a flux or is insulated, and nothing else makes heat. The "
       "reason has the same sum of the exact temperatures: its deviation is a quadrature error, for on disturbed "
       "particles the masses are not exact quadrature weights."},
      {"work-by-diffusion", "1",
       "Work of the density's diffusion (+sph{density_diffusion}) over the run, over the scale of energy-budget; positive "
       "where the fluid gains energy. Its power is computed from the particles of each sample by the reference's sums, the "
       "integral is Simpson's rule over the samples; the bar is the largest of its differences to the trapezoidal rule and to "
       "itself over every second sample, and of energy-unaccounted."},
      {"work-by-shift", "1",
       "Work of the motion relative to the fluid that keeps particles in order (+sph{shift}), with its fluxes, found as "
       "work-by-diffusion is."},
      {"work-by-viscosity", "1",
       "Work of viscosity among particles and at walls, minus the heat that viscous_heat makes of it, found as "
       "work-by-diffusion is; the work of moving walls is included."},
      {"work-by-bodies", "1",
       "Work of the other terms of bodies that can move: the pressure of their points, which is extrapolated from the "
       "fluid, and heat through them; found as work-by-diffusion is. The energy is that of the fluid only."},
      {"work-by-walls", "1",
       "Work of the other terms of fixed walls: the pressure of their points, which is extrapolated from the fluid, and "
       "heat through them; found as work-by-diffusion is."},
      {"work-by-sources", "1",
       "Work of body accelerations (`source`) and of buoyancy (`expansion_per_K`), found as work-by-diffusion is."},
      {"energy-unaccounted", "1",
       "|E - E0 - work| at the end, over the scale of energy-budget: the part that neither pressure between "
       "particles nor the rows of work explain: the error of the time steps and of the quadrature. If it exceeds a fifth of "
       "the works, the samples are too few for the motion (sound, for instance), and the rows of work are left out. Only for +sph and "
       "nine samples or more; with density=summation, without shift and without walls that move within their own plane."},
      {"neighbours", "1",
       "Mean number of other particles within the support of the method's kernel, at the end, walls not counted. The "
       "reason has the support."},
      {"ns-per-particle-evaluation", "ns",
       "Time of the whole run (run-time) over its evaluations of the rate and the number of particles. The reason has "
       "both, and the neighbours where they are known."},
      {"volume-error", "1", "Ratio of the sum of m / rho at the end to that at the start, minus 1."},
      {"fluid-momentum-error", "1",
       "Largest change of the linear momentum of fluids and moving bodies over the samples, minus the impulse of gravity and "
       "of point forces that are always on, divided by the sum of |m v|. Only where no other force acts from outside."},
      {"fluid-angular-momentum-error", "1",
       "Largest change of the angular momentum about the origin over the samples, divided by the sum of |m x v|. Only where "
       "no force acts from outside and space has no period."},
      {"particle-order", "1",
       "Standard deviation over mean of the distance to the nearest particle, at the end: 0 on a lattice, about 0.5 where "
       "particles lie at random."},
      {"spacing-min", "1", "Least distance of two particles at the end, over their spacing."},
      {"speed-max", "m/s", "Largest speed of a particle at the end: the noise of a fluid that should rest."},
      {"front-error", "1", "The probe `front` minus its true value, over that value."},
      {"front-speed-error", "1",
       "Speed of the run's front over that of the measured one, minus 1. Both are slopes of straight lines through the same "
       "places, from 1.4 of the front's first distance on."},
      {"front-delay", "s",
       "How much later the measured front is than the run's: the delay that makes front-delayed-error least. Releasing the "
       "column takes time."},
      {"front-delayed-error", "1",
       "Largest |front / measured front - 1| after that one delay, over the readings from 1.4 of the distance at t = 0 on."},
      {"probe-error", "1", "A probe minus its true value, over that value; `body` names the probe."},
  };
  all.insert(all.end(), others.begin(), others.end());
  return all;
}

}  // namespace atwood
