// Every metric's name, unit and definition, once.
#include <algorithm>
#include <stdexcept>

#include "validation/metrics/fluid_parts.hpp"
#include "validation/metrics/joints.hpp"
#include "validation/metrics/measurements.hpp"

namespace atwood {

namespace {

// The orders of one quantity's error: over the run, and of the end, the largest and the root mean square alone.
std::vector<MetricInfo> order_metrics(const std::string& quantity, const std::string& largest) {
  const std::string order = "order-" + quantity, error = "error-" + quantity,
                    fitted = " on log h over the asymptotic window; bar = 95 % half-width; NaN: inconclusive.";
  return {
      {order, "1",
       "Observed order over the run, that of the largest error: order-" + quantity +
           "-max. Where the order at the end is higher beyond both intervals the reason says `superconvergent at the "
           "samples`."},
      {order + "-end", "1", "Slope of log " + error + "-end" + fitted},
      {order + "-max", "1", "Slope of log " + largest + fitted + " All rungs have the same instants."},
      {order + "-rms", "1", "Slope of log " + error + "-rms" + fitted + " All rungs have the same instants."}};
}

// Definitions that have changed, with what they were.
void tell_changes(std::vector<MetricInfo>& all) {
  const auto changed = [&](MetricInfo& metric) -> const char* {
    const std::string& name = metric.name;
    for (const char* quantity : {"position", "velocity", "attitude", "body-rate", "joint-coordinate"}) {
      if (name == std::string("order-") + quantity)
        return "the order of the largest error over the run; it was the end's";
      if (name == std::string("error-") + quantity + "-max" || name == std::string("error-") + quantity + "-rms")
        return "over instants between the samples too";
    }
    for (const char* over_instants :
         {"error-joint-coordinate", "error-joint-angle", "error-joint-offset", "error-joint-rate", "energy-max",
          "energy-drift", "energy-oscillation", "energy-change-max", "energy-change-drift", "energy-change-oscillation",
          "jacobi-constant-error", "growth-exponent-position", "growth-exponent-attitude", "growth-exponent-energy",
          "tolerance-ratio", "tolerance-exponent"})
      if (name == over_instants) return "over instants between the samples too";
    return nullptr;
  };
  for (MetricInfo& metric : all)
    if (const char* what = changed(metric)) metric.version = 2, metric.changed = what;
}

std::vector<MetricInfo> common_metrics() {
  return {
      {"status", "", "How the cell ended when it could not be measured; the reason says why."},
      {"truth", "", "How the scene's truth ended when it gave no solution: no error is measured; the reason says why."},
      {"error-position-end", "m", "Distance from the true position at the last sample; the worst body."},
      {"error-position-max", "m",
       "Largest distance from the true position over the instants of the run (samples, and instants between them that all "
       "rungs of the ladder share), t = 0 left out; the worst body. With errors e and bars b there, the true value lies in "
       "[max(e - b), max(e + b)]."},
      {"error-position-rms", "m",
       "Root mean square of the distance from the true position over the judged instants: of those that all rungs of the "
       "ladder share one in each of 64 or more equal parts of the run; the worst body."},
      {"error-velocity-end", "m/s", "Norm of the velocity's error at the last sample; the worst body."},
      {"error-velocity-max", "m/s",
       "Largest norm of the velocity's error over the instants of the run (see error-position-max), those on the instant "
       "of an impact left out; the worst body."},
      {"error-velocity-rms", "m/s",
       "Root mean square of the velocity's error over the judged instants (see error-position-rms); the worst body."},
      {"error-attitude-end", "rad",
       "Geodesic angle to the true attitude at the last sample, the same for q and -q; the worst body."},
      {"error-attitude-max", "rad",
       "Largest geodesic angle to the true attitude over the instants of the run (see error-position-max); the worst "
       "body."},
      {"error-attitude-rms", "rad",
       "Root mean square of the geodesic angle to the true attitude over the judged instants (see error-position-rms); "
       "the worst body."},
      {"quaternion-norm-drift", "1",
       "Largest | |q| - 1 | over the samples and the bodies that turn, reported where it is above 1e-6: methods that do "
       "not normalise the quaternion drift, which the angle of an attitude hides."},
      {"error-body-rate-end", "rad/s",
       "Norm of the error of the body-axes angular velocity at the last sample; the worst body."},
      {"error-body-rate-max", "rad/s",
       "Largest norm of the error of the body-axes angular velocity over the instants of the run (see "
       "error-position-max), those on the instant of an impact left out; the worst body."},
      {"error-body-rate-rms", "rad/s",
       "Root mean square of the body-axes angular velocity's error over the judged instants (see error-position-rms); "
       "the worst body."},
      {"error-state-end", "1",
       "Relative 2-norm of the whole state's error at the last sample: positions [m] and velocities [m/s] of all "
       "moving bodies in one vector, over the norm of the true one."},
      {"size-position", "m",
       "Largest distance from the origin along the true motion: what relative errors and round-off floors are scaled "
       "by."},
      {"size-velocity", "m/s", "Largest speed along the true motion."},
      {"size-body-rate", "rad/s", "Largest angular speed along the true motion."},
      {"condition", "1",
       "Condition number of the flow: (|dx(t_end)| / S) / eps for an initial perturbation by eps of each vector's own "
       "size, S the size of the trajectory."},
      {"energy-scale", "J",
       "E_scale, one per scene for all methods and steps: largest kinetic energy + |V - V0| over the truth's "
       "samples, or over a run of the reference with converged energy, without a truth or where the samples miss more "
       "than 1 % of it (the reason says which)."},
      {"energy-max", "1", "Largest |E - E0| / E_scale over the instants of the run (see error-position-max)."},
      {"energy-drift", "1/s",
       "Slope of (E - E0) / E_scale by Theil and Sen over t = 0 and the judged instants (see error-position-rms), an "
       "oscillation removed; positive: E grows. Bar: 95 %, for correlated "
       "noise or a walk hidden under it; where not stationary, or of fewer than ten samples, the mean slope and "
       "Student's interval over at most eight parts. NaN: round-off (see energy-drift-round-off), or fewer than five "
       "samples."},
      {"energy-oscillation", "1",
       "Half the range of (E - E0) / E_scale about its drift, at the instants of energy-drift."},
      {"energy-change-max", "J", "energy-max of scenes without E_scale: largest |E - E0|."},
      {"energy-change-drift", "W", "energy-drift of scenes without E_scale: slope of E - E0."},
      {"energy-change-oscillation", "J", "Half the range of E - E0 about its drift, of scenes without E_scale."},
      {"energy-drift-round-off", "1/s",
       "Mean slope of the round-off in energy over E_scale, from 96 runs perturbed in the last place and their "
       "differences from the same runs in wider arithmetic; bar = 95 % by bootstrap over runs."},
      {"energy-change-drift-round-off", "W", "energy-drift-round-off of scenes without E_scale, in joules per second."},
      {"momentum-error", "kg m/s",
       "Largest |P(t) - P(0) - M g t|: linear momentum, uniform gravity's impulse accounted for."},
      {"momentum-error-relative", "1", "momentum-error over the largest sum of m |v|."},
      {"angular-momentum-error", "kg m^2/s",
       "Largest change of angular momentum: about the attractor or anchor where there is one, about the centre of mass "
       "under uniform gravity, else the larger of origin and centre of mass."},
      {"angular-momentum-error-relative", "1", "angular-momentum-error over the largest |L| about the same point."},
      {"center-of-mass-error", "m", "Largest |X(t) - X(0) - V(0) t - g t^2 / 2| of the centre of mass."},
      {"jacobi-constant-error", "1", "Largest change of the Jacobi constant, over E_scale."},
      {"laplace-runge-lenz-error", "1",
       "Largest change of the Laplace-Runge-Lenz vector over mu: of the eccentricity vector."},
      {"magnetic-moment-error", "1",
       "Largest change of m v_perp^2 / 2B in the drift frame, over its value at the start."},
      {"growth-exponent-position", "1",
       "Exponent of the law by which the position error grows, at the judged instants (see error-position-rms; reason: its "
       "name); bar = 95 %; NaN: inconclusive."},
      {"growth-exponent-attitude", "1",
       "Exponent of the law by which the attitude error grows, at the judged instants (see error-position-rms; reason: its "
       "name); bar = 95 %; NaN: inconclusive."},
      {"growth-exponent-energy", "1",
       "Exponent of the law by which |E - E0| grows, at the judged instants (see error-position-rms; reason: its name); "
       "bar = 95 %; NaN: inconclusive."},
      {"growth-exponent-round-off-energy", "1",
       "Exponent of the law by which the root mean square of the round-off in energy grows (reason: its name; "
       "Brouwer's law: t^1/2), from 96 runs perturbed in the last place and their differences from the same runs in "
       "wider arithmetic; bar = 95 % by bootstrap over runs; NaN: inconclusive. If the method's energy error "
       "oscillates far above round-off, phase shifts of that oscillation are included."},
      {"growth-exponent-round-off-position", "1",
       "Exponent of the law by which the root mean square of the round-off in position grows, found as "
       "growth-exponent-round-off-energy is (Brouwer's law of the phase: t^3/2)."},
      {"growth-exponent-round-off-attitude", "1",
       "Exponent of the law by which the root mean square of the round-off in attitude grows, found as "
       "growth-exponent-round-off-energy is."},
      {"round-off-rms-position", "m",
       "Root mean square, over the 96 runs, of the round-off in position at the last sample; the worst body."},
      {"round-off-best-error", "m",
       "Least error-position-end along the ladder; reported only if the two next finer steps have larger errors."},
      {"round-off-best-step", "s", "The step of round-off-best-error."},
      {"reversal-error-position", "m",
       "Distance from the initial position after the run, a reversal of velocities, and as many steps back; the "
       "worst body or particle."},
      {"reversal-error-velocity", "m/s",
       "Norm of the difference from the initial velocity after the run forward and back; the worst body or particle."},
      {"reversal-error-attitude", "rad",
       "Angle from the initial attitude after the run forward and back; the worst body."},
      {"reversal-error-body-rate", "rad/s",
       "Norm of the difference from the initial body rate after the run forward and back; the worst body."},
      {"reversal-over-round-off", "1",
       "The reversal error divided by the expected round-off of both passes, u sqrt(steps) size condition; the largest "
       "of position, velocity, attitude and body rate."},
      {"symplecticity-defect", "1",
       "Frobenius norm of M^T J M - J, where M is the derivative of the final by the initial state in scaled canonical "
       "variables; bar: its least change between two successive steps of the finite differences."},
      {"poisson-defect", "1",
       "For a freely rotating body: Frobenius norm of M hat(L0) M^T - hat(L) over |L|, where M is the derivative of "
       "L by L0 in body axes; bar: its least change between two successive steps of the finite differences."},
      {"horizon", "s",
       "Predictability horizon: the time at which two runs that start 1e-10 of the scale apart are 1e-3 of it apart; "
       "the run's end where they stay closer."},
      {"lyapunov-exponent", "1/s",
       "Mean exponential rate at which two neighbouring runs separate, their distance reset after each sample "
       "(Benettin et al. 1980); bar = 95 % from means of ten blocks. NaN: not resolved, the separation may grow like a "
       "power of time (up to t^2)."},
      {"state-differences", "1",
       "Number of values of the samples (instants, bodies, particles, joints) differ in any bit between the run and the "
       "same run repeated, or a run with another number of threads."},
      {"state-hash", "1",
       "The upper 48 bits of the 64-bit hash (xxHash, XXH64) of the last sample's numbers, widened to quadruple "
       "precision, in the order of the scene: equal on every machine, compiler and thread count, or the bits differ."},
      {"tolerance-ratio", "1",
       "Relative position error (error-position-max over size-position) divided by the relative tolerance of the run."},
      {"tolerance-exponent", "1",
       "Slope of log error-position-max against log rtol; tolerances whose error is within 30 times the floor are "
       "left out. 1: proportional; bar = 95 %; NaN: inconclusive."},
      {"gci-position", "m",
       "Grid convergence index of the worst body's last position from the finest three usable steps, "
       "1.25 |x2 - x1| / (r^p - 1): the band about the finest value. No truth is used. The reason says whether the "
       "observed order agrees with that of the next three coarser steps, and with the formal order where it is known. Three steps alone do not test "
       "the asymptotic range."},
      {"richardson-order-position", "1",
       "Order p from the differences of positions between the finest three usable steps; negative where the "
       "differences grow as h decreases."},
      {"gci-effectivity", "1",
       "True error at the finest step of gci-position, over gci-position: at most 1 where the index bounds the error."},
      {"order-impact-time", "1",
       "Slope of log impact-time-error on log h over the asymptotic window; bar = 95 % half-width; NaN: inconclusive."},
      {"landing-range-error", "m",
       "Horizontal distance flown to z = 0 minus the true one; landing by the parabola through three samples, on run "
       "and truth alike; positive: too far."},
      {"impact-time-error", "s",
       "Largest error |t_k - true t_k| of an impact's time. Impacts of a pair are matched by their number k; only those "
       "after a flight higher than 1e-3 m count. NaN: the run reports fewer impacts than the truth."},
      {"impact-place-error", "m",
       "Largest distance of a reported contact point from the true one, over the impacts of impact-time-error."},
      {"impact-normal-impulse-error", "N s",
       "Largest |J_n - true J_n| of the normal impulse J_n, over the impacts of impact-time-error."},
      {"impact-tangential-impulse-error", "N s",
       "Largest difference of the sizes of the tangential impulse and the true one, over the impacts of "
       "impact-time-error."},
      {"transition-time-error", "s",
       "Largest error |t_k - true t_k| of the time at which a contact's regime changes (rest, slip, stick, roll, "
       "separate). Changes of one kind and pair are matched by their number k. NaN: the run reports fewer than the truth."},
      {"impact-count-error", "1",
       "Number of reported impacts minus number of true ones; only impacts after a clearance of at least 1e-3 m are "
       "counted."},
      {"apex-error", "1",
       "Largest |apex - true apex| / true apex over the first five apexes after an impact; an apex is the clearance at "
       "the vertex of the parabola through three samples of one flight, the same samples of run and truth."},
      {"restitution-error", "1",
       "Largest |-vn_after / vn_before - e| over the reported impacts that fell from a clearance of at least 1e-3 m."},
      {"energy-gain", "1",
       "Contacts under gravity alone: largest rise of the energy above its least value before, over E_scale; 0 where "
       "it only falls."},
      {"energy-rise", "J",
       "energy-gain of scenes without E_scale: largest rise of the energy above its least value before."},
      {"contact-energy-gain", "J",
       "Largest work of a reported normal impulse, J (vn_before + vn_after) / 2; zero or less where no contact gains "
       "energy."},
      {"cone-violation", "1",
       "Largest max(0, |f_t| - mu f_n) over the largest f_n, of the contacts in the samples and the reported "
       "impulses."},
      {"signorini-gap", "m",
       "Largest |gap| of a contact that carries force, over the samples: a contact with a gap must carry no "
       "force."},
      {"signorini-pull", "N",
       "Largest tensile force of a contact, max(0, -f_n), over the samples: contacts can only push."},
      {"dissipation-defect", "1",
       "Largest mu f_n |u_t| + f_t . u_t over the largest mu f_n times the largest speed of slip or of a touching body "
       "(u_t: slip of b on a): 0 where friction has its full size and opposes the slip; no row where nothing moves."},
      {"contact-misses", "1",
       "Poses of a sweep that overlap by more than round-off of their positions and where the engine finds no "
       "contact."},
      {"contact-false-hits", "1",
       "Poses of a sweep that are apart by more than round-off of their positions and where the engine finds a "
       "contact."},
      {"touch-misses", "1", "Swept poses that touch within a second and where the engine finds no touch."},
      {"touch-false-hits", "1", "Swept poses that never touch within a second and where the engine finds a touch."},
      {"contact-depth-error-median", "1",
       "|deepest reported depth - least-penetration depth| over the smaller body's bounding radius, over overlapping "
       "poses of a sweep: median."},
      {"contact-depth-error-p99", "1",
       "|deepest reported depth - least-penetration depth| over the smaller body's bounding radius, over overlapping "
       "poses of a sweep: 99th percentile."},
      {"contact-depth-error-max", "1",
       "|deepest reported depth - least-penetration depth| over the smaller body's bounding radius, over overlapping "
       "poses of a sweep: largest."},
      {"contact-normal-error-median", "rad",
       "Angle between reported and true normal, over overlapping poses of a sweep in which no other "
       "direction has a depth within 0.1 % of the least: median."},
      {"contact-normal-error-p99", "rad",
       "Angle between reported and true normal, over overlapping poses of a sweep in which no other "
       "direction has a depth within 0.1 % of the least: 99th percentile."},
      {"contact-normal-error-max", "rad",
       "Angle between reported and true normal, over overlapping poses of a sweep in which no other "
       "direction has a depth within 0.1 % of the least: largest."},
      {"contact-distance-error-median", "1",
       "|reported distance - true distance| over the smaller body's bounding radius, over poses of a sweep that are "
       "apart, of engines that report it: median."},
      {"contact-distance-error-p99", "1",
       "|reported distance - true distance| over the smaller body's bounding radius, over poses of a sweep that are "
       "apart, of engines that report it: 99th percentile."},
      {"contact-distance-error-max", "1",
       "|reported distance - true distance| over the smaller body's bounding radius, over poses of a sweep that are "
       "apart, of engines that report it: largest."},
      {"touch-time-error-median", "s",
       "|reported first touch - true one| over swept poses that touch within a second: median."},
      {"touch-time-error-p99", "s",
       "|reported first touch - true one| over swept poses that touch within a second: 99th percentile."},
      {"touch-time-error-max", "s",
       "|reported first touch - true one| over swept poses that touch within a second: largest."},
      {"penetration-max", "m",
       "Deepest overlap of two shapes over the samples; 0 when none. NaN: shapes came near whose depth cannot be "
       "computed (a cylinder with anything but a sphere or a plane)."},
      {"penetration-rms", "m", "Root mean square over the samples (t = 0 left out) of the deepest overlap."},
      {"penetration-relative", "1",
       "Deepest overlap over the samples in units of the smaller body: its radius or least half extent."},
      {"step-time", "s",
       "Time of one step: median over the repeats of the timed pass, which records no samples. Bar: distance to the "
       "farther end of the median's 95 % interval by order statistics; with fewer than six repeats their range; with "
       "one, unknown."},
      {"step-time-p95", "s",
       "Time of one step: 95th percentile over the repeats of the timed pass, from 20 repeats on."},
      {"run-time", "s",
       "Time of the whole run: the same median as step-time's, times the number of steps taken, with the same bar."},
      {"step-time-wasm", "s",
       "step-time of an engine that runs as WebAssembly under Node.js. No ranking, goal or gate compares it with the "
       "step-time of native engines: a native build of the same engine has another step time."},
      {"run-time-wasm", "s", "run-time of an engine that runs as WebAssembly under Node.js, as step-time-wasm."},
      {"call-time-wasm", "s",
       "Part of step-time-wasm: a step of a world without bodies, which is the call from JavaScript and what the engine "
       "does in any step. Median of 11 means over 200 steps, times the substeps."},
      {"solver-capped", "1",
       "Solves that ended above their tolerance: at the iteration limit, or because the iteration diverged. `body` "
       "names the solver; without it all solvers of the run are counted. Of contact-sweeps most "
       "end capped: bodies in motion are not swept to convergence."},
      {"solver-residual-max", "1",
       "Largest residual that a solve ended with. `body` names the solver, the reason the scale of its residual; "
       "without `body`: the largest of all solvers. Solves of rejected steps are left out."},
      {"solver-iterations-max", "1", "Largest number of iterations of one solve; `body` names the solver."},
      {"solver-converged", "1",
       "Solves whose residual fell to the solver's own tolerance. `body` names the solver; `atwood list metrics` says "
       "what each one solves."},
      {"solver-stagnated", "1",
       "Solves whose residual stopped falling at round-off, above the solver's own tolerance. `body` names the "
       "solver."},
      {"rate-evaluations", "1", "Evaluations of the equations of motion over the run, as the engine counts them."},
      {"steps-taken", "1",
       "Accepted steps of a run with a tolerance, which chooses them itself; of runs with equal "
       "steps only if no other figure is reported."},
  };
}

}  // namespace

const std::vector<MetricInfo>& all_metrics() {
  static const std::vector<MetricInfo> metrics = [] {
    std::vector<MetricInfo> all = common_metrics();
    const auto before =
        std::find_if(all.begin(), all.end(), [](const auto& m) { return m.name == "order-impact-time"; });
    std::vector<MetricInfo> orders;
    for (const char* quantity : {"position", "velocity", "attitude", "body-rate"})
      for (MetricInfo& one : order_metrics(quantity, std::string("error-") + quantity + "-max"))
        orders.push_back(std::move(one));
    all.insert(before, orders.begin(), orders.end());
    for (const std::vector<MetricInfo>& family :
         {joint_metrics(), order_metrics("joint-coordinate", "error-joint-coordinate"), fluid_metrics()})
      all.insert(all.end(), family.begin(), family.end());
    tell_changes(all);
    return all;
  }();
  return metrics;
}

namespace metrics {

Row row(const std::string& metric, double value, double bar, std::string reason) {
  const auto& known = all_metrics();
  const auto found = std::find_if(known.begin(), known.end(), [&](const MetricInfo& m) { return m.name == metric; });
  if (found == known.end()) throw std::logic_error("metric `" + metric + "` is not in the catalogue");
  Row r;
  r.metric = metric;
  r.unit = found->unit;
  r.value = value;
  r.truth_bar = bar;
  r.reason = std::move(reason);
  return r;
}

}  // namespace metrics
}  // namespace atwood
