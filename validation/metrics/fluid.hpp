// What the recording of a fluid says: its fields against exact ones at the particles, what it conserves, its probes.
//
// Norms are over the particles, weighted by their masses: l1 sum m |e| / sum m |f|, l2 the root of sum m |e|^2 over
// sum m |f|^2, linf max |e| / max |f|, where f is the exact field at the same particles and |.| the Euclidean norm of a
// velocity. Where f is 0 everywhere, the scale is the sound speed (velocity), rho0 c^2 (pressure), rho0 (density), 1 K.
//
// The velocity's error is the sum of three, particle by particle, each exact field taken at the positions of the
// solution that it is compared with:
//   v_i - u(x_i)  =  (u_c - u)(x_i)                                          model: the fluid is compressible
//                  + V_i - u_c(X_i)                                          space: it is particles
//                  + (v_i - u_c(x_i)) - (V_i - u_c(X_i))                     time: they are stepped
// with u the field of the scene's truth, u_c that of the weakly compressible equations, and X, V the particles' own
// equations of motion without an error of time. Without X, V the last two are one, which is called `space-error` with
// the reason that says so; without u_c it is u, and there is no model error.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "protocol/fluid_field.hpp"
#include "protocol/truth.hpp"
#include "validation/metrics/metrics.hpp"

namespace atwood {

// A field at the particles of every sample of a solution (t = 0 included); `outcome` not ok: there is none.
struct FieldAtParticles {
  Outcome outcome;
  std::string source, note;
  FieldKnown known;
  std::vector<FieldSample> samples;
};

// Asks for the field of this kind of truth at these positions, one list a time. `response` is the method's.
using AskField = std::function<FieldAtParticles(TruthKind kind, const std::vector<Wide>& t_s,
                                                const std::vector<std::vector<FieldPosition>>& positions)>;

struct FluidTruths {
  FieldAtParticles exact;               // of the scene's truth, at the run's particles
  FieldAtParticles compressible;        // of the weakly compressible equations, at the run's particles
  Truth semi_discrete;                  // the particles' own equations; no values: not asked for, or refused
  FieldAtParticles compressible_there;  // the field that the space error is against, at the particles of semi_discrete
  FieldAtParticles on_grid;             // of the scene's truth on comparison_grid(), at the end alone
  bool model = false;                   // `compressible` is another field than `exact`
};
// Asks for what the scene's truth can tell. Without a truth everything stays empty and not ok.
FluidTruths fluid_truths(const Scenario& scenario, const Recording& run, const AskField& ask,
                         const std::function<Truth()>& semi_discrete);

// Points of a regular grid as wide as the spacing, at the centres of its cells: of scenes whose fluids are boxes that
// fill a domain which is periodic along every axis and at least six spacings long. Empty: another scene.
std::vector<FieldPosition> comparison_grid(const Scene& scene);

// As measure(), for a scene with fluids.
std::vector<Row> measure_fluid(const Scenario& scenario, const FluidTruths& truths, const Recording& run);

// Of all cells of one scenario and method: order-time along the steps of each resolution, order-space along the
// spacings of each sound speed (its finest steps), order-model along the sound speeds of each spacing, each of its
// error.
std::vector<Row> fit_fluid_orders(std::span<const Row> cells);

// Mean number of other particles within `support_m` of one, by the nearest image; 0 where there are none.
double mean_neighbours(const Domain& domain, const std::vector<std::array<double, 3>>& places_m, double support_m);

// Parts of reasons that readers of rows look for: an error over the fluid's own scale, where the exact field is 0
// everywhere; a space-error that the run's steps are part of.
inline constexpr const char* kOfOwnScale = "of the fluid's own scale";
inline constexpr const char* kWithStepsError = "includes the error of these steps";

// Support of the kernel that a response's settings (all of them, `kernel` and `smoothing` among them) mean at this
// spacing, by docs/fluids.md; 0: these settings name no kernel.
double kernel_support_m(const Settings& response, double spacing_m, bool free_surface = false);
// The row `neighbours` of a run's last sample; none for a support of 0 or a run that did not end well.
std::vector<Row> neighbour_rows(const Scene& scene, const Recording& run, double support_m);

// Rows of work of the terms that do not keep the energy: work-by-diffusion, -shift, -viscosity, -bodies, -walls,
// -sources, each where the method (`response`: "sph{...}" with all settings) and the scene have the term, and
// energy-unaccounted. Their powers are computed from the samples (reference/fluid_truth/powers.hpp) and integrated over
// them by Simpson's rule. Where the samples are too few for the motion, energy-unaccounted alone, which says so. None
// for other responses, density=summation with shift or walls that slide in themselves, more than 50 000 particles,
// fewer than nine samples, and runs that did not end well.
std::vector<Row> fluid_work_rows(const Scene& scene, const Recording& run, const std::string& response);
// The integral over equal intervals of length h, and the same by the trapezoidal rule. `bar`: the larger of the
// differences of Simpson's rule to that and to itself over every second value.
struct Integral {
  double simpson = 0, trapezoid = 0, bar = 0;
};
Integral integral_of(const std::vector<double>& values, double h);

// Value of a probe, in its unit; NaN: nothing of the fluid is there, or the probe is of another kind of recording.
//   pressure, velocity (its norm)  the linear function that fits the particles within three spacings best, weights of
//                                  Wendland C2: exact for linear fields, also beside walls
//   front                          largest x of a particle and half a spacing
//   column-height                  highest particle within one spacing of the line through the position against gravity
//                                  (y without gravity), and half a spacing
//   marker                         distance from the origin of the material point that began at the position: its place
//                                  is the linear function of places at t = 0 that fits the particles best which began
//                                  within three spacings of it, weights as above; where particles are not shifted
//   force-on-body                  NaN: it takes two samples
double probe_value(const Scene& scene, const FluidProbe& probe, const SampleView& sample);
// The same of each sample, and of force-on-body the norm of the fluid's force on the body, as its mean over the time
// since the sample before (the first: NaN), from changes of momentum alone. On a body that moves freely: of its own
// momentum, beside gravity and point forces that are always on. On a fixed body that is the only fixed boundary: of the
// fluid's momentum, beside gravity and the forces on the other bodies. NaN where other forces, joints or ropes act.
std::vector<double> probe_values(const Scene& scene, const FluidProbe& probe, const SampleSeries& samples);
// Why a probe has no value where it is NaN, in words.
std::string probe_gap(const Scene& scene, const FluidProbe& probe);
const char* probe_unit(const FluidProbe& probe);
const char* probe_kind(const FluidProbe& probe);

// Kinetic energy of all particles [J] (in two dimensions per metre of depth), one entry a sample.
std::vector<Wide> fluid_kinetic_energy(const Scene& scene, const SampleSeries& samples);

// Number of the fluid that a particle of a sample belongs to.
std::vector<int> fluid_of_particles(const Scene& scene);

}  // namespace atwood
