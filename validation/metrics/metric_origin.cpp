// Notation: x, v, q, w: position, velocity, quaternion and body rate of the run, a star: of the truth; t_k: instants of
// the samples; h: step, n: number of steps, u: unit round-off; E, T, V: energy, kinetic and potential; P, L: momentum
// and angular momentum; g: gap or gravity; f_n, f_t, J_n, J_t: normal and tangential forces and impulses, u_n, u_t:
// relative velocities.
#include "validation/metrics/metric_origin.hpp"

#include <map>
#include <stdexcept>

namespace atwood {
namespace {

const std::string global_error = "Hairer, Norsett, Wanner, Solving ODEs I (2nd ed.), section II.3 (global error)";
const std::string convergence = "Hairer, Norsett, Wanner, Solving ODEs I (2nd ed.), section II.3";
const std::string step_size = "Hairer, Norsett, Wanner, Solving ODEs I (2nd ed.), section II.4";
const std::string angles = "Huynh, J. Math. Imaging Vis. 35 (2009) 155";
const std::string momenta = "Goldstein, Classical Mechanics (2nd ed.), section 1-2";
const std::string energy_of_long_runs =
    "Hairer, Lubich, Wanner, Geometric Numerical Integration (2nd ed.), section IX.8";
const std::string reversal = "Hairer, Lubich, Wanner, Geometric Numerical Integration (2nd ed.), section V.1";
const std::string nonsmooth = "Acary, Brogliato, Numerical Methods for Nonsmooth Dynamical Systems (2008)";
const std::string impacts = "Stronge, Impact Mechanics (2000)";
const std::string joints = "Featherstone, Rigid Body Dynamics Algorithms (2008)";
const std::string particles = "Monaghan, Rep. Prog. Phys. 68 (2005) 1703";
const std::string dam_break = "Martin, Moyce, Philos. Trans. R. Soc. A 244 (1952) 312";
const std::string here = "here";
const std::string iterations = "Kelley, Iterative Methods for Linear and Nonlinear Equations (1995)";

using Origins = std::map<std::string, MetricOrigin>;
const Origins& origins_of_motion() {
  static const Origins all{
      {"error-position-end", {"e(t_end), e = |x - x*|", global_error}},
      {"error-position-max", {"max_k e(t_k), e = |x - x*|", global_error}},
      {"error-position-rms", {"sqrt(mean_k e(t_k)^2), e = |x - x*|", global_error}},
      {"error-velocity-end", {"e(t_end), e = |v - v*|", global_error}},
      {"error-velocity-max", {"max_k e(t_k), e = |v - v*|", global_error}},
      {"error-velocity-rms", {"sqrt(mean_k e(t_k)^2), e = |v - v*|", global_error}},
      {"error-attitude-end", {"e(t_end), e = 2 arccos |q . q*|", angles}},
      {"error-attitude-max", {"max_k e(t_k), e = 2 arccos |q . q*|", angles}},
      {"error-attitude-rms", {"sqrt(mean_k e(t_k)^2), e = 2 arccos |q . q*|", angles}},
      {"quaternion-norm-drift", {"max_k | |q(t_k)| - 1 |", here}},
      {"error-body-rate-end", {"e(t_end), e = |w - w*|", global_error}},
      {"error-body-rate-max", {"max_k e(t_k), e = |w - w*|", global_error}},
      {"error-body-rate-rms", {"sqrt(mean_k e(t_k)^2), e = |w - w*|", global_error}},
      {"error-state-end", {"|y - y*| / |y*| at t_end, y = (x, v) of all moving bodies", global_error}},
      {"size-position", {"max_k |x*(t_k)|", here}},
      {"size-velocity", {"max_k |v*(t_k)|", here}},
      {"size-body-rate", {"max_k |w*(t_k)|", here}},
      {"condition",
       {"(|dx(t_end)| / S) / eps of a perturbation by eps of each vector's own size, S the size of the trajectory",
        "Higham, Accuracy and Stability of Numerical Algorithms (2nd ed.), section 1.6"}},
      {"energy-scale", {"E_scale = max_k (T(t_k) + |V(t_k) - V(0)|)", here}},
      {"energy-max", {"max_k |E(t_k) - E(0)| / E_scale", energy_of_long_runs}},
      {"energy-drift",
       {"median over i < j of (r_j - r_i) / (t_j - t_i), r = (E - E(0)) / E_scale less its oscillation",
        "Theil, Proc. Kon. Ned. Akad. Wet. A 53 (1950) 386; Sen, J. Am. Stat. Assoc. 63 (1968) 1379"}},
      {"energy-oscillation", {"(max_k r - min_k r) / 2, r = (E - E(0)) / E_scale less its drift", here}},
      {"energy-change-max", {"max_k |E(t_k) - E(0)|", energy_of_long_runs}},
      {"energy-change-drift",
       {"median over i < j of (r_j - r_i) / (t_j - t_i), r = E - E(0) less its oscillation",
        "Theil, Proc. Kon. Ned. Akad. Wet. A 53 (1950) 386; Sen, J. Am. Stat. Assoc. 63 (1968) 1379"}},
      {"energy-change-oscillation", {"(max_k r - min_k r) / 2, r = E - E(0) less its drift", here}},
      {"energy-drift-round-off",
       {"mean over 96 runs of the slope of (E - E_wide) / E_scale in t",
        "Hairer, McLachlan, Razakarivony, BIT 48 (2008) 231; bar: Efron, Tibshirani, An Introduction to the Bootstrap (1993)"}},
      {"energy-change-drift-round-off",
       {"mean over 96 runs of the slope of E - E_wide in t",
        "Hairer, McLachlan, Razakarivony, BIT 48 (2008) 231; bar: Efron, Tibshirani, An Introduction to the Bootstrap (1993)"}},
      {"momentum-error", {"max_k |P(t_k) - P(0) - M g t_k|, P = sum m v, M = sum m", momenta}},
      {"momentum-error-relative", {"momentum-error / max_k sum m |v(t_k)|", momenta}},
      {"angular-momentum-error", {"max_k |L(t_k) - L(0)|, L = sum (x - o) x m v + R I w", momenta}},
      {"angular-momentum-error-relative", {"angular-momentum-error / max_k |L(t_k)|", momenta}},
      {"center-of-mass-error",
       {"max_k |X(t_k) - X(0) - V(0) t_k - g t_k^2 / 2|, X = sum m x / M, V = sum m v / M", momenta}},
      {"jacobi-constant-error",
       {"max_k |C(t_k) - C(0)| / E_scale, C = |v|^2 / 2 + U(x) with the potential U of the rotating frame",
        "Szebehely, Theory of Orbits (1967)"}},
      {"laplace-runge-lenz-error",
       {"max_k |A(t_k) - A(0)|, A = v x (r x v) / mu - r / |r|",
        "Goldstein, Classical Mechanics (2nd ed.), section 3-9"}},
      {"magnetic-moment-error",
       {"max_k |M(t_k) - M(0)| / M(0), M = m |v_perp|^2 / (2 |B|)",
        "Northrop, The Adiabatic Motion of Charged Particles (1963)"}},
      {"growth-exponent-position",
       {"b of e(t) = a t^b", "Hairer, Lubich, Wanner, Geometric Numerical Integration (2nd ed.), section X.3"}},
      {"growth-exponent-attitude",
       {"b of e(t) = a t^b", "Hairer, Lubich, Wanner, Geometric Numerical Integration (2nd ed.), section X.3"}},
      {"growth-exponent-energy", {"b of |E(t) - E(0)| = a t^b", energy_of_long_runs}},
      {"growth-exponent-round-off-energy",
       {"b of rms over 96 runs of E - E_wide = a t^b",
        "Brouwer, Astron. J. 46 (1937) 149; Hairer, McLachlan, Razakarivony, BIT 48 (2008) 231"}},
      {"growth-exponent-round-off-position",
       {"b of rms over 96 runs of x - x_wide = a t^b",
        "Brouwer, Astron. J. 46 (1937) 149; Hairer, McLachlan, Razakarivony, BIT 48 (2008) 231"}},
      {"growth-exponent-round-off-attitude",
       {"b of rms over 96 runs of q - q_wide = a t^b",
        "Brouwer, Astron. J. 46 (1937) 149; Hairer, McLachlan, Razakarivony, BIT 48 (2008) 231"}},
      {"round-off-rms-position",
       {"sqrt(mean over 96 runs of |x - x_wide|^2) at t_end", "Brouwer, Astron. J. 46 (1937) 149"}},
      {"round-off-best-error",
       {"min over the ladder of |x - x*| at t_end",
        "Henrici, Discrete Variable Methods in Ordinary Differential Equations (1962)"}},
      {"round-off-best-step",
       {"the h of round-off-best-error",
        "Henrici, Discrete Variable Methods in Ordinary Differential Equations (1962)"}},
      {"reversal-error-position",
       {"|x' - x(0)|, the primed state that of rho Phi^n rho Phi^n y(0), rho: velocities reversed", reversal}},
      {"reversal-error-velocity",
       {"|v' - v(0)|, the primed state that of rho Phi^n rho Phi^n y(0), rho: velocities reversed", reversal}},
      {"reversal-error-attitude",
       {"2 arccos |q' . q(0)|, the primed state that of rho Phi^n rho Phi^n y(0), rho: velocities reversed", reversal}},
      {"reversal-error-body-rate",
       {"|w' - w(0)|, the primed state that of rho Phi^n rho Phi^n y(0), rho: velocities reversed", reversal}},
      {"reversal-over-round-off",
       {"max over the kinds of reversal-error / (u sqrt(2 n) size condition), n the steps of a pass, u the unit round-off",
        reversal}},
      {"symplecticity-defect",
       {"|M^T J M - J|_F, M = d y(t_end) / d y(0) in canonical variables",
        "Hairer, Lubich, Wanner, Geometric Numerical Integration (2nd ed.), section VI.2"}},
      {"poisson-defect",
       {"|M hat(L(0)) M^T - hat(L)|_F / |L|, M = dL / dL(0), hat(L) u = L x u",
        "Hairer, Lubich, Wanner, Geometric Numerical Integration (2nd ed.), section VII.4"}},
      {"horizon", {"t with |d(t)| = 1e-3 S, where |d(0)| = 1e-10 S", "Lorenz, J. Atmos. Sci. 20 (1963) 130"}},
      {"lyapunov-exponent",
       {"sum_k ln(|d_k| / |d_0|) / t_end, the distance set back to d_0 after each sample",
        "Benettin, Galgani, Giorgilli, Strelcyn, Meccanica 15 (1980) 9"}},
      {"state-differences", {"number of i with bits(y_i) != bits(y'_i)", here}},
      {"state-hash", {"floor(XXH64(y(t_end)) / 2^16)", "xxHash, XXH64"}},
      {"tolerance-ratio", {"(error-position-max / size-position) / rtol", step_size}},
      {"tolerance-exponent", {"b of error-position-max = a rtol^b, by least squares of logarithms", step_size}},
      {"gci-position",
       {"1.25 |x_2 - x_1| / (r_21^p - 1), p = richardson-order-position",
        "Roache, J. Fluids Eng. 116 (1994) 405; Celik et al., J. Fluids Eng. 130 (2008) 078001"}},
      {"richardson-order-position",
       {"p = (ln(|x_3 - x_2| / |x_2 - x_1|) + ln((r_21^p - s) / (r_32^p - s))) / ln r_21, s the sign of (x_3 - x_2) . (x_2 - x_1), r_21 = h_2 / h_1",
        "Roache, J. Fluids Eng. 116 (1994) 405; Celik et al., J. Fluids Eng. 130 (2008) 078001, eq. 5"}},
      {"gci-effectivity",
       {"|x_1 - x*| / gci-position",
        "Roache, J. Fluids Eng. 116 (1994) 405; Celik et al., J. Fluids Eng. 130 (2008) 078001"}}};
  return all;
}

const Origins& origins_of_contact() {
  static const Origins all{
      {"order-position", {"p of error-position-end = C h^p, by least squares of logarithms", convergence}},
      {"order-velocity", {"p of error-velocity-end = C h^p, by least squares of logarithms", convergence}},
      {"order-attitude", {"p of error-attitude-end = C h^p, by least squares of logarithms", convergence}},
      {"order-body-rate", {"p of error-body-rate-end = C h^p, by least squares of logarithms", convergence}},
      {"order-impact-time", {"p of impact-time-error = C h^p, by least squares of logarithms", convergence}},
      {"landing-range-error", {"s - s*, s = |x_xy(t_l) - x_xy(0)|, z(t_l) = 0", here}},
      {"impact-time-error", {"max_k |t_k - t_k*|", here}},
      {"impact-place-error", {"max_k |c_k - c_k*|", here}},
      {"impact-normal-impulse-error", {"max_k |J_n,k - J_n,k*|", impacts}},
      {"impact-tangential-impulse-error", {"max_k | |J_t,k| - |J_t,k*| |", impacts}},
      {"transition-time-error", {"max_k |t_k - t_k*|", here}},
      {"impact-count-error", {"N - N*", here}},
      {"apex-error", {"max_k |z_k - z_k*| / z_k*, z_k the apex after impact k, k <= 5", here}},
      {"restitution-error", {"max_k |-u_n,k(after) / u_n,k(before) - e|", "Newton, Principia (1687); " + impacts}},
      {"energy-gain", {"max_(j<k) (E(t_k) - E(t_j)) / E_scale, not below 0", nonsmooth}},
      {"energy-rise", {"max_(j<k) (E(t_k) - E(t_j)), not below 0", nonsmooth}},
      {"contact-energy-gain",
       {"max_k J_n,k (u_n,k(before) + u_n,k(after)) / 2",
        "Kelvin, Tait, Treatise on Natural Philosophy (1867); " + impacts}},
      {"cone-violation", {"max(0, |f_t| - mu f_n) / max f_n", nonsmooth}},
      {"signorini-gap", {"max |g| where f_n > 0", nonsmooth + " (Signorini's condition: g >= 0, f_n >= 0, g f_n = 0)"}},
      {"signorini-pull", {"max(0, -f_n)", nonsmooth + " (Signorini's condition: g >= 0, f_n >= 0, g f_n = 0)"}},
      {"dissipation-defect", {"max (mu f_n |u_t| + f_t . u_t) / (max mu f_n max |u|)", "Moreau (1988); " + nonsmooth}},
      {"contact-misses", {"number of poses with depth* > round-off and no contact", here}},
      {"contact-false-hits", {"number of poses with distance* > round-off and a contact", here}},
      {"touch-misses", {"number of poses with t* <= 1 s and no touch", here}},
      {"touch-false-hits", {"number of poses without t* <= 1 s and with a touch", here}},
      {"contact-depth-error-median",
       {"median of |d - d*| / R",
        "d*: least translation that separates, Cameron, Culley, IEEE Robotics and Automation (1986) 591; quantiles: Hyndman, Fan, Am. Stat. 50 (1996) 361, definition 7"}},
      {"contact-depth-error-p99",
       {"99th percentile of |d - d*| / R",
        "d*: least translation that separates, Cameron, Culley, IEEE Robotics and Automation (1986) 591; quantiles: Hyndman, Fan, Am. Stat. 50 (1996) 361, definition 7"}},
      {"contact-depth-error-max",
       {"maximum of |d - d*| / R",
        "d*: least translation that separates, Cameron, Culley, IEEE Robotics and Automation (1986) 591; quantiles: Hyndman, Fan, Am. Stat. 50 (1996) 361, definition 7"}},
      {"contact-normal-error-median",
       {"median of arccos(n . n*)", "here; quantiles: Hyndman, Fan, Am. Stat. 50 (1996) 361, definition 7"}},
      {"contact-normal-error-p99",
       {"99th percentile of arccos(n . n*)", "here; quantiles: Hyndman, Fan, Am. Stat. 50 (1996) 361, definition 7"}},
      {"contact-normal-error-max",
       {"maximum of arccos(n . n*)", "here; quantiles: Hyndman, Fan, Am. Stat. 50 (1996) 361, definition 7"}},
      {"contact-distance-error-median",
       {"median of |s - s*| / R", "here; quantiles: Hyndman, Fan, Am. Stat. 50 (1996) 361, definition 7"}},
      {"contact-distance-error-p99",
       {"99th percentile of |s - s*| / R", "here; quantiles: Hyndman, Fan, Am. Stat. 50 (1996) 361, definition 7"}},
      {"contact-distance-error-max",
       {"maximum of |s - s*| / R", "here; quantiles: Hyndman, Fan, Am. Stat. 50 (1996) 361, definition 7"}},
      {"touch-time-error-median",
       {"median of |t - t*|", "here; quantiles: Hyndman, Fan, Am. Stat. 50 (1996) 361, definition 7"}},
      {"touch-time-error-p99",
       {"99th percentile of |t - t*|", "here; quantiles: Hyndman, Fan, Am. Stat. 50 (1996) 361, definition 7"}},
      {"touch-time-error-max",
       {"maximum of |t - t*|", "here; quantiles: Hyndman, Fan, Am. Stat. 50 (1996) 361, definition 7"}}};
  return all;
}

const Origins& other_origins() {
  static const Origins all{
      {"penetration-max", {"max_k max(0, -g(t_k)) over all pairs", here}},
      {"penetration-rms", {"sqrt(mean_k d(t_k)^2), d = max(0, -g) over all pairs", here}},
      {"penetration-relative", {"max_k d(t_k) / min(R_a, R_b)", here}},
      {"step-time",
       {"median_i T_i / n, T_i the time of repeat i of n steps",
        "bar: order statistics, Conover, Practical Nonparametric Statistics (3rd ed., 1999)"}},
      {"step-time-p95", {"95th percentile of T_i / n", "Hyndman, Fan, Am. Stat. 50 (1996) 361"}},
      {"run-time", {"n step-time", here}},
      {"step-time-wasm", {"median_i T_i / n", here}},
      {"run-time-wasm", {"n step-time-wasm", here}},
      {"call-time-wasm", {"median of 11 means over 200 steps of an empty world, times the substeps", here}},
      {"solver-capped", {"number of solves with residual > tolerance at the end, without stagnation", iterations}},
      {"solver-residual-max", {"max over solves of the scaled residual |r| / scale", iterations}},
      {"solver-iterations-max", {"max over solves of the iterations", iterations}},
      {"solver-converged", {"number of solves with residual <= tolerance", iterations}},
      {"solver-stagnated", {"number of solves with residual > tolerance that round-off stopped", iterations}},
      {"rate-evaluations",
       {"number of evaluations of f(t, y)", "Hairer, Norsett, Wanner, Solving ODEs I (2nd ed.), section II.10"}},
      {"steps-taken", {"number of accepted steps", step_size}},
      {"joint-gap", {"max_k |a_child(t_k) - a_parent(t_k)| of the two anchors in the world", joints}},
      {"joint-tilt",
       {"max_k arccos(n_parent . n_child) of an axis; of a relative rotation 2 arccos |q . q(joint)|",
        "Featherstone, Rigid Body Dynamics Algorithms (2008); " + angles}},
      {"error-joint-coordinate", {"max_k |c - c*|, of a ball 2 arccos |q . q*|", joints}},
      {"error-joint-coordinate-end", {"|c - c*| at t_end, of a ball 2 arccos |q . q*|", joints}},
      {"error-joint-rate", {"max_k |c' - c'*|", joints}},
      {"error-reaction-force", {"max_k |f - f*|", joints}},
      {"error-reaction-torque", {"max_k |tau - tau*|", joints}},
      {"size-joint-coordinate", {"max_k |c*(t_k)|", here}},
      {"order-joint-coordinate",
       {"p of error-joint-coordinate-end = C h^p, by least squares of logarithms", convergence}},
      {"swinging-atwood-error",
       {"max_k | |I(t_k)| - |I(0)| | / max_k (sum of the sizes of the terms of I), I = r^2 th' (r' cos(th/2) - r th'/2 sin(th/2)) + g r^2 sin(th/2) cos^2(th/2)",
        "Tufillaro, Am. J. Phys. 54 (1986) 142"}},
      {"step-time-per-link", {"step-time / number of held bodies", here}},
      {"velocity-l1", {"sum m |f - f*| / sum m |f*|", particles + " (sums over particles as integrals)"}},
      {"velocity-l2", {"sqrt(sum m |f - f*|^2 / sum m |f*|^2)", particles + " (sums over particles as integrals)"}},
      {"velocity-linf", {"max |f - f*| / max |f*|", here}},
      {"pressure-l1", {"sum m |f - f*| / sum m |f*|", particles + " (sums over particles as integrals)"}},
      {"pressure-l2", {"sqrt(sum m |f - f*|^2 / sum m |f*|^2)", particles + " (sums over particles as integrals)"}},
      {"pressure-linf", {"max |f - f*| / max |f*|", here}},
      {"density-l1", {"sum m |f - f*| / sum m |f*|", particles + " (sums over particles as integrals)"}},
      {"density-l2", {"sqrt(sum m |f - f*|^2 / sum m |f*|^2)", particles + " (sums over particles as integrals)"}},
      {"density-linf", {"max |f - f*| / max |f*|", here}},
      {"temperature-l1", {"sum m |f - f*| / sum m |f*|", particles + " (sums over particles as integrals)"}},
      {"temperature-l2", {"sqrt(sum m |f - f*|^2 / sum m |f*|^2)", particles + " (sums over particles as integrals)"}},
      {"temperature-linf", {"max |f - f*| / max |f*|", here}},
      {"model-error", {"sum m |u_c(x) - u(x)| / sum m |u(x)|", here}},
      {"space-error", {"sum m |V - u_c(X)| / sum m |u|", here}},
      {"time-error", {"sum m |(v - u_c(x)) - (V - u_c(X))| / sum m |u|", here}},
      {"closing-residual", {"max |total - model - space - time| / max |u|", here}},
      {"order-space", {"p of space-error = C dx^p", convergence}},
      {"order-time", {"p of time-error = C h^p", convergence}},
      {"order-model",
       {"p of model-error = C (U / c)^p", "Monaghan, J. Comput. Phys. 110 (1994) 399 (errors of order Mach^2)"}},
      {"kinetic-energy-error", {"(K - K*) / max K*, K = sum m |v|^2 / 2", here}},
      {"energy-budget",
       {"max_k |E(t_k) - E(0)| / (max K + max |dV| + max |dU|), E = sum m (|v|^2 / 2 + e(rho) + C T) + V, de = p / rho^2 drho",
        particles}},
      {"neighbours", {"mean_i number of j != i with |x_ij| < R", particles}},
      {"ns-per-particle-evaluation", {"run-time / (rate-evaluations N)", here}},
      {"volume-error", {"sum m / rho(t_end) / sum m / rho(0) - 1", here}},
      {"fluid-momentum-error", {"max_k |P(t_k) - P(0)| / sum |m v|", particles}},
      {"fluid-angular-momentum-error", {"max_k |L(t_k) - L(0)| / sum |m x x v|", particles}},
      {"particle-order", {"std(d_i) / mean(d_i), d_i the distance to the nearest particle", here}},
      {"spacing-min", {"min_(i<j) |x_ij| / dx", here}},
      {"speed-max", {"max_i |v_i|", here}},
      {"front-error", {"(s - s*) / s*", dam_break}},
      {"front-speed-error", {"(ds/dt) / (ds*/dt) - 1", dam_break}},
      {"front-delay", {"argmin over tau of max_k |s(t_k - tau) / s*_k - 1|", dam_break}},
      {"front-delayed-error", {"min over tau of max_k |s(t_k - tau) / s*_k - 1|", dam_break}},
      {"probe-error", {"(p - p*) / p*", here}}};
  return all;
}

}  // namespace

MetricOrigin origin_of(const std::string& metric) {
  if (metric == "status" || metric == "truth") return {};
  for (const Origins* origins : {&origins_of_motion(), &origins_of_contact(), &other_origins()})
    if (const auto found = origins->find(metric); found != origins->end()) return found->second;
  throw std::logic_error("metric `" + metric + "` has no formula (validation/metrics/metric_origin.cpp)");
}

}  // namespace atwood
